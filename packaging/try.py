#!/usr/bin/env python3
"""Tries an archive, a wheel or both where there is next to nothing: packaging/try.py FILE... [--keep FOLDER]

Each is unpacked into a root of its own, which holds beside it what `ldd` names (libc, its loader and libgcc), /proc and, for a wheel, the Python that runs
this, its standard library, and what pip installs with the wheel. In there, without a network, without a shell and without the variables of this
environment, the program runs a study, compensates a program and checks its machines, and Python solves an equilibrium. Linux, as root; pip is needed
for a wheel. --keep leaves the roots in FOLDER.
"""

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Of the standard library, what is no part of it or of no use without a screen.
LEFT_OUT = ("site-packages", "dist-packages", "test", "tests", "idlelib", "tkinter", "_tkinter*", "turtledemo", "ensurepip", "config-*", "__pycache__")

PYTHON = """
import kinetostat
solved = kinetostat.Machine("orthoglide").equilibrium([30, -40, 75], [215, -10, -25, 0, 0, 0])
print(solved)
assert str(solved.status) == "solved", solved.status
# As the guide prints it.
assert abs(float((solved.deflection**2).sum()) ** 0.5 - 0.1151) < 1e-4, solved.deflection
assert kinetostat.__file__.startswith("/packages/"), kinetostat.__file__
"""


class Fault(Exception):
    """What a try has found."""


def libraries(file):
    """What the loader needs for a program or library, by `ldd`; nothing for what is linked whole."""
    said = subprocess.run(["ldd", file], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if re.search(r"not found", said.stdout):
        raise Fault(f"{file} needs what this machine has not:\n{said.stdout}")
    return set(re.findall(r"(/\S+) \(0x", said.stdout))


def put_libraries(root, files):
    """Copies what `files` need to where they look for it; its names."""
    needed = {Path(name) for file in files for name in libraries(file)}
    # What a wheel brings along is in the root already.
    needed = {file for file in needed if not file.is_relative_to(root)}
    for file in needed:
        copy = root / file.relative_to("/")
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
        copy.chmod(0o755)
    return sorted(file.name for file in needed)


def inside(root, *command, folder="/", **env):
    """What a command prints in `root`."""
    # Network interfaces of its own, of which there are none; /proc is the kernel's, and where a program finds itself.
    (root / "proc").mkdir(exist_ok=True)
    ran = subprocess.run(
        ["unshare", "--net", "--pid", "--fork", "--mount-proc", f"--root={root}", f"--wd={folder}", "--", *command],
        env=env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600,
    )
    if ran.returncode != 0:
        raise Fault(f"{' '.join(command)} ended with {ran.returncode}:\n{ran.stdout}")
    return ran.stdout


def filled(root, *names):
    for name in names:
        file = root / name.lstrip("/")
        if not file.is_file() or file.stat().st_size == 0:
            raise Fault(f"{name} was not written")


def try_archive(file, root):
    with tarfile.open(file) as archive:
        archive.extractall(root, filter="data")
    [home] = [path for path in root.iterdir()]
    (root / "tmp").mkdir()
    names = put_libraries(root, [home / "kinetostat"])
    print(f"{file.name}: beside what is in it, {', '.join(names)}")
    subprocess.run([sys.executable, ROOT / "tests/docs/check_links.py", home / "README.md", home / "docs", home / "studies"], check=True)
    at = {"folder": f"/{home.name}"}
    said = inside(root, "./kinetostat", "run", "studies/01_workspace_map", "--grid", "5", "--out", "/tmp/map", **at)
    if "Tool deflection: 0.500 mm at best, 1.712 mm at worst." not in said:
        raise Fault(f"no answer in what `run` says:\n{said}")
    filled(root, "/tmp/map/map.csv", "/tmp/map/report.html", "/tmp/map/machine_at_home.svg")
    groove = "studies/02_groove_50mm"
    inside(root, "./kinetostat", "compensate", f"{groove}/groove.nc", "--machine", "orthoglide", "--process", f"{groove}/process_program.toml",
           "--out", "/tmp/groove.nc", **at)
    filled(root, "/tmp/groove.nc")
    for machine in sorted((home / "machines").iterdir()):
        inside(root, "./kinetostat", "check", f"machines/{machine.name}", **at)


def try_wheel(file, root):
    packages = root / "packages"
    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-compile", "--target", packages, file], check=True)
    library, python = Path(sysconfig.get_path("stdlib")), Path(sys.executable).resolve()
    copied = root / library.relative_to("/")
    shutil.copytree(library, copied, ignore=shutil.ignore_patterns(*LEFT_OUT))
    inner = root / python.relative_to("/")
    inner.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(python, inner)
    (root / "tmp").mkdir()
    names = put_libraries(root, [python, *(copied / "lib-dynload").glob("*.so"), *packages.rglob("*.so")])
    print(f"{file.name}: beside Python {platform.python_version()} and what pip installs, {', '.join(names)}")
    said = inside(root, str(python), "-c", PYTHON, PYTHONPATH="/packages", PYTHONDONTWRITEBYTECODE="1")
    print(said, end="")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help=".tar.gz or .whl")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="leave the roots here, where nothing may be")
    options = parser.parse_args()
    if sys.platform != "linux" or os.geteuid() != 0:
        raise Fault("needs Linux, and to be root: nobody else changes the root of a process")
    for tool in ("ldd", "unshare"):
        if shutil.which(tool) is None:
            raise Fault(f"{tool} is not installed")
    for file in options.files:
        if not file.is_file() or not file.name.endswith((".tar.gz", ".whl")):
            raise Fault(f"{file} is no .tar.gz or .whl")
    if options.keep and options.keep.exists():
        raise Fault(f"{options.keep} is there already")
    with tempfile.TemporaryDirectory() as folder:
        roots = options.keep or Path(folder)
        for file in options.files:
            root = (roots / f"root_of_{file.name}").resolve()
            root.mkdir(parents=True)
            (try_wheel if file.suffix == ".whl" else try_archive)(file.resolve(), root)
    print(f"{len(options.files)} of {len(options.files)} work where there is next to nothing")


if __name__ == "__main__":
    try:
        main()
    except (Fault, subprocess.CalledProcessError, subprocess.TimeoutExpired) as fault:
        sys.exit(f"packaging/try.py: {fault}")
