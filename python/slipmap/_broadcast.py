"""Elementwise calls over numbers, NumPy arrays, dask arrays and xarray objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    import dask.array

Kernel = Callable[[list[np.ndarray]], tuple[np.ndarray, ...]]

# What broadcasts: a result is of the kind of its arguments, as that of a ufunc of NumPy, and is typed as there.
Numbers: TypeAlias = "ArrayLike | xr.DataArray | xr.Variable | pd.Series | dask.array.Array"


class Output(NamedTuple):
    """A result of an elementwise call."""

    name: str
    dtype: type
    long_name: str
    attrs: Mapping[str, Any] = {}
    axis: tuple[str, np.ndarray, str] | None = None
    """A last axis of its own: name, nodes and long name."""


def elementwise(kernel: Kernel, arguments: Mapping[str, Any], outputs: Sequence[Output]) -> tuple[Any, ...]:
    """Applies `kernel` to the broadcast arguments, as a NumPy ufunc would.

    `kernel` takes one flat array per argument, of length 1 or of the common length, and returns one array per output:
    flat, or with the output's own axis behind. Masked arrays give masked arrays, a pandas Series a Series (or a
    DataFrame) with its index.
    """
    names = list(arguments)
    values = [_numbers(name, value) for name, value in arguments.items()]
    dtypes = [output.dtype for output in outputs]
    axes = [output.axis for output in outputs if output.axis is not None]
    sizes = {name: nodes.size for name, nodes, _ in axes}

    def block(*arrays: Any) -> Any:
        results = _apply(kernel, names, arrays, outputs)
        return results if len(outputs) > 1 else results[0]

    def each(results: Any) -> tuple[Any, ...]:
        return tuple(results) if len(outputs) > 1 else (results,)

    if any(isinstance(value, (xr.DataArray, xr.Variable)) for value in values):
        results = xr.apply_ufunc(
            block,
            *values,
            output_core_dims=[[output.axis[0]] if output.axis else [] for output in outputs],
            dask="parallelized",
            output_dtypes=dtypes,
            dask_gufunc_kwargs={"output_sizes": sizes},
        )
        return tuple(_described(result, output) for result, output in zip(each(results), outputs, strict=True))
    if any(_is_dask(value) for value in values):
        import dask.array as da

        cores = ",".join(f"({output.axis[0]})" if output.axis else "()" for output in outputs)
        signature = f"{','.join('()' for _ in values)}->{cores}"
        return each(da.apply_gufunc(block, signature, *values, output_dtypes=dtypes, output_sizes=sizes))
    series = [value for value in values if isinstance(value, pd.Series)]
    results = _apply(kernel, names, values, outputs)
    if not series:
        return results
    index = series[0].index
    if not all(other.index.equals(index) for other in series):
        raise ValueError("the pandas Series have different indexes; align them first")
    return tuple(_indexed(result, index, output) for result, output in zip(results, outputs, strict=True))


def named(names: Sequence[str], results: Sequence[Any]) -> Any:
    """Results by name: a Dataset if they are DataArrays, a DataFrame if they are Series, else a dict."""
    by_name = dict(zip(names, results, strict=True))
    if isinstance(results[0], pd.Series):
        return pd.DataFrame(by_name)
    return xr.Dataset(by_name) if isinstance(results[0], xr.DataArray) else by_name


def _described(result: Any, output: Output) -> Any:
    """A result of xarray with name and attributes of its own, not those of an argument."""
    result.attrs = {"long_name": output.long_name, "units": "1", **output.attrs}
    if not isinstance(result, xr.DataArray):
        return result
    if output.axis is not None:
        name, nodes, long_name = output.axis
        result = result.assign_coords({name: (name, nodes, {"long_name": long_name, "units": "1"})})
    return result.rename(output.name)


def _indexed(result: Any, index: pd.Index, output: Output) -> Any:
    """The result with the index of its arguments, unless it has other elements."""
    if np.shape(result)[:1] != index.shape or np.ndim(result) != (1 if output.axis is None else 2):
        return result
    if output.axis is None:
        return pd.Series(result, index, name=output.name)
    return pd.DataFrame(result, index, pd.Index(output.axis[1], name=output.axis[0]))


def _is_dask(value: Any) -> bool:
    return type(value).__module__.startswith("dask.")


def _numbers(name: str, value: Any) -> Any:
    """The value as real numbers; told by its name if it has none."""
    if isinstance(value, (xr.DataArray, xr.Variable)) or _is_dask(value):
        if value.dtype.kind not in "iufb":
            raise TypeError(f"{name}: real numbers are needed, not {value.dtype}")
        return value
    try:
        if isinstance(value, pd.Series):
            return value.astype(float)
        array = value if isinstance(value, np.ma.MaskedArray) else np.asarray(value)
        if array.dtype.kind not in "iufb":
            raise TypeError
        return array.astype(float, copy=False)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: real numbers are needed, not {value!r:.60}") from None


def flat(values: Any) -> np.ndarray:
    """The numbers in a row as the compiled part takes them: contiguous, aligned, of native byte order, NaN if masked."""
    return np.require(_unmasked(values), float, ["C", "A", "E"]).reshape(-1)


def _unmasked(values: Any) -> Any:
    return np.ma.filled(values.astype(float), np.nan) if isinstance(values, np.ma.MaskedArray) else values


def _apply(kernel: Kernel, names: list[str], values: Sequence[Any], outputs: Sequence[Output]) -> tuple[Any, ...]:
    try:
        shape = np.broadcast_shapes(*(np.shape(value) for value in values))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(value)}" for name, value in zip(names, values, strict=True) if np.ndim(value))
        raise ValueError(f"these shapes cannot be broadcast together: {shapes}") from None
    masks = [np.ma.getmaskarray(value) for value in values if isinstance(value, np.ma.MaskedArray)]
    shapes_of = [shape if output.axis is None else (*shape, output.axis[1].size) for output in outputs]
    if 0 in shape:
        return tuple(np.empty(own, output.dtype) for own, output in zip(shapes_of, outputs, strict=True))
    arrays = [
        flat(value if np.size(value) == 1 else np.broadcast_to(_unmasked(value), shape))
        for value in values
    ]
    # A 0-d result is a NumPy scalar, as from a ufunc.
    results = [np.asarray(result).reshape(own)[()] for result, own in zip(kernel(arrays), shapes_of, strict=True)]
    if not masks:
        return tuple(results)
    mask = np.broadcast_to(np.logical_or.reduce(np.broadcast_arrays(*masks)), shape)
    return tuple(
        np.ma.array(result, mask=np.broadcast_to(mask.reshape(shape + (1,) * (len(own) - len(shape))), own))[()]
        for result, own in zip(results, shapes_of, strict=True)
    )
