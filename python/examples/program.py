"""A program that makes the loaded tool follow its path."""

from kinetostat import Machine, Path, Process

PROCESS = {
    "placement": {"origin_mm": [126.35, 126.35, 226.35]},
    "force": {"path_frame": {"radial_force_N": 215.0, "tangential_force_N": -10.0, "axial_force_N": -25.0}},
    "chain_error": [{"chain": "x", "turn_about_drive_axis_deg": 1.0}],
}

process = Process(Machine("orthoglide"), PROCESS)
path = Path.from_text("G90 G21\nG0 X0 Y0 Z0\nG1 X10 Y0 F300\nG3 X0 Y10 I-10 J0\n", process, "quarter.nc")
written = path.compensate()
print(written)
print(written.text)
