"""Programs: their points, what the machine does along them, and programs that put it right."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path as FilePath

import numpy as np
import pytest

from kinetostat import Error, Machine, Path, Process

ROOT = FilePath(os.environ.get("REPOSITORY", FilePath(__file__).resolve().parents[2])).resolve()
STUDY = ROOT / "studies" / "02_groove_50mm"
PROGRAM = os.environ.get("KINETOSTAT", "")


@pytest.fixture(scope="module")
def path() -> Path:
    return Path.from_gcode(STUDY / "groove.nc", Process(Machine("orthoglide"), STUDY / "process_program.toml"))


def test_points_of_a_program(path: Path) -> None:
    count = len(path)
    assert path.position.shape == (count, 3) and path.pose.shape == (count, 4, 4) and path.wrench.shape == (count, 6)
    lines = (STUDY / "groove.nc").read_text().splitlines()
    assert "G0" in lines[path.line[0] - 1]
    assert not path.cutting[0] and path.cutting.sum() == path.follow().summary["points"]
    steps = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    # Chords are shorter than arcs.
    assert np.all(steps <= np.diff(path.arc_length) + 1e-9)
    assert path.to_table().units["force_x_N"] == "N"


def test_following_is_commanding_each_point(path: Path) -> None:
    found = path.follow("direct")
    assert found.drives.shape == found.nominal_drives.shape == (len(path), 3)
    assert np.nanmax(found.distance) < 1e-8 and set(found.status) == {"converged"} and found.reasons == {}
    assert path.follow("none").summary["max_mm"] > 1.0


def test_a_program_written_anew(path: Path, tmp_path: FilePath) -> None:
    seen: list[int] = []
    written = path.compensate(progress=lambda done, total, of: seen.append(done))
    # The commands, then without compensation, as written, and as written without the cutting force.
    assert seen[-1] == 4 * len(path)
    assert written.summaries["as_written"]["max_mm"] < 0.01 < written.summaries["none"]["max_mm"]
    assert written.content is not None and written.rounded_mm is not None and written.position is not None
    written.save(tmp_path / "corrected.nc")
    again = Path.from_gcode(tmp_path / "corrected.nc", path.process)
    assert np.abs(again.position[-1] - written.position[-1]).max() < 1e-9


def test_what_a_program_leaves_on_machines_as_they_may_be(path: Path) -> None:
    assert path.compensate().spread is None
    tables = {
        "tolerance_mm": 0.5,
        "placement": {"reference": "platform_point"},
        "force": {"path_frame": {"radial_force_N": 215.0, "tangential_force_N": -10.0, "axial_force_N": -25.0}},
        "uncertainty": {"process": {"force_relative_std": 0.15}},
    }
    uncertain = Path.from_gcode(STUDY / "groove.nc", Process(Machine("orthoglide"), tables))
    written = uncertain.compensate()
    assert written.spread is not None
    plain, left = written.spread["none"], written.spread["as_written"]
    assert 0.0 < left["median_mm"] < left["p95_mm"] < plain["p95_mm"] and 0.0 <= left["within_tolerance"] <= 1.0
    assert 0.0 <= written.spread["worse"] <= 1.0
    with pytest.raises(Error, match="uncertainty: is not computed for following a program"):
        uncertain.follow()


@pytest.mark.skipif(not PROGRAM, reason="KINETOSTAT names no program to hold it against")
def test_a_program_has_the_bytes_of_the_command_line(path: Path, tmp_path: FilePath) -> None:
    out = tmp_path / "by_program.nc"
    process = STUDY / "process_program.toml"
    command = [
        PROGRAM,
        "compensate",
        STUDY / "groove.nc",
        "--machine",
        "orthoglide",
        "--process",
        process,
        "--out",
        out,
    ]
    subprocess.run([str(word) for word in command], check=True, capture_output=True)
    assert path.compensate().content == out.read_bytes()


def test_a_process_that_asks_for_the_best_rotation_about_the_tool_gets_it() -> None:
    machine = Machine("fanuc_r2000ic")
    placed = {"origin_mm": [1900.0, 0.0, 800.0], "pitch_deg": -35.0}
    force = {"path_frame": {"radial_force_N": 300.0, "tangential_force_N": -200.0, "axial_force_N": -150.0}}
    text = "x_mm,y_mm,z_mm,feed_mm_per_min\n0,0,0,600\n8,0,0,600\n8,8,0,600\n"

    def left(redundancy: str) -> float:
        table = {"placement": placed, "force": force, "redundancy": {"gamma": redundancy, "step_deg": 30.0}}
        rms: float = Path.from_text(text, Process(machine, table), "path.csv").follow("none").summary["rms_mm"]
        return rms

    assert left("best_constant") < left("as_programmed")
    # G-code of a machine without rotary axes cannot say how the platform stands.
    table = {"placement": placed, "force": force, "redundancy": {"gamma": "best"}}
    with pytest.raises(Error, match="its rotations about the tool axis cannot be written"):
        Path.from_text("G90 G21\nG1 X0 Y0 Z0 F600\nX8\n", Process(machine, table))


def test_where_there_is_no_command_there_is_no_program(path: Path, tmp_path: FilePath) -> None:
    far = Path.from_text("G90 G21\nG0 X0 Y0 Z0\nG1 X2000 F300\n", path.process)
    written = far.compensate()
    assert written.content is None and written.text is None and len(written.failures) > 0
    assert "None" not in repr(written) and "no command for" in repr(written)
    with pytest.raises(Error, match="there is no program to write: no command for point"):
        written.save(tmp_path / "none.nc")
    assert not (tmp_path / "none.nc").exists()


def test_processes_from_tables_and_what_is_wrong_with_them() -> None:
    machine = Machine("orthoglide")
    force = {"path_frame": {"radial_force_N": 100.0, "tangential_force_N": 0.0, "axial_force_N": 0.0}}
    process = Process(machine, {"placement": {"origin_mm": [0.0, 0.0, 10.0]}, "force": force})
    path = Path.from_text("G90 G21\nG0 X0 Y0 Z0\nG1 X10 F300\n", process, "line.nc")
    assert np.allclose(np.linalg.norm(path.wrench[-1, :3]), 100.0)
    with pytest.raises(Error, match="unknown key `forc`"):
        Process(machine, {"forc": force})
    with pytest.raises(Error, match=r"line\.nc:2:7: `Y=`: expected a number"):
        Path.from_text("G90\nG1 X1 Y=\n", process, "line.nc")


def test_errors_of_chains_stand_in_the_process() -> None:
    turned = Machine("orthoglide").with_parameters({"x.turn": 1.0})
    with pytest.raises(Error, match=r"orthoglide: has errors of its chains .* expected them in \[\[chain_error\]\]"):
        Process(turned, {})
