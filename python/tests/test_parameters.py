"""Deflections as a function of named parameters, alone and as other libraries ask for them."""

from __future__ import annotations

import numpy as np
import pytest

from kinetostat import Error, Machine

WRENCH = [215.0, -10.0, -25.0, 0.0, 0.0, 0.0]
NAMES = ["leg.rail.stiffness", "leg.foot.height", "x.turn"]
PLACES = [[0.0, 0.0, 0.0], [30.0, -40.0, 75.0]]


@pytest.fixture(scope="module")
def machine() -> Machine:
    return Machine("orthoglide")


def sets(machine: Machine, count: int) -> np.ndarray:
    own = machine.parameters()
    rail, height = own[NAMES[0]].value, own[NAMES[1]].value
    assert rail is not None and height is not None
    share = np.random.default_rng(1).uniform(0.8, 1.25, (count, 3))
    return share * [rail, height, 0.0] + (share - 1.0) * [0.0, 0.0, 2.0]


def test_each_row_is_the_machine_with_these_numbers(machine: Machine) -> None:
    rows = sets(machine, 5)
    vectors = machine.deflection(rows, NAMES, PLACES, WRENCH, output="vector")
    distances = machine.deflection(rows, NAMES, PLACES, WRENCH)
    assert vectors.shape == (5, 6) and distances.shape == (5, 2)
    for row, vector, distance in zip(rows, vectors, distances, strict=True):
        alone = machine.with_parameters(dict(zip(NAMES, row, strict=True))).equilibrium(PLACES, WRENCH)
        assert np.array_equal(vector.reshape(2, 3), alone.deflection)
        assert np.array_equal(distance, alone.distance)
    assert np.array_equal(machine.deflection(rows[0], NAMES, PLACES, WRENCH), distances[0])


def test_what_makes_no_machine(machine: Machine) -> None:
    rows = sets(machine, 3)
    rows[1, 0] = -1.0
    with pytest.raises(Error, match="parameters, row 1: leg.rail.stiffness: "):
        machine.deflection(rows, NAMES, PLACES, WRENCH)
    found = machine.deflection(rows, NAMES, PLACES, WRENCH, no_machine="nan")
    assert np.isnan(found[1]).all() and np.isfinite(found[[0, 2]]).all()
    with pytest.raises(Error, match="leg.rail.stifness: no parameter is called so"):
        machine.deflection(rows[:, :1], ["leg.rail.stifness"], PLACES, WRENCH, no_machine="nan")
    with pytest.raises(ValueError, match=r"parameters: expected the shape \[n, 2\], got \[3, 3\]"):
        machine.deflection(rows, NAMES[:2], PLACES, WRENCH)


def test_salib_tells_which_number_counts(machine: Machine) -> None:
    sample = pytest.importorskip("SALib.sample.sobol")
    analyze = pytest.importorskip("SALib.analyze.sobol")
    own = machine.parameters()
    names = ["leg.rail.stiffness", "leg.foot.height", "platform.tool_tip.z"]
    values = [own[name].value or 0.0 for name in names]
    bounds = [
        [0.8 * values[0], 1.2 * values[0]],
        [0.8 * values[1], 1.2 * values[1]],
        [values[2] - 1e-6, values[2] + 1e-6],
    ]
    problem = {"num_vars": 3, "names": names, "bounds": bounds}
    rows = sample.sample(problem, 64, calc_second_order=False, seed=7)
    found = machine.deflection(rows, names, [30.0, -40.0, 75.0], WRENCH)
    indices = analyze.analyze(problem, found[:, 0], calc_second_order=False, seed=7)
    # The foot bends with the cube of its height; a tool longer by nothing does nothing.
    assert indices["ST"][1] > indices["ST"][0] > indices["ST"][2]
    assert 0.9 < sum(indices["S1"]) < 1.1 and indices["ST"][2] < 1e-3


def test_optuna_finds_the_stiffest_place(machine: Machine) -> None:
    optuna = pytest.importorskip("optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    low, high = machine.workspace_mm

    def moved(trial: object) -> float:
        place = [trial.suggest_float(axis, low[k], high[k]) for k, axis in enumerate("xyz")]  # type: ignore[attr-defined]
        return float(machine.equilibrium(place, WRENCH).distance)

    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=3))
    study.optimize(moved, n_trials=60)
    axes = [np.linspace(low[k], high[k], 5) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    assert study.best_value < 1.1 * machine.equilibrium(grid, WRENCH).distance.min()
