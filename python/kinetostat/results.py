"""What came of single cases or many: arrays by name, NaN where there is no answer, and why there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._cases import Cases
from .table import Column, Table

if TYPE_CHECKING:
    import pandas
    import polars
    import xarray

Array = NDArray[np.float64]

_AXES = ("x", "y", "z")


@dataclass(frozen=True, repr=False)
class Settled:
    """Cases that were commanded and settled. Of one case that was asked without an axis of its own, arrays have no
    first axis."""

    drives: Array
    """``[n, d]``: drive positions commanded, mm of prismatic joints and rad of revolute joints."""
    drive_forces: Array
    """``[n, d]``: forces of the drives, N, or N·mm of revolute joints."""
    pose: Array
    """``[n, 4, 4]``: pose of P in O as the machine settles under its load, mm."""
    deflection: Array
    """``[n, 3]``: from where the tool tip is wanted to where it is, O, mm."""
    rotation: Array
    """``[n, 3]``: rotation vector of the platform from the wanted orientation, O, rad."""
    status: NDArray[np.str_]
    """``[n]``: how each case ended, ``"solved"`` and so on, as in the tables of the command line."""
    reasons: dict[int, str]
    """Why there is no answer, by the number of the case."""
    drive_names: Sequence[str]
    revolute: Sequence[bool]

    @property
    def solved(self) -> NDArray[np.bool_]:
        """``[n]``: whether there is an answer."""
        return np.isin(self.status, ("solved", "converged", "applied"))

    @property
    def distance(self) -> Array:
        """``[n]``: how far the tool tip is from where it is wanted, mm."""
        return np.asarray(np.linalg.norm(self.deflection, axis=-1))

    def __len__(self) -> int:
        return 1 if self.status.ndim == 0 else len(self.status)

    def __repr__(self) -> str:
        solved = int(np.count_nonzero(self.solved))
        largest = f", tool moved by up to {np.nanmax(self.distance):.4g} mm" if solved else ""
        reason = "" if solved == len(self) else f"; {next(iter(self.reasons.values()))}"
        return f"{type(self).__name__}: {solved} of {len(self)} solved{largest}{reason}"

    def to_table(self) -> Table:
        """A row for each case, a column for each number, with units."""
        return Table(type(self).__name__.lower(), self._columns())

    def to_pandas(self) -> pandas.DataFrame:
        """:meth:`to_table` as a data frame."""
        return self.to_table().to_pandas()

    def to_polars(self) -> polars.DataFrame:
        """:meth:`to_table` as a data frame."""
        return self.to_table().to_polars()

    def to_xarray(self) -> xarray.Dataset:
        """Arrays over the dimensions case, axis and drive."""
        import xarray

        dims = {"drives": ("drive",), "drive_forces": ("drive",), "pose": ("row", "column")}
        variables = {}
        cases = () if self.status.ndim == 0 else ("case",)
        for name, values, unit in self._arrays():
            own = dims.get(name, ("axis",) if values.ndim > self.status.ndim else ())
            variables[name] = ((*cases, *own), values, {"units": unit} if unit else {})
        variables["reason"] = (cases, self._reasons().reshape(self.status.shape), {})
        coordinates = {"drive": list(self.drive_names), "axis": list(_AXES)}
        return xarray.Dataset(variables, coords=coordinates)

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """For whatever reads Arrow streams; needs pyarrow."""
        return self.to_table().__arrow_c_stream__(requested_schema)

    def _repr_html_(self) -> str:
        return self.to_table()._repr_html_()

    def _arrays(self) -> list[tuple[str, NDArray[Any], str]]:
        # Of prismatic and revolute joints together, there is no common unit.
        unit, force = (
            ("", "") if len(set(self.revolute)) > 1 else (("rad", "N mm") if any(self.revolute) else ("mm", "N"))
        )
        return [
            ("drives", self.drives, unit),
            ("drive_forces", self.drive_forces, force),
            ("pose", self.pose, ""),
            ("deflection", self.deflection, "mm"),
            ("rotation", self.rotation, "rad"),
            ("status", self.status, ""),
        ]

    def _columns(self) -> list[Column]:
        status = np.atleast_1d(self.status)
        position = self.pose[..., :3, 3].reshape(-1, 3)
        columns = [
            Column("status", status.astype(object)),
            Column("reason", self._reasons()),
            *_columns("deflection", self.deflection, [f"{axis}_mm" for axis in _AXES], "mm"),
            *_columns("rotation", self.rotation, [f"{axis}_rad" for axis in _AXES], "rad"),
            *_columns("p", position, [f"{axis}_mm" for axis in _AXES], "mm"),
            *self._of_drives("rho", self.drives, ("mm", "rad")),
            *self._of_drives("drive_force", self.drive_forces, ("N", "Nmm")),
        ]
        return columns

    def _reasons(self) -> NDArray[np.object_]:
        reasons = np.full(len(self), "", dtype=object)
        for case, reason in self.reasons.items():
            reasons[case] = reason
        return reasons

    def _of_drives(self, name: str, values: Array, units: tuple[str, str]) -> list[Column]:
        rows = values.reshape(-1, len(self.drive_names))
        unit = [units[is_revolute] for is_revolute in self.revolute]
        named = zip(self.drive_names, unit, rows.T, strict=True)
        return [Column(f"{name}_{drive}_{own}", column, own) for drive, own, column in named]


@dataclass(frozen=True, repr=False)
class Equilibrium(Settled):
    """Machines as they settle under loads at their nominal commands: see :meth:`Machine.equilibrium`."""

    stiffness: Array | None = field(default=None)
    """``[n, 6, 6]`` if it was asked for: change of the wrench at P per twist of P under the load, eq. (6), N/mm,
    N·mm/rad and so on; NaN where the machine is rigid in some direction."""
    compliance: Array | None = field(default=None)
    """``[n, 6, 6]`` if it was asked for: its inverse; NaN where the platform is free."""


@dataclass(frozen=True, repr=False)
class Compensation(Settled):
    """Commands that bring the loaded tool to where it is wanted: see :meth:`Machine.compensate`."""

    nominal_drives: Array
    """``[n, d]``: drive positions without compensation, mm and rad."""
    command: Array
    """``[n, 4, 4]``: pose of P in O to be commanded so that the nominal machine drives to :attr:`drives`, mm."""
    error: Array
    """``[n, 3]``: residual position error of the compensated point, O, mm."""
    corrections: NDArray[np.uint32]
    """``[n]``: corrections that were made."""

    @property
    def delta_rho(self) -> Array:
        """``[n, d]``: commanded less nominal drive positions, mm and rad."""
        return np.asarray(self.drives - self.nominal_drives)

    def _arrays(self) -> list[tuple[str, NDArray[Any], str]]:
        return [*super()._arrays(), ("error", self.error, "mm"), ("corrections", self.corrections, "")]

    def _columns(self) -> list[Column]:
        command = self.command[..., :3, 3].reshape(-1, 3)
        return [
            *super()._columns(),
            *self._of_drives("delta_rho", self.delta_rho, ("mm", "rad")),
            *_columns("command", command, [f"{axis}_mm" for axis in _AXES], "mm"),
            *_columns("error", self.error, [f"{axis}_mm" for axis in _AXES], "mm"),
        ]


def _columns(name: str, values: Array, ends: Sequence[str], unit: str) -> list[Column]:
    rows = values.reshape(-1, len(ends))
    return [Column(f"{name}_{end}", rows[:, k], unit) for k, end in enumerate(ends)]


def shared(found: dict[str, Any], cases: Cases, drive_names: Sequence[str], revolute: Sequence[bool]) -> dict[str, Any]:
    """What all settled cases have, of what the engine `found`."""
    words = np.array(found["statuses"])
    arrays = {name: cases.shaped(found[name]) for name in ("drives", "drive_forces", "pose", "deflection", "rotation")}
    status = words[found["status"]]
    return {
        **arrays,
        "status": np.asarray(cases.shaped(status)),
        "reasons": dict(found["reasons"]),
        "drive_names": tuple(drive_names),
        "revolute": tuple(revolute),
    }
