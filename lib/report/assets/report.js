"use strict";
// Draws a report from the data that stands in the page. Text from user files only ever becomes text nodes.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const main = document.querySelector("main");
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  const element = (name, attributes = {}, ...children) => {
    const svg = ["svg", "rect", "circle", "line", "path", "text", "g", "title"].includes(name);
    const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
      if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
      else node.setAttribute(key, value);
    }
    for (const child of children) node.append(child);
    return node;
  };
  const number = (x, digits = 4) => typeof x !== "number" ? "–" : Number.isSafeInteger(x) ? String(x) :
    Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(digits - 1) : String(Number(x.toPrecision(digits)));
  const file = path => path.split("/").pop();
  const percent = x => (100 * x).toFixed(x >= 0.0995 ? 0 : 1) + " %";
  const section = title => {
    const part = element("section", {}, element("h2", {}, title));
    main.append(part);
    return part;
  };

  // A table that can be sorted by its headings and copied.
  const table = (columns, rows, caption) => {
    const body = element("tbody");
    const fill = list => {
      body.replaceChildren(...list.map(row => element("tr", {}, ...row.map(cell =>
        element("td", typeof cell === "number" ? {class: "number"} : {},
          cell instanceof Node ? cell : typeof cell === "number" ? number(cell) : String(cell))))));
    };
    let sorted = -1;
    const heads = columns.map((name, i) => element("th", {scope: "col"}, element("button", {type: "button",
      title: "sort by " + name, onclick: () => {
        const sign = sorted === i ? -1 : 1;
        sorted = sorted === i ? -1 : i;
        const value = row => row[i] instanceof Node ? row[i].textContent : row[i];
        fill([...rows].sort((a, b) => sign * (typeof value(a) === "number" && typeof value(b) === "number" ?
          value(a) - value(b) : String(value(a)).localeCompare(String(value(b)), undefined, {numeric: true}))));
      }}, name)));
    fill(rows);
    const text = () => [columns, ...rows.map(row => row.map(c => c instanceof Node ? c.textContent : c))]
      .map(row => row.join("\t")).join("\n");
    const copy = element("button", {type: "button", class: "copy", onclick: async () => {
      try { await navigator.clipboard.writeText(text()); copy.textContent = "copied"; }
      catch { copy.textContent = "copying is not allowed here"; }
    }}, "copy");
    return element("div", {class: "scroll"}, element("table", {}, ...(caption ? [element("caption", {class: "soft"}, caption)] : []),
      element("thead", {}, element("tr", {}, ...heads)), body), copy);
  };

  let figures = [];  // {holder, draw}
  const redraw = () => { figures = figures.filter(f => f.holder.isConnected); figures.forEach(f => f.draw()); };
  // A plot over time. `series`: {label, values, colour, dash, fill}; `bands`: pairs of series between which the area is filled.
  const plot = (place, alternative, x, series, options = {}) => {
    const holder = element("div", {role: "img", "aria-label": alternative, tabindex: "0"});
    place.append(element("figure", {}, holder, element("figcaption", {}, alternative)));
    const draw = () => {
      holder.replaceChildren();
      const axis = {stroke: colour("ink"), grid: {stroke: colour("line"), width: 1}, ticks: {stroke: colour("line"), width: 1}};
      new uPlot({
        width: Math.max(280, holder.clientWidth), height: options.height || 260,
        scales: {x: {time: false}}, axes: [{...axis, label: options.x || "t (s)"}, {...axis, label: options.y || "", size: 70}],
        bands: (options.bands || []).map(pair => ({series: pair, fill: colour("band")})),
        series: [{label: options.x || "t (s)"}, ...series.map(s => ({label: s.label, stroke: colour(s.colour), width: s.width ?? 1.5,
          dash: s.dash, spanGaps: false, points: {show: false}}))],
        hooks: {drawClear: [u => {  // marked times
          u.ctx.fillStyle = colour("band");
          for (const m of options.marks || []) {
            const a = u.valToPos(Math.max(m.from, u.scales.x.min), "x", true), b = u.valToPos(Math.min(m.to, u.scales.x.max), "x", true);
            if (b > a) u.ctx.fillRect(a, u.bbox.top, b - a, u.bbox.height);
          }
        }]},
      }, [x, ...series.map(s => s.values)], holder);
    };
    draw();
    figures.push({holder, draw});
  };

  // One recording at a time.
  const choice = (place, label, names, draw) => {
    const body = element("div");
    const select = element("select", {"aria-label": label, onchange: () => show(Number(select.value))},
      ...names.map((name, i) => element("option", {value: String(i)}, name)));
    const show = i => { body.replaceChildren(); draw(i, body); };
    place.append(element("label", {}, label + " ", select), body);
    draw(0, body);
  };

  // Bars beside one another: [{label, value, colour}].
  const bars = (place, alternative, list, unit) => {
    const width = 640, height = 34 * list.length + 8, most = Math.max(...list.map(b => b.value)) || 1;
    const svg = element("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": alternative, width, height});
    list.forEach((bar, i) => {
      const y = 34 * i + 6;
      svg.append(element("text", {x: 118, y: y + 17, "text-anchor": "end"}, bar.label),
        element("rect", {x: 126, y, width: Math.max(1, 390 * bar.value / most), height: 24, rx: 3, fill: `var(--${bar.colour})`}),
        element("text", {x: 134 + 390 * bar.value / most, y: y + 17}, number(bar.value) + (unit ? " " + unit : "")));
    });
    place.append(element("figure", {}, svg, element("figcaption", {}, alternative)));
  };

  // Points in a plane, coloured by a signed value.
  const plane = (place, alternative, xs, ys, values, labels) => {
    const width = 560, height = 400, left = 64, bottom = 44, keep = Math.max(1, Math.ceil(xs.length / 2500));
    const range = list => { let a = Infinity, b = -Infinity; for (const x of list) { a = Math.min(a, x); b = Math.max(b, x); } return b > a ? [a, b] : [a - 1, a + 1]; };
    const [x0, x1] = range(xs), [y0, y1] = range(ys);
    const size = values.map(Math.abs).sort((a, b) => a - b)[Math.floor(0.98 * (values.length - 1))] || 1;
    const svg = element("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": alternative, width, height});
    const px = x => left + (width - left - 12) * (x - x0) / (x1 - x0), py = y => height - bottom - (height - bottom - 12) * (y - y0) / (y1 - y0);
    svg.append(element("rect", {x: left, y: 12, width: width - left - 12, height: height - bottom - 12, fill: "none", stroke: "var(--line)"}));
    for (let i = 0; i < xs.length; i += keep) {
      const s = Math.max(-1, Math.min(1, values[i] / size));
      svg.append(element("circle", {cx: px(xs[i]).toFixed(1), cy: py(ys[i]).toFixed(1), r: 2.4,
        fill: `var(--${s < 0 ? "before" : "after"})`, "fill-opacity": (0.08 + 0.92 * Math.abs(s)).toFixed(2)}));
    }
    const text = (x, y, anchor, words) => svg.append(element("text", {x, y, "text-anchor": anchor}, words));
    text(left, height - 26, "start", number(x0, 3)); text(width - 12, height - 26, "end", number(x1, 3));
    text((left + width) / 2, height - 8, "middle", labels[0]);
    text(left - 6, height - bottom, "end", number(y0, 3)); text(left - 6, 22, "end", number(y1, 3));
    text(left - 6, (height - bottom) / 2, "end", labels[1]);
    place.append(element("figure", {}, svg, element("figcaption", {}, alternative)));
  };

  const reports = {
    diagnosis() {
      const d = data.diagnosis, unit = d.fit.unit, joints = data.joints;
      main.append(element("p", {class: "verdict"}, data.sentence));
      if (d.reason) main.append(element("p", {class: "soft"}, d.reason));

      const held = d.fit.held_out.before === null ? "train" : "held_out", fit = d.fit[held];
      const where = held === "held_out" ? "recordings that were held out" : "the recordings that were explained";
      if (fit.before !== null) {
        const part = section(held === "held_out" ? "Does it predict what it has not seen?" : "How well does it fit?");
        bars(part, `Error of simulations of ${d.fit.horizon_s} s on ${where}, RMS. The sensor's noise is ${number(d.fit.noise_floor)} ${unit}.`, [
          {label: "as it was", value: fit.before, colour: "before"},
          ...(fit.refit !== fit.before ? [{label: "refit", value: fit.refit, colour: "soft"}] : []),
          {label: "corrected", value: fit.after, colour: "after"},
          {label: "sensor noise", value: d.fit.noise_floor, colour: "line"}], unit);
        const runs = data.runs.filter(r => r.set === held);
        if (runs.length) choice(part, "Recording", runs.map(r => file(r.recording)), (i, place) => {
          runs[i].joints.forEach((joint, j) => plot(place,
            `${file(runs[i].recording)}${joints > 1 ? ", joint " + (j + 1) : ""}: recorded, simulated by the nominal model, and by the corrected one.`,
            runs[i].t, [{label: "recorded", values: joint.measured, colour: "measured", width: 2}, {label: "nominal", values: joint.before, colour: "before", dash: [6, 4]},
              {label: "corrected", values: joint.after, colour: "after"}], {y: `position (${unit})`}));
          const less = (a, b) => a.map((x, k) => b[k] === null ? null : x - b[k]);
          runs[i].joints.forEach((joint, j) => plot(place,
            `${file(runs[i].recording)}${joints > 1 ? ", joint " + (j + 1) : ""}: what the two simulations miss, recorded less simulated; each window of ${d.fit.horizon_s} s starts anew.`,
            runs[i].t, [{label: "nominal", values: less(joint.measured, joint.before), colour: "before", width: 1},
              {label: "corrected", values: less(joint.measured, joint.after), colour: "after", width: 1}], {y: `error (${unit})`, height: 200}));
        });
      }

      if (d.mismatch.detected) {
        const part = section("Where is the mismatch?");
        const shares = Object.entries(d.mismatch.depends_on).filter(s => s[1] >= 0.005);
        part.append(element("p", {}, `Joint ${d.mismatch.joint ?? "–"}, on the ${d.mismatch.channel ?? "–"} side. The missing torque depends on ` +
          shares.sort((a, b) => b[1] - a[1]).map(([name, share]) => `${name} (${percent(share)})`).join(", ") + "."));
        if (data.torque.length) choice(part, "Recording", data.torque.map(r => file(r.recording)), (i, place) => {
          const r = data.torque[i];
          r.joints.forEach((joint, j) => {
            const band = (sign) => joint.torque.map((x, k) => x + 2 * sign * joint.sd[k]);
            plot(place, `${file(r.recording)}${joints > 1 ? ", joint " + (j + 1) : ""}: what the nominal model lacks, with its band of two standard deviations; shaded times are significant.`,
              r.t, [{label: "missing torque", values: joint.torque, colour: "after"}, {label: "upper", values: band(1), colour: "line", width: 0.5},
                {label: "lower", values: band(-1), colour: "line", width: 0.5}],
              {y: "missing torque", bands: [[2, 3]], marks: d.mismatch.time.filter(m => m.recording === r.recording)});
            plane(place, `${file(r.recording)}${joints > 1 ? ", joint " + (j + 1) : ""}: missing torque in the plane of position and velocity; strong colours are large, the two colours are its signs.`,
              joint.q, joint.v, joint.torque, [`position (${unit})`, "velocity"]);
          });
        });
      }

      const effects = d.explanation.effects;
      if (effects.length || d.alternatives.length) {
        const part = section("Which physics is missing?");
        if (effects.length) {
          part.append(element("p", {}, `Probability ${percent(d.explanation.probability)}. `, element("code", {}, d.explanation.equation)));
          const rows = [];
          for (const e of effects) {
            for (const [name, p] of Object.entries(e.parameters)) {
              rows.push([e.name, e.joint, name, p.value, p.sd ? `${number(p.value - 1.96 * p.sd)} … ${number(p.value + 1.96 * p.sd)}` : "–", p.unit, e.text]);
            }
          }
          part.append(table(["effect", "joint", "parameter", "value", "95 % interval", "unit", "in words"], rows));
        }
        if (d.alternatives.length) part.append(element("h3", {}, "Alternatives"), table(["explanation", "probability"],
          d.alternatives.map(a => [a.effects.join(" + ") || "nothing is missing", a.probability])));
        for (const names of d.indistinguishable) part.append(element("p", {}, `These recordings cannot separate: ${names.join(", ")}.`));
      }
      if (d.remainder) section("What is left").append(element("p", {}, `A part of ${percent(d.remainder.share)} of the nominal's error (squares) is explained by no effect of the catalogue; it depends on ` +
        Object.entries(d.remainder.depends_on).filter(s => s[1] >= 0.05).map(([n, s]) => `${n} (${percent(s)})`).join(", ") + "."));
      const parameters = Object.entries(d.parameters);
      if (parameters.length) section("Parameters of the nominal model").append(table(["parameter", "nominal", "value", "standard deviation"],
        parameters.map(([name, p]) => [name, p.nominal, p.value, p.sd])));

      if (d.next_experiment) {
        const n = d.next_experiment, part = section("What to try next");
        part.append(element("p", {}, `${n.input}. It is expected to tell ${n.separates.join(" from ")}: log odds ${number(n.expected_log_odds, 3)}.`));
        if (n.signal) plot(part, `Proposed input of joint ${n.signal.joint}.`, n.signal.values.map((_, i) => i * n.signal.period_s),
          [{label: "input", values: n.signal.values, colour: "after"}], {y: "input", height: 200});
      }
      if (d.residual.after) {
        const words = {slow_modes: "more than noise in what mechanics can follow", autocorrelation: "neighbouring samples are alike (Ljung-Box)",
          input: "follows earlier inputs: physics of the input", feedback: "goes before the input: a closed loop", change: "its size changes in time (CUSUM)"};
        section("Is what is left only noise?").append(table(["test", "p, nominal", "p, explained", "meaning of a small p"],
          Object.keys(words).map(name => [name, d.residual.before[name].p_value, d.residual.after[name].p_value, words[name]])));
      }
    },

    trial() {
      const s = data.summary;
      main.append(element("p", {class: "verdict"}, data.sentence));
      section("Figures").append(table(["figure", "value"], Object.entries(s).filter(e => typeof e[1] === "number").map(([k, v]) => [k, v])));
      const part = section("Which effect was said for which?");
      part.append(table(["hidden", "cases", "said", "not said", "declined"], data.confusion));
      const c = data.calibration;
      const svg = element("svg", {viewBox: "0 0 420 400", width: 420, height: 400, role: "img", "aria-label": "Calibration: share of right answers over the stated probability."});
      const x = p => 50 + 340 * p, y = p => 360 - 340 * p;
      svg.append(element("rect", {x: 50, y: 20, width: 340, height: 340, fill: "none", stroke: "var(--line)"}),
        element("line", {x1: x(0), y1: y(0), x2: x(1), y2: y(1), stroke: "var(--line)"}),
        element("text", {x: 220, y: 392, "text-anchor": "middle"}, "stated probability"), element("text", {x: 46, y: 30, "text-anchor": "end"}, "right"));
      for (const bin of c) svg.append(element("circle", {cx: x(bin.stated), cy: y(bin.right), r: 3 + Math.min(9, Math.sqrt(bin.cases)), fill: "var(--after)"},
        element("title", {}, `${bin.cases} cases, stated ${number(bin.stated, 3)}, right ${number(bin.right, 3)}`)));
      section("Are the stated probabilities right?").append(element("figure", {}, svg, element("figcaption", {}, "Circles on the line are calibrated; larger circles are more cases.")),
        table(["stated", "right", "cases"], c.map(b => [b.stated, b.right, b.cases])));
    },
  };
  reports[data.kind]();

  let width = innerWidth;
  addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; redraw(); } });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
})();
