// Figures, and plots over time: uPlot with marks, the data to copy, and keys.

// Something in a frame with its caption; the caption begins with the figure's number in its panel.
const figure = (place, picture, caption, ...more) => {
  const node = element("figure", {}, picture, element("figcaption", {}, caption, ...more));
  place.append(node);
  return node;
};

// Plots are drawn when all around them stands and they can be seen: their width is that of their place.
let plots = [];  // {holder, draw}
const redraw = () => {
  plots = plots.filter(p => p.holder.isConnected);
  plots.forEach(p => {
    if (printing.matches || p.holder.clientWidth) p.draw();
  });
};
// Pixels, of a plot: on paper, the layout is not known before.
const width_of = holder => printing.matches ? (holder.closest(".pair") ? 330 : 680) : Math.max(240, holder.clientWidth);

// A plot over time. `series`: {label, values, colour, dash, width, steps}. Options: y (label), height, bands (pairs of
// series with the area between them filled), marks ({from, to, colour, edge, strength}), sync (plots whose cursors move
// together), clock (whose time is marked).
const plot = (place, caption, x, series, options = {}) => {
  const told = series.filter(s => !s.silent).map(s => {
    const [least, most] = range([s.values]), seen = s.values.filter(v => typeof v === "number");
    return `${s.label}: from ${number(seen[0], 3)} to ${number(seen.at(-1), 3)}, least ${number(least, 3)}, greatest ${
        number(most, 3)}`;
  });
  const alternative =
      `${caption} ${options.y || ""} over ${number(x[0], 3)} to ${number(x.at(-1), 3)} s. ${told.join("; ")}.`;
  const holder = element("div", {class: "plot", role: "img", "aria-label": alternative, tabindex: "0"});
  figure(
      place, holder, caption + " ",
      copy_button("copy data", () => tabbed([
                                 ["t (s)", ...series.map(s => s.label)],
                                 ...x.map((t, i) => [t, ...series.map(s => s.values[i] ?? "")])
                               ])));
  // A run that diverges ends at 1e150: what came before is to be seen.
  const kDiverged = 1e9,
        sizes = series.flatMap(s => s.values).filter(v => typeof v === "number").map(Math.abs).sort((a, b) => a - b);
  const limit = Math.min(20 * sizes[Math.floor(sizes.length / 2)] || 1, 1e6);
  const seen = (_, least, most) =>
      sizes.at(-1) > kDiverged ? [-limit, limit] : uPlot.rangeNum(least ?? 0, most ?? 1, 0.1, true);
  let u = null, line = null;
  const draw = () => {
    if (u) u.destroy();
    const axis = {
      stroke: colour("ink"),
      grid: {stroke: colour("line"), width: 1},
      ticks: {stroke: colour("line"), width: 1},
      font: "12px system-ui, sans-serif",
      labelFont: "13px system-ui, sans-serif",
      labelSize: 20,
      labelGap: 0
    };
    u = new uPlot(
        {
          width: width_of(holder),
          height: options.height || 220,
          scales: {x: {time: false}, y: {range: seen}},
          cursor: {sync: options.sync ? {key: options.sync} : undefined, points: {size: 6}},
          axes: [
            {...axis, label: "t (s)", size: 32},
            {...axis, label: options.y || "", size: 52, values: (_, list) => labels_of(list)}
          ],
          bands: (options.bands || []).map(pair => ({series: pair, fill: colour("band")})),
          series: [
            {label: "t (s)", value: (_, t) => number(t)},
            ...series.map(s => ({
                            label: s.label,
                            stroke: colour(s.colour),
                            width: s.width ?? 1.5,
                            dash: s.dash,
                            spanGaps: false,
                            points: {show: false},
                            value: (_, v) => number(v),
                            paths: s.steps ? uPlot.paths.stepped({align: 1}) : undefined
                          }))
          ],
          hooks: {drawClear: [shade]},
        },
        [x, ...series.map(s => s.values)], holder);
    line = element("div", {class: "time"});
    u.over.append(line);
    mark();
  };
  const shade = plot => {  // marked times, each at least two pixels wide, with a tick at its edge of the frame
    const {ctx, bbox} = plot, scale = plot.scales.x, pixel = devicePixelRatio;
    for (const m of options.marks || []) {
      if (m.to < scale.min || m.from > scale.max) continue;
      const a = plot.valToPos(Math.max(m.from, scale.min), "x", true),
            b = plot.valToPos(Math.min(m.to, scale.max), "x", true);
      const width = Math.max(b - a, 2 * pixel);
      ctx.fillStyle = colour(m.colour);
      ctx.globalAlpha = m.strength || 0.22;
      ctx.fillRect(a, bbox.top, width, bbox.height);
      ctx.globalAlpha = 1;
      if (m.edge) ctx.fillRect(a, m.edge === "top" ? bbox.top : bbox.top + bbox.height - 9 * pixel, width, 9 * pixel);
    }
  };
  const mark = () => {
    const t = options.clock ? options.clock.time : null;
    line.hidden = t === null || t < u.scales.x.min || t > u.scales.x.max;
    if (!line.hidden) line.style.transform = `translateX(${u.valToPos(t, "x")}px)`;
  };
  if (options.clock)
    options.clock.listeners.add(() => {
      if (line && line.isConnected) mark();
    });
  holder.addEventListener("keydown", event => {  // arrows move the cursor, + and - zoom about it, 0 shows all
    const {min, max} = u.scales.x, step = event.shiftKey ? 20 : 2;
    const at = u.cursor.left >= 0 ? u.cursor.left : 0, t = u.posToVal(at, "x");
    const zoom = factor =>
        u.setScale("x", {min: Math.max(x[0], t - factor * (t - min)), max: Math.min(x.at(-1), t + factor * (max - t))});
    const actions = {
      ArrowRight: () => move(at + step),
      ArrowLeft: () => move(at - step),
      "+": () => zoom(0.5),
      "=": () => zoom(0.5),
      "-": () => zoom(2),
      0: () => u.setScale("x", {min: x[0], max: x.at(-1)})
    };
    const move = left =>
        u.setCursor({left: Math.max(0, Math.min(u.over.clientWidth - 1, left)), top: u.over.clientHeight / 2});
    if (actions[event.key]) {
      event.preventDefault();
      actions[event.key]();
    }
  });
  plots.push({holder, draw});
};
const kPlotHelp =
    "In every plot: drag to enlarge a stretch of time, double-click to see all again. With the keyboard: the arrows move the " +
    "cursor (with Shift: faster), + and − enlarge and reduce, 0 shows all.";

// Once the page is made: plots are drawn, and follow the window, the colour scheme and the printer.
const begin = () => {
  redraw();
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth !== width) {
      width = innerWidth;
      redraw();
    }
  });
  for (const media of [printing, matchMedia("(prefers-color-scheme: dark)")]) media.addEventListener("change", redraw);
};
