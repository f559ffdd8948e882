"""What is not known exactly of a machine and of the force on its tool."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _kinetostat
from ._cases import Cases, numbers
from .machine import Machine

_BATCHES = 16
"""Batches whose scatter tells standard errors."""


class UncertainInput(NamedTuple):
    """A number of the machine that varies."""

    name: str
    """As in :meth:`Machine.parameters`, of a mounting: a leg that is mounted three times has three."""
    value: float
    """Nominal value, in :attr:`unit`."""
    unit: str
    """As in machine files."""
    interval: tuple[float, float]
    """95 % interval in :attr:`unit`."""
    distribution: str
    """lognormal, normal or uniform; the nominal value is the median of the first two."""
    numbers: tuple[float, float]
    """Standard deviations below and above the median, of the logarithm where it is lognormal; of a uniform one the
    least and the largest difference from the nominal value."""
    group: int
    """Number of what varies by itself; those of one group vary together."""


class Sample(NamedTuple):
    """Machines and forces."""

    values: NDArray[np.float64]
    """``[n, k]``: a row for each machine, columns as :attr:`Uncertainty.names`."""
    force: NDArray[np.float64]
    """``[n]``: factor of the wrench."""


class Uncertainty:
    """Distributions of numbers of a machine and of the force on its tool, as the table ``[uncertainty]`` of studies
    says them (docs/uncertainty.md).

    >>> import kinetostat
    >>> machine = kinetostat.Machine("orthoglide")
    >>> table = {"parameter": [{"name": "leg.rail.stiffness", "relative_std": 0.15}]}
    >>> uncertainty = kinetostat.Uncertainty(machine, table)
    >>> uncertainty.names
    ['x.rail.stiffness', 'y.rail.stiffness', 'z.rail.stiffness']
    """

    __slots__ = ("_uncertainty", "machine", "names")

    def __init__(self, machine: Machine, what: Mapping[str, Any], *, folder: str | PathLike[str] = ".") -> None:
        """The table `what` as a dictionary; the file of a ``covariance`` is sought in `folder`.

        Raises :class:`Error` with key, value and what was expected.
        """
        toml = _kinetostat.as_toml(json.dumps(dict(what)))
        self._uncertainty = _kinetostat.Uncertainty.from_toml(toml, "uncertainty", fspath(folder), machine._machine)
        self.machine = machine
        self.names: list[str] = [own[0] for own in self._uncertainty.inputs()]
        """Names of all numbers that vary."""

    @property
    def inputs(self) -> list[UncertainInput]:
        """All numbers that vary, with their distributions."""
        return [UncertainInput(*own) for own in self._uncertainty.inputs()]

    @property
    def force_factor(self) -> tuple[float, float] | None:
        """95 % interval of the factor of the force, which is lognormal about 1, times one of tool wear that is uniform
        from 1 to 1 + :attr:`wear_force_increase`; None where it is exact."""
        return self._uncertainty.force()

    @property
    def wear_force_increase(self) -> float | None:
        """Share by which the force of a worn tool may be above that of a sharp one; None where tools stay sharp."""
        return self._uncertainty.wear()

    def draws(self) -> Sample:
        """The 4096 machines and forces that studies draw of this table and its seed, correlations included."""
        return Sample(*self._uncertainty.draws())

    def sample(self, n: int, seed: int = 0) -> Sample:
        """`n` independent machines and forces, from the random numbers of NumPy's generator with this `seed`.

        Raises :class:`Error` where numbers are correlated, as :meth:`draws` has them.
        """
        groups = 1 + max((own.group for own in self.inputs), default=-1)
        of_force = 1 if self.wear_force_increase is None else 2
        normal = np.random.default_rng(seed).standard_normal((n, groups + of_force))
        return Sample(*self._uncertainty.values(normal))

    def deflection(
        self, sample: Sample | tuple[ArrayLike, ArrayLike], pose: ArrayLike, wrench: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """``[n, m]``: how far the tool is moved at `m` cases on the `n` machines of `sample`, mm, each under the wrench
        times its factor; every one solved by the engine.

        `pose` and `wrench` as in :meth:`Machine.equilibrium`; `sample` may be two arrays of another library's numbers,
        as :class:`Sample` has them. NaN where a machine has no equilibrium, or the numbers make none. What the model
        leaves out is not in it.
        """
        values, force = (np.ascontiguousarray(numbers("sample", own)) for own in sample)
        if values.shape != (len(force), len(self.names)) or force.ndim != 1:
            shapes = f"{list(values.shape)} and {list(force.shape)}"
            raise ValueError(f"sample: expected the shapes [n, {len(self.names)}] and [n], got {shapes}")
        cases = Cases.of(pose, wrench)
        vectors = self._uncertainty.deflections(values, force, cases.pose, cases.wrench)
        return np.asarray(np.linalg.norm(vectors, axis=-1))

    def quantiles(
        self,
        pose: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        shares: Sequence[float] = (0.5, 0.95),
        sample: Sample | None = None,
    ) -> NDArray[np.float64]:
        """``[len(shares), m]``: how far the tool is moved at most with these probabilities, mm; infinite where more of
        the machines have no equilibrium. What the model leaves out is not in it, so that studies have wider ones.

        Of the draws of studies, or of `sample`; `pose` and `wrench` as in :meth:`deflection`.
        """
        if not all(0.0 < share <= 1.0 for share in shares):
            raise ValueError(f"shares: expected numbers above 0 and at most 1, got {list(shares)}")
        found = self.deflection(self.draws() if sample is None else sample, pose, wrench)
        if len(found) == 0:
            raise ValueError("sample: expected at least one machine")
        sorted_ = np.sort(np.where(np.isnan(found), np.inf, found), axis=0)
        places = np.clip(np.ceil(np.asarray(shares) * len(sorted_)).astype(int), 1, len(sorted_)) - 1
        return np.asarray(sorted_[places])

    def total_indices(
        self,
        pose: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        groups: Mapping[str, Sequence[str]] | None = None,
        n: int = 1024,
        seed: int = 0,
    ) -> dict[str, NDArray[np.float64]]:
        """``[2, m]`` for each group: its total Sobol index at `m` cases, and the standard error of that.

        The share of the variance of how far the tool is moved that would be left if all else were known: of a group
        alone and with others. `groups` names numbers as :attr:`names` does, with wildcards, and the force as
        ``"force"``; without, each number that varies by itself is a group. By Jansen's estimate from `n` pairs of
        machines, all solved by the engine: ``n * (1 + len(groups))`` machines. What the model leaves out is not in it.

        Raises :class:`Error` where numbers are correlated, and ValueError where a machine has no equilibrium.
        """
        columns = [*self.names, "force"]
        if groups is None:
            found: dict[int, list[str]] = {}
            for own in self.inputs:
                found.setdefault(own.group, []).append(own.name)
            groups = {own[0]: own for own in found.values()}
            groups = {**groups, **({"force": ["force"]} if self.force_factor is not None else {})}
        which = {
            key: [any(fnmatchcase(own, name) for name in names) for own in columns] for key, names in groups.items()
        }
        for key, names in groups.items():
            for name in names:
                if not any(fnmatchcase(own, name) for own in columns):
                    raise ValueError(f"groups: {key}: expected names of numbers that vary, or force, got {name!r}")
        if n < 2 * _BATCHES:
            raise ValueError(f"n: expected at least {2 * _BATCHES} pairs, got {n}")
        drawn = self.sample(2 * n, seed)
        rows = np.column_stack([drawn.values, drawn.force])
        first, second = rows[:n], rows[n:]

        def solved(sets: NDArray[np.float64]) -> NDArray[np.float64]:
            distances = self.deflection((sets[:, :-1], sets[:, -1]), pose, wrench)
            missing = int(np.isnan(distances).any(axis=1).sum())
            if missing > 0:
                raise ValueError(f"sample: {missing} of {len(sets)} machines have no equilibrium: there is no variance")
            return distances

        distances = solved(first)
        variance = np.maximum(distances.var(axis=0), np.finfo(float).tiny)

        def index(chosen: list[bool]) -> NDArray[np.float64]:
            squares = (distances - solved(np.where(chosen, second, first))) ** 2 / (2.0 * variance)
            batches = np.stack([batch.mean(axis=0) for batch in np.array_split(squares, _BATCHES)])
            return np.stack([squares.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(_BATCHES)])

        return {key: index(chosen) for key, chosen in which.items()}

    def __repr__(self) -> str:
        force = " and the force" if self.force_factor is not None else ""
        return f"Uncertainty of {self.machine.name}: {len(self.names)} numbers{force}"
