"""`detune lobes` on random cases of arm and tool modes against two independent computations.

python3 tests/stability.py target/release/detune [--cases 200] [--simulated 50] [--seed 1]

Spectral radii: semi-discretisation (Insperger & Stepan) with the delayed place as the mean of two samples and
the coefficients of the middle of each step, extrapolated from two step widths (Richardson) that differ little. Stretches with
and without a tooth in the cut have steps of their own, so that no step spans a corner.
Limits: neither too high nor too low. The spectral radius there is 1, the program's own within 1e-6, the other one
within its accuracy; below it nothing grows, a thousandth above it does.
Growth: the equations of motion in time by Runge and Kutta, the vibration of whole turns compared; there with
uneven pitch, too. Half of the cases have process damping.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np
import yaml

TAU = 2 * np.pi


def case(rng, uneven=False):
    modes = []
    for _ in range(rng.integers(0, 4)):  # of an arm
        modes.append(dict(frequency_hz=float(rng.uniform(8, 60)), damping_ratio=float(rng.uniform(0.01, 0.05)),
                          mass_kg=float(rng.uniform(30, 300)), axis=rng.normal(size=3).tolist()))
    for _ in range(rng.integers(0 if modes else 1, 3)):  # of a tool
        modes.append(dict(frequency_hz=float(rng.uniform(300, 1500)), damping_ratio=float(rng.uniform(0.01, 0.05)),
                          mass_kg=float(rng.uniform(0.03, 1)), axis=rng.normal(size=3).tolist()))
    teeth = int(rng.integers(1, 5))
    tool = dict(teeth=teeth, diameter_mm=12)
    if uneven and teeth > 1:
        pitch = 360 / teeth * (1 + rng.uniform(-0.2, 0.2, teeth))
        tool["pitch_deg"] = [float(p) for p in pitch * 360 / pitch.sum()]
    cutting = dict(direction=str(rng.choice(["slot", "climb", "conventional"])),
                   radial_depth_mm=float(rng.uniform(0.5, 12)),
                   coefficients=dict(ktc_n_per_mm2=float(rng.uniform(300, 2000)), krc_n_per_mm2=float(rng.uniform(50, 800)),
                                     kac_n_per_mm2=float(rng.uniform(0, 400))))
    if rng.random() < 0.5:
        cutting["process_damping_n_per_mm"] = float(np.exp(rng.uniform(np.log(5), np.log(500))))
    highest = max(mode["frequency_hz"] for mode in modes)
    rpm = float(60 / teeth * highest * np.exp(rng.uniform(np.log(0.1), np.log(3))))
    return dict(modes=modes, tool=tool, cutting=cutting), rpm


def of_case(text):
    shapes = np.array([np.array(m["axis"]) / np.linalg.norm(m["axis"]) / np.sqrt(m["mass_kg"]) for m in text["modes"]])
    omega = np.array([TAU * m["frequency_hz"] for m in text["modes"]])
    zeta = np.array([m["damping_ratio"] for m in text["modes"]])
    cut, k = text["cutting"], text["cutting"]["coefficients"]
    arc = np.arccos(1 - 2 * min(cut["radial_depth_mm"] / text["tool"]["diameter_mm"], 1))
    span = dict(slot=(0, np.pi), conventional=(0, arc), climb=(np.pi - arc, np.pi))[cut["direction"]]
    return shapes, omega, zeta, span, np.array([k["ktc_n_per_mm2"], k["krc_n_per_mm2"], k["kac_n_per_mm2"]]) * 1e6


def coefficient(phi, kt, kr, ka):
    """Force on the tool for a chip: x along the feed, y across, z out of the work."""
    s, c = math.sin(phi), math.cos(phi)
    return np.array([[force * s, force * c] for force in (-kt * c - kr * s, kt * s - kr * c, -ka)])


def rubbing(text, turning):
    """Of the flank, N s/m per depth: C over the cutting speed."""
    return text["cutting"].get("process_damping_n_per_mm", 0) * 1e3 / (turning * text["tool"]["diameter_mm"] * 5e-4)


def damping(phi, of_flank):
    """Force on the tool for the speed of its tip."""
    s, c = math.sin(phi), math.cos(phi)
    return -of_flank * np.array([[s * s, s * c], [c * s, c * c], [0, 0]])


OFF, FINEST = 5e-3, 8


def radius(text, rpm, depth_mm):
    """The spectral radius, and what it may be off by: in steps so small that it is little, or the smallest there are."""
    fineness, fine = 1, of_steps(text, rpm, depth_mm * 1e-3, 1)
    while True:
        coarse, fineness = fine, 2 * fineness
        fine = of_steps(text, rpm, depth_mm * 1e-3, fineness)
        found, off = fine + (fine - coarse) / 3, abs(fine - coarse)
        if fineness >= FINEST or off < OFF:
            return found, off


def of_steps(text, rpm, depth, fineness):
    shapes, omega, zeta, (entry, leaves), k = of_case(text)
    teeth, m = text["tool"]["teeth"], len(omega)
    turning, pitch = TAU * rpm / 60, TAU / teeth
    plane, rate = np.zeros((2, 2 * m)), np.zeros((2, 2 * m))
    plane[:, :m] = rate[:, m:] = shapes[:, :2].T
    flank = rubbing(text, turning)
    free = np.zeros((2 * m, 2 * m))
    free[:m, m:] = np.eye(m)
    free[m:, :m], free[m:, m:] = -np.diag(omega**2), -np.diag(2 * zeta * omega)
    gain = np.zeros((2 * m, 3))
    gain[m:] = shapes
    corners = sorted({0.0, pitch} | {round(angle % pitch, 13) for angle in (entry, leaves)})
    stretches = []
    for a, b in zip(corners, corners[1:]):
        if b - a < 1e-9:
            continue
        inside = [j for j in range(teeth) if entry < ((a + b) / 2 + j * pitch) % TAU < leaves]
        steps = max(40, int(np.ceil((b - a) / turning * omega.max() * 4))) * fineness if inside else 0
        stretches.append((a, b, inside, steps))
    samples = sum(steps + 1 for *_, steps in stretches if steps)
    size = 2 * m + 2 * samples
    state = np.eye(2 * m, size)
    before = np.eye(size)[2 * m:].reshape(samples, 2, size)
    after, at = np.zeros((samples, 2, size)), 0
    for a, b, inside, steps in stretches:
        if not steps:
            state = exponential(free * (b - a) / turning) @ state
            continue
        after[at] = plane @ state
        h = (b - a) / steps
        for i in range(steps):
            middle = a + (i + 0.5) * h
            cut = depth * sum(coefficient(middle + j * pitch, *k) for j in inside)
            rubs = depth * sum(damping(middle + j * pitch, flank) for j in inside)
            matrix = np.zeros((2 * m + 2, 2 * m + 2))
            matrix[:2 * m, :2 * m] = free + gain @ cut @ plane + gain @ rubs @ rate
            matrix[:2 * m, 2 * m:] = -gain @ cut
            step = exponential(matrix * h / turning)
            was = (before[at + i] + before[at + i + 1]) / 2
            state = step[:2 * m, :2 * m] @ state + step[:2 * m, 2 * m:] @ was
            after[at + i + 1] = plane @ state
        at += steps + 1
    whole = np.vstack([state, after.reshape(2 * samples, size)])
    return max(abs(np.linalg.eigvals(whole)))


def exponential(matrix):
    norm = np.linalg.norm(matrix, 1)
    halvings = max(0, int(np.ceil(np.log2(norm / 0.25)))) if norm > 0 else 0
    matrix = matrix / 2**halvings
    term = total = np.eye(len(matrix))
    for i in range(1, 14):
        term = term @ matrix / i
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def growth(text, rpm, depth, turns):
    """Mean growth per turn of the vibration in time."""
    shapes, omega, zeta, (entry, leaves), k = of_case(text)
    teeth, turning = text["tool"]["teeth"], TAU * rpm / 60
    pitch = np.radians(text["tool"].get("pitch_deg", [360 / teeth] * teeth))
    angles = np.concatenate([[0], np.cumsum(pitch)[:-1]])
    steps = int(max(400, 60 * omega.max() / turning))
    h = TAU / turning / steps
    lags = pitch / TAU * steps
    plane, flank = shapes[:, :2], rubbing(text, turning)
    history = np.zeros((turns * steps + 1, 2))
    q, v = np.full(len(omega), 1.0) / np.linalg.norm(shapes, axis=1), np.zeros(len(omega))
    sizes = []

    def place(at):
        if at <= 0:
            return np.zeros(2)
        low = int(at)
        share = at - low
        return history[low] * (1 - share) + history[low + 1] * share if share else history[low]

    def rate(at, q, v):
        u, force = plane.T @ q, np.zeros(3)
        for angle, lag in zip(angles, lags):
            phi = (at * TAU / steps + angle) % TAU
            if entry <= phi < leaves:
                force += depth * coefficient(phi, *k) @ (u - place(at - lag))
                force += depth * damping(phi, flank) @ (plane.T @ v)
        return v, shapes @ force - 2 * zeta * omega * v - omega**2 * q

    for turn in range(turns):
        for i in range(turn * steps, (turn + 1) * steps):
            history[i] = plane.T @ q
            a = rate(i, q, v)
            b = rate(i + 0.5, q + 0.5 * h * a[0], v + 0.5 * h * a[1])
            c = rate(i + 0.5, q + 0.5 * h * b[0], v + 0.5 * h * b[1])
            d = rate(i + 1 - 1e-12, q + h * c[0], v + h * c[1])
            q = q + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0])
            v = v + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1])
        history[(turn + 1) * steps] = plane.T @ q
        sizes.append(np.abs(history[turn * steps:(turn + 1) * steps]).max())
        if sizes[-1] > 1e12 or sizes[-1] < 1e-12:
            break
    half = len(sizes) // 2
    return (sizes[-1] / sizes[half]) ** (1 / (len(sizes) - 1 - half)) if len(sizes) > half + 1 else sizes[-1] / sizes[0]


def told(program, file, rpm, *more):
    command = [program, "lobes", file, "--rpm", f"{rpm!r}:{rpm!r}:1", *more]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[1].split(",")


def on_the_limit(program, file, rpm, limit_mm):
    """What is wrong with a limit by the program's own growth there and just above it."""
    at, above = (float(told(program, file, rpm, "--depth-mm", repr(limit_mm * share))[2]) for share in (1, 1.001))
    if abs(at - 1) > 1e-6:
        yield f"the radius at the limit {limit_mm} mm is {at}"
    if not above > 1:
        yield f"the radius a thousandth above the limit {limit_mm} mm is {above}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--simulated", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    worst, at_limit, coarsest, wrong, limits, unstable = 0.0, 0.0, 0.0, [], 0, 0
    undecided = 0
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "modes.yaml")
        for i in range(args.cases):
            text, rpm = case(rng)
            with open(file, "w") as out:
                yaml.safe_dump(text, out)
            row = told(args.program, file, rpm)
            limit_mm = float(row[1]) if row[1] else 100.0
            limits += bool(row[1])
            depth_mm = limit_mm * float(rng.choice([0.5, 0.9, 1.0, 1.1, 2.0]))
            found = float(told(args.program, file, rpm, "--depth-mm", repr(depth_mm))[2])
            expected, off = radius(text, rpm, depth_mm)
            undecided += off >= OFF
            worst, coarsest = max(worst, abs(found - expected)), max(coarsest, off)
            if abs(found - expected) > 1e-4 + 0.5 * off:
                wrong.append(f"case {i}: {rpm} rpm, {depth_mm} mm: {found}, expected {expected}: {text}")
            below = limit_mm * float(rng.uniform(0.2, 0.999))
            expected, off = radius(text, rpm, below)
            coarsest = max(coarsest, off)
            if row[1] and expected > 1 + 1e-4 + 0.5 * off:
                wrong.append(f"case {i}: {rpm} rpm: grows at {below} mm, below the limit {limit_mm} mm: {text}")
            if row[1]:
                faults = list(on_the_limit(args.program, file, rpm, limit_mm))
                expected, off = radius(text, rpm, limit_mm)
                at_limit, coarsest = max(at_limit, abs(expected - 1)), max(coarsest, off)
                if abs(expected - 1) > 1e-4 + 0.5 * off:
                    faults.append(f"the other radius at the limit {limit_mm} mm is {expected}")
                wrong += [f"case {i}: {rpm} rpm: {fault}: {text}" for fault in faults]
        for i in range(args.simulated):
            text, rpm = case(rng, uneven=True)
            with open(file, "w") as out:
                yaml.safe_dump(text, out)
            row = told(args.program, file, rpm)
            limit_mm = float(row[1]) if row[1] else 100.0
            if row[1]:
                faults = on_the_limit(args.program, file, rpm, limit_mm)
                wrong += [f"simulated {i}: {rpm} rpm: {fault}: {text}" for fault in faults]
            for factor in (0.6, 1.6):
                depth_mm = limit_mm * factor
                per_tooth = float(told(args.program, file, rpm, "--depth-mm", repr(depth_mm))[2])
                per_turn = per_tooth ** text["tool"]["teeth"]
                if abs(np.log(per_turn)) < 0.02:
                    continue
                # Shorter, and the beat of two modes passes for growth.
                turns = int(np.clip(6 / abs(np.log(per_turn)), 12, 300))
                seen = growth(text, rpm, depth_mm * 1e-3, turns)
                unstable += per_turn > 1
                if (seen > 1) != (per_turn > 1):
                    wrong.append(f"simulated {i}: {rpm} rpm, {depth_mm} mm: {per_turn} a turn, seen {seen}: {text}")
    print(f"{args.cases} spectral radii within {worst:.1e}, {limits} limits "
          f"where they are within {at_limit:.1e} of 1 (widths of steps differ by {coarsest:.1e} at most); "
          f"{args.simulated} cases in time, {unstable} that grow")
    if undecided > 0.1 * args.cases:
        wrong.append(f"{undecided} cases are not resolved by the smallest steps")
    for line in wrong:
        print(line)
    sys.exit(bool(wrong))


main()
