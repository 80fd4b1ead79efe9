// The report of a trial: what was said of machines whose physics was concealed.
const calibration = place => {
  const bins = data.calibration,
        told = bins.map(b => `stated ${number(b.stated, 2)}, right ${number(b.right, 2)} of ${b.cases}`).join("; ");
  const caption =
      "Share of right answers over the stated probability. Circles on the line are calibrated; larger circles are more cases.";
  const frame = axes(
      `${caption} ${told}.`, [0, 1.02], [0, 1.02], ["stated probability", "share that is right"],
      {width: 460, height: 420});
  frame.svg.append(
      element("line", {x1: frame.px(0), y1: frame.py(0), x2: frame.px(1), y2: frame.py(1), class: "axis"}));
  for (const bin of bins) {
    frame.svg.append(element(
        "circle", {
          cx: frame.px(bin.stated),
          cy: frame.py(bin.right),
          r: 3 + Math.min(9, Math.sqrt(bin.cases)),
          fill: "var(--blue)",
          "fill-opacity": 0.8
        },
        element("title", {}, `${bin.cases} cases, stated ${number(bin.stated, 3)}, right ${number(bin.right, 3)}`)));
  }
  const pair = element("div", {class: "pair"});
  figure(pair, frame.svg, caption);
  pair.append(table("Calibration", ["stated", "right", "cases"], bins.map(b => [b.stated, b.right, b.cases])));
  place.append(pair);
};

// How often each answer (column) was given where one effect, an invention or nothing was hidden (row).
const matrix = () => {
  const place = element("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "What was said of what"});
  const last = ["nothing", "several", "declined", "too little data", "check the spec"];
  const rank = name => last.indexOf(name);  // effects before them
  const rows = [...data.matrix].sort((a, b) => group(a.hidden) - group(b.hidden) || a.hidden.localeCompare(b.hidden));
  const answers = new Set(rows.flatMap(row => Object.keys(row.said)));
  for (const row of rows) {
    if (group(row.hidden) === 0) answers.add(row.hidden);
  }
  const columns = [...answers].sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
  const cell = 19, left = 190, top = 190;
  const width = left + cell * columns.length + 8, height = top + cell * rows.length + 8;
  const caption = "Rows: what was hidden. Columns: what was said. Off the diagonal of the effects: another name.";
  const told = data.confusion.map(([name, cases, right]) => `${words(name)} ${right} of ${cases} right`).join("; ");
  const svg = element(
      "svg",
      {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${caption} ${told}.`, class: "picture matrix"});
  columns.forEach((name, c) => {
    const x = left + cell * (c + 0.5);
    svg.append(element(
        "text", {transform: `translate(${x + 4} ${top - 6}) rotate(-90)`, "text-anchor": "start"}, words(name)));
  });
  rows.forEach((row, r) => {
    const y = top + cell * r;
    svg.append(element("text", {x: left - 6, y: y + 14, "text-anchor": "end"}, words(row.hidden)));
    const cases = Object.values(row.said).reduce((sum, n) => sum + n, 0);
    columns.forEach((name, c) => {
      const n = row.said[name] || 0, right = name === wanted(row.hidden);
      svg.append(element("rect", {
        x: left + cell * c,
        y,
        width: cell - 1,
        height: cell - 1,
        fill: n ? right ? "var(--blue)" : "var(--red)" : "var(--line)",
        "fill-opacity": n ? 0.35 + 0.65 * n / cases : 0.35
      }));
      if (n) {
        svg.append(element(
            "text", {
              x: left + cell * (c + 0.5) - 0.5,
              y: y + 14,
              "text-anchor": "middle",
              class: n > 0.5 * cases ? "count full" : "count"
            },
            String(n), element("title", {}, `${words(row.hidden)}: ${n} times ${words(name)}`)));
      }
    });
  });
  figure(place, svg, caption);
  return place;
};
const group = hidden => hidden === "nothing" ? 1 : hidden.startsWith("outside: ") ? 2 : 0;
const wanted = hidden => hidden.startsWith("outside: ") ? "declined" : hidden;

const is_share = name => !name.includes("/") && !/^(cases|failed|not drawn|processor)/.test(name);

main.append(paragraph(data.sentence, "verdict"));
const scores = Object.entries(data.summary).filter(([name, value]) => typeof value === "number" && name !== "seed");
section(main, "Scores")
    .append(
        table(
            "Shares of cases", ["score", "share"],
            scores.filter(([name]) => is_share(name)).map(([name, value]) => [name, {value, text: percent(value)}])),
        table("Other figures", ["figure", "value"], scores.filter(([name]) => !is_share(name))));
section(main, "Which effect was said for which?")
    .append(
        matrix(),
        table(
            "What was hidden, how often it was said, and what was said instead",
            ["hidden", "cases", "right", "said instead", "declined"],
            data.confusion.map(
                ([name, cases, right, instead, declined]) => [words(name), cases, right, words(instead), declined])));
if (data.calibration.length) calibration(section(main, "Are the stated probabilities right?"));
origin(main, "the trial", data.origin, "h2");
begin();
