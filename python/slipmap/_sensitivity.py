"""How the critical damping answers to its parameters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from ._elementwise import critical_c
from ._law import Law

# Relative step of the coarser of two differences; the finer has half of it.
_STEP = 4e-3
# Derivative at the point of the polynomial through five equidistant nodes, whose middle lies `shift` steps beside it.
_WEIGHTS = {
    shift: np.linalg.solve(np.vander(np.arange(-2.0, 3.0) + shift, increasing=True).T, [0.0, 1.0, 0.0, 0.0, 0.0])
    for shift in (-2, 0, 2)
}


def sensitivity(
    law: Law,
    *,
    V: Any,
    epsilon: Any,
    wrt: Iterable[str] | None = None,
    return_error: bool = False,
    threads: int | None = None,
    **parameters: Any,
) -> Any:
    """Partial derivatives of the critical damping c* by V, by epsilon and by the law's own parameters.

    Parameters
    ----------
    law, V, epsilon, threads, **parameters
        As in :func:`critical_c`.
    wrt : iterable of str, optional
        By which parameters; by default by all of them.
    return_error : bool
        Whether to return error estimates too.

    Returns
    -------
    derivatives : dict or Dataset
        ``dc_dV`` and so on, each broadcast as :func:`critical_c`; a Dataset if an argument is a DataArray.
    errors : like `derivatives`
        Estimates of their absolute errors: the change from twice the step, and what the errors of c* allow. Only if
        `return_error`.

    Notes
    -----
    Differences of five critical dampings each, which are accurate to rounding; at the edge of a parameter's domain to
    one side. At first order a standard error s of a parameter makes one of ``abs(derivative) * s`` of c*.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> slopes = slipmap.sensitivity(law, V=0.6, epsilon=2.0)
    >>> c = slipmap.critical_c(law, V=0.6, epsilon=2.0)
    >>> bool(abs(slopes["dc_depsilon"] + c / 2.0) < 1e-9)      # epsilon c* does not depend on epsilon
    True
    """
    arguments = law._arguments(parameters, epsilon=epsilon, V=V)
    names = list(arguments) if wrt is None else list(wrt)
    for name in names:
        if name not in arguments:
            raise ValueError(f"wrt: `{name}` is no parameter of c*; choose from: {', '.join(arguments)}")
    tiny = float(np.finfo(float).tiny)
    least: dict[str, float] = {"V": tiny, "epsilon": tiny}
    most: dict[str, float] = {}
    for name, _, low, high in law._law.parameters:
        least[name], most[name] = low, high
    values: dict[str, Any] = {}
    errors: dict[str, Any] = {}
    for name in names:
        at = _as_real(arguments[name])
        positive = least[name] > 0.0
        scale = abs(at) if positive else _maximum(abs(at), 0.05)

        def slope(step: Any, name: str = name, at: Any = at) -> tuple[Any, Any]:
            low, high = at - 2 * step < least[name], at + 2 * step > most.get(name, np.inf)
            shift = 2 * _as_int(low) - 2 * _as_int(high & ~low)
            total: Any = 0.0
            uncertain: Any = 0.0
            for j in range(-2, 3):
                weight = sum(_WEIGHTS[k][j + 2] * _as_int(shift == k) for k in (-2, 0, 2))
                node = at + (shift + j) * step
                own = {**arguments, name: node}
                c, error = critical_c(
                    Law(law._law, {}), **own, tolerance=1e-13, threads=threads, return_error=True
                )
                total, uncertain = total + weight * c, uncertain + abs(weight) * error
            return total / step, uncertain / step

        coarse, _ = slope(_STEP * scale)
        fine, uncertain = slope(0.5 * _STEP * scale)
        values[f"dc_d{name}"] = fine
        errors[f"dc_d{name}"] = abs(fine - coarse) + uncertain
    slopes = _named(values, "derivative of the critical damping")
    return (slopes, _named(errors, "error estimate of the derivative")) if return_error else slopes


def standard_error(law: Law, *, V: Any, epsilon: Any, threads: int | None = None) -> Any:
    """Standard error of the critical damping that the standard errors of a table's data make.

    Parameters
    ----------
    law : Law
        A table with standard errors: ``Law.table(u, friction, stderr)``. The errors are taken to be independent.
    V, epsilon, threads
        As in :func:`critical_c`.

    Returns
    -------
    ndarray, scalar or DataArray
        The root of the sum of squares of what each datum's standard error does to c*, as :func:`critical_c` broadcasts.

    Raises
    ------
    TypeError
        If the law is no table with standard errors.

    Notes
    -----
    Half the difference of the critical dampings with the datum raised and lowered by its standard error. Friction is in units
    of the static one: the datum at slip speed 0 scales all others.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.table([0.0, 0.5, 1.0, 2.0, 4.0], [0.40, 0.31, 0.28, 0.26, 0.25], stderr=0.002)
    >>> bool(0.0 < slipmap.standard_error(law, V=1.0, epsilon=1.0) < 0.05)
    True
    """
    data = law._law.data
    if data is None or data[3] is None:
        raise TypeError("law: a table with standard errors is needed, Law.table(u, friction, stderr)")
    u, friction, static, errors = np.array(data[0]), np.array(data[1]), data[2], data[3]
    total: Any = 0.0
    for datum, error in enumerate(errors):
        if error == 0.0:
            continue
        ends = []
        for sign in (1.0, -1.0):
            moved = friction.copy()
            moved[datum] += sign * error
            level = static * moved[0] / friction[0]
            shifted = Law.table(u, moved, static=level, origin="the table with one datum moved")
            ends.append(critical_c(shifted, V=V, epsilon=epsilon, threads=threads))
        total = total + (0.5 * (ends[0] - ends[1])) ** 2
    return total**0.5


def _as_real(value: Any) -> Any:
    return value.astype(float) if hasattr(value, "astype") else np.asarray(value, dtype=float)[()]


def _as_int(flags: Any) -> Any:
    return flags.astype(int) if hasattr(flags, "astype") else int(flags)


def _maximum(value: Any, least: float) -> Any:
    return np.maximum(value, least)


def _named(by_name: dict[str, Any], what: str) -> Any:
    if not any(isinstance(it, xr.DataArray) for it in by_name.values()):
        return by_name
    data = xr.Dataset(by_name)
    for variable in data.data_vars.values():
        variable.attrs = {"long_name": what, "units": "1"}
    return data
