"""How often does a job ring if the springs are off by 15 %? One robot file a draw, jobs checked by
the module, beside the probability that detune itself states.

python python/examples/monte_carlo.py [JOB] [DRAWS]
"""

import pathlib
import re
import sys
import tempfile

import numpy as np

import detune

job = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "jobs/pocket.yaml").resolve()
draws = int(sys.argv[2]) if len(sys.argv) > 2 else 40
text = job.read_text()
robot = (job.parent / re.search(r"^robot:\s*(\S+)", text, re.M).group(1)).resolve()
robot_text = robot.read_text()
rng = np.random.default_rng(1)
spring = re.compile(r"(stiffness_nm_per_rad:\s*)([0-9.e+]+)")

with tempfile.TemporaryDirectory() as folder:
    jobs = []
    for draw in range(draws):
        def off(match):
            return f"{match[1]}{float(match[2]) * np.exp(0.15 * rng.normal()):.1f}"

        drawn = spring.sub(off, robot_text)
        drawn = re.sub(r"^(urdf:\s*)(\S+)", lambda m: f"{m[1]}{robot.parent / m[2]}", drawn, flags=re.M)
        robot_file = pathlib.Path(folder, f"robot{draw}.yaml")
        robot_file.write_text(drawn)
        job_file = pathlib.Path(folder, f"job{draw}.yaml")
        drawn_job = re.sub(r"^robot:.*$", f"robot: {robot_file}", text, flags=re.M)
        job_file.write_text(re.sub(r"file:\s*(\w[\w.]*)", lambda m: f"file: {job.parent / m[1]}", drawn_job))
        jobs.append(job_file)
    checked = detune.check(*jobs)
    rings = [any(crossing["certainty"] == "certain" for operation in one["operations"]
                 for crossing in operation["crossings"]) for one in checked.to_dict()["jobs"]]
    print(f"a line lies in a band in {sum(rings)} of {draws} draws")
    stated = detune.check(job).jobs[0].operations
    print("detune states", ", ".join(f"{operation.probability:.2f}" for operation in stated))
