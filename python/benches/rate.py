"""A million equilibria through Python beside the same from Rust (`rate.rs`), in turns; best of all rounds.

cargo build --release --example rate
python benches/rate.py target/release/examples/rate 1000000 3
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np

from kinetostat import Machine

GOAL = 0.9


def main() -> None:
    program, count, rounds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    machine = Machine("orthoglide")
    low, high = machine.workspace_mm
    steps = np.array([0.8191725, 0.6710436, 0.5497005])
    places = low + (high - low) * ((0.5 + np.arange(count)[:, None] * steps) % 1.0)
    wrench = [215.0, -10.0, -25.0, 0.0, 0.0, 0.0]
    rates: dict[str, list[float]] = {"Rust": [], "Python": []}
    for _ in range(rounds):
        done = subprocess.run([program, str(count)], capture_output=True, text=True, check=True).stdout.split()
        rates["Rust"].append(float(done[0]))
        begun = time.perf_counter()
        found = machine.equilibrium(places, wrench)
        rates["Python"].append(count / (time.perf_counter() - begun))
        # The same work.
        assert int(done[1]) == found.solved.sum() and abs(float(done[2]) - np.nanmax(found.distance)) < 1e-8
    best = {name: max(own) for name, own in rates.items()}
    for name, own in rates.items():
        print(f"{name}: {best[name]:.0f} equilibria per second (of {', '.join(f'{rate:.0f}' for rate in own)})")
    print(f"Python has {best['Python'] / best['Rust']:.3f} times the rate of Rust (goal {GOAL})")


if __name__ == "__main__":
    main()
