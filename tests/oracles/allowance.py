#!/usr/bin/env python3
"""python3 allowance.py KINETOSTAT STUDY [RESULTS]

Holds the recommended place of a placement study against paths at the place and at the corners of its allowance. STUDY is the folder of a study of one
feature, RESULTS the folder of its results, which are computed if it is not given. At each of these places the workpiece is put into the process file,
and the feature computed as the path of a study of its own: nothing of the search of places is used.

Fails where a point of the path is not reached, where a metric at a corner is worse than the one told, or where none of them is as bad. Standard library
of Python 3.11 alone.
"""

import argparse
import csv
import itertools
import json
import math
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

# By what share a metric of a path may differ from the one told: both solve the same points, from other ones.
ROUNDING = 1e-6
# What a path may read beside its process.
READ = (".csv", ".stl", ".nc", ".mpf", ".h", ".src", ".mod", ".ls", ".toml")
# Coordinates of a place that always vary where it is clamped; others do where they are sought.
CLAMPED, OTHERS = ("x_mm", "y_mm", "yaw_deg"), ("z_mm", "pitch_deg", "roll_deg")


def corners(placement):
    """By how much coordinates differ from those of the place, mm and degrees: nothing first, then at each corner."""
    allowance = placement.get("allowance", {})
    halves = {"mm": allowance.get("position_mm", 1.0), "deg": allowance.get("angle_deg", 0.5)}
    names = [*CLAMPED, *(name for name in OTHERS if name in placement.get("bounds", {}))]
    signs = itertools.product([-1.0, 1.0], repeat=len(names))
    return [{}, *({name: sign * halves[name.split("_")[1]] for name, sign in zip(names, own)} for own in signs)]


def placed(process, place):
    """The text of a process file with the workpiece at a place."""
    lines, inside, reference = [], False, []
    for line in process.splitlines():
        if line.startswith("["):
            inside = line.strip() == "[placement]"
        if not inside:
            lines.append(line)
        elif line.startswith("reference"):
            reference = [line]
    origin = [place[name] for name in ("x_mm", "y_mm", "z_mm")]
    lines += ["", "[placement]", f"origin_mm = {origin}", f"yaw_deg = {place['yaw_deg']!r}", *reference]
    if place["pitch_deg"] or place["roll_deg"]:
        lines += [f"pitch_deg = {place['pitch_deg']!r}", f"roll_deg = {place['roll_deg']!r}"]
    return "\n".join(lines) + "\n"


def path_of(feature):
    """The table [path] of a feature."""
    if "file" in feature:
        return [f"file = {json.dumps(feature['file'])}"]
    circle = feature["circle"]
    where = [f"{key} = {json.dumps(circle[key])}" for key in ("centre_mm", "centre_point", "diameter_mm", "points") if key in circle]
    return [f"circle = {{ {', '.join(where)} }}"]


def follow(program, folder, study, feature, place):
    """Computes the feature at a place; returns its metrics by the names of summary.json."""
    process = folder / (feature.get("process") or study["process"])
    with tempfile.TemporaryDirectory(prefix="allowance_") as own:
        own = Path(own)
        for file in folder.iterdir():
            if file.suffix in READ and file.name not in ("study.toml", process.name):
                shutil.copy(file, own)
        (own / "process.toml").write_text(placed(process.read_text(), place))
        head = ["schema = 3", 'question = "?"', f"machine = {json.dumps(study['machine'])}", 'process = "process.toml"']
        head += [f"branch = {json.dumps(study['branch'])}"] if "branch" in study else []
        (own / "study.toml").write_text("\n".join([*head, "[path]", *path_of(feature), 'methods = ["none"]', ""]))
        ran = subprocess.run([program, "run", own, "--no-figures", "--points", "all", "--out", own / "out"], capture_output=True, text=True)
        if ran.returncode != 0:
            raise SystemExit(f"{place}: {ran.stdout}{ran.stderr}")
        with open(own / "out/points.csv") as table:
            rows = list(csv.DictReader(table))
        return metrics(rows)


def metrics(rows):
    """The metrics of a path, of its table of points."""
    unsolved = [row for row in rows if row["status"] != "converged"]
    if unsolved or not rows:
        raise SystemExit(f"not solved: {unsolved[:1]}")
    by_source = {source: [row for row in rows if row["source"] == source] for source in ("cutting", "geometry", "all")}
    moved = {source: [vector(row) for row in own] for source, own in by_source.items()}
    largest = lambda beginning: max(abs(float(row[key])) for row in by_source["all"] for key in row if key.startswith(beginning))
    parts = zip(moved["all"], moved["cutting"], moved["geometry"])
    found = {
        "worst_deflection_mm": max(math.hypot(*own) for own in moved["all"]),
        "superposition_error_mm": max(math.dist(both, map(sum, zip(one, other))) for both, one, other in parts),
    }
    columns = rows[0].keys()
    # A table of points does not say where a tool cuts that bears no force, as when it plunges.
    if all(any(float(row[f"cutting_force_{axis}_N"]) for axis in "xyz") for row in by_source["all"]):
        found["rms_deflection_mm"] = rms(by_source["all"])
    # Machines whose drives are of both kinds have these apart.
    if all(key.endswith("_mm") for key in columns if key.startswith("delta_rho_")):
        found |= {"worst_correction_mm": largest("delta_rho_"), "worst_drive_force_N": largest("drive_force_")}
    return found


def rms(rows):
    """The root mean square over the length of a path: half of each way counts to either end."""
    lengths, squares = 0.0, 0.0
    for here, there in zip(rows, rows[1:]):
        length = float(there["arc_length_mm"]) - float(here["arc_length_mm"])
        lengths += length
        squares += 0.5 * length * sum(float(row["displacement_mm"]) ** 2 for row in (here, there))
    return math.sqrt(squares / lengths)


def vector(row):
    return [float(row[f"displacement_{axis}_mm"]) for axis in "xyz"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinetostat", type=Path)
    parser.add_argument("study", type=Path)
    parser.add_argument("results", type=Path, nargs="?")
    asked = parser.parse_args()
    program = asked.kinetostat.resolve()
    study = tomllib.loads((asked.study / "study.toml").read_text())
    [feature] = study["placement"]["feature"]
    with tempfile.TemporaryDirectory(prefix="allowance_") as own:
        results = asked.results or Path(own) / "out"
        if asked.results is None:
            subprocess.run([program, "run", asked.study, "--no-figures", "--quiet", "--out", results], check=True)
        summary = json.loads((results / "summary.json").read_text())
    best = summary["best"]
    [told] = [entry["metrics"] for entry in summary["entries"] if entry["name"] == best["name"]]
    worst, places = {}, corners(study["placement"])
    for corner in places:
        place = {name: value + corner.get(name, 0.0) for name, value in best["place"].items()}
        for name, value in follow(program, asked.study, study, feature, place).items():
            worst[name] = max(worst.get(name, value), value)
    compared = [name for name in worst if name in told]
    wrong = []
    for name in compared:
        is_same = abs(worst[name] - told[name]) <= ROUNDING * abs(told[name])
        print(f"{asked.study.name}: {name} is at most {worst[name]:.9f} at the place and {len(places) - 1} corners, told {told[name]:.9f}")
        wrong += [] if is_same else [name]
    missing = [name for name in study["placement"]["objective"]["weights"] if not any(own.startswith(name) for own in compared)]
    if wrong or missing or not compared:
        print(f"{asked.study.name}: differ: {wrong}, in the objective and not compared: {missing}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
