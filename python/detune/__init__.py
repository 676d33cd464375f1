"""detune: will a job shake the robot arm that runs it, where, and at which spindle speeds not.

>>> import detune
>>> robot = detune.Robot("robots/two-link")
>>> robot.frequencies([[0.0, 1.571]])
>>> detune.check("jobs/contour.yaml").verdict
"""

from __future__ import annotations

import json
import os
from typing import Any, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as _np

from . import _detune
from ._detune import __version__
from .errors import DetuneError, Fault
from .results import Advice, AdviceList, Check, Diagnosis, Identification, Map, Record

__all__ = [
    "Advice",
    "AdviceList",
    "Check",
    "DetuneError",
    "Diagnosis",
    "Fault",
    "Identification",
    "Map",
    "Record",
    "Robot",
    "__version__",
    "advise",
    "advise_all",
    "check",
    "diagnose",
    "identify",
    "map",
    "run",
]


def _rows(q: Any, joints: int) -> Tuple[_np.ndarray, bool]:
    """Poses with one row each, without a copy where they are float64 in C order already."""
    poses = _np.require(q, dtype=_np.float64, requirements=["C", "ALIGNED"])
    if poses.ndim == 1:
        return _np.ascontiguousarray(poses.reshape(1, -1)), True
    if poses.ndim != 2:
        raise ValueError(f"poses have {poses.ndim} dimensions, must have 2: one row a pose")
    return poses, False


class Robot(_detune.Robot):
    """A robot.yaml (or the folder that holds one) over arrays of poses.

    Poses are arrays with one row each and one column per moving joint, base to tip, rad or m; one
    pose may be a plain sequence, and the result then has no axis for poses. ``parallel=False``
    keeps to the calling thread. The interpreter's lock is released while anything is computed.
    """

    __slots__ = ()

    def frequencies(self, q: Any, *, parallel: bool = True) -> _np.ndarray:
        """Natural frequencies, Hz, ascending: poses × modes."""
        poses, is_one = _rows(q, len(self.joint_names))
        found = self._frequencies(poses, parallel)
        return found[0] if is_one else found

    def modes(
        self, q: Any, *, parallel: bool = True
    ) -> Tuple[_np.ndarray, _np.ndarray, _np.ndarray]:
        """Natural frequencies (poses × modes, Hz), mass-normalised shapes (poses × modes ×
        coordinates) and damping ratios (poses × modes)."""
        poses, is_one = _rows(q, len(self.joint_names))
        found = self._modes(poses, parallel)
        return tuple(array[0] for array in found) if is_one else found

    def shapes(self, q: Any, *, parallel: bool = True) -> _np.ndarray:
        """Mass-normalised mode shapes: poses × modes × coordinates."""
        return self.modes(q, parallel=parallel)[1]

    def tip_response(
        self,
        q: Any,
        frequencies_hz: Sequence[float],
        *,
        direction: Sequence[float] = (0.0, 0.0, 1.0),
        tcp_m: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> _np.ndarray:
        """Receptance at a point of the tip frame along a direction of the base frame, m/N, complex:
        poses × frequencies."""
        poses, is_one = _rows(q, len(self.joint_names))
        hz = _np.atleast_1d(_np.asarray(frequencies_hz, dtype=_np.float64))
        found = self._tip_response(poses, hz, tuple(direction), tuple(tcp_m))
        return found[0] if is_one else found

    def __repr__(self) -> str:
        return f"detune.Robot({str(self.file)!r})"


PathLike = Union[str, "os.PathLike[str]"]
#: Keys of a job's policy, which win over the job and detune.toml.
Policy = Optional[Mapping[str, Any]]


def _path(robot: Union[Robot, PathLike]) -> Any:
    return robot.file if isinstance(robot, _detune.Robot) else robot


def _entries(policy: Policy) -> List[str]:
    """KEY=VALUE as the command line has them. JSON is YAML."""
    return [f"{key}={json.dumps(value)}" for key, value in (policy or {}).items()]


def check(*jobs: PathLike, policy: Policy = None, samples: str = "all") -> Check:
    """Checks jobs: files, folders (the jobs in and below them), patterns such as
    ``"jobs/**/*.yaml"``. ``samples`` is none, thin or all: the poses that the result lists. Raises
    :class:`DetuneError` with every fault if one cannot be checked, or if there is none."""
    return Check(json.loads(_detune.check(list(jobs), _entries(policy), samples)))


def advise(
    job: PathLike,
    *,
    objective: str = "nearest",
    feed: str = "chip-load",
    schedule: bool = False,
    policy: Policy = None,
) -> Advice:
    """Safe spindle speeds of a job. ``objective`` is nearest, margin, highest, vibration or depth;
    ``feed`` is chip-load or programmed."""
    found = _detune.advise([job], False, objective, feed, schedule, _entries(policy))
    return Advice(json.loads(found))


def advise_all(
    *jobs: PathLike,
    objective: str = "nearest",
    feed: str = "chip-load",
    schedule: bool = False,
    policy: Policy = None,
) -> AdviceList:
    """:func:`advise` on files, folders and patterns, as :func:`check` takes them."""
    found = _detune.advise(list(jobs), True, objective, feed, schedule, _entries(policy))
    return AdviceList(json.loads(found))


def identify(session: PathLike) -> Identification:
    """Natural frequencies, damping and shapes from a session of vibration records."""
    found, table = _detune.identify(session)
    return Identification(json.loads(found), table)


def diagnose(robot: Union[Robot, PathLike], measured: PathLike, *, seed: int = 1) -> Diagnosis:
    """What the model of a robot gets wrong against a table of measured modes, and why."""
    found, calibrated = _detune.diagnose(_path(robot), measured, seed)
    return Diagnosis(json.loads(found), calibrated)


def map(  # noqa: A001
    robot: Union[Robot, PathLike],
    grid: Mapping[str, Tuple[float, float, int]],
    *,
    at: Optional[Mapping[str, float]] = None,
    intervals: bool = False,
    shapes: bool = False,
) -> Map:
    """Natural frequencies over a grid: joint name → (from, to, steps), degrees (mm for a sliding
    joint); the last joint runs fastest; joints in ``at`` stay there, others at zero. For poses of
    an array use :meth:`Robot.frequencies`."""
    axes = [(name, float(a), float(b), int(steps)) for name, (a, b, steps) in grid.items()]
    fixed = [(name, float(value)) for name, value in (at or {}).items()]
    return Map(json.loads(_detune.map(_path(robot), axes, fixed, intervals, shapes)))


def run(arguments: Iterable[str]) -> int:
    """Runs the command ``detune`` in this process; its exit code."""
    return _detune.run(["detune", *arguments])
