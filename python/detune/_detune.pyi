from os import PathLike
from typing import Any, List, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

_Path = Union[str, PathLike[str]]

__version__: str

class Robot:
    def __new__(cls, file: _Path) -> "Robot": ...
    @property
    def name(self) -> str: ...
    @property
    def file(self) -> Any: ...
    @property
    def warnings(self) -> List[str]: ...
    @property
    def joint_names(self) -> List[str]: ...
    @property
    def coordinate_names(self) -> List[str]: ...
    def _frequencies(self, q: NDArray[np.float64], parallel: bool) -> NDArray[np.float64]: ...
    def _modes(
        self, q: NDArray[np.float64], parallel: bool
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def _tip_response(
        self,
        q: NDArray[np.float64],
        frequencies_hz: NDArray[np.float64],
        direction: Tuple[float, ...],
        tcp_m: Tuple[float, ...],
    ) -> NDArray[np.complex128]: ...

def job_files(jobs: Sequence[_Path]) -> List[Any]: ...
def check(jobs: Sequence[_Path], policy: Sequence[str], samples: str) -> str: ...
def advise(
    jobs: Sequence[_Path],
    is_list: bool,
    objective: str,
    feed: str,
    schedule: bool,
    policy: Sequence[str],
) -> str: ...
def identify(session: _Path) -> Tuple[str, str]: ...
def diagnose(robot: _Path, measured: _Path, seed: int) -> Tuple[str, str]: ...
def map(
    robot: _Path,
    axes: Sequence[Tuple[str, float, float, int]],
    at: Sequence[Tuple[str, float]],
    intervals: bool,
    shapes: bool,
) -> str: ...
def run(arguments: Sequence[str]) -> int: ...
