"""What the critical damping depends on."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from . import _core
from ._broadcast import Numbers, Output, elementwise, named
from ._law import Law, _scalar, arguments_of


def sensitivity(
    law: Law,
    *,
    V: Numbers,
    epsilon: Numbers | None = None,
    return_error: bool = False,
    threads: int | None = None,
    **parameters: Numbers,
) -> Any:
    """Partial derivatives of the critical damping c* by epsilon, by the law's own parameters and by V.

    Parameters
    ----------
    law, V, epsilon, threads, **parameters
        As in :func:`critical_c`.
    return_error : bool
        Whether to return error estimates too.

    Returns
    -------
    derivatives : dict or Dataset
        ``dc_dV`` and so on, each broadcast as :func:`critical_c`; a Dataset if an argument is a DataArray, a DataFrame
        if one is a Series.
        NaN where c* is negative, there is none or none known to 1 %, and where the derivative is not either.
    errors : like `derivatives`
        Estimates of their absolute errors; only if `return_error`.

    Notes
    -----
    Weighted means over the grazing orbit, one for each parameter: see "Sensitivity" in the theory pages of
    the crate. At first order a standard error s of a parameter makes one of ``abs(derivative) * s`` of c*.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> slopes = slipmap.sensitivity(law, V=0.6, epsilon=2.0)
    >>> c = slipmap.critical_c(law, V=0.6, epsilon=2.0)
    >>> bool(abs(slopes["dc_depsilon"] + c / 2.0) < 1e-9)      # epsilon c* does not depend on epsilon
    True
    """

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        values, errors = _core.sensitivity(law._law, arrays, threads)
        return (*values[:-1], *errors[:-1])

    arguments = arguments_of(law, parameters, epsilon=epsilon, V=V)
    names = [f"dc_d{name}" for name in arguments]
    outputs = [
        Output(f"dc_d{name}", np.float64, f"{what} of the critical damping by {name}")
        for what in ("derivative", "error estimate of the derivative")
        for name in arguments
    ]
    results = elementwise(kernel, arguments, outputs)
    values, errors = named(names, results[: len(names)]), named(names, results[len(names) :])
    return (values, errors) if return_error else values


def standard_error(
    law: Law, *, V: Numbers, epsilon: Numbers | None = None, return_error: bool = False, threads: int | None = None
) -> Any:
    """Standard error of the critical damping that the standard errors of a table's data make.

    Parameters
    ----------
    law : Law
        A table with standard errors: ``Law.table(u, friction, stderr)``. They are taken to be independent.
    V, epsilon, threads
        As in :func:`critical_c`.
    return_error : bool
        Whether to return an estimate of its own error too.

    Returns
    -------
    standard_error : ndarray, scalar or DataArray
        To first order in the errors of the data, as :func:`critical_c` broadcasts.
    error : like `standard_error`
        Estimate of the absolute error of the computation; only if `return_error`.

    Raises
    ------
    TypeError
        If the law is no table with standard errors.

    Notes
    -----
    Friction is in units of the static one: the datum at slip speed 0 scales all others.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.table([0.0, 0.5, 1.0, 2.0, 4.0], [0.40, 0.31, 0.28, 0.26, 0.25], stderr=0.002)
    >>> bool(0.0 < slipmap.standard_error(law, V=1.0, epsilon=1.0) < 0.05)
    True
    """
    arguments = arguments_of(law, {}, epsilon=epsilon, V=V)
    if not law._law.has_standard_errors:
        raise TypeError("law: a table with standard errors is needed, Law.table(u, friction, stderr)")

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        values, errors = _core.sensitivity(law._law, arrays, threads)
        return values[-1], errors[-1]

    outputs = [
        Output(name, np.float64, f"{what} of the critical damping, from the data's")
        for name, what in (("standard_error", "standard error"), ("error", "error estimate of the standard error"))
    ]
    results = elementwise(kernel, arguments, outputs)
    return results if return_error else results[0]


def influence(
    law: Law, parts: int = 64, *, V: float, epsilon: float | None = None, **parameters: float
) -> xr.Dataset:
    """The weight of the friction's slope at each slip speed, for the critical damping.

    Parameters
    ----------
    law : Law
        The friction law.
    parts : int
        Number of equal ranges of slip speeds, from 0 to the fastest on the grazing orbit.
    V, epsilon, **parameters : float
        The column, as in :func:`critical_c`.

    Returns
    -------
    xarray.Dataset
        ``share`` along ``slip_speed``, the middles of the ranges, whose ends are ``slip_from`` and
        ``slip_to``. A change of the weakening rate by dw throughout a range moves epsilon c* by the range's
        share of dw. All shares are at least 0 and add up to 1.

    Raises
    ------
    ValueError
        If there is no critical damping c* >= 0.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> shares = slipmap.influence(law, V=0.6, epsilon=1.0).share
    >>> round(float(shares.sum()), 12)
    1.0
    """
    if parts < 1:
        raise ValueError(f"parts = {parts}: must be at least 1")
    arguments = arguments_of(law, parameters, epsilon=epsilon, V=V)
    values = [_scalar(name, value) for name, value in arguments.items()]
    edges, shares = _core.influence(law._law, values, parts)
    data = xr.Dataset(
        {
            "share": ("slip_speed", shares, {"long_name": "weight of the friction's slope", "units": "1"}),
            "slip_from": ("slip_speed", edges[:-1], {"long_name": "slip speed from here", "units": "1"}),
            "slip_to": ("slip_speed", edges[1:], {"long_name": "slip speed to here", "units": "1"}),
        },
        coords={"slip_speed": 0.5 * (edges[:-1] + edges[1:])},
        attrs={"law": law.name, **dict(zip(arguments, values, strict=True))},
    )
    data["slip_speed"].attrs = {"long_name": "slip speed, middle of the range", "units": "1"}
    return data
