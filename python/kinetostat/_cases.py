"""Shapes of what is asked: one case, or several in rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True)
class Cases:
    """Places and loads as rows, and whether there is one case without an axis of its own."""

    pose: NDArray[np.float64]
    wrench: NDArray[np.float64]
    is_one: bool

    @staticmethod
    def of(pose: ArrayLike, wrench: ArrayLike | None) -> Cases:
        """Of `pose`, ``[3]``, ``[4, 4]``, ``[n, 3]`` or ``[n, 4, 4]``, and `wrench`, ``[6]``, ``[n, 6]`` or none."""
        places = numbers("pose", pose)
        if places.shape[-2:] == (4, 4) and places.ndim in (2, 3):
            return Cases._of_rows("pose", places.reshape(-1, 16), places.ndim == 2, wrench)
        if places.shape[-1:] == (3,) and places.ndim in (1, 2):
            return Cases._of_rows("pose", places.reshape(-1, 3), places.ndim == 1, wrench)
        raise ValueError(f"pose: expected the shape [3], [4, 4], [n, 3] or [n, 4, 4], got {list(places.shape)}")

    @staticmethod
    def of_drives(drives: ArrayLike, count: int, wrench: ArrayLike | None) -> Cases:
        """Of `drives`, ``[d]`` or ``[n, d]`` of `count` drives, as :attr:`pose`, and `wrench` as in :meth:`of`."""
        places = numbers("drives", drives)
        if places.shape[-1:] != (count,) or places.ndim not in (1, 2):
            raise ValueError(f"drives: expected the shape [{count}] or [n, {count}], got {list(places.shape)}")
        cases = Cases._of_rows("drives", places.reshape(-1, count), places.ndim == 1, wrench)
        if len(cases.pose) == 1 and len(cases.wrench) > 1:
            return Cases(np.repeat(cases.pose, len(cases.wrench), axis=0), cases.wrench, cases.is_one)
        return cases

    @staticmethod
    def _of_rows(name: str, rows: NDArray[np.float64], one_place: bool, wrench: ArrayLike | None) -> Cases:
        loads = numbers("wrench", np.zeros(6) if wrench is None else wrench)
        if loads.shape[-1:] != (6,) or loads.ndim not in (1, 2):
            raise ValueError(f"wrench: expected the shape [6] or [n, 6], got {list(loads.shape)}")
        one_load, loads = loads.ndim == 1, loads.reshape(-1, 6)
        if not one_place and not one_load and len(rows) != len(loads):
            raise ValueError(f"wrench: expected {len(rows)} rows, one for each row of {name}, got {len(loads)}")
        # Rows that are there once although there are several of the other, or none.
        if one_place and not one_load and len(loads) == 0:
            rows = rows[:0]
        if one_load and not one_place and len(rows) == 0:
            loads = loads[:0]
        return Cases(np.ascontiguousarray(rows), np.ascontiguousarray(loads), one_place and one_load)

    def shaped(self, array: NDArray[Any]) -> NDArray[Any]:
        """`array`, without its first axis if there is one case."""
        return array[0] if self.is_one else array


def numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array of numbers; `name` names them in messages."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{name}: expected an array of numbers: {fault}") from None
