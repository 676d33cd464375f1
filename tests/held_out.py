#!/usr/bin/env python3
"""Held-out check of `detune check` and `detune map`, from outside.

    python3 tests/held_out.py target/release/detune [--robots 4] [--seed 1] [--scan 20000] [--keep DIR]

Draws random robots (URDF and robot.yaml) and jobs, runs the program on them, and compares what it says with a
computation of its own that follows the words of the guide alone and shares no code and no method with the program:
see held_out/mechanics.py and held_out/paths.py. Needs numpy. Exit code 0 if nothing disagrees; else 1, and every
disagreement is printed with the files that show it. The same seed draws the same robots and jobs.

What is compared, and how far apart it may lie:

    frequencies at every sample of a check and every row of a map           1e-9 of the frequency
    tip response at samples; at the closest point of a crossing             1e-6; 1e-5 of the response
    duration of an operation                                                1e-6 of the duration
    joints at every sample (the time law, the arm's branch)                 2e-6 rad or m
    the tool on its straight line: position; orientation                    1e-7 m; 1e-7 rad
    crossings against a scan of 20 000 equal steps in s: each one there,    2e-3 of the path at each end
      of its certainty, none besides, but for those narrower than the scan
      can tell
    separation at the closest point, against own frequency there            1e-5 percent points
    excitation frequency there                                              1e-9 of the frequency
    verdicts of operation, job and call; exit codes with --fail-on          equal

A crossing wider than 2e-4 of the path that is not found is a failure. Frequencies are computed in 80-bit floats where
the machine has them, so the 1e-9 is the program's own.
"""

import argparse
import collections
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "held_out"))

from drawing import draw_arm, draw_job, draw_pose, draw_random_robot  # noqa: E402
from figures import COUNTS, FAILURES, WHERE, WORST, expect, fail, worst  # noqa: E402
from mechanics import LONGEST, frame, rotation_log, yaml_of  # noqa: E402
from paths import JointPath, PosePath, joints_of, poses_of, rpm_of, runs_of, states  # noqa: E402

SCAN = 20_000
END_TOLERANCE = 2e-3  # share of the path
HIDDEN = 2e-4  # a crossing wider than this must be found
DUST_STEPS = 2.5  # what a scan cannot tell, in its steps
KINDS = ["tree", "spherical wrist", "tree", "offset wrist"]


def compare_operation(job, robot, operation, told, path, tcp, where, scan):
    """One operation of a check's answer against the path as computed here; the number of its verdict."""
    COUNTS["operations"] += 1
    expect("duration_s, relative", abs(told["duration_s"] - path.duration) / max(path.duration, 1e-300) if path.duration else abs(told["duration_s"]), 1e-6, where)
    samples = told["samples"]
    s = np.array([x["s"] for x in samples])
    q = np.array([x["joints_rad"] for x in samples])
    f = np.array([x["natural_frequencies_hz"] for x in samples])
    if s[0] != 0 or s[-1] != 1 or (np.diff(s) <= 0).any():
        fail(where, "samples do not ascend from 0 to 1")
    # (a) frequencies where the program looked, in 80 bits.
    own = np.concatenate([robot.frequencies(q[i : i + 4000].astype(LONGEST)) for i in range(0, len(q), 4000)])
    COUNTS["samples"] += len(s)
    expect("frequency at samples, relative", (np.abs(f - own) / own).max(), 1e-9, where)
    _, _, tip = robot.modes(q, tcp[1])
    told_tip = np.array([x["tip_response_um_per_n"] for x in samples])
    gap = np.diff(own.astype(float), axis=1) / own[:, :-1].astype(float)
    clear = np.ones(own.shape, dtype=bool)  # shapes of modes that nearly coincide are no figures to compare
    clear[:, 1:] &= gap > 1e-4
    clear[:, :-1] &= gap > 1e-4
    scale = np.maximum(tip, 1e-9 * tip.max(axis=1, keepdims=True))
    expect("tip response at samples, relative", (np.abs(told_tip - tip) / scale)[clear].max(initial=0), 1e-6, where)
    # (b) the time law.
    mine = path.at(s)
    expect("joints at samples, rad or m", np.abs(mine - q).max(), 2e-6, where)
    # (c) straight lines.
    if isinstance(path, PosePath):
        COUNTS["pose operations"] += 1
        r, p, _ = robot.tool(q, *tcp)
        rg, pg = path.pose(s)
        expect("line: position, m", np.abs(p - pg).max(), 1e-7, where)
        expect("line: orientation, rad", np.abs(rotation_log(rg.swapaxes(1, 2) @ r)).max(), 1e-7, where)
        jumps = np.abs(np.diff(q, axis=0)).max(axis=1)
        expect("line: largest joint step between samples, rad", jumps.max(initial=0), 0.06, where)
    # The scan.
    grid = np.linspace(0, 1, scan + 1)
    gq = path.at(grid)
    if job.get("policy", {}).get("min_tip_response_um_per_n", 0) > 0:
        gf, _, gt = robot.modes(gq, tcp[1])
    else:
        gf, gt = robot.frequencies(gq), None
    crossings = collections.defaultdict(list)
    for c in told["crossings"]:
        crossings[(c["source"], c["harmonic"], c["mode"])].append(c)
    verdict = 0
    COUNTS["crossings told"] += len(told["crossings"])
    for line, r, state, apart, exc in states(job, robot, operation, grid, gf, gt):
        key = (line[0], line[1], r + 1)
        mine = runs_of(state, grid)
        COUNTS["crossings scanned"] += len(mine)
        verdict = max(verdict, state.max())
        match_runs(mine, crossings.pop(key, []), apart, where, key, scan)
    for key, extra in crossings.items():
        for c in extra:
            width = c["to_s"] - c["from_s"]
            if width > DUST_STEPS / scan:
                fail(where, f"extra crossing {key} {c['certainty']} {c['from_s']:.6f}..{c['to_s']:.6f}")
            else:
                COUNTS["crossings below the scan"] += 1
    # What is said at the closest points.
    for c in told["crossings"]:
        at = np.array([c["closest_s"]])
        f1, zeta, tip1 = robot.modes(path.at(at), tcp[1])
        r = c["mode"] - 1
        order = c["harmonic"] * (job["tool"]["teeth"] if c["source"] == "tooth_passing" else 1)
        exc = order * rpm_of(operation, at)[0] / 60
        expect("excitation_hz, relative", abs(exc - c["excitation_hz"]) / exc, 1e-9, where)
        expect("separation_percent at closest_s, points", abs(100 * abs(exc - f1[0, r]) / f1[0, r] - c["separation_percent"]), 1e-5, where)
        others = np.delete(f1[0], r)
        if len(others) == 0 or (np.abs(others - f1[0, r]) / f1[0, r]).min() > 1e-4:
            error = abs(tip1[0, r] - c["tip_response_um_per_n"]) / max(tip1[0, r], 1e-9 * tip1.max())
            expect("tip response at closest_s, relative", error, 1e-5, where)
        if not c["from_s"] - 1e-12 <= c["closest_s"] <= c["to_s"] + 1e-12:
            fail(where, f"closest_s {c['closest_s']} outside {c['from_s']}..{c['to_s']}")
    worst_told = max([{"certain": 2, "uncertain": 1}[c["certainty"]] for c in told["crossings"]], default=0)
    if worst_told != verdict:
        slim = [c for c in told["crossings"] if c["to_s"] - c["from_s"] <= DUST_STEPS / scan]
        if slim:
            COUNTS["verdicts that hang on less than the scan can tell"] += 1
        else:
            fail(where, f"verdict of the operation {worst_told}, the scan says {verdict}")
    return worst_told


def match_runs(mine, told, apart, where, key, scan):
    """Pairs the runs of the scan with the crossings of the program, in order."""
    told = sorted(told, key=lambda c: c["from_s"])
    used = set()
    for certainty, begin, end, first, last in mine:
        best = None
        for i, c in enumerate(told):
            if i in used or c["certainty"] != certainty:
                continue
            off = max(abs(c["from_s"] - begin), abs(c["to_s"] - end))
            if best is None or off < best[0]:
                best = (off, i)
        if best is None or best[0] > END_TOLERANCE:
            if end - begin > HIDDEN:
                fail(where, f"missing crossing {key} {certainty} {begin:.6f}..{end:.6f}" + (f" (nearest off by {best[0]:.2e})" if best else ""))
            else:
                COUNTS["narrow ones missed"] += 1
            continue
        off, i = best
        used.add(i)
        worst("end of a crossing, share of the path", off, f"{where} {key}")
        least = apart[first:last].min()
        # The scan's minimum is over its own samples: the program's may be a little lower, not higher.
        higher = told[i]["separation_percent"] / 100 - least
        expect("separation above the scan's minimum", max(higher, 0), 1e-6 + 2 * off, f"{where} {key} {begin:.4f}..{end:.4f}")
    for i, c in enumerate(told):
        if i not in used:
            if c["to_s"] - c["from_s"] > DUST_STEPS / scan:
                fail(where, f"extra crossing {key} {c['certainty']} {c['from_s']:.6f}..{c['to_s']:.6f}")
            else:
                COUNTS["crossings below the scan"] += 1


def run(detune, *args, stdin=None):
    return subprocess.run([detune, *map(str, args)], input=stdin, capture_output=True, text=True, timeout=900)


def check_job(detune, robot, job, file, where, scan):
    """Runs a job file and compares everything."""
    started = time.time()
    done = run(detune, "check", file, "--format", "json")
    worst("seconds of one check", time.time() - started, where)
    if done.returncode not in (0, 1):
        fail(where, f"exit {done.returncode}: {done.stderr.strip()[:300]}")
        return
    answer = json.loads(done.stdout)
    entry = answer["jobs"][0]
    if answer["schema"] != "check/1" or entry["job"] != str(file):
        fail(where, f"schema {answer['schema']}, job {entry['job']}")
    uncertainty = job.get("policy", {}).get("model_uncertainty_percent", robot.uncertainty)
    if abs(entry["model"]["uncertainty_percent"] - uncertainty) > 1e-9 or entry["model"]["calibrated"] != ("calibration" in robot.yaml):
        fail(where, f"model {entry['model']}")
    tcp = frame(job.get("tcp"))
    names = ["clear", "uncertain", "resonance"]
    verdict = 0
    if [o["name"] for o in entry["operations"]] != [o["name"] for o in job["operations"]]:
        fail(where, "operations differ")
    for operation, told in zip(job["operations"], entry["operations"]):
        feed = operation["feed_mm_per_min"] / 60000
        here = f"{where}#{operation['name']}"
        if abs(told["spindle_rpm"] - rpm_of(operation, np.zeros(1))[0]) > 1e-9:
            fail(here, f"spindle_rpm {told['spindle_rpm']}")
        if "joints_deg" in operation["path"]:
            path = JointPath(robot, joints_of(robot, operation["path"]["joints_deg"]), feed, tcp)
            COUNTS["standstill segments"] += path.standing
        else:
            start = np.array(told["samples"][0]["joints_rad"])
            path = PosePath(robot, poses_of(job, operation["path"]["poses"]), feed, tcp, start)
            if not path.ok:
                COUNTS["paths that this check cannot follow"] += 1
                continue
        verdict = max(verdict, compare_operation(job, robot, operation, told, path, tcp, here, scan))
    COUNTS["jobs"] += 1
    # Warnings that may hide a resonance leave a verdict at best uncertain; where nothing counts it is unchecked.
    if any(warning["hides_clear"] for warning in entry["warnings"]):
        verdict = max(verdict, 1)
    expected = names[verdict]
    if verdict < 2 and any(warning["code"] == "nothing_checked" for warning in entry["warnings"]):
        expected = "unchecked"
    COUNTS["verdict " + expected] += 1
    if entry["verdict"] != expected or answer["verdict"] != expected:
        fail(where, f"verdict {entry['verdict']}, must be {expected}")
    fails = expected in ("unchecked", "resonance")
    for fail_on, code in (("resonance", int(fails)), ("uncertain", int(expected != "clear")), ("never", 0)):
        form = {"resonance": "text", "uncertain": "junit", "never": "github"}[fail_on]
        got = done.returncode if fail_on == "resonance" else run(detune, "check", file, "--format", form, "--fail-on", fail_on).returncode
        if got != code:
            fail(where, f"--fail-on {fail_on}: exit {got}, must be {code}")


def check_map(detune, robot, rng, folder, where):
    """--poses in another order and unit, from a file or standard input; and a sweep."""
    n = len(robot.moving)
    q = np.array([draw_pose(robot, rng, 2.0) for _ in range(25)])
    titles, values = [], []
    for i in rng.permutation(n):
        if robot.slides[i]:
            unit_, column = ("m", q[:, i]) if rng.random() < 0.5 else ("mm", 1000 * q[:, i])
        else:
            unit_, column = ("rad", q[:, i]) if rng.random() < 0.5 else ("deg", np.degrees(q[:, i]))
        titles.append(f"{robot.names[i]}_{unit_}")
        values.append(column)
    text = ",".join(titles) + "\n" + "\n".join(",".join(repr(float(v)) for v in row) for row in zip(*values)) + "\n"
    file = folder / "poses.csv"
    file.write_text(text)
    if rng.random() < 0.5:
        done = run(detune, "map", folder / "robot.yaml", "--poses", file)
    else:
        done = run(detune, "map", folder / "robot.yaml", "--poses", "-", stdin=text)
    if done.returncode:
        return fail(where, f"map --poses: exit {done.returncode}: {done.stderr[:200]}")
    compare_map(robot, done.stdout, q, where)
    turning = [i for i in range(n) if not robot.slides[i]]
    i = int(rng.choice(turning))
    at = int(rng.choice(turning))
    a, b = -30.0, 41.0
    low, high = np.degrees(robot.lower[i]), np.degrees(robot.upper[i])
    a, b = max(a, low), min(b, high)
    options = ["--at", f"{robot.names[at]}=12.5"] if at != i else []
    done = run(detune, "map", folder / "robot.yaml", "--joint", robot.names[i], "--from-deg", repr(float(a)), "--to-deg", repr(float(b)), "--steps", "9", *options)
    q = np.zeros((9, n))
    q[:, i] = np.radians(np.linspace(a, b, 9))
    if options:
        q[:, at] = np.radians(12.5)
    if done.returncode:
        return fail(where, f"map --joint: exit {done.returncode}: {done.stderr[:200]}")
    compare_map(robot, done.stdout, q, where)


def compare_map(robot, text, q, where):
    rows = [l.split(",") for l in text.splitlines() if not l.startswith("#")]
    header, rows = rows[0], np.array(rows[1:], dtype=float)
    beta = robot.yaml.get("arm_angles", {}).get("beta2")
    wanted = [f"{n}_{'m' if slides else 'rad'}" for n, slides in zip(robot.names, robot.slides)]
    wanted += ["beta2_rad"] if beta else []
    wanted += [f"f{i + 1}_hz" for i in range(robot.n)]
    if sorted(header) != sorted(wanted):
        fail(where, f"map's header {header}, must have {wanted}")
        return
    column = {t: rows[:, i] for i, t in enumerate(header)}
    got = np.stack([column[t] for t in wanted[: len(robot.moving)]], axis=1)
    expect("map: joints", np.abs(got - q).max(), 1e-14, where)
    if beta:
        mine = beta.get("offset_rad", 0.0) + sum(v * got[:, robot.names.index(k)] for k, v in beta["terms"].items())
        expect("map: beta2", np.abs(column["beta2_rad"] - mine).max(), 1e-12, where)
    f = np.stack([column[f"f{i + 1}_hz"] for i in range(robot.n)], axis=1)
    own = robot.frequencies(got.astype(LONGEST))
    expect("map: frequency, relative", (np.abs(f - own) / own).max(), 1e-9, where)
    COUNTS["map rows"] += len(f)


def write_robot(robot, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(robot.urdf())
    (folder / "robot.yaml").write_text(yaml_of(robot.yaml))


def check_robot(detune, index, options, home):
    """Draws one robot and its jobs, and checks all of them."""
    rng = np.random.default_rng([options.seed, index + 1])
    kind = KINDS[index % len(KINDS)]
    robot = draw_random_robot(rng) if kind == "tree" else draw_arm(rng, kind == "spherical wrist")
    folder = home / f"robot_{options.seed}_{index + 1:02}"
    write_robot(robot, folder)
    COUNTS[f"robots: {kind}"] += 1
    check_map(detune, robot, rng, folder, f"{folder}/poses.csv")
    for number in range(int(rng.integers(3, 6))):
        posed = kind != "tree" and rng.random() < 0.75
        job = draw_job(rng, robot, posed)
        file = folder / f"job_{number + 1}.yaml"
        file.write_text(yaml_of(job))
        check_job(detune, robot, job, file, str(file), options.scan)
    return f"{folder.name} {kind}: {len(robot.moving)} joints, {robot.n} coordinates"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("detune", help="path of the program")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", type=int, default=4, help="how many robots to draw, with three to five jobs each")
    parser.add_argument("--scan", type=int, default=SCAN, help="steps of the scan")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files (default: temporary, kept on disagreement)")
    options = parser.parse_args()
    detune = os.path.abspath(options.detune)
    home = options.keep or pathlib.Path(tempfile.mkdtemp(prefix="held-out-"))
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
    if COUNTS["operations"] == 0 or COUNTS["crossings told"] == 0:
        fail("the whole run", "nothing was compared")
    print(f"{len(FAILURES)} disagreements, {time.time() - started:.0f} s" + (f"; files in {home}" if FAILURES else ""))
    for line in FAILURES:
        print("  DISAGREES", line)
    if not FAILURES and options.keep is None:
        shutil.rmtree(home)
    sys.exit(1 if FAILURES else 0)


if __name__ == "__main__":
    main()
