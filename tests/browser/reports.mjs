// Opens reports in headless Chromium, from disk: nothing may be asked of a network, no error may be said, and what can
// be pressed must do what it says, in dark and light, on a phone, by keyboard and in print.
//
//     node reports.mjs [--shots FOLDER] KIND=PAGE ...     KIND: experiment, diagnosis, trial, or any other name
//
// Exit code: 0, 1 after a failure, 77 where there is no browser.
import {existsSync, mkdirSync} from "node:fs";
import {join, resolve} from "node:path";
import {pathToFileURL} from "node:url";

const kSkipped = 77;
const executablePath =
    [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser"].find(path => path && existsSync(path));
const skip = reason => {
  console.log(`skipped: ${reason}`);
  process.exit(kSkipped);
};
if (!executablePath) skip("no chromium (scripts/setup installs it)");
const {chromium} = await import("playwright-core");  // scripts/setup installs it

const failures = [];
const check = (holds, what) => {
  if (!holds) {
    failures.push(what);
    console.log(`FAILED: ${what}`);
  }
};

// A page opened from disk; what it says to the console or asks for is a failure.
const open = async (browser, file, options = {}) => {
  const context = await browser.newContext({viewport: {width: 1100, height: 900}, colorScheme: "light", ...options});
  const page = await context.newPage(), address = pathToFileURL(resolve(file)).href;
  page.on(
      "console",
      message => check(!["error", "warning"].includes(message.type()), `${file}: console: ${message.text()}`));
  page.on("pageerror", error => check(false, `${file}: ${error.stack}`));
  page.on("dialog", dialog => {
    check(false, `${file}: says ${dialog.message()}`);
    dialog.dismiss();
  });
  page.on(
      "request",
      request => check(
          request.url() === address || /^(data|blob):/.test(request.url()), `${file}: asks for ${request.url()}`));
  await page.goto(address);
  await page.waitForFunction(() => document.querySelector("main").childElementCount > 0);
  return page;
};

const visible = async (page, selector) => {
  const found = [];
  for (const one of await page.locator(selector).all())
    if (await one.isVisible()) found.push(one);
  return found;
};

// What holds for every page at every size.
const sound = async (page, what) => {
  const width = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  check(width[0] <= width[1], `${what}: scrolls sideways, ${width[0]} > ${width[1]}`);
  const mute = await page.evaluate(
      () => [...document.querySelectorAll("[role=img], svg")]
                .filter(node => !(node.getAttribute("aria-label") || "").trim())
                .length);
  check(mute === 0, `${what}: ${mute} figures without a text alternative`);
  const broken = await page.evaluate(
      () => [...document.querySelectorAll("[role=img], figcaption, td, th, p, dd")]
                .filter(
                    node => /NaN|undefined|Infinity|\[object/.test(
                        (node.getAttribute("aria-label") || "") + node.textContent))
                .map(node => node.textContent.slice(0, 80)));
  check(broken.length === 0, `${what}: no numbers: ${broken.join(" | ")}`);
  const empty = await page.evaluate(
      () => [...document.querySelectorAll(".plot")]
                .filter(node => node.clientWidth && !node.querySelector("canvas"))
                .length);
  check(empty === 0, `${what}: ${empty} plots were not drawn`);
  const poor = await page.evaluate(() => {  // contrast of text on its background, WCAG AA
    const light = c => {
      const [r, g, b] = c.match(/[\d.]+/g)
                            .map(Number)
                            .map(x => x / 255)
                            .map(x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const paper = light(getComputedStyle(document.body).backgroundColor);
    return [...document.querySelectorAll("h1, h2, h3, p, figcaption, td, dt, button:not([role=tab])")]
        .filter(node => {
          const ink = light(getComputedStyle(node).color);
          return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05) < 4.5;
        })
        .map(node => node.textContent.slice(0, 40));
  });
  check(poor.length === 0, `${what}: too little contrast: ${poor.slice(0, 3).join(" | ")}`);
};

// A click on a heading sorts up, a second one down; the keyboard does the same.
const sorts = async (page, what) => {
  const [head] = await visible(page, "thead th.number button");
  check(head, `${what}: no table with numbers`);
  if (!head) return;
  const column = () => head.evaluate(button => {
    const th = button.closest("th"), i = [...th.parentNode.children].indexOf(th);
    return {
      sort: th.getAttribute("aria-sort"),
      values: [...th.closest("table").tBodies[0].rows]
                  .map(row => parseFloat(row.cells[i].textContent.replace("−", "-")))
                  .filter(x => !isNaN(x))
    };
  });
  await head.click();
  const up = await column();
  check(
      up.sort === "ascending" && up.values.every((x, i) => i === 0 || x >= up.values[i - 1]),
      `${what}: is not sorted: ${up.values}`);
  await head.focus();
  await page.keyboard.press("Enter");
  const down = await column();
  check(
      down.sort === "descending" && down.values.every((x, i) => i === 0 || x <= down.values[i - 1]),
      `${what}: is not sorted downwards: ${down.values}`);
};

const copies = async (page, what) => {
  const [button] = await visible(page, ".table .copy button");
  await button.click();
  await page
      .waitForFunction(
          () => [...document.querySelectorAll("[role=status]")].some(s => s.textContent.includes("copied")), null,
          {timeout: 3000})
      .catch(() => check(false, `${what}: a table cannot be copied`));
};

// Every other entry of every list, and back to the first.
const chooses = async (page, what) => {
  for (const list of await visible(page, "label.choice select")) {
    const entries = await list.locator("option").count();
    for (const i of [entries - 1, 0]) await list.selectOption(String(i));
    check(
        await list.evaluate(node => node.closest("label").nextSibling.querySelectorAll("figure").length) > 0,
        `${what}: a choice shows no figure`);
  }
};

const reads_plots = async (page, what) => {
  const [plot] = await visible(page, ".plot");
  if (!plot) return;
  await plot.focus();
  for (let i = 0; i < 20; ++i) await page.keyboard.press("Shift+ArrowRight");
  const value = await plot.locator(".u-legend .u-value").first().textContent();
  check(/\d/.test(value), `${what}: the cursor of a plot does not follow the keyboard: '${value}'`);
  await page.keyboard.press("+");
  await page.keyboard.press("0");
};

const tabs = async (page, what) => {
  const list = page.locator("[role=tab]");
  const entries = await list.count();
  if (!entries) return;
  await list.first().focus();
  for (let i = 1; i < entries; ++i) {
    await page.keyboard.press("ArrowRight");
    check(
        await list.nth(i).getAttribute("aria-selected") === "true",
        `${what}: the keyboard does not reach tab ${i + 1}`);
    check((await visible(page, "[role=tabpanel]")).length === 1, `${what}: more or less than one panel is seen`);
    await sound(page, `${what}, tab ${i + 1}`);
    await chooses(page, `${what}, tab ${i + 1}`);
  }
  await list.first().click();
};

const moves = async (page, what, wait) => {
  const [slider] = await visible(page, ".player input[type=range]");
  check(slider, `${what}: no motion`);
  if (!slider) return;
  const tip = () =>
      page.locator(".machine .tip").first().evaluate(node => [node.getAttribute("cx"), node.getAttribute("cy")].join());
  const end = await tip();
  await slider.focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("ArrowRight");
  check(await tip() !== end, `${what}: the slider moves nothing`);
  const [play] = await visible(page, ".player button"), before = await tip();
  await play.click();
  await page.waitForTimeout(wait);
  await play.click();
  check(await tip() !== before, `${what}: play moves nothing`);
  const stopped = await tip();
  await page.waitForTimeout(150);
  check(await tip() === stopped, `${what}: pause does not stop`);
  await slider.focus();
  await page.keyboard.press("End");
};

// The window, or with `parts` (headings) the sections under them.
const kTallest = 1120;  // pixels of a picture
const shoot = async (page, shots, name, parts = []) => {
  if (!shots) return;
  mkdirSync(shots, {recursive: true});
  const path = join(shots, `${name}.png`);
  await page.evaluate(() => {
    document.activeElement.blur();
    scrollTo(0, 0);
  });
  const boxes = await Promise.all(
      parts.map(text => page.locator("section", {has: page.locator("h2, h3", {hasText: text})}).last().boundingBox()));
  const top = Math.min(...boxes.map(box => box.y));
  const bottom = Math.min(top + kTallest, Math.max(...boxes.map(box => box.y + box.height)));
  const style = ".u-cursor-x, .u-cursor-y { visibility: hidden }";  // where a pointer was last
  await page.screenshot(
      parts.length ? {
        path,
        style,
        fullPage: true,
        clip: {x: 0, y: top - 8, width: page.viewportSize().width, height: bottom - top + 16}
      } :
                     {path, style});
};

const look = async (browser, kind, file, shots) => {
  for (const colorScheme of ["light", "dark"]) {
    for (const [device, options] of Object.entries({
           desk: {},
           phone: {viewport: {width: 390, height: 844}, deviceScaleFactor: 2, isMobile: true, hasTouch: true}
         })) {
      const what = `${kind}, ${device}, ${colorScheme}`;
      const page = await open(browser, file, {...options, colorScheme});
      await sound(page, what);
      await shoot(page, shots, `${kind}-${device}-${colorScheme}`);
      if (kind === "experiment" && device === "desk") {
        await page.locator(".player input").first().fill("2.4");
        await shoot(page, shots, `${kind}-evolution-${colorScheme}`, ["Evolution", "Motion"]);
        await shoot(page, shots, `${kind}-maps-${colorScheme}`, ["What was learned"]);
      }
      if (kind === "diagnosis" && device === "desk") {
        await shoot(page, shots, `diagnosis-fit-${colorScheme}`, ["Does it predict"]);
        await shoot(page, shots, `diagnosis-law-${colorScheme}`, ["What the missing torque"]);
      }
      if (kind === "trial" && device === "desk")
        await shoot(page, shots, `trial-matrix-${colorScheme}`, ["Which effect was said"]);
      await chooses(page, what);
      await tabs(page, what);
      await sorts(page, what);
      if (device === "desk") {
        await reads_plots(page, what);
        await copies(page, what);
        if (kind === "experiment") await moves(page, what, 400);
      }
      await page.context().close();
    }
  }
  const still = await open(browser, file, {reducedMotion: "reduce"});
  await sound(still, `${kind}, reduced motion`);
  if (kind === "experiment") await moves(still, `${kind}, reduced motion`, 1200);  // stills, half a second apart
  await still.emulateMedia({media: "print"});
  await sound(still, `${kind}, print`);
  check(
      (await visible(still, "[role=tabpanel]")).length === await still.locator("[role=tabpanel]").count(),
      `${kind}, print: panels are hidden`);
  check(
      (await visible(still, "button:not(thead button), select, input")).length === 0,
      `${kind}, print: what can be pressed is seen`);
  await still.context().close();
};

const given = process.argv.slice(2);
const shots = given[0] === "--shots" ? given.splice(0, 2)[1] : "";
const browser = await chromium.launch({executablePath, args: process.getuid() === 0 ? ["--no-sandbox"] : []});
for (const one of given) {
  const [kind, ...path] = one.split("=");
  await look(browser, kind, path.join("="), shots);
  console.log(`looked at: ${one}`);
}
await browser.close();
if (failures.length) console.log(`${failures.length} failures`);
process.exit(failures.length ? 1 : 0);
