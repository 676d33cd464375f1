"""Where to put the fixture, and how to turn the tool, so that a job has the widest clear band of
spindle speeds: a sweep over a grid of places (mm in the base frame) and turns of the tool.

python python/examples/fixture.py [JOB] [--reach-mm 60] [--steps 3] [--turns-deg 0 30 60]
    [--separation-percent 5] [--workers 2 | --scheduler ADDRESS]

--workers starts a cluster here; --scheduler uses one that exists, such as one in SLURM or Kubernetes,
whose workers see the job by the same name. The rows do not depend on which.
"""

import argparse
import contextlib
import itertools

import numpy as np

from detune import fleet

parser = argparse.ArgumentParser()
parser.add_argument("job", nargs="?", default="jobs/pocket.yaml")
parser.add_argument("--reach-mm", type=float, default=60.0, help="farthest along each axis")
parser.add_argument("--steps", type=int, default=3, help="places along each axis")
parser.add_argument("--turns-deg", type=float, nargs="+", default=[0.0, 30.0, 60.0])
parser.add_argument("--separation-percent", type=float, help="wins over the job's policy")
parser.add_argument("--workers", type=int, default=0)
parser.add_argument("--scheduler")


def main(arguments):
    along = np.linspace(-arguments.reach_mm, arguments.reach_mm, arguments.steps)
    # As it stands, too.
    offsets = [(0.0, 0.0, 0.0), *itertools.product(along, along, along)]
    offsets = list(dict.fromkeys((float(x), float(y), float(z)) for x, y, z in offsets))
    with contextlib.ExitStack() as stack:
        client = None
        if arguments.scheduler or arguments.workers:
            from dask.distributed import Client, LocalCluster

            cluster = arguments.scheduler or stack.enter_context(
                LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None)
            )
            client = stack.enter_context(Client(cluster))
        percent = arguments.separation_percent
        policy = {} if percent is None else {"separation_percent": percent}
        rows = fleet.placements(arguments.job, offsets, arguments.turns_deg, client=client, policy=policy)
    now = next(row for row in rows if not any(row["offset_mm"]) and row["turn_deg"] == arguments.turns_deg[0])
    cannot = sum("faults" in row for row in rows)
    print(f"{len(rows)} placements, {cannot} out of reach; rpm that are clear in one piece:")
    for row in [*rows[:3], now]:
        place = ", ".join(f"{mm:+.0f}" for mm in row["offset_mm"])
        speeds = ", ".join("none" if rpm is None else f"{rpm:.0f}" for rpm in row.get("recommended_rpm", []))
        told = "; ".join(row["faults"]) if "faults" in row else f"{row['clear_rpm']:.0f}, run at {speeds}"
        print(f"  ({place}) mm, tool turned by {row['turn_deg']:.0f}°: {told}{' (now)' if row is now else ''}")


if __name__ == "__main__":
    main(parser.parse_args())
