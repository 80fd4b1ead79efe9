// The machine in motion: one small picture per controller, all at the same time of one clock.

// Where the joints are, in metres, y downwards, for positions q; `reach` is the farthest from the origin.
const machines = {
  pendulum: p => ({reach: p.length, joints: q => [[0, 0], [p.length * Math.sin(q[0]), p.length * Math.cos(q[0])]]}),
  two_link_arm: p => ({
    reach: p.length1 + p.length2,
    joints: q => {
      const elbow = [p.length1 * Math.sin(q[0]), p.length1 * Math.cos(q[0])];
      return [
        [0, 0], elbow, [elbow[0] + p.length2 * Math.sin(q[0] + q[1]), elbow[1] + p.length2 * Math.cos(q[0] + q[1])]
      ];
    }
  }),
  planar_arm: p => ({
    reach: p.length.reduce((sum, l) => sum + l, 0),
    joints: q => {
      const points = [[0, 0]];
      let angle = 0;
      p.length.forEach((l, i) => {
        angle += q[i];
        points.push([points[i][0] + l * Math.sin(angle), points[i][1] + l * Math.cos(angle)]);
      });
      return points;
    }
  }),
  mass: (_, runs) => ({
    reach: 1.15 * Math.max(...range(runs.flatMap(r => [r.q[0], r.reference[0]])).map(Math.abs), 1e-6),
    rail: true,
    joints: q => [[q[0], 0]]
  }),
};

const clock = () => ({
  time: null,
  listeners: new Set(),
  set(t) {
    this.time = t;
    this.listeners.forEach(f => f(t));
  }
});

// The index of the last sample at or before t.
const sample_at = (times, t) => {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= t)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
};

const animation = (place, study, clock) => {
  const make = machines[study.plant], runs = study.runs;
  if (!make || !runs.length) return;
  const part = section(place, "Motion", "h3"), machine = make(study.spec.model.parameters, runs);
  const end = Math.max(...runs.map(r => r.t.at(-1))), size = 100, scale = x => size * x / (1.18 * machine.reach);
  const path = points => pen(points.map(p => scale(p[0])), points.map(p => scale(p[1])));
  const kTrail = 1.5;  // seconds

  const views = runs.map(run => {
    const high = machine.rail ? 34 : size;
    const trail = element("path", {class: "trail"}), target = element("path", {class: "target"}),
          rod = element("path", {class: "rod"});
    const tip = element("circle", {r: 7, class: "tip"}), said = element("span", {class: "soft"});
    const svg = element(
        "svg", {viewBox: `${- size} ${- high} ${2 * size} ${2 * high}`, role: "img", class: "machine"},
        machine.rail ? element("line", {x1: -size, x2: size, y1: 9, y2: 9, class: "axis"}) :
                       element("circle", {r: scale(machine.reach), class: "reach"}),
        trail, target, rod, machine.rail ? "" : element("circle", {r: 3, class: "pivot"}), tip);
    const place_at = t => {
      const i = sample_at(run.t, t), next = Math.min(i + 1, run.t.length - 1);
      const share = next > i ? Math.max(0, Math.min(1, (t - run.t[i]) / (run.t[next] - run.t[i]))) : 0;
      return {i, q: run.q.map(q => q[i] + share * (q[next] - q[i]))};
    };
    const show = t => {
      const {i, q} = place_at(t), joints = machine.joints(q), hand = joints.at(-1);
      const learning = run.probing.some(p => t >= p[0] && t < p[1] + 0.1);  // a little longer: an instant is not seen
      rod.setAttribute("d", path(joints));
      target.setAttribute(
          "d",
          path(
              machine.rail ?
                  [[run.reference[0][i], -0.2 * machine.reach], [run.reference[0][i], 0.08 * machine.reach]] :
                  machine.joints(run.reference.map(r => r[i]))));
      tip.setAttribute("cx", scale(hand[0]));
      tip.setAttribute("cy", scale(hand[1]));
      tip.classList.toggle("learning", learning);
      const steps = 24, from = Math.max(run.t[0], t - kTrail);
      trail.setAttribute(
          "d",
          machine.rail ?
              "" :
              path(Array.from(
                  {length: steps + 1}, (_, k) => machine.joints(place_at(from + (t - from) * k / steps).q).at(-1))));
      const names = q.map(
                         (x, j) => `q${q.length > 1 ? j + 1 : ""} = ${x.toFixed(2).replace("-", "−")}${
                             study.units.q ? " " + study.units.q : ""}`)
                        .join(", ");
      said.textContent = names + (t > run.t.at(-1) + 1e-9 ? ", ended" : learning ? ", learning" : "");
      svg.setAttribute("aria-label", `${words(study.plant)} under ${run.name} at ${t.toFixed(2)} s: ${names}.`);
    };
    return {show, node: element("div", {}, element("h4", {}, run.name), svg, said)};
  });

  const slider = element("input", {
    type: "range",
    min: 0,
    max: end,
    step: "any",
    "aria-label": "time (s)",
    oninput: () => {
      stop();
      go(Number(slider.value));
    },
    onkeydown: event => {  // half a second a step: "any" leaves the step to the browser
      const step =
          {ArrowRight: 0.5, ArrowUp: 0.5, ArrowLeft: -0.5, ArrowDown: -0.5, PageUp: 2, PageDown: -2}[event.key];
      if (step) {
        event.preventDefault();
        stop();
        go(Math.max(0, Math.min(end, clock.time + step)));
      }
    }
  });
  const shown = element("output", {}), calm = matchMedia("(prefers-reduced-motion: reduce)");
  const speed = element(
      "select", {"aria-label": "speed"}, ...[0.5, 1, 2, 5].map(s => element("option", {value: String(s)}, s + " ×")));
  speed.value = "2";
  const button = element("button", {type: "button", onclick: () => playing ? stop() : play()});
  let playing = 0, last = 0;
  const go = t => {
    slider.value = String(t);
    slider.setAttribute("aria-valuetext", t.toFixed(1) + " s");
    shown.textContent = t.toFixed(2) + " s";
    views.forEach(view => view.show(t));
    clock.set(t);
  };
  const name_button = () => button.replaceChildren(playing ? "❚❚ pause" : "▶ play");
  const stop = () => {
    cancelAnimationFrame(playing);
    playing = 0;
    name_button();
  };
  const frame = now => {
    const passed = (now - last) / 1000 * Number(speed.value),
          pause = calm.matches ? 1 : 0;  // without motion: stills, a second apart
    if (passed >= pause) {
      last = now;
      go(Math.min(end, clock.time + passed));
    }
    if (clock.time >= end) {
      stop();
      return;
    }
    playing = requestAnimationFrame(frame);
  };
  const play = () => {
    if (clock.time >= end) go(0);
    last = performance.now();
    playing = requestAnimationFrame(frame);
    name_button();
  };
  name_button();
  figure(
      part,
      element(
          "div", {}, element("div", {class: "machines"}, ...views.map(view => view.node)),
          element("div", {class: "player"}, button, slider, shown, speed)),
      "The machine under each controller at the time of the slider; dashed: where it should be. An orange disc marks learning. The same time is marked in the plots.");
  go(end);
};
