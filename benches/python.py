"""Times the Python module against the command and against itself, ratios in one run: poses from numpy to
numpy, two threads of Python at once, two workers of a Dask cluster against one, and statistics of poses in parts.

    pip install '.[fleet]' && python3 benches/python.py [target/release/detune]

A reduced map of the command's own random poses, less that of one pose, is the command's time for as many
eigenproblems. The least of several runs stands for each figure.
"""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np

import detune

ROOT = Path(__file__).resolve().parent.parent
ROBOT = str(ROOT / "robots/irb1600/robot.yaml")
POSES = 10**6
REDUCED = 2 * 10**8
ROUNDS = 5


def least(work, rounds=ROUNDS):
    """Wall-clock seconds of the fastest of several runs."""
    found = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)


def command(program, poses):
    """A map of random poses that writes one table of ranges."""
    arguments = [program, "map", ROBOT, "--random", str(poses), "--seed", "1", "--reduce", "min,max"]
    subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def at_once(robot, poses):
    """Two threads, each with all poses on one thread of its own."""
    threads = [threading.Thread(target=robot.frequencies, args=(poses,), kwargs={"parallel": False})
               for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def fleet(job, offsets_mm, turns_deg):
    """Seconds of one process and of two workers for placements of a job, and whether they say the same."""
    from dask.distributed import Client, LocalCluster
    from detune import fleet as spread

    os.environ["RAYON_NUM_THREADS"] = "1"
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            spread.placements(job, offsets_mm[:2], turns_deg, client=client)
            serial = least(lambda: spread.placements(job, offsets_mm, turns_deg, client=client), 1)
            cluster.scale(2)
            client.wait_for_workers(2)
            spread.placements(job, offsets_mm[:2], turns_deg, client=client)
            wall = least(lambda: spread.placements(job, offsets_mm, turns_deg, client=client), 1)
            there = spread.placements(job, offsets_mm[:2], turns_deg, client=client)
    return serial, wall, there == spread.placements(job, offsets_mm[:2], turns_deg)


def reduced(program):
    """Seconds of the command and of two workers for statistics of as many poses, and whether they agree."""
    from dask.distributed import Client, LocalCluster
    from detune import fleet as spread

    options = ["--random", str(REDUCED), "--seed", "1", "--reduce", "min,max,quantiles", "--format", "json"]
    whole = []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            def parts():
                return spread.statistics(ROBOT, REDUCED, reduce="min,max,quantiles", client=client)

            def undivided():
                whole.append(subprocess.run([program, "map", ROBOT, *options], check=True, capture_output=True).stdout)

            of_command = least(undivided, 2)
            of_fleet = least(parts, 2)
            return of_command, of_fleet, parts() == json.loads(whole[0])


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/detune")
    robot = detune.Robot(ROBOT)
    low, high = -np.pi / 2, np.pi / 2
    poses = np.random.default_rng(1).uniform(low, high, (POSES, 6))

    of_command = least(lambda: command(program, POSES)) - least(lambda: command(program, 1))
    of_module = least(lambda: robot.frequencies(poses))
    print(f"{POSES} poses, numpy to numpy: {of_module:.3f} s, command {of_command:.3f} s, "
          f"ratio {of_module / of_command:.2f}")

    alone = least(lambda: robot.frequencies(poses, parallel=False))
    both = least(lambda: at_once(robot, poses))
    print(f"two threads at once: {2 * alone / both:.2f} times one after the other")

    offsets = [(x, y, 0.0) for x in range(-40, 41, 10) for y in range(-40, 41, 10)]
    serial, wall, same = fleet(str(ROOT / "jobs/pocket.yaml"), offsets, [0.0, 30.0])
    print(f"two workers: {wall:.1f} s, one {serial:.1f} s, ratio {wall / serial:.2f}, "
          f"{'the same values' if same else 'OTHER VALUES'}")

    of_command, of_fleet, same = reduced(program)
    print(f"{REDUCED:.0e} poses reduced: {of_fleet:.1f} s in parts, command {of_command:.1f} s, "
          f"{'the same values' if same else 'OTHER VALUES'}")


if __name__ == "__main__":
    main()
