"""Jobs, poses and placements on a local cluster of two processes: the serial result to the byte, also
when a worker is lost on the way."""

import json
import os
import pathlib
import signal
import threading
import time

import numpy as np
import pytest
from dask.distributed import Client, LocalCluster

import detune
from detune import fleet

ROOT = pathlib.Path(__file__).resolve().parents[2]
JOB = ROOT / "jobs/pocket.yaml"
JOBS = ["jobs/contour.yaml", "jobs/pocket.yaml", "jobs/rail.yaml"]


@pytest.fixture(scope="module")
def client():
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


def test_checks_are_those_of_one_process(client, monkeypatch):
    monkeypatch.chdir(ROOT)
    serial = detune.check(*JOBS).to_dict()
    for found in (fleet.check(JOBS, client=client), fleet.check(JOBS)):
        assert json.dumps(found.to_dict()) == json.dumps(serial)
    advised = fleet.advise(JOBS, client=client, objective="margin")
    assert [one.operations for one in advised] == [
        detune.advise(job, objective="margin").operations for job in JOBS
    ]


def test_frequencies_are_the_serial_ones_when_a_worker_is_killed(client):
    robot = detune.Robot(ROOT / "robots/irb1600")
    q = np.random.default_rng(3).uniform(-1, 1, (400_000, len(robot.joint_names)))
    serial = robot.frequencies(q)
    victim = next(iter(client.run(os.getpid).values()))
    killer = threading.Timer(0.15, os.kill, (victim, signal.SIGKILL))
    killer.start()
    found = fleet.frequencies(robot, q, client=client, chunk=20_000)
    killer.join()
    assert found.tobytes() == serial.tobytes()
    begun = time.monotonic()
    while victim in client.run(os.getpid).values():
        assert time.monotonic() - begun < 30, "nothing was killed"
        time.sleep(0.1)


def test_placements_are_sorted_by_their_clear_band(client):
    offsets = [[0, 0, 0], [0, 60, 40], [9000, 0, 0]]
    rows = fleet.placements(JOB, offsets, [0, 25], client=client)
    assert rows == fleet.placements(JOB, offsets, [0, 25])
    assert len(rows) == 6
    widths = [row["clear_rpm"] for row in rows if "clear_rpm" in row]
    assert len(widths) >= 2 and widths == sorted(widths, reverse=True)
    assert {tuple(row["offset_mm"]) for row in rows if "faults" in row} >= {(9000.0, 0.0, 0.0)}
    # Where nothing is moved, the job's own advice.
    own = next(row for row in rows if row["offset_mm"] == [0, 0, 0] and row["turn_deg"] == 0)
    advised = detune.advise(JOB, objective="margin").to_dict()
    assert own["recommended_rpm"] == [one["recommended_rpm"] for one in advised["operations"]]


def test_what_does_not_move_is_refused():
    with pytest.raises(ValueError, match="contour.*own work object"):
        fleet.placements(ROOT / "jobs/contour.yaml", [[0, 60, 40]])


@pytest.mark.parametrize("rpy", [[0.3, -0.4, 2.0], [0.1, np.pi / 2, 0.7], [0, -np.pi / 2, 0.2]])
def test_turns_about_the_tools_axis_are_urdf_angles(rpy):
    turned = fleet._matrix(rpy) @ fleet._about_z(0.6)
    assert np.abs(fleet._matrix(fleet._rpy(turned)) - turned).max() < 1e-12
