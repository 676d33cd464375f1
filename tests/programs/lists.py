"""What is run, as lists that every dialect is written from.

("line", end, mm/min or None for rapid), ("arc", centre, sweep, end, mm/min) about Z, a helix where it ends at another
height, ("bow", centre, a, b, sweep, end, mm/min) through centre + a cos t + b sin t, ("dwell", s), ("speed", rpm), and
("group", form, items): items for which a dialect may have a form of its own. `flat` is a list without groups.
"""

import math

OBJECT = (0.72, -0.12, 0.42)
TCP = 0.15
RAPID = 500.0  # mm/s
# Of coarse metric threads, mm (ISO 261).
PITCHES = {3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 16: 2.0}


class Air(float):
    """The feed of a rapid move that a robot program states, mm/min."""


def n(value):
    return f"{value:.9f}".rstrip("0").rstrip(".") or "0"


def flat(items):
    return [each for item in items for each in (flat(item[2]) if item[0] == "group" else [item])]


def is_move(item):
    return item[0] in ("line", "arc", "bow")


def end_of(item):
    """Where a move ends."""
    return item[1] if item[0] == "line" else item[-2]


def direction_at(centre, at, sweep):
    """Of an arc about a centre, where it comes through a point."""
    x, y = at[0] - centre[0], at[1] - centre[1]
    sense = math.copysign(1 / math.hypot(x, y), sweep)
    return [-y * sense, x * sense]


def heading(at, item):
    """The direction in the plane in which a move from a place ends; none where it has none there."""
    x, y, z = (b - a for a, b in zip(at, end_of(item)))
    if item[0] == "arc":
        return direction_at(item[1], item[3], item[2]) if z == 0 else None
    length = math.hypot(x, y)
    return [x / length, y / length] if item[0] == "line" and z == 0 and length > 0.5 else None


def shifted(item, by):
    move = lambda p: [x + y for x, y in zip(p, by)]
    if item[0] == "line":
        return ("line", move(item[1]), item[2])
    if item[0] == "arc":
        return ("arc", move(item[1]), item[2], move(item[3]), item[4])
    return item


def holes(rng, at, feed, taps):
    """A pattern of holes, drilled, reamed or tapped, from where the tool is above them."""
    kind = rng.choice(["row", "circle", "free"])
    way = rng.choice(["drill", "ream", "tap"] if taps else ["drill", "drill", "ream"])
    # Every tapped hole makes stretches of its own, which are thousands of samples each.
    count = 2 if way == "tap" else rng.randint(2, 5)
    x, y = (round(rng.uniform(-40, 40), 2) for _ in range(2))
    angle = rng.choice([0.0, 30.0, 90.0, -135.0, round(rng.uniform(-180, 180), 2)])
    form = {"kind": "holes", "pattern": kind}
    on = lambda radius, angle: [x + radius * math.cos(math.radians(angle)), y + radius * math.sin(math.radians(angle))]
    if kind == "row":
        first, step = rng.choice([0.0, 4.5, 10.0]), round(rng.uniform(4, 12), 2)
        form["words"] = (x, y, angle, first, step, count)
        places = [on(first + step * i, angle) for i in range(count)]
        # Sinumerik begins at the end that is nearer.
        if math.dist(at[:2], places[-1]) < math.dist(at[:2], places[0]):
            places.reverse()
    elif kind == "circle":
        radius, step = round(rng.uniform(5, 25), 2), rng.choice([0.0, 25.0, -40.0])
        form["words"] = (x, y, radius, angle, step, count)
        places = [on(radius, angle + i * (step or 360 / count)) for i in range(count)]
    else:
        places = [[round(rng.uniform(-50, 50), 2), round(rng.uniform(-50, 50), 2)] for _ in range(count)]
    surface = round(at[2] - rng.uniform(8, 15), 2)
    clear, depth = surface + rng.choice([1.0, 2.5]), surface - round(rng.uniform(2, 12), 2)
    back = rng.choice([clear, at[2], round(clear + rng.uniform(1, 3), 3)])
    dwell = rng.choice([0.0, 0.0, 0.5, 2.0])
    out_feed = rng.choice([feed, feed, 450.0])
    form |= {"places": places, "surface": surface, "clear": clear, "depth": depth, "back": back, "way": way, "dwell": dwell}
    if way == "tap":
        size = rng.choice(list(PITCHES))
        form |= {"size": size, "in": 600.0, "out": rng.choice([600.0, 750.0]), "hand": rng.choice([1, -1])}
        feed, out_feed = form["in"] * PITCHES[size], form["out"] * PITCHES[size]
    items, z = [], at[2]
    for px, py in places:
        items += [("line", [px, py, z], None), ("line", [px, py, clear], None)]
        items += [("speed", form["in"])] if way == "tap" else []
        items += [("line", [px, py, depth], feed)]
        items += [("dwell", dwell)] if dwell else []
        items += [("speed", form["out"])] if way == "tap" and form["out"] != form["in"] else []
        items += [("line", [px, py, clear], out_feed)] if way != "drill" else []
        items += [("line", [px, py, back], None)]
        items += [("speed", 6000.0)] if way == "tap" else []
        z = back
    found, before = [], at
    for item in items:
        if item[0] != "line" or item[1] != before:
            found.append(item)
        before = item[1] if item[0] == "line" else before
    return ("group", form, found)


def again(rng, at, feed):
    """Some moves, and the same from where they end."""
    body, here, count = [], at, rng.randint(2, 4)
    for _ in range(rng.randint(1, 4)):
        kind = rng.random()
        step = [round(rng.uniform(-8, 8), 3), round(rng.uniform(-8, 8), 3), rng.choice([0, 0, round(rng.uniform(-2, 2), 3)])]
        if kind < 0.7:
            body.append(("line", [a + b for a, b in zip(here, step)], None if kind < 0.1 else feed))
        elif kind < 0.9:
            centre, sweep = [here[0] + step[0], here[1] + step[1]], rng.choice([-1, 1]) * rng.uniform(0.4, 5.5)
            body.append(arc(here, centre, sweep, feed))
        else:
            body.append(("dwell", 0.5))
            continue
        here = end_of(body[-1])
    by = [b - a for a, b in zip(at, here)]
    items = [shifted(item, [x * k for x in by]) for k in range(count) for item in body]
    return ("group", {"kind": "again", "count": count, "body": len(body)}, items)


def arc(at, centre, sweep, feed, rise=0.0):
    start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.hypot(at[0] - centre[0], at[1] - centre[1])
    end = [centre[0] + radius * math.cos(start + sweep), centre[1] + radius * math.sin(start + sweep), at[2] + rise]
    return ("arc", centre, sweep, end, feed)


def bow(rng, at, feed):
    """An arc in a plane that leans up to 40°."""
    lean, start, radius = rng.uniform(-0.7, 0.7), rng.uniform(0, math.tau), rng.uniform(4, 20)
    along = [math.cos(start), math.sin(start), 0.0]
    aside = [-math.sin(start) * math.cos(lean), math.cos(start) * math.cos(lean), math.sin(lean)]
    radius_b = rng.choice([-1, 1]) * radius
    a, b = [radius * x for x in along], [radius_b * x for x in aside]
    centre, sweep = [x - y for x, y in zip(at, a)], rng.uniform(0.4, 5.5)
    return ("bow", centre, a, b, sweep, on_bow(centre, a, b, sweep), feed)


def on_bow(centre, a, b, angle):
    return [c + x * math.cos(angle) + y * math.sin(angle) for c, x, y in zip(centre, a, b)]


def draw(rng, taps=True, bows=False, helices=False):
    at, found, feed = [0.0, 0.0, 60.0], [("line", [0.0, 0.0, 60.0], None), ("speed", 6000.0)], 600.0
    way = None
    for _ in range(rng.randint(5, 25)):
        kind = rng.random()
        here, count = at, len(found)
        if kind < 0.15:
            feed = float(rng.choice([90, 300, 655.5, 1200]))
        if kind < 0.45:
            end = [round(rng.uniform(-60, 60), 3), round(rng.uniform(-60, 60), 3), round(rng.uniform(0, 60), 3)]
            if rng.random() < 0.4:
                end[2] = at[2]
            if math.dist(at, end) > 1e-3:
                found.append(("line", end, None if kind < 0.2 else feed))
        elif kind < 0.68:
            start, sweep = rng.uniform(0, math.tau), rng.choice([-1, 1]) * rng.uniform(0.3, 5.8)
            radius = rng.uniform(3, 25)
            if way and rng.random() < 0.6:
                # On from the move before.
                start = math.atan2(way[1], way[0]) - math.copysign(math.pi / 2, sweep)
                centre = [at[0] - radius * math.cos(start), at[1] - radius * math.sin(start)]
            else:
                centre = [round(at[0] - radius * math.cos(start), 3), round(at[1] - radius * math.sin(start), 3)]
            rise = round(rng.uniform(-6, 12), 3) if helices and rng.random() < 0.3 else 0.0
            found.append(arc(at, centre, sweep, feed, rise))
        elif kind < 0.73:
            found.append(bow(rng, at, feed) if bows else ("dwell", 0.75))
        elif kind < 0.86:
            found.append(holes(rng, at, feed, taps))
            taps = taps and found[-1][1]["way"] != "tap"
        elif kind < 0.95:
            found.append(again(rng, at, feed))
        else:
            found.append(("dwell", rng.choice([0.25, 1.5, 3.0])))
        if len(found) > count and found[-1][0] != "dwell":
            last = [item for item in flat(found[-1:]) if is_move(item)]
            way = heading(here, last[-1]) if last and found[-1][0] != "group" else None
            at = end_of(last[-1]) if last else at
    return found + [("line", [at[0], at[1], at[2] + 20], None)]


def pieces(truth):
    """(seconds, function of the share of it, spindle speed, none of a dwell) one after the other, from where the
    path starts."""
    truth = flat(truth)
    at, found, rpm = truth[0][1], [], None
    for item in truth[1:]:
        if item[0] == "speed":
            rpm = item[1]
        elif item[0] == "dwell":
            found.append((item[1], lambda u, at=at: at, None))
        elif item[0] == "line":
            a, b = at, item[1]
            speed = RAPID if item[2] is None else item[2] / 60
            on = lambda u, a=a, b=b: [x + (y - x) * u for x, y in zip(a, b)]
            found.append((math.dist(a, b) / speed, on, rpm))
            at = b
        elif item[0] == "bow":
            _, centre, a, b, sweep, end, feed = item
            on = lambda u, centre=centre, a=a, b=b, sweep=sweep: on_bow(centre, a, b, sweep * u)
            found.append((math.hypot(*a) * sweep / (feed / 60), on, rpm))
            at = end
        else:
            _, centre, sweep, end, feed = item
            start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.dist(at[:2], centre[:2])

            def on(u, centre=centre, start=start, radius=radius, sweep=sweep, z=at[2], rise=end[2] - at[2]):
                angle = start + sweep * u
                return [centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle), z + rise * u]

            found.append((math.hypot(radius * sweep, end[2] - at[2]) / (feed / 60), on, rpm))
            at = end
    return found


def middle(at, item):
    """Via points and ends of an arc in pieces of less than half a turn."""
    sweep = item[2] if item[0] == "arc" else item[4]
    count = math.ceil(abs(sweep) / 3.0)
    if item[0] == "bow":
        on = lambda u: on_bow(*item[1:4], sweep * u)
    else:
        centre = item[1]
        start, radius = math.atan2(at[1] - centre[1], at[0] - centre[0]), math.dist(at[:2], centre[:2])
        turned = lambda angle: [centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle), at[2]]
        on = lambda u: turned(start + sweep * u)
    return [(on((k + 0.5) / count), on((k + 1) / count)) for k in range(count)]


def with_speeds(truth, rng):
    """The same with several speeds, each for a stretch of moves."""
    found, left = [], 0
    speeds = [float(s) for s in rng.sample(range(600, 2600, 7), 8)]
    for item in truth:
        if item[0] == "speed":
            left = 0
        if found and left <= 0 and speeds:
            found.append(("speed", speeds.pop()))
            left = rng.randint(4, 9)
        if item[0] != "speed":
            found.append(item)
            left -= item[0] != "dwell"
    return found


def advised(truth, speeds, is_robot):
    """The same with other speeds, one after the other, and feeds in ratio; a robot's rapids have a feed, too."""
    old = [item[1] for item in truth if item[0] == "speed"]
    at = 0

    def scaled(item, ratio):
        if item[0] == "group":
            return (*item[:2], [scaled(each, ratio) for each in item[2]])
        if not is_move(item) or item[-1] is None and not is_robot:
            return item
        return (*item[:-1], Air(60 * RAPID * ratio) if item[-1] is None else item[-1] * ratio)

    found = []
    for item in truth:
        if item[0] == "speed":
            found.append(("speed", speeds[at]))
            at += 1
        else:
            found.append(scaled(item, speeds[max(at - 1, 0)] / old[max(at - 1, 0)]))
    return found
