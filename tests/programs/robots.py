"""The languages of robots: RAPID, KRL, TP; RAPID with a tool that stands, and with work on a positioner."""

import math

from arm import multiply, place, turn
from lists import OBJECT, RAPID, TCP, Air, end_of, flat, is_move, middle, n

# The tool that stands, in the base frame, and the work object in the frame of the tip.
STANDING = (0.7, -0.15, 0.5)
GRIPPED = (0.01, 0.02, 0.16)
# The axis of the positioner, a point on it, and its user frame with the axis at zero.
AXIS, ORIGIN = (0.0, 0.6, 0.8), (0.65, -0.05, 0.3)


def told(truth, speed, dwell, line, arc):
    """The statements of a robot program, by what writes each kind; an arc comes in pieces."""
    out, at = [], None
    for item in flat(truth):
        if item[0] == "speed":
            out.append(speed(item[1]))
        elif item[0] == "dwell":
            out.append(dwell(item[1]))
        elif item[0] == "line":
            out.append(line(item[1], item[2]))
            at = item[1]
        else:
            out += [arc(via, end, item[-1]) for via, end in middle(at, item)]
            at = item[-2]
    return out


TOOL = "[TRUE,[[0,0,150],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]]"


def mm(at):
    return ",".join(n(1000 * x) for x in at)


def rapid(truth, rng, rewritten=False, tool=TOOL, part=f'FALSE,TRUE,"",[[{mm(OBJECT)}]', axes=None):
    """`part` is the start of the work object; `axes` gives the positions of a positioner at the ends."""

    def target(p):
        at = "9E9" if axes is None else n(next(axes))
        return f"[[{','.join(n(x) for x in p)}],[0,1,0,0],[0,0,0,0],[9E9,{at},9E9,9E9,9E9,9E9]]"

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
    head = (
        f"MODULE random\nPERS tooldata tSpindle:={tool};\n"
        f"PERS wobjdata wPart:=[{part},[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\n"
        "ConfL\\Off;\nConfJ\\Off;\n"
    )
    return head + "\n".join(out) + "\nENDPROC\nENDMODULE\n", "mod"


def held(truth, rng, rewritten=False):
    """The arm holds the work and leads it along a tool that stands, its axis upwards."""
    tool = f"[FALSE,[[{mm(STANDING)}],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]]"
    return rapid(truth, rng, tool=tool, part=f'TRUE,TRUE,"",[[{mm(GRIPPED)}]')


def seen_in_hand(arm, truth):
    """Where the tool is in the work, mm."""
    work = place(GRIPPED, (0, 0, 0))

    def seen(q, index, share):
        frame = multiply(arm.tip(q), work)
        off = [a - row[3] for a, row in zip(STANDING, frame)]
        return [1000 * sum(frame[k][i] * off[k] for k in range(3)) for i in range(3)]

    return seen


def angles(truth):
    """The positioner at the start and the ends of all moves, degrees, as it does not depend on speeds."""
    moves = [item for item in flat(truth) if is_move(item)]
    return [20 * math.sin(x / 13 + y / 29 - z / 17) for x, y, z in map(end_of, moves)]


def on_positioner(truth, rng, rewritten=False):
    """A positioner turns the work beneath the tool."""

    def axes():
        before = None
        for item, at in zip((item for item in flat(truth) if is_move(item)), angles(truth)):
            if item[0] == "line":
                yield at
            else:
                for k in range(count := len(middle(end, item))):
                    yield from [before + (at - before) * (k + share) / count for share in (0.5, 1.0)]
            before, end = at, end_of(item)

    return rapid(truth, rng, part='FALSE,FALSE,"STN1",[[1,2,3]', axes=axes())


def seen_on_positioner(arm, truth):
    """Where the tool is in the work, mm."""
    turns = []
    ends, at = iter(angles(truth)), None
    for item in flat(truth):
        before, at = at, next(ends) if is_move(item) else at
        if item[0] != "speed":
            turns.append((before, at))

    def seen(q, index, share):
        # The first of all moves goes to where the path starts.
        before, at = turns[index + 1]
        frame = turn(AXIS, math.radians(before + (at - before) * share))
        tip = arm.tip(q)
        # The tool's point about a point on the axis, turned back; the user frame stands at the work object.
        off = [row[3] + TCP * row[2] - a for row, a in zip(tip, ORIGIN)]
        back = [sum(frame[k][i] * off[k] for k in range(3)) for i in range(3)]
        return [1000 * (x + a - b) for x, a, b in zip(back, ORIGIN, OBJECT)]

    return seen


def krl(truth, rng, rewritten=False):
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


def fanuc(truth, rng, rewritten=False):
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
