// The report of a diagnosis: where recordings and model differ, why, and how well the corrected model predicts.
const d = data.diagnosis, unit = d.fit.unit;
const joints = d.joints;
const file = path => path.split("/").pop();
const of_joint = (recording, j) => file(recording) + (joints > 1 ? `, joint ${j + 1}` : "");
const free = Object.entries(d.parameters).filter(([, p]) => p.free).map(([name]) => name);
// Probabilities are never rounded to certainty.
const chance = p => p > 0.9995 ? "more than 99.9\u00a0%" : p < 0.001 ? "less than 0.1\u00a0%" : percent(p);
const interval = sd => sd ? {value: 1.96 * sd, text: "± " + number(1.96 * sd, 2)} : null;

const fit = () => {
  const held = d.fit.held_out.before === null ? "train" : "held_out", error = d.fit[held];
  if (error.before === null) return;
  const where = held === "held_out" ? "recordings that were held out" : "the recordings that were explained";
  const part = section(main, held === "held_out" ? "Does it predict what it has not seen?" : "How well does it fit?");
  bars(
      part,
      `Error of simulations of ${number(d.fit.horizon_s)} s on ${where}, root mean square${
          unit ? " in " + unit : ""}. Refit: ${
          free.length ? "the nominal with other values of " + free.map(words).join(", ") :
                        "the nominal itself, no parameter of which is free"}.`,
      [
        {label: "as it was", value: error.before, colour: "orange"},
        {label: "refit", value: error.refit, colour: "grey"}, {label: "corrected", value: error.after, colour: "blue"},
        {label: "sensor noise", value: d.fit.noise_floor, colour: "line"}
      ],
      unit);
  const runs = data.runs.filter(r => r.set === held);
  if (!runs.length) return;
  choice(part, "Recording", runs.map(r => file(r.recording)), (i, place) => {
    const run = runs[i], less = (a, b) => a.map((x, k) => x === null || b[k] === null ? null : x - b[k]);
    run.joints.forEach(
        (joint, j) => plot(
            place, `${of_joint(run.recording, j)}: recorded, simulated by the nominal model, and by the corrected one.`,
            run.t,
            [
              {label: "recorded", values: joint.measured, colour: "ink", width: 2},
              {label: "nominal", values: joint.before, colour: "orange", dash: [6, 4]},
              {label: "corrected", values: joint.after, colour: "blue"}
            ],
            {y: with_unit("position", d.units[j].position), height: 260, sync: "fit"}));
    run.joints.forEach(
        (joint, j) => plot(
            place,
            `${of_joint(run.recording, j)}: what the two simulations miss, recorded less simulated; each window of ${
                number(d.fit.horizon_s)} s starts anew.`,
            run.t,
            [
              {label: "nominal", values: less(joint.measured, joint.before), colour: "orange", width: 1},
              {label: "corrected", values: less(joint.measured, joint.after), colour: "blue", width: 1}
            ],
            {y: with_unit("error", d.units[j].position), height: 200, sync: "fit"}));
    place.append(paragraph(kPlotHelp, "soft hint"));
  });
};

// The missing torque in the plane of position and velocity: its sign is the colour, its size the strength.
const plane = (place, caption, joint, units) => {
  const keep = Math.max(1, Math.ceil(joint.q.length / 2500)),
        wide = ([a, b]) => [a - 0.04 * (b - a || 1), b + 0.04 * (b - a || 1)];
  const size = joint.torque.filter(x => x !== null).map(Math.abs).sort((a, b) => a - b),
        full = size[Math.floor(0.98 * (size.length - 1))] || 1;
  caption += ` Full colour: ±${[number(full, 3), units.torque].join(" ").trim()}.`;
  const frame = axes(
      caption, wide(range([joint.q])), wide(range([joint.v])),
      [with_unit("position", units.position), with_unit("velocity", units.velocity)]);
  for (let i = 0; i < joint.q.length; i += keep) {
    if (joint.q[i] === null || joint.v[i] === null || joint.torque[i] === null) continue;
    const share = Math.max(-1, Math.min(1, joint.torque[i] / full));
    frame.svg.append(element("circle", {
      cx: frame.px(joint.q[i]).toFixed(1),
      cy: frame.py(joint.v[i]).toFixed(1),
      r: 2.4,
      fill: `var(--${share < 0 ? "orange" : "blue"})`,
      "fill-opacity": (0.08 + 0.92 * Math.abs(share)).toFixed(2)
    }));
  }
  figure(place, frame.svg, caption);
};

const sides = {
  drift: "in the mechanics (drift)",
  input: "between command and torque (input)",
  sensor: "in the position sensor"
};
const mismatch = () => {
  if (!d.mismatch.detected) return;
  const part = section(main, "Where is the mismatch?");
  const shares = Object.entries(d.mismatch.depends_on).filter(s => s[1] >= 0.005).sort((a, b) => b[1] - a[1]);
  part.append(paragraph(
      `In joint ${d.mismatch.joint ?? "–"}, ${sides[d.mismatch.channel] ?? "–"}.` +
      (shares.length ? ` The missing torque depends on ${
                           shares.map(([name, share]) => `${name} (${percent(share)})`).join(", ")}.` :
                       "")));
  if (!data.torque.length) return;
  choice(part, "Recording", data.torque.map(r => file(r.recording)), (i, place) => {
    const run = data.torque[i], pair = element("div", {class: "pair"});
    run.joints.forEach((joint, j) => {
      const band = sign => joint.torque.map((x, k) => x === null ? null : x + 2 * sign * joint.sd[k]);
      const who = of_joint(run.recording, j), times = d.mismatch.time.filter(m => m.recording === run.recording);
      plot(
          place, who + ": what the nominal model lacks, with two standard deviations; shaded times are significant.",
          run.t,
          [
            {label: "missing torque", values: joint.torque, colour: "blue"},
            {label: "upper", values: band(1), colour: "line", width: 0.5, silent: true},
            {label: "lower", values: band(-1), colour: "line", width: 0.5, silent: true}
          ],
          {
            y: with_unit("missing torque", d.units[j].torque),
            height: 240,
            bands: [[2, 3]],
            marks: times.map(m => ({...m, colour: "shade"}))
          });
      plane(
          pair,
          who + ": missing torque by position and velocity; strong colours: large, blue: positive, orange: negative.",
          joint, d.units[j]);
    });
    place.append(pair);
  });
};

// What is missing against what it may depend on, the stated law through it, and beside it what the law leaves.
const kDots = 2500, kUnsure = 4;  // points of a panel; standard deviations, in the median, of points that are left out
const scatter = (place, caption, labels, xs, within, series) => {
  const kept = xs.map((_, i) => i).filter(i => xs[i] !== null && within.every(values => values[i] !== null));
  if (!kept.length) return;
  const every = Math.max(1, Math.ceil(kept.length / kDots)), shown = kept.filter((_, n) => n % every === 0);
  const wide = ([a, b]) => [a - 0.05 * (b - a || 1), b + 0.05 * (b - a || 1)];
  const frame = axes(
      caption, wide(range([shown.map(i => xs[i])])), wide(range(within.map(values => shown.map(i => values[i])))),
      labels);
  for (const s of series) {
    const dots = shown.map(i => `M${frame.px(xs[i]).toFixed(1)} ${frame.py(s.values[i]).toFixed(1)}h0`).join("");
    frame.svg.append(element("path", {
      d: dots,
      stroke: `var(--${s.colour})`,
      "stroke-width": s.width,
      "stroke-linecap": "round",
      "stroke-opacity": s.opacity,
      fill: "none"
    }));
  }
  figure(place, frame.svg, caption);
};

const law = () => {
  const runs = data.torque.filter(r => r.joints[0].law);
  if (!runs.length || !d.mismatch.detected) return;
  const part = section(main, "What the missing torque looks like");
  const causes = {velocity: ["v", "velocity"], position: ["q", "position"], input: ["u", "input"], time: ["t", "time"]};
  const names = Object.keys(causes).sort((a, b) => (d.mismatch.depends_on[b] ?? 0) - (d.mismatch.depends_on[a] ?? 0));
  // Friction is drawn against velocity: the past, which it seems to depend on, is no axis.
  const first = d.explanation.effects.some(e => e.name.includes("friction") || e.name.includes("drag")) ?
      names.indexOf("velocity") :
      0;
  choice(part, "Against", names, (i, place) => {
    const [column, label] = causes[names[i]];
    for (let j = 0; j < joints; ++j) {
      const of = key => runs.flatMap(r => key === "t" ? r.t : r.joints[j][key]);
      const sd = of("sd"), usual = sd.filter(x => x !== null).sort((a, b) => a - b)[Math.floor(sd.length / 2)];
      const torque = of("torque").map((x, k) => sd[k] > kUnsure * usual ? null : x), said = of("law");
      const left = torque.map((x, k) => x === null || said[k] === null ? null : x - said[k]);
      const says = said.some(x => x !== null && x !== 0);
      const who = joints > 1 ? `Joint ${j + 1}: what` : "What", units = d.units[j];
      const across = with_unit(label, column === "t" ? "s" : units[label]);
      const labels = [across, with_unit("torque", units.torque)], within = says ? [torque, said] : [torque],
            pair = element("div", {class: "pair"});
      scatter(
          pair, `${who} the nominal lacks (grey)${says ? " and what the stated law says (blue)" : ""}.`, labels,
          of(column), within, [
            {values: torque, colour: "grey", width: 3, opacity: 0.45},
            ...(says ? [{values: said, colour: "blue", width: 3, opacity: 0.9}] : [])
          ]);
      if (says) {
        scatter(
            pair, `${who} that law leaves, on the same scale.`, labels, of(column), within,
            [{values: left, colour: "orange", width: 3, opacity: 0.45}]);
      }
      place.append(pair);
    }
  }, first);
};

const explanation = () => {
  const effects = d.explanation.effects;
  if (!effects.length && !d.alternatives.length && !d.remainder) return;
  const part = section(main, "Which physics is missing?"), best = effects.map(e => words(e.name)).join(" + ");
  const alike = d.alternatives.filter(a => a.indistinguishable);
  if (effects.length || d.alternatives.length) {
    const name = list => list.map(words).join(" + ") || "nothing is missing";
    part.append(table(
        "Explanations and their probabilities", ["explanation", "probability", "equation"], [
          ...(effects.length ?
                  [[
                    best + (alike.length ? " or what is told apart by nothing" : ""),
                    {value: d.explanation.probability, text: chance(d.explanation.probability)}, d.explanation.equation
                  ]] :
                  []),
          ...d.alternatives.map(a => [name(a.effects), {
                                        value: a.probability,
                                        text: a.indistinguishable ? `${chance(a.probability)} of the first` :
                                                                    chance(a.probability)
                                      },
                                      a.equation])
        ]));
  }
  if (effects.some(e => e.share !== undefined)) {
    part.append(table(
        "What each effect is good for",
        ["effect", "joint", "part of the machine with", "of the error (squares), left without it"],
        effects.map(e => [words(e.name), e.joint, {value: e.inclusion, text: chance(e.inclusion)}, {
                      value: e.share,
                      text: percent(e.share)
                    }])));
  }
  if (d.remainder) {
    const shares = Object.entries(d.remainder.depends_on).filter(s => s[1] >= 0.05);
    const causes = shares.map(([name, share]) => `${name} (${percent(share)})`).join(", ");
    part.append(paragraph(
        `${percent(d.remainder.share)} of the nominal's error (squares) is explained by no effect of the catalogue` +
        (causes ? `; it depends on ${causes}.` : ".")));
  }
};

const parameters = () => {
  const nominal = Object.entries(d.parameters), effects = d.explanation.effects;
  if (!nominal.length && !effects.length) return;
  const part = section(main, "Parameters"), columns = ["parameter", "value", "95 % interval", "unit"];
  if (effects.length) {
    part.append(table(
        "Parameters of the effects", ["effect", "joint", ...columns, "in words"],
        effects.flatMap(
            e => Object.entries(e.parameters)
                     .map(
                         ([name, p]) =>
                             [words(e.name), e.joint, words(name), p.value, interval(p.sd), p.unit,
                              e.text + (e.recording ? `, in ${file(e.recording)}` : "")]))));
  }
  if (nominal.length) {
    part.append(table(
        "Parameters of the nominal model", ["parameter", "nominal", "value", "95 % interval", "unit"],
        nominal.map(
            ([name,
              p]) => [words(name), p.nominal, p.value, p.free ? interval(p.sd) : "trusted, not estimated", p.unit])));
  }
};

const doubts = () => {
  const suspicions = d.suspicions ?? [];
  if (!suspicions.length) return;
  const part = section(main, "What may be wrong in the spec");
  part.append(table(
      "Mistakes that may explain the mismatch, best first", ["mistake", "error before", "after", "beside it"],
      suspicions.map(
          s =>
              [s.sentence, s.before === null ? "diverges" : s.before, s.after,
               s.effects.map(words).join(" + ") || "nothing is missing"])));
};

const apart = () => {
  if (!d.indistinguishable.length && !d.alone) return;
  const part = section(main, "What could not be told apart");
  for (const names of d.indistinguishable)
    part.append(paragraph(`These recordings cannot separate: ${names.map(words).join(", ")}.`));
  if (d.alone)
    part.append(table(
        "Effects any of which alone would do nearly all that is missing", ["effect", "of the error (squares), %"],
        Object.entries(d.alone.effects).map(([name, share]) => [words(name), number(100 * share, 4)])));
};

const kLeastP = 0.005;  // of 199 replicates
const p_cell = p =>
    ({value: p, text: p <= kLeastP ? "≤ " + kLeastP : number(p, 2), kind: p <= kLeastP ? "violated" : ""});
const rest = () => {
  if (d.next_experiment) {
    const next = d.next_experiment, part = section(main, "What to try next");
    const odds = next.expected_log_odds > 100 ? "practically certain, log odds above 100" :
                                                `log odds ${number(next.expected_log_odds, 3)}`;
    part.append(
        paragraph(`${next.input}. It is expected to tell ${next.separates.map(words).join(" from ")}: ${odds}.`));
    if (next.signal) {
      plot(
          part, `Proposed input of joint ${next.signal.joint}.`,
          next.signal.values.map((_, i) => i * next.signal.period_s),
          [{label: "input", values: next.signal.values, colour: "blue", steps: true}],
          {y: with_unit("input", next.signal.unit), height: 200});
    }
  }
  if (d.residual.after) {
    const tests = {
      slow_modes: "more than noise in what mechanics can follow",
      autocorrelation: "neighbouring samples are alike (Ljung-Box)",
      input: "follows earlier inputs: physics of the input",
      feedback: "goes before the input: a closed loop",
      change: "its size changes in time (CUSUM)"
    };
    const part = section(main, "Is what is left only noise?");
    const found = Object.keys(tests).filter(name => d.residual.after[name].p_value <= kLeastP);
    part.append(paragraph(
        found.length ? `No: ${found.map(name => tests[name]).join("; ")}.` :
                       "Yes, as far as these tests can tell: none finds more than chance would."));
    part.append(table(
        "Tests of the residual", ["test", "p, nominal", "p, explained", "meaning of a small p"],
        Object.entries(tests).map(
            ([name, text]) =>
                [words(name), p_cell(d.residual.before[name].p_value), p_cell(d.residual.after[name].p_value), text])));
  }
};

main.append(paragraph(data.sentence, "verdict"));
if (d.reason) main.append(paragraph(d.reason, "soft"));
fit();
mismatch();
law();
doubts();
explanation();
parameters();
apart();
rest();
origin(main, d.name, data.origin, "h2");
begin();
