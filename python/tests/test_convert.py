"""Studies and process files get the keys of now by ``packaging/convert.py``; what is neither stays."""

import os
import subprocess
import sys
from pathlib import Path

CONVERT = Path(os.environ.get("REPOSITORY", Path(__file__).parents[2])) / "packaging" / "convert.py"

OLD = """# A study.
schema = 2  # of version 2
question = "How far, [held] or not? departure = 3, turn_step_deg = 4"
machine = "cell.toml"
[held]
rail = 100.0  # departure of the rail
[[validation.quoted]]
quantity = "departure"
[placement.objective]
weights = { departure = 1.0, worst_residual = 2.0 }
pareto = ["departure", "worst_residual"]
"""
NEW = """# A study.
schema = 3  # of version 2
question = "How far, [held] or not? departure = 3, turn_step_deg = 4"
machine = "cell.toml"
[locked]
rail = 100.0  # departure of the rail
[[validation.quoted]]
quantity = "superposition_error"
[placement.objective]
weights = { superposition_error = 1.0, worst_residual = 2.0 }
pareto = ["superposition_error", "worst_residual"]
"""


def converted(path: Path, *options: str) -> tuple[int, str]:
    done = subprocess.run([sys.executable, CONVERT, *options, path], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_a_study_of_version_2_becomes_one_of_version_3(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(OLD, encoding="utf-8")
    assert converted(study) == (0, f"{study}: changed\n")
    assert study.read_text(encoding="utf-8") == NEW
    assert converted(study) == (0, f"{study}: nothing to change\n")
    assert study.read_text(encoding="utf-8") == NEW


PROCESS_OLD = """schema = 1 # redundancy = "best"
[tool_turn] # tool_turn
redundancy = "best" # redundancy
cost = "deflection"
[gcode]
dialect = "iso"
"""
PROCESS_NEW = """schema = 1 # redundancy = "best"
[redundancy] # tool_turn
gamma = "best" # redundancy
cost = "deflection"
[gcode]
dialect = "iso"
"""


def test_process_files_and_studies_with_one_get_the_keys_of_now(tmp_path: Path) -> None:
    process = tmp_path / "process.toml"
    head = 'schema = 3\nquestion = "q"\n'
    inner = PROCESS_OLD.removeprefix("schema = 1 ").replace("[", "[process.")
    cases = [
        (PROCESS_OLD, PROCESS_NEW),
        ("schema = 1\ntool_turn = { redundancy = 'best' }\n", "schema = 1\nredundancy = { gamma = 'best' }\n"),
        ("schema = 1\ntool_turn.redundancy = 'best'\n", "schema = 1\nredundancy.gamma = 'best'\n"),
        ("schema = 1\n[redundancy]\nredundancy = 'best'\n", "schema = 1\n[redundancy]\ngamma = 'best'\n"),
        (head + inner, head + PROCESS_NEW.removeprefix("schema = 1 ").replace("[", "[process.")),
        (head.replace("3", "2") + inner, head + PROCESS_NEW.removeprefix("schema = 1 ").replace("[", "[process.")),
    ]
    for old, new in cases:
        process.write_text(old, encoding="utf-8")
        assert converted(process) == (0, f"{process}: changed\n")
        assert process.read_text(encoding="utf-8") == new
        assert converted(process) == (0, f"{process}: nothing to change\n")


def test_what_is_no_file_of_ours_or_doubtful_stays(tmp_path: Path) -> None:
    machine = tmp_path / "machine.toml"
    for text in ("schema = 7\n", "a = 1\n", "not TOML"):
        machine.write_text(text, encoding="utf-8")
        code, said = converted(machine)
        assert code == 1
        assert "left as it is" in said
        assert machine.read_text(encoding="utf-8") == text
    for text in (
        "schema = 1\ntool_turn = 5\n",
        'schema = 2\nquestion = "q"\nturn_map = 5\n',
        "schema = 1\n[[tool_turn]]\n",
    ):
        machine.write_text(text, encoding="utf-8")
        assert converted(machine)[0] == 1 and machine.read_text(encoding="utf-8") == text
    doubts = PROCESS_OLD.replace("[tool_turn]", '["tool_turn"]')
    machine.write_text(doubts, encoding="utf-8")
    assert "change it by hand" in converted(machine)[1]
    assert machine.read_text(encoding="utf-8") == doubts
    doubtful = tmp_path / "doubtful.toml"
    doubtful.write_text(OLD.replace("[held]\nrail = 100.0", 'held."rail" = """\n[held]\n"""'), encoding="utf-8")
    before = doubtful.read_bytes()
    code, said = converted(doubtful)
    assert code == 1
    assert "change it by hand" in said
    assert doubtful.read_bytes() == before
    code, said = converted(tmp_path / "none.toml")
    assert code == 2
    assert "none.toml" in said


def test_columns_of_results_get_their_names(tmp_path: Path) -> None:
    table = tmp_path / "points.csv"
    table.write_text(
        "x_mm,error_left_mm,departure_x_mm,status,turn_pocket_deg\n1,2,3,given_up,departure\n", encoding="utf-8"
    )
    assert converted(table, "--columns")[0] == 0
    head = "x_mm,residual_error_mm,superposition_error_x_mm,status,gamma_pocket_deg"
    assert table.read_text(encoding="utf-8") == f"{head}\n1,2,3,pruned,departure\n"
