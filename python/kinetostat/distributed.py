"""Studies computed in parts, by the workers of Dask or of any executor of ``concurrent.futures``.

>>> from dask.distributed import Client                                   # doctest: +SKIP
>>> from kinetostat.distributed import run                                # doctest: +SKIP
>>> run("studies/01_workspace_map", Client("tcp://head:8786"), out="map") # doctest: +SKIP

What is left in the folder has the bytes of a run on one machine, whatever the workers, their number and their threads.
A worker that dies takes a part with it, which another one computes; one that comes late gets parts that wait. All
workers must see the study under the same name and have the same build of this package; parts of another build are
refused.

Pools of Ray (``ray.util.multiprocessing`` through ``joblib``), ``mpi4py.futures.MPIPoolExecutor`` and
``ProcessPoolExecutor`` are executors, too.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from os import PathLike, fspath
from pathlib import Path
from typing import Protocol, cast, runtime_checkable

from . import _kinetostat
from ._kinetostat import Error
from ._progress import Progress, told

__all__ = ["run"]

_PARTS_OF_WORKER = 4
_UNKNOWN_WORKERS = 8


@runtime_checkable
class _Client(Protocol):
    """What is asked of ``distributed.Client``."""

    def get_executor(self, **options: object) -> Executor: ...

    def ncores(self) -> dict[str, int]: ...


def run(
    study: str | PathLike[str],
    workers: _Client | Executor | Callable[[], Executor],
    *,
    out: str | PathLike[str] | None = None,
    parts: int | None = None,
    threads: int = 1,
    retries: int = 3,
    progress: Progress = True,
    stop: Callable[[], bool] = lambda: False,
) -> Path:
    """Computes the study in a folder on `workers` and leaves its results in the folder `out`, which is returned.

    study The folder of the study (or its file), by a name that all workers see. workers A ``distributed.Client``, an
    ``Executor``, or a function that makes one: asked again for another one where a process pool has lost a worker,
    which ends such a pool. out The folder of the results, ``results/NAME`` if it is not given. parts How many parts. If
    it is not given, four for each worker, and no more than the study has pieces. A part should take seconds: handing
    one out takes about a millisecond. threads Threads of each part; 0 for all processors of the worker. retries How
    often another executor is made. Dask hands on by itself what a worker that died had, as often as its setting
    ``distributed.scheduler.allowed-failures`` says. progress Whether a bar of tqdm shows how many parts are there, or
    who is told: done, of how many, what. stop Asked about twice a second: what is not begun is cancelled when it says
    yes, and :class:`Error` raised. Ctrl-C does the same.

    Raises :class:`Error` in the words of the command line; what a part raises, the first one that does.
    """
    name = fspath(Path(study).resolve())
    pieces, in_rounds = _kinetostat.study_pieces(name)
    count = max(1, min(pieces, _PARTS_OF_WORKER * _workers(workers))) if parts is None else parts
    folder = Path(out) if out is not None else Path("results") / _name(name)
    found: list[bytes] = []
    pool = _Pool(workers, retries)
    with told(progress) as tell:
        round_number = 0
        while True:
            round_number += 1
            of = f"parts of round {round_number}" if in_rounds else "parts"

            def hear(done: int, of: str = of) -> None:
                if tell is not None:
                    tell(done, count, of)

            new = _round(pool, (name, count, tuple(found), threads), hear, stop)
            found += new
            if not in_rounds or all(_kinetostat.part_head(part)[3] for part in new):
                break
        _kinetostat.merge_parts(name, found, fspath(folder))
    return folder


def compute_part(study: str, number: int, count: int, before: tuple[bytes, ...], threads: int) -> bytes:
    """Part `number` of `count`, from 1: what a worker does."""
    return _kinetostat.compute_part(study, number, count, list(before), threads)


class _Pool:
    """An executor, made anew where it broke and somebody can make another one."""

    def __init__(self, workers: _Client | Executor | Callable[[], Executor], retries: int) -> None:
        self.retries = retries
        self._make: Callable[[], Executor] | None = None
        if isinstance(workers, _Client):
            # Dask computes again by itself what a worker that died had.
            self.executor = workers.get_executor(pure=False)
        elif isinstance(workers, Executor):
            self.executor = workers
        else:
            self._make = workers
            self.executor = workers()

    def renew(self) -> bool:
        """Whether there is another executor now."""
        if self._make is None:
            return False
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = self._make()
        return True


def _round(
    pool: _Pool,
    asked: tuple[str, int, tuple[bytes, ...], int],
    tell: Callable[[int], object],
    stop: Callable[[], bool],
) -> list[bytes]:
    """All parts of a round, in their order."""
    study, count, before, threads = asked
    found: dict[int, bytes] = {}
    breaks = 0
    pending: dict[Future[bytes], int] = {}
    try:
        while len(found) < count:
            if not pending:
                missing = [number for number in range(1, count + 1) if number not in found]
                submit = pool.executor.submit
                pending = {submit(compute_part, study, number, count, before, threads): number for number in missing}
            done, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
            if stop():
                raise Error(f"stopped after {len(found)} of {count} parts")
            for future in done:
                number = pending.pop(future)
                try:
                    found[number] = future.result()
                except (BrokenProcessPool, CancelledError):
                    # Everything that the pool had is lost; what it had finished is not.
                    finished = {other: k for other, k in pending.items() if other.done() and not other.cancelled()}
                    found |= {k: other.result() for other, k in finished.items() if other.exception() is None}
                    breaks += 1
                    if breaks > pool.retries or not pool.renew():
                        raise
                    pending = {}
                    break
                tell(len(found))
    finally:
        for future in pending:
            future.cancel()
    return [found[number] for number in range(1, count + 1)]


def _workers(workers: object) -> int:
    if hasattr(workers, "ncores"):
        return max(1, len(cast(_Client, workers).ncores()))
    return int(getattr(workers, "_max_workers", None) or os.cpu_count() or _UNKNOWN_WORKERS)


def _name(study: str) -> str:
    path = Path(study)
    return path.name if path.is_dir() else path.parent.name
