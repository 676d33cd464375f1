"""How often does a job ring if the springs are off by 15 %? Jobs checked with springs drawn anew,
beside the probability that detune itself states.

python python/examples/monte_carlo.py [JOB] [DRAWS]
"""

import sys

import detune
from detune import fleet

job = sys.argv[1] if len(sys.argv) > 1 else "jobs/pocket.yaml"
draws = int(sys.argv[2]) if len(sys.argv) > 2 else 40

# With client=dask.distributed.Client(…) on as many machines as there are.
rows = fleet.monte_carlo(job, draws, std_percent=15)
rings = sum(any(row.get("rings", [])) for row in rows)
print(f"a line lies in a band in {rings} of {draws} draws")
stated = detune.check(job, samples="none").jobs[0].operations
print("detune states", ", ".join(f"{operation.probability:.2f}" for operation in stated))
