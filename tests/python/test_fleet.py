"""Jobs, poses and placements on a local cluster of two processes: the serial result to the byte, also
when a worker is lost on the way."""

import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from dask.distributed import Client, LocalCluster

import detune
from detune import fleet

ROOT = pathlib.Path(__file__).resolve().parents[2]
JOB = ROOT / "jobs/pocket.yaml"
CONTOUR = ROOT / "jobs/contour.yaml"
JOBS = ["jobs/contour.yaml", "jobs/pocket.yaml", "jobs/rail.yaml"]


@pytest.fixture
def milling(tmp_path):
    """The pocket without what the cut does, which takes long."""
    text = (ROOT / "jobs/pocket.yaml").read_text().replace("../robots", str(ROOT / "robots"))
    job = tmp_path / "jobs/milling.yaml"
    job.parent.mkdir()
    job.write_text(re.sub(r"^    cutting: .*\n", "", text, flags=re.M))
    return job


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
    whole = fleet.check(["jobs/[cr]*"], client=client, policy={"separation_percent": 3}, samples="none")
    there = detune.check("jobs/[cr]*.yaml", policy={"separation_percent": 3}, samples="none")
    assert json.dumps(whole.to_dict()) == json.dumps(there.to_dict())
    advised = fleet.advise(JOBS, client=client, objective="margin")
    assert [one.operations for one in advised] == [
        detune.advise(job, objective="margin").operations for job in JOBS
    ]


@contextlib.contextmanager
def a_worker_killed(client):
    """One of the two processes ends while it has work, and it did."""
    address, victim = next(iter(client.run(os.getpid).items()))
    is_over, was_at_work = threading.Event(), threading.Event()

    def kill():
        while not is_over.is_set():
            if client.processing().get(address):
                was_at_work.set()
                return os.kill(victim, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    yield
    is_over.set()
    killer.join()
    assert was_at_work.is_set(), "the work was over before"
    begun = time.monotonic()
    while victim in client.run(os.getpid).values():
        assert time.monotonic() - begun < 30, "nothing was killed"
        time.sleep(0.1)
    client.wait_for_workers(2, timeout=60)


def test_frequencies_are_the_serial_ones_when_a_worker_is_killed(client):
    robot = detune.Robot(ROOT / "robots/irb1600")
    q = np.random.default_rng(3).uniform(-1, 1, (400_000, len(robot.joint_names)))
    serial = robot.frequencies(q)
    with a_worker_killed(client):
        found = fleet.frequencies(robot, q, client=client, chunk=20_000)
    assert found.tobytes() == serial.tobytes()


def test_sweeps_of_jobs_are_the_serial_ones_when_a_worker_is_killed(client, monkeypatch, tmp_path):
    monkeypatch.chdir(ROOT)
    soft = tmp_path / "soft.yaml"
    text = (ROOT / "robots/irb1600/robot.yaml").read_text().replace("_rad: 555000", "_rad: 300000")
    soft.write_text(text.replace("irb1600.urdf", str(ROOT / "robots/irb1600/irb1600.urdf")))
    axes = {"robots": [None, soft], "speeds_rpm": [None, *range(4000, 24000, 800)]}
    jobs = ["jobs/contour.yaml"]
    with a_worker_killed(client):
        found = fleet.sweep(jobs, **axes, client=client)
    assert json.dumps(found) == json.dumps(fleet.sweep(jobs, **axes))
    assert len(found) == 2 * 26 and {row["verdict"] for row in found} == {"resonance", "uncertain", "clear"}
    # The job as it stands, and at another speed.
    contour = CONTOUR.read_text().replace("../robots", str(ROOT / "robots"))
    own_robot = str(ROOT / "robots/irb1600/robot.yaml")
    contour = contour.replace("contour.mod", str(ROOT / "jobs/contour.mod"))
    job = tmp_path / "contour.yaml"
    for row, rpm, robot in ((found[0], 3000, own_robot), (found[-1], 23200, str(soft))):
        assert row["robot"] == (None if robot == own_robot else robot)
        moved = contour.replace("spindle_rpm: 3000", f"spindle_rpm: {rpm}").replace(own_robot, robot)
        job.write_text(moved)
        own = detune.check(job).jobs[0]
        assert (row["verdict"], row["probability"]) == (own.verdict, own.probability)


def test_what_would_not_count_is_refused(tmp_path, milling):
    job = tmp_path / "contour.yaml"
    text = CONTOUR.read_text().replace("../robots", str(ROOT / "robots"))
    job.write_text(text.replace("contour.mod", str(ROOT / "jobs/contour.mod")) + "speeds_from: program\n")
    with pytest.raises(ValueError, match="no speed of a sweep would count"):
        fleet.sweep([job], speeds_rpm=[3000])
    with pytest.raises(detune.DetuneError, match="did you mean 'separation_percent'"):
        fleet.placements(milling, policy={"separation_percnt": 3})


def test_draws_depend_on_the_seed_alone(client):
    rows = fleet.monte_carlo(CONTOUR, 12, std_percent=15, client=client)
    assert json.dumps(rows) == json.dumps(fleet.monte_carlo(CONTOUR, 12, std_percent=15))
    assert rows[:5] == fleet.monte_carlo(CONTOUR, 5, std_percent=15)
    assert rows[0] != fleet.monte_carlo(CONTOUR, 1, seed=2, std_percent=15)[0]
    drawn = np.log([list(row["factors"].values()) for row in rows])
    assert drawn.shape == (12, 6) and 0.1 < drawn.std() < 0.2
    still = fleet.monte_carlo(CONTOUR, 1, std_percent=0)[0]
    own = detune.check(CONTOUR, samples="none").jobs[0]
    assert still["verdicts"] == [one.verdict for one in own.operations]


def test_statistics_are_those_of_the_command(client):
    robot = ROOT / "robots/two-link"
    found = fleet.statistics(robot, 100_000, seed=3, parts=5, client=client)
    options = "--random 100000 --seed 3 --reduce min,max,mean,quantiles --format json".split()
    command = [sys.executable, "-m", "detune", "map", robot, *options]
    whole = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    assert json.dumps(found) == json.dumps(whole)
    with pytest.raises(ValueError, match="median"):
        fleet.statistics(robot, 100, reduce="median", parts=1)


def test_settings_and_numbers_of_a_moved_job_stay(tmp_path, milling):
    """A detune.toml above the job counts where the job is moved, too, and 5e2 is a number."""
    pytest.importorskip("tomllib")
    text = re.sub(r"^robot: .*\n", "", milling.read_text(), flags=re.M).replace("min_rpm: 500", "min_rpm: 5.0e2")
    job = milling.with_name("of-settings.yaml")
    job.write_text(text)
    (tmp_path / "detune.toml").write_text(
        f"robot = '{ROOT / 'robots/irb1600/robot.yaml'}'\n[policy]\nseparation_percent = 4\n"
        '[[accept]]\ncode = "tcp_assumed"\nreason = "r"\nuntil = 2999-01-01\n'
    )
    rows = fleet.placements(job, [[0, 0, 0], [0, 10, 0]])
    own = next(row for row in rows if not any(row["offset_mm"]))
    advised = detune.advise(job, objective="margin")
    assert own["recommended_rpm"] == [one.recommended_rpm for one in advised.operations]
    default = {"separation_percent": 10}
    assert own["recommended_rpm"] != [
        one.recommended_rpm for one in detune.advise(milling, objective="margin", policy=default).operations
    ]
    wider = fleet.placements(job, policy={"separation_percent": 12})[0]
    assert wider["clear_rpm"] < own["clear_rpm"]
    assert set(own["recommended_rpm"]) != {None}


def test_a_posture_is_another_way_to_the_same_path(client, milling):
    turned_over = [0, 0, 0, 180, 0, 180]
    rows = fleet.placements(milling, starts_deg=[None, turned_over], client=client)
    assert [row["start_near_deg"] for row in rows] == [None, turned_over]
    base = fleet._base(milling)
    (_, here), _ = fleet._starts(base)
    (_, there), _ = fleet._starts(fleet._moved(base, [0, 0, 0], 0, turned_over))
    assert np.abs(np.abs(np.subtract(there, here)[[3, 5]]) - np.pi).max() < 1e-9
    assert abs(here[4] + there[4]) < 1e-9
    with pytest.raises(ValueError, match="joint angles"):
        fleet.placements(ROOT / "jobs/rail.yaml", starts_deg=[[0] * 7])


def test_nothing_to_check_is_an_error():
    for nothing in (fleet.check, fleet.advise, fleet.sweep):
        with pytest.raises(detune.DetuneError, match="no job is given"):
            nothing([])


def test_placements_are_sorted_by_their_clear_band(client, milling):
    offsets = [[0, 0, 0], [0, 60, 40], [9000, 0, 0]]
    policy = {"separation_percent": 5}
    rows = fleet.placements(milling, offsets, [0, 25], client=client, policy=policy)
    assert rows == fleet.placements(milling, offsets, [0, 25], policy=policy)
    assert len(rows) == 6
    widths = [row["clear_rpm"] for row in rows if "clear_rpm" in row]
    assert len(set(widths)) >= 2 and widths == sorted(widths, reverse=True)
    assert {tuple(row["offset_mm"]) for row in rows if "faults" in row} >= {(9000.0, 0.0, 0.0)}
    # Where nothing is moved, the job's own advice.
    own = next(row for row in rows if row["offset_mm"] == [0, 0, 0] and row["turn_deg"] == 0)
    advised = detune.advise(milling, objective="margin", policy=policy).to_dict()
    assert own["recommended_rpm"] == [one["recommended_rpm"] for one in advised["operations"]]


def test_what_does_not_move_is_refused():
    with pytest.raises(ValueError, match="contour.*own work object"):
        fleet.placements(ROOT / "jobs/contour.yaml", [[0, 60, 40]])


@pytest.mark.parametrize("rpy", [[0.3, -0.4, 2.0], [0.1, np.pi / 2, 0.7], [0, -np.pi / 2, 0.2]])
def test_turns_about_the_tools_axis_are_urdf_angles(rpy):
    turned = fleet._matrix(rpy) @ fleet._about_z(0.6)
    assert np.abs(fleet._matrix(fleet._rpy(turned)) - turned).max() < 1e-12
