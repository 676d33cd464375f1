#!/usr/bin/env python3
"""Spectral radii of milling by `detune lobes` and by a public implementation of semi-discretisation, in one run.

    python3 benches/peers/stability.py target/release/detune FOLDER [--speeds 40] [--intervals 40 160]

FOLDER holds a clone of https://github.com/V0es/milling-analyzer (Python with numpy and scipy, MIT), which solves
one mode across the feed with even teeth. The case is the benchmark of Insperger and Stepan (Int. J. Numer. Meth.
Engng 61, 2004, table I): 922 Hz, damping ratio 0.011, 0.03993 kg, two teeth, K_t 6e8 and K_n 2e8 N/m2, a slot.
Both solve the same speeds and depths on one processor. The time of detune is that of the whole command.
"""

import argparse
import contextlib
import os
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np

CASE = """modes: [{frequency_hz: 922, damping_ratio: 0.011, mass_kg: 0.03993, axis: [1, 0, 0]}]
tool: {teeth: 2}
cutting: {direction: slot, coefficients: {ktc_n_per_mm2: 600, krc_n_per_mm2: 200}}
"""
DEPTHS_MM = [0.2, 0.5, 0.7, 1.0]
# Exact at 5000 rpm, to ten digits by two methods.
AT_5000_RPM = [0.8197427843, 1.0739755867, 1.2215561357, 1.4064735253]


def own(program, speeds):
    """Radii, speeds in rows and depths in columns, and the seconds for all."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "modes.yaml")
        with open(file, "w") as out:
            out.write(CASE)
        columns, start = [], time.perf_counter()
        for depth in DEPTHS_MM:
            speed = f"{speeds[0]!r}:{speeds[-1]!r}:{len(speeds)}"
            command = [program, "lobes", file, "--rpm", speed, "--depth-mm", repr(depth)]
            rows = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[1:]
            columns.append([float(row.split(",")[2]) for row in rows])
        return np.array(columns).T, time.perf_counter() - start


def theirs(folder, speeds, intervals):
    sys.path.insert(0, folder)
    from src.mill import Mill, MillingDirection
    from src.solver import Solver, VariableName, Varying

    mill = Mill(teeth_num=2, tangential_force_coeff=6e8, normal_force_coeff=2e8, relative_damping=0.011, aD=1,
                natural_frequency=922, modal_mass=0.03993, direction=MillingDirection.UP)
    columns, seconds = [], 0.0
    # It leaves the last value of a range out.
    beyond = speeds[-1] + (speeds[1] - speeds[0])
    for depth in DEPTHS_MM:
        solver = Solver(mill, Varying(VariableName.SPINDLE_SPEED, speeds[0], beyond, len(speeds)),
                        Varying(VariableName.DEPTH_OF_CUT, depth * 1e-3, depth * 1e-3, 1),
                        intervals_per_period=intervals)
        start = time.perf_counter()
        with contextlib.redirect_stdout(open(os.devnull, "w")):
            rpm, _, radius = solver.solve()
        seconds += time.perf_counter() - start
        assert np.allclose(rpm[:, 0], speeds)
        columns.append(radius[:, 0])
    return np.array(columns).T, seconds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--speeds", type=int, default=40)
    parser.add_argument("--intervals", type=int, nargs="+", default=[40, 160])
    args = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    speeds = np.linspace(5000.0, 25000.0, args.speeds).tolist()
    count = len(speeds) * len(DEPTHS_MM)
    radii, seconds = own(args.program, speeds)
    off = abs(radii[0] - AT_5000_RPM).max()
    print(f"detune: {1e6 * seconds / count:.0f} us a radius, within {off:.0e} of the exact ones at 5000 rpm")
    assert off < 1e-6
    for intervals in args.intervals:
        other, other_seconds = theirs(args.folder, speeds, intervals)
        print(f"semi-discretisation, {intervals} intervals: {1e6 * other_seconds / count:.0f} us a radius "
              f"({other_seconds / seconds:.0f} times as long), within {abs(other[0] - AT_5000_RPM).max():.0e} there, "
              f"and within {abs(other - radii).max():.0e} of detune at all {count}")


main()
