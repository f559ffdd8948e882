"""Which numbers of a machine its deflection depends on: Sobol indices of SALib over named parameters."""

from SALib.analyze import sobol as analyze
from SALib.sample import sobol as sample

from kinetostat import Machine

machine = Machine("orthoglide")
own = machine.parameters()
names = ["leg.rail.stiffness", "leg.foot.height", "leg.foot.width"]
values = {name: own[name].value or 0.0 for name in names}
problem = {"num_vars": 3, "names": names, "bounds": [[0.9 * value, 1.1 * value] for value in values.values()]}

rows = sample.sample(problem, 256, calc_second_order=False, seed=1)
moved = machine.deflection(rows, names, pose=[30, -40, 75], wrench=[215, -10, -25, 0, 0, 0])
indices = analyze.analyze(problem, moved[:, 0], calc_second_order=False, seed=1)
for name, share in zip(names, indices["ST"], strict=True):
    print(f"{name}: {share:.2f}")
