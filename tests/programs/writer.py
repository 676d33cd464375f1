"""What the writers of machine languages share: which stretch of a list gets which dress."""

from lists import end_of, is_move


class Writer:
    """Where the tool is, the feed that holds, and the lines so far. `forms` are methods that write a stretch in a form of
    their own and return whether they did; `groups` those for groups, by kind."""

    def __init__(self, rng, forms, groups):
        self.rng, self.forms, self.groups = rng, forms, groups
        self.out, self.at, self.feed, self.shift, self.files = [], None, None, [0.0, 0.0, 0.0], {}

    def chance(self, share):
        return self.rng.random() < share

    def local(self, p):
        """A point as the program has it."""
        return [x - y for x, y in zip(p, self.shift)]

    def run(self, items, depth=0):
        """Stretch after stretch; in a form at most three deep."""
        left = list(items)
        while left:
            count = self.rng.randint(1, 5)
            part, left = left[:count], left[count:]
            if self.at is None or depth > 2 or not self.chance(0.5) or not self.rng.choice(self.forms)(part, depth + 1):
                self.each(part, depth)

    def each(self, items, depth):
        for item in items:
            if item[0] != "group":
                self.item(item)
            elif not self.chance(0.8) or not self.groups[item[1]["kind"]](item, depth):
                self.run(item[2], 3)

    def item(self, item):
        getattr(self, item[0])(*item[1:])
        if is_move(item):
            self.at = list(end_of(item))

    def called(self, part, depth):
        """A stretch as a subprogram."""
        self.subprogram(lambda: self.run(part, depth), 1)
        return True

    def relatively(self, items):
        """By relative numbers alone, as what comes again from where it ends; the way that it ends in is another at
        first than when it comes again."""
        self.relative, self.way = True, None
        self.each(items, 3)
        self.relative = False

    def ends_with(self, items):
        moves = [item for item in items if is_move(item)]
        self.at = list(end_of(moves[-1])) if moves else self.at

    def captured(self, write):
        """The lines of what is written apart; it knows nothing of the feed before, nor is its own known behind it."""
        out, self.out, self.feed = self.out, [], None
        write()
        lines, self.out, self.feed = self.out, out, None
        return lines
