"""Elementwise calls over numbers, NumPy arrays, dask arrays and xarray objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

Kernel = Callable[[list[np.ndarray]], tuple[np.ndarray, ...]]


def elementwise(
    kernel: Kernel, arguments: Mapping[str, Any], dtypes: Sequence[type], attrs: Sequence[Mapping[str, Any]]
) -> tuple[Any, ...]:
    """Applies `kernel` to the broadcast arguments, as a NumPy ufunc would.

    `kernel` takes one flat array per argument, of length 1 or of the common length, and returns one flat
    array per entry of `dtypes`. `attrs` are the attributes of results that are DataArrays.
    """
    names = list(arguments)
    values = [_numbers(name, value) for name, value in arguments.items()]

    def block(*arrays: Any) -> Any:
        results = _apply(kernel, names, arrays, dtypes)
        return results if len(dtypes) > 1 else results[0]

    if any(isinstance(value, (xr.DataArray, xr.Variable)) for value in values):
        results = xr.apply_ufunc(
            block,
            *values,
            output_core_dims=[[] for _ in dtypes],
            dask="parallelized",
            output_dtypes=list(dtypes),
        )
        results = results if len(dtypes) > 1 else (results,)
        for result, own in zip(results, attrs, strict=True):
            result.attrs = dict(own)
        return tuple(results)
    if any(_is_dask(value) for value in values):
        import dask.array as da

        signature = ",".join("()" for _ in values) + "->" + ",".join("()" for _ in dtypes)
        results = da.apply_gufunc(block, signature, *values, output_dtypes=list(dtypes))
        return tuple(results) if len(dtypes) > 1 else (results,)
    return _apply(kernel, names, values, dtypes)


def named(names: Sequence[str], results: Sequence[Any]) -> Any:
    """Results by name: a Dataset if they are DataArrays, else a dict."""
    by_name = dict(zip(names, results, strict=True))
    return xr.Dataset(by_name) if isinstance(results[0], xr.DataArray) else by_name


def _is_dask(value: Any) -> bool:
    return type(value).__module__.startswith("dask.")


def _numbers(name: str, value: Any) -> Any:
    """The value as real numbers; told by its name if it has none."""
    if isinstance(value, (xr.DataArray, xr.Variable)) or _is_dask(value):
        if value.dtype.kind not in "iufb":
            raise TypeError(f"{name}: real numbers are needed, not {value.dtype}")
        return value
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iufb":
            raise TypeError
        return array.astype(float, copy=False)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: real numbers are needed, not {value!r:.60}") from None


def flattened(names: list[str], values: Sequence[Any]) -> tuple[list[np.ndarray], tuple[int, ...]]:
    """Flat arrays of length 1 or of the common length, and the common shape."""
    arrays = [np.asarray(value, dtype=float) for value in values]
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in zip(names, arrays, strict=True) if array.ndim)
        raise ValueError(f"these shapes cannot be broadcast together: {shapes}") from None
    flat = [
        array.reshape(1) if array.size == 1 else np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1)
        for array in arrays
    ]
    return flat, shape


def _apply(kernel: Kernel, names: list[str], values: Sequence[Any], dtypes: Sequence[type]) -> tuple[Any, ...]:
    flat, shape = flattened(names, values)
    if 0 in shape:
        return tuple(np.empty(shape, dtype) for dtype in dtypes)
    # A 0-d result is a NumPy scalar, as from a ufunc.
    return tuple(np.asarray(result).reshape(shape)[()] for result in kernel(flat))
