"""Many jobs, poses or placements on many machines, by Dask: ``pip install 'detune[fleet]'``.

Every function takes a ``client`` (``dask.distributed.Client`` of a LocalCluster, of SLURM, of
Kubernetes); without one it runs here. The result is the same, byte for byte, however many workers
there are and whichever of them is lost on the way. Workers must see the same files by the same names.

>>> from dask.distributed import Client
>>> from detune import fleet
>>> with Client(n_workers=8) as client:
...     fleet.check(jobs, client=client).verdict
"""

from __future__ import annotations

import copy
import json
import os
import pathlib
import re
import tempfile
from typing import Any, Callable, Dict, Iterable, List, Sequence, Tuple

import numpy as np

import detune

__all__ = ["advise", "check", "frequencies", "placements"]

#: From the best to the worst.
VERDICTS = ("clear", "uncertain", "unchecked", "resonance")

#: Poses of a task: half a second of work and more, so that sending them costs little.
POSES = 500_000


def _spread(client: Any, work: Callable, items: Sequence[Any]) -> List[Any]:
    """The results of all items in their order."""
    if client is None:
        return [work(item) for item in items]
    # A task without side effects may run twice.
    return client.gather(client.map(work, items, pure=False, retries=2))


def _absolute(path: Any) -> str:
    return str(pathlib.Path(path).resolve())


def _here(folder: str) -> None:
    """Relative names mean what they mean to the caller."""
    if os.getcwd() != folder:
        os.chdir(folder)


def _checked(task: Tuple[str, str]) -> Dict[str, Any]:
    folder, job = task
    _here(folder)
    return detune.check(job).to_dict()


def check(jobs: Iterable[Any], client: Any = None) -> detune.Check:
    """:func:`detune.check` of all jobs, one task a job."""
    parts = _spread(client, _checked, [(os.getcwd(), str(job)) for job in jobs])
    merged = [entry for part in parts for entry in part["jobs"]]
    worst = max((part["verdict"] for part in parts), key=VERDICTS.index, default="clear")
    return detune.Check({**(parts[0] if parts else {"schema": "check/1"}), "verdict": worst, "jobs": merged})


def _advised(task: Tuple[str, str, Dict[str, Any]]) -> Dict[str, Any]:
    folder, job, options = task
    _here(folder)
    return detune.advise(job, **options).to_dict()


def advise(jobs: Iterable[Any], client: Any = None, **options: Any) -> List[detune.Advice]:
    """:func:`detune.advise` of each job, one task a job."""
    tasks = [(os.getcwd(), str(job), options) for job in jobs]
    return [detune.Advice(found) for found in _spread(client, _advised, tasks)]


def _solved(task: Tuple[str, np.ndarray]) -> np.ndarray:
    robot, poses = task
    return detune.Robot(robot).frequencies(poses, parallel=False)


def frequencies(robot: Any, poses: Any, client: Any = None, chunk: int = POSES) -> np.ndarray:
    """Natural frequencies, Hz: poses × modes. ``chunk`` poses are a task."""
    file = _absolute(robot.file if isinstance(robot, detune.Robot) else robot)
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    if len(poses) == 0:
        return detune.Robot(file).frequencies(poses)
    tasks = [(file, poses[start : start + chunk]) for start in range(0, len(poses), chunk)]
    return np.concatenate(_spread(client, _solved, tasks))


def placements(
    job: Any,
    offsets_mm: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0),),
    turns_deg: Sequence[float] = (0.0,),
    client: Any = None,
    objective: str = "margin",
) -> List[Dict[str, Any]]:
    """Where to put the fixture, and how to turn a tool of rotational symmetry about its axis: advice
    on the job with its work object moved by each offset (base frame) and its tool centre point
    turned by each angle about its own z. One row each, the widest clear band first:

    ``offset_mm``, ``turn_deg``, ``clear_rpm`` (the width of the widest band of safe speeds, of the
    operation for which that is least), ``recommended_rpm`` and ``separation_percent`` by operation;
    a placement that the arm cannot run has ``faults`` instead and comes last. Operations in joint
    angles, and programs with work objects of their own, cannot be moved: a ``ValueError``.
    """
    job = pathlib.Path(job).resolve()
    _refuse_what_stays(job)
    tasks = [
        (str(job), tuple(map(float, offset)), float(turn), objective)
        for offset in offsets_mm
        for turn in turns_deg
    ]
    rows = _spread(client, _placed, tasks)
    return sorted(rows, key=lambda row: -row.get("clear_rpm", -1.0))


def _refuse_what_stays(job: pathlib.Path) -> None:
    """A millimetre must move the joints of every operation."""
    here = detune.check(job).to_dict()
    with tempfile.TemporaryDirectory() as folder:
        moved = pathlib.Path(folder, "job.yaml")
        moved.write_text(json.dumps(_moved(job, (1.0, 1.0, 1.0), 0.0)))
        try:
            there = detune.check(moved).to_dict()
        except detune.DetuneError:
            # At the edge of the reach; something moved.
            return
    for a, b in zip(here["jobs"][0]["operations"], there["jobs"][0]["operations"]):
        if a["samples"][0]["joints_rad"] == b["samples"][0]["joints_rad"]:
            raise ValueError(
                f"operation '{a['name']}' does not move with the job's work_object: its path is in "
                "joint angles, or its program states its own work object"
            )


def _placed(task: Tuple[str, Tuple[float, ...], float, str]) -> Dict[str, Any]:
    name, offset_mm, turn_deg, objective = task
    row: Dict[str, Any] = {"offset_mm": list(offset_mm), "turn_deg": turn_deg}
    with tempfile.TemporaryDirectory() as folder:
        moved = pathlib.Path(folder, "job.yaml")
        moved.write_text(json.dumps(_moved(pathlib.Path(name), offset_mm, turn_deg)))
        try:
            operations = detune.advise(moved, objective=objective).to_dict()["operations"]
        except detune.DetuneError as error:
            # Places in the moved job mean nothing to the reader.
            place = re.compile(re.escape(str(moved)) + r"(:\d+)?: ")
            row["faults"] = [place.sub("", fault.message) for fault in error.faults]
            return row
    widths = [max((b - a for a, b in one["safe_speeds_rpm"]), default=0.0) for one in operations]
    row["clear_rpm"] = min(widths, default=0.0)
    for key in ("recommended_rpm", "separation_percent"):
        row[key] = [one[key] for one in operations]
    return row


def _moved(job: pathlib.Path, offset_mm: Sequence[float], turn_deg: float) -> Dict[str, Any]:
    """The job, its files by absolute names, moved and turned. JSON is YAML."""
    import yaml  # comes with Dask

    moved = copy.deepcopy(yaml.safe_load(job.read_text()))

    def named(holder: Any, key: str) -> None:
        if isinstance(holder, dict) and isinstance(holder.get(key), str):
            holder[key] = str((job.parent / holder[key]).resolve())

    named(moved, "robot")
    for operation in moved.get("operations") or []:
        program = (operation.get("path") or {}).get("program")
        named(program, "file")
        if isinstance(program, dict) and isinstance(program.get("files"), list):
            program["files"] = [str((job.parent / file).resolve()) for file in program["files"]]
    work_object = moved.setdefault("work_object", {})
    at = work_object.get("xyz_m") or [0.0, 0.0, 0.0]
    work_object["xyz_m"] = [a + 1e-3 * b for a, b in zip(at, offset_mm)]
    if turn_deg != 0.0:
        tcp = moved.setdefault("tcp", {})
        turned = _matrix(tcp.get("rpy_rad") or [0.0, 0.0, 0.0]) @ _about_z(np.radians(turn_deg))
        tcp["rpy_rad"] = _rpy(turned)
    return moved


def _about_z(angle: float) -> np.ndarray:
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _matrix(rpy: Sequence[float]) -> np.ndarray:
    """Turns about the fixed axes x, y, z in turn, as URDF has them."""
    (sr, cr), (sp, cp) = ((np.sin(angle), np.cos(angle)) for angle in rpy[:2])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    return _about_z(rpy[2]) @ about_y @ about_x


def _rpy(matrix: np.ndarray) -> List[float]:
    pitch = np.arctan2(-matrix[2, 0], np.hypot(matrix[0, 0], matrix[1, 0]))
    if np.hypot(matrix[0, 0], matrix[1, 0]) < 1e-9:
        # Roll and yaw turn about one axis.
        return [0.0, float(pitch), float(np.arctan2(-matrix[0, 1], matrix[1, 1]))]
    roll, yaw = np.arctan2(matrix[2, 1], matrix[2, 2]), np.arctan2(matrix[1, 0], matrix[0, 0])
    return [float(roll), float(pitch), float(yaw)]
