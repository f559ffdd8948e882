"""Parts of studies as bytes, and what is merged of them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import kinetostat
from kinetostat import Error, _kinetostat

ROOT = Path(os.environ.get("REPOSITORY", Path(__file__).resolve().parents[2])).resolve()
MAP = ROOT / "studies" / "01_workspace_map"


def test_parts_in_any_order_have_the_bytes_of_a_run(tmp_path: Path) -> None:
    grid = (3, 3, 2)
    pieces, in_rounds = _kinetostat.study_pieces(MAP, grid)
    assert pieces >= 1 and not in_rounds
    parts = [_kinetostat.compute_part(MAP, k, 2, [], 1, grid) for k in (2, 1)]
    assert [_kinetostat.part_head(part)[:3] for part in parts] == [(2, 2, 1), (1, 2, 1)]
    _kinetostat.merge_parts(MAP, parts, tmp_path / "merged", grid)
    kinetostat.run(MAP, tmp_path / "whole", grid=grid, progress=False)
    whole, merged = ({f.name: f.read_bytes() for f in (tmp_path / name).iterdir()} for name in ("whole", "merged"))
    assert whole == merged


def test_parts_that_are_missing_or_damaged_are_refused(tmp_path: Path) -> None:
    part = _kinetostat.compute_part(MAP, 1, 2, [], 1, (2, 2, 2))
    with pytest.raises(Error, match="2"):
        _kinetostat.merge_parts(MAP, [part], tmp_path / "merged", (2, 2, 2))
    with pytest.raises(Error, match="bytes 0"):
        _kinetostat.part_head(part[:-3])
    with pytest.raises(Error, match="part: "):
        _kinetostat.compute_part(MAP, 3, 2)
