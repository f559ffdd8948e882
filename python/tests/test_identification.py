"""Numbers found by measuring, and what would be measured: as the commands `identify` and `predict` compute them."""

from __future__ import annotations

import csv
import io
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinetostat
from kinetostat import Error, Identification, Machine, identify, predict

ROOT = Path(os.environ.get("REPOSITORY", Path(__file__).resolve().parents[2])).resolve()
PROGRAM = os.environ.get("KINETOSTAT", "")
MEASURED = ROOT / "src" / "questions" / "identification" / "template" / "measurements.csv"
STUDY = """schema = 3
question = "How stiff are the joints of this arm?"
machine = "fanuc_r2000ic"
[identification]
data = "measurements.csv"
unknowns = ["arm.J*.stiffness"]
loss = "squares"
folds = 5
[[identification.alternative]]
name = "first three joints"
unknowns = ["arm.J1.stiffness", "arm.J2.stiffness", "arm.J3.stiffness"]
"""
JOINTS = "arm.J*.stiffness"
FIRST = {"name": "first three joints", "unknowns": [f"arm.J{k}.stiffness" for k in (1, 2, 3)]}
OTHERS = """pose,J1_deg,J2_deg,J3_deg,J4_deg,J5_deg,J6_deg,force_x_N,force_y_N,force_z_N,displacement_z_mm
a,0,14,-50,0,50,0,500,0,0,
b,10,20,-40,0,50,0,0,0,-500,-1.0
"""


@pytest.fixture(scope="module")
def arm() -> Machine:
    return Machine("fanuc_r2000ic")


@pytest.fixture(scope="module")
def found(arm: Machine) -> Identification:
    return identify(arm, MEASURED, JOINTS, folds=5, alternative=[FIRST], figures=False, progress=False)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study") / "identification"
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    shutil.copy(MEASURED, folder)
    return folder


def columns(file: Path) -> dict[str, NDArray[Any]]:
    rows = list(csv.DictReader(io.StringIO(file.read_text(encoding="utf-8"))))
    read = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return {name: values if name == "pose" else values.astype(np.float64) for name, values in read.items()}


def together(measured: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """The columns of the template as arrays of vectors."""
    drives = np.radians(np.column_stack([measured[f"J{k}_deg"] for k in range(1, 7)]))
    vector = {name: np.column_stack([measured[f"{name}_{axis}_{unit}"] for axis in "xyz"]) for name, unit in LOADED}
    return {"pose": measured["pose"], "drives": drives, **{f"{n}_{u}": vector[n] for n, u in LOADED}}


LOADED = (("force", "N"), ("displacement", "mm"))


def test_identify_computes_what_the_study_does(found: Identification, study: Path, tmp_path: Path) -> None:
    run = kinetostat.run(study, tmp_path / "out", figures=False, progress=False)
    for table in ("parameters", "residuals", "models", "open", "correlations", "patterns"):
        own, other = (answer.folder / f"{table}.csv" for answer in (found, run))
        assert own.read_bytes() == other.read_bytes(), table
    assert found.sentence == run.sentence and found.is_complete


def test_columns_are_a_file(arm: Machine, found: Identification) -> None:
    measured = columns(MEASURED)
    for given in (
        measured,
        together(measured),
        kinetostat.Table("t", [kinetostat.Column(*c) for c in measured.items()]),
    ):
        own = identify(arm, given, JOINTS, folds=5, alternative=[FIRST], figures=False, progress=False)
        # Radians are not degrees to the last digit.
        np.testing.assert_allclose(own.parameters["value"], found.parameters["value"], rtol=1e-9)
        assert list(own.residuals["pose"]) == list(found.residuals["pose"])
    pandas = pytest.importorskip("pandas")
    framed = identify(arm, pandas.read_csv(MEASURED), JOINTS, folds=5, figures=False, progress=False)
    assert list(framed.parameters["value"]) == list(found.parameters["value"])


def test_numbers_their_standard_deviations_and_the_machine_with_them(arm: Machine, found: Identification) -> None:
    table = found.parameters
    assert list(table["parameter"]) == [f"arm.J{k}.stiffness" for k in range(1, 7)]
    known = table["status"] == "identified"
    assert known.any() and all(table["reason"][~known] != "")
    # Intervals of a stiffness are factors: the standard deviation is that of its logarithm, times the value.
    half = np.log(table["high_95"] / table["low_95"])[known] / 2
    quantile = half * table["value"][known] / table["std"][known]
    assert np.allclose(quantile, quantile[0]) and 1.9 < quantile[0] < 2.2
    assert found.machine is not None and found.chain_errors is None
    numbers, before = found.machine.parameters(), arm.parameters()
    for name, value, is_known in zip(table["parameter"], table["value"], known, strict=True):
        assert numbers[name].value == (value if is_known else before[name].value)
        assert (numbers[name].grade == "identified") == is_known
    residuals = found.residuals
    assert residuals.rows == 48
    np.testing.assert_allclose(residuals["residual"], residuals["measured"] - residuals["predicted"], atol=1e-9)


def test_what_a_machine_would_show_leads_back_to_its_numbers(arm: Machine) -> None:
    name = "arm.J2.stiffness"
    before = arm.parameters()[name].value
    assert before is not None
    softer = arm.with_parameters({name: before / 2})
    given = together(columns(MEASURED))
    poses = {key: given[key] for key in ("drives", "force_N")}
    shown = predict(softer, poses)
    assert shown.is_complete and shown.rows == 48 and np.isnan(shown["low_95"]).all()
    loaded = softer.equilibrium_at_drives(
        poses["drives"], np.hstack([poses["force_N"], np.zeros((16, 3))]), at="tip"
    ).deflection
    unloaded = softer.equilibrium_at_drives(poses["drives"]).deflection
    displaced = shown["predicted"].reshape(-1, 3)
    np.testing.assert_allclose(displaced, loaded - unloaded, atol=1e-6)
    again = identify(
        arm, {**poses, "displacement_mm": displaced, "std_mm": 0.01}, [name], figures=False, progress=False
    )
    np.testing.assert_allclose(again.parameters["value"], before / 2, rtol=1e-6)
    assert again.parameters.units == {} and list(again.parameters["unit"]) == [arm.parameters()[name].unit]
    # Numbers that were set and not sought stay.
    other = "arm.J1.stiffness"
    start = arm.with_parameters({other: 2e9})
    displaced = predict(start.with_parameters({name: before / 2}), poses)["predicted"].reshape(-1, 3)
    measured = {**poses, "displacement_mm": displaced, "std_mm": 0.01}
    kept = identify(start, measured, [name], figures=False, progress=False).machine
    assert kept is not None and kept.parameters()[other].value == 2e9


def test_predictions_by_what_was_identified(found: Identification, study: Path, tmp_path: Path) -> None:
    (tmp_path / "others.csv").write_text(OTHERS, encoding="utf-8")
    answer = predict(found, tmp_path / "others.csv")
    assert list(answer["reading"]) == [f"displacement_{axis}_mm" for axis in "xyz"] + ["displacement_z_mm"]
    assert list(answer["pose"]) == ["a", "a", "a", "b"] and set(answer["status"]) == {"solved"}
    assert (answer["low_95"] < answer["predicted"]).all() and (answer["predicted"] < answer["high_95"]).all()
    assert np.isnan(answer["measured"][:3]).all() and answer["measured"][3] == -1.0
    assert answer.words.startswith("1 length read: predicted to") and answer.words in repr(answer)
    by_columns = predict(found, columns_of_others())
    by_study = predict(study, tmp_path / "others.csv")
    for other in (by_columns, by_study):
        assert all(np.array_equal(answer[name], other[name], equal_nan=name == "measured") for name in answer)


def columns_of_others() -> dict[str, Any]:
    rows = list(csv.DictReader(io.StringIO(OTHERS)))
    return {name: [row[name] if name == "pose" else float(row[name] or "nan") for row in rows] for name in rows[0]}


@pytest.mark.skipif(not PROGRAM, reason="KINETOSTAT names no program to hold it against")
def test_predictions_are_those_of_the_command_line(found: Identification, study: Path, tmp_path: Path) -> None:
    poses = tmp_path / "others.csv"
    poses.write_text(OTHERS, encoding="utf-8")
    done = subprocess.run([PROGRAM, "predict", study, "--poses", poses], capture_output=True, text=True, check=True)
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    answer = predict(found, poses)
    assert list(rows[0]) == list(answer) and done.stderr.strip() == answer.words
    np.testing.assert_allclose([float(row["low_95"]) for row in rows], answer["low_95"], rtol=1e-9)


def test_what_cannot_be_predicted_is_a_row(arm: Machine) -> None:
    poses = {"drives": np.zeros((2, 6)), "force_x_N": [10.0, 1e9]}
    answer = predict(arm, poses)
    assert not answer.is_complete and answer["status"][0] == "solved" and answer["status"][-1] != "solved"
    assert answer["reason"][-1] and np.isnan(answer["predicted"][-1])


def test_the_example_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    section = (ROOT / "docs" / "python.md").read_text(encoding="utf-8").split("## Numbers by measuring")[1]
    code = re.search(r"```python\n(.*?)```", section, re.DOTALL)
    assert code is not None
    names: dict[str, Any] = {}
    exec(compile(code[1], "python.md", "exec"), names)
    stiffness, high = capsys.readouterr().out.splitlines()
    assert abs(float(stiffness.strip("[]")) / 1e9 - 1) < 0.01 and len(high.strip("[]").split()) == 3
    assert names["found"].machine.parameters()["arm.J2.stiffness"].grade == "identified"


def test_errors_name_the_argument(arm: Machine, found: Identification, tmp_path: Path) -> None:
    measured = columns(MEASURED)
    small: dict[str, Any] = {"figures": False, "progress": False}
    with pytest.raises(Error, match=r"^unknowns\[0\]: .*arm\.J9\.stiffness"):
        identify(arm, measured, ["arm.J9.stiffness"], **small)
    with pytest.raises(Error, match=r"^std_mm: .*got -1"):
        identify(arm, measured, JOINTS, std_mm=-1.0, **small)
    with pytest.raises(Error, match=r"^prior\[0\]\.parameter: \"arm\.x\" is none of the unknowns"):
        identify(arm, measured, JOINTS, prior=[{"parameter": "arm.x", "std": 1.0}], **small)
    with pytest.raises(Error, match=r"^measurements: force: unknown column; expected any of arm_J1_deg"):
        identify(arm, {**measured, "force": measured["force_x_N"]}, JOINTS, **small)
    missing = {**measured, "J3_deg": np.where(np.arange(16) == 4, np.nan, measured["J3_deg"])}
    with pytest.raises(Error, match=r"^measurements, row 4: J3_deg: "):
        identify(arm, missing, JOINTS, **small)
    with pytest.raises(Error, match=r"^poses, row 1: J1_deg: must be a number, got `inf`"):
        predict(found, {**columns_of_others(), "J1_deg": [0.0, np.inf]})
    with pytest.raises(Error, match=r"^measurements: .*nowhere\.csv\" is not a file"):
        identify(arm, tmp_path / "nowhere.csv", JOINTS, **small)
    with pytest.raises(Error, match="nowhere.csv"):
        predict(arm, tmp_path / "nowhere.csv")
    with pytest.raises(Error, match=r"expected one with \[identification\]"):
        predict(ROOT / "studies" / "01_workspace_map", tmp_path / "nowhere.csv")
    with pytest.raises(ValueError, match=r"^measurements: force_N: expected the shape \[n, 3\], got \[16, 2\]"):
        identify(arm, {"drives": np.zeros((16, 6)), "force_N": np.zeros((16, 2))}, JOINTS)
    with pytest.raises(ValueError, match=r"^poses: force_x_N: expected 2 values, as many as pose has, got 3"):
        predict(arm, {**columns_of_others(), "force_x_N": [1.0, 2.0, 3.0]})
    with pytest.raises(ValueError, match=r"^poses: loads: expected the shape \[n\]"):
        predict(arm, {"loads": np.zeros((2, 2))})
