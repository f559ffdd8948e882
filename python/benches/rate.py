"""Equilibria through Python beside those of the engine's `Batch` alone (`rate.rs`), in turns; best of all rounds.

One thread each. Seconds are those of the processor, so that what else a computer does counts little. Linux.

cargo build --release --example rate
python benches/rate.py target/release/examples/rate 100000 5 [MACHINE ...]
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

os.environ["RAYON_NUM_THREADS"] = "1"

import numpy as np

from kinetostat import Machine

GOAL = 0.6
# Poses that stand under many loads each.
FEW = 300


def processor_seconds(process: subprocess.Popen[str]) -> float:
    """What `process` has taken of the processor so far."""
    # The clock of a process, as `clock_getcpuclockid` makes it.
    return time.clock_gettime((~process.pid << 3) | 2)


def compare(program: str, machine: Machine, poses: int, loads: int, rounds: int) -> None:
    """Prints both rates of `poses` under `loads` each, and their ratio."""
    low, high = machine.workspace_mm
    steps = np.array([0.8191725, 0.6710436, 0.5497005])
    places = np.repeat(low + (high - low) * ((0.5 + np.arange(poses)[:, None] * steps) % 1.0), loads, axis=0)
    shares = np.arange(1, loads + 1)[:, None] / loads
    wrenches = np.tile(np.array([215.0, -10.0, -25.0, 0.0, 0.0, 0.0]) * shares, (poses, 1))
    command = [program, machine.name, str(poses), str(loads)]
    rates: dict[str, list[float]] = {"Batch": [], "Python": []}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as batch:
        assert batch.stdin is not None and batch.stdout is not None
        # Its first line says that commands are known.
        batch.stdout.readline()
        for _ in range(rounds):
            begun = processor_seconds(batch)
            batch.stdin.write("\n")
            batch.stdin.flush()
            cases, solved, largest = batch.stdout.readline().split()
            rates["Batch"].append(int(cases) / (processor_seconds(batch) - begun))
            begun = time.process_time()
            found = machine.equilibrium(places, wrenches)
            rates["Python"].append(int(cases) / (time.process_time() - begun))
            # The same work.
            assert int(cases) == np.count_nonzero(found.status != "unreachable")
            assert int(solved) == found.solved.sum() and abs(float(largest) - np.nanmax(found.distance)) < 1e-8
        batch.stdin.close()
    best = {name: max(own) for name, own in rates.items()}
    print(f"{machine.name}, {poses} poses under {loads} loads each:", end="")
    for name, own in rates.items():
        print(f" {name} {best[name]:.0f} a second (of {', '.join(f'{rate:.0f}' for rate in own)}),", end="")
    print(f" ratio {best['Python'] / best['Batch']:.2f} (goal {GOAL})", flush=True)


def main() -> None:
    program, count, rounds, *names = sys.argv[1:]
    for name in names or ["orthoglide", "hexapod"]:
        for poses in (int(count), FEW):
            compare(program, Machine(name), poses, int(count) // poses, int(rounds))


if __name__ == "__main__":
    main()
