"""Studies in parts: the bytes of one run, whatever becomes of the workers."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

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
    # Exactly placed: the few places lie on the bounds, where none can be cut with an allowance.
    text += "\n[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0\n"
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


class Counted(Executor):
    """Threads, and what they are asked for: part numbers, and bytes that a worker elsewhere would be sent."""

    def __init__(self, threads: int = 2) -> None:
        self.numbers: list[int] = []
        self.sent: list[int] = []
        self._pool = ThreadPoolExecutor(threads)

    def submit(self, call: Any, /, asked: Any, number: int) -> Future[Any]:  # type: ignore[override]
        self.numbers.append(number)
        self.sent.append(len(pickle.dumps((asked, number))))
        return self._pool.submit(call, asked, number)


def test_grid_and_points_are_those_of_a_run_and_parts_are_no_more_than_pieces(study: Path, tmp_path: Path) -> None:
    kinetostat.run(study, out=tmp_path / "whole", grid=(4, 3, 2), progress=False)
    workers = Counted()
    out = run(study, workers, out=tmp_path / "out", grid=(4, 3, 2), parts=1000, progress=False)
    assert contents(out) == contents(tmp_path / "whole")
    pieces, _ = _kinetostat.study_pieces(study, (4, 3, 2))
    assert sorted(workers.numbers) == list(range(1, pieces + 1)) and pieces < 12
    for wrong in ({"points": 7}, {"grid": 0}):
        with pytest.raises(kinetostat.Error) as one:
            kinetostat.run(study, tmp_path / "none", progress=False, **wrong)  # type: ignore[arg-type]
        with pytest.raises(kinetostat.Error) as other:
            run(study, workers, out=tmp_path / "none", progress=False, **wrong)  # type: ignore[arg-type]
        assert str(one.value) == str(other.value)
    with pytest.raises(kinetostat.Error, match="^parts: expected at least 1, got 0"):
        run(study, workers, out=tmp_path / "none", parts=0, progress=False)


KILLED = """
import sys, time
from concurrent.futures import ThreadPoolExecutor
from kinetostat.distributed import run

def tell(done, total, of):
    print(done, of, flush=True)
    if done == {after} and of == {of!r}:
        time.sleep(600)

run(sys.argv[1], ThreadPoolExecutor(1), out=sys.argv[2], parts={parts}, progress=tell)
"""


def killed(study: Path, out: Path, parts: int, after: int, of: str) -> None:
    """Runs a client and kills it when so many parts are there."""
    script = KILLED.format(parts=parts, after=after, of=of)
    command = [sys.executable, "-c", script, os.fspath(study), os.fspath(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        assert any(line == f"{after} {of}\n" for line in client.stdout)
        client.send_signal(signal.SIGKILL)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_client_that_was_killed_goes_on(study: Path, whole: dict[str, bytes], tmp_path: Path) -> None:
    out = tmp_path / "out"
    killed(study, out, 6, 4, "parts")
    kept = {file.name for file in (tmp_path / "out.parts").iterdir() if file.suffix == ".kpart"}
    # One thread was at the next part when its client was killed.
    assert len(kept) == 4
    told: list[tuple[int, int, str]] = []
    workers = Counted()
    # As many parts as there were, whatever the number of workers.
    run(study, workers, out=out, progress=lambda *now: told.append(now))
    assert len(workers.numbers) == 2
    assert kept.isdisjoint(f"part_{number:04}_of_0006.kpart" for number in workers.numbers)
    assert told == [(4, 6, "parts"), (5, 6, "parts"), (6, 6, "parts")]
    assert contents(out) == whole
    assert not (tmp_path / "out.parts").exists()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_client_that_was_killed_in_a_later_round_goes_on(placement: Path, tmp_path: Path) -> None:
    kinetostat.run(placement, out=tmp_path / "whole", progress=False)
    killed(placement, tmp_path / "out", 2, 1, "parts of round 3")
    told: list[tuple[int, int, str]] = []
    out = run(placement, Counted(), out=tmp_path / "out", parts=2, progress=lambda *now: told.append(now))
    assert told[0] == (1, 2, "parts of round 3")
    assert contents(out) == contents(tmp_path / "whole")


def test_parts_of_something_else_are_refused(study: Path, tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    stopped = [False]

    def tell(*_: object) -> None:
        stopped[0] = True

    def begun(**options: Any) -> None:
        with pytest.raises(kinetostat.Error, match="stopped after"):
            run(study, Counted(1), out=tmp_path / "out", keep=kept, progress=tell, stop=lambda: stopped[0], **options)

    begun(parts=6)
    there = contents(kept)
    assert there
    with pytest.raises(kinetostat.Error, match=r"other inputs: .*grid.*; remove the folder .*kept, or name another"):
        run(study, Counted(), out=tmp_path / "out", keep=kept, grid=(4, 3, 2), progress=False)
    with pytest.raises(kinetostat.Error, match=r"^parts: .*kept has some of 6 parts, expected 5; leave out parts"):
        run(study, Counted(), out=tmp_path / "out", keep=kept, parts=5, progress=False)
    (tmp_path / "out" / "map.csv").write_text("mine")
    with pytest.raises(kinetostat.Error, match=r"map\.csv"):
        run(study, Counted(), out=tmp_path / "out", keep=kept, progress=False)
    assert contents(kept) == there
    (kept / "mine.txt").write_text("mine")
    (tmp_path / "out" / "map.csv").unlink()
    run(study, Counted(), out=tmp_path / "out", keep=kept, progress=False)
    # What is not ours stays.
    assert os.listdir(kept) == ["mine.txt"]


def test_a_part_of_something_else_is_refused_and_not_kept(study: Path, tmp_path: Path) -> None:
    part = _kinetostat.compute_part(study, 1, 2, [], 1)
    other = _kinetostat.KeptParts.open(study, tmp_path / "kept", (4, 3, 2), None)
    with pytest.raises(kinetostat.Error, match="a part that was computed: is a part of superposition and was computed"):
        other.keep(part)
    with pytest.raises(kinetostat.Error, match="cut short or damaged"):
        other.keep(part[:-1])
    assert other.heads() == [] and not list(tmp_path.glob("kept/*"))


def test_rounds_of_a_placement_are_sent_what_they_need(placement: Path, tmp_path: Path) -> None:
    study, parts = os.fspath(placement), 4
    own = _kinetostat.KeptParts.open(study, tmp_path / "kept", None, None)
    everything: list[bytes] = []
    sent = all_found = 0
    rounds = 0
    while True:
        rounds += 1
        before = [own.excerpt(rounds)] if rounds > 1 else []
        sent += parts * sum(len(part) for part in before)
        all_found += parts * sum(len(part) for part in everything)
        new = [_kinetostat.compute_part(study, number, parts, before, 1) for number in range(1, parts + 1)]
        heads = [own.keep(part) for part in new]
        everything += new
        if all(head[3] for head in heads):
            break
    print(f"{rounds} rounds: {sent} bytes sent, {all_found} with all that was found")
    assert sent < 0.3 * all_found
    own.merge(tmp_path / "out")
    kinetostat.run(placement, out=tmp_path / "whole", progress=False)
    assert contents(tmp_path / "out") == contents(tmp_path / "whole")
    with pytest.raises(kinetostat.Error, match=f"is what round {rounds} needs of the parts before: expected parts"):
        _kinetostat.merge_parts(study, before, tmp_path / "none")


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
