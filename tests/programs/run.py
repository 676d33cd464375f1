"""Random programs in every dialect against an independent computation: one list of lines, arcs, dwells and speeds,
with patterns of holes and stretches that come again, is written in each language, in random dress, and detune's samples
must lie where and when the list has them. `plain` is G-code that pygcode reads, too.

Round trips: programs with several speeds are written by `advise --write-program`. The same list with the advised
speeds, and feeds in ratio, is written again in the same dress: what the program wrote must be that text, number by
number, and every byte that states no speed or feed must be the old one. What is read back runs at the advised speeds.

    python3 tests/programs/run.py target/release/detune [--seeds N] [--round-trips N] [--pygcode]
"""

import argparse
import bisect
import itertools
import json
import math
import pathlib
import random
import re
import subprocess
import tempfile

from apt import apt
from arm import Arm
from gcode import gcode, plain
from heidenhain import heidenhain
from lists import OBJECT, TCP, advised, draw, end_of, flat, is_move, pieces, with_speeds
from robots import AXIS, ORIGIN, fanuc, held, krl, on_positioner, rapid, seen_in_hand, seen_on_positioner
from sinumerik import sinumerik

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ROBOT = ROOT / "robots" / "irb1600"

WRITERS = (plain, gcode, sinumerik, apt, rapid, held, on_positioner, krl, fanuc, heidenhain)
ROBOTS = (rapid, held, on_positioner, krl, fanuc)
# Where the tool is in the work, of joint positions, of the number of a piece and of the share of it; others have the
# work on the ground.
SEEN = {held: seen_in_hand, on_positioner: seen_on_positioner}
# An arc in any plane is one block of theirs.
BOWED = (*ROBOTS, sinumerik)
# So is a helix of these.
WOUND = (plain, gcode, sinumerik, heidenhain)

KEYS = {
    "mod": "spindle_from: {signal: aoSpindle}, mechanical_units: {STN1: {"
    f"axes: [{{name: eax_b, axis: {list(AXIS)}, origin_m: {list(ORIGIN)}}}], user_frame: {{xyz_m: {list(OBJECT)}}}}}}}",
    "src": "spindle_from: {procedure: SPINDLE}",
    "ls": "spindle_from: {comment: SPINDLE}, "
    f"tool_frames: {{1: {{xyz_m: [0, 0, {TCP}]}}}}, base_frames: {{1: {{xyz_m: {list(OBJECT)}}}}}",
}


def interpreted(text):
    """Ends of the moves of a G-code program, mm, by pygcode, which others wrote."""
    from pygcode import Line, Machine

    machine, ends = Machine(), []
    for line in text.splitlines():
        # The interpreter knows neither the marks of a file's ends nor program numbers.
        if line.startswith(("%", "O")):
            continue
        machine.process_block(Line(line.upper()).block)
        values = machine.pos.values
        end = [values[axis] for axis in "XYZ"]
        if not ends or end != ends[-1]:
            ends.append(end)
    return ends


def interpreters_agree(truth, text):
    wanted = [end_of(item) for item in flat(truth) if is_move(item)]
    found = interpreted(text)
    for end in wanted:
        while found and math.dist(found[0], end) > 1e-6:
            found.pop(0)
        if not found:
            return f"pygcode does not come to {end}"
    return None


def job_of(folder, text, extension, files, more=""):
    """The path of a job that runs a program with subprograms in files of their own."""
    for name, each in {f"p.{extension}": text, **files}.items():
        (folder / name).write_text(each)
    frames = "" if extension in ("mod", "src") else f"tcp: {{xyz_m: [0, 0, {TCP}]}}\nwork_object: {{xyz_m: {list(OBJECT)}}}\n"
    keys = [KEYS[extension]] if extension in KEYS else []
    keys += [f"files: [{', '.join(files)}]"] if files else []
    (folder / "job.yaml").write_text(
        f"robot: {ROBOT / 'robot.yaml'}\ntool: {{teeth: 2}}\npayload: none\n{frames}"
        f"spindle: {{min_rpm: 500, max_rpm: 24000}}\n{more}operations:\n  - name: all\n"
        f"    path: {{program: {{file: {', '.join([f'p.{extension}', *keys])}}}}}\n"
    )
    return folder / "job.yaml"


def check(detune, folder, seen_from, truth, text, extension, files={}):
    job = job_of(folder, text, extension, files)
    # Of each of many stretches a hundred samples are enough.
    which = "thin" if any(item[0] == "speed" and item[1] != 6000.0 for item in flat(truth)) else "all"
    command = [detune, "check", str(job), "--format", "json", "--samples", which, "--fail-on", "never"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if ran.returncode != 0:
        return f"exit code {ran.returncode}: {ran.stderr}"
    operations = json.loads(ran.stdout)["jobs"][0]["operations"]
    parts = pieces(truth)
    duration = sum(seconds for seconds, _, _ in parts)
    found = sum(operation["duration_s"] for operation in operations)
    if abs(found - duration) > 1e-6 * duration:
        return f"takes {found} s, not {duration} s"
    wanted = [rpm for _, _, rpm in parts if rpm]
    wanted = [rpm for rpm, before in zip(wanted, [None, *wanted]) if rpm != before] or [6000.0]
    stated = [operation["spindle_rpm"] for operation in operations]
    if stated != wanted:
        return f"runs at {stated} rpm, not {wanted}"
    ends = list(itertools.accumulate(seconds for seconds, _, _ in parts))
    # A helix is run in arcs that lie within a micrometre of it, and are shorter than it by some microseconds.
    moves = [item for item in flat(truth) if is_move(item)]
    is_wound = any(
        item[0] == "arc" and end_of(item)[2] != end_of(before)[2] for before, item in itertools.pairwise(moves)
    )
    near_mm, lag_s = (1.2e-3, 1e-5) if is_wound else (2e-4, 0.0)
    begin = 0.0
    for operation in operations:
        seen = {}
        for sample in operation["samples"]:
            at = begin + sample["s"] * operation["duration_s"]
            index = min(bisect.bisect_left(ends, at), len(parts) - 1)
            seen.setdefault(index, []).append((at - (ends[index] - parts[index][0]), sample))
        begin += operation["duration_s"]
        for index, samples in seen.items():
            seconds, on, rpm = parts[index]
            # Of each piece the first, the last and one between.
            for at, sample in {id(each): each for each in (samples[0], samples[len(samples) // 2], samples[-1])}.values():
                share, where = at / seconds, f"s = {sample['s']} of {operation['name']}"
                wanted, found = on(min(max(share, 0.0), 1.0)), seen_from(sample["joints_rad"], index, share)
                if math.dist(wanted, found) > near_mm + lag_s * math.dist(on(0.0), on(1.0)) / seconds:
                    return f"is at {found}, not at {wanted}, {where}"
                if rpm not in (None, operation["spindle_rpm"]) and 1e-5 < at < seconds - 1e-5:
                    return f"runs at {operation['spindle_rpm']} rpm, not {rpm}, {where}"
    return None


NUMBER = re.compile(r"\d+\.?\d*")


def differs(old, wanted, found):
    """Where a text is neither the old one nor has the numbers that it should."""
    if NUMBER.split(wanted) != NUMBER.split(found):
        pairs = zip(wanted.splitlines(), found.splitlines())
        return next((pair for pair in pairs if NUMBER.split(pair[0]) != NUMBER.split(pair[1])), "line count")
    # v500 becomes v500\\V:=625: as if it had been v500\\V:=500.
    old, wanted, found = (re.sub(r"v500(?=,)", "v500\\\\V:=500", text) for text in (old, wanted, found))
    numbers = [NUMBER.findall(text) for text in (old, wanted, found)]
    if len({len(own) for own in numbers}) > 1:
        return "another number of numbers"
    for i, (was, wanted, found) in enumerate(zip(*numbers)):
        is_near = wanted != was and abs(float(wanted) - float(found)) <= 5e-6 * float(wanted)
        if wanted != found and not is_near:
            return f"number {i} is {found}, not {wanted}"
    return None


def round_trip(detune, folder, seed, write):
    """What is wrong, and how many speeds were changed."""
    truth = draw(random.Random(seed), taps=False, bows=write in BOWED, helices=write in WOUND)
    truth = with_speeds(truth, random.Random(f"{seed} speeds"))
    dress = lambda truth: write(truth, random.Random(f"{seed} {write.__name__}"), rewritten=True)[:2]
    text, extension = dress(truth)
    job = job_of(folder, text, extension, {}, "policy: {separation_percent: 3, model_uncertainty_percent: 0.3}\n")
    new_program, new_job = folder / f"new.{extension}", folder / "new.yaml"
    for file in (new_program, new_job):
        file.unlink(missing_ok=True)
    command = [detune, "advise", str(job), "--format", "json", "--write", str(new_job), "--write-program", str(new_program)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if ran.returncode == 2:
        return f"exit code 2: {ran.stderr}", 0
    operations = json.loads(ran.stdout)["operations"]
    old = [item[1] for item in truth if item[0] == "speed"]
    stated = [operation["programmed_rpm"] for operation in operations]
    if stated != old:
        return f"speeds are read as {stated}, not {old}", 0
    if not new_program.exists():
        # Nothing may be written where there is no safe speed for all, or every speed is kept.
        is_open = all(operation["status"] in ("keep", "change") for operation in operations)
        is_kept = all(operation["status"] == "keep" for operation in operations)
        if new_job.exists() or is_open and not is_kept:
            return f"exit code {ran.returncode}, not written: {ran.stderr}", 0
        return None, 0
    new = [operation["recommended_rpm"] for operation in operations]
    wanted, _ = dress(advised(truth, new, write in ROBOTS))
    fault = differs(text, wanted, new_program.read_text())
    command = [detune, "check", str(new_job), "--format", "json", "--samples", "none", "--fail-on", "never"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if ran.returncode != 0:
        return fault or f"what was written is not read: {ran.stderr}", 0
    again = json.loads(ran.stdout)["jobs"][0]
    back = [operation["spindle_rpm"] for operation in again["operations"]]
    # Neighbours that got one speed are one stretch now.
    back, wanted = ([rpm for rpm, _ in itertools.groupby(rpms)] for rpms in (back, new))
    if any(abs(a - b) > 1e-3 for a, b in zip(back, wanted)) or len(back) != len(wanted):
        fault = fault or f"is read back at {back}, not {new}"
    if again["verdict"] == "resonance":
        fault = fault or "what was advised is a resonance"
    return fault, sum(a != b for a, b in zip(old, new))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("detune")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--round-trips", type=int, default=0)
    parser.add_argument("--pygcode", action="store_true", help="compare with pygcode, too, which must be installed")
    arguments = parser.parse_args()
    arm = Arm(next(ROBOT.glob("*.urdf")))
    detune, ran, faults = str(pathlib.Path(arguments.detune).resolve()), 0, []
    with tempfile.TemporaryDirectory() as name:
        for seed in range(arguments.seeds):
            for write in WRITERS:
                rng = random.Random(f"{seed} {write.__name__}")
                truth = draw(random.Random(seed), bows=write in BOWED, helices=write in WOUND)
                text, *rest = write(truth, rng)
                seen_from = SEEN[write](arm, truth) if write in SEEN else lambda q, *_: arm.tool(q)
                fault = check(detune, pathlib.Path(name), seen_from, truth, text, *rest)
                if arguments.pygcode and write is plain:
                    fault = fault or interpreters_agree(truth, text)
                ran += 1
                if fault:
                    faults.append(f"seed {seed}, {write.__name__}: {fault}")
        print(f"{ran} random programs in {len(WRITERS)} dresses: {len(faults)} wrong")
        changed = {write.__name__: 0 for write in WRITERS}
        for seed in range(arguments.round_trips):
            for write in WRITERS:
                fault, count = round_trip(detune, pathlib.Path(name), 1000 + seed, write)
                changed[write.__name__] += count > 0
                if fault:
                    faults.append(f"round trip {1000 + seed}, {write.__name__}: {fault}")
    written = ", ".join(f"{name} {count}" for name, count in changed.items())
    print(f"{arguments.round_trips} round trips in each: rewritten {written}")
    if arguments.round_trips >= 5 and not all(changed.values()):
        faults.append("a dialect was never rewritten")
    print("\n".join(faults[:10]))
    raise SystemExit(1 if faults else 0)


if __name__ == "__main__":
    main()
