// The report of experiments: the paper's figures and table for every study.
const kControllerColours = ["grey", "orange", "green", "blue", "purple", "red", "sky", "yellow"];
const kJointColours = ["blue", "orange", "green", "purple", "red", "sky", "yellow"];
const kMetricNames = {
  energy: "energy",
  energy_riemann: "energy, Riemann sum",
  drift_points: "data of a",
  gain_points: "data of b",
  final_angle: "final q",
  new_drift_points: "new data of a",
  new_gain_points: "new data of b"
};
const metric_name = (metric, units = {}) =>
    with_unit(kMetricNames[metric] || words(metric), {final_angle: units.q, peak_input: units.u}[metric]);
const point_of = study =>
    Object.entries(study.point).map(([path, value]) => `${path.split(".").pop()} = ${value}`).join(", ");
const title_of = study => [study.name, point_of(study)].filter(Boolean).join(", ");
const failed = study => study.rows.filter(row => row.status !== "ok");

// The published table with our results in its cells.
const published_table = place => {
  const {name, source, cells} = data.published, part = section(place, `${name} beside the results`);
  const known = Object.keys(data.studies[0].rows[0]), used = [...new Set(cells.map(c => c.metric))];
  const metrics = used.sort((a, b) => known.indexOf(a) - known.indexOf(b));
  part.append(paragraph(
      "In each cell: the result, the published number, the deviation and its tolerance. The deeper the colour, the " +
      "greater the deviation; ✗ and orange: beyond its tolerance."));
  const cell_of = cell => {
    if (!cell) return null;
    if (cell.ok === "missing") return {value: null, text: "no result", kind: "missing"};
    const far = Math.min(1, Math.abs(cell.deviation_percent ?? 0) / 20), well = cell.ok === "yes";
    const sign = cell.deviation_percent > 0 ? "+" : "",
          deviation = cell.deviation_percent === null ? "" : `, ${sign}${number(cell.deviation_percent, 3)}\u00a0%`;
    const node = element(
        "span", {class: "compared", style: `--far: ${(12 + 58 * far).toFixed(0)}%`},
        element("b", {}, `${number(cell.result, 5)} ${well ? "✓" : "✗"}`),
        element("small", {}, `published ${number(cell.published, 5)}${deviation}`),
        element("small", {}, cell.tolerance));
    return {value: cell.result, node, kind: well ? "holds" : "violated"};
  };
  const rows =
      [...new Map(cells.map(c => [c.experiment + "\n" + c.controller, [c.experiment, c.controller]])).values()];
  part.append(table(
      `${name}: ${source}.`, ["experiment", "controller", ...metrics.map(m => metric_name(m))],
      rows.map(
          ([experiment, controller]) =>
              [experiment, controller,
               ...metrics.map(
                   m => cell_of(cells.find(
                       c => c.experiment === experiment && c.controller === controller && c.metric === m)))])));
};

// One row per controller, without the columns that say nothing: empty, or zero in every row.
const runs_table = (caption, studies) => {
  const rows = studies.flatMap(s => s.rows), points = [...new Set(studies.flatMap(s => Object.keys(s.point)))];
  const measured =
      Object.keys(rows[0]).filter(c => !["controller", "experiment", ...points].includes(c) && rows.some(r => r[c]));
  const named = new Set(rows.map(r => r.experiment)).size > 1 ? ["experiment"] : [];
  const as_number = text => text !== "" && isFinite(text) ? Number(text) : text ?? null;
  const cell = (row, column) => ({
    value: points.includes(column) ? as_number(row[column]) : row[column],
    kind: column === "status" && row.status !== "ok" ? "violated" : undefined
  });
  const columns = ["controller", ...named, ...points, ...measured];
  return table(
      caption, columns.map(c => points.includes(c) ? c : metric_name(c, studies[0].units)),
      rows.map(row => columns.map(c => cell(row, c))));
};

const comparison = (place, study) => {
  const part = section(place, "Controllers", "h3");
  part.append(runs_table(`Results of ${title_of(study)}`, [study]));
  const pair = element("div", {class: "pair"});
  part.append(pair);
  const cells = data.published ? data.published.cells : [];
  for (const [metric, what] of [
           ["energy", "Control energy, the integral of |u|² over time."],
           ["squared_error", "Squared error, the integral of |x − ξ|² over time."]]) {
    const list = study.rows
                     .map((row, i) => {
                       const told = cells.find(
                           c => c.experiment === study.name && c.controller === row.controller && c.metric === metric);
                       return {
                         label: row.controller,
                         value: row[metric],
                         colour: kControllerColours[i % kControllerColours.length],
                         published: told ? told.published : undefined
                       };
                     })
                     .filter((b, i) => typeof b.value === "number" && study.rows[i].status === "ok");
    if (list.length)
      bars(
          pair, what + (list.some(b => b.published !== undefined) ? " The marks are published values." : ""), list, "");
  }
};

// What a controller learned, in words.
const learning_of = (run, settings) => {
  if (settings.type !== "adaptive") return "";
  const probes = run.probing.filter(p => p[2] !== "learn_a").length, samples = run.probing.length - probes;
  const start = settings.trained_from ? `starting with the data of ${settings.trained_from}` : "starting without data";
  return ` It learned a at ${samples} and b at ${probes} times, ${start}.`;
};
const kLearning = {
  // how each kind is marked in the plots
  a: {colour: "learn-a", edge: "top", text: " (tick at the top) a sample of the drift a, "},
  b: {colour: "learn-b", edge: "bottom", text: " (tick at the bottom) a probing action for the input gain b. "},
};
const kAlarm = {
  colour: "red",
  strength: 0.9,
  text: " an alarm: its predictions were surer than they were right, and its prior was widened."
};

// Two controllers beside one another: position, velocity and input over time, with what was learned when.
const evolution = (place, study, clock, key) => {
  if (!study.runs.length) return;
  const {units, runs} = study, position = units.q === "rad" ? "angle" : "position";
  const part = section(place, `Evolution of ${position}, velocity and control`, "h3");
  const swatch = kind => element("span", {class: "swatch", style: `background: var(--${kind.colour})`});
  const pair = element("div", {class: "pair"}), legend = element("p", {class: "soft"}, "Shaded: learning. ");
  const alarmed = runs.some(run => run.alarms.length);
  for (const kind of [...Object.values(kLearning), ...(alarmed ? [kAlarm] : [])])
    legend.append(swatch(kind), kind.text);
  part.append(legend, pair);

  const show = (run, body) => {
    const joints = run.q.length, settings = study.spec.controllers[run.name] || {};
    const marks = run.probing.map(([from, to, mode]) => ({from, to, ...kLearning[mode === "learn_a" ? "a" : "b"]}));
    for (const t of run.alarms) marks.push({from: t, to: t, ...kAlarm});
    const lines = (lists, name, more) =>
        lists.map((values, j) => ({label: numbered(name, j, joints), values, colour: kJointColours[j], ...more}));
    const draw = (caption, series, label) =>
        plot(body, `${run.name}: ${caption}`, run.t, series, {marks, clock, sync: key, height: 190, y: label});
    draw(
        `${position} q; dashed: the reference.${learning_of(run, settings)}`,
        [...lines(run.q, "q"), ...lines(run.reference, "ξ", {dash: [6, 4], width: 1})], with_unit("q", units.q));
    draw("velocity.", lines(run.v, "v"), with_unit("v", units.v));
    draw(
        "control input.", lines(run.u, "u", {steps: settings.type !== "proportional", width: 1.2}),
        with_unit("u", units.u));
  };
  const adaptive = [...runs.keys()].filter(i => runs[i].points), first = adaptive[0] ?? 0;
  for (const i of runs.length > 1 ? [first, adaptive[1] ?? (first + 1) % runs.length] : [0]) {
    const column = element("div");
    pair.append(column);
    choice(column, "Controller", runs.map(r => r.name), (k, body) => show(runs[k], body), i);
  }
  part.append(paragraph(kPlotHelp, "soft hint"));
};

// The settings of the paper's Table 1.
const task = (place, study) => {
  const s = study.spec,
        list = x =>
            Array.isArray(x) ? (x.length === 1 ? number(x[0]) : `(${x.map(v => number(v)).join(", ")})`) : number(x);
  const facts = [
    [
      "plant",
      words(study.plant) +
          Object.entries(s.model.parameters || {})
              .filter(([_, v]) => Array.isArray(v) ? v.some(x => x !== 0) : typeof v === "number" && v !== 0)
              .map(([k, v]) => `, ${words(k)} ${list(v)}`)
              .join("")
    ],
    ["x(0)", `${list(s.initial_state.position)}, ${list(s.initial_state.velocity)}`],
    ["duration", `${number(s.duration)} s`], ["control period Δu", `${number(s.control_period)} s`],
    ["w1, w2", `${number(s.inner_law.position_weight)}, ${number(s.inner_law.velocity_weight)}`]
  ];
  if (s.reference.type === "setpoint") facts.splice(2, 0, ["set-point ξ", list(s.reference.position)]);
  if (s.learner)
    facts.push(["learning period Δl", `${number(s.learner.period)} s`], [
      "thresholds of var a, var log b", `${number(s.learner.drift_threshold)}, ${number(s.learner.gain_threshold)}`
    ]);
  place.append(element(
      "dl", {class: "facts"},
      ...facts.map(([k, v]) => element("div", {}, element("dt", {}, k), element("dd", {}, v)))));
};

const panel = (study, place, index) => {
  const time = clock();
  if (study.description) place.append(paragraph(study.description));
  task(place, study);
  for (const row of failed(study)) place.append(paragraph(`${row.controller} failed: ${row.reason}`, "violated"));
  comparison(place, study);
  evolution(place, study, time, "study" + index);
  animation(place, study, time);
  learned(place, study);
  origin(place, title_of(study), study);
};

const many = (n, what, whats = what + "s") => `${n} ${n === 1 ? what : whats}`;
const told = () => {
  const runs = data.studies.flatMap(s => s.rows), bad = data.studies.flatMap(failed).length;
  const outcome = bad ? `${runs.length - bad} succeeded, ${bad} failed` : "all succeeded";
  const cells = data.published ? data.published.cells : [], held = cells.filter(c => c.ok === "yes").length;
  return `${many(data.studies.length, "study", "studies")}, ${many(runs.length, "run")}: ${outcome}.` +
      (cells.length ? ` ${held} of ${cells.length} cells of ${data.published.name} hold.` : "");
};

main.append(paragraph(told(), "verdict"));
if (data.published) published_table(main);
if (data.studies.length > 1) {
  const drawn = data.studies.filter(s => s.drawn), part = section(main, "Studies");
  const sweep = new Set(data.studies.map(s => s.name)).size === 1;
  if (data.studies.some(s => Object.keys(s.point).length)) part.append(runs_table("All runs", data.studies));
  if (drawn.length < data.studies.length) {
    const text =
        `Figures are of the first ${drawn.length} studies; the report of a point's own folder shows the others.`;
    part.append(paragraph(text, "soft"));
  }
  tabs(part, "Study", drawn.map(s => sweep && point_of(s) || title_of(s)), (i, place) => panel(drawn[i], place, i));
} else {
  panel(data.studies[0], section(main, "Results"), 0);
}
begin();
