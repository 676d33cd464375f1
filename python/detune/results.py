"""Results as objects: attributes are the keys of the command's JSON, ``to_dict()`` gives it back.

Type checkers know the keys by ``types.pyi``, which follows the command's schemas.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Tuple

__all__ = ["Advice", "AdviceList", "Check", "Diagnosis", "Identification", "Map", "Record"]


class Record:
    """One object of the JSON: ``record.key``, ``record["key"]``, ``to_dict()``."""

    __slots__ = ("_data",)
    _data: Dict[str, Any]

    def __init__(self, data: Dict[str, Any]):
        object.__setattr__(self, "_data", data)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name.startswith("__"):
                raise AttributeError(name)
            try:
                return _wrapped(self._data[name])
            except KeyError:
                has = f"it has {', '.join(self._data)}"
                raise AttributeError(f"{type(self).__name__} has no '{name}'; {has}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("results are read-only")

    def __getitem__(self, name: str) -> Any:
        return _wrapped(self._data[name])

    def __contains__(self, name: str) -> bool:
        return name in self._data

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __dir__(self) -> List[str]:
        return sorted([*self._data, *super().__dir__()])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._data == other._data

    def __hash__(self) -> int:
        return hash(json.dumps(self._data, sort_keys=True))

    def __reduce__(self) -> Tuple[Any, ...]:
        return (type(self), (self._data,))

    def __repr__(self) -> str:
        shown = ", ".join(f"{key}={_short(value)}" for key, value in self._data.items())
        return f"{type(self).__name__}({shown})"

    def to_dict(self) -> Dict[str, Any]:
        """The JSON that the command prints."""
        return self._data


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [Record(item) for item in value]
    return value


def _short(value: Any) -> str:
    if isinstance(value, (dict, list)):
        return f"<{len(value)}>"
    return repr(value)


if TYPE_CHECKING:
    from .types import AdviceKeys, CheckKeys, DiagnosisKeys, IdentificationKeys
else:
    AdviceKeys = CheckKeys = DiagnosisKeys = IdentificationKeys = Record


class Check(CheckKeys):
    """``check/1``: the verdict on jobs."""

    __slots__ = ()

    def crossings(self) -> List[Dict[str, Any]]:
        """All crossings as flat rows, for ``pandas.DataFrame``."""
        return [
            {"job": job["job"], "operation": operation["name"], **crossing}
            for job in self._data["jobs"]
            for operation in job["operations"]
            for crossing in operation["crossings"]
        ]

    def samples(self) -> List[Dict[str, Any]]:
        """The samples along all paths as flat rows, one column a mode, for ``pandas.DataFrame``."""
        rows = []
        for job in self._data["jobs"]:
            for operation in job["operations"]:
                for sample in operation.get("samples") or []:
                    row = {"job": job["job"], "operation": operation["name"], "s": sample["s"]}
                    if "beta2_rad" in sample:
                        row["beta2_rad"] = sample["beta2_rad"]
                    for mode, hz in enumerate(sample["natural_frequencies_hz"], 1):
                        row[f"f{mode}_hz"] = hz
                    rows.append(row)
        return rows


class Advice(AdviceKeys):
    """``advice/1``: safe spindle speeds, operation by operation."""

    __slots__ = ()


class AdviceList(Record):
    """``advice-list/1``: advice on several jobs, in ``jobs``."""

    __slots__ = ()

    @property
    def jobs(self) -> List[Advice]:
        """One advice a job, in the order given."""
        return [Advice(job) for job in self._data["jobs"]]


class Identification(IdentificationKeys):
    """Modes of a session's records."""

    __slots__ = ("_table",)
    _table: str

    def __init__(self, data: Dict[str, Any], table: str = ""):
        super().__init__(data)
        object.__setattr__(self, "_table", table)

    def __reduce__(self) -> Tuple[Any, ...]:
        return (type(self), (self._data, self._table))

    @property
    def measured_csv(self) -> str:
        """The table of modes that :func:`detune.diagnose` reads."""
        return self._table


class Diagnosis(DiagnosisKeys):
    """``diagnosis/1``: what the model gets wrong, and why."""

    __slots__ = ("_robot",)
    _robot: str

    def __init__(self, data: Dict[str, Any], robot: str = ""):
        super().__init__(data)
        object.__setattr__(self, "_robot", robot)

    def __reduce__(self) -> Tuple[Any, ...]:
        return (type(self), (self._data, self._robot))

    @property
    def calibrated_yaml(self) -> str:
        """The robot's file with the findings as corrections, to be kept beside the robot's file."""
        return self._robot


class Map(Record):
    """``map/1``: natural frequencies over poses."""

    __slots__ = ()

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    @property
    def poses(self) -> Any:
        """Joint positions, rad or m: one row a pose (numpy)."""
        return self._column("joints")

    @property
    def frequencies_hz(self) -> Any:
        """Natural frequencies: one row a pose, one column a mode (numpy)."""
        return self._column("natural_frequencies_hz")

    def _column(self, name: str) -> Any:
        import numpy

        return numpy.array([row[name] for row in self._data["rows"]], dtype=float)
