"""Studies computed in parts, by the workers of Dask or of any executor of ``concurrent.futures``.

>>> from dask.distributed import Client                                   # doctest: +SKIP
>>> from kinetostat.distributed import run                                # doctest: +SKIP
>>> run("studies/01_workspace_map", Client("tcp://head:8786"), out="map") # doctest: +SKIP

What is left in the folder has the bytes of a run on one machine, whatever the workers, their number and their threads.
A worker that dies takes a part with it, which another one computes; one that comes late gets parts that wait. All
workers must see the study under the same name and have the same build of this package; parts of another are refused.
Finished parts are kept in a folder until the results are written, so that a client that was killed goes on with them.

Clients of ``dask_jobqueue`` and ``dask_mpi`` clusters are such clients; ``mpi4py.futures.MPIPoolExecutor`` and
``concurrent.futures.ProcessPoolExecutor`` are such executors.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Protocol, cast

from . import _kinetostat
from ._kinetostat import Error
from ._progress import Progress, Told, told

__all__ = ["run"]

_PARTS_OF_WORKER = 4
_UNKNOWN_WORKERS = 8


class _Client(Protocol):
    """What is asked of ``distributed.Client``."""

    def get_executor(self, **options: object) -> Executor: ...

    def ncores(self) -> dict[str, int]: ...


def run(
    study: str | PathLike[str],
    workers: _Client | Executor | Callable[[], Executor],
    *,
    out: str | PathLike[str] | None = None,
    grid: int | Sequence[int] | None = None,
    points: int | None = None,
    parts: int | None = None,
    keep: str | PathLike[str] | None = None,
    threads: int = 1,
    retries: int = 3,
    progress: Progress = True,
    stop: Callable[[], bool] = lambda: False,
) -> Path:
    """Computes the study in a folder on `workers` and leaves its results in the folder `out`, which is returned.

    study
        The folder of the study (or its file), by a name that all workers see.
    workers
        A ``distributed.Client``, an ``Executor``, or a function that makes one: asked again for another one where a
        process pool has lost a worker, which ends such a pool.
    out
        The folder of the results, ``results/NAME`` if it is not given.
    grid, points
        Points of a map along x, y, z, and along a circle, in place of those of the study, as in
        :func:`kinetostat.run`.
    parts
        How many parts, no more than the study has pieces. If it is not given, four for each worker, or as many as the
        parts in `keep` are of. A part should take seconds.
    keep
        The folder of finished parts, ``OUT.parts`` if it is not given. The same call goes on with what a client that
        was stopped or killed has left there; parts of another study, grid, build or division are refused. What is in
        it is removed once the results are written.
    threads
        Threads of each part; 0 for all processors of the worker.
    retries
        How often another executor is made. Dask hands on by itself what a worker that died had, as often as its setting
        ``distributed.scheduler.allowed-failures`` says.
    progress
        Whether a bar of tqdm shows how many parts are there, or who is told: done, of how many, what.
    stop
        Asked about twice a second: what is not begun is cancelled when it says yes, and :class:`Error` raised.
        Ctrl-C does the same.

    Raises :class:`Error` in the words of the command line.
    """
    name = fspath(Path(study).resolve())
    counts = (grid,) * 3 if isinstance(grid, int) else grid
    folder = Path(out) if out is not None else Path("results") / _name(name)
    kept_in = Path(keep) if keep is not None else Path(f"{folder.resolve()}.parts")
    kept = _kinetostat.KeptParts.open(name, kept_in, counts, points)
    kept.check_out(folder)
    heads, count = _kept(kept, kept_in, parts, _workers(workers))
    pool = _Pool(workers, retries)
    with told(progress) as tell, pool:
        round_number = 0
        while True:
            round_number += 1
            of = f"parts of round {round_number}" if kept.goes_in_rounds else "parts"
            done = {head[0]: head[3] for head in heads if head[2] == round_number}
            if len(done) < count:
                before = (kept.excerpt(round_number),) if round_number > 1 else ()
                asked = _Asked(name, count, before, threads, counts, points)
                _round(pool, asked, (kept, done), partial(_tell, tell, count, of), stop)
            if not kept.goes_in_rounds or all(done.values()):
                break
    kept.merge(folder)
    kept.remove()
    return folder


def _kept(
    kept: _kinetostat.KeptParts, folder: Path, parts: int | None, workers: int
) -> tuple[list[tuple[int, int, int, bool, int]], int]:
    """Heads of the finished parts in `folder`, and how many parts the study is divided into."""
    if parts is not None and parts < 1:
        raise Error(f"parts: expected at least 1, got {parts}")
    most = max(1, kept.pieces)
    try:
        heads = kept.heads()
    except Error as fault:
        raise Error(f"{fault}; remove the folder {folder}, or name another one as keep") from None
    divisions = sorted({head[1] for head in heads})
    if parts is None and len(divisions) == 1:
        return heads, divisions[0]
    count = min(most, _PARTS_OF_WORKER * workers if parts is None else parts)
    if divisions not in ([], [count]):
        there = " and ".join(str(of) for of in divisions)
        raise Error(
            f"parts: {folder} has some of {there} parts, expected {count}; leave out parts to go on with them, remove "
            "the folder, or name another one as keep"
        )
    return heads, count


def _tell(tell: Told | None, count: int, of: str, done: int) -> None:
    if tell is not None:
        tell(done, count, of)


@dataclass(frozen=True)
class _Asked:
    """What all parts of a round have in common."""

    study: str
    count: int
    before: tuple[bytes, ...]
    threads: int
    grid: Sequence[int] | None
    points: int | None


def compute_part(asked: _Asked, number: int) -> bytes:
    """Part `number` of what is asked, from 1: what a worker does."""
    return _kinetostat.compute_part(
        asked.study, number, asked.count, list(asked.before), asked.threads, asked.grid, asked.points
    )


class _Pool:
    """An executor, made anew where it broke and somebody can make another one."""

    def __init__(self, workers: _Client | Executor | Callable[[], Executor], retries: int) -> None:
        self.retries = retries
        self._make: Callable[[], Executor] | None = None
        if hasattr(workers, "get_executor"):
            # Dask computes again by itself what a worker that died had.
            self.executor = cast(_Client, workers).get_executor(pure=False)
        elif isinstance(workers, Executor):
            self.executor = workers
        else:
            self._make = workers
            self.executor = self._make()

    def __enter__(self) -> _Pool:
        return self

    def __exit__(self, *_: object) -> None:
        # An executor that was given is not ours to end.
        if self._make is not None:
            self.executor.shutdown(wait=False, cancel_futures=True)

    def renew(self) -> bool:
        """Whether there is another executor now."""
        if self._make is None:
            return False
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = self._make()
        return True


def _round(
    pool: _Pool,
    asked: _Asked,
    finished: tuple[_kinetostat.KeptParts, dict[int, bool]],
    tell: Callable[[int], object],
    stop: Callable[[], bool],
) -> None:
    """Computes and keeps the parts of a round that are not done: each with whether nothing is left to a later one."""
    kept, done = finished
    breaks = 0
    pending: dict[Future[bytes], int] = {}
    if done:
        tell(len(done))
    try:
        while len(done) < asked.count:
            if not pending:
                missing = [number for number in range(1, asked.count + 1) if number not in done]
                pending = {pool.executor.submit(compute_part, asked, number): number for number in missing}
            ended, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
            if stop():
                raise Error(f"stopped after {len(done)} of {asked.count} parts")
            for future in ended:
                number = pending.pop(future)
                try:
                    done[number] = kept.keep(future.result())[3]
                except (BrokenProcessPool, CancelledError):
                    # Everything that the pool had is lost; what it had finished is not.
                    others = {other: k for other, k in pending.items() if other.done() and not other.cancelled()}
                    done |= {k: kept.keep(own.result())[3] for own, k in others.items() if own.exception() is None}
                    breaks += 1
                    if breaks > pool.retries or not pool.renew():
                        raise
                    pending = {}
                    break
                tell(len(done))
    finally:
        for future in pending:
            future.cancel()


def _workers(workers: object) -> int:
    if hasattr(workers, "ncores"):
        return max(1, len(cast(_Client, workers).ncores()))
    return int(getattr(workers, "_max_workers", None) or os.cpu_count() or _UNKNOWN_WORKERS)


def _name(study: str) -> str:
    path = Path(study)
    return path.name if path.is_dir() else path.parent.name
