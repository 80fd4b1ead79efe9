#!/usr/bin/python3
"""Reference numbers for the Gaussian processes, from scikit-learn: tests/reference/gp.json and the benchmark's data.

    /usr/bin/python3 scripts/reference/gp_reference.py      Debian: python3-sklearn

Shares no code with the project. Kernel matrices come from scikit-learn's kernels; posterior, log marginal likelihood
and gradient from its GaussianProcessRegressor. `OnColumns` feeds a kernel the columns that matter, already divided by
their length scales: RationalQuadratic and Matern need it for one length scale per input, ExpSineSquared (a function of
the Euclidean distance) to be used one input at a time, and an infinite length scale is a column left out.

Every number is computed a second time from the formulas below in extended precision (80 bit), without scikit-learn; the
script stops unless both agree, and writes the largest relative differences, which say what tolerance a test may use.
"""

import json
import math
import platform
import re
from pathlib import Path

import numpy as np
import scipy
import sklearn
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor, kernels

SEED = 20131210
NOISE = 0.01  # noise variance
LOW, HIGH = np.array([-np.pi, -4.0]), np.array([np.pi, 4.0])
OUTPUT = Path(__file__).resolve().parents[2] / "tests" / "reference"
INF = float("inf")


# --- the data -------------------------------------------------------------------------------------------------------

def drift(x):
    """The pendulum of Exp. 1: -9.81 sin(x1) - 2 x2."""
    return -9.81 * np.sin(x[:, 0]) - 2.0 * x[:, 1]


def make_data():
    """30 inputs of which the first 1, 5, 30 are used; 12 queries: three are inputs, three are far away."""
    rng = np.random.default_rng(SEED)
    inputs = rng.uniform(LOW, HIGH, (30, 2))
    queries = np.vstack([inputs[[0, 3, 20]], rng.uniform(LOW, HIGH, (6, 2)), [[20.0, -30.0], [-1e3, 0.5], [0.5, 1e3]]])
    targets = drift(inputs) + 0.1 * rng.standard_normal(30)
    log_gain = -1.4 + 0.3 * np.cos(inputs[:, 0]) + 0.05 * rng.standard_normal(30)
    noise_variances = 10.0 ** rng.uniform(-4.0, 0.0, 30)
    return {"inputs": inputs, "targets": targets, "log_gain": log_gain, "noise_variances": noise_variances,
            "queries": queries}


def make_benchmark():
    """1100 rows x1, x2, y and 256 queries x1, x2."""
    rng = np.random.default_rng(SEED)
    inputs = rng.uniform(LOW, HIGH, (1100, 2))
    targets = drift(inputs) + 0.1 * rng.standard_normal(1100)
    return inputs, targets, rng.uniform(LOW, HIGH, (256, 2))


DATA = make_data()


# --- kernels by scikit-learn ----------------------------------------------------------------------------------------

class OnColumns(kernels.Kernel):
    """`base` on the given columns of the input, each divided by its scale; 1 everywhere when there is no column."""

    def __init__(self, base, columns, scales):
        self.base, self.columns, self.scales = base, columns, scales

    def _pick(self, x):
        return x[:, self.columns] / np.array(self.scales)

    def __call__(self, x, y=None, eval_gradient=False):
        if not self.columns:
            k = np.ones((len(x), len(x if y is None else y)))
        else:
            k = self.base(self._pick(x), None if y is None else self._pick(y))
        return (k, np.empty((len(x), len(x), 0))) if eval_gradient else k

    def diag(self, x):
        return np.ones(len(x))

    def is_stationary(self):
        return True


def sklearn_kernel(spec):
    """{"<kind>": {parameters}} as in a spec of the project -> scikit-learn kernel."""
    (kind, p), = spec.items()
    if kind in ("sum", "product"):
        parts = [sklearn_kernel(part) for part in p["terms" if kind == "sum" else "factors"]]
        total = parts[0]
        for part in parts[1:]:
            total = total + part if kind == "sum" else total * part
        return total
    columns = [d for d, scale in enumerate(p["length_scales"]) if scale != INF]
    scales = [p["length_scales"][d] for d in columns]
    output = kernels.ConstantKernel(p["output_scale"] ** 2)
    if kind == "periodic":
        for d, scale in zip(columns, scales):
            one = kernels.ExpSineSquared(length_scale=scale, periodicity=p["periods"][d])
            output = output * OnColumns(one, [d], [1.0])
        return output
    if kind == "squared_exponential" and len(columns) == len(p["length_scales"]):
        return output * kernels.RBF(scales)
    base = {
        "squared_exponential": lambda: kernels.RBF(1.0),
        "rational_quadratic": lambda: kernels.RationalQuadratic(length_scale=1.0, alpha=p["shape"]),
        "matern32": lambda: kernels.Matern(1.0, nu=1.5),
        "matern52": lambda: kernels.Matern(1.0, nu=2.5),
    }[kind]()
    return output * OnColumns(base, columns, scales)


# --- the same from the formulas, in extended precision --------------------------------------------------------------

def long(x):
    return np.asarray(x, dtype=np.longdouble)


def long_kernel(spec, x, y):
    (kind, p), = spec.items()
    if kind == "sum":
        return sum(long_kernel(part, x, y) for part in p["terms"])
    if kind == "product":
        return np.prod([long_kernel(part, x, y) for part in p["factors"]], axis=0)
    delta = long(x)[:, None, :] - long(y)[None, :, :]
    variance = long(p["output_scale"]) ** 2
    scales = long(p["length_scales"])
    if kind == "periodic":
        pi = long(4.0) * np.arctan(long(1.0))
        waves = np.sin(pi * delta / long(p["periods"])) ** 2
        return variance * np.exp(-2 * np.sum(np.where(np.isinf(scales), 0, waves / scales**2), axis=2))
    r2 = np.sum((delta / scales) ** 2, axis=2)
    r = np.sqrt(r2)
    if kind == "squared_exponential":
        return variance * np.exp(-r2 / 2)
    if kind == "rational_quadratic":
        return variance * (1 + r2 / (2 * long(p["shape"]))) ** -long(p["shape"])
    if kind == "matern32":
        z = np.sqrt(long(3.0)) * r
        return variance * (1 + z) * np.exp(-z)
    if kind == "matern52":
        z = np.sqrt(long(5.0)) * r
        return variance * (1 + z + z**2 / 3) * np.exp(-z)
    raise ValueError(kind)


def long_cholesky(a):
    n = len(a)
    factor = np.zeros_like(a)
    for j in range(n):
        factor[j, j] = np.sqrt(a[j, j] - factor[j, :j] @ factor[j, :j])
        factor[j + 1:, j] = (a[j + 1:, j] - factor[j + 1:, :j] @ factor[j, :j]) / factor[j, j]
    return factor


def long_forward(factor, b):
    x = np.zeros_like(b)
    for i in range(len(factor)):
        x[i] = (b[i] - factor[i, :i] @ x[:i]) / factor[i, i]
    return x


def long_evidence(spec, x, y, noise):
    """Cholesky factor, L^-1 y and log marginal likelihood (Rasmussen & Williams 2006, Alg. 2.1)."""
    factor = long_cholesky(long_kernel(spec, x, x) + np.diag(long(noise) * np.ones(len(x), dtype=np.longdouble)))
    z = long_forward(factor, long(y))
    pi = long(4.0) * np.arctan(long(1.0))
    return factor, z, -z @ z / 2 - np.sum(np.log(np.diag(factor))) - len(x) * np.log(2 * pi) / 2


def long_posterior(spec, x, y, noise, queries):
    factor, z, evidence = long_evidence(spec, x, y, noise)
    v = long_forward(factor, long_kernel(spec, x, queries))
    prior = np.diag(long_kernel(spec, queries, queries))
    return z @ v, prior - np.sum(v * v, axis=0), evidence


# --- cases ----------------------------------------------------------------------------------------------------------

WORST = {}  # what -> largest relative difference between scikit-learn and extended precision


def agree(name, what, value, reference, scale):
    difference = float(np.max(np.abs(long(value) - long(reference)) / scale))
    if not difference < 1e-9:
        raise SystemExit(f"{name}: the {what} of scikit-learn and of the formulas differ by {difference:g}")
    WORST[what] = max(WORST.get(what, 0.0), difference)


def posterior_case(name, spec, dataset, n, mean=0.0, heteroscedastic=False):
    """Posterior and log marginal likelihood; the noise variance is each sample's own, or NOISE."""
    x, y, queries = DATA["inputs"][:n], DATA[dataset][:n], DATA["queries"]
    noise = DATA["noise_variances"][:n] if heteroscedastic else NOISE
    process = GaussianProcessRegressor(sklearn_kernel(spec), alpha=noise, optimizer=None).fit(x, y - mean)
    centred, covariance = process.predict(queries, return_cov=True)
    variance = np.diag(covariance)
    evidence = process.log_marginal_likelihood_value_

    mean80, variance80, evidence80 = long_posterior(spec, x, long(y) - long(mean), noise, queries)
    prior_variance = np.diag(long_kernel(spec, queries, queries))
    agree(name, "mean", centred, mean80, max(1.0, np.max(np.abs(y))))
    agree(name, "variance", variance, variance80, prior_variance)
    agree(name, "evidence", evidence, evidence80, max(1.0, abs(evidence)))
    return {
        "name": name,
        "kernel": spec,
        "targets": dataset,
        "samples": n,
        "mean": mean,
        **({"noise_variances": noise} if heteroscedastic else {"noise_variance": noise}),
        "posterior_mean": centred + mean,
        "posterior_variance": variance,
        "log_marginal_likelihood": evidence,
    }


def lognormal_case(name, spec, n):
    """Adds mean and variance of exp(f): exp(m + s2/2) and exp(2m + s2)(exp(s2) - 1)."""
    case = posterior_case(name, spec, "log_gain", n, mean=-1.0)
    m, s2 = case["posterior_mean"], case["posterior_variance"]
    case["lognormal_mean"] = [math.exp(a + v / 2) for a, v in zip(m, s2)]
    case["lognormal_variance"] = [math.exp(2 * a + v) * math.expm1(v) for a, v in zip(m, s2)]
    return case


def with_parameters(spec, theta):
    """`spec` with exp(theta) in the project's order, and the noise variance, its last entry."""
    (kind, p), = spec.items()
    d = len(p["length_scales"])
    value = np.exp(long(theta))
    changed = {"output_scale": value[0], "length_scales": value[1:1 + d]}
    if "shape" in p:
        changed["shape"] = value[1 + d]
    return {kind: changed}, value[-1]


def gradient_case(name, spec, n):
    """Gradient of the log marginal likelihood by the logs of [output_scale, length_scales..., shape, noise_variance].

    Squared exponential: all of it from scikit-learn. Rational quadratic: scikit-learn's is isotropic, so that on inputs
    divided by the length scales it gives output_scale, shape, noise_variance and the sum of the entries of the length
    scales; these entries themselves are central differences in extended precision, extrapolated by Richardson, as is
    the check of all others.
    """
    (kind, p), = spec.items()
    x, y = DATA["inputs"][:n], DATA["targets"][:n]
    d = len(p["length_scales"])
    white = kernels.WhiteKernel(NOISE)
    output = kernels.ConstantKernel(p["output_scale"] ** 2)
    if kind == "squared_exponential":
        process = GaussianProcessRegressor(output * kernels.RBF(p["length_scales"]) + white, alpha=0.0, optimizer=None)
        process.fit(x, y)
    else:
        base = kernels.RationalQuadratic(length_scale=1.0, alpha=p["shape"])
        process = GaussianProcessRegressor(output * base + white, alpha=0.0, optimizer=None)
        process.fit(x / np.array(p["length_scales"]), y)
    names = [h.name.split("__")[-1] for h in process.kernel_.hyperparameters for _ in range(h.n_elements)]
    evidence, raw = process.log_marginal_likelihood(process.kernel_.theta, eval_gradient=True)
    by_name = {key: [g for k, g in zip(names, raw) if k == key] for key in names}

    order = ["output_scale"] + [f"length_scales.{i}" for i in range(d)] + (["shape"] if "shape" in p else []) + [
        "noise_variance"]
    theta = np.log(long([p["output_scale"], *p["length_scales"], *([p["shape"]] if "shape" in p else []), NOISE]))

    def value(at):
        changed, noise = with_parameters(spec, at)
        return long_evidence(changed, x, y, noise)[2]

    def slope(i):
        def central(h):
            step = np.zeros(len(theta), dtype=np.longdouble)
            step[i] = h
            return (value(theta + step) - value(theta - step)) / (2 * step[i])
        rows = [central(long(2.0) ** -k) for k in range(5, 10)]
        for power in range(1, len(rows)):
            rows = [b + (b - a) / (4**power - 1) for a, b in zip(rows, rows[1:])]
        return rows[0]

    differences = np.array([slope(i) for i in range(len(theta))])
    scales = by_name["length_scale"]
    gradient = [2 * by_name["constant_value"][0], *(scales if len(scales) == d else differences[1:1 + d])]
    if "shape" in p:
        agree(name, "gradient", scales[0], np.sum(differences[1:1 + d]), max(1.0, abs(scales[0])))
        gradient.append(by_name["alpha"][0])
    gradient.append(by_name["noise_level"][0])
    gradient = np.array(gradient, dtype=float)
    agree(name, "gradient", gradient, differences, np.max(np.abs(gradient)))
    return {
        "name": name,
        "kernel": spec,
        "targets": "targets",
        "samples": n,
        "noise_variance": NOISE,
        "log_marginal_likelihood": evidence,
        "parameters": order,
        "gradient_by_log_parameter": gradient,
    }


def optimum_case(n, inputs, targets):
    """Maximum of the log marginal likelihood over output scale, two length scales and noise variance (W3): bounded
    L-BFGS on scikit-learn's value and gradient, from the start of W3 and 24 random ones, each polished by Newton.
    """
    x, y = inputs[:n], targets[:n]
    model = kernels.ConstantKernel(25.0) * kernels.RBF([2.0, 2.0]) + kernels.WhiteKernel(0.25)
    process = GaussianProcessRegressor(model, alpha=0.0, optimizer=None).fit(x, y)

    def loss(theta):  # logs of [s^2, l1, l2, noise variance]
        value, gradient = process.log_marginal_likelihood(theta, eval_gradient=True, clone_kernel=False)
        return -value, -gradient

    bounds = np.log([[1e-6, 1e6], [1e-2, 1e3], [1e-2, 1e3], [1e-8, 1e2]])

    def climb(theta):
        found = minimize(loss, theta, jac=True, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-9})
        theta, inside = found.x, np.all((found.x > bounds[:, 0] + 1e-6) & (found.x < bounds[:, 1] - 1e-6))
        for _ in range(4 if inside else 0):
            h = 1e-5
            hessian = np.array([(loss(theta + h * e)[1] - loss(theta - h * e)[1]) / (2 * h) for e in np.eye(4)])
            hessian = (hessian + hessian.T) / 2
            if np.min(np.linalg.eigvalsh(hessian)) <= 0:
                break
            trial = theta - np.linalg.solve(hessian, loss(theta)[1])
            if np.max(np.abs(loss(trial)[1])) > np.max(np.abs(loss(theta)[1])):
                break
            theta = trial
        return theta, -loss(theta)[0], float(np.max(np.abs(loss(theta)[1])))

    start = np.log([25.0, 2.0, 2.0, 0.25])
    rng = np.random.default_rng(SEED + n)
    starts = [rng.uniform(np.log([1.0, 0.3, 0.3, 1e-4]), np.log([1e4, 20.0, 20.0, 10.0])) for _ in range(24)]
    ends = [climb(theta) for theta in [start, *starts]]
    best = max(ends, key=lambda end: end[1])
    scale, *length_scales, noise = np.exp(best[0] * [0.5, 1.0, 1.0, 1.0])
    exact = long_evidence(se(scale, *length_scales), x, y, noise)[2]
    agree(f"W3/{n}", "evidence at the optimum", best[1], exact, max(1.0, abs(best[1])))
    return {
        "name": f"W3/{n}",
        "samples": n,
        "start": {"output_scale": 5.0, "length_scales": [2.0, 2.0], "noise_variance": 0.25},
        "log_marginal_likelihood_at_start": -loss(start)[0],
        "log_marginal_likelihood": best[1],
        "from_start_of_w3": ends[0][1],
        "output_scale": scale,
        "length_scales": length_scales,
        "noise_variance": noise,
        "largest_gradient_entry": best[2],
        "starts": len(ends),
        "starts_that_found_it": sum(end[1] > best[1] - 1e-6 for end in ends),
        "other_maxima": sorted({round(end[1], 4) for end in ends if end[1] < best[1] - 1e-3}, reverse=True),
    }


def se(output_scale, *scales):
    return {"squared_exponential": {"output_scale": output_scale, "length_scales": list(scales)}}


def rq(output_scale, shape, *scales):
    return {"rational_quadratic": {"output_scale": output_scale, "length_scales": list(scales), "shape": shape}}


def matern(kind, output_scale, *scales):
    return {kind: {"output_scale": output_scale, "length_scales": list(scales)}}


def periodic(output_scale, scales, periods):
    return {"periodic": {"output_scale": output_scale, "length_scales": scales, "periods": periods}}


def main():
    two_pi = 2.0 * np.pi
    specs = {
        "squared_exponential": se(10.0, 1.5, 4.0),
        "rational_quadratic": rq(10.0, 1.5, 1.5, 4.0),
        "matern32": matern("matern32", 8.0, 2.0, 5.0),
        "matern52": matern("matern52", 9.0, 1.8, 4.5),
        "periodic": periodic(7.0, [1.2, 1.5], [two_pi, 9.0]),
        "one_input": se(10.0, 1.5, INF),
        "product": {"product": {"factors": [periodic(3.0, [1.2, INF], [two_pi, 1.0]), se(2.5, INF, 3.0)]}},
        "sum": {"sum": {"terms": [se(8.0, 2.5, 6.0), matern("matern52", 3.0, 0.9, 2.0)]}},
    }
    posteriors = [posterior_case(f"{name}/{n}", spec, "targets", n) for name, spec in specs.items() for n in (1, 5, 30)]
    for name in ("squared_exponential", "rational_quadratic"):
        posteriors.append(posterior_case(f"constant_mean/{name}/30", specs[name], "targets", 30, mean=1.5))
        posteriors.append(posterior_case(f"heteroscedastic/{name}/30", specs[name], "targets", 30,
                                         heteroscedastic=True))
    lognormals = [lognormal_case(f"lognormal/{n}", rq(0.6, 1.5, 2.0, 5.0), n) for n in (1, 5, 30)]
    gradients = [gradient_case(f"{name}/{n}", specs[name], n) for name in ("squared_exponential", "rational_quadratic")
                 for n in (5, 30)]

    rows, values, asked = make_benchmark()
    optima = [optimum_case(n, rows, values) for n in (20, 50, 200)]

    document = {
        "origin": {
            "script": "scripts/reference/gp_reference.py",
            "method": "scikit-learn GaussianProcessRegressor, checked against the formulas in 80-bit arithmetic",
            "versions": {
                "python": platform.python_version(),
                "scikit-learn": sklearn.__version__,
                "scipy": scipy.__version__,
                "numpy": np.__version__,
            },
            "seed": SEED,
            "largest_difference": WORST,
            "difference_relative_to": {
                "mean": "largest |target|, at least 1",
                "variance": "k(x, x)",
                "evidence": "its magnitude, at least 1",
                "gradient": "its largest entry",
            },
            "infinity": "the string \"inf\"",
        },
        "data": DATA,
        "posteriors": posteriors,
        "lognormals": lognormals,
        "gradients": gradients,
        "optima": {"data": "benchmark_data.csv, its first `samples` rows", "cases": optima},
    }
    OUTPUT.mkdir(parents=True, exist_ok=True)
    write_json(OUTPUT / "gp.json", document)
    np.savetxt(OUTPUT / "benchmark_data.csv", np.column_stack([rows, values]), fmt="%.17g", delimiter=",",
               header="x1,x2,y", comments="")
    np.savetxt(OUTPUT / "benchmark_queries.csv", asked, fmt="%.17g", delimiter=",", header="x1,x2", comments="")
    print(f"gp_reference: {len(posteriors)} posteriors, {len(lognormals)} log-normal, {len(gradients)} gradients, "
          f"{len(optima)} optima; largest relative differences "
          + ", ".join(f"{what} {worst:.1e}" for what, worst in WORST.items()))


def plain(value):
    """numpy to JSON; every double as its shortest text that reads back the same."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(entry) for entry in value]
    if isinstance(value, (float, np.floating)):
        return "inf" if np.isinf(value) else float(value)
    return int(value) if isinstance(value, np.integer) else value


def write_json(path, document):
    text = json.dumps(plain(document), indent=1, allow_nan=False)
    one_line = lambda match: re.sub(r"\s*\n\s*", " ", match.group()).replace("[ ", "[").replace(" ]", "]")
    path.write_text(re.sub(r"\[[^\[\]{}]*\]", one_line, text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
