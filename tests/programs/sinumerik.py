"""Sinumerik's G-code, with Siemens' own words."""

import math

from lists import direction_at, heading, n, on_bow
from writer import Writer


class Sinumerik(Writer):
    def __init__(self, rng, rewritten):
        ways = [self.moved] if rewritten else [self.moved, self.called, self.called]
        super().__init__(rng, ways, {"holes": self.holes, "again": self.again})
        self.rewritten, self.count, self.relative = rewritten, 0, False
        self.pole, self.radius, self.way, self.rpm, self.held = None, None, None, 6000.0, None

    def item(self, item):
        way = heading(self.at, item) if self.at and item[0] in ("line", "arc", "bow") else self.way
        super().item(item)
        self.way = way

    def word(self, letter, value):
        equals = "=" if letter[-1].isdigit() else self.rng.choice(["", "", "=", " = "])
        return letter + equals + n(value)

    def to(self, letter, value, start):
        """The word of a place, from the zero or from where the tool is."""
        if self.relative:
            return self.word(letter, value - start)
        kind = self.rng.random() if self.at else 1.0
        if kind < 0.12:
            return f"{letter}=IC({n(value - start)})"
        return f"{letter}=AC({n(value)})" if kind < 0.2 else self.word(letter, value)

    def end(self, end, letters="XYZ"):
        new, old = self.local(end), self.local(self.at or end)
        return [
            self.to(letter, new["XYZ".index(letter)], old["XYZ".index(letter)])
            for letter in letters
            if self.at is None or abs(new["XYZ".index(letter)] - old["XYZ".index(letter)]) > 1e-10 or self.chance(0.3)
        ]

    def fed(self, feed):
        if feed is None or feed == self.feed and not self.chance(0.2):
            return []
        if self.feed is not None and self.chance(0.3):
            return [f"FB={n(feed)}"]
        self.feed = feed
        return [f"F{n(feed)}" if self.chance(0.7) else f"F={n(feed)}"]

    def block(self, words, feed):
        number = f"N{10 * len(self.out)} " if self.chance(0.3) else ""
        self.out.append(number + " ".join(words + self.fed(feed)) + self.rng.choice(["", " ; X5"]))

    def speed(self, rpm):
        self.out.append(self.rng.choice([f"S{n(rpm)} M3", f"M3 S={n(rpm)}", f"R90={n(rpm)}\nS=R90 M3"]))
        self.feed, self.rpm = None, rpm

    def dwell(self, seconds):
        turns = seconds * self.rpm / 60
        self.out.append(f"G4 F{seconds}" if self.rewritten or self.chance(0.7) else f"G4 S{n(turns)}")

    def polar(self, centre, end):
        """The words of an end about a pole, which is set before where it is another."""
        x, y, _ = self.local(centre)
        hx, hy, _ = self.local(self.at)
        if self.pole is None or math.dist(self.pole, (x, y)) > 1e-9:
            ways = [f"G111 X{n(x)} Y{n(y)}", f"G110 X{n(x - hx)} Y{n(y - hy)}"]
            if self.pole:
                ways.append(f"G112 X{n(x - self.pole[0])} Y{n(y - self.pole[1])}")
            self.out.append(self.rng.choice(ways))
            self.pole, self.radius = (x, y), None
        ex, ey, _ = self.local(end)
        radius = math.hypot(ex - x, ey - y)
        angle = math.degrees(math.atan2(ey - y, ex - x)) + self.rng.choice([0, 0, 360])
        words = [f"AP={n(angle)}"]
        if self.radius is None or abs(self.radius - radius) > 1e-9 or self.chance(0.5):
            words.append(f"RP={n(radius)}")
        self.radius = radius
        return words

    def line(self, end, feed):
        code, kind = "G0" if feed is None else "G1", self.rng.random()
        dx, dy, dz = (b - a for a, b in zip(self.at or end, end))
        if self.relative or self.at is None or kind > 0.55:
            words = self.end(end)
        elif kind < 0.3:
            # About the pole of before, the zero or another place.
            near = [0.0, 0.0, 0.0] if self.chance(0.2) else [round(self.rng.uniform(-60, 60), 2) for _ in range(3)]
            pole = [a + b for a, b in zip(self.pole, self.shift)] if self.pole and self.chance(0.5) else near[:2]
            pole = [*pole, 0.0]
            if math.dist(pole[:2], end[:2]) < 0.5:
                return self.block([code] + self.end(end) + ["Z" + n(self.local(end)[2])] * (dx == dy == dz == 0), feed)
            words = self.polar(pole, end) + self.end(end, "Z")
        elif dz == 0 and max(abs(dx), abs(dy)) > 0.5:
            turns = self.rng.choice([0, 0, 360, -360])
            words = [f"ANG={n(math.degrees(math.atan2(dy, dx)) + turns)}"]
            x, y, _ = self.local(end)
            hx, hy, _ = self.local(self.at)
            words.append(self.to("X", x, hx) if abs(dx) > abs(dy) else self.to("Y", y, hy))
        else:
            words = self.end(end)
        self.block([code] + (words or [f"Z{n(0 if self.relative else self.local(end)[2])}"]), feed)

    def through(self, via, end, feed):
        words = ["CIP"] + self.end(end)
        new, old = self.local(via), self.local(self.at)
        for letter, axis, value, start in zip(("I1", "J1", "K1"), "XYZ", new, old):
            if axis != "Z" or abs(value - start) > 1e-10 or self.chance(0.5):
                words.append(self.to(letter, value, start))
        self.block(words, feed)

    def bow(self, centre, a, b, sweep, end, feed):
        self.through(on_bow(centre, a, b, sweep * self.rng.uniform(0.3, 0.7)), end, feed)

    def arc(self, centre, sweep, end, feed):
        radius, angle, code = math.dist(self.at[:2], centre[:2]), abs(sweep), "G3" if sweep > 0 else "G2"
        starts = direction_at(centre, self.at, sweep)
        is_flat = end[2] == self.at[2]
        if is_flat and self.way and sum(a * b for a, b in zip(starts, self.way)) > 1 - 1e-12 and self.chance(0.6):
            words = self.end(end, "XY") or [self.to("X", self.local(end)[0], self.local(self.at)[0])]
            return self.block(["CT"] + words, feed)
        kind = self.rng.random()
        if kind < 0.25 and not self.relative:
            words = self.polar([*centre[:2], 0.0], end)
            return self.block([code] + words + ([] if is_flat else self.end(end, "Z")), feed)
        if kind < 0.5 and is_flat:
            start = math.atan2(self.at[1] - centre[1], self.at[0] - centre[0])
            on = start + sweep * self.rng.uniform(0.3, 0.7)
            via = [centre[0] + radius * math.cos(on), centre[1] + radius * math.sin(on), self.at[2]]
            return self.through(via, end, feed)
        words = [code] + self.end(end, "XY" if is_flat else "XYZ")
        if kind < 0.7 and 0.3 < angle < 5.5 and abs(angle - math.pi) > 0.3:
            words.append(f"CR={n(radius if angle < math.pi else -radius)}")
        else:
            c, a = self.local([*centre[:2], 0.0]), self.local(self.at)
            for letter, i in (("I", 0), ("J", 1)):
                words.append(f"{letter}=AC({n(c[i])})" if self.chance(0.2) and not self.relative else self.word(letter, c[i] - a[i]))
        self.block(words, feed)

    def moved(self, part, depth):
        if self.relative:
            return False
        before, self.pole = self.shift, None
        by = [round(self.rng.uniform(-30, 30), 2) for _ in range(3)]
        name = self.rng.choice(["TRANS", "ATRANS"])
        self.shift = by if name == "TRANS" else [a + b for a, b in zip(before, by)]
        self.out.append(" ".join([name, *(f"{axis}{n(value)}" for axis, value in zip("XYZ", by))]))
        self.run(part, depth)
        self.pole, self.shift = None, before
        self.out.append("TRANS" + "".join(f" {a}{n(v)}" for a, v in zip("XYZ", before) if before != [0, 0, 0]))
        return True

    def subprogram(self, write, count):
        """A stretch in a file of its own, which is called so many times."""
        self.count += 1
        self.pole, name = None, self.rng.choice([f"L{100 + self.count}", f"PART{self.count}", f"part_{self.count}"])
        lines = self.captured(write)
        self.pole = None
        head = [f"PROC {name}"] if self.chance(0.2) and name[0] != "L" else []
        self.files[f"{name}.spf"] = "\n".join([*head, *lines, self.rng.choice(["M17", "RET"]), ""])
        self.out.append(name + (f" P{count}" if count > 1 else ""))

    def again(self, group, depth):
        """What comes again from where it ends: from a label on, or in a file of its own."""
        _, form, items = group
        body, count = items[: form["body"]], form["count"]
        if self.relative:
            return False

        def write():
            self.out.append("G91")
            self.relatively(body)
            self.out.append("G90")

        if self.rewritten or self.chance(0.5):
            self.count += 1
            label = f"AGAIN{self.count}"
            self.out += [f"{label}:", *self.captured(write), f"REPEAT {label} P={count - 1}"]
        else:
            self.subprogram(write, count)
        self.pole, self.way = None, None
        self.ends_with(items)
        return True

    def holes(self, group, depth):
        _, form, items = group
        # The feeds of CYCLE85 stand in its call, where none is written anew.
        if self.relative or self.rewritten and form["way"] == "ream":
            return False
        way, clear, surface, depth_at, back = (form[key] for key in ("way", "clear", "surface", "depth", "back"))
        level = lambda z: n(z - self.shift[2])
        dwell = n(form["dwell"]) if form["dwell"] else self.rng.choice(["", "0"])
        # The last depth from the zero, or from the surface.
        depths = [level(depth_at), ""] if self.chance(0.5) else ["", n(surface - depth_at)]
        words = [level(back), level(surface), n(clear - surface), *depths]
        feeds = [item[2] for item in items if item[0] == "line" and item[2] is not None]
        if way == "drill":
            if feeds[0] != self.feed:
                self.out.append(f"F{n(feeds[0])}")
                self.feed = feeds[0]
            cycle = "CYCLE82" if form["dwell"] or self.chance(0.3) else "CYCLE81"
            words += [dwell] if cycle == "CYCLE82" else []
        elif way == "ream":
            cycle, words = "CYCLE85", words + [dwell, n(feeds[0]), n(feeds[1])]
        else:
            size, pitch = "", ""
            if self.chance(0.5) and form["size"] >= 3:
                size = n(form["hand"] * form["size"])
            else:
                pitch = n(form["hand"] * (feeds[0] / form["in"]))
            out = n(form["out"]) if form["out"] != form["in"] or self.chance(0.5) else self.rng.choice(["", "0"])
            stop = self.rng.choice(["", "0", "90"])
            cycle, words = "CYCLE84", words + [dwell, "3", size, pitch, stop, n(form["in"]), out]
        while words[-1] == "":
            words.pop()
        call = f"{cycle}({self.rng.choice([',', ', ']).join(words)})"
        pattern = form["pattern"]
        if pattern != "free" and self.chance(0.7):
            x, y, *rest = form["words"]
            values = [x - self.shift[0], y - self.shift[1], *rest]
            name = "HOLES1" if pattern == "row" else "HOLES2"
            self.out += [f"MCALL {call}", f"{name}({','.join(n(v) for v in values)})", "MCALL"]
        elif self.chance(0.5):
            # Places on a circle by their angles, the pole set before the cycle holds.
            is_polar = pattern == "circle" and self.chance(0.7)
            words = lambda place: self.polar([*form["words"][:2], 0.0], place) if is_polar else self.end(place, "XY")
            for i, place in enumerate([*place, self.at[2]] for place in form["places"]):
                to = words(place)
                self.out += [f"MCALL {call}"] * (i == 0)
                self.block(["G0"] + to, None)
                self.at = [*place[:2], back]
            self.out.append("MCALL")
        else:
            for place in form["places"]:
                self.line([*place, self.at[2]], None)
                self.out.append(call)
                self.at = [*place, back]
        self.at, self.way = [*form["places"][-1], back], None
        self.feed = self.feed if way == "drill" else None
        self.radius = None
        return True


def sinumerik(truth, rng, rewritten=False):
    writer = Sinumerik(rng, rewritten)
    writer.run(truth)
    return "\n".join(["G710 G17 G90 G94", *writer.out, "M5", "M30", ""]), "mpf", writer.files
