// What was learned: error and deviation of a over the state space, and the posterior over log b.
const learned = (place, study) => {
  const views = study.runs.flatMap(
      run => (run.posterior || [])
                 .map((grid, joint) => ({run, grid, joint}))
                 .filter(v => v.grid.q.length > 1 && v.grid.v.length > 1));
  if (!views.length) return;
  const part = section(place, "What was learned", "h3"), joints = study.runs[0].q.length;
  choice(part, "Posterior of", views.map(v => v.run.name + (joints > 1 ? `, joint ${v.joint + 1}` : "")), (i, body) => {
    const {run, grid, joint} = views[i], u = study.units, name = run.name, none = {q: [], v: [], target: []};
    const of = process => {
      const p = (run.points || {})[process];
      return p ? {q: p.q[joint], v: p.v[joint], target: p.target} : none;
    };
    const motion = of(numbered("motion", joint, joints));  // where a and b are learned together
    const a = motion === none ? of(numbered("a", joint, joints)) : motion;
    const log_b = of(joints > 1 ? `log_b${joint + 1}${joint + 1}` : "log_b"), b = motion === none ? log_b : motion;
    const path = {q: run.q[joint], v: run.v[joint]};
    const labels = [with_unit(numbered("q", joint, joints), u.q), with_unit(numbered("v", joint, joints), u.v)];
    const cut = joints > 1 ? " The other joints rest at their reference." : "";
    // The share of the states at which both are known; NaN where there is none.
    const share = (errors, limits, factor = 1) => {
      const known = (limits || []).map((limit, k) => [errors[k], limit]).filter(p => p[0] !== null && p[1] !== null);
      return known.filter(([e, limit]) => e <= factor * limit).length / known.length;
    };
    const covered = share(grid.error_a, grid.sd_a, 2);
    const within = (errors, bounds) => {
      const held = share(errors, bounds), what = "its bound, which is to hold at every state at once";
      return isNaN(held) ? "" : ` The error is within ${what}, on ${percent(held)}.`;
    };
    const kept = typeof grid.bound_error === "number" ?
        ` Begun at its goal at rest, this loop stays within ${number(grid.bound_error, 3)}${
            u.q ? ` ${u.q}` : ""} of it.` :
                  "";
    const error_log_b =
        grid.mean_log_b.map((m, k) => m === null || grid.log_b[k] === null ? null : Math.abs(m - grid.log_b[k]));
    const pair = element("div", {class: "pair"});
    const draw = (key, title, caption, points, unit, over = [0]) =>
        map(pair, title, caption + cut, {q: grid.q, v: grid.v, values: grid[key], over}, labels, unit, path, points);
    // Differences far below what is known at best are none.
    const [least, most] = range([grid.mean_log_b]), [best] = range([grid.sd_log_b]), middle = (least + most) / 2;
    draw(
        "error_a", "|a(x) − E[a(x)]|",
        `${name}: error of the learned drift at the end. Stars: training points; white line: the way of the state.`, a,
        u.a);
    draw(
        "sd_a", "√var[a(x)]",
        `${name}: posterior standard deviation of the drift. The error is within two of them on ${
            percent(covered)} of the map.${within(grid.error_a, grid.bound_a)}${kept}`,
        a, u.a);
    draw(
        "mean_log_b", "E[log b(x)]", `${name}: posterior mean of the logarithm of the input gain.`, b, "",
        [middle - best, middle + best]);
    draw(
        "sd_log_b", "√var[log b(x)]",
        `${name}: its posterior standard deviation.${within(error_log_b, grid.bound_log_b)}`, b, "");
    body.append(pair);
    const caption = `${name}: posterior over log b at the velocity nearest zero, with its band of two standard ` +
        `deviations. Dashed: the truth. Stars: all training points.${cut}`;
    slice(pair, grid, caption, labels[0], log_b);
  });
};

// The posterior over log b along the positions.
const slice = (place, grid, caption, label, points) => {
  const row = grid.v.reduce((best, v, k) => Math.abs(v) < Math.abs(grid.v[best]) ? k : best, 0);
  const along = key => grid.q.map((_, i) => grid[key][i * grid.v.length + row]);
  const mean = along("mean_log_b"), sd = along("sd_log_b"), truth = along("log_b");
  const upper = mean.map((m, i) => m + 2 * sd[i]), lower = mean.map((m, i) => m - 2 * sd[i]);
  const [least, most] = range([upper, lower, truth, points.target]), room = 0.06 * (most - least || 1);
  const ends = list => range([list]).map(x => number(x, 3)).join(" to ");
  const alternative = `${caption} Mean ${ends(mean)}, standard deviation ${ends(sd)}, truth ${ends(truth)}.`;
  const frame = axes(alternative, [grid.q[0], grid.q.at(-1)], [least - room, most + room], [label, "log b"]);
  const px = grid.q.map(frame.px), line = values => pen(px, values.map(y => y === null ? null : frame.py(y)));
  frame.svg.prepend(element(
      "path",
      {d: pen([...px, ...[...px].reverse()], [...upper, ...[...lower].reverse()].map(frame.py)) + "Z", class: "band"}));
  frame.svg.append(element("path", {d: line(mean), class: "mean"}), element("path", {d: line(truth), class: "truth"}));
  stars(frame, points.q, points.target);
  figure(place, frame.svg, caption);
};
