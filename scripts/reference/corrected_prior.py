#!/usr/bin/env python3
"""What a diagnosis is worth to a learner, over hidden effects and noise.

For each: a pendulum with the effect is recorded for 20 s (`bayesctrl simulate`, noise added to its positions), diagnosed
against the nominal, and the model.yaml is the prior model of the learner `corrected` of configs/corrected_prior.yaml,
whose machine has the effect. A row: verdict, the standard deviation of a that model.yaml states, and of each controller
its data of a and b, squared error, energy and final error.

    scripts/reference/corrected_prior.py [--program build/release/bayesctrl] [--seed N]
"""

import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parents[2]
EFFECTS = [
    "type: coulomb_friction, level: 0.2",
    "type: coulomb_friction, level: 0.5",
    "type: stribeck_friction, coulomb: 0.2, static: 0.5, velocity: 0.3",
    "type: viscous_friction, coefficient: 0.3",
    "type: quadratic_drag, coefficient: 0.15",
    "type: linear_spring, stiffness: 1.0",
    "type: constant_bias, torque: 0.5",
    "type: input_gain, gain: 0.9",
    "type: added_inertia, inertia: 0.05",
    "type: input_dead_zone, width: 0.3",
    "type: actuator_lag, time_constant: 0.03",
    "type: input_delay, delay: 0.02",
]
SPEC = """name: found
model: {plant: pendulum, parameters: {length: 1, friction: 1, mass: 0.5, gravity: 9.81}}
signals: {time: t, position: q, input: u}
recordings: [recording.csv]
"""


def record(run, folder, effect, noise, generator):
    """recording.csv: the machine with this effect under a sum of sines, positions with noise."""
    times = [k / 100 for k in range(2000)]
    inputs = ["%g,%.6f" % (t, 2 * math.sin(1.3 * t) + 1.5 * math.sin(3.9 * t + 1)) for t in times]
    (folder / "u.csv").write_text("t,u\n" + "\n".join(inputs) + "\n")
    run("simulate", HERE / "configs/exp1.yaml", "--input", "u.csv", "--out", "motion.csv", "--set",
        f"model.effects=[{{{effect}}}]")
    with open(folder / "motion.csv") as file:
        rows = ["%s,%.9g,%s" % (r["t"], float(r["q"]) + generator.gauss(0, noise), r["u"]) for r in csv.DictReader(file)]
    (folder / "recording.csv").write_text("t,q,u\n" + "\n".join(rows) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=HERE / "build/release/bayesctrl")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    generator = random.Random(arguments.seed)
    print("effect,noise,verdict,sd_a," + ",".join(
        f"{c}_{m}" for c in ("oracle", "zero", "nominal", "corrected") for m in ("a", "b", "error", "energy", "final")))
    for effect in EFFECTS:
        for noise in (1e-4, 1e-3, 1e-2):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)

                def run(*words):
                    done = subprocess.run([arguments.program.resolve(), *words], cwd=folder, capture_output=True, text=True)
                    if done.returncode not in (0, 1):
                        raise SystemExit(done.stderr)

                record(run, folder, effect, noise, generator)
                (folder / "spec.yaml").write_text(SPEC)
                run("diagnose", "spec.yaml", "--no-report")
                found = json.loads((folder / "results/diagnose/found/diagnosis.json").read_text())
                model = (folder / "results/diagnose/found/model.yaml").read_text()
                deviation = float(model.split("uncertainty:")[1].split("drift: [")[1].split("]")[0])
                run("run", HERE / "configs/corrected_prior.yaml", "--no-report", "--set", f"model.effects=[{{{effect}}}]",
                    "--set", f"controllers.corrected.belief.prior_model={{file: {folder}/results/diagnose/found/model.yaml}}")
                summary = json.loads((folder / "results/corrected_prior/summary.json").read_text())["controllers"]
            cells = [r[m] for r in summary for m in ("drift_points", "gain_points", "squared_error", "energy", "final_error")]
            shown = ",".join("" if c is None else "%.4g" % c for c in cells)
            print(f'"{effect}",{noise:g},{found["verdict"]},{deviation:.2g},{shown}', flush=True)


if __name__ == "__main__":
    main()
