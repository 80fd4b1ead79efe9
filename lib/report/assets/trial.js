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

main.append(paragraph(data.sentence, "verdict"));
section(main, "Scores")
    .append(table(
        "Scores of the trial", ["score", "value"],
        Object.entries(data.summary).filter(([name, value]) => typeof value === "number" && name !== "seed")));
section(main, "Which effect was said for which?")
    .append(table(
        "What was hidden, and how often it was said", ["hidden", "cases", "said", "not said", "declined"],
        data.confusion.map(([name, ...counts]) => [words(name), ...counts])));
if (data.calibration.length) calibration(section(main, "Are the stated probabilities right?"));
begin();
