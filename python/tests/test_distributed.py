"""Studies in parts: the bytes of one run, whatever becomes of the workers."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

import kinetostat
from kinetostat import _kinetostat
from kinetostat.distributed import run

distributed = pytest.importorskip("distributed")

STUDY = """
schema = 3
question = "May they be added?"
machine = "orthoglide"
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
[[process.chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
[superposition]
grid = [8, 6, 4]
slices_z_mm = [0.0]
phi_step_deg = 20.0
tolerance_mm = 0.01
location = []
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("studies") / "superposition"
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def whole(study: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    out = tmp_path_factory.mktemp("whole")
    kinetostat.run(study, out=out, progress=False)
    return contents(out)


@pytest.fixture
def placement(tmp_path: Path) -> Path:
    studies = Path(os.environ.get("REPOSITORY", Path(__file__).parents[2])) / "studies" / "03_placement_circle"
    folder = tmp_path / "circle"
    folder.mkdir()
    (folder / "process.toml").write_bytes((studies / "process.toml").read_bytes())
    text = (studies / "study.toml").read_text(encoding="utf-8")
    for old, new in [
        ("{ x = 9, y = 9, z = 5 }", "{ x = 3, y = 3, z = 2 }"),
        ("starts = 3", "starts = 1"),
        ("max_iterations = 80", "max_iterations = 4"),
        ("points = 121", "points = 25"),
    ]:
        assert old in text
        text = text.replace(old, new)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


@pytest.fixture
def cluster() -> Iterator[distributed.LocalCluster]:
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        yield cluster


def test_dask_gives_the_bytes_of_one_run_though_a_worker_is_killed_and_another_comes_late(
    study: Path, whole: dict[str, bytes], cluster: distributed.LocalCluster, tmp_path: Path
) -> None:
    told: list[tuple[int, int, str]] = []
    killed: list[int] = []
    with distributed.Client(cluster) as client, distributed.get_task_stream(client) as stream:

        def watch(done: int, total: int, of: str) -> None:
            told.append((done, total, of))
            if done == 1:
                # One comes late ...
                cluster.scale(2)
                client.wait_for_workers(2)
            if done == 4:
                # ... and one dies in the middle of a part.
                pid = next(iter(client.run(os.getpid).values()))
                killed.append(pid)
                os.kill(pid, signal.SIGKILL)

        out = run(study, client, out=tmp_path / "out", parts=12, progress=watch)
        workers = {task["worker"] for task in stream.data} if stream.data else set()
    assert contents(out) == whole
    assert len(killed) == 1
    assert told == [(done, 12, "parts") for done in range(1, 13)]
    assert len(workers) != 1, workers


def test_a_process_pool_that_lost_a_worker_is_made_anew(study: Path, whole: dict[str, bytes], tmp_path: Path) -> None:
    pools: list[ProcessPoolExecutor] = []

    def pool() -> Executor:
        pools.append(ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")))
        return pools[-1]

    def watch(done: int, total: int, of: str) -> None:
        if done == 2 and len(pools) == 1:
            os.kill(next(iter(pools[0]._processes)), signal.SIGKILL)

    out = run(study, pool, out=tmp_path / "out", parts=6, progress=watch)
    assert contents(out) == whole
    assert len(pools) == 2
    for own in pools:
        own.shutdown()


def test_rounds_of_a_placement_are_the_whole_placement(placement: Path, tmp_path: Path) -> None:
    kinetostat.run(placement, out=tmp_path / "whole", progress=False)
    rounds: set[str] = set()
    with ThreadPoolExecutor(2) as pool:
        told = lambda done, total, of: rounds.add(of)  # noqa: E731
        out = run(placement, pool, out=tmp_path / "out", parts=2, progress=told)
    assert contents(out) == contents(tmp_path / "whole")
    assert "parts of round 2" in rounds


def test_what_is_refused_is_said_and_what_is_stopped_ends(study: Path, tmp_path: Path) -> None:
    parts = [_kinetostat.compute_part(os.fspath(study), number, 3, [], 1) for number in (1, 2, 3)]
    assert _kinetostat.part_head(parts[1]) == (2, 3, 1, False, 4)
    assert _kinetostat.study_pieces(os.fspath(study)) == (12, False)
    out = os.fspath(tmp_path / "out")
    with pytest.raises(kinetostat.Error, match=r"part 2 of 3: is missing: expected all 3, got 2"):
        _kinetostat.merge_parts(os.fspath(study), [parts[0], parts[2]], out)
    with pytest.raises(kinetostat.Error, match=r"bytes 1: is cut short or damaged"):
        _kinetostat.merge_parts(os.fspath(study), [parts[0], parts[1][:-1], parts[2]], out)
    with pytest.raises(kinetostat.Error, match=r"of 3 expected a part from 1 to 3, got 4"):
        _kinetostat.compute_part(os.fspath(study), 4, 3, [], 1)
    begun = threading.Event()
    with (
        ThreadPoolExecutor(1) as pool,
        pytest.raises(kinetostat.Error, match=r"stopped after [1-5] of 6 parts"),
    ):
        run(study, pool, out=out, parts=6, progress=lambda *_: begun.set(), stop=begun.is_set)
