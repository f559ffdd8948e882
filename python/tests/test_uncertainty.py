"""Uncertain machines: draws, quantiles, and another library's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from kinetostat import Error, Machine, Uncertainty

WRENCH = [215.0, -10.0, -25.0, 0.0, 0.0, 0.0]
PLACES = [[0.0, 0.0, 0.0], [30.0, -40.0, 75.0]]
TABLE = {
    "machine": "exact",
    "parameter": [{"name": "leg.rail.stiffness", "relative_std": 0.3}],
    "chain_error": [{"chain": "*", "turn_about_drive_axis_deg": {"uniform": [-0.1, 0.1]}}],
    "process": {"force_relative_std": 0.15},
}


@pytest.fixture(scope="module")
def uncertainty() -> Uncertainty:
    return Uncertainty(Machine("orthoglide"), TABLE)


def test_each_mounting_varies_by_itself(uncertainty: Uncertainty) -> None:
    rails = [own for own in uncertainty.inputs if own.distribution == "lognormal"]
    turns = [own for own in uncertainty.inputs if own.distribution == "uniform"]
    assert [own.name for own in rails] == ["x.rail.stiffness", "y.rail.stiffness", "z.rail.stiffness"]
    assert len(turns) == 3 and len({own.group for own in uncertainty.inputs}) == 6
    std = np.sqrt(np.log(0.5 * (1.0 + np.sqrt(1.0 + 4.0 * 0.3**2))))
    for own in rails:
        assert own.numbers == pytest.approx((std, std))
        assert own.interval == pytest.approx(
            (own.value * np.exp(-1.96 * std), own.value * np.exp(1.96 * std)), rel=1e-4
        )
    assert turns[0].numbers == pytest.approx((-0.1, 0.1))
    low, high = uncertainty.force_factor or (0.0, 0.0)
    assert low * high == pytest.approx(1.0) and 1.3 < high < 1.35


def test_samples_have_the_distributions(uncertainty: Uncertainty) -> None:
    draws, sample = uncertainty.draws(), uncertainty.sample(20_000, seed=3)
    assert draws.values.shape == (4096, 6) and sample.values.shape == (20_000, 6)
    assert np.array_equal(sample.values, uncertainty.sample(20_000, seed=3).values)
    for own, drawn, sampled in zip(uncertainty.inputs, draws.values.T, sample.values.T, strict=True):
        low, high = own.interval
        for values, error in [(drawn, 3e-3), (sampled, 6e-3)]:
            assert np.mean((low < values) & (values < high)) == pytest.approx(0.95, abs=error)
            assert np.mean(values < own.value) == pytest.approx(0.5, abs=2.0 * error)


def test_worn_tools_need_more_force_than_sharp_ones(uncertainty: Uncertainty) -> None:
    worn = Uncertainty(Machine("orthoglide"), {**TABLE, "process": {**TABLE["process"], "wear_force_increase": 0.3}})
    assert worn.wear_force_increase == 0.3 and uncertainty.wear_force_increase is None
    own, sharp = worn.draws(), uncertainty.draws()
    assert np.array_equal(own.values, sharp.values)
    factor = own.force / sharp.force
    assert factor.min() >= 1.0 and factor.max() <= 1.3
    assert np.mean(factor < 1.15) == pytest.approx(0.5, abs=3e-3)
    sample = worn.sample(20_000, seed=3)
    assert np.median(sample.force) == pytest.approx(np.median(own.force), rel=5e-3)
    low, high = worn.force_factor or (0.0, 0.0)
    assert np.mean((low < sample.force) & (sample.force < high)) == pytest.approx(0.95, abs=6e-3)


def test_deflections_are_those_of_the_machines(uncertainty: Uncertainty) -> None:
    sample = uncertainty.sample(3, seed=1)
    found = uncertainty.deflection(sample, PLACES, WRENCH)
    # A machine file whose legs are three designs is not at hand; one number for all legs is.
    shared = Uncertainty(
        Machine("orthoglide"),
        {
            "machine": "exact",
            "parameter": [{"name": "leg.rail.stiffness", "relative_std": 0.3, "shared": True}],
            "process": TABLE["process"],
        },
    )
    assert found.shape == (3, 2) and np.isfinite(found).all()
    alike = shared.sample(3, seed=1)
    for values, force, own in zip(alike.values, alike.force, shared.deflection(alike, PLACES, WRENCH), strict=True):
        assert len(set(values)) == 1
        machine = Machine("orthoglide").with_parameters({"leg.rail.stiffness": values[0]})
        assert own == pytest.approx(machine.equilibrium(PLACES, force * np.array(WRENCH)).distance, rel=1e-7)


def test_quantiles_are_those_of_random_machines(uncertainty: Uncertainty) -> None:
    found = uncertainty.quantiles(PLACES, WRENCH)
    assert found.shape == (2, 2) and (found[0] < found[1]).all()
    random = uncertainty.quantiles(PLACES, WRENCH, sample=uncertainty.sample(4000, seed=2))
    assert found == pytest.approx(random, rel=0.025)


def test_total_indices_of_a_product_are_the_exact_ones() -> None:
    # One number for all legs at a place where only they bend: the distance is a constant times compliance times force.
    toml = """
schema = 1
name = "lever"
title = "a prismatic joint"
gravity_m_per_s2 = [0.0, 0.0, 0.0]
platform = { tool_tip_mm = [0.0, 0.0, 50.0], controls = ["x"] }
workspace = { min_mm = [-1.0, 0.0, 0.0], max_mm = [1.0, 0.0, 0.0] }
mount = [{ name = "guide", chain = "guide" }]
[[chain]]
name = "guide"
elements = [{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 1e4 } }]
"""
    table = {
        "parameter": [{"name": "guide.slide.stiffness", "relative_std": 0.3}],
        "process": {"force_relative_std": 0.15},
    }
    lever = Uncertainty(Machine.from_toml(toml), table)
    found = lever.total_indices([0.0, 0.0, 0.0], [1000.0, 0.0, 0.0, 0.0, 0.0, 0.0], n=8192, seed=5)
    logarithms = np.array([lever.inputs[0].numbers[0], np.log((lever.force_factor or (0, 1))[1]) / 1.959964])
    squares = np.exp(logarithms**2)
    exact = (squares - 1.0) * squares[::-1] / (squares.prod() - 1.0)
    for (index, error), expected in zip(found.values(), exact, strict=True):
        assert 0.0 < error[0] < 0.03 and abs(index[0] - expected) < 4.0 * error[0] + 0.02
    together = lever.total_indices(
        [0.0, 0.0, 0.0], [1000.0, 0, 0, 0, 0, 0], groups={"all": ["*"], "machine": ["guide.*"]}, n=8192, seed=5
    )
    assert together["all"][0, 0] == pytest.approx(1.0, abs=0.06)
    assert together["machine"][0, 0] == pytest.approx(found["guide.slide.stiffness"][0, 0])
    with pytest.raises(ValueError, match="groups: legs: expected names of numbers that vary, or force, got 'leg"):
        lever.total_indices([0.0, 0.0, 0.0], groups={"legs": ["leg.*"]})
    with pytest.raises(ValueError, match="n: expected at least 32 pairs, got 8"):
        lever.total_indices([0.0, 0.0, 0.0], n=8)


def test_a_machine_samples_itself(uncertainty: Uncertainty) -> None:
    machine = Machine("orthoglide")
    own = machine.sample(5, 2, TABLE)
    assert np.array_equal(own.values, uncertainty.sample(5, 2).values)
    # Alone it varies by the grades of its file, its drives as what is assumed.
    names = Uncertainty(machine, {"machine": "provenance"}).names
    values = machine.sample(4000, seed=1).values
    rail = values[:, names.index("x.rail.stiffness")]
    assert values.shape == (4000, len(names)) and np.std(rail) / np.median(rail) == pytest.approx(0.6, abs=0.05)


def test_a_length_that_is_wrong_moves_the_tool_without_load() -> None:
    table = {
        "machine": "exact",
        "parameter": [{"name": "leg.q2.length", "std": 0.1}],
        "process": {"force_relative_std": 0.1},
    }
    rod = Uncertainty(Machine("orthoglide"), table)
    sample = rod.sample(2, seed=4)
    assert (rod.deflection(sample, PLACES) > 1e-3).all()
    force = Uncertainty(Machine("orthoglide"), {"machine": "exact", "process": {"force_relative_std": 0.1}})
    assert force.names == [] and force.quantiles(PLACES, WRENCH).shape == (2, 2)


def test_what_makes_no_sense(uncertainty: Uncertainty) -> None:
    with pytest.raises(Error, match=r"uncertainty: parameter\[0\].name"):
        Uncertainty(Machine("orthoglide"), {"parameter": [{"name": "leg.rial.stiffness", "relative_std": 0.3}]})
    with pytest.raises(ValueError, match=r"sample: expected the shapes \[n, 6\] and \[n\], got \[2, 5\] and \[2\]"):
        uncertainty.deflection((np.ones((2, 5)), np.ones(2)), PLACES, WRENCH)
    wrong = uncertainty.draws().values[:2].copy()
    wrong[1, 0] = -1.0
    found = uncertainty.deflection((wrong, np.ones(2)), PLACES, WRENCH)
    assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()
