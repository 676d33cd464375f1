"""What was compared and how far apart it was, in one place for all parts of the check."""

import collections

WORST = collections.defaultdict(float)  # figure -> worst value attained
WHERE = {}  # figure -> where
FAILURES = []
COUNTS = collections.Counter()


def worst(figure, value, where=""):
    """Keeps the worst value of a figure; NaN is the worst of all."""
    value = float(value)
    if not value <= WORST[figure]:
        WORST[figure] = value
        WHERE[figure] = str(where)


def fail(where, what):
    """The program and this check disagree."""
    FAILURES.append(f"{where}: {what}")
    print(f"DISAGREES {where}: {what}", flush=True)


def expect(figure, value, limit, where):
    """Records a figure and fails where it is above its limit."""
    worst(figure, value, where)
    if not value <= limit:
        fail(where, f"{figure} is {float(value):.3e}, must be at most {limit:.1e}")
