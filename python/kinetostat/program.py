"""Programs: the points at which a tool is wanted, what the loaded machine does along them, and programs that put it
right."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _kinetostat
from ._progress import Progress, told
from .process import Process
from .results import Array
from .table import Column, Table


@dataclass(frozen=True)
class Followed:
    """What the commands of a method lead to along a path, a row for each point; NaN where there is none."""

    drives: Array
    """``[n, d]``: drive positions commanded, mm of prismatic joints and rad of revolute joints."""
    nominal_drives: Array
    """``[n, d]``: the same without compensation."""
    drive_forces: Array
    """``[n, d]``: forces of the drives, N, or N·mm of revolute joints."""
    command: Array
    """``[n, 4, 4]``: pose of P in O that is commanded, mm."""
    error: Array
    """``[n, 3]``: from where the compensated point is wanted to where it is, O, mm."""
    rotation: Array
    """``[n, 3]``: rotation vector from the wanted orientation, O, rad."""
    status: NDArray[np.str_]
    """``[n]``: how each point ended."""
    reasons: dict[int, str]
    """Why there is no answer, by the number of the point."""
    summary: dict[str, Any]
    """Over the points that count (at which the tool cuts): points, solved, failed, max_mm and rms_mm."""

    @property
    def distance(self) -> Array:
        """``[n]``: how far the compensated point is from where it is wanted, mm."""
        return np.asarray(np.linalg.norm(self.error, axis=-1))


@dataclass(frozen=True, repr=False)
class CompensatedProgram:
    """A program written anew so that the loaded tool follows its path."""

    content: bytes | None
    """The program; None where a point at which the tool cuts has no command."""
    failures: dict[int, str]
    """Those points and why."""
    summaries: dict[str, dict[str, Any]]
    """What is left without compensation ("none"), by the commands of the method, and by the program as it is written,
    rounding included ("as_written"): points, solved, failed, max_mm, rms_mm."""
    position: Array | None
    """``[n, 3]``: what it commands, read back from its text, workpiece frame, mm."""
    rounded_mm: float | None
    """The farthest that writing has moved a position, mm."""
    spread: dict[str, Any] | None = None
    """Where the process has uncertain inputs: of the largest distance from the path without compensation ("none") and
    as written ("as_written") median_mm, p95_mm and within_tolerance (None where there is none), and the probability
    that it is larger as written ("worse")."""

    @property
    def text(self) -> str | None:
        """The program as text."""
        return None if self.content is None else self.content.decode("utf-8", errors="replace")

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the program to `path`.

        Raises :class:`Error` if there is none.
        """
        if self.content is None:
            point, reason = next(iter(self.failures.items()))
            raise _kinetostat.Error(
                f"{fspath(path)}: there is no program to write: no command for point {point}: {reason}"
            )
        FilePath(path).write_bytes(self.content)

    def __repr__(self) -> str:
        if self.content is None:
            reason = next(iter(self.failures.values()))
            return f"CompensatedProgram: none, no command for {len(self.failures)} points; {reason}"
        before, after = (self.summaries[name]["max_mm"] for name in ("none", "as_written"))
        return f"CompensatedProgram: leaves up to {after:.4g} mm, without compensation {before:.4g} mm"


def _spread(found: Any) -> dict[str, Any] | None:
    """Names for what the engine tells of distributions."""
    if found is None:
        return None
    names = ("median_mm", "p95_mm", "within_tolerance")
    plain, written, worse = found
    named = [None if own is None else dict(zip(names, own, strict=True)) for own in (plain, written)]
    return {"none": named[0], "as_written": named[1], "worse": worse}


class Path:
    """A program on a machine: points in order, with where P is to stand and the load there."""

    __slots__ = ("_points", "_program", "name", "process")

    def __init__(self, program: _kinetostat.Program, process: Process, name: str) -> None:
        self._program, self.process, self.name = program, process, name
        self._points = program.points()

    @classmethod
    def from_file(cls, path: str | PathLike[str], process: Process) -> Path:
        """The program in `path`: a polyline (.csv), KRL (.src), RAPID (.mod, .prg), FANUC (.ls), URScript (.script),
        APT (.apt, .cl, .cls, .ncl) or G-code.

        Raises :class:`Error` with file, line and what was expected.
        """
        return cls(_kinetostat.Program.open(fspath(path), process._process), process, fspath(path))

    @classmethod
    def from_gcode(cls, path: str | PathLike[str], process: Process) -> Path:
        """As :meth:`from_file`, of G-code."""
        return cls.from_file(path, process)

    @classmethod
    def from_text(cls, text: str | bytes, process: Process, name: str = "program.nc") -> Path:
        """The program that `text` is, of a file that would be called `name`."""
        content = text.encode() if isinstance(text, str) else text
        return cls(_kinetostat.Program.parse(content, name, process._process), process, name)

    @property
    def position(self) -> Array:
        """``[n, 3]``: where the tool tip is wanted, workpiece frame, mm."""
        return self._points["position"]

    @property
    def pose(self) -> Array:
        """``[n, 4, 4]``: where P is commanded without compensation, O, mm."""
        return self._points["pose"]

    @property
    def wrench(self) -> Array:
        """``[n, 6]``: load at P in the axes of O, N and N·mm."""
        return self._points["wrench"]

    @property
    def arc_length(self) -> Array:
        """``[n]``: length of the path up to each point, mm."""
        return self._points["arc_length"]

    @property
    def cutting(self) -> NDArray[np.bool_]:
        """``[n]``: whether the tool cuts there."""
        return self._points["cutting"]

    @property
    def line(self) -> NDArray[np.int64]:
        """``[n]``: line of the file, from 1; 0 where it is not known."""
        return self._points["line"]

    def __len__(self) -> int:
        return len(self._program)

    def __repr__(self) -> str:
        return f"Path {self.name}: {len(self)} points on {self.process.machine.name}"

    def follow(self, method: str = "none", *, progress: Progress = False) -> Followed:
        """What the commands of `method` lead to, point after point; methods as in :meth:`Machine.compensate`."""
        with told(progress) as tell:
            found = self._program.follow(method, tell)
        return Followed(**{**found, "status": np.array(found["status"]), "reasons": dict(found["reasons"])})

    def compensate(self, method: str = "direct", *, progress: Progress = False) -> CompensatedProgram:
        """The program that makes the loaded tool follow the path, verified by simulating what was written.

        What calls or loops cannot carry is written out; files beside the program are not made (the command line does).
        """
        with told(progress) as tell:
            found = self._program.compensated(method, tell)
        return CompensatedProgram(
            content=found.get("bytes"),
            failures=dict(found["failures"]),
            summaries=found["summaries"],
            position=found.get("position"),
            rounded_mm=found.get("rounded_mm"),
            spread=_spread(found.get("spread")),
        )

    def to_table(self) -> Table:
        """A row for each point."""
        position, wrench = self.position, self.wrench
        columns = [Column(f"{axis}_mm", position[:, k], "mm") for k, axis in enumerate("xyz")]
        columns += [Column(f"force_{axis}_N", wrench[:, k], "N") for k, axis in enumerate("xyz")]
        columns += [Column(f"moment_{axis}_Nmm", wrench[:, 3 + k], "N mm") for k, axis in enumerate("xyz")]
        columns += [
            Column("path_length_mm", self.arc_length, "mm"),
            Column("cutting", self.cutting),
            Column("line", self.line),
        ]
        return Table("path", columns)
