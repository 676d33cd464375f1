"""Random programs in every dialect against an independent computation: one list of lines, arcs, dwells and speeds is
written in each language, in random dress, and detune's samples must lie where and when the list has them.

Round trips: programs with several speeds are written by `advise --write-program`. The same list with the advised
speeds, and feeds in ratio, is written again in the same dress: what the program wrote must be that text, number by
number, and every byte that states no speed or feed must be the old one. What is read back runs at the advised speeds.

    python3 tests/programs.py target/release/detune [--seeds N] [--round-trips N] [--pygcode]
"""

import argparse
import json
import math
import pathlib
import random
import re
import subprocess
import tempfile
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROBOT = ROOT / "robots" / "irb1600"
OBJECT = (0.72, -0.12, 0.42)
TCP = 0.15
RAPID = 500.0  # mm/s


class Air(float):
    """The feed of a rapid move that a robot program states, mm/min."""



def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def turn(axis, angle):
    x, y, z = axis
    c, s, v = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [
        [x * x * v + c, x * y * v - z * s, x * z * v + y * s, 0],
        [y * x * v + z * s, y * y * v + c, y * z * v - x * s, 0],
        [z * x * v - y * s, z * y * v + x * s, z * z * v + c, 0],
        [0, 0, 0, 1],
    ]


def place(xyz, rpy):
    found = multiply(turn((0, 0, 1), rpy[2]), multiply(turn((0, 1, 0), rpy[1]), turn((1, 0, 0), rpy[0])))
    for row, value in zip(found, xyz):
        row[3] = value
    return found


class Arm:
    """The chain of a URDF from its root to the child of its last moving joint."""

    def __init__(self, urdf):
        numbers = lambda text: [float(word) for word in text.split()]
        joints = {}
        for joint in xml.parse(urdf).getroot().findall("joint"):
            origin, axis = joint.find("origin"), joint.find("axis")
            joints[joint.find("parent").get("link")] = (
                joint.get("type"),
                place(
                    numbers(origin.get("xyz", "0 0 0")) if origin is not None else [0, 0, 0],
                    numbers(origin.get("rpy", "0 0 0")) if origin is not None else [0, 0, 0],
                ),
                numbers(axis.get("xyz")) if axis is not None else [1, 0, 0],
                joint.find("child").get("link"),
            )
        children = {joint[3] for joint in joints.values()}
        link = next(parent for parent in joints if parent not in children)
        self.chain = []
        while link in joints:
            self.chain.append(joints[link])
            link = joints[link][3]

    def tool(self, q):
        """The point of the tool, mm: carried from the last joint to the first, as thousands of samples ask for it."""
        q, at = list(q), (0.0, 0.0, TCP)
        for kind, origin, axis, _ in reversed(self.chain):
            for rows in (turn(axis, q.pop()), origin) if kind in ("revolute", "continuous") else (origin,):
                x, y, z = at
                at = tuple(a * x + b * y + c * z + d for a, b, c, d in rows[:3])
        return [1000 * (at[i] - OBJECT[i]) for i in range(3)]


# What is run: ("line", end, mm/min or None for rapid), ("arc", centre, sweep, end, mm/min), ("dwell", s), ("speed", rpm).
def draw(rng):
    at, found, feed = [0.0, 0.0, 60.0], [("line", [0.0, 0.0, 60.0], None), ("speed", 6000.0)], 600.0
    for _ in range(rng.randint(5, 25)):
        kind = rng.random()
        if kind < 0.15:
            feed = float(rng.choice([90, 300, 655.5, 1200]))
        if kind < 0.6:
            end = [round(rng.uniform(-60, 60), 3), round(rng.uniform(-60, 60), 3), round(rng.uniform(0, 60), 3)]
            if rng.random() < 0.3:
                end[2] = at[2]
            if math.dist(at, end) > 1e-3:
                found.append(("line", end, None if kind < 0.2 else feed))
                at = end
        elif kind < 0.9:
            start, sweep = rng.uniform(0, math.tau), rng.choice([-1, 1]) * rng.uniform(0.3, 5.8)
            radius = rng.uniform(3, 25)
            centre = [round(at[0] - radius * math.cos(start), 3), round(at[1] - radius * math.sin(start), 3)]
            start = math.atan2(at[1] - centre[1], at[0] - centre[0])
            radius = math.hypot(at[0] - centre[0], at[1] - centre[1])
            end = [centre[0] + radius * math.cos(start + sweep), centre[1] + radius * math.sin(start + sweep), at[2]]
            found.append(("arc", centre, sweep, end, feed))
            at = end
        else:
            found.append(("dwell", rng.choice([0.25, 1.5, 3.0])))
    return found + [("line", [at[0], at[1], at[2] + 20], None)]


def pieces(truth):
    """(seconds, function of the share of it) one after the other, from where the path starts."""
    at, found = truth[0][1], []
    for item in truth[1:]:
        if item[0] == "dwell":
            found.append((item[1], lambda u, at=at: at))
        elif item[0] == "line":
            a, b = at, item[1]
            speed = RAPID if item[2] is None else item[2] / 60
            found.append((math.dist(a, b) / speed, lambda u, a=a, b=b: [x + (y - x) * u for x, y in zip(a, b)]))
            at = b
        elif item[0] == "arc":
            _, centre, sweep, end, feed = item
            start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.dist(at[:2], centre)

            def on(u, centre=centre, start=start, radius=radius, sweep=sweep, z=at[2]):
                angle = start + sweep * u
                return [centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle), z]

            found.append((radius * abs(sweep) / (feed / 60), on))
            at = end
    return found


def n(value):
    return f"{value:.9f}".rstrip("0").rstrip(".") or "0"


def gcode(truth, rng):
    out, at, feed = ["%", "O1 (RANDOM)", "G21 G90 G17 G94"], None, None
    word = lambda letter, value: (letter if rng.random() < 0.8 else letter.lower()) + rng.choice(["", " "]) + n(value)
    for item in truth:
        number = f"N{len(out)} " if rng.random() < 0.3 else ""
        if item[0] == "speed":
            out.append(number + f"M3 S{n(item[1])}")
            feed = None
        elif item[0] == "dwell":
            out.append(number + f"G4 P{item[1]}")
        elif item[0] == "line":
            words = ["G0" if item[2] is None else "G1"]
            shift = at is not None and rng.random() < 0.2
            if shift:
                words.insert(0, "G91")
            for letter, i in zip("XYZ", range(3)):
                if at is None or item[1][i] != at[i] or rng.random() < 0.3:
                    words.append(word(letter, item[1][i] - at[i] if shift else item[1][i]))
            if item[2] is not None and (item[2] != feed or rng.random() < 0.2):
                words.append(word("F", item[2]))
                feed = item[2]
            out.append(number + " ".join(words) + rng.choice(["", " (F1 S2)", "; X5"]))
            if shift:
                out.append("G90")
            at = item[1]
        else:
            _, centre, sweep, end, own = item
            words = ["G3" if sweep > 0 else "G2", word("X", end[0]), word("Y", end[1])]
            words += [word("I", centre[0] - at[0]), word("J", centre[1] - at[1])]
            if own != feed:
                words.append(word("F", own))
                feed = own
            out.append(number + " ".join(words))
            at = end
    return "\n".join(out + ["M5", "M30", "%", ""]), "nc"


def apt(truth, rng):
    out, at, feed = ["PARTNO RANDOM $ 1/2", "UNITS/MM"], None, None
    point = lambda p: ",".join(f" {n(x)}" for x in p)
    before = None
    # No CAM system turns back on its own line at an arc, and the reader takes that for an arc the other way round.
    turns_back = lambda a, b: sum(x * y for x, y in zip(a, b)) < -0.9 * math.hypot(*a) * math.hypot(*b)
    for index, item in enumerate(truth):
        if item[0] == "speed":
            out.append(rng.choice([f"SPINDL/{n(item[1])},RPM,CLW", f"SPINDL/RANGE,2,RPM,{n(item[1])},CLW"]))
            feed = None
        elif item[0] == "dwell":
            out.append(f"DELAY/{item[1]}")
        else:
            own = item[-1]
            if own is None:
                out.append("RAPID")
            elif own != feed:
                out.append(f"FEDRAT/{n(own)},MMPM" if rng.random() < 0.7 else f"FEDRAT/ MMPM, {n(own)}")
                feed = own
            if item[0] == "arc":
                _, centre, sweep, end, _ = item
                start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.dist(at[:2], centre)
                along = lambda angle, sweep=sweep: [math.copysign(1, sweep) * x for x in (-math.sin(angle), math.cos(angle))]
                after = truth[index + 1] if index + 1 < len(truth) else None
                cusps = before and turns_back([*along(start), 0], [a - b for a, b in zip(at, before)])
                if after and after[0] == "line":
                    cusps = cusps or turns_back([*along(start + sweep), 0], [a - b for a, b in zip(after[1], end)])
                if rng.random() < 0.5 and not cusps:
                    axis = "0,0,1" if sweep > 0 else "0,0,-1"
                    out.append(f"CIRCLE/{n(centre[0])},{n(centre[1])},{n(at[2])},{axis},$\n {n(radius)}")
                    out.append(f"GOTO/{point(end)}")
                else:
                    sense = 1 if sweep > 0 else -1
                    out.append(f"INDIRV/{n(-sense * math.sin(start))},{n(sense * math.cos(start))},0")
                    centre = f"{n(centre[0])},{n(centre[1])},{n(at[2])}"
                    out.append(f"TLON,GOFWD/ (CIRCLE/ {centre},$\n{n(radius)}),ON,(LINE/ {centre},$\n{point(end)})")
                before, at = None, end
            else:
                before = at
                out.append(f"GOTO/{point(item[1])}" + rng.choice(["", ",0,0,1", " $$ GOTO/0,0,0"]))
                at = item[1]
    return "\n".join(out + ["FINI", ""]), "apt"


def middle(at, item):
    """Via points and ends of an arc in pieces of less than half a turn."""
    _, centre, sweep, _, _ = item
    start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.dist(at[:2], centre)
    count = math.ceil(abs(sweep) / 3.0)
    on = lambda u: [centre[0] + radius * math.cos(start + sweep * u), centre[1] + radius * math.sin(start + sweep * u), at[2]]
    return [(on((k + 0.5) / count), on((k + 1) / count)) for k in range(count)]


def told(truth, speed, dwell, line, arc):
    """The statements of a robot program, by what writes each kind; an arc comes in pieces."""
    out, at = [], None
    for item in truth:
        if item[0] == "speed":
            out.append(speed(item[1]))
        elif item[0] == "dwell":
            out.append(dwell(item[1]))
        elif item[0] == "line":
            out.append(line(item[1], item[2]))
            at = item[1]
        else:
            out += [arc(via, end, item[4]) for via, end in middle(at, item)]
            at = item[3]
    return out


def rapid(truth, rng):
    target = lambda p: f"[[{','.join(n(x) for x in p)}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"

    def speed(feed):
        if feed is None or isinstance(feed, Air):
            return "v500" if feed in (None, 60 * RAPID) else f"v500\\V:={n(feed / 60)}"
        return f"[{n(feed / 60)},500,5000,1000]"

    rest = "fine,tSpindle\\WObj:=wPart;"
    out = told(
        truth,
        lambda rpm: f"SetAO aoSpindle, {n(rpm)};",
        lambda seconds: f"WaitTime {seconds};",
        lambda end, feed: f"MoveL {target(end)},{speed(feed)},{rest}",
        lambda via, end, feed: f"MoveC {target(via)},{target(end)},{speed(feed)},{rest}",
    )
    object_at = ",".join(n(1000 * x) for x in OBJECT)
    head = (
        "MODULE random\nPERS tooldata tSpindle:=[TRUE,[[0,0,150],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];\n"
        f'PERS wobjdata wPart:=[FALSE,TRUE,"",[[{object_at}],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\n'
        "ConfL\\Off;\nConfJ\\Off;\n"
    )
    return head + "\n".join(out) + "\nENDPROC\nENDMODULE\n", "mod"


def krl(truth, rng):
    object_at = ",".join(f"{axis} {n(1000 * x)}" for axis, x in zip("XYZ", OBJECT))
    head = ["&ACCESS RVP", "DEF random()", "$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}", f"$BASE={{FRAME: {object_at},A 0,B 0,C 0}}"]
    held, begun = [None], [False]

    def parts(p, full):
        return ",".join(f"{axis} {n(x)}" for axis, x in zip("XYZ", p)) + (",A 0,B 0,C 180" if full else "")

    def motion(write, feed):
        own = RAPID * 60 if feed is None else feed
        first = [] if own == held[0] else [f"$VEL.CP={own / 60000:.12f}"]
        full = not begun[0] or rng.random() < 0.5
        held[0], begun[0] = own, True
        return "\n".join(first + [write(full)])

    def spindle(rpm):
        held[0] = None
        return f"SPINDLE({n(rpm)})"

    out = told(
        truth,
        spindle,
        lambda seconds: f"WAIT SEC {seconds}",
        lambda end, feed: motion(
            lambda full: f"LIN {{{parts(end, full)}}}" + rng.choice(["", " C_DIS", " ; {X 1}"]), feed
        ),
        lambda via, end, feed: motion(lambda full: f"CIRC {{{parts(via, full)}}},{{{parts(end, full)}}}", feed),
    )
    return "\n".join(head + out + ["END", ""]), "src"


def fanuc(truth, rng):
    points = []

    def point(p):
        points.append(p)
        return f"P[{len(points)}]"

    def speed(feed):
        if feed is None or isinstance(feed, Air):
            return f"{n((feed or 60 * RAPID) / 60)}mm/sec"
        return f"{n(feed / 10)}cm/min" if rng.random() < 0.5 else f"{n(feed / 60)}mm/sec"

    lines = ["UFRAME_NUM=1 ;", "UTOOL_NUM=1 ;"] + told(
        truth,
        lambda rpm: f"!SPINDLE {n(rpm)} ;",
        lambda seconds: f"WAIT   {seconds}(sec) ;",
        lambda end, feed: f"L {point(end)} {speed(feed)} FINE ;",
        lambda via, end, feed: f"C {point(via)}\n    :  {point(end)} {speed(feed)} CNT50 ;",
    )
    out = ["/PROG RANDOM", "/ATTR", "OWNER = MNEDITOR;", "/MN"]
    out += [f"{i + 1:4}:{line}" for i, line in enumerate(lines)] + ["/POS"]
    for i, (x, y, z) in enumerate(points):
        brace = rng.choice(["{", " {"])
        out.append(f"P[{i + 1}]{brace}\n   GP1:\n\tUF : 1, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',")
        out.append(f"\tX = {n(x)} mm,\tY = {n(y)} mm,\tZ = {n(z)} mm,\n\tW = 180 deg,\tP = 0 deg,\tR = 0 deg\n}};")
    return "\n".join(out + ["/END", ""]), "ls"


def heidenhain(truth, rng):
    out, at, feed, number = ["BEGIN PGM RANDOM MM", "BLK FORM 0.1 Z X-60 Y-60 Z+0"], None, None, lambda x: f"{x:+.9f}"
    for item in truth:
        own = item[-1] if item[0] in ("line", "arc") else None
        speed = " FMAX" if own is None else "" if own == feed else f" F{n(own)}"
        feed = feed if own is None else own
        if item[0] == "speed":
            out += [f"TOOL CALL 5 Z S{n(item[1])}", "M3"]
            feed = None
        elif item[0] == "dwell":
            out += ["CYCL DEF 9.0 DWELL TIME", f"CYCL DEF 9.1 DWELL {item[1]}".replace(".1 DWELL 0.", ".1 DWELL 0,")]
        elif item[0] == "line":
            relative = at is not None and rng.random() < 0.3
            words = [("I" + axis + number(b - a)) if relative else axis + number(b) for axis, a, b in zip("XYZ", at or item[1], item[1])]
            out.append("L " + " ".join(words) + rng.choice(["", " R0"]) + speed + rng.choice(["", " ; X99"]))
            at = item[1]
        else:
            _, centre, sweep, end, _ = item
            sense = "DR+" if sweep > 0 else "DR-"
            out.append(f"CC X{number(centre[0])} Y{number(centre[1])}")
            if rng.random() < 0.5:
                out.append(f"C X{number(end[0])} Y{number(end[1])} {sense}{speed}")
            else:
                out.append(f"CP IPA{number(math.degrees(sweep))} {sense}{speed}")
            at = end
    out += ["M5", "END PGM RANDOM MM"]
    return "\n".join(f"{i} {line}" for i, line in enumerate(out)) + "\n", "h"


WRITERS = (gcode, apt, rapid, krl, fanuc, heidenhain)

KEYS = {
    "mod": "spindle_from: {signal: aoSpindle}",
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
    wanted = [item[1] if item[0] == "line" else item[3] for item in truth if item[0] in ("line", "arc")]
    found = interpreted(text)
    for end in wanted:
        while found and math.dist(found[0], end) > 1e-6:
            found.pop(0)
        if not found:
            return f"pygcode does not come to {end}"
    return None


def job_of(folder, text, extension, more=""):
    """The path of a job that runs a program."""
    (folder / f"p.{extension}").write_text(text)
    frames = "" if extension in ("mod", "src") else f"tcp: {{xyz_m: [0, 0, {TCP}]}}\nwork_object: {{xyz_m: {list(OBJECT)}}}\n"
    keys = KEYS.get(extension)
    (folder / "job.yaml").write_text(
        f"robot: {ROBOT / 'robot.yaml'}\ntool: {{teeth: 2}}\npayload: none\n{frames}"
        f"spindle: {{min_rpm: 500, max_rpm: 24000}}\n{more}operations:\n  - name: all\n"
        f"    path: {{program: {{file: p.{extension}{', ' + keys if keys else ''}}}}}\n"
    )
    return folder / "job.yaml"


def check(detune, folder, arm, truth, text, extension):
    job = job_of(folder, text, extension)
    command = [detune, "check", str(job), "--format", "json", "--fail-on", "never"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if ran.returncode != 0:
        return f"exit code {ran.returncode}: {ran.stderr}"
    (operation,) = json.loads(ran.stdout)["jobs"][0]["operations"]
    parts = pieces(truth)
    duration = sum(seconds for seconds, _ in parts)
    if abs(operation["duration_s"] - duration) > 1e-6 * duration:
        return f"takes {operation['duration_s']} s, not {duration} s"
    if operation["spindle_rpm"] != 6000.0:
        return f"runs at {operation['spindle_rpm']} rpm"
    for sample in operation["samples"]:
        left, index = sample["s"] * duration, 0
        while index + 1 < len(parts) and left > parts[index][0]:
            left, index = left - parts[index][0], index + 1
        wanted = parts[index][1](min(left / parts[index][0], 1.0))
        found = arm.tool(sample["joints_rad"])
        if math.dist(wanted, found) > 2e-4:
            return f"is at {found}, not at {wanted}, s = {sample['s']}"
    return None


def with_speeds(truth, rng):
    """The same with several speeds, each for a stretch of moves."""
    found, left = [], 0
    speeds = [float(s) for s in rng.sample(range(600, 2600, 7), 8)]
    for item in truth:
        if item[0] == "speed":
            left = 0
        if found and left == 0 and speeds:
            found.append(("speed", speeds.pop()))
            left = rng.randint(4, 9)
        if item[0] != "speed":
            found.append(item)
            left -= item[0] != "dwell"
    return found


def advised(truth, speeds, is_robot):
    """The same with other speeds, one after the other, and feeds in ratio; a robot's rapids have a feed, too."""
    old = [item[1] for item in truth if item[0] == "speed"]
    found, at = [], 0
    for item in truth:
        if item[0] == "speed":
            found.append(("speed", speeds[at]))
            at += 1
            continue
        ratio = speeds[max(at - 1, 0)] / old[max(at - 1, 0)]
        feed = item[-1]
        if item[0] in ("line", "arc") and (feed is not None or is_robot):
            feed = Air(60 * RAPID * ratio) if feed is None else feed * ratio
            item = (*item[:-1], feed)
        found.append(item)
    return found


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
    truth = with_speeds(draw(random.Random(seed)), random.Random(f"{seed} speeds"))
    dress = lambda truth: write(truth, random.Random(f"{seed} {write.__name__}"))
    text, extension = dress(truth)
    job = job_of(folder, text, extension, "policy: {separation_percent: 3, model_uncertainty_percent: 0.3}\n")
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
    wanted, _ = dress(advised(truth, new, write in (rapid, krl, fanuc)))
    fault = differs(text, wanted, new_program.read_text())
    command = [detune, "check", str(new_job), "--format", "json", "--samples", "none", "--fail-on", "never"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if ran.returncode != 0:
        return fault or f"what was written is not read: {ran.stderr}", 0
    again = json.loads(ran.stdout)["jobs"][0]
    back = [operation["spindle_rpm"] for operation in again["operations"]]
    if any(abs(a - b) > 1e-3 for a, b in zip(back, new)) or len(back) != len(new):
        fault = fault or f"is read back at {back}, not {new}"
    if again["verdict"] == "resonance":
        fault = fault or "what was advised is a resonance"
    return fault, sum(a != b for a, b in zip(old, new))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("detune")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--round-trips", type=int, default=0)
    parser.add_argument("--pygcode", action="store_true", help="compare with pygcode, too, which must be installed")
    arguments = parser.parse_args()
    arm = Arm(next(ROBOT.glob("*.urdf")))
    ran, faults = 0, []
    with tempfile.TemporaryDirectory() as name:
        for seed in range(arguments.seeds):
            for write in WRITERS:
                rng = random.Random(f"{seed} {write.__name__}")
                truth = draw(random.Random(seed))
                text, extension = write(truth, rng)
                fault = check(str(pathlib.Path(arguments.detune).resolve()), pathlib.Path(name), arm, truth, text, extension)
                if arguments.pygcode and write is gcode:
                    fault = fault or interpreters_agree(truth, text)
                ran += 1
                if fault:
                    faults.append(f"seed {seed}, {write.__name__}: {fault}")
        print(f"{ran} random programs in {len(WRITERS)} dialects: {len(faults)} wrong")
        changed = {write.__name__: 0 for write in WRITERS}
        for seed in range(arguments.round_trips):
            for write in WRITERS:
                detune = str(pathlib.Path(arguments.detune).resolve())
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


main()
