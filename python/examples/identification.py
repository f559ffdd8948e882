"""How stiff the joints of an arm are, by pushing it, and what it would show elsewhere."""

import numpy as np

from kinetostat import Machine, identify, predict

JOINT = "arm.J2.stiffness"

arm = Machine("fanuc_r2000ic")
random = np.random.default_rng(1)
poses = {"drives": random.uniform(-0.6, 0.6, (12, 6)), "force_N": random.uniform(-800.0, 800.0, (12, 3))}
softer = arm.with_parameters({JOINT: 1.0e9})
displaced = predict(softer, poses)["predicted"].reshape(12, 3) + random.normal(0.0, 0.01, (12, 3))

found = identify(
    arm, {**poses, "displacement_mm": displaced}, "arm.J*.stiffness", std_mm=0.01, figures=False, progress=False
)
print(found)
table = found.parameters
for row in range(table.rows):
    print(f"{table['parameter'][row]}: {table['value'][row]:.4g} ± {table['std'][row]:.2g}, {table['status'][row]}")
assert found.machine is not None
print(found.machine.parameters()[JOINT].interval)

elsewhere = predict(found, {"drives": np.zeros((1, 6)), "force_z_N": -500.0})
print(elsewhere["low_95"], elsewhere["high_95"])
