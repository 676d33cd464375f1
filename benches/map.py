"""Times `detune map` from end to end: CSV, .npy and reduced maps of 10^3 to 10^8 poses of the IRB 1600.

    cargo build --release && python3 benches/map.py [target/release/detune [LARGEST [FOLDER]]]

NumPy makes the .npy files. Poses are the program's own random ones, written to FOLDER (a temporary one if none is named) first; 10^8 of
them are only reduced. Start-up, the time of a map of one pose, is taken off. The least of several runs
stands for each figure: wall-clock, and the processors' time (user and system), which other work on the machine
disturbs less.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROBOT = "robots/irb1600"
MOST_WRITTEN = 10**7


def times(command, threads):
    """Wall-clock and processor seconds of one run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    environment = dict(os.environ, RAYON_NUM_THREADS=str(threads))
    quiet = subprocess.DEVNULL
    subprocess.run(command, check=True, env=environment, stdout=quiet, stderr=quiet)
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def least(command, threads, repetitions):
    runs = [times(command, threads) for _ in range(repetitions)]
    return tuple(min(column) for column in zip(*runs))


def main():
    detune = sys.argv[1] if len(sys.argv) > 1 else "target/release/detune"
    largest = int(float(sys.argv[2])) if len(sys.argv) > 2 else 10**6
    folder = Path(sys.argv[3]) if len(sys.argv) > 3 else Path(tempfile.mkdtemp())
    base = [detune, "map", ROBOT]
    print("| poses | from | to | threads | wall ns/pose | processor ns/pose |")
    print("|---:|---|---|---:|---:|---:|")
    count = 1000
    while count <= largest:
        random = ["--random", str(count), "--seed", "1"]
        ways = [("inside", "reduced", random + ["--reduce", "min,max,mean,quantiles"])]
        if count <= MOST_WRITTEN:
            csv, npy, out = folder / "poses.csv", folder / "poses.npy", folder / "out"
            subprocess.run(base + random + ["--output", csv], check=True)
            as_npy(csv, npy)
            write = ["--output", out]
            ways += [
                ("npy", "npy", ["--poses", npy, "--format", "npy"] + write),
                ("csv", "csv", ["--poses", csv] + write),
                ("csv", "npy", ["--poses", csv, "--format", "npy"] + write),
                ("inside", "npy", random + ["--format", "npy"] + write),
                ("inside", "csv", random + write),
            ]
        repetitions = 7 if count <= 10**6 else 3
        for source, target, options in ways:
            for threads in (1, 2):
                one = least(base + ["--random", "1", "--format", "npy", "--output", folder / "one"], threads, 7)
                wall, processor = least(base + options, threads, repetitions)
                wall, processor = (1e9 * (t - s) / count for t, s in zip((wall, processor), one))
                print(
                    f"| {count:.0e} | {source} | {target} | {threads} | {wall:.0f} | {processor:.0f} |",
                    flush=True,
                )
        count *= 10


def as_npy(csv, npy):
    """The joints of a map as an array."""
    import numpy

    with open(csv) as file:
        titles = file.readline().strip().split(",")
    joints = [i for i, title in enumerate(titles) if title.startswith("joint_")]
    numpy.save(npy, numpy.loadtxt(csv, delimiter=",", skiprows=1, usecols=joints))


if __name__ == "__main__":
    main()
