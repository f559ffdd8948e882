"""OpenTURNS drives the machine: its distributions, its sample, and the same quantile. `pip install openturns`."""

import numpy as np
import openturns as ot

import kinetostat

machine = kinetostat.Machine("orthoglide")
uncertainty = kinetostat.Uncertainty(
    machine,
    {
        "parameter": [{"name": "leg.rail.stiffness", "relative_std": 0.3}],
        "process": {"force_relative_std": 0.15},
    },
)
place, wrench = [30.0, -40.0, 75.0], [215.0, -10.0, -25.0, 0.0, 0.0, 0.0]

# Medians are the nominal values; of the force, the 95 % interval says how wide it is.
low, high = uncertainty.force_factor or (1.0, 1.0)
marginals = [ot.LogNormal(np.log(own.value), own.numbers[0], 0.0) for own in uncertainty.inputs]
marginals.append(ot.LogNormal(0.0, np.log(high / low) / (2.0 * 1.959964), 0.0))
joint = ot.JointDistribution(marginals)

sample = np.array(ot.LowDiscrepancyExperiment(ot.SobolSequence(), joint, 4096).generate())
distances = uncertainty.deflection((sample[:, :-1], sample[:, -1]), place, wrench)[:, 0]

ours = uncertainty.quantiles(place, wrench)[:, 0]
theirs = np.quantile(distances, [0.5, 0.95])
print(f"median {ours[0]:.4f} mm, OpenTURNS {theirs[0]:.4f} mm; P95 {ours[1]:.4f} mm, OpenTURNS {theirs[1]:.4f} mm")
assert np.allclose(ours, theirs, rtol=0.01)
