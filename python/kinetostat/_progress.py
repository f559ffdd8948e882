"""How far a long computation is: a bar of tqdm, if that is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

Told: TypeAlias = Callable[[int, int, str], object]
Progress: TypeAlias = bool | Told


@contextmanager
def told(progress: Progress) -> Iterator[Told | None]:
    """Whom to tell: nobody, who was given, or a bar that is closed at the end."""
    if callable(progress):
        yield progress
        return
    bar = _Bar() if progress else None
    try:
        yield bar if bar is not None and bar.is_there else None
    finally:
        if bar is not None:
            bar.close()


class _Bar:
    def __init__(self) -> None:
        self._bar: Any = None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            self._make = None
        else:
            self._make = tqdm

    @property
    def is_there(self) -> bool:
        return self._make is not None

    def __call__(self, done: int, total: int, of: str) -> None:
        if self._bar is None or (self._bar.total, self._bar.unit) != (total, f" {of}"):
            self.close()
            self._bar = self._make(total=total, unit=f" {of}") if self._make is not None else None
        if self._bar is not None:
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        self._bar = None
