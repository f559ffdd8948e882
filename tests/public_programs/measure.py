"""Gives public programs, which the project does not ship, to kinetostat and writes what it says of each into programs.csv.

    python3 tests/public_programs/measure.py PROGRAM [--mirror FOLDER] [--only WORD]

PROGRAM is the program built (target/release/kinetostat). Programs are run where they are in their repositories, with their neighbours, on a machine of
ten metres without load, those of robots and what turns the tool on one that does: what is accepted must come out with the same bytes. FOLDER has the repositories (bare, OWNER+NAME/repo); what is missing there is
cloned into it from GitHub (default: target/public_programs). The columns repository, commit, path, dialect and mills (yes, or what else it is) are
written by hand; options are keys of the process file that say what a program leaves open; the answer is of the last run.
"""

import argparse
import collections
import contextlib
import concurrent.futures
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
TABLE = HERE / "programs.csv"
COLUMNS = ["repository", "commit", "path", "dialect", "mills", "options", "answer"]
# Of the first line of an error that much is kept.
MOST = 240
# Bytes of a program, or of one that it calls, at most.
LARGEST = 5_000_000
# Dialects whose programs turn the tool.
ROBOTS = {"rapid", "krl", "urscript", "fanuc_ls"}


def repository(mirror: Path, name: str) -> Path:
    folder = mirror / name.replace("/", "+") / "repo"
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "--quiet", "--bare", f"https://github.com/{name}", str(folder)], check=True)
    return folder / ".git" if (folder / ".git").is_dir() else folder


def git(folder: Path, *words: str) -> bytes:
    return subprocess.run(["git", "-C", str(folder), *words], capture_output=True, check=True).stdout


def is_missing(mirror: Path, name: str) -> bool:
    try:
        repository(mirror, name)
    except subprocess.CalledProcessError:
        return True
    return False


def answer(program: str, mirror: Path, row: dict) -> str:
    said = answer_on(HERE / ("arm.toml" if row["dialect"] in ROBOTS else "machine.toml"), program, mirror, row)
    return answer_on(HERE / "arm.toml", program, mirror, row) if "controls no rotation" in said else said


def answer_on(machine: Path, program: str, mirror: Path, row: dict) -> str:
    folder = repository(mirror, row["repository"])
    with tempfile.TemporaryDirectory() as root:
        beside = os.path.dirname(row["path"])
        file = Path(root, row["path"])
        file.parent.mkdir(parents=True, exist_ok=True)
        # Of a history that was cut off only the newest commit is there.
        for commit in (row["commit"], "HEAD"):
            try:
                entries = git(folder, "ls-tree", "-z", "--long", commit, *([beside + "/"] if beside else [])).decode().split("\0")
            except subprocess.CalledProcessError:
                continue
            for entry in filter(None, entries):
                (_, kind, blob, size), name = entry.split("\t")[0].split(), entry.split("\t")[1]
                # A copy without its largest files lacks some that no program calls.
                if kind == "blob" and size.isdigit() and int(size) < LARGEST:
                    with contextlib.suppress(subprocess.CalledProcessError):
                        Path(root, name).write_bytes(git(folder, "cat-file", "blob", blob))
            if file.is_file():
                break
        else:
            return "not found"
        process = Path(root, "process_of_the_run.toml")
        process.write_text("schema = 1\n" + row["options"].replace("; ", "\n") + "\n")
        out = Path(root, "result_of_the_run", file.name)
        out.parent.mkdir()
        command = [program, "compensate", str(file), "--machine", str(machine), "--process", str(process), "--out", str(out)]
        command += ["--method", "direct", "--progress", "none"]
        try:
            run = subprocess.run(command, capture_output=True, timeout=300)
        except subprocess.TimeoutExpired:
            return "no answer within 300 s"
        if run.returncode not in (0, 1) or not out.is_file():
            said = run.stderr.decode("utf8", "replace").strip().split("\n")[0]
            said = said.replace(str(file.parent) + "/", "").removeprefix("error: ")
            return "refused: " + said[:MOST]
        return "accepted, same bytes" if out.read_bytes() == file.read_bytes() else "accepted, written out"


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("program")
    words.add_argument("--mirror", type=Path, default=HERE.parents[1] / "target" / "public_programs")
    words.add_argument("--only", help="only rows with this word in repository, path or dialect")
    given = words.parse_args()
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    chosen = [row for row in rows if not given.only or any(given.only in row[name] for name in COLUMNS[:4])]
    program = os.path.abspath(given.program)
    missing = {name for name in sorted({row["repository"] for row in chosen}) if is_missing(given.mirror, name)}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        asked = [row for row in chosen if row["repository"] not in missing]
        for row, said in zip(asked, pool.map(lambda row: answer(program, given.mirror, row), asked)):
            row["answer"] = said
    with TABLE.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    for dialect in sorted({row["dialect"] for row in chosen}):
        mills = [row["answer"] for row in chosen if row["dialect"] == dialect and row["mills"] == "yes"]
        accepted = sum(said.startswith("accepted") for said in mills)
        print(f"{dialect}: {accepted} of {len(mills)} that mill accepted")
    counts = collections.Counter(row["answer"].split(":")[0] for row in chosen)
    print(", ".join(f"{said} {count}" for said, count in counts.most_common()))
    if missing:
        print(f"{len(chosen) - len(asked)} rows keep their answers, as these cannot be cloned: {', '.join(sorted(missing))}")
    if any(row["answer"] == "not found" for row in chosen):
        sys.exit("programs were not found: their commits are no longer there")


if __name__ == "__main__":
    main()
