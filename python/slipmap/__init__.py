"""Where a dry-friction oscillator on a moving belt stick-slips, which test proves it, and how surely.

NumPy arrays in, xarray out; the work is done by the compiled engine of the program ``slipmap``, without the
GIL and on all cores. All quantities are dimensionless (see :class:`Machine` for SI): time in sqrt(mass /
stiffness), force in units of the static friction force.

Examples
--------
>>> import numpy as np, slipmap
>>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
>>> slipmap.verdicts(law, V=0.6, c=[0.1, 0.4], epsilon=1.0, methods="simulation")
array([ 1, -1], dtype=int8)
"""

from ._accessor import MapAccessor
from ._backbone import backbone
from ._codes import METHODS, Method, Regime, Verdict
from ._core import __version__
from ._elementwise import critical_c, regime, verdicts
from ._files import MapError, open_map
from ._fit import Fit
from ._law import Law
from ._machine import Machine, Page, Units
from ._maps import map, run
from ._orbits import curves, orbit, phase_portrait
from ._point import Point, probe
from ._probe import Probe
from ._sensitivity import influence, sensitivity, standard_error

__all__ = [
    "METHODS",
    "Fit",
    "Law",
    "Machine",
    "MapAccessor",
    "MapError",
    "Method",
    "Page",
    "Point",
    "Probe",
    "Regime",
    "Units",
    "Verdict",
    "__version__",
    "backbone",
    "critical_c",
    "curves",
    "influence",
    "map",
    "open_map",
    "orbit",
    "phase_portrait",
    "probe",
    "regime",
    "run",
    "sensitivity",
    "standard_error",
    "verdicts",
]
