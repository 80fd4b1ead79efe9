// What all reports share: elements, numbers, tables, choices, tabs. Text from user files only ever becomes text
// nodes and attributes.
const data = JSON.parse(document.getElementById("data").textContent);
const main = document.querySelector("main");
const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const kSvg = new Set(["svg", "rect", "circle", "line", "path", "text", "g", "title"]);

const element = (name, attributes = {}, ...children) => {
  const node =
      kSvg.has(name) ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on"))
      node.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== null)
      node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
};
const paragraph = (text, kind) => element("p", {class: kind}, text);
const section = (place, title, level = "h2") => {
  const part = element("section", {}, element(level, {}, title));
  place.append(part);
  return part;
};

const raised = x => String(x).replace(/[-\d]/g, c => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]);
const number = (x, digits = 4) => {
  if (typeof x !== "number") return "–";
  if (Number.isSafeInteger(x) && Math.abs(x) < 1e5) return String(x).replace("-", "−");
  const power = Math.floor(Math.log10(Math.abs(x)));
  const text = power < -3 || power > 4 ? `${Number((x / 10 ** power).toPrecision(digits))}·10${raised(power)}` :
                                         String(Number(x.toPrecision(digits)));
  return text.replace("-", "−");
};
const labels_of = list => {  // of ticks: as few digits as tell them apart
  for (let digits = 3;; ++digits) {
    const texts = list.map(x => x === null ? "" : number(x, digits));
    if (new Set(texts).size === new Set(list).size || digits > 8) return texts;
  }
};
const percent = x => (100 * x).toFixed(x >= 0.0995 ? 0 : 1) + "\u00a0%";
const words = name =>
    name.replaceAll("_", " ").replace(/@(\d+)/g, " in joint $1").replace(/#(\d+)/g, " of recording $1");
const numbered = (name, j, joints) => joints > 1 ? name + (j + 1) : name;
const with_unit = (text, unit) => unit ? `${text} (${unit})` : text;
const range = lists => {  // of numbers, leaving out what is missing
  let least = Infinity, most = -Infinity;
  for (const list of lists) {
    for (const x of list) {
      if (typeof x === "number") {
        least = Math.min(least, x);
        most = Math.max(most, x);
      }
    }
  }
  return most >= least ? [least, most] : [0, 0];
};

let count = 0;  // of what needs an id

// A button that copies `text()` and says so.
const copy_button = (label, text) => {
  const said = element("span", {role: "status"});
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text());
    } catch {  // older browsers, and where pages from disk may not
      const area = element("textarea", {});
      area.value = text();
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    said.textContent = " copied";
    setTimeout(() => {
      said.textContent = "";
    }, 2000);
  };
  return element("span", {class: "copy"}, element("button", {type: "button", onclick: copy}, label), said);
};
const tabbed = rows => rows.map(row => row.join("\t")).join("\n");

// A table that can be sorted by its headings and copied. A cell is a number, a text, null, or {text, value, kind,
// node}: `value` sorts and is copied, `kind` is its class. The first column names its row.
const table = (caption, columns, rows) => {
  const plain = cell => cell !== null && typeof cell === "object" ? cell.value : cell;
  const draw = (cell, i) => {
    const given = cell !== null && typeof cell === "object" ? cell : {value: cell};
    const text = given.node || given.text || (typeof given.value === "string" ? given.value : number(given.value));
    const kind = [given.kind, typeof given.value === "string" ? "" : "number"].filter(Boolean).join(" ") || undefined;
    return i === 0 ? element("th", {scope: "row", class: kind}, text) : element("td", {class: kind}, text);
  };
  const body = element("tbody");
  const fill = list => body.replaceChildren(...list.map(row => element("tr", {}, ...row.map(draw))));
  const missing = x => x === null || x === undefined || x === "";
  const compare = (a, b) => missing(a) || missing(b) ? missing(a) - missing(b) :
      typeof a === "number" && typeof b === "number" ? a - b :
                                                       String(a).localeCompare(String(b), undefined, {numeric: true});
  const heads = columns.map((name, i) => {
    const head = element(
        "th", {scope: "col"},
        element(
            "button", {
              type: "button",
              onclick: () => {
                const down = head.getAttribute("aria-sort") === "ascending";
                heads.forEach(other => other.removeAttribute("aria-sort"));
                head.setAttribute("aria-sort", down ? "descending" : "ascending");
                fill([...rows].sort((a, b) => {  // what is missing stays last
                  const [x, y] = [plain(a[i]), plain(b[i])];
                  return (down && !missing(x) && !missing(y) ? -1 : 1) * compare(x, y);
                }));
              }
            },
            name));
    if (rows.some(row => typeof plain(row[i]) === "number")) head.classList.add("number");
    return head;
  });
  fill(rows);
  const id = "caption" + ++count;
  return element(
      "div", {class: "table"}, element("p", {class: "soft", id}, caption),
      element(
          "div",
          {class: rows.length > 24 ? "scroll long" : "scroll", tabindex: "0", role: "region", "aria-labelledby": id},
          element("table", {"aria-labelledby": id}, element("thead", {}, element("tr", {}, ...heads)), body)),
      copy_button("copy table", () => tabbed([columns, ...rows.map(row => row.map(cell => plain(cell) ?? ""))])));
};

// One of several things at a time, by a list.
const choice = (place, label, names, draw, chosen = 0) => {
  const body = element("div");
  const show = i => {
    body.replaceChildren();
    draw(i, body);
  };
  const select = element(
      "select", {
        onchange: () => {
          show(Number(select.value));
          redraw();
        }
      },
      ...names.map((name, i) => element("option", {value: String(i)}, name)));
  select.value = String(chosen);
  if (names.length > 1) place.append(element("label", {class: "choice"}, label + " ", select));
  place.append(body);
  show(chosen);
};

// Panels of which one is seen; all of them in print. A panel is drawn when it is first seen.
const printing = matchMedia("print");
const tabs = (place, label, names, draw) => {
  const id = "tabs" + ++count;
  const panels = names.map((_, i) => element("div", {
                             role: "tabpanel",
                             id: `${id}-panel${i}`,
                             "aria-labelledby": `${id}-tab${i}`,
                             "data-title": names[i],
                             hidden: ""
                           }));
  const drawn = names.map(() => false);
  const ensure = i => {
    if (!drawn[i]) {
      drawn[i] = true;
      draw(i, panels[i]);
    }
  };
  const show = (i, focus) => {
    buttons.forEach((button, k) => {
      button.setAttribute("aria-selected", String(k === i));
      button.tabIndex = k === i ? 0 : -1;
      panels[k].hidden = k !== i;
    });
    ensure(i);
    redraw();
    if (focus) buttons[i].focus();
  };
  const keys = {
    ArrowRight: i => (i + 1) % names.length,
    ArrowLeft: i => (i + names.length - 1) % names.length,
    Home: () => 0,
    End: () => names.length - 1
  };
  const buttons = names.map(
      (name, i) => element(
          "button", {
            type: "button",
            role: "tab",
            id: `${id}-tab${i}`,
            "aria-controls": `${id}-panel${i}`,
            onclick: () => show(i),
            onkeydown: event => {
              if (keys[event.key]) {
                event.preventDefault();
                show(keys[event.key](i), true);
              }
            }
          },
          name));
  place.append(element("div", {role: "tablist", "aria-label": label}, ...buttons), ...panels);
  printing.addEventListener("change", () => {
    if (printing.matches) names.forEach((_, i) => ensure(i));
  });
  show(0);
};

// A nested object as rows [path, value], with all digits; lists stand in one cell.
const flat = (object, path = "") => Object.entries(object ?? {}).flatMap(([key, value]) => {
  const name = path ? `${path}.${key}` : key;
  if (value === null) return [[name, null]];
  if (typeof value !== "object") return [[name, String(value)]];
  if (Array.isArray(value) && value.every(x => typeof x !== "object")) return [[name, `[${value.join(", ")}]`]];
  return flat(value, name);
});
// Settings and provenance of results: of an experiment, a diagnosis, a trial.
const origin = (place, title, {spec, provenance}, level = "h3") => {
  if (!spec) return;
  const seed = "seed" in provenance ? `, seed ${provenance.seed}` : "";
  section(place, "Settings and provenance", level)
      .append(
          element(
              "details", {}, element("summary", {}, "Settings: the whole spec with every default"),
              table(`Settings of ${title}, SI units`, ["setting", "value"], flat(spec))),
          element(
              "details", {},
              element(
                  "summary", {},
                  `Provenance: ${provenance.program} ${provenance.version}, revision ${provenance.revision}${seed}`),
              table(`Provenance of ${title}`, ["what", "value"], flat(provenance))));
};
