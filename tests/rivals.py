#!/usr/bin/env python3
"""Simpler ways to a diagnosis, on the cases of tests/blind/real.

    DETUNE_REAL_SEEDS=10 DETUNE_REAL_FIRST_SEED=41 DETUNE_CASES=target/cases \\
        cargo test --release --test blind real:: -- --nocapture
    OMP_NUM_THREADS=1 python3 tests/rivals.py target/release/detune target/cases --jobs 2

Every way has the causes of detune itself, by robot files with one correction each, and the same tables:

  BIC   least squares of one parameter of one cause; the cause with the lowest BIC, if it is below that of
        none; within 2 of it the alternatives (at most three)
  L1    least squares of all parameters at once, linear, under an L1 penalty chosen by tenfold
        cross-validation (one standard error), the chosen ones fitted again without it
  GP    a Gaussian process of the residual over the joints, hyperparameters of the largest likelihood

For each: whether the first finding is right, whether one is wrong, and the error at fresh poses, which no way
has seen, over the noise of the table.
"""

import argparse
import csv
import json
import re
import subprocess
import tempfile
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

import numpy as np

# Values of a parameter between which ln f is interpolated: Chebyshev's points.
POINTS = 9


class Arm:
    """A case's robot, as the program computes it."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        self.text = (folder / "robot.yaml").read_text().removesuffix("{}\n")
        self.links = re.findall(r'<link name="([^"]+)"', (folder / "robot.urdf").read_text())
        springs = re.findall(r"^    (\w+): \{stiffness_nm_per_rad: ([\d.e+-]+)", self.text, re.M)
        self.springs = {name: float(k) for name, k in springs}
        self.rigid = [
            name
            for name in re.findall(r'<joint name="([^"]+)" type="revolute"', (folder / "robot.urdf").read_text())
            if name not in self.springs
        ]
        carried = re.search(r"^payload: .*?mass_kg: ([\d.]+)", self.text, re.M | re.S)
        self.payload_kg = float(carried.group(1)) if carried else 0.0
        rows, fresh = (self.table(name) for name in ("measured.csv", "fresh.csv"))
        joints = [name for name in rows[0] if re.fullmatch(r"\w+_(rad|deg|m|mm)", name)]
        joints = [name for name in joints if not name.startswith("phi")]
        self.modes = sum(bool(re.fullmatch(r"f\d+_hz", name)) for name in fresh[0])
        self.measured = len(rows)
        q = [[float(row[name]) for name in joints] for row in rows + fresh]
        self.q = np.array(q)
        number = lambda text: float(text) if text else np.nan
        f = [[number(row[f"f{m + 1}_hz"]) for m in range(self.modes)] for row in rows + fresh]
        self.ln_f = np.log(f)
        self.column = lambda name: (
            np.array([float(row[name]) for row in rows]) if name in rows[0] else None
        )
        self.poses = folder / "rival.csv"
        with open(self.poses, "w") as out:
            out.write(",".join(joints) + "\n")
            for row in q:
                out.write(",".join(map(repr, row)) + "\n")

    def table(self, name):
        lines = (self.folder / name).read_text().splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    def ln_hz(self, text):
        """ln f by pose and mode; None where there is no such robot."""
        with tempfile.NamedTemporaryFile("w", suffix=".yaml", dir=self.folder) as robot:
            robot.write(text)
            robot.flush()
            arguments = ["map", robot.name, "--poses", str(self.poses)]
            run = subprocess.run([self.program, *arguments], capture_output=True, text=True)
        if run.returncode != 0:
            return None
        rows = csv.DictReader(run.stdout.splitlines())
        found = np.array([[float(row.get(f"f{m + 1}_hz") or "nan") for m in range(self.modes)] for row in rows])
        return np.log(found)

    def corrected(self, cause, at, parameters, hinge=""):
        values = ", ".join(f"{name}: {value!r}" for name, value in parameters.items())
        place = f", at: {at}" if at else ""
        return f"{self.text}corrections:\n  - {{cause: {cause}{place}, parameters: {{{values}}}{hinge}}}\n"

    def softer(self, joint, factor):
        before = f"{joint}: {{stiffness_nm_per_rad: "
        k = self.springs[joint] * factor
        return re.sub(re.escape(before) + r"[\d.e+-]+", before + repr(k), self.text)


class Curve:
    """What a cause does to ln f over a parameter x from -1 to 1, interpolated; x = 0 or -1 does nothing."""

    def __init__(self, cause, at, columns, one_sided):
        self.cause, self.at, self.one_sided = cause, at, one_sided
        # columns: ln f at Chebyshev's points, [point, pose, mode]
        k = np.arange(POINTS)
        nodes = np.cos(np.pi * (k + 0.5) / POINTS)
        matrix = np.cos(np.outer(np.arccos(nodes), k))
        self.coefficients = np.tensordot(np.linalg.inv(matrix), columns, 1)

    def __call__(self, x):
        return np.tensordot(np.cos(np.arccos(x) * np.arange(POINTS)), self.coefficients, 1)

    @staticmethod
    def nodes():
        return np.cos(np.pi * (np.arange(POINTS) + 0.5) / POINTS)


def curves(arm, plain):
    """One a cause, place and direction."""
    found = []

    def add(cause, at, of, one_sided=False):
        columns = []
        for x in Curve.nodes():
            ln_hz = of(x)
            if ln_hz is None or np.isnan(ln_hz).any():
                return
            columns.append(ln_hz)
        found.append(Curve(cause, at, np.array(columns), one_sided))

    def by_file(cause, at, parameters, hinge="", one_sided=False):
        add(cause, at, lambda x: arm.ln_hz(arm.corrected(cause, at, parameters(x), hinge)), one_sided)

    springs = {}
    for joint in arm.springs:
        columns = [arm.ln_hz(arm.softer(joint, float(np.exp(1.2 * x)))) for x in Curve.nodes()]
        if any(c is None for c in columns):
            continue
        springs[joint] = Curve("joint_stiffness", joint, np.array(columns), False)
    found.extend(springs.values())

    def all_softer(x):
        text = arm.text
        for joint, k in arm.springs.items():
            before = f"{joint}: {{stiffness_nm_per_rad: "
            text = re.sub(re.escape(before) + r"[\d.e+-]+", before + repr(k * float(np.exp(1.2 * x))), text)
        return arm.ln_hz(text)

    add("joint_stiffness", "all", all_softer)

    def law(curve, factor):
        """A spring that differs from row to row, by the spring that is the same everywhere."""
        x = np.log(np.clip(factor, 0.31, 3.2)) / 1.2
        return np.array([curve(value)[i] for i, value in enumerate(x)])

    warm, pushed = arm.column("temperature_c"), arm.column("amplitude_nm")
    of_rows = lambda values: np.concatenate([values, np.zeros(len(arm.q) - arm.measured)])
    for joint, curve in springs.items():
        if warm is not None:
            dt = of_rows(warm - np.median(warm))
            add("temperature_drift", joint, lambda x, c=curve: law(c, 1 + 0.03 * x * dt))
        if pushed is not None:
            level = of_rows(np.log(pushed / np.median(pushed)))
            add("amplitude_dependence", joint, lambda x, c=curve: law(c, np.exp(0.3 * x * level)))
        i = list(arm.springs).index(joint)
        if i < arm.q.shape[1]:
            for k in (1, 2, 3):
                for wave in (np.sin, np.cos):
                    phase = wave(k * arm.q[:, i])
                    add("position_dependent_stiffness", joint, lambda x, c=curve, p=phase: law(c, 1 + 0.6 * x * p))
        by_file("load_dependent_stiffness", joint, lambda x: {"change_per_nm": float(np.sinh(4 * x) * 1e-4)})
        by_file("drive_inertia", joint, lambda x: {"reflected_inertia_kgm2": float(10 ** (2 * x))}, one_sided=True)
        by_file("joint_zero_offset", joint, lambda x: {"offset_rad": float(0.3 * x)})
        for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
            hinge = f", kind: rotation, axes: [[{axis[0]}, {axis[1]}, {axis[2]}]], origin_m: [0, 0, 0]"
            soft = lambda x, k=arm.springs[joint]: {"stiffness_nm_per_rad": float(k * 10 ** (2 - 2 * x))}
            by_file("transverse_compliance", joint, soft, hinge, True)
    if warm is not None and springs:
        everything = next((c for c in found if c.at == "all"), None)
        dt = of_rows(warm - np.median(warm))
        add("temperature_drift", "all", lambda x: law(everything, 1 + 0.03 * x * dt))
    for joint in arm.rigid:
        by_file(
            "joint_stiffness", joint, lambda x: {"stiffness_nm_per_rad": float(10 ** (6 - 2 * x))}, one_sided=True
        )
    for link in arm.links:
        by_file("link_inertia", link, lambda x: {"inertia_factor": float(np.exp(2 * x))})
        if link == arm.links[-1]:
            low = -0.95 * arm.payload_kg
            by_file("payload", link, lambda x: {"mass_kg": float(low + (x + 1) * (0.5 * (20 - low)))})
        else:
            by_file("payload", link, lambda x: {"mass_kg": float(20 * (x + 1))}, one_sided=True)
        for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
            hinge = f", kind: rotation, axes: [[{axis[0]}, {axis[1]}, {axis[2]}]], origin_m: [0, 0, 0]"
            soft = lambda x: {"stiffness_nm_per_rad": float(10 ** (7 - 2 * x)), "position": 0.5}
            by_file("link_flexibility", link, soft, hinge, True)
    base = arm.links[0]
    for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        hinge = f", axes: [[{axis[0]}, {axis[1]}, {axis[2]}]], origin_m: [0, 0, 0]"
        tilt = lambda x: {"stiffness_nm_per_rad": float(10 ** (7.5 - 2 * x))}
        by_file("base_compliance", base, tilt, ", kind: rotation" + hinge, True)
        shift = lambda x: {"stiffness_n_per_m": float(10 ** (8 - 2 * x))}
        by_file("base_compliance", base, shift, ", kind: translation" + hinge, True)
    by_file("gravity_stiffness", None, lambda x: {}, one_sided=True)
    for first, joint in zip(list(arm.springs), list(arm.springs)[1:]):
        by_file("joint_coupling", joint, lambda x: {"ratio": float(x)})
    return found


def by_bic(arm, plain, known):
    """Findings, each with its alternatives, and ln f at the fresh poses."""
    target = arm.ln_f[: arm.measured]
    is_known = ~np.isnan(target)
    n = is_known.sum()
    bic = lambda ln_hz, k: n * np.log((((target - ln_hz[: arm.measured])[is_known]) ** 2).mean()) + k * np.log(n)
    tried = []
    for curve in known:
        xs = np.linspace(-0.98, 0.98, 197)
        at = min(xs, key=lambda x: bic(curve(x), 1))
        tried.append((bic(curve(at), 1), curve, at))
    tried.sort(key=lambda t: t[0])
    if not tried or tried[0][0] >= bic(plain, 0):
        return [], plain
    best, curve, x = tried[0]
    names, group = {(curve.cause, curve.at)}, []
    for value, other, _ in tried[1:]:
        name = (other.cause, other.at)
        if value < best + 2 and name not in names and len(group) < 3:
            names.add(name)
            group.append(name)
    return [[(curve.cause, curve.at), *group]], curve(x)


def by_l1(arm, plain, known, rng):
    """The same by an L1 penalty over all parameters at once."""
    step = 0.02
    slopes, limits = [], []
    for curve in known:
        at = -0.9 if curve.one_sided else 0.0
        slopes.append((curve(at + step) - curve(at - step * (not curve.one_sided))))
        limits.append(0.0 if curve.one_sided else -np.inf)
    target = (arm.ln_f - plain)[: arm.measured]
    keep = ~np.isnan(target).ravel()
    columns = np.array([s[: arm.measured].ravel()[keep] for s in slopes]).T
    size = np.sqrt((columns**2).mean(0))
    use = size > 1e-7
    columns, limits = columns[:, use] / size[use], np.array(limits)[use]
    own = [curve for curve, used in zip(known, use) if used]
    y = target.ravel()[keep]
    rows = np.repeat(np.arange(arm.measured), arm.modes)[keep]

    def lasso(a, b, penalty, start):
        x, gram, along = start.copy(), a.T @ a / len(b), a.T @ b / len(b)
        for _ in range(200):
            before = x.copy()
            for j in range(len(x)):
                rho = along[j] - gram[j] @ x + gram[j, j] * x[j]
                x[j] = np.sign(rho) * max(abs(rho) - penalty, 0) / gram[j, j]
                x[j] = max(x[j], limits[j])
            if np.abs(x - before).max() < 1e-6 * max(np.abs(x).max(), 1e-9):
                break
        return x

    def path(a, b):
        top = np.abs(columns.T @ y / len(y)).max()
        x, out = np.zeros(a.shape[1]), []
        for penalty in top * 0.7 ** np.arange(0, 18):
            x = lasso(a, b, penalty, x)
            out.append(x.copy())
        return out

    fold_of = rng.permutation(np.arange(arm.measured) % 10)[rows]
    errors = []
    for fold in range(10):
        out = fold_of == fold
        if out.any():
            errors.append([((y[out] - columns[out] @ x) ** 2).mean() for x in path(columns[~out], y[~out])])
    errors = np.array(errors)
    mean, spread = errors.mean(0), errors.std(0, ddof=1) / np.sqrt(len(errors))
    best = mean.argmin()
    chosen = next(i for i in range(len(mean)) if mean[i] <= mean[best] + spread[best])
    x = path(columns, y)[chosen]
    support = np.flatnonzero(x)
    if not len(support):
        return [], plain
    again = np.zeros_like(x)
    again[support] = np.linalg.lstsq(columns[:, support], y, rcond=None)[0]
    again = np.maximum(again, limits)
    fresh = plain + sum(again[j] / size[use][j] * slopes[i] for j, i in enumerate(np.flatnonzero(use)))
    named = []
    for j in sorted(support, key=lambda j: -abs(again[j])):
        name = (own[j].cause, own[j].at)
        if name not in [n for n, in named]:
            named.append([name])
    return named, fresh


def by_gp(arm, plain):
    """ln f of a Gaussian process over sines and cosines of the joints, mode by mode."""
    turned = np.concatenate([np.sin(arm.q), np.cos(arm.q)], 1)
    out = plain.copy()
    for m in range(arm.modes):
        y = (arm.ln_f - plain)[: arm.measured, m]
        keep = np.flatnonzero(~np.isnan(y))
        if len(keep) < 3:
            continue
        y, mean = y[keep] - y[keep].mean(), y[keep].mean()
        joints = arm.q.shape[1]

        def kernel(a, b, lengths):
            scale = np.tile(np.exp(lengths), 2)
            d2 = (((a[:, None] - b[None]) / scale) ** 2).sum(2)
            return np.exp(-0.5 * d2)

        def fit(theta):
            c = kernel(turned[keep], turned[keep], theta[1:])
            c = np.exp(theta[0]) * c + np.eye(len(y))
            try:
                root = np.linalg.cholesky(c)
            except np.linalg.LinAlgError:
                return np.inf, None
            w = np.linalg.solve(root, y)
            s2 = (w @ w) / len(y)
            return 0.5 * len(y) * np.log(s2) + np.log(np.diag(root)).sum(), root

        best, theta = np.inf, None
        for ratio in (-6.0, 0.0, 2.5):
            for length in (0.0, 1.0):
                t = np.array([ratio] + [length] * joints)
                value = fit(t)[0]
                step = 1.0
                while step > 0.1:
                    moved = False
                    for i in range(len(t)):
                        for sign in (1, -1):
                            u = t.copy()
                            u[i] = np.clip(u[i] + sign * step, -8 if i == 0 else -1.5, 8 if i == 0 else 4)
                            v = fit(u)[0]
                            if v < value - 1e-6:
                                t, value, moved = u, v, True
                    step *= 1.0 if moved else 0.5
                if value < best:
                    best, theta = value, t
        root = fit(theta)[1]
        weights = np.linalg.solve(root.T, np.linalg.solve(root, y))
        out[:, m] = plain[:, m] + mean + np.exp(theta[0]) * kernel(turned, turned[keep], theta[1:]) @ weights
    return [], out


def by_detune(arm):
    """What the program itself said and wrote."""
    diagnosis = json.loads((arm.folder / "diagnosis.json").read_text())
    named = []
    for finding in diagnosis["findings"]:
        group = [(s["cause"], s["at"]) for s in finding["indistinguishable_from"]]
        named.append([(finding["cause"], finding["at"]), *(group if len(group) < 4 else [])])
    return named, arm.ln_hz((arm.folder / "calibrated.yaml").read_text())


def scored(program, folder):
    """A line about a case, and by way: whether something is hidden, the first finding is right, how many are wrong, and
    the error."""
    truth = json.loads((folder / "hidden.json").read_text())
    right = {(h["cause"], at) for h in truth["hidden"] for at in h["at"]}
    arm = Arm(program, folder)
    plain = arm.ln_hz(arm.text)
    known = curves(arm, plain)
    rng = np.random.default_rng(1)
    ways = {
        "detune": by_detune(arm),
        "BIC": by_bic(arm, plain, known),
        "L1": by_l1(arm, plain, known, rng),
        "GP": by_gp(arm, plain),
        "model": ([], plain),
    }
    line, scores = [], {}
    for way, (named, ln_hz) in ways.items():
        error = np.exp(ln_hz - arm.ln_f)[arm.measured :] - 1
        error = np.sqrt((error**2).mean()) / truth["noise"]
        first = bool(named) and any(tuple(name) in right for name in named[0])
        wrong = sum(not any(tuple(name) in right for name in group) for group in named)
        scores[way] = (bool(right), first, wrong, error)
        line.append(f"{way} {'+' if first else '-'}{wrong} {error:.2f}")
    arm.poses.unlink()
    return f"{folder.name:<28} {len(known)} candidates: " + ", ".join(line), scores


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("cases", type=Path)
    arguments.add_argument("--only", default="")
    arguments.add_argument("--jobs", type=int, default=1, help="cases at once")
    given = arguments.parse_args()
    program = str(Path(given.program).resolve())
    folders = [
        folder
        for folder in sorted(given.cases.iterdir())
        if given.only in folder.name and (folder / "calibrated.yaml").exists()
    ]
    scores = {}
    with ProcessPoolExecutor(given.jobs) as pool:
        for line, of_case in pool.map(scored, repeat(program), folders):
            print(line, flush=True)
            for way, score in of_case.items():
                scores.setdefault(way, []).append(score)
    print(f"\n{'way':<8}{'first right':>14}{'wrong cause':>14}{'none, calm':>14}{'fresh/noise':>14}{'worst tenth':>14}")
    for way, rows in scores.items():
        hidden = [row for row in rows if row[0]]
        calm = [row for row in rows if not row[0]]
        errors = sorted(row[3] for row in rows)
        share = lambda hits, of: f"{sum(hits)}/{len(of)}"
        print(
            f"{way:<8}{share([r[1] for r in hidden], hidden):>14}{share([r[2] > 0 for r in hidden], hidden):>14}"
            f"{share([r[2] == 0 for r in calm], calm):>14}{np.median(errors):>14.2f}{errors[int(0.9 * len(errors))]:>14.2f}"
        )


if __name__ == "__main__":
    main()
