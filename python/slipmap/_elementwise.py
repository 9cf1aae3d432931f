"""Functions of parameters that broadcast like NumPy's ufuncs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from . import _core
from ._broadcast import Numbers, Output, elementwise, named
from ._codes import METHODS, REGIME_FLAGS, VERDICT_FLAGS
from ._law import Law, arguments_of
from ._progress import Progress, told


def critical_c(
    law: Law,
    *,
    V: Numbers,
    epsilon: Numbers | None = None,
    return_error: bool = False,
    tolerance: float = 1e-9,
    threads: int | None = None,
    progress: Progress = False,
    **parameters: Numbers,
) -> Any:
    """Critical damping c*: a stick-slip orbit returns to the belt for c < c* and not for c > c*.

    Parameters
    ----------
    law : Law
        The friction law.
    V : array_like
        Belt speed, greater than 0, in units of (static force) / sqrt(stiffness * mass).
    epsilon : array_like, optional
        Size of the small terms, greater than 0; the viscous force is -epsilon c x2. By default 1 for a law that does not
        contain it; other laws need it.
    return_error : bool
        Whether to return the error estimate too.
    tolerance : float
        Error aimed at, relative to the size of the divergence; from 1e-14 to 1e-2.
    threads : int, optional
        Number of threads; by default one per core.
    progress : bool or callable
        True shows a bar (of tqdm, if it is there); a function is called with the values done and all values. Of dask arrays
        each block has its own; dask's ProgressBar shows all.
    **parameters : array_like
        The law's own parameters that it does not hold itself.

    Returns
    -------
    c : ndarray, scalar, DataArray, Series or dask array
        Of the shape to which the arguments broadcast; dimensions, coordinates and the index of a Series are kept, and
        what is masked in an argument is masked.
        Negative where no damping c >= 0 is small enough; NaN where an argument is NaN, where the orbit
        that grazes the belt line cannot be followed, and where the error is more than 1 % of it (and 1e-9).
    error : like `c`
        Estimate of its absolute error, also where that is too large for a value; only if `return_error`.

    Raises
    ------
    ValueError
        If an argument is outside its domain, or shapes do not broadcast; the message names the argument.
    TypeError
        If a parameter is missing or unknown.

    Notes
    -----
    Where the spectral iteration for the periodic grazing orbit converges, the error falls to rounding; see
    the theory pages of the crate, "The critical damping".

    Examples
    --------
    >>> import numpy as np, slipmap
    >>> law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    >>> slipmap.critical_c(law, V=np.array([0.5, 1.0, 2.0]), epsilon=0.1).round(4)
    array([ 0.7979,  0.4511, -0.1476])
    """

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        bar = told(progress, max(array.size for array in arrays), "values")
        values, errors = _core.critical_c(law._law, arrays, tolerance, threads, bar)
        return (values, errors) if return_error else (values,)

    outputs = [
        Output("critical_c", np.float64, "critical damping"),
        Output("critical_c_error", np.float64, "error estimate of the critical damping"),
    ]
    results = elementwise(kernel, arguments_of(law, parameters, epsilon=epsilon, V=V), outputs[: 1 + return_error])
    return results if return_error else results[0]


def verdicts(
    law: Law,
    *,
    V: Numbers,
    c: Numbers,
    epsilon: Numbers | None = None,
    methods: str | Iterable[str] | None = None,
    tolerance: float = 1e-9,
    threads: int | None = None,
    **parameters: Numbers,
) -> Any:
    """Does a stick-slip limit cycle exist? What each method says.

    Parameters
    ----------
    law : Law
        The friction law.
    V, epsilon : array_like
        As in :func:`critical_c`.
    c : array_like
        Viscous damping, at least 0.
    methods : str or iterable of str, optional
        One method, or several; by default the closed-form tests and the simulation. See ``slipmap.METHODS``.
    tolerance : float
        Bound on the error of the scaled grazing margin that the simulation aims at.
    threads : int, optional
        Number of threads; by default one per core.
    **parameters : array_like
        The law's own parameters that it does not hold itself.

    Returns
    -------
    ndarray, scalar, DataArray, Series or dask array; or a dict, Dataset or DataFrame of them
        Codes of :class:`Verdict` (int8): of the one method if `methods` is a str, else by name of the method,
        in a Dataset if an argument is a DataArray, in a DataFrame if one is a Series, and in a dict otherwise.
        ``NOT_COMPUTED`` where an argument is NaN.

    Raises
    ------
    ValueError
        If an argument is outside its domain, shapes do not broadcast, or there is no such method.

    Notes
    -----
    Elements that share all but `c` are one column, decided at once; a grid of V and c costs a root per V.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    >>> said = slipmap.verdicts(law, V=1.0, c=0.6, epsilon=0.1)
    >>> slipmap.Verdict(said["perturbation"]).name, slipmap.Verdict(said["symmetric"]).name
    ('PRESENT', 'ABSENT')
    >>> slipmap.verdicts(law, V=1.0, c=[0.3, 0.6], epsilon=0.1, methods="simulation")
    array([ 1, -1], dtype=int8)
    """
    single = isinstance(methods, str)
    names = [methods] if isinstance(methods, str) else list(_core.USUAL_METHODS if methods is None else methods)
    for name in names:
        if name not in METHODS:
            raise ValueError(f"methods: there is no method `{name}`; choose from: {', '.join(METHODS)}")

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        return tuple(_core.verdicts(law._law, arrays, names, tolerance, threads))

    outputs = [
        Output(
            f"verdict_{name}",
            np.int8,
            f"does a stick-slip limit cycle exist: {METHODS[name].long_name}",
            {**VERDICT_FLAGS, "guarantee": METHODS[name].guarantee, "equation": METHODS[name].equation},
        )
        for name in names
    ]
    results = elementwise(kernel, arguments_of(law, parameters, epsilon=epsilon, V=V, c=c), outputs)
    return results[0] if single else named(names, results)


def regime(
    law: Law,
    *,
    V: Numbers,
    c: Numbers,
    epsilon: Numbers | None = None,
    tolerance: float = 1e-9,
    threads: int | None = None,
    **parameters: Numbers,
) -> Any:
    """Long-run behaviour according to the simulated flow.

    Parameters are those of :func:`verdicts`.

    Returns
    -------
    ndarray, scalar, DataArray, Series or dask array
        Codes of :class:`Regime` (int8); ``FAILED`` where it is not determined or an argument is NaN.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    >>> slipmap.Regime(slipmap.regime(law, V=1.0, c=0.3, epsilon=0.1)).name
    'STICK_SLIP'
    """

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        return (_core.regime(law._law, arrays, tolerance, threads),)

    output = Output("regime", np.int8, "long-run behaviour according to the simulated flow", REGIME_FLAGS)
    return elementwise(kernel, arguments_of(law, parameters, epsilon=epsilon, V=V, c=c), [output])[0]
