#!/usr/bin/python3
"""Recordings of machines with concealed effects by a simulator that shares no code with the project, and what became of them.

    scripts/reference/foreign.py draw OUT --seed 7 --sets 6 --effects 4
    bayesctrl diagnose OUT/*/spec.yaml --out OUT/results --no-report
    scripts/reference/foreign.py score OUT

Each case is a pendulum or a slide with effects drawn from the laws below, each of 4 to 25 % of the torques' RMS; two
recordings to learn from and one held out; OUT/NAME/truth.json keeps what was concealed, and by how many noises the first
seconds would differ without it: at least ten. Classical Runge-Kutta in steps of 0.25 ms; a joint with dry friction sticks
and breaks away at instants found by bisection.

    --family open      the sum of five sines as input
             closed    a proportional-derivative controller follows such a sum: the input holds the sensor's noise
             free      no input: let go from another position each time
             short     one recording of 10 s at 50 Hz beside the one held out
             shaken    a stiff controller, and a torque that no law tells: 3 % of the others, for about 0.1 s
             quantised an encoder of 4096 counts a turn or 0.1 mm instead of noise
    --having KIND     one of the effects, in every case: also those that have to be asked for, which are not drawn else;
                      the spec then asks for them
    --asking KIND     the spec asks for it too, though nothing of the kind is concealed

`thermal_friction` comes with a recorded temperature that rises, to a tenth of a degree with as much noise.
"""

import argparse
import json
import math
import random
from pathlib import Path

STEP = 2.5e-4  # s
INPUT_EFFECTS = {"actuator_lag", "input_saturation", "input_dead_zone", "backlash", "input_gain", "recording_gain"}
DRY = {"coulomb_friction", "stribeck_friction", "load_dependent_friction", "load_stribeck_friction"}
ON_DEMAND = ["joint_elasticity", "elastic_load", "counterbalance", "warming_friction", "load_stribeck_friction",
             "recording_offset", "recording_gain"]
RECORDED = ["thermal_friction"]  # looked for where the temperature is recorded
ALIKE = [  # laws of which no more than one is drawn: a recording hardly tells them apart
    DRY, {"viscous_friction", "quadratic_drag", "asymmetric_friction"}, {"linear_spring", "cubic_spring"},
    {"input_saturation", "input_dead_zone", "backlash"}, {"input_gain", "added_inertia"},
    {"joint_elasticity", "actuator_lag"}, {"joint_elasticity", "added_inertia"},
    {"joint_elasticity", "elastic_load"}, {"elastic_load", "added_inertia"},
    {"thermal_friction", "warming_friction"}, {"counterbalance", "linear_spring"}, {"counterbalance", "cubic_spring"}, {"counterbalance", "cogging_torque"},
]
KINDS = ["coulomb_friction", "stribeck_friction", "load_dependent_friction", "viscous_friction", "quadratic_drag",
         "asymmetric_friction", "linear_spring", "cubic_spring", "constant_bias", "cogging_torque", "actuator_lag",
         "input_saturation", "input_dead_zone", "backlash", "input_gain", "added_inertia"]


def balance(p, q):
    """The torque of a spring between the end of a lever and a point of the frame."""
    at = (math.cos(q), math.sin(q))
    along = [p["anchor"] * c - a for c, a in zip((math.cos(p["centre"]), math.sin(p["centre"])), at)]
    length = math.hypot(*along)
    pull = p["stiffness"] / p["anchor"] * (length - p["rest"]) / length
    return pull * (at[0] * along[1] - at[1] * along[0])


class Machine:
    """inertia q'' = u - friction v - gravity sin q, and the effects {name: parameters}."""

    def __init__(self, rng, effects, family, turns):
        self.pendulum = rng.random() < 0.6 or family == "free" or turns
        if self.pendulum:
            self.mass, self.length, self.friction = rng.uniform(0.5, 2), rng.uniform(0.4, 1.2), rng.uniform(0.05, 0.3)
            self.inertia, self.gravity = self.mass * self.length ** 2, 9.81 * self.mass * self.length
        else:
            self.mass, self.friction = rng.uniform(1, 20), rng.uniform(0.5, 5)
            self.inertia, self.gravity = self.mass, 0.0
        self.effects = effects
        self.shaking = []  # torque from sample to sample
        self.time = 0.0
        self.recording = ""
        self.warming = (20.0, 0.0, 1.0)  # degrees Celsius at the start, how many more in the end, and within how many s

    def nominal(self):
        if self.pendulum:
            return {"length": self.length, "friction": self.friction, "mass": self.mass}
        return {"mass": self.mass, "friction": self.friction}

    def temperature(self):
        begin, more, within = self.warming
        return begin + more * (1 - math.exp(-self.time / within))

    def input(self, u, play):
        """What the motor gives before its lag, and where the play is now."""
        e = self.effects
        if "input_gain" in e:
            u *= e["input_gain"]["gain"]
        if "recording_gain" in e and e["recording_gain"]["recording"] == self.recording:
            u *= e["recording_gain"]["gain"]
        if "backlash" in e:
            play = min(max(play, u - e["backlash"]["width"]), u + e["backlash"]["width"])
            u = play
        if "input_dead_zone" in e:
            u = math.copysign(max(abs(u) - e["input_dead_zone"]["width"], 0.0), u)
        if "input_saturation" in e:
            u = max(-e["input_saturation"]["limit"], min(e["input_saturation"]["limit"], u))
        return u, play

    def torque(self, q, v, u):
        """All but dry friction."""
        e = self.effects
        f = u + self.shake - self.friction * v - self.gravity * math.sin(q)
        for name, p in e.items():
            if name == "viscous_friction":
                f -= p["coefficient"] * v
            elif name == "quadratic_drag":
                f -= p["coefficient"] * v * abs(v)
            elif name == "asymmetric_friction":
                f -= (p["forward"] if v > 0 else p["backward"]) * v
            elif name == "linear_spring":
                f -= p["stiffness"] * (q - p.get("centre", 0.0))
            elif name == "cubic_spring":
                f -= p["stiffness"] * q ** 3
            elif name == "constant_bias":
                f += p["torque"]
            elif name == "cogging_torque":
                f += p["amplitude"] * math.sin(p["order"] * q + p["phase"])
            elif name == "warming_friction":
                f -= p["coefficient"] * math.exp(-self.time / p["time_constant"]) * v
            elif name == "thermal_friction":
                f -= p["coefficient"] * math.exp((20 - self.temperature()) / p["scale"]) * v
            elif name == "counterbalance":
                f += balance(p, q)
        return f

    def dry(self, q, v, u):
        """Magnitude of dry friction at speed v, and what it holds at rest."""
        e = self.effects
        if "coulomb_friction" in e:
            return (e["coulomb_friction"]["level"],) * 2
        if "stribeck_friction" in e:
            p = e["stribeck_friction"]
            return p["coulomb"] + (p["static"] - p["coulomb"]) * math.exp(-(v / p["velocity"]) ** 2), p["static"]
        if "load_dependent_friction" in e or "load_stribeck_friction" in e:
            springs = e.get("linear_spring", {}).get("stiffness", 0.0) * q + e.get("cubic_spring", {}).get("stiffness", 0.0) * q ** 3
            if "counterbalance" in e:
                springs -= balance(e["counterbalance"], q)
            load = abs(u + self.gravity * math.sin(q) + springs)
            if "load_dependent_friction" in e:
                return (e["load_dependent_friction"]["k"] * load,) * 2
            p = e["load_stribeck_friction"]
            return (p["k"] + (p["static"] - p["k"]) * math.exp(-(v / p["velocity"]) ** 2)) * load, p["static"] * load
        return 0.0, 0.0

    def run(self, start, command, seconds, rate):
        """Positions and inputs at the samples; command(k, q, v) is held from sample k to the next."""
        inertia = self.inertia + self.effects.get("added_inertia", {}).get("inertia", 0.0)
        lag = self.effects.get("actuator_lag", {}).get("time_constant", 0.0)
        substeps = max(1, round(1 / rate / STEP))
        h = 1 / rate / substeps
        q, v = start
        self.shake = 0.0
        u0 = command(0, q, v)
        motor, play = self.input(u0, u0)
        sign = 0 if v == 0 else int(math.copysign(1, v))
        samples = []
        spring = self.effects.get("joint_elasticity")
        # What pushes: the torque of the motor behind its lag and, where it pushes through a spring, by how much the
        # motor is ahead of the joint and its speed; the same of a load that the joint takes along.
        load = self.effects.get("elastic_load")
        push = (motor, motor / spring["stiffness"] if spring else 0.0, v, 0.0, v)

        def through(v, push):
            """The torque on the joint."""
            if not spring:
                return push[0]
            return spring["stiffness"] * push[1] + spring["damping"] * (push[2] - v)

        def carried(v, push):
            """The torque of the load on the joint."""
            return load["stiffness"] * push[3] + load["damping"] * (push[4] - v) if load else 0.0

        def pushing(v, push, target):
            """Its change, in a joint of that speed."""
            lagging = (target - push[0]) / lag if lag else 0.0
            motor = (push[2] - v, (push[0] - through(v, push)) / spring["inertia"]) if spring else (0.0, 0.0)
            return lagging, *motor, *((push[4] - v, -carried(v, push) / load["inertia"]) if load else (0.0, 0.0))

        def slope(x, target, sign):
            q, v, push = x[0], x[1], x[2:]
            u = through(v, push)
            # the load on the bearings is the motor's torque, whatever the spring passes on
            friction = sign * self.dry(q, v, push[0])[0]
            return v, (self.torque(q, v, u) + carried(v, push) - friction) / inertia, *pushing(v, push, target)

        def step(x, target, sign, h):
            a = slope(x, target, sign)
            b = slope(tuple(x + h / 2 * i for x, i in zip(x, a)), target, sign)
            c = slope(tuple(x + h / 2 * i for x, i in zip(x, b)), target, sign)
            d = slope(tuple(x + h * i for x, i in zip(x, c)), target, sign)
            return tuple(x + h / 6 * (i + 2 * j + 2 * k + l) for x, i, j, k, l in zip(x, a, b, c, d))

        sticks = any(name in DRY for name in self.effects)
        for k in range(int(seconds * rate) + 1):
            u = command(k, q, v)
            self.shake = self.shaking[k] if self.shaking else 0.0
            samples.append((k / rate, q, u))
            target, play = self.input(u, play)
            if not lag:
                push = (target, *push[1:])
            for substep in range(substeps):
                self.time = k / rate + (substep + 0.5) * h
                rest = h
                for _ in range(8):
                    if sticks and sign == 0:
                        f = self.torque(q, 0.0, through(0.0, push)) + carried(0.0, push)
                        holds = self.dry(q, 0.0, push[0])[1]
                        if abs(f) <= holds:
                            if spring or load:
                                middle = tuple(p + rest / 2 * d for p, d in zip(push, pushing(0.0, push, target)))
                                push = tuple(p + rest * d for p, d in zip(push, pushing(0.0, middle, target)))
                            elif lag:
                                push = (target + (push[0] - target) * math.exp(-rest / lag), *push[1:])
                            break
                        sign = 1 if f > 0 else -1
                    then = step((q, v, *push), target, sign, rest)
                    if not sticks or then[1] * sign >= 0:
                        q, v, *push = then
                        break
                    low, high = 0.0, rest  # comes to rest within the step
                    for _ in range(40):
                        middle = (low + high) / 2
                        if step((q, v, *push), target, sign, middle)[1] * sign >= 0:
                            low = middle
                        else:
                            high = middle
                    q, _, *push = step((q, v, *push), target, sign, low)
                    v, sign, rest = 0.0, 0, rest - low
                    if rest <= 1e-12:
                        break
        return samples


def draw_effects(rng, count, torque, speed, span, family, having):
    """Parameters of `count` laws, each of 4 to 25 % of the torque."""
    kinds, chosen = list(KINDS), []
    if family == "free":
        kinds = [k for k in kinds if k not in INPUT_EFFECTS and k != "load_dependent_friction"]
    rng.shuffle(kinds)
    for kind in having + [k for k in kinds if k not in having]:
        if len(chosen) == count:
            break
        if all(not ({kind, other} <= group) for group in ALIKE for other in chosen):
            chosen.append(kind)
    effects = {}
    for kind in chosen:
        s = rng.uniform(0.04, 0.25) * torque
        effects[kind] = {
            "coulomb_friction": lambda: {"level": s},
            "stribeck_friction": lambda: {"coulomb": 0.7 * s, "static": 1.3 * s, "velocity": rng.uniform(0.05, 0.2) * speed},
            "load_dependent_friction": lambda: {"k": rng.uniform(0.05, 0.25)},
            "joint_elasticity": lambda: {"inertia": None, "frequency": rng.uniform(12, 50), "ratio": rng.uniform(0.03, 0.4)},
            "elastic_load": lambda: {"inertia": None, "frequency": rng.uniform(12, 50), "ratio": rng.uniform(0.03, 0.4)},
            "counterbalance": lambda: {"stiffness": 2 * s, "anchor": rng.uniform(1.3, 3), "rest": rng.uniform(0.1, 0.9), "centre": rng.uniform(-3, 3)},
            "warming_friction": lambda: {"coefficient": 2 * s / speed, "time_constant": rng.uniform(3, 15)},
            "thermal_friction": lambda: {"coefficient": 2 * s / speed, "scale": rng.uniform(8, 30)},
            "load_stribeck_friction": lambda: (lambda k: {"k": k, "static": k * rng.uniform(1.4, 2.2), "velocity": rng.uniform(0.05, 0.2) * speed})(rng.uniform(0.05, 0.2)),
            "viscous_friction": lambda: {"coefficient": s / speed},
            "quadratic_drag": lambda: {"coefficient": s / speed ** 2},
            "asymmetric_friction": lambda: {"forward": 0.5 * s / speed, "backward": 1.5 * s / speed},
            "linear_spring": lambda: {"stiffness": s / span},
            "cubic_spring": lambda: {"stiffness": s / span ** 3},
            "constant_bias": lambda: {"torque": s},
            "cogging_torque": lambda: {"amplitude": s, "order": min(28.0, rng.uniform(3, 12) / max(span, 0.3)), "phase": rng.uniform(0, 6.28)},
            "actuator_lag": lambda: {"time_constant": rng.uniform(0.01, 0.06)},
            "input_saturation": lambda: {"limit": rng.uniform(1.0, 1.5) * torque},
            "input_dead_zone": lambda: {"width": s},
            "backlash": lambda: {"width": s},
            "input_gain": lambda: {"gain": rng.choice([0.8, 0.9, 1.1, 1.2])},
            "recording_gain": lambda: {"gain": rng.choice([0.8, 0.9, 1.1, 1.2]), "recording": "train1"},
            "recording_offset": lambda: {"angle": rng.choice([-1, 1]) * rng.uniform(0.03, 0.15), "recording": rng.choice(["train1", "train2"])},
            "added_inertia": lambda: {"inertia": None},
        }[kind]()
    return effects


def sines(rng, amplitude, low, high):
    parts = [(rng.uniform(0.4, 1), rng.uniform(low, high), rng.uniform(0, 6.28)) for _ in range(5)]
    scale = amplitude / math.sqrt(sum(a * a for a, _, _ in parts) / 2)
    return lambda t: scale * sum(a * math.sin(6.2832 * f * t + p) for a, f, p in parts)


def wandering(rng, deviation, time, count, rate):
    """An Ornstein-Uhlenbeck process at samples."""
    keep, values = math.exp(-1 / (rate * time)), [deviation * rng.gauss(0, 1)]
    while len(values) < count:
        values.append(keep * values[-1] + deviation * math.sqrt(1 - keep * keep) * rng.gauss(0, 1))
    return values


def sizes(machine, rows, seconds, rate, unit):
    """RMS by which a recording would differ in its first seconds without each effect, in units of the noise."""
    result, (_, q0, _), (_, q1, _) = {}, rows[0], rows[1]
    start, command = (q0, (q1 - q0) * rate), lambda k, q, v: rows[k][2]
    machine_with, all_effects = machine.run(start, command, seconds, rate), machine.effects
    for name in all_effects:
        if name == "recording_offset":
            result[name] = abs(all_effects[name]["angle"]) / unit
            continue
        machine.effects = {n: p for n, p in all_effects.items() if n != name}
        without = machine.run(start, command, seconds, rate)
        result[name] = math.sqrt(sum((a[1] - b[1]) ** 2 for a, b in zip(machine_with, without)) / len(without)) / unit
    machine.effects = all_effects
    return result


def draw(options):
    for index in range(options.sets):
        attempt = 0
        while not draw_one(options, index, attempt):  # until every effect shows
            attempt += 1


def draw_one(options, index, attempt):
    rng = random.Random(f"{options.seed} {options.family} {index} {attempt}")
    machine = Machine(rng, {}, options.family, not {"counterbalance", "recording_offset"}.isdisjoint(options.having))
    torque = 0.6 * machine.gravity if machine.pendulum else machine.inertia * rng.uniform(1, 3)  # RMS
    speed, span = (2.0, 0.8) if machine.pendulum else (0.5, 0.3)
    machine.effects = draw_effects(rng, options.effects, torque, speed, span, options.family, options.having)
    if "added_inertia" in machine.effects:
        machine.effects["added_inertia"]["inertia"] = rng.uniform(0.05, 0.3) * machine.inertia
    for name in [n for n in ("joint_elasticity", "elastic_load") if n in machine.effects]:
        drawn = machine.effects[name]
        inertia, frequency = rng.uniform(0.05, 0.5) * machine.inertia, drawn["frequency"]
        machine.effects[name] = {"stiffness": inertia * frequency ** 2, "damping": 2 * drawn["ratio"] * frequency * inertia, "inertia": inertia}
    short = options.family == "short"
    rate, seconds = (50, 10) if short else (options.rate, options.seconds)
    noise = 0.0 if options.family == "quantised" else options.noise * span
    folder = options.out / f"{options.family}_{index:02}"
    folder.mkdir(parents=True, exist_ok=True)
    recorded = any(k in RECORDED for k in options.having + options.asking)
    names = ["train1", "held1"] if short else ["train1", "train2", "held1"]
    for name in names:
        start = (rng.uniform(-0.5, 0.5) * span, rng.uniform(-0.5, 0.5) * speed)
        if options.family == "free":
            start = (rng.choice([-1, 1]) * rng.uniform(0.8, 2.2), 0.0)
            command = lambda k, q, v: 0.0
        elif options.family in ("closed", "shaken"):
            reference = sines(rng, 0.7 * span, 0.1, 0.8)
            stiff = options.family == "shaken"
            kp = (400 if stiff else 25) * machine.inertia
            kd = (40 if stiff else 8) * machine.inertia
            if stiff:
                machine.shaking = wandering(rng, 0.03 * torque, 0.1, int(seconds * rate) + 1, rate)
            command = lambda k, q, v: kp * (reference(k / rate) - q - noise * rng.gauss(0, 1)) - kd * v
        else:
            wave = sines(rng, torque, 0.1, 1.5)
            command = lambda k, q, v: wave(k / rate)
        if recorded:  # each recording begins where the one before may have left it, or cooler
            machine.warming = (rng.uniform(15, 35), rng.uniform(10, 25), rng.uniform(0.3, 1.0) * seconds)
        machine.recording = name
        rows = machine.run(start, command, seconds, rate)
        count = 2 * math.pi / 4096 if machine.pendulum else 1e-4
        if name == "train1":
            size = sizes(machine, rows, 5.0, rate, noise or count / math.sqrt(12))
            if min(size.values(), default=math.inf) < 10.0:
                return False
        with open(folder / f"{name}.csv", "w") as file:
            file.write("t,q,u,T\n" if recorded else "t,q,u\n")
            for t, q, u in rows:
                machine.time = t
                seen = round(q / count) * count if options.family == "quantised" else q + noise * rng.gauss(0, 1)
                if machine.effects.get("recording_offset", {}).get("recording") == name:
                    seen += machine.effects["recording_offset"]["angle"]
                celsius = f",{machine.temperature() + 0.1 * rng.gauss(0, 1):.1f}" if recorded else ""
                file.write(f"{t:.6f},{seen:.9f},{u:.7f}{celsius}\n")
    held = [f"{n}.csv" for n in names if n.startswith("held")]
    train = [f"{n}.csv" for n in names if n.startswith("train")]
    asked = [k for k in ON_DEMAND if k in options.having + options.asking]
    parameters = ", ".join(f"{k}: {v:.9g}" for k, v in machine.nominal().items())
    (folder / "spec.yaml").write_text(
        f"name: {folder.name}\nmodel:\n  plant: {'pendulum' if machine.pendulum else 'mass'}\n"
        f"  parameters: {{{parameters}}}\nsignals: {{time: t, position: [q], input: [u]{', temperature: T' if recorded else ''}}}\n"
        f"recordings: [{', '.join(train)}]\nheld_out: [{', '.join(held)}]\n"
        + (f"effects: [{', '.join(['usual', *asked])}]\n" if asked else ""))
    (folder / "truth.json").write_text(json.dumps({"effects": machine.effects, "noises": size}, indent=1) + "\n")
    return True


def score(options):
    tally = {"cases": 0, "stated": 0, "right": 0, "true": 0, "found": 0, "certain": 0, "false": 0, "left_named": 0.0}
    verdicts = {}
    for truth_file in sorted(options.out.glob("*/truth.json")):
        name = truth_file.parent.name
        truth = set(json.loads(truth_file.read_text())["effects"])
        result = options.out / "results" / name / "diagnosis.json"
        if not result.exists():
            print(f"{name:16} no result; concealed {', '.join(sorted(truth))}")
            continue
        d = json.loads(result.read_text())
        listed = {e["name"]: e.get("inclusion") or 0.0 for e in d["explanation"]["effects"]}
        alike = [{label.replace("#", "@").split("@")[0] for label in group} for group in d.get("indistinguishable", [])]
        same = lambda a, b: a == b or any({a, b} <= group for group in alike)
        p = d["explanation"]["probability"] or 0.0
        missed = [t for t in truth if not any(same(t, e) for e in listed)]
        wrong = [e for e in listed if not any(same(t, e) for t in truth)]
        certain = [e for e, sure in listed.items() if sure >= 0.9]
        false = [e for e in certain if e in wrong]
        error = d["fit"]["train"]["after"] or 0.0
        left = error / max(d["fit"]["noise_floor"], 1e-12)
        verdicts[d["verdict"]] = verdicts.get(d["verdict"], 0) + 1
        tally["cases"] += 1
        tally["true"] += len(truth)
        tally["found"] += len([t for t in truth if any(same(t, e) for e in certain)])
        tally["certain"] += len(certain)
        tally["false"] += len(false)
        if d["verdict"] == "named" and p >= 0.9:
            tally["stated"] += 1
            tally["right"] += not missed and not wrong
            tally["left_named"] = max(tally["left_named"], left)
        print(f"{name:16} {d['verdict']:15} p {p:.3f}  left {left:6.2f} noises  missed {missed}  wrong "
              f"{[f'{e} {listed[e]:.2f}' for e in wrong]}  of {sorted(truth)}")
    print(f"{tally['cases']} cases: {verdicts}; stated >= 0.9 {tally['stated']}, right {tally['right']}; largest remainder "
          f"of those {tally['left_named']:.2f} noises; effects {tally['true']}, found with >= 0.9 {tally['found']}; "
          f"certain {tally['certain']}, false {tally['false']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["draw", "score"])
    parser.add_argument("out", type=Path)
    parser.add_argument("--having", action="append", default=[], choices=KINDS + ON_DEMAND + RECORDED)
    parser.add_argument("--asking", action="append", default=[], choices=ON_DEMAND + RECORDED)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sets", type=int, default=6)
    parser.add_argument("--effects", type=int, default=4)
    parser.add_argument("--family", choices=["open", "closed", "free", "short", "shaken", "quantised"], default="open")
    parser.add_argument("--rate", type=float, default=200.0, help="Hz")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--noise", type=float, default=1e-4, help="share of the motion's RMS")
    options = parser.parse_args()
    {"draw": draw, "score": score}[options.what](options)


main()
