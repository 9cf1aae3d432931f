"""Maps: every method at every cell of a grid."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from . import _core, _fingerprints
from ._law import Law, refuse_si
from ._progress import Progress, told


def map(
    grid: Mapping[str, Any],
    *,
    law: Law | None = None,
    methods: Iterable[str] | None = None,
    fields: Iterable[str] = (),
    tolerance: float = 1e-9,
    audit_cells: int = 1000,
    proof_boxes: int = 32,
    threads: int | None = None,
    progress: Progress = False,
    chunks: Mapping[str, int] | None = None,
) -> xr.Dataset:
    """Asks every method at every cell of a grid: the map that ``slipmap run`` writes, in memory.

    Parameters
    ----------
    grid : mapping of str to array_like
        Nodes of every axis, growing: epsilon, the law's own parameters, V and c; a number is an axis of one
        node. A Dataset of coordinates will do. Parameters that the law holds can be left out.
    law : Law, optional
        The friction law; by default the paper's.
    methods : iterable of str, optional
        By default the closed-form tests and the simulation. See ``slipmap.METHODS``.
    fields : iterable of str
        What to compute besides verdicts, by the names of ``output.fields`` in configurations: "margin", "regime" and others.
    tolerance : float
        Bound on the error of the scaled grazing margin that the simulation aims at.
    audit_cells : int
        Cells that the independent engine decides again; disagreements are counted in the attributes.
    proof_boxes : int
        Boxes that the method `validated`, if it is asked, tries to prove between the nodes.
    threads : int, optional
        Number of threads; by default one per core.
    progress : bool or callable
        True shows a bar (of tqdm, if it is there); a function is called with the cells done and all cells.
    chunks : mapping of str to int, optional
        Numbers of nodes in a block: the map is then made of dask arrays, and a block is computed when it is needed, for maps
        that do not fit into memory. Nodes that are dask arrays have blocks of their own.

    Returns
    -------
    xarray.Dataset
        Equal, variable by variable, attributes included, to the file that the program writes. A map in blocks has the same
        cells, without the audit, the fingerprints and what a run counts.

    Raises
    ------
    ValueError
        If an axis, a method or a field is wrong; the message names it.
    KeyboardInterrupt
        On Ctrl-C, after the tiles in work.

    Examples
    --------
    >>> import numpy as np, slipmap
    >>> grid = {"V": [0.5, 1.0], "c": np.linspace(0.0, 1.0, 5), "epsilon": 0.1}
    >>> data = slipmap.map(grid, law=slipmap.Law.stribeck(0.4, 0.2, 2.0), fields=["critical_c"])
    >>> data.verdict_simulation.squeeze().values
    array([[ 1,  1,  1,  1, -1],
           [ 1,  1, -1, -1, -1]], dtype=int8)
    """
    law = Law.stribeck() if law is None else law
    refuse_si(law)
    axes = {**{name: value for name, value in law.parameters.items() if value is not None}, **grid}
    unknown = [name for name in axes if name not in law.axes]
    if unknown:
        raise ValueError(f"{unknown[0]} is no axis of the law `{law.name}`; its axes are {', '.join(law.axes)}")
    missing = [name for name in law.axes if name not in axes]
    if missing:
        raise ValueError(f"the grid also needs {', '.join(missing)}; an axis of one node is a number")
    nodes = [_nodes(name, axes[name]) for name in law.axes]
    names, own_fields = None if methods is None else list(methods), list(fields)

    def compute(nodes: list[list[float]], audit_cells: int, progress: Progress) -> xr.Dataset:
        bar = told(progress, math.prod(len(axis) for axis in nodes), "cells")
        more = (names, own_fields, tolerance, audit_cells, proof_boxes, threads, bar)
        return _dataset(_core.compute_map(law._law, nodes, *more))

    blocks = {name: axes[name].chunks[0] for name in law.axes if getattr(axes[name], "chunks", None)}
    if not blocks and chunks is None:
        return compute(nodes, audit_cells, progress)
    lengths = {**dict.fromkeys(law.axes, -1), **blocks, **(chunks or {})}
    return _in_blocks(dict(zip(law.axes, nodes, strict=True)), lengths, lambda nodes: compute(nodes, 0, False))


# What the first block says of all.
_OF_ALL = ("Conventions", "source", "references", "law", "law_definition", "methods", "fields", "tolerance")


def _in_blocks(
    axes: Mapping[str, list[float]], chunks: Mapping[str, Any], compute: Callable[[list[list[float]]], xr.Dataset]
) -> xr.Dataset:
    """The map as dask arrays, whose blocks `compute` computes."""
    import dask.array as da

    def empty(names: Sequence[Any], dtype: Any) -> Any:
        return da.zeros([len(axes[name]) for name in names], dtype=dtype, chunks=tuple(chunks[name] for name in names))

    first = compute([axis[:1] for axis in axes.values()])
    coords = {name: (name, axis, _of_all(first[name].attrs)) for name, axis in axes.items()}
    variables = {name: (it.dims, empty(it.dims, it.dtype), _of_all(it.attrs)) for name, it in first.data_vars.items()}
    attrs = {name: value for name, value in first.attrs.items() if name in _OF_ALL}
    cells = xr.Dataset({"cells": (list(axes), empty(list(axes), np.int8))}, coords)

    def block(part: xr.Dataset) -> xr.Dataset:
        return compute([part[name].values.tolist() for name in axes]).assign_coords(part.coords)

    return xr.map_blocks(block, cells, template=xr.Dataset(variables, coords, attrs))


def _of_all(attributes: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in attributes.items() if name not in ("sha256", "flag_counts")}


def run(
    config: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | Sequence[str] = (),
    threads: int | None = None,
    progress: Progress = False,
) -> xr.Dataset:
    """Computes the map of a configuration file, as ``slipmap run`` does, and writes nothing.

    Parameters
    ----------
    config : str or path
        The configuration (TOML).
    set : mapping or sequence of str
        Values that replace those of the file: ``{"grid.V": 2.5}`` or ``["grid.V=2.5"]``.
    threads, progress
        As in :func:`map`.

    Returns
    -------
    xarray.Dataset
        As :func:`map`; stored curves are at ``Dataset.slipmap.curves``.

    Raises
    ------
    ValueError
        With the program's message: file, line, key, value and remedy.
    """
    sets = [f"{key}={_toml(value)}" for key, value in set.items()] if isinstance(set, Mapping) else list(set)
    found = _core.run_config(os.fspath(config), sets, threads, lambda cells: told(progress, cells, "cells"))
    return _dataset(found)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    return repr(value.item() if isinstance(value, np.generic) else value)


def _nodes(name: str, value: Any) -> list[float]:
    try:
        nodes = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise TypeError(f"{name}: numbers are needed, not {value!r:.60}") from None
    if nodes.ndim != 1:
        raise ValueError(f"{name}: the nodes of an axis are one row of numbers, not the shape {nodes.shape}")
    return [float(node) for node in nodes]


def _dataset(found: _core.Map) -> xr.Dataset:
    tile = found.tile_shape
    coords: dict[str, Any] = {}
    for name, attributes, values in found.axes:
        coords[name] = (name, values, _closed(dict(attributes), values, None))
    names = [name for name, *_ in found.axes]
    variables: dict[str, Any] = {}
    for name, attributes, values in found.variables:
        own = dict(attributes)
        # As a reader of the file has it: the coordinates themselves say so.
        own.pop("coordinates", None)
        if "flag_values" in own:
            own["flag_counts"] = np.array([int((values == code).sum()) for code in own["flag_values"]], dtype=np.int64)
        variables[name] = (names[: values.ndim], values, _closed(own, values, tile))
    for name, attributes, values in found.pieces:
        piece = (names[: values.ndim], values, _closed(dict(attributes), np.atleast_1d(values), None))
        # Single numbers are coordinates, by the CF conventions.
        (variables if values.ndim else coords)[name] = piece
    data = xr.Dataset(variables, coords, attrs=dict(found.attributes))
    if found.curves is not None:
        data.encoding["curves"] = _curves(found.curves)
    return data


def _closed(attributes: dict[str, Any], values: np.ndarray, tile: Sequence[int] | None) -> dict[str, Any]:
    """The attributes with the fingerprint that the file has."""
    attributes["sha256"] = _fingerprints.of_values(values, tile)
    return attributes


def _curves(columns: list[tuple[str, str, dict[str, Any], np.ndarray]]) -> xr.Dataset:
    """The curves as the two tables of the file's group: along ``plane`` and along ``point``."""
    data = xr.Dataset({name: (dimension, values, attributes) for dimension, name, attributes, values in columns})
    for dimension in data.sizes:
        numbers = np.arange(1.0, data.sizes[dimension] + 1)
        data = data.assign_coords({dimension: (dimension, numbers, {"long_name": f"number of the {dimension}", "units": "1"})})
    for variable in data.variables.values():
        _closed(variable.attrs, variable.values, None)
    return data
