"""The Markdown tables of `run.sh` from the files in its folder: what an equilibrium costs, and how displacements differ."""

import json
import os
import platform
import sys
from pathlib import Path

import numpy as np

PEERS = ["numpy_vjm", "pynite_frame", "opensees_frame", "exudyn_springs"]
ALONE = "one at a time, from the rigid machine"
BASE = "one at a time, from the last tool angle"
# Nearest to beams: others are held against it too.
FINEST = ("OpenSees", "corotational beams, 8 elements per beam")
ANGLES_DEG = [0, 45, 90, 135, 180, 225, 270, 315]


def row(*cells):
    print("| " + " | ".join(cells) + " |")


def number(value):
    """Three digits."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.processor()


def displacements(point, share, machine="tool_displacement_mm"):
    kept = [i for i, case in enumerate(point["cases"]) if case["load_share"] == share]
    return kept, np.array([point["cases"][i][machine] for i in kept])


def difference(point, peer, share):
    """Largest |difference| over |displacement| of the tool over the tool angles."""
    kept, ours = displacements(point, share)
    theirs = np.array(peer["tool_displacements_mm"])[kept]
    return max(np.linalg.norm(theirs - ours, axis=1) / np.linalg.norm(ours, axis=1))


def cost_row(program, model, results, base, agreement):
    per_solve = [number(r["solve_us"]) for r in results]
    ratios = [number(r["solve_us"] / b) for r, b in zip(results, base)]
    new_place = " / ".join(number(r["new_place_us"]) for r in results if "new_place_us" in r)
    inside = " / ".join(f"{100 * r['inside_share']:.0f} %" for r in results if "inside_share" in r)
    iterations = " / ".join("linear" if r["iterations"] is None else f"{r['iterations']:.1f}" for r in results)
    iterations = "linear" if "linear" in iterations else iterations
    row(program, model, " / ".join(per_solve), " / ".join(ratios), inside, iterations, new_place, *agreement)


def main():
    folder = Path(sys.argv[1])
    ours = json.loads((folder / "ours.json").read_text())
    points = ours["points"]
    peers = []
    missing = []
    for name in PEERS:
        path = folder / f"{name}.json"
        if path.exists():
            peers.append(json.loads(path.read_text()))
        else:
            missing.append(name)
    names = " / ".join(point["name"] for point in points)
    print(f"{processor()}, {os.cpu_count()} cores, one used; Python {platform.python_version()}. Cells: {names}.\n")

    row(
        "program",
        "model",
        "µs per equilibrium",
        "times ours",
        "of it in the solver's call",
        "Newton iterations",
        "µs at a new place",
        "differs, full load",
        "differs, 1/1000 load",
    )
    row(*["---"] * 9)
    times = [point["times"] for point in points]
    for point, of_point in zip(points, times):
        for time in of_point:
            if time["how"] == ALONE:
                time["new_place_us"] = point["setup_us"] + time["solve_us"]
    base = [next(t["solve_us"] for t in of_point if t["how"] == BASE) for of_point in times]
    for results in zip(*times):
        cost_row("kinetostat", results[0]["how"], results, base, ["", ""])
    for peer in peers:
        for model in peer["models"]:
            agreement = [
                " / ".join(f"{difference(*pair, share):.1e}" for pair in zip(points, model["points"]))
                for share in (1.0, 1e-3)
            ]
            cost_row(peer["program"], model["model"], model["points"], base, agreement)
    for name in missing:
        row(name, "did not run", *[""] * 7)

    models = [(peer["program"].split()[0], model) for peer in peers for model in peer["models"]]
    print("\nTool displacement at full load in mm and, by program, how far another one's tool is from ours (last rows: from others), in µm:\n")
    row("point, tool angle", "kinetostat, mm", *(f"{program}: {model['model']}" for program, model in models))
    row(*["---"] * (2 + len(models)))
    for i, point in enumerate(points):
        kept, moved = displacements(point, 1.0)
        for k, displacement in zip(kept, moved):
            angle = point["cases"][k]["tool_angle_deg"]
            if min(abs(angle - wanted) for wanted in ANGLES_DEG) > 1e-6:
                continue
            theirs = [np.array(model["points"][i]["tool_displacements_mm"][k]) for _, model in models]
            row(
                f"{point['name']}, {angle:.0f}°",
                f"{np.linalg.norm(displacement):.5f}",
                *(f"{1e3 * np.linalg.norm(other - displacement):.2f}" for other in theirs),
            )
    references = [
        ("", [displacements(point, 1.0)[1] for point in points]),
        (", from ours with feet of 8 beams", [displacements(point, 1.0, "with_divided_feet_mm")[1] for point in points]),
    ]
    for program, model in models:
        if (program, model["model"]) == FINEST:
            kept = [displacements(point, 1.0)[0] for point in points]
            finest = [np.array(p["tool_displacements_mm"])[k] for p, k in zip(model["points"], kept)]
            references.append((f", from {FINEST[0]} with 8 elements", finest))
    for label, reference in references:
        for i, (point, moved) in enumerate(zip(points, reference)):
            kept, ours = displacements(point, 1.0)
            theirs = [np.array(model["points"][i]["tool_displacements_mm"])[kept] for _, model in models]
            largest = [1e3 * max(np.linalg.norm(other - moved, axis=1)) for other in (ours, *theirs)]
            row(f"{point['name']}, largest of {len(kept)}{label}", *(f"{value:.2f}" for value in largest))


if __name__ == "__main__":
    main()
