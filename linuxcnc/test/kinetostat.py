"""What kinetostat itself commands: the program is asked, not the functions it generated."""

import csv
import pathlib
import subprocess

POLYLINE = "x_mm y_mm z_mm force_x_N force_y_N force_z_N moment_x_Nmm moment_y_Nmm moment_z_Nmm".split()
STUDY = """schema = 3
question = "What are the drives told?"
machine = "orthoglide"
process = "process.toml"

[path]
file = "path.csv"
"""
PROCESS = """
[force]
from_path = true

[sampling]
max_segment_mm = 10000.0
"""


def drives(program, process, folder, places, loads):
    """Nominal and corrected drives, mm, with the tool tip at each of `places` under each of `loads`: a path study in `folder`."""
    folder = pathlib.Path(folder)
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY)
    (folder / "process.toml").write_text(pathlib.Path(process).read_text() + PROCESS)
    with open(folder / "path.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(POLYLINE)
        table.writerows([*map(repr, place), *map(repr, load)] for place, load in zip(places, loads))
    subprocess.run([program, "run", folder, "--out", folder / "out", "--no-figures"], check=True, stdout=subprocess.DEVNULL)
    with open(folder / "out" / "points.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["source"] == "all"]
    if len(rows) != len(places) or any(row["status"] != "converged" for row in rows):
        raise SystemExit(f"kinetostat solved {len(rows)} points of {len(places)}, or not all of them: see {folder}/out/points.csv")
    read = lambda kind: [tuple(float(row[f"rho_{kind}_{drive}_mm"]) for drive in "xyz") for row in rows]
    return read("nominal"), read("compensated")
