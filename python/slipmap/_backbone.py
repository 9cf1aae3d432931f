"""The backbone: one damping for each amplitude of a slip cycle."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._broadcast import Numbers, Output, elementwise
from ._law import Law, arguments_of


def backbone(
    law: Law,
    amplitude: ArrayLike | None = None,
    *,
    V: Numbers,
    epsilon: Numbers | None = None,
    return_error: bool = False,
    tolerance: float = 1e-9,
    threads: int | None = None,
    **parameters: Numbers,
) -> Any:
    """The damping at which the slip cycle of each amplitude lives: all slip cycles of a column in one curve.

    For each amplitude r in (0, V] there is exactly one damping c = C(r) at which the orbit that turns at x2 =
    r closes. At damping c the slip cycles are the solutions of C(r) = c; one attracts where C falls with r,
    and repels where it rises. At r = 0 it is the Hopf damping, at r = V the critical damping, and its
    extremes between are folds.

    Parameters
    ----------
    law : Law
        The friction law.
    amplitude : array_like, optional
        Amplitudes in belt speeds, r / V, from 0 to 1; by default 65 equal steps.
    V, epsilon, tolerance, threads, **parameters
        As in :func:`critical_c`.
    return_error : bool
        Whether to return error estimates too.

    Returns
    -------
    c : ndarray, DataArray, DataFrame or dask array
        Dampings, of the shape to which the arguments broadcast and a last axis ``amplitude``. NaN where an
        argument is, or where an orbit could not be followed.
    error : ndarray, DataArray, Series or dask array
        Estimates of their absolute errors, without that axis; only if `return_error`.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> c = slipmap.backbone(law, [0.0, 0.5, 1.0], V=1.5, epsilon=1.0)
    >>> bool(abs(c[2] - slipmap.critical_c(law, V=1.5, epsilon=1.0)) < 1e-9)
    True
    """
    ratios = np.linspace(0.0, 1.0, 65) if amplitude is None else np.atleast_1d(np.asarray(amplitude, dtype=float))
    if ratios.ndim != 1 or not ((ratios >= 0.0) & (ratios <= 1.0)).all():
        raise ValueError("amplitude: one row of numbers from 0 to 1 is needed, in units of the belt speed")

    def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
        rows, errors = _core.backbone(law._law, arrays, ratios.tolist(), tolerance, threads)
        # The error of the law moves every damping of the curve, like the critical one, by at most itself.
        return rows, errors + law.error / arrays[0]

    outputs = [
        Output("backbone", np.float64, "damping of the slip cycle", axis=("amplitude", ratios, "amplitude over belt speed")),
        Output("backbone_error", np.float64, "error estimate of the damping"),
    ]
    results = elementwise(kernel, arguments_of(law, parameters, epsilon=epsilon, V=V), outputs)
    return results if return_error else results[0]
