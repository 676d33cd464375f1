#!/usr/bin/env python3
"""Held-out check of `detune advise`, from outside.

    python3 tests/held_out_advice.py target/release/detune [--robots 4] [--seed 1] [--scan 20000] [--keep DIR]

Draws random robots and jobs, runs the program on them, and compares its advice with a computation of its own that
follows the words of the guide alone: mechanics and paths as in held_out.py, safe speeds by a scan, schedules by a scan
and by dynamic programming, the cutting force as it runs in time. Needs numpy. Exit code 0 if nothing disagrees; else 1,
and every disagreement is printed with the files that show it. The same seed draws the same robots and jobs.

What is compared, and how far apart it may lie:

    safe or not at every 0.1 rpm over 20 000 points of the path    equal, but within 0.3 rpm of a told end
    told ends against the scan's                                   0.3 rpm
    recommended speed: inside a safe stretch, the nearest there    1.1 rpm (it is round)
    its distance to the nearest mode and line                      0.01 percent points
    its feed                                                       1e-9 of it
    the job written: exit code of `check`, verdict                 0, clear
    schedules at 10 000 points: contact with a band                none outside what is told
    programmed schedules that are kept, at as many                 no contact with a band
    spindle speed; acceleration between all corners                within the limits
    time in bands that are crossed, over what the spindle's        1.02
      acceleration takes; ends of exposures                        0.001 of their width
    what is minimised, against a dynamic programme on a grid       1 % above at most
    no safe speed: no number, exit 1, the largest distance that    0.2 percent points
      any speed of a scan keeps, its mode and line named
    other cutters, tool turned, spindle: the margin told           0.2 percent points
    vibration of the tool tip where it is largest                  1 %
"""

import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "held_out"))

from drawing import draw_arm, draw_job, draw_random_robot  # noqa: E402
from figures import COUNTS, FAILURES, WHERE, WORST, expect, fail, worst  # noqa: E402
from mechanics import frame, rotation_exp, rpy_angles, yaml_of  # noqa: E402
from paths import JointPath, PosePath, joints_of, lines_of, poses_of, rpm_of  # noqa: E402

STEP_RPM = 0.1
NEAR_RPM = 0.3
DENSE = 10_000
ROUND_RPM = 1.1
KINDS = ["tree", "spherical wrist", "tree", "offset wrist"]
# Ktc, Krc in N/mm2 and Kte, Kre in N/mm: Chin. J. Mech. Eng. 2021, 10.1186/s10033-021-00536-9, Table 5.
# Ktc, Krc, Kac in N/mm2, Kte, Kre, Kae in N/mm.
MATERIALS = {"al-6082": (631, 99, 273, 13, 10, 2.8), "al-7075": (767, 169, 222, 27.7, 26.6, 0.7),
             "al-6061": (244, 113.5, 0, 7.53, 7.83, 0)}


def all_lines(job):
    """Teeth with uneven pitch also have lines between those of even ones: where they weigh 2 % at least."""
    lines, teeth = lines_of(job), job["tool"]["teeth"]
    if "pitch_deg" not in job["tool"]:
        return lines
    angles = np.radians(np.cumsum(job["tool"]["pitch_deg"]))
    taken = {order for *_, order in lines}
    top = max(h for source, h, _ in lines if source == "tooth_passing") * teeth
    more = [k for k in range(1, top + 1) if k not in taken and abs(np.exp(1j * k * angles).mean()) >= 0.02]
    return lines + [("spindle", k, k) for k in more]


class Modes:
    """What each mode covers along a path: its frequencies at equal steps where it counts, sorted."""

    def __init__(self, job, robot, path, scan):
        policy = job["policy"]
        self.policy, self.lines = policy, all_lines(job)
        self.wide = (policy.get("separation_percent", 10) + policy.get("model_uncertainty_percent", robot.uncertainty)) / 100
        # A turn on the spot may be over within a step of the scan: each move has its share of points.
        ends = path.time / path.duration
        quick = [np.linspace(a, b, 401) for a, b in zip(ends[:-1], ends[1:]) if 0 < b - a < 400 / scan]
        s = np.unique(np.concatenate([np.linspace(0, 1, scan + 1), *quick]).clip(0, 1))
        q = path.at(s)
        least = policy.get("min_tip_response_um_per_n", 0)
        if least > 0:
            f, _, tip = robot.modes(q, frame(job.get("tcp"))[1])
            counts = tip >= least
        else:
            f = robot.frequencies(q)
            counts = np.ones(f.shape, dtype=bool)
        # A mode that begins to count between two points does so at a frequency that neither has.
        i, r = np.nonzero(counts[1:] != counts[:-1])
        a, b, row = s[i], s[i + 1], np.arange(len(i))
        at = np.empty((0, robot.n))
        for _ in range(20 if len(i) else 0):
            middle = 0.5 * (a + b)
            at, _, tip = robot.modes(path.at(middle), frame(job.get("tcp"))[1])
            same = (tip[row, r] >= least) == counts[i, r]
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        self.sorted = [np.sort(np.concatenate([f[counts[:, k], k], at[r == k, k]])) for k in range(robot.n)]

    def checks_nothing(self, spindle):
        """No mode counts anywhere, or every line is somebody else's business at every speed."""
        rpm = np.arange(spindle["min_rpm"], spindle["max_rpm"] + 0.5 * STEP_RPM, STEP_RPM)
        return not any(map(len, self.sorted)) or all(ignored.all() for _, _, ignored in self.lines_at(rpm))

    def lines_at(self, rpm):
        """(order, line's frequency, whether it is somebody else's business) at speeds."""
        for _, _, order in self.lines:
            hz = order * rpm / 60
            ignored = np.zeros(np.shape(hz), dtype=bool)
            for low, high in self.policy.get("ignore_hz", []):
                ignored |= (hz >= low) & (hz <= high)
            yield order, hz, ignored

    def is_safe(self, rpm):
        safe, nothing = np.ones(len(rpm), dtype=bool), np.ones(len(rpm), dtype=bool)
        for _, hz, ignored in self.lines_at(rpm):
            nothing &= ignored
            for f in self.sorted:
                first = np.searchsorted(f, hz / (1 + self.wide), side="right")
                bound = hz / (1 - self.wide) if self.wide < 1 else np.inf
                hit = np.append(f, np.inf)[first] < bound
                safe &= ~hit | ignored
        # Where every line is somebody else's business, nothing is checked.
        return safe & ~nothing

    def separation(self, rpm):
        """The least |line - f| / f of what counts at each speed; infinite where nothing does."""
        least = np.full(len(rpm), np.inf)
        for _, hz, ignored in self.lines_at(rpm):
            for f in self.sorted:
                if len(f) == 0:
                    continue
                at = np.searchsorted(f, hz)
                for i in (np.clip(at - 1, 0, len(f) - 1), np.clip(at, 0, len(f) - 1)):
                    apart = np.abs(hz - f[i]) / f[i]
                    # Between two samples of one mode that lie close together there is every frequency.
                    least = np.where(ignored, least, np.minimum(least, apart))
        return least


def run(detune, *args):
    return subprocess.run([detune, *map(str, args)], capture_output=True, text=True, timeout=900)


def path_of(job, robot, operation, told):
    feed, tcp = operation["feed_mm_per_min"] / 60000, frame(job.get("tcp"))
    if "joints_deg" in operation["path"]:
        return JointPath(robot, joints_of(robot, operation["path"]["joints_deg"]), feed, tcp)
    start = np.array(told["samples"][0]["joints_rad"])
    path = PosePath(robot, poses_of(job, operation["path"]["poses"]), feed, tcp, start)
    return path if path.ok else None


def mean_rpm(operation):
    if "spindle_rpm" in operation:
        return operation["spindle_rpm"]
    points = operation["spindle_schedule"]
    s = np.unique([0.0, 1.0] + [p["s"] for p in points])
    return np.trapezoid(rpm_of(operation, s), s)


def compare_safe(modes, spindle, told, where):
    rpm = np.arange(spindle["min_rpm"], spindle["max_rpm"] + 0.5 * STEP_RPM, STEP_RPM)
    safe = modes.is_safe(rpm)
    inside = np.zeros(len(rpm), dtype=bool)
    near = np.zeros(len(rpm), dtype=bool)
    changes = 0.5 * (rpm[1:] + rpm[:-1])[safe[1:] != safe[:-1]]
    last = -np.inf
    for low, high in told:
        if not last < low <= high:
            fail(where, f"safe stretches do not ascend: {told}")
        last = high
        inside |= (rpm >= low) & (rpm <= high)
        near |= (np.abs(rpm - low) <= NEAR_RPM) | (np.abs(rpm - high) <= NEAR_RPM)
        if high - low > 2 * STEP_RPM:
            for end in (low, high):
                if spindle["min_rpm"] < end < spindle["max_rpm"]:
                    expect("end of a safe stretch, rpm", np.abs(changes - end).min(initial=np.inf), NEAR_RPM, where)
    wrong = (inside != safe) & ~near
    if wrong.any():
        i = np.flatnonzero(wrong)[0]
        fail(where, f"{rpm[i]:.1f} rpm: told {'safe' if inside[i] else 'closed'}, the scan says otherwise; {wrong.sum()} such")
    COUNTS["safe stretches told"] += len(told)
    COUNTS["speeds scanned"] += len(rpm)


def compare_constant(modes, operation, advice, where):
    rpm, programmed = advice["recommended_rpm"], mean_rpm(operation)
    stretches = advice["safe_speeds_rpm"]
    if not any(low <= rpm <= high for low, high in stretches):
        fail(where, f"recommended {rpm} lies in no safe stretch")
    least = min(0 if low <= programmed <= high else min(abs(low - programmed), abs(high - programmed)) for low, high in stretches)
    wide = [x for x in stretches if x[1] - x[0] > 2]
    if wide:
        expect("recommended speed beyond the nearest, rpm", abs(rpm - programmed) - least, ROUND_RPM if len(wide) == len(stretches) else np.inf, where)
    if advice["status"] == "constant":
        own = modes.separation(np.array([rpm]))[0]
        told = advice["separation_percent"]
        if told is None:
            if np.isfinite(own):
                fail(where, f"separation null, here {100 * own}")
        else:
            expect("separation of the recommended speed, points", abs(100 * own - told), 0.01, where)
        feed = operation["feed_mm_per_min"] * rpm / programmed
        expect("feed, relative", abs(advice["recommended_feed_mm_per_min"] / feed - 1), 1e-9, where)
    COUNTS["constant speeds"] += 1


def compare_schedule(job, robot, modes, path, operation, advice, where):
    points = advice["schedule"]
    facts = advice["schedule_facts"]
    if facts is None:
        return compare_kept(job, robot, modes, path, operation, points, where)
    s, rpm = np.array([p["s"] for p in points]), np.array([p["rpm"] for p in points])
    if s[0] != 0 or s[-1] != 1 or (np.diff(s) <= 0).any():
        fail(where, "a schedule's corners do not ascend from 0 to 1")
    spindle = job["spindle"]
    if rpm.min() < spindle["min_rpm"] or rpm.max() > spindle["max_rpm"]:
        fail(where, f"a schedule of {rpm.min()}..{rpm.max()} rpm")
    limit = spindle["max_acceleration_rpm_per_s"]
    own = path.duration
    if not getattr(path, "standing", 0):
        own *= operation["feed_mm_per_min"] / advice["recommended_feed_mm_per_min"]
    expect("duration under a schedule, relative", abs(facts["duration_s"] / own - 1), 1e-6, where)
    rate = np.abs(np.diff(rpm) / np.diff(s)) / facts["duration_s"]
    expect("spindle acceleration, share of the limit", rate.max(initial=0) / limit, 1.0, where)
    dense = np.linspace(0, 1, DENSE + 1)
    told = np.zeros(len(dense), dtype=bool)
    for e in facts["exposures"]:
        told |= (dense > e["from_s"] - 2 / DENSE) & (dense < e["to_s"] + 2 / DENSE)
    f, counts = scan_schedule(job, robot, modes, path, dense, np.interp(dense, s, rpm), told, where)
    if facts["exposures"]:
        compare_crossings(job, robot, modes, path, s, rpm, facts, limit, where)
    COUNTS["schedules that cross" if facts["exposures"] else "schedules"] += 1
    if not facts["exposures"]:
        best = programme(modes, job, mean_rpm(operation), f, counts, path.duration, own)
        if np.isfinite(best):
            COUNTS["schedules against a dynamic programme"] += 1
            expect("objective over the dynamic programme's", facts["objective"] / max(best, 1e-9), 1.01, where)


def scan_schedule(job, robot, modes, path, dense, rpm, told, where):
    """No line in a band at any of the places but those that are told; frequencies there, and whether they count."""
    f, _, tip = robot.modes(path.at(dense), frame(job.get("tcp"))[1])
    counts = tip >= job["policy"].get("min_tip_response_um_per_n", 0)
    for _, hz, ignored in modes.lines_at(rpm):
        hit = ((np.abs(hz[:, None] - f) < f * modes.wide) & counts).any(axis=1) & ~ignored & ~told
        if hit.any():
            fail(where, f"a schedule meets a band at s = {dense[np.flatnonzero(hit)[0]]}")
    return f, counts


def compare_kept(job, robot, modes, path, operation, points, where):
    """A programmed schedule that is kept is the programmed one, and keeps out of every band."""
    if points != operation.get("spindle_schedule"):
        return fail(where, "a schedule without facts is not the programmed one")
    dense = np.linspace(0, 1, DENSE + 1)
    told = np.zeros(len(dense), dtype=bool)
    scan_schedule(job, robot, modes, path, dense, rpm_of(operation, dense), told, where)
    COUNTS["schedules kept"] += 1


def compare_crossings(job, robot, modes, path, s, rpm, facts, limit, where):
    """Time in bands, of the schedule as it stands: what is told, and what full acceleration takes."""
    reached, stays = -1.0, []
    for a, b in sorted((e["from_s"], e["to_s"]) for e in facts["exposures"]):
        if a > reached + 1e-12:
            stays.append([a, b])
        reached = max(reached, b)
        stays[-1][1] = reached
    for a, b in stays:
        # A little outside, the line is out of the band, a little inside, in it.
        hair = 1e-3 * (b - a)
        places = np.array([a - hair, a + hair, b - hair, b + hair])
        f, _, tip = robot.modes(path.at(np.clip(places, 0, 1)), frame(job.get("tcp"))[1])
        counts = tip >= job["policy"].get("min_tip_response_um_per_n", 0)
        inside = np.zeros(4, dtype=bool)
        for _, hz, ignored in modes.lines_at(np.interp(places, s, rpm)):
            inside |= ((np.abs(hz[:, None] - f) < f * modes.wide) & counts).any(axis=1) & ~ignored
        if inside.tolist() != [False, True, True, False]:
            fail(where, f"exposure {a}..{b}: in a band at its ends {inside.tolist()}")
        seconds = (b - a) * facts["duration_s"]
        least = abs(np.interp(b, s, rpm) - np.interp(a, s, rpm)) / limit
        expect("time in bands over full acceleration's", seconds / least, 1.02, where)
        COUNTS["passages through bands"] += 1


def programme(modes, job, programmed, f, counts, *durations):
    """The least of sum w (n/p - 1)^2 + 1e-3 sum (dn/p)^2 / ds over a grid of speeds."""
    cells, per_cell = 100, DENSE // 100
    low, high = job["spindle"]["min_rpm"], job["spindle"]["max_rpm"]
    reach = job["spindle"]["max_acceleration_rpm_per_s"] * min(durations) / cells
    levels = min(int(math.ceil((high - low) / max(reach / 8, 1e-9))), 600) + 1
    speed = np.linspace(low, high, levels)
    window = int(reach / (speed[1] - speed[0]) + 1e-9)
    if window < 3:
        return math.inf  # too coarse a grid
    window = min(window, 40)
    near = (speed / programmed - 1) ** 2 / cells

    def free(sample, n):
        clear = np.ones(len(n), dtype=bool)
        g = f[sample][counts[sample]]
        for _, hz, ignored in modes.lines_at(n):
            clear &= ~(np.abs(hz[:, None] - g) < g * modes.wide).any(axis=1) | ignored
        return clear

    cost = np.where(free(0, speed), 0.5 * near, math.inf)
    for i in range(cells):
        weight = 0.5 if i + 1 == cells else 1.0
        following = np.full(levels, math.inf)
        for d in range(-window, window + 1):
            a = np.arange(max(0, -d), min(levels, levels - d))
            a = a[np.isfinite(cost[a])]
            change = (speed[1] - speed[0]) * d / programmed
            total = cost[a] + weight * near[a + d] + 1e-3 * change**2 * cells
            better = total < following[a + d]
            a, total = a[better], total[better]
            for j in range(0, per_cell + 1, per_cell // 5):
                clear = free(i * per_cell + j, speed[a] + (speed[a + d] - speed[a]) * j / per_cell)
                a, total = a[clear], total[clear]
            following[a + d] = total
        cost = following
    return cost.min()


def compare_infeasible(modes, spindle, advice, where):
    for key in ("recommended_rpm", "schedule", "separation_percent", "recommended_feed_mm_per_min"):
        if advice[key] is not None:
            fail(where, f"no speed is safe, yet {key} is {advice[key]}")
    COUNTS["without a safe speed"] += 1
    compare_binding(modes, spindle, advice, where)
    levers = advice["levers"]
    if not levers or not levers[0]["opens"]:
        fail(where, f"no lever opens a gap: {levers}")


def compare_binding(modes, spindle, advice, where):
    binding = advice["binding"]
    rpm = np.arange(spindle["min_rpm"], spindle["max_rpm"] + 0.05, 0.25)
    if binding is None:
        return  # gaps that are too narrow
    own = modes.separation(rpm).max()
    expect("largest distance of any speed, points", abs(max(binding["separation_percent"], 0) - 100 * own), 0.2, where)
    for pair in (binding["below"], binding["above"]):
        if pair is not None:
            source = pair["source"].replace("_", " ")
            if f"mode {pair['mode']} with {source} × {pair['harmonic']}" not in advice["reason"]:
                fail(where, f"{pair} is not named: {advice['reason']}")


def compare_levers(detune, job, robot, path, operation, advice, scan, folder, where):
    spindle = job["spindle"]
    for lever in advice["levers"]:
        name, told = lever["lever"], lever["margin_percent"]
        rpm = np.arange(spindle["min_rpm"], spindle["max_rpm"] + 0.05, 0.25)
        if name == "tool":
            other = {**job, "tool": {"teeth": lever["teeth"]}}
            modes = Modes(other, robot, path, scan // 5)
        elif name == "turn_tool" and isinstance(path, PosePath):
            turned = turned_path(detune, job, robot, operation, math.radians(lever["angle_deg"]), folder)
            if turned is None:
                COUNTS["turned paths that this check cannot follow"] += 1
                continue
            modes = Modes(job, robot, turned, scan // 5)
        elif name == "spindle":
            modes = Modes(job, robot, path, scan // 5)
            at = lever["rpm"]
            if not modes.is_safe(np.array([at]))[0] or spindle["min_rpm"] <= at <= spindle["max_rpm"]:
                fail(where, f"lever {lever} opens nothing")
            rpm = np.arange(min(at, spindle["min_rpm"]), max(at, spindle["max_rpm"]) + 0.05, 0.25)
            rpm = np.append(rpm, at)
        else:
            continue
        own = modes.separation(rpm).max()
        COUNTS[f"levers: {name}"] += 1
        if told is None:
            if np.isfinite(own):
                fail(where, f"lever {name}: margin null, here {100 * own}")
        else:
            expect(f"margin of lever {name}, points", abs(max(told, 0) - 100 * own), 0.2, where)


def turned_path(detune, job, robot, operation, angle, folder):
    """The path with the tool turned about its axis. Where it starts, and so the arm's branch, is the program's word."""
    tcp, (rw, _) = frame(job.get("tcp")), frame(job.get("work_object"))
    turn = rotation_exp(np.array([0, 0, angle]))
    rows = [
        {**row, "rpy_deg": np.degrees(rpy_angles(rw.T @ r @ turn)).tolist()}
        for row, (r, _) in zip(operation["path"]["poses"], poses_of(job, operation["path"]["poses"]))
    ]
    one = {**job, "operations": [{**operation, "path": {"poses": rows}}]}
    file = folder / "turned.yaml"
    file.write_text(yaml_of(one))
    done = run(detune, "check", file, "--format", "json")
    if done.returncode not in (0, 1):
        return None
    return path_of(one, robot, one["operations"][0], json.loads(done.stdout)["jobs"][0]["operations"][0])


def compare_vibration(job, robot, path, operation, advice, where):
    """The amplitude where it is told to be largest, from the force over a turn of the spindle."""
    vibration = advice["vibration"]
    if vibration is None:
        return
    chip = operation["feed_mm_per_min"] / 1000 / (job["tool"]["teeth"] * mean_rpm(operation))
    for tip in (vibration["programmed"], vibration["recommended"]):
        if tip is None:
            continue
        own = amplitude_um(job, robot, path, operation, tip["s"], tip["rpm"], chip)
        if own is None:
            COUNTS["tool tips that stand still"] += 1
            continue
        expect("vibration of the tool tip, relative", abs(tip["amplitude_um"] / own - 1), 0.01, where)
        COUNTS["tool tips"] += 1


def amplitude_um(job, robot, path, operation, s, rpm, chip_m):
    cutting, teeth = operation["cutting"], job["tool"]["teeth"]
    ktc, krc, kac, kte, kre, kae = MATERIALS[cutting["material"]]
    n = 1 << 15
    angle = 2 * np.pi * (np.arange(n) + 0.5) / n
    arc = math.acos(max(1 - 2 * cutting["radial_depth_mm"] / job["tool"]["diameter_mm"], -1))
    entry, leave = {"slot": (0, math.pi), "conventional": (0, arc), "climb": (math.pi - arc, math.pi)}[cutting["direction"]]
    pitch = np.radians(job["tool"].get("pitch_deg", [360 / teeth] * teeth))
    force = np.zeros((n, 3))
    for theta, following in zip(np.cumsum(pitch) - pitch, pitch):
        phi = (angle + theta) % (2 * np.pi)
        cuts = (phi >= entry) & (phi < leave)
        chip_mm = 1000 * chip_m * following * teeth / (2 * np.pi) * np.sin(phi)
        ft = cutting["axial_depth_mm"] * (ktc * chip_mm + kte) * cuts
        fr = cutting["axial_depth_mm"] * (krc * chip_mm + kre) * cuts
        fa = cutting["axial_depth_mm"] * (kac * chip_mm + kae) * cuts
        force += np.stack([-ft * np.cos(phi) - fr * np.sin(phi), ft * np.sin(phi) - fr * np.cos(phi), -fa], axis=1)
    spectrum = 2 * np.fft.rfft(force, axis=0) / n
    # The frame of the cut: x with the feed, z out of the work.
    tcp = frame(job.get("tcp"))
    around = np.clip([s - 1e-5, s, s + 1e-5], 0, 1)
    r, p, _ = robot.tool(path.at(around), *tcp)
    up = -r[1] @ [0, 0, 1]
    along = p[2] - p[0]
    along = along - up * (up @ along)
    if np.linalg.norm(along) < 1e-9:
        return None  # no feed, so no direction
    x = along / np.linalg.norm(along)
    y = np.cross(up, x)
    f, zeta, motion = tip_motions(robot, path.at(np.array([s])), tcp[1])
    omega_r = 2 * np.pi * f
    step = 1 if "pitch_deg" in job["tool"] else teeth
    total = 0.0
    for k in range(step, 12 * teeth + 1, step):
        omega = 2 * np.pi * k * rpm / 60
        pushed = spectrum[k, 0] * (x @ motion) + spectrum[k, 1] * (y @ motion) + spectrum[k, 2] * (up @ motion)
        u = motion @ (pushed / (omega_r**2 - omega**2 + 2j * zeta * omega_r * omega))
        total += (np.abs(u) ** 2).sum()
    return 1e6 * math.sqrt(total)


def tip_motions(robot, q, tcp_p):
    """f, zeta and J phi (3 x n) at one pose."""
    m, k, frames, axes, origins = robot.matrices(q)
    low = np.linalg.cholesky(m[0])
    inverse = np.linalg.inv(low)
    values, vectors = np.linalg.eigh(inverse @ k[0] @ inverse.T)
    phi = inverse.T @ vectors
    omega = np.sqrt(values)
    energy = robot.k[:, None] * phi**2
    zeta = (robot.zeta[:, None] * energy).sum(axis=0) / energy.sum(axis=0)
    r, p = frames[robot.tip]
    point = (p + r @ np.array(tcp_p))[0]
    j = np.zeros((3, robot.n))
    for c in robot.carries[robot.tip]:
        j[:, c] = axes[c][0] if robot.coordinates[c][1] else np.cross(axes[c][0], point - origins[c][0])
    return omega / (2 * np.pi), zeta, j @ phi


def compare_job(detune, robot, job, file, scan, more):
    where = str(file)
    target = file.with_name(file.stem + "_advised.yaml")
    done = run(detune, "advise", file, "--format", "json", "--write", target, *more)
    if done.returncode not in (0, 1):
        return fail(where, f"exit {done.returncode}: {done.stderr[:300]}")
    advice = json.loads(done.stdout)
    paths = json.loads(run(detune, "check", file, "--format", "json").stdout)["jobs"][0]["operations"]
    clear = True
    for operation, told, as_run in zip(job["operations"], advice["operations"], paths):
        here = f"{where}#{operation['name']}"
        path = path_of(job, robot, operation, as_run)
        status = told["status"]
        crosses = status == "scheduled" and (told["schedule_facts"] or {}).get("exposures")
        clear &= status != "infeasible" and not crosses
        if path is None or path.duration == 0:
            COUNTS["paths that this check leaves out"] += 1
            continue
        COUNTS["operations"] += 1
        modes = Modes(job, robot, path, scan)
        # No speed is known to be safe, as a check of any says `unchecked`.
        if modes.checks_nothing(job["spindle"]):
            COUNTS["operations of which nothing is checked"] += 1
            if status != "infeasible" or told["safe_speeds_rpm"] or "nothing was checked" not in told["reason"]:
                fail(here, f"nothing is checked, told {status}: {told['reason']}")
            continue
        compare_safe(modes, job["spindle"], told["safe_speeds_rpm"], here)
        if told["recommended_rpm"] is not None:
            compare_constant(modes, operation, told, here)
        if status == "scheduled":
            compare_schedule(job, robot, modes, path, operation, told, here)
        if told["recommended_rpm"] is None:
            compare_binding(modes, job["spindle"], told, here)
            compare_levers(detune, job, robot, path, operation, told, scan, file.parent, here)
        if status == "infeasible":
            compare_infeasible(modes, job["spindle"], told, here)
        compare_vibration(job, robot, path, operation, told, here)
    if done.returncode != int(not clear):
        fail(where, f"exit {done.returncode}, must be {int(not clear)}")
    if target.exists() != clear:
        fail(where, f"written: {target.exists()}, must be {clear}")
    if clear:
        COUNTS["jobs written"] += 1
        again = run(detune, "check", target, "--format", "json", "--fail-on", "never")
        if again.returncode != 0 or any(o["crossings"] for o in json.loads(again.stdout)["jobs"][0]["operations"]):
            fail(where, f"check of the job written: exit {again.returncode}")


def draw_spindle(rng, robot, job):
    """A range of speeds in which lines meet modes; often so narrow that nothing is safe."""
    f = robot.frequencies(np.zeros((1, len(robot.moving))))[0]
    order = lines_of(job)[0][2]
    middle = 60 * f[int(rng.integers(min(3, len(f))))] / order * rng.uniform(0.8, 1.25)
    spread = float(rng.choice([1.15, 1.4, 2.0, 3.0]))
    low, high = round(middle / spread, 1), round(min(middle * spread, middle / spread + 5000), 1)
    job["spindle"] = {"min_rpm": low, "max_rpm": high, "max_acceleration_rpm_per_s": round(float(np.exp(rng.uniform(2, 6.5))), 1)}
    for operation in job["operations"]:
        if "spindle_schedule" in operation and rng.random() < 0.5:
            operation["spindle_schedule"] = [{"s": s, "rpm": float(rng.uniform(low, high))} for s in (0.0, 0.4, 1.0)]
        else:
            operation.pop("spindle_schedule", None)
            operation["spindle_rpm"] = float(round(rng.uniform(low, high), 1))
        if "poses" in operation["path"] and rng.random() < 0.5:
            operation["free_axis_deg"] = [-40, 40]
        if rng.random() < 0.5:
            job["tool"]["diameter_mm"] = 12.0
            operation["cutting"] = {
                "radial_depth_mm": float(rng.uniform(0.5, 12)),
                "axial_depth_mm": float(rng.uniform(0.5, 4)),
                "direction": str(rng.choice(["climb", "conventional", "slot"])),
                "material": str(rng.choice(sorted(MATERIALS))),
            }
    teeth = job["tool"]["teeth"]
    if rng.random() < 0.5:
        job["tools_on_hand"] = [{"teeth": int(z)} for z in range(1, 7) if z != teeth][:3]
    if teeth > 1 and rng.random() < 0.3:
        pitch = 360 / teeth + rng.uniform(-8, 8, teeth)
        job["tool"]["pitch_deg"] = [float(p) for p in (pitch - pitch.mean() + 360 / teeth)]
    policy = job["policy"]
    policy.pop("ignore_hz", None)
    if rng.random() < 0.3:
        hz = order * middle / 60 * rng.uniform(0.7, 1.4)
        policy["ignore_hz"] = [[hz * 0.97, hz * 1.01], [hz * 1.49, hz * 1.61]]
    policy["separation_percent"] = float(rng.choice([1, 2, 4, 8]))
    policy["model_uncertainty_percent"] = float(rng.choice([0, 0.5, 2, 5]))


def check_robot(detune, index, options, home):
    rng = np.random.default_rng([options.seed, index + 1, 5])
    kind = KINDS[index % len(KINDS)]
    robot = draw_random_robot(rng) if kind == "tree" else draw_arm(rng, kind == "spherical wrist")
    folder = home / f"robot_{options.seed}_{index + 1:02}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(robot.urdf())
    (folder / "robot.yaml").write_text(yaml_of(robot.yaml))
    COUNTS[f"robots: {kind}"] += 1
    for number in range(options.jobs):
        job = draw_job(rng, robot, kind != "tree" and rng.random() < 0.75)
        draw_spindle(rng, robot, job)
        file = folder / f"job_{number + 1}.yaml"
        file.write_text(yaml_of(job))
        more = ["--schedule"] if number % 2 else []
        compare_job(detune, robot, job, file, options.scan, more)
    return f"{folder.name} {kind}: {len(robot.moving)} joints, {robot.n} coordinates"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("detune", help="path of the program")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", type=int, default=4, help="how many robots to draw")
    parser.add_argument("--jobs", type=int, default=4, help="how many jobs for each")
    parser.add_argument("--scan", type=int, default=20_000, help="steps of the scan along the path")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files (default: temporary, kept on disagreement)")
    options = parser.parse_args()
    detune = os.path.abspath(options.detune)
    home = options.keep or pathlib.Path(tempfile.mkdtemp(prefix="held-out-advice-"))
    started = time.time()
    for index in range(options.robots):
        told = check_robot(detune, index, options, home)
        print(f"{told}, {time.time() - started:.0f} s", flush=True)
    print("worst figures")
    for figure in sorted(WORST):
        print(f"  {figure:50} {WORST[figure]:.2e}  {WHERE.get(figure, '')}")
    print("counts")
    for name in sorted(COUNTS):
        print(f"  {name:50} {COUNTS[name]}")
    if COUNTS["operations"] == 0 or COUNTS["safe stretches told"] == 0:
        fail("the whole run", "nothing was compared")
    print(f"{len(FAILURES)} disagreements, {time.time() - started:.0f} s" + (f"; files in {home}" if FAILURES else ""))
    for line in FAILURES:
        print("  DISAGREES", line)
    if not FAILURES and options.keep is None:
        shutil.rmtree(home)
    sys.exit(1 if FAILURES else 0)


if __name__ == "__main__":
    main()
