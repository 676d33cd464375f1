"""Many jobs, poses, placements or draws on many machines, by Dask: ``pip install 'detune[fleet]'``.

Every function takes a ``client`` (``dask.distributed.Client`` of a LocalCluster, of SLURM, of
Kubernetes); without one it runs here. The result is the same, byte for byte, however many workers
there are and whichever of them is lost on the way. Workers must see the same files by the same names.

>>> from dask.distributed import Client
>>> from detune import fleet
>>> with Client(n_workers=8) as client:
...     fleet.check(["jobs"], client=client).verdict
"""

from __future__ import annotations

import copy
import functools
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import numpy as np

import detune
from detune import _detune

__all__ = [
    "advise",
    "check",
    "frequencies",
    "monte_carlo",
    "placements",
    "statistics",
    "sweep",
]

#: From the best to the worst.
VERDICTS = ("clear", "uncertain", "unchecked", "resonance")

#: Poses of a task: half a second of work and more, so that sending them costs little.
POSES = 500_000

Vector = Sequence[float]
Row = Dict[str, Any]


def _spread(client: Any, work: Callable[[Any], Any], items: Sequence[Any]) -> List[Any]:
    """The results of all items in their order."""
    if client is None:
        return [work(item) for item in items]
    # A task without side effects may run twice.
    task = functools.partial(_task, work)
    return client.gather(client.map(task, items, pure=False, retries=2))


def _task(work: Callable[[Any], Any], item: Any) -> Any:
    # The cluster decides how many tasks a machine runs at once: one thread each. What a worker has
    # begun with stays.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    return work(item)


def _absolute(path: Any) -> str:
    """Names in a file are relative to where it is named, also where that is a link."""
    path = pathlib.Path(path)
    return str(path.parent.resolve() / path.name)


def _files(jobs: Iterable[Any]) -> List[str]:
    """Files, folders and patterns as job files."""
    return [str(job) for job in _detune.job_files([str(job) for job in jobs])]


def _here(folder: str) -> None:
    """Relative names mean what they mean to the caller."""
    if os.getcwd() != folder:
        os.chdir(folder)


def _checked(task: Tuple[str, str, Dict[str, Any]]) -> Dict[str, Any]:
    folder, job, options = task
    _here(folder)
    return detune.check(job, **options).to_dict()


def check(jobs: Iterable[Any], client: Any = None, **options: Any) -> detune.Check:
    """:func:`detune.check` of all jobs (files, folders, patterns), one task a job."""
    tasks = [(os.getcwd(), job, options) for job in _files(jobs)]
    parts = _spread(client, _checked, tasks)
    worst = max((part["verdict"] for part in parts), key=VERDICTS.index)
    merged = [entry for part in parts for entry in part["jobs"]]
    return detune.Check({**parts[0], "verdict": worst, "jobs": merged})


def _advised(task: Tuple[str, str, Dict[str, Any]]) -> Dict[str, Any]:
    folder, job, options = task
    _here(folder)
    return detune.advise(job, **options).to_dict()


def advise(jobs: Iterable[Any], client: Any = None, **options: Any) -> List[detune.Advice]:
    """:func:`detune.advise` of each job (files, folders, patterns), one task a job."""
    tasks = [(os.getcwd(), job, options) for job in _files(jobs)]
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


def _command(*arguments: str) -> bytes:
    """Standard output of the command. Its errors are those of a file or of the arguments."""
    found = subprocess.run([sys.executable, "-m", "detune", *arguments], capture_output=True)
    if found.returncode != 0:
        raise ValueError(found.stderr.decode(errors="replace").strip())
    return found.stdout


def _sketched(task: Tuple[List[str], str]) -> bytes:
    arguments, part = task
    return _command("map", *arguments, "--part", part, "--format", "sketch")


def statistics(
    robot: Any,
    poses: int,
    *,
    seed: int = 1,
    reduce: str = "min,max,mean,quantiles",
    parts: int = 64,
    client: Any = None,
) -> Dict[str, Any]:
    """``detune map --random POSES --reduce …`` in parts, one task a part: the JSON of the undivided
    command. No pose is kept, so that their number only costs time."""
    file = _absolute(robot.file if isinstance(robot, detune.Robot) else robot)
    arguments = [file, "--random", str(poses), "--seed", str(seed), "--reduce", reduce]
    tasks = [(arguments, f"{part}/{parts}") for part in range(1, parts + 1)]
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for part, sketch in enumerate(_spread(client, _sketched, tasks)):
            names.append(os.path.join(folder, f"{part}.json"))
            pathlib.Path(names[-1]).write_bytes(sketch)
        return json.loads(_command("merge", *names, "--format", "json"))


def placements(
    job: Any,
    offsets_mm: Sequence[Vector] = ((0.0, 0.0, 0.0),),
    turns_deg: Vector = (0.0,),
    client: Any = None,
    objective: str = "margin",
    starts_deg: Sequence[Optional[Vector]] = (None,),
    policy: Optional[Mapping[str, Any]] = None,
) -> List[Row]:
    """Where to put the fixture, how to turn a tool of rotational symmetry about its axis, and in
    which posture to start: advice on the job with its work object moved by each offset (base frame),
    its tool centre point turned by each angle about its own z, and its paths of poses begun near
    each of the joint positions (``None``: as the job says). One row each, the widest clear band
    first:

    ``offset_mm``, ``turn_deg``, ``start_near_deg``, ``clear_rpm`` (the width of the widest band of
    safe speeds, of the operation for which that is least), ``recommended_rpm`` and
    ``separation_percent`` by operation; a placement that the arm cannot run has ``faults`` instead
    and comes last. Operations in joint angles, and programs with work objects or tools of their own,
    cannot be moved: a ``ValueError``.
    """
    base = _base(job, policy)
    _refuse_what_stays(base, offsets_mm, turns_deg, starts_deg)
    options = {"objective": objective, "policy": dict(policy or {})}
    tasks = [
        (_moved(base, offset, turn, start), _placement(offset, turn, start), options)
        for offset in offsets_mm
        for turn in turns_deg
        for start in starts_deg
    ]
    rows = _spread(client, _placed, tasks)
    return sorted(rows, key=lambda row: -row.get("clear_rpm", -1.0))


def _placement(offset_mm: Vector, turn_deg: float, start_deg: Optional[Vector]) -> Row:
    start = None if start_deg is None else [float(one) for one in start_deg]
    offset = [float(one) for one in offset_mm]
    return {"offset_mm": offset, "turn_deg": float(turn_deg), "start_near_deg": start}


def _placed(task: Tuple[Dict[str, Any], Row, Dict[str, Any]]) -> Row:
    job, row, options = task
    found = _with_files(job, lambda file: detune.advise(file, **options).to_dict())
    if isinstance(found, list):
        return {**row, "faults": found}
    operations = found["operations"]
    widths = [max((b - a for a, b in one["safe_speeds_rpm"]), default=0.0) for one in operations]
    row = {**row, "clear_rpm": min(widths, default=0.0)}
    for key in ("recommended_rpm", "separation_percent"):
        row[key] = [one[key] for one in operations]
    return row


def sweep(
    jobs: Iterable[Any],
    robots: Sequence[Any] = (None,),
    speeds_rpm: Sequence[Optional[float]] = (None,),
    offsets_mm: Sequence[Vector] = ((0.0, 0.0, 0.0),),
    turns_deg: Vector = (0.0,),
    starts_deg: Sequence[Optional[Vector]] = (None,),
    client: Any = None,
    policy: Optional[Mapping[str, Any]] = None,
) -> List[Row]:
    """Verdicts on jobs × robots × speeds × placements, one task and one row each, in that order:
    ``None`` is the job's own robot or speed; placements are those of :func:`placements`. The feed
    stays as it is.

    A row holds ``job``, ``robot``, ``spindle_rpm``, ``offset_mm``, ``turn_deg``, ``start_near_deg``,
    ``verdict``, ``probability``, and lists with one entry an operation: ``verdicts``,
    ``probabilities`` and ``closest_percent``, how far the closest line stays from a mode; or
    ``faults`` where the job cannot be run so.
    """
    tasks: List[Tuple[Dict[str, Any], Row, Dict[str, Any]]] = []
    options = {"policy": dict(policy or {}), "samples": "none"}
    for job in _files(jobs):
        base = _base(job, policy)
        _refuse_what_stays(base, offsets_mm, turns_deg, starts_deg)
        axes = (robots, speeds_rpm, offsets_mm, turns_deg, starts_deg)
        for robot, rpm, offset, turn, start in itertools.product(*axes):
            moved = _moved(base, offset, turn, start)
            if robot is not None:
                robot = str(robot.file if isinstance(robot, detune.Robot) else robot)
                moved["robot"] = _absolute(robot)
            if rpm is not None:
                _run_at(moved, float(rpm))
            row = {"job": job, "robot": robot, "spindle_rpm": rpm, **_placement(offset, turn, start)}
            tasks.append((moved, row, options))
    return _spread(client, _judged, tasks)


def _judged(task: Tuple[Dict[str, Any], Row, Dict[str, Any]]) -> Row:
    job, row, options = task
    found = _with_files(job, lambda file: detune.check(file, **options).to_dict()["jobs"][0])
    if isinstance(found, list):
        return {**row, "faults": found}
    operations = found["operations"]
    closest = [one["closest"] and one["closest"]["separation_percent"] for one in operations]
    return {
        **row,
        "verdict": found["verdict"],
        "probability": found["probability"],
        "verdicts": [one["verdict"] for one in operations],
        "probabilities": [one["probability"] for one in operations],
        "closest_percent": closest,
    }


def monte_carlo(
    job: Any,
    draws: int,
    *,
    seed: int = 1,
    std_percent: float = 10.0,
    client: Any = None,
    policy: Optional[Mapping[str, Any]] = None,
) -> List[Row]:
    """The verdicts on a job with the springs of its robot drawn anew: each is its own times a
    log-normal factor with the ``std_percent`` of the robot file, else with the one given here. One
    task and one row a draw: ``draw``, ``factors`` by spring, and for each operation whether a line
    lies in a band (``rings``) beside what :func:`sweep` has. Draws depend on ``seed`` and their
    number alone. A robot whose calibration says how its springs go together is a ``ValueError``:
    ``check`` states its probability.
    """
    base = _base(job, policy)
    robot = pathlib.Path(base["robot"])
    robot = robot / "robot.yaml" if robot.is_dir() else robot
    described = _read(robot)
    if (described.get("calibration") or {}).get("posterior"):
        raise ValueError(f"{robot}: the springs were calibrated together; check states the probability")
    described["urdf"] = _absolute(robot.parent / described["urdf"])
    options = {"policy": dict(policy or {}), "samples": "none"}
    tasks = []
    for draw in range(draws):
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(draw,)))
        drawn, factors = _drawn(described, std_percent, rng)
        tasks.append((base, drawn, {"draw": draw, "factors": factors}, options))
    return _spread(client, _drawn_and_judged, tasks)


def _drawn(
    robot: Dict[str, Any], std_percent: float, rng: np.random.Generator
) -> Tuple[Dict[str, Any], Dict[str, float]]:
    robot = copy.deepcopy(robot)
    elasticity = robot["elasticity"]
    springs = dict(elasticity.get("joints") or {})
    springs.update({one["name"]: one for one in elasticity.get("extra") or []})
    factors = {}
    for name, spring in springs.items():
        own = spring.get("std_percent")
        std = std_percent if own is None else own
        factors[name] = float(np.exp(0.01 * std * rng.normal()))
        for key in ("stiffness_nm_per_rad", "stiffness_n_per_m"):
            if spring.get(key) is not None:
                spring[key] *= factors[name]
    return robot, factors


def _drawn_and_judged(task: Tuple[Dict[str, Any], Dict[str, Any], Row, Dict[str, Any]]) -> Row:
    job, robot, row, options = task
    check = functools.partial(detune.check, **options)
    found = _with_files(job, lambda file: check(file).to_dict()["jobs"][0], robot)
    if isinstance(found, list):
        return {**row, "faults": found}
    operations = found["operations"]
    certain = [{one["certainty"] for one in operation["crossings"]} for operation in operations]
    return {
        **row,
        "verdict": found["verdict"],
        "verdicts": [one["verdict"] for one in operations],
        "rings": ["certain" in one for one in certain],
    }


def _with_files(
    job: Dict[str, Any],
    work: Callable[[pathlib.Path], Any],
    robot: Optional[Dict[str, Any]] = None,
) -> Any:
    """What is found of a job in a file of its own, also with another robot; or the messages of its
    faults."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "job.yaml")
        if robot is not None:
            file.with_name("robot.yaml").write_text(json.dumps(robot))
            job = {**job, "robot": "robot.yaml"}
        file.write_text(json.dumps(job))
        try:
            return work(file)
        except detune.DetuneError as error:
            # Places in a file that is gone mean nothing to the reader.
            place = re.compile(re.escape(folder + os.sep) + r"(job|robot)\.yaml(:\d+)?: ")
            return [place.sub("", fault.message) for fault in error.faults]


def _refuse_what_stays(
    base: Dict[str, Any],
    offsets_mm: Sequence[Vector],
    turns_deg: Vector,
    starts_deg: Sequence[Optional[Vector]],
) -> None:
    """A millimetre, and a degree, must move the joints of every operation."""
    for operation in base["operations"]:
        is_begun = any(start is not None for start in starts_deg)
        if is_begun and "joints_deg" in operation["path"]:
            name = operation["name"]
            raise ValueError(f"operation '{name}' has a path in joint angles, which has no posture")
    moves = []
    if any(any(offset) for offset in offsets_mm):
        moves.append(("work_object", "work object", _moved(base, (1.0, 1.0, 1.0), 0.0, None)))
    if any(turns_deg):
        moves.append(("tcp", "tool", _moved(base, (0.0, 0.0, 0.0), 1.0, None)))
    here = _starts(base) if moves else []
    if moves and not here:
        raise ValueError("the job cannot be run alone, so nobody can tell whether it moves")
    for key, own, moved in moves:
        # At the edge of the reach there is none, but something moved.
        for (name, a), (_, b) in zip(here, _starts(moved)):
            if a == b:
                raise ValueError(
                    f"operation '{name}' does not move with the job's {key}: its path is in joint "
                    f"angles, or its program states its own {own}"
                )


def _starts(job: Dict[str, Any]) -> List[Tuple[str, List[float]]]:
    """Where each operation begins; nothing if one cannot be run."""
    # What the cut does takes long, and moves no joint.
    job = {key: value for key, value in job.items() if key not in ("policy", "accept")}
    job["operations"] = [
        {key: value for key, value in operation.items() if key != "cutting"}
        for operation in job["operations"]
    ]
    found = _with_files(job, lambda file: detune.check(file, samples="thin").to_dict()["jobs"][0])
    if isinstance(found, list):
        return []
    return [(one["name"], one["samples"][0]["joints_rad"]) for one in found["operations"]]


def _base(job: Any, policy: Optional[Mapping[str, Any]] = None) -> Dict[str, Any]:
    """A job that holds what its detune.toml gives, with files by absolute names. It must be one that
    can be run as it stands."""
    detune.check(job, samples="none", policy=policy)
    file = pathlib.Path(_absolute(job))
    base = _read(file)

    def named(holder: Any, key: str) -> None:
        if isinstance(holder, dict) and isinstance(holder.get(key), str):
            holder[key] = _absolute(file.parent / holder[key])

    named(base, "robot")
    for operation in base.get("operations") or []:
        program = (operation.get("path") or {}).get("program")
        named(program, "file")
        if isinstance(program, dict) and isinstance(program.get("files"), list):
            program["files"] = [_absolute(file.parent / name) for name in program["files"]]
    _add_settings(base, file)
    return base


def _add_settings(base: Dict[str, Any], job: pathlib.Path) -> None:
    """The nearest detune.toml, up to the root of the repository, as the page on settings says."""
    for folder in job.parents:
        settings = folder / "detune.toml"
        if os.path.lexists(settings):
            break
        if any((folder / root).exists() for root in (".git", ".hg")):
            return
    else:
        return
    try:
        import tomllib
    except ImportError:
        raise ValueError(f"{settings}: to read it takes Python 3.11 or later") from None
    shared = json.loads(json.dumps(tomllib.loads(settings.read_text("utf-8-sig")), default=str))
    if "robot" in shared:
        base["robot"] = base.get("robot") or _absolute(folder / shared["robot"])
    own = {key: value for key, value in (base.get("policy") or {}).items() if value is not None}
    base["policy"] = {**shared.get("policy", {}), **own}
    for entry in shared.get("accept", []):
        at = entry.pop("job", None)
        if at is None or _absolute(folder / at) == str(job):
            base["accept"] = [*(base.get("accept") or []), entry]


def _read(file: pathlib.Path) -> Dict[str, Any]:
    """A file of YAML 1.2, where 1e6 is a number and a date is text. JSON is YAML."""
    import yaml  # comes with Dask

    class Loader(yaml.SafeLoader):
        yaml_implicit_resolvers: Dict[str, Any] = {}

    for tag, pattern, first in (
        ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
        ("null", r"~|null|Null|NULL|", "~nN"),
        ("int", r"[-+]?(0|[1-9][0-9]*)", "-+0123456789"),
        ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
    ):
        whole = re.compile(f"^(?:{pattern})$")
        Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", whole, [*first, ""])
    read = yaml.load(file.read_text("utf-8-sig"), Loader)
    if not isinstance(read, dict):
        raise ValueError(f"{file}: holds no keys")
    return read


def _run_at(job: Dict[str, Any], rpm: float) -> None:
    if job.get("speeds_from") == "program":
        raise ValueError("speeds_from: program, so that no speed of a sweep would count")
    for operation in job["operations"]:
        operation.pop("spindle_schedule", None)
        operation["spindle_rpm"] = rpm


def _moved(
    base: Dict[str, Any], offset_mm: Vector, turn_deg: float, start_deg: Optional[Vector]
) -> Dict[str, Any]:
    """The job moved, turned, and begun in another posture."""
    moved = copy.deepcopy(base)
    if any(offset_mm):
        work_object = moved["work_object"] = moved.get("work_object") or {}
        at = work_object.get("xyz_m") or [0.0, 0.0, 0.0]
        work_object["xyz_m"] = [a + 1e-3 * float(b) for a, b in zip(at, offset_mm)]
    if turn_deg != 0.0:
        tcp = moved["tcp"] = moved.get("tcp") or {}
        turned = _matrix(tcp.get("rpy_rad") or [0.0, 0.0, 0.0]) @ _about_z(np.radians(turn_deg))
        tcp["rpy_rad"] = _rpy(turned)
    if start_deg is not None:
        for operation in moved["operations"]:
            operation["start_near_deg"] = [float(one) for one in start_deg]
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
