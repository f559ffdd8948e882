"""How far a loaded machine leaves its path, which drive commands compensate that, and where to put the workpiece.

Units are mm, N, N·mm and rad, unless a name or a column ends with another one. Poses are those of P, the point of the
platform (or flange) that carries the tool, in the base frame O; wrenches act at P and are written in the axes of O:
force first, then moment.

An outcome that cannot be solved is data (a status, a reason, NaN), wrong input an :class:`Error` in the words of the
command line.

>>> import kinetostat
>>> machine = kinetostat.Machine("orthoglide")
>>> machine.equilibrium([30, -40, 75], [215, -10, -25, 0, 0, 0]).deflection.round(3)
array([ 0.082,  0.02 , -0.078])
"""

from ._kinetostat import Error, __version__
from .identification import Identification, Predictions, identify, predict
from .machine import Machine, Parameter, machine_names
from .process import Process
from .program import CompensatedProgram, Followed, Path
from .results import Compensation, Equilibrium
from .study import Answer, place, run, workspace_map
from .table import Column, Table
from .uncertainty import Sample, UncertainInput, Uncertainty

__all__ = [
    "Answer",
    "Column",
    "CompensatedProgram",
    "Compensation",
    "Equilibrium",
    "Error",
    "Followed",
    "Identification",
    "Machine",
    "Parameter",
    "Path",
    "Predictions",
    "Process",
    "Sample",
    "Table",
    "UncertainInput",
    "Uncertainty",
    "__version__",
    "identify",
    "machine_names",
    "place",
    "predict",
    "run",
    "workspace_map",
]
