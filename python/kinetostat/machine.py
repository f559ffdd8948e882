"""Machines: what they are made of, how they settle under loads, and what to command instead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _kinetostat
from ._cases import Cases, numbers
from .results import Compensation, Equilibrium, shared

if TYPE_CHECKING:
    from .uncertainty import Sample

Target = Literal["tool_tip", "platform_point", "full_pose"]


class Parameter(NamedTuple):
    """A number of a machine."""

    name: str
    """Such as ``arm.A2.stiffness``; no other has it."""
    value: float | None
    """In :attr:`unit`; None where the machine file calls it unknown."""
    unit: str
    """As in machine files: mm, deg, N, N_per_mm and so on; empty for a plain number."""
    key: str | None
    """Where the machine file has it; None for an error of a chain."""
    grade: str | None
    """How far it may be trusted: published, data_sheet, identified or assumed; None where the file does not say."""
    interval: tuple[float, float] | None
    """95 % interval in :attr:`unit`; None where the file has none."""


def machine_names() -> list[str]:
    """Names of the built-in machines."""
    return _kinetostat.machine_names()


class Machine:
    """A machine that does not change; other numbers make another one (:meth:`with_parameters`).

    ``Machine("orthoglide")`` is a built-in one, see :func:`machine_names`. Methods that compute release the lock of the
    interpreter, use all processors (``RAYON_NUM_THREADS`` of them if that is set) and end at Ctrl-C; results have the
    same bits on any number of them.
    """

    __slots__ = ("_machine", "notes")

    def __init__(self, name: str) -> None:
        """The built-in machine called `name`.

        Raises :class:`Error` if there is none.
        """
        self._machine = _kinetostat.Machine.named(name)
        self.notes: tuple[str, ...] = ()
        """What an import had to say: what was not used, and what was assumed."""

    @classmethod
    def _of(cls, machine: _kinetostat.Machine, notes: Sequence[str] = ()) -> Machine:
        own = cls.__new__(cls)
        own._machine, own.notes = machine, tuple(notes)
        return own

    @classmethod
    def from_file(cls, path: str | PathLike[str]) -> Machine:
        """The machine of the machine file `path` (TOML).

        Raises :class:`Error` with file, line, key, value and what was expected.
        """
        return cls._of(_kinetostat.Machine.from_file(fspath(path)))

    @classmethod
    def from_toml(cls, toml: str, name: str = "machine.toml") -> Machine:
        """The machine that the text `toml` of a machine file describes; `name` names it in messages."""
        return cls._of(_kinetostat.Machine.from_toml(toml, name))

    @classmethod
    def import_urdf(
        cls,
        path: str | PathLike[str],
        *,
        stiffness: Sequence[float] | None = None,
        like: Machine | None = None,
        tip: str | None = None,
        tool_tip_mm: Sequence[float] = (0.0, 0.0, 0.0),
        tool_rpy_deg: Sequence[float] | None = None,
    ) -> Machine:
        """The machine of the URDF `path`; :attr:`toml` is its machine file, :attr:`notes` what was not used or assumed.

        A URDF does not say how stiff its drives are: `stiffness` does, from base to tip, N·m/rad of revolute joints and
        N/mm of prismatic ones, or they are `like` those of another machine. `tip` is the link that carries the tool, if
        the robot has several ends; `tool_tip_mm` and `tool_rpy_deg` (roll, pitch, yaw; z along the tool) are the tool
        in its frame.

        Raises :class:`Error` if the file is no robot, or no stiffness is given.
        """
        given = _kinetostat.Machine.urdf(
            fspath(path), tip, tool_tip_mm, tool_rpy_deg, stiffness, like._machine if like is not None else None
        )
        toml, notes = given
        return cls._of(_kinetostat.Machine.from_toml(toml, fspath(path)), notes)

    def __reduce__(self) -> tuple[Any, ...]:
        own = self._machine
        return _restored, (own.toml, own.origin, own.set_parameters, self.notes)

    def __copy__(self) -> Machine:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Machine:
        return self

    def __eq__(self, other: object) -> bool:
        """Whether its file and the numbers that were set are the same."""
        if not isinstance(other, Machine):
            return NotImplemented
        return self._numbers() == other._numbers()

    def __hash__(self) -> int:
        return hash(self._numbers())

    def _numbers(self) -> tuple[str, tuple[tuple[str, float], ...]]:
        return self._machine.toml, tuple(self._machine.set_parameters)

    @property
    def name(self) -> str:
        """Its short name."""
        return self._machine.name

    @property
    def title(self) -> str:
        """What machine it is, in a line."""
        return self._machine.title

    @property
    def source(self) -> str:
        """Where its numbers come from."""
        return self._machine.source

    @property
    def toml(self) -> str:
        """Its machine file, without what :meth:`with_parameters` has set."""
        return self._machine.toml

    @property
    def drive_names(self) -> list[str]:
        """Its drives, in the order of arrays."""
        return self._machine.drive_names

    @property
    def revolute(self) -> list[bool]:
        """Whether each drive is a revolute joint (rad, N·mm) and not a prismatic joint (mm, N)."""
        return self._machine.revolute

    @property
    def characteristic_length_mm(self) -> float:
        """Largest distance from P to a joint at home, mm."""
        return self._machine.characteristic_length_mm

    @property
    def workspace_mm(self) -> NDArray[np.float64]:
        """``[2, 3]``: lower and upper corner of the nominal workspace of P, O, mm."""
        return self._machine.workspace_mm

    @property
    def tool_tip_mm(self) -> NDArray[np.float64]:
        """``[3]``: from P to the tool tip, platform axes, mm."""
        return self._machine.tool_tip_mm

    @property
    def home(self) -> NDArray[np.float64]:
        """``[4, 4]``: pose of P at home, O, mm."""
        return self._machine.home

    @property
    def points_mm(self) -> dict[str, NDArray[np.float64]]:
        """Named positions of P, O, mm."""
        return self._machine.points_mm

    def __repr__(self) -> str:
        changed = self._machine.set_parameters
        with_numbers = f", {len(changed)} numbers changed" if changed else ""
        return f"Machine {self.name}: {self.title}{with_numbers}"

    def parameters(self) -> dict[str, Parameter]:
        """All its numbers by name: those of its file, those with a usual value, and errors of its chains (zero unless
        set)."""
        return {own[0]: Parameter(*own) for own in self._machine.parameters()}

    def with_parameters(self, values: Mapping[str, float]) -> Machine:
        """The machine with other numbers, in the units of :meth:`parameters`.

        Errors of chains answer but do not command: a machine with them is commanded as if it had none.

        Raises :class:`Error` for a name that is none, with the nearest ones, and for values that make no machine.
        """
        set_values = [(name, float(value)) for name, value in values.items()]
        return self._of(self._machine.with_parameters(set_values), self.notes)

    def sample(self, n: int, seed: int = 0, what: Mapping[str, Any] | None = None) -> Sample:
        """`n` machines and forces of the table ``[uncertainty]`` that `what` is: :meth:`Uncertainty.sample`.

        Without it, numbers of the machine vary in the intervals of its file, and stiffnesses that it grades as assumed
        by 30 %.
        """
        # That module needs this one.
        from .uncertainty import Uncertainty

        return Uncertainty(self, {"machine": "provenance"} if what is None else what).sample(n, seed)

    def forward_kinematics(self, drives: ArrayLike) -> NDArray[np.float64]:
        """``[n, 4, 4]``: pose of P in O of the nominal, unloaded machine with its drives at `drives`, ``[n, d]``.

        Drives are in mm or rad in the order of :attr:`drive_names`. NaN where the chains cannot close.
        """
        cases = Cases.of_drives(drives, len(self.drive_names), None)
        return cases.shaped(self._machine.forward(cases.pose))

    def inverse_kinematics(self, pose: ArrayLike, *, branch: str | None = None) -> NDArray[np.float64]:
        """``[n, d]``: drives of the nominal, unloaded machine, mm or rad, that put P to `pose`.

        `pose` is as in :meth:`equilibrium`; `branch` is the one that an arm is to stand on, such as "front-up-flip";
        any if it is None. NaN where the pose cannot be reached, or the machine does not control it.

        Raises :class:`Error` for a branch that the machine has not.
        """
        cases = Cases.of(pose, None)
        return cases.shaped(self._machine.inverse(cases.pose, branch, False))

    def jacobian(self, pose: ArrayLike, *, branch: str | None = None) -> NDArray[np.float64]:
        """``[n, d, k]``: derivative of the drives by the controlled coordinates of P at `pose`.

        In mm or rad of the drives per mm, or per rad about the axes of the platform; `pose` and `branch` as in
        :meth:`inverse_kinematics`. NaN where it has no answer, and at a singularity.
        """
        cases = Cases.of(pose, None)
        return cases.shaped(self._machine.inverse(cases.pose, branch, True))

    def equilibrium_at_drives(
        self,
        drives: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        stiffness: bool = False,
        at: Literal["P", "tip"] = "P",
    ) -> Equilibrium:
        """How the machine settles under a load with its drives at `drives`, ``[d]`` or ``[n, d]``.

        Drives are in mm or rad in the order of :attr:`drive_names`; all else is as in :meth:`equilibrium`.
        """
        cases = Cases.of_drives(drives, len(self.drive_names), wrench)
        found = self._machine.equilibria_at_drives(cases.pose, cases.wrench, stiffness, _is_tip(at))
        kept: dict[str, Any] = {name: cases.shaped(found[name]) for name in ("stiffness", "compliance") if stiffness}
        return Equilibrium(**shared(found, cases, self.drive_names, self.revolute), **kept)

    def equilibrium(
        self,
        pose: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        stiffness: bool = False,
        at: Literal["P", "tip"] = "P",
    ) -> Equilibrium:
        """How the machine settles under a load where it is commanded to `pose`, without compensation.

        `pose` is a position of P in O, mm (``[3]`` or ``[n, 3]``, oriented as at home), or a homogeneous matrix (``[4,
        4]`` or ``[n, 4, 4]``); `wrench` a dead wrench at P in the axes of O, ``[6]`` or ``[n, 6]``: force in N, then
        moment in N·mm; none is no load. One of them serves for all of the other. With `stiffness`, those of P under the
        load are kept, too. With `at` "tip" the wrench acts at the tool tip, where the unloaded machine has it.

        Raises :class:`Error` for numbers that are none or no rotation, ValueError for shapes; what cannot be reached or
        has no stable equilibrium is a status.
        """
        cases = Cases.of(pose, wrench)
        found = self._machine.equilibria(cases.pose, cases.wrench, stiffness, _is_tip(at))
        kept: dict[str, Any] = {name: cases.shaped(found[name]) for name in ("stiffness", "compliance") if stiffness}
        return Equilibrium(**shared(found, cases, self.drive_names, self.revolute), **kept)

    def stiffness(self, pose: ArrayLike, wrench: ArrayLike | None = None) -> NDArray[np.float64]:
        """``[n, 6, 6]``: Cartesian stiffness of P in the axes of O under a load, eq. (6): N/mm, N/rad; N·mm/mm,
        N·mm/rad.

        NaN where it is rigid in some direction, or where there is no stable equilibrium; :meth:`equilibrium` tells why,
        and has the compliance, too. `pose` and `wrench` as there.
        """
        found = self.equilibrium(pose, wrench, stiffness=True).stiffness
        assert found is not None
        return found

    def compensate(
        self,
        pose: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        method: str = "direct",
        target: Target = "tool_tip",
        at: Literal["P", "tip"] = "P",
    ) -> Compensation:
        """What to command so that the loaded tool is where `pose` would have it; `pose`, `wrench` and `at` as in
        :meth:`equilibrium`.

        `method` is none, linear, mirror, mirror_N, matrix_free, fixed_matrix, procedure, newton or direct; `target`
        says what is compensated, as far as the drives control it.

        Raises :class:`Error` for a method or target that is none; a command that is not found is a status.
        """
        cases = Cases.of(pose, wrench)
        found = self._machine.compensations(cases.pose, cases.wrench, method, target, _is_tip(at))
        own: dict[str, Any] = {
            name: cases.shaped(found[name]) for name in ("nominal_drives", "command", "error", "corrections")
        }
        return Compensation(**shared(found, cases, self.drive_names, self.revolute), **own)

    def deflection(
        self,
        parameters: ArrayLike,
        names: Sequence[str],
        pose: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        output: Literal["distance", "vector"] = "distance",
        no_machine: Literal["raise", "nan"] = "raise",
    ) -> NDArray[np.float64]:
        """``[n, m]``: how far the tool is moved at `m` cases for `n` sets of named numbers, mm; what SALib, Optuna and
        their like ask.

        `parameters` is ``[n, d]``, a row for each set, columns as `names` say, in the units of :meth:`parameters`;
        ``[d]`` is one set, whose answer is ``[m]``. `pose` and `wrench` as in :meth:`equilibrium`. With the output
        "vector" there are three columns for each case, the displacement of the tool tip in O. NaN where the machine is
        not solved: ``with_parameters(...).equilibrium(...)`` tells why.

        Raises :class:`Error` for names that are none, and, unless `no_machine` is "nan", for numbers that make no
        machine, with the row.
        """
        cases = Cases.of(pose, wrench)
        sets = numbers("parameters", parameters)
        if sets.ndim not in (1, 2) or sets.shape[-1] != len(names):
            raise ValueError(f"parameters: expected the shape [n, {len(names)}], got {list(sets.shape)}")
        if no_machine not in ("raise", "nan"):
            raise ValueError(f'no_machine: expected "raise" or "nan", got "{no_machine}"')
        if output not in ("distance", "vector"):
            raise ValueError(f'output: expected "distance" or "vector", got "{output}"')
        rows = np.ascontiguousarray(sets.reshape(-1, len(names)))
        vectors = self._machine.deflections(rows, list(names), cases.pose, cases.wrench, no_machine == "nan")
        found = vectors.reshape(len(rows), -1) if output == "vector" else np.linalg.norm(vectors, axis=-1)
        return np.asarray(found[0] if sets.ndim == 1 else found)


def _restored(toml: str, origin: str, parameters: Sequence[tuple[str, float]], notes: Sequence[str]) -> Machine:
    """The machine that :mod:`pickle` kept."""
    own = _kinetostat.Machine.from_toml(toml, origin)
    return Machine._of(own.with_parameters(parameters) if parameters else own, notes)


def _is_tip(at: str) -> bool:
    """Whether a wrench acts at the tool tip."""
    if at not in ("P", "tip"):
        raise ValueError(f'at: expected "P" or "tip", got "{at}"')
    return at == "tip"
