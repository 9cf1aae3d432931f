"""Orbits, phase portraits and curves of codimension one."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from . import _core
from ._broadcast import Numbers
from ._law import Law, _scalar, arguments_of, no_machine
from ._point import Point, probe

PHASES = {"slip_below": -1, "stick": 0, "slip_above": 1}
_PHASE_FLAGS = {
    "flag_values": np.array([-1, 0, 1], dtype=np.int8),
    "flag_meanings": "slip_below stick slip_above",
}
_LONG_NAMES = {"x1": "position", "x2": "velocity", "phase": "what the mass does from here on"}


def orbit(
    point: Point,
    start: tuple[float, float] | None = None,
    *,
    max_time: float = 100.0,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """One orbit, sampled: slipping, crossing and sticking.

    Parameters
    ----------
    point : Point
        The parameters.
    start : (x1, x2), optional
        Where it starts; by default the exit point, through which every sticking orbit leaves the belt.
    max_time : float
        Longest time, in units of sqrt(mass / stiffness).
    tolerance : float
        Error aimed at, as in :func:`probe`.

    Returns
    -------
    xarray.Dataset
        ``x1``, ``x2`` and ``phase`` along ``time``, at most 0.1 rad apart while slipping; contacts with the
        belt line are among the samples. Attributes: ``ending`` ("closes", "settles", "out_of_time" or
        "failed: ..") and, of an orbit that closes, ``period``.

    Examples
    --------
    >>> import slipmap
    >>> point = slipmap.Point(slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0), V=1.0, c=0.3, epsilon=0.1)
    >>> cycle = slipmap.orbit(point)
    >>> cycle.attrs["ending"], bool(cycle.x2.max() == 1.0)
    ('closes', True)
    """
    if not isinstance(point, Point):
        raise TypeError(f"point: {no_machine(point, 'Point')}")
    if start is not None:
        start = (_scalar("start x1", start[0]), _scalar("start x2", start[1]))
    if not max_time > 0.0:
        raise ValueError(f"max_time = {max_time}: must be greater than 0")
    values = list(point.values.values())
    time, x1, x2, phase, ending, period = _core.orbit(point.law._law, values, start, tolerance, float(max_time))
    data = xr.Dataset(
        {"x1": ("time", x1), "x2": ("time", x2), "phase": ("time", phase)},
        coords={"time": time},
        attrs={"ending": ending, **point.values},
    )
    if period is not None:
        data.attrs["period"] = period
    for name, long_name in _LONG_NAMES.items():
        data[name].attrs.update({"long_name": long_name, "units": "1"})
    data["phase"].attrs.update(_PHASE_FLAGS)
    return data


def phase_portrait(point: Point, *, max_time: float = 40.0 * math.pi, tolerance: float = 1e-9) -> xr.Dataset:
    """The orbits that tell what the flow does at a point.

    From the exit point, from near steady slip, from far out, and the unstable slip cycle, if there is one.

    Parameters
    ----------
    point, max_time, tolerance
        As in :func:`orbit`.

    Returns
    -------
    xarray.Dataset
        ``time``, ``x1``, ``x2`` and ``phase`` along ``sample``; the coordinate ``orbit`` names the orbit of
        each sample: "exit", "inner", "outer" and "unstable_cycle". Scalars: ``equilibrium_x1`` and the ends
        ``exit_x1`` and ``upper_tangency_x1`` of the stick segment, which lies at x2 = V.
    """
    answer = probe(point, tolerance=tolerance)
    speed, rest = point["V"], answer.equilibrium.x1
    starts: dict[str, tuple[float, float] | None] = {
        "exit": None,
        "inner": (rest, 0.05 * speed),
        "outer": (answer.exit_point.x1 + 0.5, speed),
    }
    lengths = dict.fromkeys(starts, max_time)
    cycle = answer.basin_boundary.cycle if answer.basin_boundary else None
    if cycle is not None:
        # Where x2 is largest, x2' = 0: the spring balances friction and damping.
        top = cycle.x2.hi
        friction = float(point.law.phi(speed - top, epsilon=point["epsilon"]))
        starts["unstable_cycle"] = (friction - point["epsilon"] * point["c"] * top, top)
        lengths["unstable_cycle"] = cycle.period
    parts = []
    for name, start in starts.items():
        part = orbit(point, start, max_time=lengths[name], tolerance=tolerance)
        columns = {key: ("sample", part[key].values, part[key].attrs) for key in ("time", "x1", "x2", "phase")}
        parts.append(xr.Dataset(columns, {"orbit": ("sample", [name] * part.sizes["time"])}))
    portrait = xr.concat(parts, "sample", combine_attrs="override")
    portrait["equilibrium_x1"] = rest
    portrait["exit_x1"] = answer.sliding_segment.to_x1
    portrait["upper_tangency_x1"] = answer.sliding_segment.from_x1
    portrait.attrs.update(point.values)
    return portrait


def curves(
    law: Law, *, V: Numbers, c: Numbers, epsilon: Numbers | None = None, threads: int | None = None, **parameters: Numbers
) -> xr.Dataset:
    """Curves in a plane of two parameters on which the long-run behaviour changes, by continuation.

    Parameters
    ----------
    law : Law
        The friction law.
    V, c, epsilon, **parameters : float or array_like
        Two of them are the plane: give two numbers or more, growing, of which the first and the last are its
        sides (more than two of equal ratios: the side is logarithmic). The others are numbers.
    threads : int, optional
        Number of threads; by default one per core.

    Returns
    -------
    xarray.Dataset
        Along ``point``, as in the group "curves" of a map: ``curve`` (code of what happens there: Hopf,
        grazing, landing, crossing, fold; of points of codimension two Bautin, Hopf at grazing, fold at grazing,
        cusp, each a branch of one point), ``branch`` (number of the connected curve), the values of the two
        axes, and ``error``, the estimated distance from the curve in sides of the plane.

    Raises
    ------
    ValueError
        If not exactly two parameters have several values.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    >>> found = slipmap.curves(law, V=[0.5, 2.0], c=[0.0, 1.5], epsilon=0.1)
    >>> "hopf" in found.curve.attrs["flag_meanings"]
    True
    """
    arguments = arguments_of(law, parameters, epsilon=epsilon, V=V, c=c)
    nodes = {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in arguments.items()}
    plane = [name for name, values in nodes.items() if values.size > 1]
    if len(plane) != 2:
        raise ValueError(f"two parameters make a plane, but {len(plane)} have several values: {', '.join(plane)}")
    x, y = plane
    names = list(nodes)
    rows = [values.tolist() for values in nodes.values()]
    found = _core.curves(law._law, rows, names.index(x), names.index(y), threads)
    kinds: list[str] = list(dict.fromkeys(kind for kind, *_ in found))
    codes, branches, columns = [], [], {x: [], y: [], "error": []}  # type: ignore[var-annotated]
    seen: dict[str, int] = {}
    for kind, at_x, at_y, error in found:
        seen[kind] = seen.get(kind, 0) + 1
        codes.append(np.full(len(at_x), kinds.index(kind), dtype=np.int8))
        branches.append(np.full(len(at_x), seen[kind], dtype=np.int32))
        for name, values in ((x, at_x), (y, at_y), ("error", error)):
            columns[name].append(values)

    def column(parts: list[np.ndarray], dtype: type) -> tuple[str, np.ndarray]:
        return ("point", np.concatenate(parts) if parts else np.empty(0, dtype))

    data = xr.Dataset(
        {
            "curve": column(codes, np.int8),
            "branch": column(branches, np.int32),
            **{name: column(parts, np.float64) for name, parts in columns.items()},
        },
        attrs={name: float(values[0]) for name, values in nodes.items() if values.size == 1},
    )
    data["curve"].attrs = {
        "long_name": "what happens on the curve",
        "flag_values": np.arange(len(kinds), dtype=np.int8),
        "flag_meanings": " ".join(kinds),
    }
    data["branch"].attrs = {"long_name": "number of the connected curve in its plane and kind"}
    data["error"].attrs = {"long_name": "estimate of the distance from the curve, in sides of the plane"}
    data.attrs.update({"law": law.name, "plane_x": x, "plane_y": y})
    return data
