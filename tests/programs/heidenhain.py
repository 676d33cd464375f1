"""Heidenhain's conversational language."""

import math

from lists import direction_at, heading, n
from writer import Writer


class Heidenhain(Writer):
    def __init__(self, rng):
        super().__init__(rng, [self.moved, self.called, self.called], {"holes": self.holes, "again": self.again})
        self.subs, self.count, self.pole, self.way, self.relative = [], 0, None, None, False

    def item(self, item):
        way = heading(self.at, item) if self.at and item[0] in ("line", "arc") else self.way
        super().item(item)
        self.way = way

    def words(self, end, letters="XYZ", share=0.3):
        new, old = self.local(end), self.local(self.at or end)
        found = []
        for letter, a, b in ((letter, old["XYZ".index(letter)], new["XYZ".index(letter)]) for letter in letters):
            relative = self.at is not None and (self.relative or self.chance(share))
            if self.at is None or abs(b - a) > 1e-10 or self.chance(0.3):
                found.append(f"I{letter}{b - a:+.9f}" if relative else f"{letter}{b:+.9f}")
        return found

    def fed(self, feed):
        if feed is None:
            return " FMAX"
        if feed == self.feed and self.chance(0.8):
            return ""
        self.feed = feed
        return f" F{n(feed)}"

    def block(self, words, feed):
        self.out.append(" ".join(words) + self.fed(feed) + self.rng.choice(["", "", " ; X99"]))

    def speed(self, rpm):
        first = self.rng.choice([[], [], [f"Q50 = {n(rpm)}"], [f"FN 0: Q50 = +{n(rpm)}"]])
        self.out += [*first, f"TOOL CALL 5 Z S+Q50" if first else f"TOOL CALL 5 Z S{n(rpm)}", "M3"]
        self.feed = None

    def dwell(self, seconds):
        text = str(seconds).replace(".", self.rng.choice([".", ","]))
        self.out += ["CYCL DEF 9.0 DWELL TIME", f"CYCL DEF 9.1 DWELL {text}"]

    def set_pole(self, x, y):
        """Of the work as the program has it."""
        hx, hy, _ = self.local(self.at)
        if self.relative or self.chance(0.2):
            self.out.append(f"CC IX{x - hx:+.9f} IY{y - hy:+.9f}")
        else:
            self.out.append(f"CC X{x:+.9f} Y{y:+.9f}")
        self.pole = (x, y)

    def line(self, end, feed):
        hx, hy, _ = self.local(self.at or end)
        x, y, _ = self.local(end)
        if self.at is not None and not self.relative and self.chance(0.35):
            if self.pole is None or self.chance(0.5):
                if self.chance(0.15):
                    self.out.append("CC")
                    self.pole = (hx, hy)
                else:
                    self.set_pole(*(round(self.rng.uniform(-60, 60), 2) for _ in range(2)))
            px, py = self.pole
            far, before = math.hypot(x - px, y - py), math.hypot(hx - px, hy - py)
            if far > 0.5:
                angle = math.degrees(math.atan2(y - py, x - px))
                words = ["LP", f"PR{far:+.9f}"]
                if before > 0.5 and self.chance(0.4):
                    words.append(f"IPA{angle - math.degrees(math.atan2(hy - py, hx - px)):+.9f}")
                    words[1] = f"IPR{far - before:+.9f}" if self.chance(0.3) else words[1]
                else:
                    words.append(f"PA{angle:+.9f}")
                return self.block(words + self.words(end, "Z"), feed)
        words = self.words(end)
        self.block(["L"] + (words or ["IZ+0"]) + self.rng.choice([[], ["R0"]]), feed)

    def arc(self, centre, sweep, end, feed):
        sense, angle, radius = "DR+" if sweep > 0 else "DR-", abs(sweep), math.dist(self.at[:2], centre[:2])
        if end[2] != self.at[2]:
            # The only block for a helix.
            if self.pole is None or math.dist(self.pole, self.local([*centre[:2], 0.0])[:2]) > 1e-9:
                self.set_pole(*self.local([*centre[:2], 0.0])[:2])
            words = self.words(end, "Z")
            return self.block(["CP", f"IPA{math.degrees(sweep):+.9f}", *words, sense], feed)
        starts = direction_at(centre, self.at, sweep)
        if self.way and sum(a * b for a, b in zip(starts, self.way)) > 1 - 1e-12 and self.chance(0.6):
            # CT with no word of its end would be another block.
            return self.block(["CT"] + (self.words(end, "XY") or ["IX+0"]), feed)
        if 0.3 < angle < 5.5 and abs(angle - math.pi) > 0.3 and self.chance(0.25):
            words = self.words(end, "XY")
            return self.block(["CR"] + words + [f"R{radius if angle < math.pi else -radius:+.9f}", sense], feed)
        x, y, _ = self.local([*centre[:2], 0.0])
        if self.pole is None or math.dist(self.pole, (x, y)) > 1e-9:
            self.set_pole(x, y)
        kind = self.rng.random()
        if kind < 0.35 or self.relative and kind < 0.6:
            self.block(["C"] + self.words(end, "XY") + [sense], feed)
        elif kind < 0.65 or self.relative:
            self.block(["CP", f"IPA{math.degrees(sweep):+.9f}", sense], feed)
        else:
            ex, ey, _ = self.local(end)
            self.block(["CP", f"PA{math.degrees(math.atan2(ey - y, ex - x)):+.9f}", sense], feed)

    def moved(self, part, depth):
        if self.relative:
            return False
        before, self.pole = self.shift, None
        self.shift = [round(self.rng.uniform(-30, 30), 2) for _ in range(3)]
        self.datum()
        self.run(part, depth)
        self.pole, self.shift = None, before
        self.datum()
        return True

    def datum(self):
        self.out.append("CYCL DEF 7.0 DATUM SHIFT")
        self.out += [f"CYCL DEF 7.{i + 1} {axis}{value:+.3f}" for i, (axis, value) in enumerate(zip("XYZ", self.shift))]

    def subprogram(self, write, count):
        self.count += 1
        self.pole, label = None, self.rng.choice([str(self.count), f'"PART{self.count}"'])
        lines = self.captured(write)
        self.pole = None
        self.subs += [f"LBL {label}", *lines, "LBL 0"]
        self.out += [f"CALL LBL {label}"] * count

    def again(self, group, depth):
        """What comes again from where it ends: from a label on, or as a subprogram."""
        _, form, items = group
        body, count = items[: form["body"]], form["count"]
        if self.relative:
            return False

        def write():
            self.relatively(body)

        if self.chance(0.6):
            self.count += 1
            label, self.pole = self.rng.choice([str(self.count), f'"AGAIN{self.count}"']), None
            again = f"CALL LBL {label} REP {count - 1}"
            self.out += [f"LBL {label}", *self.captured(write), self.rng.choice([again, f"{again}/{count - 1}"])]
        else:
            self.subprogram(write, count)
        self.pole, self.way = None, None
        self.ends_with(items)
        return True

    def holes(self, group, depth):
        """Cycles 200 and 201, called at places."""
        _, form, items = group
        way, clear, surface, deep, back = (form[key] for key in ("way", "clear", "surface", "depth", "back"))
        if way == "tap" or self.relative:
            return False
        feeds = [item[2] for item in items if item[0] == "line" and item[2] is not None]
        # The surface may count from Z of the call.
        z = self.rng.choice([0.0, surface - self.shift[2], round(self.rng.uniform(-9, 9), 2)])
        by_place = self.chance(0.6)
        top = surface - self.shift[2] - (z if by_place else 0.0)
        second = back - surface if back > clear or self.chance(0.5) else 0.0
        own = [("Q200", clear - surface), ("Q201", deep - surface), ("Q206", feeds[0])]
        if way == "drill":
            name, own = "200 DRILLING", own + [("Q210", 0.0), ("Q202", surface - deep + self.rng.choice([0, 3]))]
        else:
            name, own = "201 REAMING", own + [("Q208", feeds[1])]
        own += [("Q203", top), ("Q204", second), ("Q211", form["dwell"])]
        # The plus of a feed that is written anew is left out.
        sign = lambda q, v: "+" if v >= 0 and q not in ("Q206", "Q208") and self.chance(0.5) else ""
        self.out.append(" ~\n    ".join([f"CYCL DEF {name}", *(f"{q}={sign(q, v)}{n(v)} ;WORD" for q, v in own)]))
        is_polar = form["pattern"] == "circle" and not by_place and self.chance(0.7)
        if is_polar:
            self.set_pole(*self.local([*form["words"][:2], 0.0])[:2])
        for i, place in enumerate(form["places"]):
            x, y, _ = self.local([*place, 0.0])
            if by_place:
                self.out.append(f"CYCL CALL POS X{x:+.9f} Y{y:+.9f} Z{z:+.9f} FMAX")
            else:
                ways = ["L", *(self.words([*place, self.at[2]], "XY") or ["IX+0"])]
                if is_polar:
                    px, py = self.pole
                    ways = [f"PA{math.degrees(math.atan2(y - py, x - px)):+.9f}"]
                    # The radius of the hole before holds on.
                    ways = ["LP", f"PR{math.hypot(x - px, y - py):+.9f}", *ways] if i == 0 or self.chance(0.3) else ["LP", *ways]
                called = self.rng.choice([[" FMAX M99"], [" FMAX", "CYCL CALL"]])
                self.out += [" ".join(ways) + called[0], *called[1:]]
            self.at = [*place, back]
        self.feed, self.way = None, None
        return True


def heidenhain(truth, rng, rewritten=False):
    writer = Heidenhain(rng)
    writer.run(truth)
    out = ["BEGIN PGM RANDOM MM", "BLK FORM 0.1 Z X-60 Y-60 Z+0", *writer.out, "M5"]
    out += (["M30", *writer.subs] if writer.subs else []) + ["END PGM RANDOM MM"]
    return "\n".join(f"{i} {line}" for i, line in enumerate(out)) + "\n", "h", {}
