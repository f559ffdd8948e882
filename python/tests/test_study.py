"""Studies asked in Python: maps, placements, study folders; tables, progress, Ctrl-C."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kinetostat
from kinetostat import Error, Machine

ROOT = Path(os.environ.get("REPOSITORY", Path(__file__).resolve().parents[2])).resolve()
PROCESS = {
    "tolerance_mm": 0.5,
    "force": {"path_frame": {"radial_force_N": 215.0, "tangential_force_N": -10.0, "axial_force_N": -25.0}},
}
GROOVE = {"name": "groove", "circle": {"centre_mm": [0.0, 0.0, 0.0], "diameter_mm": 50.0, "points": 13}}
BOX = {"x_mm": [-48.65, 101.35], "y_mm": [-48.65, 101.35], "z_mm": [-73.65, 126.35]}
SEARCH = {"grid": {"x": 3, "y": 3, "z": 3}, "starts": 1, "max_iterations": 5, "tolerance": 1e-2}


@pytest.fixture(scope="module")
def answer() -> kinetostat.Answer:
    return kinetostat.workspace_map(
        Machine("orthoglide"), PROCESS, grid=3, figures=False, progress=False, phi_step_deg=45.0
    )


def test_a_map_and_its_numbers(answer: kinetostat.Answer) -> None:
    table = answer.table("map").where(source="cutting")
    assert answer.table_names == ["map"] and table.rows == 27 and answer.is_complete
    assert table.units["deflection_mm"] == "mm" and table.units["stiffness_min_N_per_mm"] == "N/mm"
    assert answer.summary["rows_solved"] == 81
    machine = Machine("orthoglide")
    row = int(np.argmax(table["deflection_mm"]))
    place = [table[f"{axis}_mm"][row] for axis in "xyz"]
    phi = np.radians(table["deflection_phi_deg"][row])
    # The force of the process turns with the tool angle about the tool, which is along z here.
    turn = np.array([[np.cos(phi), -np.sin(phi), 0.0], [np.sin(phi), np.cos(phi), 0.0], [0.0, 0.0, 1.0]])
    forces = (turn @ np.array([215.0, -10.0, -25.0]), turn.T @ np.array([215.0, -10.0, -25.0]))
    lever = machine.tool_tip_mm
    found = [machine.equilibrium(place, [*force, *np.cross(lever, force)]).distance for force in forces]
    assert min(abs(found - table["deflection_mm"][row])) < 0.1


def test_tables_for_other_libraries(answer: kinetostat.Answer) -> None:
    table = answer.table("map")
    pandas = pytest.importorskip("pandas")
    frame = table.to_pandas()
    assert list(frame.columns) == list(table) and frame.attrs["units"]["x_mm"] == "mm"
    polars = pytest.importorskip("polars")
    assert table.to_polars().shape == (81, len(table))
    pytest.importorskip("pyarrow")
    assert table.to_arrow().schema.field("deflection_mm").metadata == {b"units": b"mm"}
    assert polars.DataFrame(table)["deflection_mm"].to_list() == frame["deflection_mm"].to_list()
    pytest.importorskip("xarray")
    data = table.to_xarray("x_mm", "y_mm", "z_mm", "source")
    assert data.deflection_mm.shape == (3, 3, 3, 3) and data.deflection_mm.attrs == {"units": "mm"}
    row = frame[(frame.source == "all")].iloc[5]
    at = data.sel(x_mm=row.x_mm, y_mm=row.y_mm, z_mm=row.z_mm, source="all")
    assert float(at.deflection_mm) == row.deflection_mm
    with pytest.raises(ValueError, match="several rows have the same x_mm"):
        table.to_xarray("x_mm")
    assert pandas.DataFrame(table.to_pandas()).shape[0] == table.rows


def test_settled_cases_for_other_libraries() -> None:
    pytest.importorskip("xarray")
    pytest.importorskip("pandas")
    machine = Machine("orthoglide")
    found = machine.equilibrium([[0, 0, 0], [9000, 0, 0]], [100.0, 0, 0, 0, 0, 0])
    frame = found.to_pandas()
    assert list(frame.status) == ["solved", "unreachable"] and frame.reason[1].startswith("chain ")
    assert frame.deflection_x_mm[0] == found.deflection[0, 0] and np.isnan(frame.deflection_x_mm[1])
    data = found.to_xarray()
    assert data.drives.attrs == {"units": "mm"} and list(data.drive.values) == machine.drive_names
    assert "chain" in str(data.reason.values[1]) and found.to_polars().shape == frame.shape
    assert "<table>" in found._repr_html_()


def test_an_answer_shows_itself(tmp_path: Path) -> None:
    machine = Machine("orthoglide")
    answer = kinetostat.workspace_map(machine, PROCESS, grid=2, out=tmp_path / "map", progress=False, phi_step_deg=90.0)
    shown = answer._repr_html_()
    assert answer.sentence.split(",")[0] in shown and "data:image/png;base64," in shown
    assert answer.page.is_file() and "answer" in answer.figures and answer.numbers[0][0] in shown


def test_other_numbers_than_those_of_the_file(answer: kinetostat.Answer) -> None:
    machine = Machine("orthoglide")
    stiff = machine.parameters()["leg.rail.stiffness"].value
    assert stiff is not None
    softer = machine.with_parameters({"leg.rail.stiffness": stiff / 3})
    found = kinetostat.workspace_map(softer, PROCESS, grid=3, figures=False, progress=False, phi_step_deg=45.0)
    assert np.all(
        found.table("map").where(source="cutting")["deflection_mm"]
        > answer.table("map").where(source="cutting")["deflection_mm"]
    )


def test_a_machine_of_a_file_and_a_place_for_a_part(tmp_path: Path) -> None:
    # Called as a built-in machine, but another one.
    toml = Machine("orthoglide").toml.replace('name = "orthoglide"', 'name = "mine"')
    own = Machine.from_toml(toml, "orthoglide")
    seen: list[tuple[int, int, str]] = []
    answer = kinetostat.place(
        own,
        GROOVE,
        PROCESS,
        bounds=BOX,
        objective={"weights": {"worst_deflection": 1.0}},
        search=SEARCH,
        figures=False,
        progress=lambda done, total, of: seen.append((done, total, of)),
    )
    assert "machine.toml" in (answer.folder / "manifest.json").read_text()
    table = answer.table("candidates")
    assert table["objective"][0] <= np.nanmin(answer.table("sweep")["objective"])
    assert seen and all(done <= total for done, total, _ in seen)
    with pytest.raises(KeyError, match="there are: candidates"):
        answer.table("nothing")


def test_errors_are_in_the_words_of_the_command_line(tmp_path: Path) -> None:
    with pytest.raises(Error, match=r"study\.toml:\d+: workspace_map.colour: unknown key `colour`"):
        kinetostat.workspace_map(Machine("orthoglide"), PROCESS, grid=2, progress=False, colour="red")
    with pytest.raises(Error, match="nowhere.*cannot be read"):
        kinetostat.run(tmp_path / "nowhere", progress=False)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "map.csv").write_text("mine")
    with pytest.raises(Error, match=r"map\.csv"):
        kinetostat.workspace_map(Machine("orthoglide"), PROCESS, grid=2, out=tmp_path / "out", progress=False)


def test_an_exception_of_who_watches_stops_it() -> None:
    def watch(done: int, total: int, of: str) -> None:
        raise RuntimeError("seen enough")

    with pytest.raises(RuntimeError, match="seen enough"):
        kinetostat.workspace_map(Machine("orthoglide"), PROCESS, grid=21, figures=False, progress=watch)


STOPPED = """
import kinetostat

def tell(done, total, of):
    if done > 4200:
        print("ready", flush=True)

try:
    kinetostat.run("study", "out", grid=19, figures=False, progress=tell)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_stopped_study_goes_on(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "studies" / "01_workspace_map", tmp_path / "study")
    file = tmp_path / "study" / "study.toml"
    file.write_text(file.read_text().replace("phi_step_deg = 10.0", "phi_step_deg = 180.0"))
    with subprocess.Popen([sys.executable, "-c", STOPPED], stdout=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        assert process.stdout.read().splitlines()[-1] == "stopped"
    small = {"grid": 19, "figures": False}
    with pytest.raises(Error, match="unfinished run"):
        kinetostat.run(tmp_path / "study", tmp_path / "out", progress=False, **small)  # type: ignore[arg-type]
    first: list[int] = []
    answer = kinetostat.run(
        tmp_path / "study",
        tmp_path / "out",
        begin="resume",
        progress=lambda done, total, of: first.append(done),
        **small,  # type: ignore[arg-type]
    )
    # The first block was kept.
    assert first[0] >= 4096 and answer.is_complete and answer.table("map").rows == 3 * 19**3
