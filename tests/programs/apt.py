"""APT, as CAM systems write it."""

import math

from lists import flat, is_move, n


def apt(truth, rng, rewritten=False):
    truth = flat(truth)
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
                after = next((each for each in truth[index + 1 :] if is_move(each)), None)
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
