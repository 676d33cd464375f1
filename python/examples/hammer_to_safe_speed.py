"""From hammer records to a safe spindle speed: modes, what the model gets wrong, a calibrated robot,
a job on it.

python python/examples/hammer_to_safe_speed.py [REPOSITORY]
"""

import pathlib
import shutil
import sys
import tempfile

import detune

root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")

with tempfile.TemporaryDirectory() as folder:
    robot = pathlib.Path(folder, "two-link")
    shutil.copytree(root / "robots/two-link", robot)

    identified = detune.identify(robot / "session.yaml")
    for record in identified.records:
        modes = ", ".join(f"{mode.frequency_hz:.2f} Hz" for mode in record.modes)
        print(f"{record.record}: {modes}")
    pathlib.Path(folder, "identified.csv").write_text(identified.measured_csv)

    # The paper's own table has poses enough for a diagnosis.
    found = detune.diagnose(robot, robot / "measured.csv")
    print(f"{found.verdict}: error {found.baseline.heldout_rms_percent:.1f} %, "
          f"with the causes {found.extended.heldout_rms_percent:.1f} % at poses left out")
    for finding in found.findings:
        print(f"  {finding.cause} at {finding.at}")
    (robot / "calibrated.yaml").write_text(found.calibrated_yaml)

    job = pathlib.Path(folder, "job.yaml")
    job.write_text(
        "name: Slot\n"
        "robot: two-link/calibrated.yaml\n"
        "payload: none\n"
        "tool: {teeth: 2}\n"
        "spindle: {min_rpm: 500, max_rpm: 6000}\n"
        "operations:\n"
        "  - name: slot\n"
        "    spindle_rpm: 800\n"
        "    feed_mm_per_min: 400\n"
        "    path: {joints_deg: [[0, 60], [5, 80]]}\n"
    )
    checked = detune.check(job)
    advised = detune.advise(job)
    print(f"{checked.verdict} at 800 rpm; run {advised.operations[0].recommended_rpm:.0f} rpm instead")
