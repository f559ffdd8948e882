#!/usr/bin/env python3
"""Processor seconds of each test, the slowest first: .ci/slowest.py [--most N] [--at-once N] [WORD...]

Builds what `cargo test --all-features` builds and runs each test whose name holds one of WORD in a process of its own, so that what several
tests share is paid by each of them. Printed is user and system time, of the processes that a test starts as well.
"""

import argparse
import concurrent.futures
import json
import os
import subprocess
import sys


def binaries():
    """Test binaries with the name of their target."""
    command = ["cargo", "test", "--all-features", "--no-run", "--message-format=json"]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = (json.loads(line) for line in said.splitlines())
    artifacts = [message for message in messages if message["reason"] == "compiler-artifact" and message["executable"]]
    return [(a["target"]["name"], a["executable"]) for a in artifacts if a["profile"]["test"]]


def cost(binary, test):
    """Processor seconds of one test, and whether it passed."""
    process = subprocess.Popen([binary, "--exact", test], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, process.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int, default=30, help="rows to print")
    parser.add_argument("--at-once", type=int, default=os.cpu_count(), help="tests side by side")
    parser.add_argument("words", nargs="*", metavar="WORD")
    options = parser.parse_args()
    tests = []
    for target, binary in binaries():
        listed = subprocess.run([binary, "--list"], check=True, stdout=subprocess.PIPE, text=True).stdout
        ignored = subprocess.run([binary, "--list", "--ignored"], check=True, stdout=subprocess.PIPE, text=True).stdout
        names = [line.removesuffix(": test") for line in listed.splitlines() if line.endswith(": test")]
        tests += [
            (target, binary, name)
            for name in names
            if f"{name}: test" not in ignored.splitlines() and (not options.words or any(w in name for w in options.words))
        ]
    with concurrent.futures.ThreadPoolExecutor(options.at_once) as pool:
        costs = list(pool.map(lambda test: cost(*test[1:]), tests))
    rows = sorted(((seconds, target, name, passed) for (target, _, name), (seconds, passed) in zip(tests, costs)), reverse=True)
    print(f"{sum(row[0] for row in rows):.1f} s of processor time in {len(rows)} tests\n")
    print("| s | test |\n|---:|---|")
    for seconds, target, name, passed in rows[: options.most]:
        print(f"| {seconds:.1f} | `{target}` {name}{'' if passed else ' (failed)'} |")
    sys.exit(not all(row[3] for row in rows))


if __name__ == "__main__":
    main()
