"""Studies: run as the command line runs them, read back as tables."""

from __future__ import annotations

import base64
import html
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path as FilePath
from typing import Any, Literal

import numpy as np

from . import _kinetostat
from ._progress import Progress, told
from .machine import Machine
from .process import Tables
from .table import Column, Table

Begin = Literal["new", "resume", "restart"]
Colours = Literal["viridis", "cividis", "grey"]
_NUMBERS = ("double", "nonNegativeInteger")


@dataclass(frozen=True, repr=False)
class Answer:
    """What a study has left in its folder. In a notebook it shows its answer, its first numbers and its first
    figure."""

    folder: FilePath
    """Where its files are: tables, figures, ``report.html``, ``summary.json``, ``manifest.json``."""
    question: str
    sentence: str
    """The answer as somebody would say it."""
    numbers: list[tuple[str, str, str, str]]
    """At most three: value, unit, what it is, what it is measured against."""
    verdict: str | None
    """Whether it may be acted on, with its sign."""
    causes: list[tuple[str, str, float | None, str]]
    """What the verdict rests on: cause, ● measured or bounded, ◐ stated or assumed, ○ not assessed, its mm, source."""
    unsolved: str | None
    """What was not solved and why, if anything was not."""
    basis: str
    cautions: list[str]
    details: str
    """All it says, in sentences and small tables."""
    is_complete: bool
    """Whether everything that was asked is answered."""
    _kept: object = None

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The answer for programs, as ``summary.json`` has it."""
        read: dict[str, Any] = json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
        return read

    @cached_property
    def _described(self) -> dict[str, list[dict[str, str]]]:
        described = json.loads((self.folder / "csv-metadata.json").read_text(encoding="utf-8"))
        return {table["url"].removesuffix(".csv"): table["tableSchema"]["columns"] for table in described["tables"]}

    @property
    def table_names(self) -> list[str]:
        """Names of its tables."""
        return list(self._described)

    def table(self, name: str | None = None) -> Table:
        """The table called `name`, or its first one.

        Raises KeyError if there is none.
        """
        name = self.table_names[0] if name is None else name
        if name not in self._described:
            raise KeyError(f"{name}; there are: {', '.join(self.table_names)}")
        described = self._described[name]
        is_number = [column["datatype"] in _NUMBERS for column in described]
        values = _kinetostat.read_table(self.folder / f"{name}.csv", is_number)
        columns = [
            Column(
                column["titles"],
                np.asarray(values[column["titles"]], dtype=np.float64 if is_a_number else object),
                column.get("schema:unitText", ""),
                column.get("dc:description", ""),
            )
            for column, is_a_number in zip(described, is_number, strict=True)
        ]
        return Table(name, columns)

    @property
    def figures(self) -> dict[str, FilePath]:
        """Its figures as SVG files by name; ``.png`` files stand beside them."""
        return {file.stem: file for file in sorted(self.folder.glob("*.svg"))}

    @property
    def page(self) -> FilePath:
        """Its page, to be opened in a browser."""
        return self.folder / "report.html"

    def __repr__(self) -> str:
        said = [self.verdict, self.sentence] if self.verdict else [self.sentence]
        return "\n".join([*said, *(f"  {value} {unit}  {what}" for value, unit, what, _ in self.numbers)])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td style='text-align:right'><b>{html.escape(value)}</b> {html.escape(unit)}</td>"
            f"<td style='text-align:left'>{html.escape(what)}<br><small>{html.escape(against)}</small></td></tr>"
            for value, unit, what, against in self.numbers
        )
        unsolved = f"<p><b>{html.escape(self.unsolved)}</b></p>" if self.unsolved else ""
        figure = self.folder / "answer.png"
        shown = ""
        if figure.is_file():
            data = base64.b64encode(figure.read_bytes()).decode()
            shown = (
                f"<img style='max-width:100%' alt='{html.escape(self.sentence)}' src='data:image/png;base64,{data}'>"
            )
        answer, basis = html.escape(self.sentence), html.escape(self.basis)
        verdict = f"<p><b>{html.escape(self.verdict)}</b></p>" if self.verdict else ""
        return f"{verdict}{unsolved}<p>{answer}</p><table>{rows}</table>{shown}<p><small>{basis}</small></p>"


def run(
    study: str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    grid: int | Sequence[int] | None = None,
    points: int | Literal["all"] | None = None,
    parameters: Mapping[str, float] | None = None,
    figures: bool = True,
    colours: Colours = "viridis",
    begin: Begin = "new",
    progress: Progress = True,
) -> Answer:
    """Runs a study folder (with a ``study.toml``) or study file, with the bytes that ``kinetostat run`` would leave.

    `out` is the folder of its results, ``results/NAME`` if not given; `grid` (points along x, y, z), `points` along a
    circle and `parameters` of the machine take the place of its own; with `points` "all", tables of more than 50 000
    rows of path points are written whole. `progress` shows a bar if tqdm is installed; a
    function is told items done, their number and what they are called. Ctrl-C stops it: with `begin` "resume", the same
    call goes on; "restart" begins anew.

    Raises :class:`Error` for what cannot be read, makes no sense or cannot be written.
    """
    counts = (grid,) * 3 if isinstance(grid, int) else grid
    with told(progress) as tell:
        found = _kinetostat.run_study(
            fspath(study),
            None if out is None else fspath(out),
            counts,
            None if points == "all" else points,
            points == "all",
            [(name, float(value)) for name, value in (parameters or {}).items()],
            figures,
            colours,
            begin,
            tell,
        )
    return Answer(**{**found, "folder": FilePath(found["folder"])})


def workspace_map(
    machine: Machine,
    process: Tables | str | PathLike[str],
    *,
    grid: int | Sequence[int] = 11,
    slices_z_mm: Sequence[float] | None = None,
    out: str | PathLike[str] | None = None,
    figures: bool = True,
    progress: Progress = True,
    question: str = "How far does the loaded tool move, where, and which drive commands compensate that?",
    **keys: Any,
) -> Answer:
    """A map over the workspace of `machine`: deflections and corrections under the cutting force and the chain errors
    of `process`.

    `process` is a process file or its tables; figures show slices at `slices_z_mm`, or else at the bottom, in the
    middle and at the top; `keys` are others of the table ``[workspace_map]`` of a study file, such as ``phi_step_deg``.
    The table "map" of the answer has a row for each point and source:
    ``answer.table("map").where(source="all").to_xarray("x_mm", "y_mm", "z_mm")``. Without `out`, results live as long
    as the answer.

    Raises :class:`Error` as :func:`run`.
    """
    counts = [grid] * 3 if isinstance(grid, int) else list(grid)
    bottom, top = (float(corner[2]) for corner in machine.workspace_mm)
    slices = [bottom, (bottom + top) / 2, top] if slices_z_mm is None else list(slices_z_mm)
    tables = {"process": _process(process), "workspace_map": {"grid": counts, "slices_z_mm": slices, **keys}}
    return _asked("workspace_map", machine, question, tables, out, figures, progress)


def place(
    machine: Machine,
    feature: Tables | Sequence[Tables],
    process: Tables | str | PathLike[str],
    *,
    bounds: Tables,
    out: str | PathLike[str] | None = None,
    figures: bool = True,
    progress: Progress = True,
    question: str = "Where should the workpiece stand?",
    **tables: Any,
) -> Answer:
    """Where a workpiece should stand: `feature`, `bounds` and `tables` (objective, search, candidate ...) are those of
    ``[placement]`` in study files (docs/study_file.md), `process` is a process file or its tables. Files that they name
    are sought where Python runs.

    Without `out`, results live as long as the answer. Raises :class:`Error` as :func:`run`.
    """
    features = [feature] if isinstance(feature, Mapping) else list(feature)
    placement = {"feature": [_with_files(own) for own in features], "bounds": bounds, **tables}
    return _asked(
        "placement", machine, question, {"process": _process(process), "placement": placement}, out, figures, progress
    )


def _asked(
    name: str,
    machine: Machine,
    question: str,
    tables: dict[str, Any],
    out: str | PathLike[str] | None,
    figures: bool,
    progress: Progress,
) -> Answer:
    """Runs a study that is written into a folder of its own."""
    kept = tempfile.TemporaryDirectory(prefix="kinetostat_") if out is None else None
    with tempfile.TemporaryDirectory(prefix="kinetostat_") as asked:
        folder = FilePath(asked) / name
        write_study(folder, machine, question, tables)
        answer = run(
            folder,
            FilePath(kept.name) / name if kept is not None else out,
            parameters=dict(machine._machine.set_parameters),
            figures=figures,
            progress=progress,
        )
    return replace(answer, _kept=kept)


def write_study(folder: FilePath, machine: Machine, question: str, tables: dict[str, Any]) -> None:
    """Makes the study folder `folder` of `tables`, for `machine` without the numbers that were set."""
    own = machine._machine
    built_in = own.origin in _kinetostat.machine_names() and _kinetostat.Machine.named(own.origin).toml == own.toml
    header = {"schema": 3, "question": question, "machine": own.origin if built_in else "machine.toml"}
    folder.mkdir()
    (folder / "study.toml").write_text(_kinetostat.as_toml(json.dumps({**header, **tables})), encoding="utf-8")
    if not built_in:
        (folder / "machine.toml").write_text(own.toml, encoding="utf-8")


def _process(process: Tables | str | PathLike[str]) -> Any:
    return process if isinstance(process, Mapping) else os.path.abspath(process)


def _with_files(feature: Tables) -> dict[str, Any]:
    """`feature` with the files that it names where they are."""
    files = {
        name: os.path.abspath(feature[name])
        for name in ("process", "file")
        if isinstance(feature.get(name), (str, PathLike))
    }
    return {**feature, **files}
