#!/usr/bin/env python3
"""Makes what is installed without a toolchain for Rust: an archive with the program, and a wheel for Python.

    packaging/make.py archive [--target TRIPLE] [--out FOLDER] [--program FILE]
    packaging/make.py wheel   [--target TRIPLE] [--out FOLDER] [--profile PROFILE]

The archive, kinetostat-VERSION-TARGET.tar.gz (.zip for Windows), holds the program, machines, studies, guide, completions for shells, and the
licences of the program and of what it is made of. The same program makes the same bytes: names are sorted, and times are that of the last commit,
or SOURCE_DATE_EPOCH. Both are written into target/packages if nothing is said. What is printed is the name of the file.

Needs Rust, git and Python; for a wheel also what requirements.txt names. Of another processor than this machine's, wheels can be made where its
linker is installed, archives cannot: the program is asked for its completions.
"""

import argparse
import gzip
import hashlib
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Bytes of a program and of a wheel, at most: growth that nobody meant is to be seen. The program has a typeface for its pages.
LARGEST_PROGRAM, LARGEST_WHEEL = 30_200_000, 12_000_000
COMPLETIONS = {"bash": "kinetostat.bash", "zsh": "_kinetostat", "fish": "kinetostat.fish", "powershell": "_kinetostat.ps1"}
LICENCES = ("LICENSE", "LICENSE-APACHE", "LICENSE-MIT")
# What is embedded and no package of Rust: name, licence and its text.
EMBEDDED = (
    ("plotly.js (part of pages)", "MIT", "src/page/assets/plotly/LICENSE"),
    ("Inter (in pages)", "SIL OFL 1.1", "src/page/assets/inter/LICENSE"),
    ("DejaVu Sans (in figures)", "Bitstream Vera", "src/figures/fonts/LICENSE-DejaVu.txt"),
)
LICENCE_FILE = re.compile(r"(licen[cs]e|copying|unlicense|notice|copyright)", re.IGNORECASE)


class Fault(Exception):
    """What keeps a package from being made, in words for who asked for it."""


def say(text):
    print(text, file=sys.stderr)


def told(*command):
    """What a command prints."""
    try:
        return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout.decode()
    except FileNotFoundError:
        raise Fault(f"{command[0]} is not installed, or not on the path") from None
    except subprocess.CalledProcessError as error:
        raise Fault(f"{' '.join(map(str, command))} failed ({error.returncode})") from None


def host():
    return re.search(r"^host: (\S+)$", told("rustc", "-vV"), re.MULTILINE)[1]


def when():
    """Seconds since 1970 that everything in a package is of."""
    given = os.environ.get("SOURCE_DATE_EPOCH") or told("git", "log", "-1", "--format=%ct").strip()
    if not given.isdecimal():
        raise Fault(f'SOURCE_DATE_EPOCH is "{given}": expected seconds since 1970')
    # Wheels and zip files know no time before 1980.
    return max(int(given), 315_532_800)


def metadata(target, *arguments):
    return json.loads(told("cargo", "metadata", "--format-version=1", "--locked", f"--filter-platform={target}", *arguments))


def made_of(graph):
    """Packages of crates.io that are compiled into the package of `graph`, by name and version."""
    nodes = {node["id"]: node["deps"] for node in graph["resolve"]["nodes"]}
    seen, waiting = set(), [graph["resolve"]["root"]]
    while waiting:
        package = waiting.pop()
        if package not in seen:
            seen.add(package)
            waiting += [used["pkg"] for used in nodes[package] if any(kind["kind"] is None for kind in used["dep_kinds"])]
    # Those without a source are parts of this repository.
    found = [package for package in graph["packages"] if package["id"] in seen and package["source"]]
    return sorted(found, key=lambda package: (package["name"], package["version"]))


def third_party(graph):
    """Names, versions and licences of what is compiled into the package of `graph`, then the texts of these licences, each once."""
    rows, texts = [], {}
    for package in made_of(graph):
        name = f"{package['name']} {package['version']}"
        rows.append((name, package["license"] or "see its text"))
        folder = Path(package["manifest_path"]).parent
        for file in sorted(file for file in folder.iterdir() if LICENCE_FILE.match(file.name) and file.is_file()):
            texts.setdefault(file.read_text(encoding="utf-8", errors="replace").strip(), []).append(name)
    for name, licence, file in EMBEDDED:
        rows.append((name, licence))
        texts.setdefault((ROOT / file).read_text(encoding="utf-8").strip(), []).append(name)
    width = max(len(name) for name, _ in rows)
    head = "What kinetostat is made of beside its own code and Rust's standard library, and under which licence.\n"
    lines = [head, *(f"{name:{width}}  {licence}" for name, licence in rows)]
    for text, names in texts.items():
        lines += ["", "-" * 80, ", ".join(dict.fromkeys(names)), "-" * 80, "", text]
    return "\n".join(lines) + "\n"


def program_for(target):
    """Builds the program; where it is."""
    command = ["cargo", "build", "--release", "--locked", "--all-features", "--bin", "kinetostat"]
    # Without --target, what `cargo build --release` has built is not built again.
    command += [] if target == host() else ["--target", target]
    for line in told(*command, "--message-format=json-render-diagnostics").splitlines():
        executable = json.loads(line).get("executable")
        if executable:
            return Path(executable)
    raise Fault("cargo built no program")


def tracked(*patterns):
    """Files that git has, by name."""
    return [Path(name) for name in told("git", "ls-files", "-z", "--", *patterns).split("\0") if name]


def contents(target, program):
    """What an archive holds: name, bytes, and whether it is a program."""
    graph = metadata(target, "--all-features")
    name = "kinetostat.exe" if "windows" in target else "kinetostat"
    yield name, program.read_bytes(), True
    yield "README.md", (ROOT / "packaging/README.md").read_bytes(), False
    yield "THIRD-PARTY.txt", third_party(graph).encode(), False
    for file in (*LICENCES, "CHANGELOG.md"):
        yield file, (ROOT / file).read_bytes(), False
    machines = tracked(":(glob)**/src/machine/catalogue/*.toml")
    if not machines:
        raise Fault("no machines: their files are no longer in src/machine/catalogue of a package")
    for file in machines:
        yield f"machines/{file.name}", (ROOT / file).read_bytes(), False
    for file in tracked("studies", "examples/*.sh", "docs/*.md", "docs/*.svg", "docs/*.json", ":!docs/SUMMARY.md"):
        yield file.as_posix(), (ROOT / file).read_bytes(), file.suffix == ".sh"
    for shell, file in COMPLETIONS.items():
        try:
            yield f"completions/{file}", told(program, "completions", shell).replace("\r\n", "\n").encode(), False
        except OSError as error:
            raise Fault(f"{program} does not run here ({error.strerror}): make its archive on a machine of its own kind") from None


def tar(folder, files, seconds):
    """Bytes of a .tar.gz that are the same wherever and whenever it is made."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name, content, runs in files:
            entry = tarfile.TarInfo(f"{folder}/{name}")
            entry.size, entry.mtime, entry.mode = len(content), seconds, 0o755 if runs else 0o644
            archive.addfile(entry, io.BytesIO(content))
    return gzip.compress(plain.getvalue(), mtime=0)


def zipped(folder, files, seconds):
    """The same as a .zip, for Windows."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content, runs in files:
            entry = zipfile.ZipInfo(f"{folder}/{name}", time.gmtime(seconds)[:6])
            entry.create_system, entry.external_attr, entry.compress_type = 3, (0o755 if runs else 0o644) << 16, zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return packed.getvalue()


def put(file, content):
    """Writes `file`, whole or not at all."""
    partial = file.with_name(f"{file.name}.partial")
    partial.write_bytes(content)
    partial.replace(file)
    say(f"{file.name}: {len(content)} bytes, SHA-256 {hashlib.sha256(content).hexdigest()}")
    print(file)


def archive(options):
    program = options.program or program_for(options.target)
    if not program.is_file():
        raise Fault(f"{program} is no file: expected a program")
    size = program.stat().st_size
    say(f"{program}: {size} bytes")
    if size > LARGEST_PROGRAM:
        raise Fault(f"a program has at most {LARGEST_PROGRAM} bytes: was it built with --release?")
    files = sorted(contents(options.target, program))
    version = told(program, "--version").split()[1]
    folder = f"kinetostat-{version}-{options.target}"
    if "windows" in options.target:
        put(options.out / f"{folder}.zip", zipped(folder, files, when()))
    else:
        put(options.out / f"{folder}.tar.gz", tar(folder, files, when()))


def run(command, env, folder=ROOT):
    if subprocess.run(command, cwd=folder, env=env, stdout=sys.stderr).returncode != 0:
        raise Fault(f"{' '.join(map(str, command))} failed")


def with_licences(made, target, env):
    """The wheel with the licences of what it is made of, by the tool that unpacks and packs wheels; `made` is gone then."""
    tool = [sys.executable, "-m", "wheel"]
    with tempfile.TemporaryDirectory() as folder:
        run([*tool, "unpack", "--dest", folder, made], env)
        [root] = Path(folder).iterdir()
        [licences] = [info / "licenses" for info in root.glob("*.dist-info")]
        licences.mkdir(exist_ok=True)
        for name in LICENCES:
            shutil.copy(ROOT / name, licences)
        graph = metadata(target, "--manifest-path", "python/Cargo.toml")
        (licences / "THIRD-PARTY.txt").write_bytes(third_party(graph).encode())
        made.unlink()
        # Its name may have other words for the same systems then.
        run([*tool, "pack", "--dest-dir", made.parent, root], env)
    [packed] = made.parent.glob("*.whl")
    return packed


def wheel(options):
    if shutil.which("maturin") is None or (options.profile == "release" and importlib.util.find_spec("wheel") is None):
        raise Fault("maturin or wheel is not there: python3 -m pip install -r packaging/requirements.txt")
    with tempfile.TemporaryDirectory() as folder:
        command = ["maturin", "build", "--quiet", "--locked", "--profile", options.profile, "--out", folder]
        command += [] if options.target == host() else ["--target", options.target]
        env = os.environ | {"SOURCE_DATE_EPOCH": str(when())}
        run(command, env, ROOT / "python")
        [made] = Path(folder).glob("*.whl")
        if options.profile == "release":
            made = with_licences(made, options.target, env)
            if made.stat().st_size > LARGEST_WHEEL:
                raise Fault(f"a wheel has at most {LARGEST_WHEEL} bytes, this one {made.stat().st_size}")
        put(options.out / made.name, made.read_bytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(dest="kind", required=True)
    for kind in (archive, wheel):
        command = kinds.add_parser(kind.__name__)
        command.set_defaults(make=kind)
        command.add_argument("--target", help="what it is for, as rustc names it: this machine if nothing is said")
        command.add_argument("--out", type=Path, default=ROOT / "target/packages", metavar="FOLDER")
    kinds.choices["archive"].add_argument("--program", type=Path, metavar="FILE", help="built already, for the target")
    kinds.choices["wheel"].add_argument("--profile", default="release", help="how it is built: dev is quicker, and not for others")
    options = parser.parse_args()
    options.target = options.target or host()
    if options.target not in told("rustc", "--print", "target-list").split():
        raise Fault(f'no target "{options.target}": rustc --print target-list names them')
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise Fault(f"{options.out} is no folder") from None
    options.out = options.out.resolve()
    if options.kind == "archive" and options.program:
        options.program = options.program.resolve()
    options.make(options)


if __name__ == "__main__":
    try:
        main()
    except Fault as fault:
        sys.exit(f"packaging/make.py: {fault}")
