#!/usr/bin/python3
"""Learning by the rules of Umlauft & Hirche (2020), beside which configs/event_triggered.yaml and time_triggered.yaml stand.

    scripts/reference/event_triggered.py      half a minute; no packages

S2: q'' = f(x) + g(x) u with f = 1 - sin q + 0.5 / (1 + exp(-0.1 v)), g = 1 + 0.5 sin(v / 2) known, from (3, 2), follows sin t
for 30 s with q'' wanted = -sin t - (e + e') - e'. f(x) itself is measured, with noise sd; a sample is taken when the process
(squared exponential, scale 5, lengths 5) has beta sd(x) > |e + e'|, beta = 7.
S1: neither f nor g is known (prior means 0 and 2, squared exponentials of scale 5, lengths 3, which they tune after each
sample and this does not); q'' is measured in the closed loop every 0.5 s, with noise 0.01, for 20 s, along a smooth step at
10 s. Shares no code with the project.
"""

import math
import random

STEP, DURATION, BETA, LEAST = 1e-3, 30.0, 7.0, 1e-5


def f(x):
    return 1 - math.sin(x[0]) + 0.5 / (1 + math.exp(-0.1 * x[1]))


def g(x):
    return 1 + 0.5 * math.sin(0.5 * x[1])


def squared_exponential(a, b, length):
    return 25 * math.exp(-0.5 * ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) / length**2)


def k(a, b):
    return squared_exponential(a, b, 5)


def of_both(a, b):
    """Covariance of f + g u at (q, v, u)."""
    return squared_exponential(a, b, 3) * (1 + a[2] * b[2])


class Process:
    def __init__(self, noise_variance, kernel):
        self.k, self.noise_variance, self.x, self.rows, self.z, self.weights = kernel, noise_variance, [], [], [], []

    def solve(self, column):
        v = []
        for row, c in zip(self.rows, column):
            v.append((c - sum(r * s for r, s in zip(row, v))) / row[-1])
        return v

    def add(self, x, y):
        row = self.solve([self.k(x, other) for other in self.x])
        pivot = self.k(x, x) + self.noise_variance - sum(r * r for r in row)
        row.append(math.sqrt(max(pivot, 1e-14)))
        self.z.append((y - sum(r * s for r, s in zip(row, self.z))) / row[-1])
        self.x.append(x)
        self.rows.append(row)
        n = len(self.x)
        self.weights = [0.0] * n
        for i in reversed(range(n)):
            rest = self.z[i] - sum(self.rows[j][i] * self.weights[j] for j in range(i + 1, n))
            self.weights[i] = rest / self.rows[i][i]

    def mean(self, x):
        return sum(w * self.k(x, other) for w, other in zip(self.weights, self.x))

    def deviation(self, x):
        return math.sqrt(max(25 - sum(v * v for v in self.solve([self.k(x, other) for other in self.x])), 0.0))


def advance(motion, x, t):
    """One step of the classical Runge-Kutta method."""

    def along(d, h):
        return x[0] + h * d[0], x[1] + h * d[1]

    a = motion(x, t)
    b = motion(along(a, STEP / 2), t + STEP / 2)
    c = motion(along(b, STEP / 2), t + STEP / 2)
    d = motion(along(c, STEP), t + STEP)
    return tuple(x[i] + STEP / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]) for i in (0, 1))


def s2(sd=1e-8):
    draw = random.Random(1)
    process = Process(max(sd * sd, 1e-12), k)
    x, t, squared, late, finished = (3.0, 2.0), 0.0, 0.0, 0.0, 0.0

    def error(x, t):
        return x[0] - math.sin(t), x[1] - math.cos(t)

    def motion(x, t):
        e, de = error(x, t)
        u = (-process.mean(x) - math.sin(t) - (e + de) - de) / g(x)
        return x[1], f(x) + g(x) * u

    while t < DURATION and len(process.x) < 200:
        filtered = max(abs(sum(error(x, t))), LEAST)
        if not process.x or BETA * process.deviation(x) > filtered:
            process.add(x, f(x) + sd * draw.gauss(0, 1))
        x = advance(motion, x, t)
        t += STEP
        e = math.hypot(*error(x, t))
        squared += STEP * e * e
        late = max(late, e) if t > DURATION - 10 else 0.0
    print(f"S2, noise {sd:g}: {len(process.x)} points by t = {t:.1f} s, squared error {squared:.4f}, largest of the last 10 s {late:.2g}")


def s1(sd=1e-2, duration=20.0, updates=40):
    draw = random.Random(1)
    process = Process(sd * sd, of_both)
    x, squared = (3.0, 2.0), 0.0

    def wanted(t):
        share = 1 / (1 + math.exp(min(20 * (t - 10), 700)))
        slope = -20 * share * (1 - share)
        return share, slope, -20 * slope * (1 - 2 * share)

    def error(x, t):
        return x[0] - wanted(t)[0], x[1] - wanted(t)[1]

    def control(x, t):
        e, de = error(x, t)
        drift = process.mean((*x, 0.0))
        gain = 2 + process.mean((*x, 1.0)) - drift
        return (-drift + wanted(t)[2] - (e + de) - de) / gain

    def motion(x, t):
        return x[1], f(x) + g(x) * control(x, t)

    for step in range(round(duration / STEP)):
        t = step * STEP
        if step % round(duration / updates / STEP) == 0:
            u = control(x, t)
            process.add((*x, u), f(x) + g(x) * u + sd * draw.gauss(0, 1) - 2 * u)
        x = advance(motion, x, t)
        e = math.hypot(*error(x, t + STEP))
        squared += STEP * e * e
    print(f"S1, noise {sd:g}: {len(process.x)} points, squared error {squared:.4f}, at the end {e:.2g}")


s1()
s2()
