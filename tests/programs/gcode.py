"""G-code of Fanuc's, Haas' and LinuxCNC's kind: as it always was, and in newer forms."""

import math
import re

from lists import end_of, flat, n
from writer import Writer


COORDINATE = re.compile(r"[XYZxyz] ?(-?\d+(?:\.\d+)?)")


class GCode(Writer):
    def __init__(self, rng, has_files, has_parameters=True):
        ways = [self.rotated, self.polar_stretch, self.moved, self.called]
        super().__init__(rng, ways, {"holes": self.holes, "again": self.again})
        self.has_parameters = has_parameters
        self.has_files, self.subs, self.first, self.count = has_files, [], [], 1000
        self.callable, self.parts = ("M97", "M98", "own"), []
        self.turn, self.polar, self.radius, self.relative, self.fresh = None, False, None, False, False

    def word(self, letter, value):
        return (letter if self.chance(0.8) else letter.lower()) + self.rng.choice(["", " "]) + n(value)

    def numbered(self, text):
        self.out.append((f"N{len(self.out)} " if self.chance(0.3) else "") + text)

    def local(self, p):
        x, y, z = super().local(p)
        if self.turn:
            (cx, cy), angle = self.turn
            c, s = math.cos(-angle), math.sin(-angle)
            x, y = cx + c * (x - cx) - s * (y - cy), cy + s * (x - cx) + c * (y - cy)
        return [x, y, z]

    def fed(self, feed):
        if feed is None or feed == self.feed and not self.chance(0.2):
            return []
        self.feed = feed
        return [self.word("F", feed)]

    def end(self, end, relative=False):
        """The words of an end, some of those left out that stay."""
        if self.relative or relative:
            steps = [b - a for a, b in zip(self.local(self.at), self.local(end))]
            return [self.word(a, d) for a, d in zip("XYZ", steps) if abs(d) > 1e-10 or self.chance(0.3)]
        old = None if self.at is None or self.fresh else self.local(self.at)
        new = self.local(end)
        self.fresh = False
        if not self.polar:
            pairs = [(a, b, old is None or abs(b - o) > 1e-10) for a, b, o in zip("XYZ", new, old or new)]
        else:
            radius, angle = math.hypot(*new[:2]), math.degrees(math.atan2(new[1], new[0]))
            angle += self.rng.choice([0, 0, 360, -360])
            pairs = [("X", radius, self.radius is None or abs(self.radius - radius) > 1e-7), ("Y", angle, True)]
            pairs.append(("Z", new[2], old is None or abs(new[2] - old[2]) > 1e-10))
            self.radius = radius
        return [self.word(letter, value) for letter, value, needed in pairs if needed or self.chance(0.3)]

    def speed(self, rpm):
        value = n(rpm)
        if self.has_parameters and self.chance(0.3):
            name = self.rng.choice(["#500", "#<_speed>"])
            self.numbered(f"{name}={value}")
            value = name
        self.numbered(f"M3 S{value}")
        self.feed = None

    def dwell(self, seconds):
        self.numbered(f"G4 P{seconds}")

    def line(self, end, feed):
        free = self.at is not None and not (self.turn or self.polar or self.relative)
        relative = free and self.chance(0.2)
        words = self.end(end, relative)
        if not words:
            words = [self.word("Z", 0 if self.relative else self.local(end)[2])]
        words = ["G91"] * relative + ["G0" if feed is None else "G1"] + words + self.fed(feed)
        self.numbered(" ".join(words) + self.rng.choice(["", " (F1 S2)", "; X5"]))
        if relative:
            self.out.append("G90")

    def arc(self, centre, sweep, end, feed):
        radius, angle = math.dist(self.at[:2], centre[:2]), abs(sweep)
        a, c = self.local(self.at), self.local([*centre[:2], self.at[2]])
        words = self.end(end)
        if self.polar or self.chance(0.3) and 0.3 < angle < 5.5 and abs(angle - math.pi) > 0.3:
            words.append(self.word("R", radius if angle < math.pi else -radius))
        else:
            words += [self.word("I", c[0] - a[0]), self.word("J", c[1] - a[1])]
        self.numbered(" ".join(["G3" if sweep > 0 else "G2"] + words + self.fed(feed)))

    def rotated(self, part, depth):
        """Part of the list turned back, which G68 turns forth."""
        if self.turn or self.polar or self.relative:
            return False
        angle = round(self.rng.uniform(-200, 200), 3)
        here = self.local(self.at)
        if self.chance(0.2):
            self.out.append(f"G68 {self.word('R', angle)}")
            centre = here[:2]
        else:
            centre = [round(self.rng.uniform(-50, 50), 2) for _ in range(2)]
            self.out.append(f"G68 {self.word('X', centre[0])} {self.word('Y', centre[1])} {self.word('R', angle)}")
        self.turn, self.fresh = (centre, math.radians(angle)), True
        self.run(part, depth)
        self.turn, self.fresh = None, True
        self.out.append("G69")
        return True

    def may_be_polar(self, part):
        """No end near the pole, where no angle is."""
        ends = [self.local(end_of(item)) for item in flat(part) if item[0] in ("line", "arc")]
        arcs = [abs(item[2]) for item in flat(part) if item[0] == "arc"]
        is_clear = all(0.3 < sweep < 5.5 and abs(sweep - math.pi) > 0.3 for sweep in arcs)
        return bool(ends) and is_clear and all(math.hypot(*end[:2]) > 0.5 for end in ends)

    def polar_stretch(self, part, depth):
        if self.turn or self.polar or self.relative or not self.may_be_polar(part):
            return False
        self.out.append("G16")
        self.polar, self.radius = True, None
        self.run(part, depth)
        self.polar, self.fresh = False, True
        self.out.append("G15")
        return True

    def moved(self, part, depth):
        """Under another zero, to which G16 belongs, too."""
        if self.turn or self.polar or self.relative or self.shift != [0, 0, 0]:
            return False
        circle = [item[1] for item in part if item[0] == "group" and item[1].get("pattern") == "circle"]
        x, y = circle[0]["words"][:2] if circle else [round(self.rng.uniform(-30, 30), 2) for _ in range(2)]
        self.out.append(f"G52 X{n(x)} Y{n(y)}")
        self.shift, self.fresh = [x, y, 0], True
        if not self.chance(0.6) or not self.polar_stretch(part, depth):
            self.run(part, depth)
        self.shift, self.fresh = [0, 0, 0], True
        self.out.append("G52 X0 Y0")
        return True

    def subprogram(self, write, count):
        """A stretch in a subprogram, which is called so many times."""
        self.count += 1
        name, times = self.count, f" L{count}" if count > 1 or self.chance(0.2) else ""
        # N numbers belong to their program, and what a file calls need not be in the one that calls it.
        kinds = {"M97": ["M97"], "M98": ["M98", "word", "G65"], "own": ["own", "named"] * self.has_files}
        kind = self.rng.choice(sum((kinds[each] for each in self.callable), []))
        within = {"M97": self.callable, "own": ("own",), "named": ("own",)}
        before, self.callable = self.callable, within.get(kind, ("M98", "own"))
        lines = self.captured(write)
        self.callable = before
        self.radius = None
        if kind == "M97":
            self.parts += [f"N{name} (PART)", *lines, "M99"]
            self.out.append(f"M97 P{name}{times}")
        elif kind == "M98" or kind == "own":
            text = [f"O{name}", *lines, "M99"]
            # As Fanuc's older controls have it, the times stand before the number.
            self.out.append(f"M98 P{count}{name}" if self.chance(0.3) else f"M98 P{name}{times}")
            if kind == "M98":
                self.subs += text
            else:
                own = self.rng.choice([f"part{name}.nc", f"O{name}.nc"])
                self.files[own] = "\n".join(["%", *text, "%", ""])
        elif kind == "G65":
            # One number of the stretch, if it has one, is an argument: A is #1.
            numbers = [(i, found) for i, line in enumerate(lines) for found in COORDINATE.finditer(line)]
            given = ""
            if numbers:
                i, found = self.rng.choice(numbers)
                lines[i] = lines[i][: found.start(1)] + "#1" + lines[i][found.end(1) :]
                given = f" A{found[1]}"
            self.subs += [f"O{name}", *lines, "M99"]
            self.out.append(f"G65 P{name}{times}{given}")
        elif kind == "word":
            self.first += [f"o{name} sub", *lines, f"o{name} endsub"]
            self.out += [f"o{name} call"] * count
        else:
            self.files[f"part{name}.ngc"] = "\n".join([f"o<part{name}> sub", *lines, f"o<part{name}> endsub", "M2", ""])
            self.out += [f"o<part{name}> call"] * count

    def called(self, part, depth):
        self.radius = None
        return super().called(part, depth)

    def again(self, group, depth):
        """What comes again from where it ends, under G91."""
        if self.turn or self.polar or self.relative:
            return False
        _, form, items = group
        outside = self.chance(0.3)

        def write():
            self.out += [] if outside else ["G91"]
            self.relatively(items[: form["body"]])
            self.out += [] if outside else ["G90"]

        self.out += ["G91"] * outside
        self.subprogram(write, form["count"])
        self.out += ["G90"] * outside
        self.ends_with(items)
        return True

    def holes(self, group, depth):
        """G81 to G89, which have a level of the first hole, R and one way out."""
        _, form, items = group
        feeds = [item[2] for item in items if item[0] == "line" and item[2] is not None]
        above = self.at[2]
        if form["way"] == "tap" or self.relative or len(set(feeds)) > 1 or form["back"] not in (above, form["clear"]):
            return False
        if form["way"] == "ream" and form["back"] != form["clear"]:
            return False
        if self.polar and not self.may_be_polar([group]):
            return False
        code = {"drill": "G81", "ream": "G85"}[form["way"]]
        if form["dwell"]:
            code = {"drill": "G82", "ream": "G89"}[form["way"]] + f" P{form['dwell']}"
        for i, place in enumerate(form["places"]):
            # The first may say where it is drilled, or be where the tool is.
            words = self.end([*place, above])
            words = [word for word in words if word[0] not in "Zz"]
            z, r = self.local([*place, form["depth"]])[2], self.local([*place, form["clear"]])[2]
            if i == 0:
                head = ["G98" if form["back"] == above else "G99", code]
                self.out.append(" ".join(head + words + [self.word("Z", z), self.word("R", r), self.word("F", feeds[0])]))
            else:
                self.out.append(" ".join(words))
            self.at = [*place, form["back"]]
        self.feed = feeds[0]
        self.out.append("G80")
        return True


def plain(truth, rng, rewritten=False):
    """Only what pygcode reads, too."""
    writer = GCode(rng, False, False)
    for item in flat(truth):
        writer.item(item)
    return "\n".join(["%", "O1 (RANDOM)", "G21 G90 G17 G94", *writer.out, "M5", "M30", "%", ""]), "nc"


def gcode(truth, rng, rewritten=False):
    writer = GCode(rng, not rewritten)
    writer.run(truth)
    head = ["%", "O1 (RANDOM)", *writer.first, "G21 G90 G17 G94"]
    return "\n".join([*head, *writer.out, "M5", "M30", *writer.parts, *writer.subs, "%", ""]), "nc", writer.files
