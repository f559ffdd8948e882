"""Machines: what single cases and batches answer, and what they refuse."""

from __future__ import annotations

import copy
import doctest
import hashlib
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import kinetostat
from kinetostat import Error, Machine

ROOT = Path(os.environ.get("REPOSITORY", Path(__file__).resolve().parents[2])).resolve()
WRENCH = np.array([215.0, -10.0, -25.0, 0.0, 0.0, 0.0])
# What other places may take, over one place: in lanes 1.5 (Orthoglide) and 2.0 (hexapod), one by one 3.9 and 6.7.
MAX_FOR_PLACES = 3.0


@pytest.fixture(scope="module")
def machine() -> Machine:
    return Machine("orthoglide")


def positions(machine: Machine, count: int) -> np.ndarray:
    low, high = machine.workspace_mm
    return np.random.default_rng(3).uniform(low, high, (count, 3))


def test_a_case_is_a_row_of_a_batch_to_the_last_bit(machine: Machine) -> None:
    places = positions(machine, 21)
    many = machine.equilibrium(places, WRENCH, stiffness=True)
    for k in (0, 7, 20):
        one = machine.equilibrium(places[k], WRENCH, stiffness=True)
        for name in ("drives", "drive_forces", "pose", "deflection", "rotation", "stiffness", "compliance"):
            assert np.array_equal(getattr(one, name), getattr(many, name)[k]), name
        assert one.status == many.status[k] == "solved"
    assert many.deflection.shape == (21, 3) and many.pose.shape == (21, 4, 4)


def test_one_pose_under_many_loads(machine: Machine) -> None:
    loads = WRENCH * np.linspace(0.1, 2.0, 13)[:, None]
    together = machine.equilibrium([30, -40, 75], loads)
    apart = machine.equilibrium(np.tile([30.0, -40.0, 75.0], (13, 1)), loads)
    assert np.array_equal(together.deflection, apart.deflection)
    assert np.all(np.diff(together.distance) > 0)


def test_a_matrix_is_the_pose_of_a_position(machine: Machine) -> None:
    pose = machine.home.copy()
    pose[:3, 3] = [30, -40, 75]
    assert np.array_equal(
        machine.equilibrium(pose, WRENCH).deflection, machine.equilibrium([30, -40, 75], WRENCH).deflection
    )


def test_the_stiffness_is_the_slope_of_the_wrench(machine: Machine) -> None:
    place, step = [30.0, -40.0, 75.0], 1e-2
    steps = np.vstack([np.eye(6), -np.eye(6)]) * step * np.array([1, 1, 1, 100, 100, 100])
    moved = machine.equilibrium(place, steps)
    compliance = np.empty((6, 6))
    for j in range(6):
        size = 2 * steps[j, j]
        compliance[:3, j] = (moved.pose[j, :3, 3] - moved.pose[6 + j, :3, 3]) / size
        compliance[3:, j] = (moved.rotation[j] - moved.rotation[6 + j]) / size
    assert np.allclose(np.linalg.inv(compliance), machine.stiffness(place), rtol=1e-5, atol=1e-2)


def test_a_compensated_command_puts_the_tool_where_it_is_wanted(machine: Machine) -> None:
    places = positions(machine, 11)
    found = machine.compensate(places, WRENCH)
    assert list(found.status) == ["converged"] * 11
    settled = machine.equilibrium(found.command, WRENCH)
    tips = settled.pose[:, :3, :3] @ machine.tool_tip_mm + settled.pose[:, :3, 3]
    wanted = places + machine.home[:3, :3] @ machine.tool_tip_mm
    assert np.abs(tips - wanted).max() < 1e-8
    assert np.allclose(found.delta_rho, settled.drives - found.nominal_drives, atol=1e-8)
    assert 0.01 < np.abs(found.delta_rho).max() < 2.0


def test_methods_of_the_command_line(machine: Machine) -> None:
    left = {
        m: machine.compensate([30, -40, 75], WRENCH, method=m).distance
        for m in ("none", "linear", "mirror_2", "newton")
    }
    assert left["none"] > left["linear"] > left["newton"]
    assert left["mirror_2"] < 1e-3 and left["newton"] < 1e-8


def test_what_cannot_be_solved_is_data(machine: Machine) -> None:
    found = machine.equilibrium([[30, -40, 75], [3000, 0, 0], [0, 0, 0]], WRENCH)
    assert list(found.status) == ["solved", "unreachable", "solved"]
    assert list(found.solved) == [True, False, True]
    assert list(found.reasons) == [1] and "cannot close" in found.reasons[1]
    assert np.isnan(found.deflection[1]).all() and np.isfinite(found.deflection[[0, 2]]).all()
    assert repr(found).startswith("Equilibrium: 2 of 3 solved") and found.reasons[1] in repr(found)


@pytest.mark.parametrize(
    ("pose", "wrench", "message"),
    [
        ([1, 2], WRENCH, "pose: expected the shape"),
        ([1, 2, 3], [1, 2, 3], "wrench: expected the shape"),
        (np.zeros((4, 3)), np.zeros((5, 6)), "wrench: expected 4 rows"),
        ("here", WRENCH, "pose: expected an array of numbers"),
    ],
)
def test_shapes_are_refused(machine: Machine, pose: object, wrench: object, message: str) -> None:
    with pytest.raises(ValueError, match=message.replace("[", r"\[")):
        machine.equilibrium(pose, wrench)  # type: ignore[arg-type]


def test_numbers_that_are_none_are_refused(machine: Machine) -> None:
    with pytest.raises(Error, match="pose, row 1: expected numbers of at most 1e15, got NaN"):
        machine.equilibrium([[0, 0, 0], [0, float("nan"), 0]])
    with pytest.raises(Error, match="pose, row 0: expected a homogeneous matrix"):
        machine.equilibrium(np.diag([1.0, 2.0, 1.0, 1.0]))
    with pytest.raises(Error, match='method: expected one of none, linear.*, got "luck"'):
        machine.compensate([0, 0, 0], method="luck")
    with pytest.raises(Error, match='target: expected tool_tip.*got "moon"'):
        machine.compensate([0, 0, 0], target="moon")  # type: ignore[arg-type]


def test_no_cases_are_no_rows(machine: Machine) -> None:
    found = machine.equilibrium(np.zeros((0, 3)), stiffness=True)
    assert len(found) == 0 and found.deflection.shape == (0, 3) and found.reasons == {}
    assert found.stiffness is not None and found.stiffness.shape == (0, 6, 6)


def test_machines_of_files_and_their_errors(tmp_path: Path, machine: Machine) -> None:
    file = tmp_path / "own.toml"
    file.write_text(machine.toml)
    own = Machine.from_file(file)
    assert np.array_equal(
        own.equilibrium([0, 0, 0], WRENCH).deflection, machine.equilibrium([0, 0, 0], WRENCH).deflection
    )
    file.write_text(machine.toml.replace('name = "orthoglide"', "name = 7"))
    with pytest.raises(Error, match=r"own\.toml:\d+: name: "):
        Machine.from_file(file)
    with pytest.raises(Error, match='no built-in machine "orthoglyde"; built in: '):
        Machine("orthoglyde")
    assert "orthoglide" in kinetostat.machine_names()


def test_parameters_by_name(machine: Machine) -> None:
    rail = machine.parameters()["leg.rail.stiffness"]
    assert rail.unit == "N_per_mm" and rail.value is not None
    softer = machine.with_parameters({"leg.rail.stiffness": rail.value / 2})
    assert softer.parameters()["leg.rail.stiffness"].value == rail.value / 2
    assert softer.equilibrium([0, 0, 0], WRENCH).distance > machine.equilibrium([0, 0, 0], WRENCH).distance
    again = softer.with_parameters({"leg.rail.stiffness": rail.value})
    assert np.array_equal(again.equilibrium([0, 0, 0], WRENCH).pose, machine.equilibrium([0, 0, 0], WRENCH).pose)
    with pytest.raises(Error, match="there are: leg.rail.stiffness"):
        machine.with_parameters({"leg.rail.stifness": 1.0})


def test_errors_of_chains_answer_and_do_not_command(machine: Machine) -> None:
    turned = machine.with_parameters({"x.turn": 1.0})
    found = turned.equilibrium([0, 0, 0])
    assert np.array_equal(found.drives, machine.equilibrium([0, 0, 0]).drives)
    assert found.distance > 1e-3 and machine.equilibrium([0, 0, 0]).distance < 1e-9


def test_what_the_package_says_of_itself() -> None:
    assert doctest.testmod(kinetostat) == (0, 3)


def test_an_arm_of_a_urdf() -> None:
    urdf = ROOT / "tests" / "urdf" / "imported" / "centre_in_millimetres.urdf"
    with pytest.raises(Error, match="unknown"):
        Machine.import_urdf(urdf)
    with pytest.raises(Error, match="stiffness: expected 6, one for each of a1, a2"):
        Machine.import_urdf(urdf, stiffness=[1e6])
    arm = Machine.import_urdf(urdf, stiffness=[1e6] * 6, tool_tip_mm=(0.0, 0.0, 100.0))
    assert arm.revolute == [True] * 6 and any(note.startswith("mass of link") for note in arm.notes)
    pushed = arm.equilibrium(arm.home, [100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert pushed.solved and 1e-6 < pushed.distance < 100.0
    again = Machine.from_toml(arm.toml).equilibrium(arm.home, [100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert np.array_equal(again.pose, pushed.pose)
    like = Machine.import_urdf(urdf, like=arm, tool_tip_mm=(0.0, 0.0, 100.0))
    assert np.array_equal(like.stiffness(arm.home), arm.stiffness(arm.home), equal_nan=True)


DIGEST = """
import hashlib, sys
import numpy as np, kinetostat
machine = kinetostat.Machine("orthoglide")
low, high = machine.workspace_mm
places = np.random.default_rng(5).uniform(low - 20, high + 20, (400, 3))
found = machine.compensate(places, [215, -10, -25, 0, 0, 0])
parts = (found.drives, found.pose, found.command, found.deflection, found.drive_forces, found.error)
text = b"".join(part.tobytes() for part in parts) + str((list(found.status), found.reasons)).encode()
print(hashlib.sha256(text).hexdigest())
"""


def test_bytes_do_not_depend_on_threads() -> None:
    digests = set()
    for threads in ("1", "2", "5"):
        environment = {**os.environ, "RAYON_NUM_THREADS": threads}
        done = subprocess.run(
            [sys.executable, "-c", DIGEST], env=environment, capture_output=True, text=True, check=True
        )
        digests.add(done.stdout)
    assert len(digests) == 1


def _in_a_fork(_: int) -> str:
    found = Machine("orthoglide").equilibrium(np.zeros((50, 3)), WRENCH)
    return hashlib.sha256(found.pose.tobytes()).hexdigest()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_forked_processes_have_threads_of_their_own() -> None:
    here = _in_a_fork(0)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert set(pool.map_async(_in_a_fork, range(4)).get(timeout=60)) == {here}


INTERRUPTED = """
import signal, numpy as np, kinetostat
# Scripts start what runs beside them with the signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
machine = kinetostat.Machine("orthoglide")
print("ready", flush=True)
try:
    machine.compensate(np.zeros((5_000_000, 3)) + np.arange(3), [215, -10, -25, 0, 0, 0], method="newton")
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_stops_a_batch() -> None:
    with subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(1.5)
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "stopped\n"
        assert time.monotonic() - begun < 10
    assert process.returncode == 0


def test_repeated_poses_are_what_each_is_alone(machine: Machine) -> None:
    places, loads = positions(machine, 4), WRENCH * np.linspace(0.1, 2.0, 6)[:, None]
    grid = machine.equilibrium(np.repeat(places, 6, axis=0), np.tile(loads, (4, 1)))
    tiled = machine.equilibrium(np.tile(places, (6, 1)), np.repeat(loads, 4, axis=0))
    for k in range(24):
        one = machine.equilibrium(places[k // 6], loads[k % 6])
        assert np.array_equal(one.deflection, grid.deflection[k])
        assert np.array_equal(one.deflection, tiled.deflection[4 * (k % 6) + k // 6])


@pytest.mark.parametrize("name", ["orthoglide", "hexapod", "fanuc_r2000ic"])
def test_places_of_a_batch_are_commanded_as_each_alone(name: str) -> None:
    machine = Machine(name)
    low, high = machine.workspace_mm
    # Beyond the box too, and some where nothing reaches.
    shares = np.random.default_rng(5).uniform(-1.2, 1.2, (40, 3)) * np.where(np.arange(40) % 8 == 3, 9.0, 1.0)[:, None]
    places = (low + high) / 2 + (high - low) * shares
    many, drives = machine.equilibrium(places, WRENCH), machine.inverse_kinematics(places)
    back = machine.forward_kinematics(many.drives[many.solved])
    assert 0 < np.count_nonzero(many.solved) < 40
    for k, place in enumerate(places):
        one = machine.equilibrium(place, WRENCH)
        assert (one.status, one.reasons.get(0)) == (many.status[k], many.reasons.get(k))
        for alone, own in ((one.drives, many.drives), (one.pose, many.pose), (one.deflection, many.deflection)):
            assert np.array_equal(alone, own[k], equal_nan=True)
        assert np.array_equal(machine.inverse_kinematics(place), drives[k], equal_nan=True)
    for place, pose, own in zip(places[many.solved], back, many.drives[many.solved], strict=True):
        assert np.array_equal(machine.forward_kinematics(own), pose)
        assert np.allclose(pose[:3, 3], place, rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", ["orthoglide", "hexapod"])
def test_other_places_cost_little_more_than_one(name: str) -> None:
    machine = Machine(name)
    low, high = machine.workspace_mm
    places = np.random.default_rng(7).uniform(low, high, (6000, 3))
    loads = np.tile(WRENCH, (len(places), 1))

    def seconds(places: np.ndarray) -> float:
        # Of the processor, all threads together: what else a computer does counts little.
        begun = time.process_time()
        assert machine.equilibrium(places, loads).solved.all()
        return time.process_time() - begun

    rounds = [(seconds(places), seconds(places[0])) for _ in range(5)]
    assert min(many for many, _ in rounds) < MAX_FOR_PLACES * min(one for _, one in rounds)


@pytest.mark.parametrize("name", ["orthoglide", "kr270", "hexapod"])
def test_kinematics_there_and_back(name: str) -> None:
    machine = Machine(name)
    pose = np.tile(machine.home, (5, 1, 1))
    pose[:, :3, 3] += np.random.default_rng(1).uniform(-40, 40, (5, 3))
    drives = machine.inverse_kinematics(pose)
    assert drives.shape == (5, len(machine.drive_names)) and np.all(np.isfinite(drives))
    assert np.allclose(machine.forward_kinematics(drives), pose, atol=1e-8)
    assert np.array_equal(machine.inverse_kinematics(pose[2]), drives[2])
    # The derivative is the slope of the inverse kinematics.
    step = pose.copy()
    step[:, 0, 3] += 1e-4
    slope = (machine.inverse_kinematics(step) - drives) / 1e-4
    assert np.allclose(machine.jacobian(pose)[:, :, 0], slope, rtol=1e-4, atol=1e-7)
    far = machine.inverse_kinematics([1e7, 0.0, 0.0])
    assert np.all(np.isnan(far))
    with pytest.raises(ValueError, match="drives: expected the shape"):
        machine.forward_kinematics([1.0])


def test_an_arm_stands_on_the_branch_that_is_asked_for() -> None:
    arm = Machine("kr270")
    own = arm.inverse_kinematics(arm.home)
    other = arm.inverse_kinematics(arm.home, branch="front-up-flip")
    again = arm.inverse_kinematics(arm.home, branch="front-up-noflip")
    assert not np.allclose(other, again)
    assert np.allclose(own, other) or np.allclose(own, again)
    assert np.allclose(arm.forward_kinematics(other), arm.home, atol=1e-8)
    with pytest.raises(Error, match="branch"):
        Machine("orthoglide").inverse_kinematics([0.0, 0.0, 0.0], branch="front-up-flip")


def test_loaded_at_drives_and_at_the_tip(machine: Machine) -> None:
    places = positions(machine, 3)
    at_pose = machine.equilibrium(places, WRENCH)
    at_drives = machine.equilibrium_at_drives(at_pose.drives, WRENCH)
    assert np.allclose(at_drives.deflection, at_pose.deflection, atol=1e-10)
    many = machine.equilibrium_at_drives(at_pose.drives[0], np.stack([WRENCH, 2 * WRENCH]))
    assert np.allclose(many.deflection[0], at_pose.deflection[0], atol=1e-10)
    # A force at the tip is one at P with its moment about P.
    arm = Machine("kr270")
    force = np.array([100.0, -50.0, 80.0])
    lever = arm.home[:3, :3] @ arm.tool_tip_mm
    at_p = arm.equilibrium(arm.home, np.concatenate([force, np.cross(lever, force)]))
    at_tip = arm.equilibrium(arm.home, np.concatenate([force, np.zeros(3)]), at="tip")
    assert np.allclose(at_tip.deflection, at_p.deflection, atol=1e-12)
    with pytest.raises(ValueError, match='at: expected "P" or "tip"'):
        arm.equilibrium(arm.home, at="T")  # type: ignore[arg-type]


def test_machines_are_pickled_copied_and_compared(machine: Machine) -> None:
    other = machine.with_parameters({"platform.tool_tip.z": -40.0})
    for own in (machine, other):
        back = pickle.loads(pickle.dumps(own))
        assert back == own and hash(back) == hash(own) and back.name == own.name
        assert np.array_equal(
            back.equilibrium([0, 0, 0], WRENCH).deflection, own.equilibrium([0, 0, 0], WRENCH).deflection
        )
        assert copy.copy(own) == own and copy.deepcopy(own) == own
    assert machine != other and machine != "orthoglide"
    assert machine == Machine.from_toml(machine.toml)
