"""Studies run through Python have the bytes that the program leaves: `KINETOSTAT` names it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import kinetostat

ROOT = Path(os.environ.get("REPOSITORY", Path(__file__).resolve().parents[2])).resolve()
PROGRAM = os.environ.get("KINETOSTAT", "")
STUDIES = sorted(folder.name for folder in (ROOT / "studies").iterdir() if (folder / "study.toml").is_file())
# Those whose size is that of a program.
WHOLE = {"09_robot_part_path", "10_five_axis"}


def reduced(study: str, into: Path) -> tuple[Path, dict[str, int]]:
    """A copy of the study with short programs and searches, and by what else it is made small."""
    # Studies name files of others.
    shutil.copytree(ROOT / "studies", into / "studies")
    folder = into / "studies" / study
    file = folder / "study.toml"
    text = file.read_text()
    text = re.sub(r"^starts = \d+", "starts = 1", text, flags=re.MULTILINE)
    text = re.sub(r"^max_iterations = \d+", "max_iterations = 2", text, flags=re.MULTILINE)
    file.write_text(text)
    for program in (*folder.glob("pocket.nc"), *folder.glob("pocket.src"), *folder.glob("cone.nc")):
        lines = program.read_text().splitlines(keepends=True)
        program.write_text("".join(lines[:16] + lines[-2:]))
    if "[placement" in text or "[workspace_map" in text or "[superposition" in text:
        return folder, {"grid": 2}
    return folder, {} if study in WHOLE else {"points": 7}


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


@pytest.mark.skipif(not PROGRAM, reason="KINETOSTAT names no program to hold it against")
@pytest.mark.parametrize("study", STUDIES)
def test_a_study_has_the_bytes_of_the_command_line(study: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, small = reduced(study, tmp_path)
    # The same name of the study in both, as their manifests have it.
    monkeypatch.chdir(tmp_path)
    name, figures = folder.relative_to(tmp_path), study in ("01_workspace_map", "02_groove_50mm")
    options = [text for key, value in small.items() for text in (f"--{key}", str(value))]
    command = [PROGRAM, "run", str(name), *options, "--out", "by_program", *([] if figures else ["--no-figures"])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert "manifest.json" in os.listdir("by_program"), done.stderr
    answer = kinetostat.run(name, "by_python", figures=figures, progress=False, **small)  # type: ignore[arg-type]
    one, other = contents(Path("by_program")), contents(answer.folder)
    assert list(one) == list(other)
    assert [name for name in one if one[name] != other[name]] == []
    assert answer.sentence.split()[0] in done.stdout
