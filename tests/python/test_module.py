"""The Python module of an installed wheel, against the command and closed forms.

pip install . pytest && pytest tests/python
"""

import json
import math
import pathlib
import pickle
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import detune
import types_of_schemas

ROOT = pathlib.Path(__file__).resolve().parents[2]
TWO_LINK = ROOT / "robots/two-link"
SIX_AXES = ROOT / "robots/irb1600"


def command(*arguments):
    """Standard output of the command that the wheel installs."""
    found = subprocess.run(
        [sys.executable, "-m", "detune", *map(str, arguments)], capture_output=True, cwd=ROOT
    )
    assert found.returncode in (0, 1), found.stderr.decode()
    return found.stdout


def test_frequencies_are_those_of_the_command():
    robot = detune.Robot(TWO_LINK)
    text = command("map", "robots/two-link", "--joint", "joint_2", "--from-deg", 10, "--to-deg", 150,
                   "--steps", 15).decode()
    rows = np.loadtxt(text.splitlines()[1:], delimiter=",")
    found = robot.frequencies(rows[:, :2])
    assert found.shape == (15, 2) and (found == rows[:, 3:]).all()
    assert (robot.frequencies(rows[3, :2]) == rows[3, 3:]).all()
    mapped = detune.map(robot, {"joint_2": (10, 150, 15)})
    assert (mapped.frequencies_hz == rows[:, 3:]).all() and (mapped.poses == rows[:, :2]).all()


def test_shapes_make_the_modal_mass_one():
    robot = detune.Robot(SIX_AXES)
    rng = np.random.default_rng(1)
    q = rng.uniform(-1, 1, (50, len(robot.joint_names)))
    hz, shapes, damping = robot.modes(q)
    n = len(robot.coordinate_names)
    assert hz.shape == (50, n) and shapes.shape == (50, n, n) and damping.shape == (50, n)
    assert (hz == robot.frequencies(q)).all() and (damping > 0).all()
    # Mass-normalised shapes are the columns of M^(-1/2) times a rotation: M = (Φ Φᵀ)⁻¹ is the same
    # by rows of any order, and Φᵀ K Φ = ω² needs K diagonal.
    for f, phi in zip(hz, shapes):
        stiffness = np.linalg.inv(phi) @ np.diag((2 * np.pi * f) ** 2) @ np.linalg.inv(phi).T
        off = stiffness - np.diag(np.diag(stiffness))
        assert np.abs(off).max() < 1e-6 * np.abs(stiffness).max()


def test_the_tip_responds_as_its_modes_do():
    """G = Σ a_r / (ω_r² − ω² + 2iζ_r ω_r ω): two frequencies give the a_r, all others follow."""
    robot = detune.Robot(TWO_LINK)
    q = [0.0, math.pi / 2]
    hz, _, damping = robot.modes(q)
    at = np.array([0.0, 40.0, 25.0, 26.0, 90.0, 200.0])
    found = robot.tip_response(q, at, direction=(1, 0, 0))
    omega_r, omega = 2 * np.pi * hz, 2 * np.pi * at[:, None]
    modal = 1 / (omega_r**2 - omega**2 + 2j * damping * omega_r * omega)
    shares = np.linalg.solve(modal[:2], found[:2])
    assert (shares.real > 0).all() and np.abs(shares.imag).max() < 1e-12
    assert np.abs(found / (modal @ shares) - 1).max() < 1e-9
    assert np.abs(robot.tip_response(q, at, direction=(0, 0, 1)) - found).max() > 1e-9
    with pytest.raises(ValueError, match="direction"):
        robot.tip_response(q, at, direction=(0, 0, 0))


@pytest.mark.parametrize("job", ["jobs/contour.yaml", "jobs/pocket.yaml"])
def test_results_are_the_json_of_the_command(job, monkeypatch):
    monkeypatch.chdir(ROOT)
    checked = detune.check(job)
    assert checked.to_dict() == json.loads(command("check", job, "--format", "json", "--fail-on", "never"))
    assert checked.verdict == checked["jobs"][0]["verdict"]
    assert len(checked.crossings()) == sum(
        len(operation.crossings) for operation in checked.jobs[0].operations
    )
    advised = detune.advise(job)
    assert advised.to_dict() == json.loads(command("advise", job, "--format", "json"))
    assert pickle.loads(pickle.dumps(checked)) == checked


def test_many_jobs_and_policies_are_those_of_the_command(monkeypatch):
    monkeypatch.chdir(ROOT)
    never = ["--fail-on", "never", "--format", "json"]
    policy = {"separation_percent": 3, "ignore_hz": [[49, 51]]}
    said = ["--policy", "separation_percent=3", "--policy", "ignore_hz=[[49, 51]]"]
    for jobs in ("jobs", "jobs/[cr]*.yaml"):
        checked = detune.check(jobs, policy=policy, samples="thin")
        assert checked.to_dict() == json.loads(command("check", jobs, *never, *said, "--samples", "thin"))
        assert len(checked.jobs) > 1
        advised = detune.advise_all(jobs, policy=policy)
        assert advised.to_dict() == json.loads(command("advise", jobs, "--format", "json", *said))
        assert type(advised.jobs[0]) is detune.Advice
    with pytest.raises(detune.DetuneError, match="no 'cutting'"):
        detune.advise("jobs/contour.yaml", objective="depth")
    with pytest.raises(detune.DetuneError, match="did you mean 'separation_percent'"):
        detune.check("jobs", policy={"separation_percnt": 3})
    with pytest.raises(detune.DetuneError, match="advise_all"):
        detune.advise("jobs")
    with pytest.raises(ValueError, match="samples is 'few'"):
        detune.check("jobs", samples="few")


@pytest.mark.parametrize("study", [detune.check, detune.advise_all])
def test_no_job_is_not_a_clear_one(study, tmp_path):
    with pytest.raises(detune.DetuneError, match="no job is given"):
        study()
    for nothing in (tmp_path, tmp_path / "*.yaml"):
        with pytest.raises(detune.DetuneError):
            study(nothing)


def test_type_checkers_know_the_keys_of_the_schemas():
    written = types_of_schemas.stubs(lambda name: command("schema", name))
    assert written == types_of_schemas.FILE.read_text(), "run tests/python/types_of_schemas.py"
    compile(written, "types.pyi", "exec")
    # What a stub says of an object is what an object has.
    keys = set(re.findall(r"def (\w+)\(self\)", written.split("class CheckCrossing(")[1].split("\nclass")[0]))
    crossings = detune.check(ROOT / "jobs/pocket.yaml").jobs[0].operations[0].crossings
    assert crossings and all(set(crossing) <= keys for crossing in crossings)


def test_a_diagnosis_names_its_causes(monkeypatch, tmp_path):
    monkeypatch.chdir(ROOT)
    robot = detune.Robot("robots/two-link")
    lines = pathlib.Path("robots/two-link/measured.csv").read_text().splitlines()
    header, *rows = [line for line in lines if line[0] != "#"]
    measured = tmp_path / "measured.csv"
    # Every other row: the module and the command agree or not, in less than half the time.
    measured.write_text("\n".join([header, *rows[::2]]) + "\n")
    found = detune.diagnose(robot, measured)
    assert found.to_dict() == json.loads(command("diagnose", "robots/two-link", measured, "--format", "json"))
    assert found.findings[0].cause
    assert "calibration:" in found.calibrated_yaml


def test_faults_are_exceptions_with_places(tmp_path):
    with pytest.raises(detune.DetuneError) as raised:
        detune.check(tmp_path / "none.yaml")
    assert raised.value.faults[0].code == "unreadable"
    job = tmp_path / "job.yaml"
    job.write_text("name: x\nrobbot: y\n")
    with pytest.raises(detune.DetuneError) as raised:
        detune.check(job)
    faults = raised.value.faults
    assert any(fault.code == "unknown_key" and fault.line == 2 for fault in faults), faults
    again = pickle.loads(pickle.dumps(raised.value))
    assert again.faults == faults
    with pytest.raises(ValueError, match="must have 2"):
        detune.Robot(TWO_LINK).frequencies(np.zeros((3, 5)))
    with pytest.raises(ValueError, match="objective"):
        detune.advise(job, objective="loudest")


def test_a_robot_is_pickled_by_its_file():
    robot = detune.Robot(TWO_LINK)
    again = pickle.loads(pickle.dumps(robot))
    assert type(again) is detune.Robot and again.name == robot.name
    assert (again.frequencies([0.0, 1.0]) == robot.frequencies([0.0, 1.0])).all()


def test_strided_and_single_precision_poses_are_taken():
    robot = detune.Robot(TWO_LINK)
    q = np.linspace(0, 1, 40).reshape(20, 2)
    assert (robot.frequencies(q[::2]) == robot.frequencies(q)[::2]).all()
    assert (robot.frequencies(np.asfortranarray(q)) == robot.frequencies(q)).all()
    assert np.allclose(robot.frequencies(q.astype(np.float32)), robot.frequencies(q), rtol=1e-5)


def test_the_interpreter_is_free_while_poses_are_solved():
    """Another thread of Python goes on while a long call runs."""
    robot = detune.Robot(SIX_AXES)
    q = np.random.default_rng(2).uniform(-1, 1, (400_000, len(robot.joint_names)))
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    other = threading.Thread(target=tick)
    other.start()
    begun = time.perf_counter()
    robot.frequencies(q, parallel=False)
    ended = time.perf_counter()
    done.set()
    other.join()
    inside = [t for t in ticks if begun < t < ended]
    assert len(inside) > 5, (len(inside), ended - begun)


def test_the_command_runs_in_the_process(capfd):
    assert detune.run(["check", str(ROOT / "jobs/contour.yaml"), "--fail-on", "never"]) == 0
    assert "RESONANCE" in capfd.readouterr().out.upper()
    assert detune.run(["check", "no-such-job.yaml"]) == 2
