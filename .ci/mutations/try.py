#!/usr/bin/env python3
"""Plants each fault of this folder into a copy of the sources and says which check catches it.

    .ci/mutations/try.py [--record] [NAME...]

A fault is a patch under two lines: `Claim:`, what is promised and then broken, and `Caught by:`, a stage of .ci/run or .ci/full, for `tests`
with names of tests. Tests are run alone, so that they, and no others, catch it; all of them pass without it. A fault
that does not build is none. Ends with 1 if a fault is not caught. --record writes what was found into caught.tsv, after each fault, and leaves
what it says of others. The copy is target/mutations.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
COPY = ROOT / "target/mutations/tree"
ENV = os.environ | {"CARGO_TARGET_DIR": str(ROOT / "target/mutations/target")}
RUN_STAGES = re.findall(r'Stage\("(\w+)"', (ROOT / ".ci/stages.py").read_text().split("\nFULL = ")[0])
LONGEST_S = 1800


def header(patch):
    """Claim, stage and names of tests."""
    lines = patch.read_text().splitlines()
    if not (lines[0].startswith("Claim: ") and lines[1].startswith("Caught by: ")):
        sys.exit(f"{patch}: expected `Claim:` and `Caught by:` in its first two lines")
    stage, *tests = lines[1].removeprefix("Caught by: ").split()
    return lines[0].removeprefix("Claim: "), stage, tests


def renew():
    """The files there are, those that have changed alone, so that little is built again."""
    said = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True, stdout=subprocess.PIPE)
    names = {name for name in said.stdout.decode().split("\0") if name and (ROOT / name).is_file()}
    for name in names:
        own, copied = ROOT / name, COPY / name
        if not copied.is_file() or copied.read_bytes() != own.read_bytes():
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(own, copied)
    for folder in ("src", "tests", "crates"):
        for path in (COPY / folder).rglob("*"):
            if path.is_file() and str(path.relative_to(COPY)) not in names:
                path.unlink()
    # .ci/full goes by what git knows of the files.
    if not (COPY / ".git").exists():
        git = ["git", "-c", "user.name=try", "-c", "user.email=try@localhost"]
        for command in (["init", "--quiet"], ["add", "--all"], ["commit", "--quiet", "--message=As it is"]):
            subprocess.run([*git, *command], cwd=COPY, check=True)


def run(*command):
    """Whether a command passes, and what it prints."""
    try:
        done = subprocess.run(command, cwd=COPY, env=ENV, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LONGEST_S)
        return done.returncode == 0, done.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired as late:
        raise ValueError(str(late)) from late


def patch_with(patch, *options):
    text = patch.read_text()
    diff = text[text.index("diff --git") :]
    subprocess.run(["patch", "--quiet", "--no-backup-if-mismatch", "-p1", *options], cwd=COPY, input=diff.encode(), check=True)


def caught_by_tests(tests):
    """The tests that fail."""
    command = ["cargo", "test", "--quiet", "--all-features", "--test=it"]
    built, said = run(*command, "--no-run")
    if not built:
        raise ValueError(f"does not build:\n{said[-3000:]}")
    passed, said = run(*command, "--", "--exact", *tests)
    ran = sum(int(count) for count in re.findall(r"^running (\d+) tests?$", said, re.MULTILINE))
    if ran < len(tests):
        raise ValueError(f"{len(tests)} names, {ran} tests: {' '.join(tests)}\n{said[-2000:]}")
    failed = sorted(set(re.findall(r"^    (\S+::\S+)$", said, re.MULTILINE)))
    return [] if passed else failed or ["(ended)"]


def caught_by_stage(stage):
    built, said = run("cargo", "build", "--quiet", "--all-features", "--bins", "--examples")
    if not built:
        raise ValueError(f"does not build:\n{said[-3000:]}")
    if stage in ("pages", "engine"):
        made, said = run(".ci/run", "tools")
        if not made:
            raise ValueError(f"tools, which {stage} needs, fails:\n{said[-3000:]}")
    passed, said = run(*([".ci/run"] if stage in RUN_STAGES else [".ci/full", "--again"]), stage)
    reason = [line for line in said.partition("-- the end of")[2].splitlines() if re.search(r"FAULT|rror|FAILED|differ|no such", line)]
    return [] if passed else [reason[0][:120] if reason else "(ended)"]


def record(row, there):
    """Replaces the row of a fault; those of patches that are gone are left out."""
    file = HERE / "caught.tsv"
    rows = file.read_text().splitlines()[1:] if file.exists() else []
    by_name = {other.split("\t")[0]: other for other in [*rows, row]}
    kept = [by_name[name] for name in sorted(by_name) if name in there]
    file.write_text("fault\tby\tstage\tfirst sign\n" + "\n".join(kept) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", action="store_true", help="write caught.tsv")
    parser.add_argument("names", nargs="*", metavar="NAME", help="part of a patch's name")
    options = parser.parse_args()
    patches = sorted(HERE.glob("*.patch"))
    chosen = [patch for patch in patches if not options.names or any(name in patch.name for name in options.names)]
    renew()
    all_tests = sorted({test for patch in chosen if header(patch)[1] == "tests" for test in header(patch)[2]})
    if all_tests and (failed := caught_by_tests(all_tests)):
        sys.exit(f"fail without a fault: {' '.join(failed)}")
    for stage in sorted({header(patch)[1] for patch in chosen} - {"tests"}):
        try:
            failed = caught_by_stage(stage)
        except ValueError as fault:
            sys.exit(f"{stage} cannot be run: {fault}")
        if failed:
            sys.exit(f"{stage} fails without a fault: {' '.join(failed)}")
    rows, missed = [], 0
    for patch in chosen:
        claim, stage, tests = header(patch)
        began = time.monotonic()
        try:
            patch_with(patch)
            failed = caught_by_tests(tests) if stage == "tests" else caught_by_stage(stage)
            verdict = f"{stage}\t{' '.join(failed)}" if failed else "NOT CAUGHT\t"
        except (ValueError, subprocess.CalledProcessError) as fault:
            failed, verdict = [], f"NO FAULT\t{' '.join(str(fault).split())[-300:]}"
        finally:
            renew()
        missed += not failed
        where = "" if not failed else ".ci/run" if stage in RUN_STAGES else ".ci/full"
        rows.append(f"{patch.stem}\t{where}\t{verdict}")
        if options.record:
            record(rows[-1], {patch.stem for patch in patches})
        print(f"{rows[-1]}\t{time.monotonic() - began:.0f} s\t{claim}", flush=True)
    print(f"{len(rows)} faults, {missed} not caught")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
