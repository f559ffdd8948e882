"""The engine: arrays in, arrays out. What is meant to be used is :mod:`kinetostat`."""

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Error",
    "Machine",
    "Process",
    "Program",
    "__version__",
    "as_toml",
    "compute_part",
    "machine_names",
    "merge_parts",
    "part_head",
    "predict_by_machine",
    "predict_by_study",
    "read_table",
    "run_study",
    "study_pieces",
]

__version__: str

_Told: TypeAlias = Callable[[int, int, str], object] | None
_Predicted: TypeAlias = tuple[list[tuple[str, str, NDArray[np.float64] | list[str]]], str, bool]

class Error(Exception): ...

def machine_names() -> list[str]: ...
def as_toml(json: str) -> str: ...
def read_table(path: str | PathLike[str], is_number: Sequence[bool]) -> dict[str, NDArray[np.float64] | list[str]]: ...
def run_study(
    path: str | PathLike[str],
    out: str | PathLike[str] | None,
    grid: Sequence[int] | None,
    points: int | None,
    all_points: bool,
    parameters: Sequence[tuple[str, float]],
    figures: bool,
    colours: str,
    begin: str,
    told: _Told,
) -> dict[str, Any]: ...
def study_pieces(
    path: str | PathLike[str], grid: Sequence[int] | None = None, points: int | None = None
) -> tuple[int, bool]: ...
def compute_part(
    path: str | PathLike[str],
    number: int,
    count: int,
    before: Sequence[bytes] = ...,
    threads: int = 0,
    grid: Sequence[int] | None = None,
    points: int | None = None,
) -> bytes: ...
def merge_parts(
    path: str | PathLike[str],
    parts: Sequence[bytes],
    out: str | PathLike[str],
    grid: Sequence[int] | None = None,
    points: int | None = None,
) -> None: ...
def part_head(part: bytes) -> tuple[int, int, int, bool, int]: ...
def predict_by_machine(machine: Machine, source: bytes | None, name: str) -> _Predicted: ...
def predict_by_study(
    path: str | PathLike[str], parameters: Sequence[tuple[str, float]], source: bytes | None, name: str
) -> _Predicted: ...

@final
class Machine:
    @staticmethod
    def named(name: str) -> Machine: ...
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Machine: ...
    @staticmethod
    def from_toml(toml: str, origin: str) -> Machine: ...
    @staticmethod
    def urdf(
        path: str | PathLike[str],
        tip: str | None,
        tool_tip: Sequence[float],
        tool_angles: Sequence[float] | None,
        stiffness: Sequence[float] | None,
        like: Machine | None,
    ) -> tuple[str, list[str]]: ...
    def with_parameters(self, values: Sequence[tuple[str, float]]) -> Machine: ...
    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def origin(self) -> str: ...
    @property
    def toml(self) -> str: ...
    @property
    def set_parameters(self) -> list[tuple[str, float]]: ...
    @property
    def characteristic_length_mm(self) -> float: ...
    @property
    def drive_names(self) -> list[str]: ...
    @property
    def hinges(self) -> list[bool]: ...
    @property
    def workspace_mm(self) -> NDArray[np.float64]: ...
    @property
    def tool_tip_mm(self) -> NDArray[np.float64]: ...
    @property
    def home(self) -> NDArray[np.float64]: ...
    @property
    def points_mm(self) -> dict[str, NDArray[np.float64]]: ...
    def parameters(self) -> list[tuple[str, float | None, str, str | None, str | None, tuple[float, float] | None]]: ...
    def equilibria(
        self, pose: NDArray[np.float64], wrench: NDArray[np.float64], stiffness: bool, at_tip: bool
    ) -> dict[str, Any]: ...
    def equilibria_at_drives(
        self, drives: NDArray[np.float64], wrench: NDArray[np.float64], stiffness: bool, at_tip: bool
    ) -> dict[str, Any]: ...
    def forward(self, drives: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def inverse(self, pose: NDArray[np.float64], branch: str | None, jacobian: bool) -> NDArray[np.float64]: ...
    def compensations(
        self, pose: NDArray[np.float64], wrench: NDArray[np.float64], method: str, target: str, at_tip: bool
    ) -> dict[str, Any]: ...
    def deflections(
        self,
        parameters: NDArray[np.float64],
        names: Sequence[str],
        pose: NDArray[np.float64],
        wrench: NDArray[np.float64],
        skips_no_machine: bool,
    ) -> NDArray[np.float64]: ...

@final
class Process:
    @staticmethod
    def from_file(path: str | PathLike[str], machine: Machine) -> Process: ...
    @staticmethod
    def from_toml(toml: str, origin: str, folder: str | PathLike[str], machine: Machine) -> Process: ...
    def facts(self) -> list[tuple[str, str]]: ...
    def assumed(self) -> list[tuple[str, str]]: ...

@final
class Program:
    @staticmethod
    def open(path: str | PathLike[str], process: Process) -> Program: ...
    @staticmethod
    def parse(content: bytes, name: str, process: Process) -> Program: ...
    def __len__(self) -> int: ...
    def points(self) -> dict[str, NDArray[Any]]: ...
    def follow(self, method: str, told: _Told) -> dict[str, Any]: ...
    def compensated(self, method: str, told: _Told) -> dict[str, Any]: ...
