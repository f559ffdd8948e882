"""A map computed by one and by two workers of Dask, each a process with one thread, beside one process alone; what a
part costs beside its work, and how large it is.

python benches/scaling.py 45          # points along each axis
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import distributed

from kinetostat import _kinetostat
from kinetostat.distributed import run

STUDY = """
schema = 3
question = "How far is the tool from its path over the workspace?"
machine = "orthoglide"
[process]
tolerance_mm = 0.5
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
[workspace_map]
grid = [{n}, {n}, {n}]
slices_z_mm = [0.0]
phi_step_deg = 10.0
"""


def seconds(of: Callable[[], object]) -> float:
    begun = time.perf_counter()
    of()
    return time.perf_counter() - begun


def main() -> None:
    n = int(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "map").mkdir()
        study = folder / "map" / "study.toml"
        study.write_text(STUDY.format(n=n), encoding="utf-8")
        pieces, _ = _kinetostat.study_pieces(str(folder / "map"))
        begun = time.perf_counter()
        whole = _kinetostat.compute_part(str(folder / "map"), 1, 1, [], 1)
        alone = time.perf_counter() - begun
        print(f"{n**3} points, {pieces} pieces")
        print(f"one thread alone: {alone:.1f} s, {1e6 * alone / n**3:.0f} us for each point")
        print(f"all pieces: {len(whole)} bytes, {len(whole) / n**3:.0f} for each point")
        merging = seconds(lambda: _kinetostat.merge_parts(str(folder / "map"), [whole], str(folder / "merged")))
        print(f"made tables and page of: {merging:.1f} s, {1e6 * merging / n**3:.0f} us for each point")
        for workers in (1, 2):
            cluster = distributed.LocalCluster(  # type: ignore[no-untyped-call]
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
            )
            with cluster, distributed.Client(cluster) as client:  # type: ignore[no-untyped-call]
                client.wait_for_workers(workers)  # type: ignore[no-untyped-call]
                # The package is imported before it counts.
                client.run(lambda: __import__("kinetostat"))  # type: ignore[no-untyped-call]
                for parts in sorted({workers, 4 * workers, pieces}):
                    out = folder / f"{workers}_{parts}"
                    took = seconds(
                        lambda out=out, parts=parts, client=client: run(  # type: ignore[misc]
                            folder / "map", client, out=out, parts=parts, progress=False
                        )
                    )
                    computed = took - merging
                    print(f"{workers} workers, {parts} parts: {took:.1f} s, {computed:.1f} s till all parts were there")
        # Parts without work: what a part costs beside it.
        empty = 50
        one = seconds(lambda: _kinetostat.compute_part(str(folder / "map"), pieces + 1, pieces + empty, [], 1))
        print(f"a part without pieces: {1e3 * one:.1f} ms")


if __name__ == "__main__":
    main()
