#!/usr/bin/env python3
"""What each cell of the paper's Table 2 does when one inferred setting moves a little.

    scripts/reference/cells.py [build/release/bayesctrl]

For each setting that configs/exp1.yaml to exp3.yaml mark as inferred: of the eight cells of SP1 and SP2 in that
experiment, how many hold (within the tolerances of configs/paper_table2.yaml) after a move of so many per cent, and
which are lost at the smallest move that loses one. Writes a Markdown table.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOVES = [-5, -2, -1, -0.2, 0.2, 1, 2, 5]  # per cent
WORDS = {"energy": "energy", "squared_error": "error", "drift_points": "points of a", "gain_points": "points of b"}
NUMBERS = {
    "exp1": {
        "learner.probing_input": 2.9,
        "belief.drift.noise_variance": 1e-4,
        "belief.drift.kernel.output_scale": 15,
        "belief.drift.kernel.length_scales.0": 9.1,
        "belief.drift.kernel.length_scales.1": 2.3,
        "belief.drift.kernel.shape": 0.66,
        "belief.input_gain.kernel.output_scale": 1.5,
        "belief.input_gain.kernel.length_scales.0": 16,
        "belief.input_gain.kernel.length_scales.1": 0.76,
        "belief.input_gain.kernel.shape": 3.1,
    },
    "exp2": {"learner.probing_input": 10},
    "exp3": {
        "learner.probing_input": 10,
        "tuning.evidence.bounds.output_scale.1": 50,
        "tuning.evidence.bounds.length_scale.1": 1000,
        "tuning.evidence.bounds.noise_variance.0": 1e-4,
    },
}
OTHERS = {  # what is not a number that moves
    "exp1": ["learner.schedule=from_start", "learner.hold_periods=2", "learner.hold_periods=4"],
    "exp2": ["learner.schedule=after_probe", "learner.hold_periods=2", "learner.hold_periods=4"],
    "exp3": ["learner.schedule=after_probe", "learner.hold_periods=2", "learner.hold_periods=4",
             "tuning.evidence.max_evaluations=20", "tuning.evidence.max_evaluations=25",
             "tuning.evidence.max_evaluations=40", "tuning.evidence.max_evaluations=60"],
}


def lost(program, experiment, change, folder):
    """Cells of SP1 and SP2 that do not hold, e.g. "SP2 energy"."""
    subprocess.run([program, "run", str(ROOT / "configs" / f"{experiment}.yaml"), "--set", change, "--out", folder,
                    "--no-report", "--quiet"], check=True)
    check = subprocess.run([program, "check", f"{folder}/{experiment}", "--against",
                            str(ROOT / "configs" / "paper_table2.yaml"), "--json"], capture_output=True, text=True)
    cells = [c for c in json.loads(check.stdout)["cells"] if c["controller"].startswith("SP")]
    assert len(cells) == 8, check.stderr
    return [f"{c['controller']} {WORDS[c['metric']]}" for c in cells if c["ok"] != "yes"]


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build" / "release" / "bayesctrl")
    print("| | setting | " + " | ".join(f"{m:+g} %" for m in MOVES) + " | lost first |")
    print("|---|---|" + "---:|" * len(MOVES) + "---|")
    with tempfile.TemporaryDirectory() as folder:
        for experiment, settings in NUMBERS.items():
            for path, value in settings.items():
                found = {m: lost(program, experiment, f"{path}={value * (1 + m / 100):.10g}", folder) for m in MOVES}
                first = next((found[m] for m in sorted(MOVES, key=abs) if found[m]), [])
                cells = " | ".join(str(8 - len(found[m])) for m in MOVES)
                print(f"| {experiment} | `{path}` | {cells} | {', '.join(first)} |", flush=True)
        print("\n| | instead | cells of eight | lost |\n|---|---|---:|---|")
        for experiment, changes in OTHERS.items():
            for change in changes:
                cells = lost(program, experiment, change, folder)
                print(f"| {experiment} | `{change}` | {8 - len(cells)} | {', '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
