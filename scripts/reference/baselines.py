#!/usr/bin/python3
"""Reference numbers for the paper's baselines P1 and P100 and for the oracle, by SciPy: tests/reference/baselines.json.

    /usr/bin/python3 scripts/reference/baselines.py      Debian: python3-scipy

Shares no code with the project. Pendulum of Calliess et al. 2013, Table 1, g = 9.81:

    q'' = a + b u,   a = -(g/l) sin q - r/(m l^2) q',   b = 1/(m l^2)
    P_k:    u = k (w1 (pi - q) - w2 q')
    oracle: u = (w1 (pi - q) - w2 q' - a)/b

each in continuous time and with u held over 0.01 s. The energies are integrated along with the state (DOP853, relative
tolerance 1e-11), and summed once more as the right-end Riemann sum h (u(h)^2 + u(2h)^2 + ... + u(t_f)^2), h = 5e-4 s;
in sampled time u(t) is the input held from t on.
"""

import json
import platform
from pathlib import Path

import numpy as np
import scipy
from scipy.integrate import solve_ivp

GRAVITY = 9.81  # m/s^2
START = (0.0, -2.0)
GOAL = (np.pi, 0.0)
HOLD = 0.01  # s, the paper's Delta_u
RIEMANN = 5e-4  # s
RTOL, ATOL = 1e-11, 1e-12
OUTPUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "baselines.json"

EXPERIMENTS = {  # Table 1
    "exp1": {"length": 1.0, "friction": 1.0, "mass": 0.5, "weights": (1.0, 1.0), "duration": 20.0},
    "exp2": {"length": 1.0, "friction": 0.5, "mass": 4.0, "weights": (2.0, 2.0), "duration": 15.0},
    "exp3": {"length": 1.0, "friction": 0.5, "mass": 4.0, "weights": (2.0, 2.0), "duration": 20.0},
}
PAPER = {  # Table 2: energy, squared error
    ("exp1", "P1"): (134, 137), ("exp1", "P100"): (644, 10),
    ("exp2", "P1"): (552, 139), ("exp2", "P100"): (11942, 10),
    ("exp3", "P1"): (730, 184), ("exp3", "P100"): (11942, 10),
}


def drift(x, e):
    return -GRAVITY / e["length"] * np.sin(x[0]) - e["friction"] / (e["mass"] * e["length"] ** 2) * x[1]


def gain(e):
    return 1.0 / (e["mass"] * e["length"] ** 2)


def proportional(k):
    return lambda x, e: k * (e["weights"][0] * (GOAL[0] - x[0]) + e["weights"][1] * (GOAL[1] - x[1]))


def oracle(x, e):
    return (proportional(1.0)(x, e) - drift(x, e)) / gain(e)


def squared_error(x):
    return (x[0] - GOAL[0]) ** 2 + (x[1] - GOAL[1]) ** 2


def integrate(e, input_at, span, y, times):
    """y = (q, q', integral u^2, integral |x - goal|^2)."""

    def slope(_, y):
        u = input_at(y)
        return [y[1], drift(y, e) + gain(e) * u, u * u, squared_error(y)]

    solution = solve_ivp(slope, span, y, method="DOP853", rtol=RTOL, atol=ATOL, t_eval=times)
    if not solution.success:
        raise SystemExit(f"solve_ivp: {solution.message}")
    return solution.y


def continuous(e, law):
    """Final y, and the input at 0, h, 2h, ..., t_f."""
    count = round(e["duration"] / RIEMANN)
    times = np.arange(count + 1) * e["duration"] / count
    y = integrate(e, lambda y: law(y, e), (0.0, e["duration"]), [*START, 0.0, 0.0], times)
    return y[:, -1], law(y, e)


def sampled(e, law):
    """The same with u held over HOLD."""
    y = np.array([*START, 0.0, 0.0])
    inputs = []
    for _ in range(round(e["duration"] / HOLD)):
        u = law(y, e)
        inputs += [u] * round(HOLD / RIEMANN)
        y = integrate(e, lambda _: u, (0.0, HOLD), y, None)[:, -1]
    return y, np.array([*inputs, law(y, e)])


def main():
    rows = []
    for name, e in EXPERIMENTS.items():
        for controller, law in {"P1": proportional(1.0), "P100": proportional(100.0), "oracle": oracle}.items():
            for time, simulate in {"continuous": continuous, "sampled": sampled}.items():
                y, inputs = simulate(e, law)
                paper = PAPER.get((name, controller))
                rows.append({
                    "experiment": name,
                    "controller": controller,
                    "time": time,
                    "energy": float(y[2]),
                    "squared_error": float(y[3]),
                    "end_state": [float(y[0]), float(y[1])],
                    "energy_right_riemann": float(RIEMANN * np.sum(inputs[1:] ** 2)),
                    **({"paper_energy": paper[0], "paper_squared_error": paper[1]} if paper else {}),
                })
                print("{experiment} {controller:6} {time:10} energy {energy:.6f}, "
                      "right Riemann {energy_right_riemann:.6f}, squared error {squared_error:.6f}, "
                      "end {end_state}".format(**rows[-1]), f"paper {paper}")

    document = {
        "origin": {
            "script": "scripts/reference/baselines.py",
            "method": "SciPy solve_ivp, DOP853, energies integrated along with the state",
            "relative_tolerance": RTOL,
            "absolute_tolerance": ATOL,
            "versions": {"python": platform.python_version(), "scipy": scipy.__version__, "numpy": np.__version__},
            "source_of_paper_numbers": "Calliess et al. 2013, Tables 1 and 2",
        },
        "gravity": GRAVITY,
        "start": START,
        "goal": GOAL,
        "hold": HOLD,
        "riemann_step": RIEMANN,
        "experiments": EXPERIMENTS,
        "runs": "ROWS",
    }
    lines = ",\n".join("  " + json.dumps(row, allow_nan=False) for row in rows)
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    OUTPUT.write_text(json.dumps(document, indent=1).replace('"ROWS"', f"[\n{lines}\n ]") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
