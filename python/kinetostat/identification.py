"""Numbers of a machine found by measuring it under load, and what would be measured."""

from __future__ import annotations

import csv
import io
import os
import re
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path as FilePath
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _kinetostat
from ._kinetostat import Error
from ._progress import Progress
from .machine import Machine
from .process import Tables
from .study import Answer, run, write_study
from .table import Column, Table

_VECTORS = (
    "command_mm",
    "force_N",
    "moment_Nmm",
    "reference_force_N",
    "reference_moment_Nmm",
    "displacement_mm",
    "position_mm",
    "rotation_deg",
    "marker_mm",
    "gauge_along",
)
_DATA = "measurements.csv"


class Columns(Protocol):
    """Columns by name: a dictionary of arrays, a :class:`Table`, or a data frame of pandas."""

    def keys(self) -> Iterable[str]: ...

    def __getitem__(self, name: str, /) -> Any: ...


Rows: TypeAlias = Columns | str | PathLike[str]
Loss = Literal["squares", "huber", "cauchy"]


@dataclass(frozen=True, repr=False)
class Identification(Answer):
    """Numbers that were sought by :func:`identify`: how far each is known, and how well the machine with them follows
    the measurements."""

    start: Machine | None = None
    """The machine from which the search began."""
    _study: FilePath | None = None
    _with_study: object = None

    @cached_property
    def machine(self) -> Machine | None:
        """The machine with the numbers that were identified, all others as they were.

        None where none was that a machine file has; errors of chains are in :attr:`chain_errors`.
        """
        file = self.folder / "machine.toml"
        if not file.is_file():
            return None
        found = Machine.from_file(file)
        identified = set(self.parameters.where(status="identified")["parameter"])
        before = self.start._machine.set_parameters if self.start is not None else []
        others = {name: value for name, value in before if name not in identified}
        return found.with_parameters(others) if others else found

    @property
    def chain_errors(self) -> FilePath | None:
        """A process file with the errors of chains that were identified; None without any."""
        file = self.folder / "chain_errors.toml"
        return file if file.is_file() else None

    @property
    def parameters(self) -> Table:
        """A row for each number sought, in the unit of machine files (``unit``): ``value``, ``std``, 95 % interval
        (``low_95``, ``high_95``, and by the profile of the likelihood), and ``status``, "identified" or
        "not_identified", with a ``reason``."""
        return self.table("parameters")

    @property
    def residuals(self) -> Table:
        """A row for each reading, mm or of rotations degrees: ``measured``, ``predicted``, ``residual`` (measured less
        predicted), ``left_out_residual`` (predicted without its own measurement), ``std`` and ``weight``."""
        return self.table("residuals")


class Predictions(Table):
    """Readings that were predicted by :func:`predict`, a row for each."""

    def __init__(self, columns: Sequence[Column], words: str, is_complete: bool) -> None:
        super().__init__("predictions", columns)
        self.words = words
        """How well what was read is predicted, and cautions."""
        self.is_complete = is_complete
        """Whether all rows are predicted; if not, ``status`` and ``reason`` say why."""

    def __repr__(self) -> str:
        return f"{super().__repr__()}\n{self.words}".rstrip()


def identify(
    machine: Machine,
    measurements: Rows,
    unknowns: str | Sequence[str],
    *,
    std_mm: float | None = None,
    std_deg: float | None = None,
    loss: Loss = "squares",
    prior: Sequence[Tables] = (),
    alternative: Sequence[Tables] = (),
    folds: int | None = None,
    profile: bool | None = None,
    out: str | PathLike[str] | None = None,
    figures: bool = True,
    progress: Progress = True,
    question: str = "Which numbers make the machine yield as it was measured, and how far is each known?",
) -> Identification:
    """Numbers of `machine` fitted to `measurements` under load, as ``kinetostat identify`` fits them.

    measurements
        A CSV file, or columns by name as such files have them (docs/identification.md): ``force_x_N``,
        ``displacement_x_mm`` and so on, ``[n]`` each, NaN where nothing was read; a number serves for all rows. Vectors
        may be together, ``[n, 3]``: ``force_N`` and ``moment_Nmm`` on the tool tip, ``displacement_mm``,
        ``position_mm`` and ``rotation_deg`` (a rotation vector) of the point measured, ``command_mm`` of P, all in the
        axes of O; ``marker_mm``, the point measured from P in platform axes. ``drives`` is ``[n, d]``, mm or rad in
        the order of :attr:`Machine.drive_names`.
    unknowns
        Names of parameters (:meth:`Machine.parameters`); ``*`` stands for any letters but a dot.
    std_mm, std_deg
        Standard deviation of readings without their own, mm and degrees; that of lengths is estimated from the scatter
        if not given.
    loss
        How readings far off count: "squares", "huber" or "cauchy".
    prior
        What is known beforehand: tables with ``parameter``, ``std`` and, if it is not that of the machine, ``value``,
        in the unit of machine files.
    alternative
        Other sets of unknowns, compared by how well they predict: tables with ``name`` and ``unknowns``.
    folds
        Into how many parts the measurements are divided, each predicted from the others; 5 if not given.
    profile
        Whether intervals are sought by the profile of the likelihood as well; if not given, for up to 20 unknowns.
    out
        The folder of the results; without it, results live as long as the answer.

    A number that the measurements do not identify is no exception: its ``status`` and ``reason`` say so in
    :attr:`Identification.parameters`, and :attr:`Identification.machine` has it as it was.

    Raises :class:`Error` in the words of the command line, with the name of the argument; ValueError for a wrong shape.
    """
    asked = {
        "unknowns": [unknowns] if isinstance(unknowns, str) else list(unknowns),
        "std_mm": std_mm,
        "std_deg": std_deg,
        "loss": loss,
        "prior": [dict(own) for own in prior],
        "alternative": [dict(own) for own in alternative],
        "folds": folds,
        "profile": profile,
    }
    given = {name: value for name, value in asked.items() if value is not None and value != []}
    kept = tempfile.TemporaryDirectory(prefix="kinetostat_")
    folder = FilePath(kept.name) / "identification"
    name, source = _source("measurements", measurements, machine)
    data = os.path.abspath(name) if source is None else _DATA
    write_study(folder, machine, question, {"identification": {"data": data, **given}})
    if source is not None:
        (folder / _DATA).write_bytes(source)
    try:
        answer = run(
            folder,
            FilePath(kept.name) / "results" if out is None else out,
            parameters=dict(machine._machine.set_parameters),
            figures=figures,
            progress=progress,
        )
    except Error as fault:
        words = re.sub(rf"^{re.escape(fspath(folder / 'study.toml'))}(:\d+)?: (identification\.)?", "", str(fault))
        words = re.sub(r"^data: ", "measurements: ", words)
        raise Error(words if source is None else _of_rows(words, fspath(folder / _DATA), "measurements")) from None
    own = {field.name: getattr(answer, field.name) for field in fields(Answer)}
    return Identification(**own, start=machine, _study=folder, _with_study=kept)


def predict(by: Identification | Machine | str | PathLike[str], poses: Rows) -> Predictions:
    """Readings that would be measured at `poses`, under the loads there.

    by
        What was identified, or the folder of a study of an identification, as ``kinetostat predict`` takes it: each
        reading has its 95 % interval, and each call fits anew. Or a machine as it is: without intervals.
    poses
        A CSV file or columns, as the measurements of :func:`identify`. Readings in it are predicted and set beside
        (``measured``); where a row has none, displacements of the tool tip are.

    The answer has a row for each reading (``pose``, ``reading``): ``predicted``, ``low_95`` and ``high_95``, mm or of
    rotations degrees, and the standard deviations of which the interval is made, by what is known of the numbers
    (``std_numbers``), by what the model leaves (``std_misfit``), and by the noise of the reading (``std_reading``). A
    row that has no equilibrium says so in ``status`` and ``reason``.

    Raises :class:`Error` in the words of the command line; ValueError for a wrong shape.
    """
    machine = by.start if isinstance(by, Identification) else by if isinstance(by, Machine) else None
    name, source = _source("poses", poses, machine)
    try:
        if isinstance(by, Machine):
            found = _kinetostat.predict_by_machine(by._machine, source, name)
        elif isinstance(by, Identification):
            if by._study is None or by.start is None:
                raise ValueError("by: expected an identification that identify has returned")
            found = _kinetostat.predict_by_study(by._study, by.start._machine.set_parameters, source, name)
        else:
            found = _kinetostat.predict_by_study(fspath(by), [], source, name)
    except Error as fault:
        raise Error(str(fault) if source is None else _of_rows(str(fault), "poses", "poses")) from None
    columns, words, is_complete = found
    arrays = [
        Column(name, np.asarray(values, dtype=object) if isinstance(values, list) else values, unit)
        for name, unit, values in columns
    ]
    return Predictions(arrays, words, is_complete)


def _of_rows(words: str, file: str, argument: str) -> str:
    """A message with the row of `argument`, from 0, for the line of `file`, whose first one has the names."""

    def row(found: re.Match[str]) -> str:
        line = int(found[1])
        return f"{argument}, row {line - 2}: " if line > 1 else f"{argument}: "

    return re.sub(rf"{re.escape(file)}:(\d+): ", row, words)


def _source(argument: str, rows: Rows, machine: Machine | None) -> tuple[str, bytes | None]:
    """The name of `rows` in messages, and their text as a CSV file unless they are in one."""
    if isinstance(rows, (str, PathLike)):
        return fspath(rows), None
    return argument, _csv(argument, rows, machine)


def _csv(argument: str, rows: Columns, machine: Machine | None) -> bytes:
    """`rows` as a CSV file; `argument` names them in messages."""
    columns: dict[str, NDArray[Any]] = {}
    for name in rows.keys():  # noqa: SIM118, as Columns are iterated otherwise
        values = np.asarray(rows[name])
        if values.ndim < 2:
            columns[name] = values
            continue
        names = _components(argument, name, machine)
        if values.shape[1:] != (len(names),):
            raise ValueError(f"{argument}: {name}: expected the shape [n, {len(names)}], got {list(values.shape)}")
        columns.update(zip(names, values.T, strict=True))
    lengths = {name: len(values) for name, values in columns.items() if values.ndim == 1}
    if not lengths:
        raise ValueError(f"{argument}: expected at least one column with a value for each row, got none")
    first, count = next(iter(lengths.items()))
    for name, length in lengths.items():
        if length != count:
            raise ValueError(f"{argument}: {name}: expected {count} values, as many as {first} has, got {length}")
    cells = [[_cell(value) for value in np.broadcast_to(values, count).tolist()] for values in columns.values()]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*cells, strict=True))
    return text.getvalue().encode()


def _components(argument: str, name: str, machine: Machine | None) -> list[str]:
    """Names of the columns of files that hold what `name` has in one array."""
    if name == "drives":
        if machine is None:
            raise ValueError(f"{argument}: drives: expected a column for each drive, as the machine is not given here")
        units = ["rad" if is_revolute else "mm" for is_revolute in machine.revolute]
        return [f"{drive}_{unit}" for drive, unit in zip(machine.drive_names, units, strict=True)]
    if name not in _VECTORS:
        expected = ", ".join(("drives", *_VECTORS))
        raise ValueError(f"{argument}: {name}: expected the shape [n]; columns together may be {expected}")
    stem, _, unit = name.rpartition("_")
    return [f"{name}_{axis}" if unit == "along" else f"{stem}_{axis}_{unit}" for axis in "xyz"]


def _cell(value: object) -> str:
    """`value` in a CSV file: empty where it is None or NaN."""
    if value is None or (isinstance(value, float) and value != value):
        return ""
    return repr(value) if isinstance(value, float) else str(value)
