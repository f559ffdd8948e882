#!/usr/bin/env python3
"""Makes a page with a map for each built-in machine, for check_pages.py.

    catalogue.py OUT PROGRAM...
    catalogue.py /tmp/pages cargo run --release --

The pages are OUT/MACHINE/report.html.
"""

import json
import subprocess
import sys
from pathlib import Path

CATALOGUE = Path(__file__).parents[2] / "crates/engine/src/machine/catalogue"
STUDY = """schema = 3
question = "How far does the tool of {machine} move under a milling force?"
machine = "{machine}"
[process.force.path_frame]
radial_force_N = 40.0
tangential_force_N = -10.0
axial_force_N = -20.0
[workspace_map]
grid = [3, 3, {heights}]
slices_z_mm = {slices}
phi_step_deg = 45.0
"""


def main():
    out, program = Path(sys.argv[1]), sys.argv[2:]
    for machine in sorted(file.stem for file in CATALOGUE.glob("*.toml")):
        answer = subprocess.run([*program, "machines", machine, "--parameters", "--json"], check=True, capture_output=True)
        values = {parameter["name"]: parameter["value"] for parameter in json.loads(answer.stdout)["parameters"]}
        ends = [values["workspace.min.z"], values["workspace.max.z"]]
        is_flat = ends[0] == ends[1]
        study = out / f"{machine}_study"
        study.mkdir(parents=True)
        slices, heights = (ends[:1], 1) if is_flat else (ends, 3)
        (study / "study.toml").write_text(STUDY.format(machine=machine, heights=heights, slices=slices))
        # 1 says that some points have no solution: a corner of the workspace may be singular.
        run = subprocess.run([*program, "run", str(study), "--out", str(out / machine)])
        if run.returncode not in (0, 1):
            sys.exit(f"{machine}: `run` ended with {run.returncode}")


if __name__ == "__main__":
    main()
