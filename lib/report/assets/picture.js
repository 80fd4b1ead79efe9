// Static pictures as SVG: axes, maps over the state space, bars, points. Their text follows the colour scheme by
// itself.

// Round numbers inside [from, to].
const ticks = (from, to, most = 6) => {
  const rough = (to - from) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(f => f * power >= rough);
  const list = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; ++k)
    list.push(Number((k * step).toPrecision(12)));
  return list;
};

// A frame with axes: {svg, px, py, inside}. `margin` is the room right of it.
const axes = (alternative, [x0, x1], [y0, y1], labels, {width = 460, height = 330, margin = 14} = {}) => {
  const left = 58, top = 12, right = width - margin, bottom = height - 46;
  const px = x => left + (right - left) * (x - x0) / (x1 - x0),
        py = y => bottom - (bottom - top) * (y - y0) / (y1 - y0);
  const svg =
      element("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": alternative, class: "picture"});
  const write = (x, y, anchor, text, more = {}) =>
      svg.append(element("text", {x, y, "text-anchor": anchor, ...more}, text));
  const across = ticks(x0, x1), up = ticks(y0, y1), across_labels = labels_of(across), up_labels = labels_of(up);
  across.forEach((x, i) => {
    svg.append(element("line", {x1: px(x), x2: px(x), y1: bottom, y2: bottom + 5, class: "axis"}));
    write(px(x), bottom + 19, "middle", across_labels[i]);
  });
  up.forEach((y, i) => {
    svg.append(element("line", {x1: left - 5, x2: left, y1: py(y), y2: py(y), class: "axis"}));
    write(left - 8, py(y) + 4, "end", up_labels[i]);
  });
  write((left + right) / 2, height - 8, "middle", labels[0]);
  write(0, 0, "middle", labels[1], {transform: `translate(14 ${(top + bottom) / 2}) rotate(-90)`});
  svg.append(
      element("rect", {x: left, y: top, width: right - left, height: bottom - top, fill: "none", class: "axis"}));
  return {svg, px, py, left, top, right, bottom, inside: (x, y) => x >= x0 && x <= x1 && y >= y0 && y <= y1};
};

// A path through points; null lifts the pen.
const pen = (xs, ys) => {
  let text = "", down = false;
  xs.forEach((x, i) => {
    if (x === null || ys[i] === null) {
      down = false;
      return;
    }
    text += `${down ? "L" : "M"}${x.toFixed(1)} ${ys[i].toFixed(1)}`;
    down = true;
  });
  return text;
};

// Viridis (van der Walt & Smith): even steps of lightness, also for the colour-blind and in grey.
const kViridis = [
  "440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"
].map(hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16)));
const viridis = share => {
  const at = Math.max(0, Math.min(1, share)) * (kViridis.length - 1), i = Math.min(kViridis.length - 2, Math.floor(at));
  return `rgb(${kViridis[i].map((c, k) => Math.round(c + (at - i) * (kViridis[i + 1][k] - c))).join(" ")})`;
};

// Stars where the training points are.
const stars = (frame, xs, ys) => {
  const shape = xs.map(
                      (x, i) => frame.inside(x, ys[i]) ?
                          `M${(frame.px(x) - 4).toFixed(1)} ${frame.py(ys[i]).toFixed(1)}h8m-6 -3.5l4 7m0 -7l-4 7` :
                          "")
                    .join("");
  frame.svg.append(element("path", {d: shape, class: "halo"}), element("path", {d: shape, class: "star"}));
};

// A map of `grid.values` over positions and velocities with the state's path and the training points. The colours go
// from the least to the greatest value, and at least over the range `grid.over`.
const map = (place, title, caption, grid, labels, unit, path, points) => {
  const half = list => (list[1] - list[0]) / 2;
  const dq = half(grid.q), dv = half(grid.v);
  const [lowest, highest] = range([grid.values]), [least, most] = range([grid.values, grid.over]);
  const known = grid.values.filter(x => x !== null).sort((a, b) => a - b), median = known[Math.floor(known.length / 2)];
  const [from, to, middle] = [lowest, highest, median].map(x => number(x, 3));
  const alternative = `${title}, a map over ${labels[0]} and ${labels[1]}: from ${from} to ${to} ${unit}, median ` +
      `${middle}. ${points.q.length} training points. ${caption}`;
  const frame = axes(
      alternative, [grid.q[0] - dq, grid.q.at(-1) + dq], [grid.v[0] - dv, grid.v.at(-1) + dv], labels, {margin: 82});
  const cells = element("g", {"shape-rendering": "crispEdges"});
  const share = x => most > least ? (x - least) / (most - least) : 0;
  grid.q.forEach((q, i) => grid.v.forEach((v, k) => {
    const z = grid.values[i * grid.v.length + k];
    if (z === null) return;
    const x = frame.px(q - dq), y = frame.py(v + dv);
    cells.append(element("rect", {
      x: x.toFixed(1),
      y: y.toFixed(1),
      width: (frame.px(q + dq) - x + 0.3).toFixed(1),
      height: (frame.py(v - dv) - y + 0.3).toFixed(1),
      fill: viridis(share(z))
    }));
  }));
  frame.svg.prepend(cells);
  const kept = path.q.map((q, i) => frame.inside(q, path.v[i]));
  cells.after(element(
      "path", {d: pen(path.q.map((q, i) => kept[i] ? frame.px(q) : null), path.v.map(frame.py)), class: "track"}));
  stars(frame, points.q, points.v);
  const steps = 24, bar = frame.right + 12, tall = (frame.bottom - frame.top) / steps;
  for (let i = 0; i < steps; ++i) {
    frame.svg.append(element(
        "rect",
        {x: bar, y: frame.bottom - (i + 1) * tall, width: 12, height: tall + 0.3, fill: viridis((i + 0.5) / steps)}));
  }
  const levels = most > least ? ticks(least, most, 5) : [least], labels_of_levels = labels_of(levels);
  levels.forEach((z, i) => {
    frame.svg.append(element(
        "text", {x: bar + 17, y: frame.bottom - share(z) * (frame.bottom - frame.top) + 4}, labels_of_levels[i]));
  });
  const node = figure(place, frame.svg, caption);
  node.prepend(element("h4", {}, with_unit(title, unit)));
};

// Bars beneath one another: [{label, value, colour, published}]; a published value is a mark on its bar.
const bars = (place, caption, list, unit) => {
  const row = 30, width = 460, height = row * list.length + 4,
        most = Math.max(...list.map(b => Math.max(b.value, b.published || 0))) || 1;
  const long = Math.max(...list.map(b => b.label.length)), left = Math.min(150, 12 + 7.2 * long),
        full = width - left - 96;
  const published = b => typeof b.published === "number" ? ` (published ${number(b.published)})` : "";
  const told = list.map(b => `${b.label} ${number(b.value)}${published(b)}`).join(", ");
  const svg = element("svg", {
    viewBox: `0 0 ${width} ${height}`,
    role: "img",
    "aria-label": `${caption} ${told}${unit ? ", in " + unit : ""}.`,
    class: "picture"
  });
  list.forEach((bar, i) => {
    const y = row * i + 4, long = Math.max(1, full * bar.value / most),
          edge = left + full * Math.max(bar.value, bar.published || 0) / most;
    svg.append(
        element(
            "text", {x: left - 8, y: y + 16, "text-anchor": "end"},
            bar.label.length > 20 ? bar.label.slice(0, 19) + "…" : bar.label),
        element("rect", {x: left, y, width: long, height: 22, rx: 2, fill: `var(--${bar.colour})`}),
        element("text", {x: edge + 8, y: y + 16}, number(bar.value)));
    if (typeof bar.published === "number")
      svg.append(element("path", {d: `M${left + full * bar.published / most} ${y - 3}v28`, class: "published"}));
  });
  return figure(place, svg, caption);
};
