"""How far the tool moves under a force, how stiff the machine is there, and what to command instead."""

import numpy as np

from kinetostat import Machine

machine = Machine("orthoglide")
low, high = machine.workspace_mm
wrench = [215.0, -10.0, -25.0, 0.0, 0.0, 0.0]

one = machine.equilibrium((low + high) / 2, wrench)
print(one, one.deflection)

places = np.random.default_rng(0).uniform(low, high, (1000, 3))
many = machine.equilibrium(places, wrench)
print(many, many.distance.mean())

stiffness = machine.stiffness(places[:10])
print(np.linalg.eigvalsh(stiffness[:, :3, :3]).min(axis=-1))

better = machine.compensate(places, wrench)
print(better, np.abs(better.delta_rho).max(axis=0))
