"""Map files."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
import xarray as xr

from . import _core, _fingerprints

CURVES = "curves"


class MapError(ValueError):
    """A file is no map, or a damaged one; the message says where."""


def open_map(
    path: str | os.PathLike[str], *, verify: bool = True, chunks: Mapping[str, int] | None = None
) -> xr.Dataset:
    """Opens a map that ``slipmap run`` has written, or that ``Dataset.to_netcdf`` has saved.

    Parameters
    ----------
    path : str or path
        The file; ``~`` is the home folder.
    verify : bool
        Whether to recompute the seal of the file and the fingerprint of every variable, and to refuse a map that
        has changed. Reads the whole file once.
    chunks : mapping of str to int, optional
        Opens it as dask arrays, with blocks of these lengths; ``{}`` takes several of the file's tiles together.

    Returns
    -------
    xarray.Dataset
        Variables over the axes epsilon, the law's parameters, V and c, read when they are needed; see the
        accessor ``Dataset.slipmap``. Close it, or use it in a ``with`` block.

    Raises
    ------
    MapError
        If the file is no complete map, or is not as it was written.
    FileNotFoundError
        If there is no such file.

    Examples
    --------
    >>> import pathlib, slipmap, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "notes.txt")
    >>> _ = path.write_text("no map")
    >>> slipmap.open_map(path)
    Traceback (most recent call last):
        ...
    slipmap._files.MapError: ...notes.txt: this is no HDF5 file
    """
    name = os.path.expanduser(os.fspath(path))
    if not os.path.exists(name):
        raise FileNotFoundError(f"{name}: there is no such file")
    if not h5py.is_hdf5(name):
        raise MapError(f"{name}: this is no HDF5 file")
    with h5py.File(name, "r") as file:
        if "law" not in file.attrs or file.attrs.get("complete") != 1:
            raise MapError(f"{name}: this is no complete map of slipmap")
        layout = np.ravel(file.attrs.get("schema", [])).tolist()
        if layout != [_core.SCHEMA]:
            raise MapError(
                f"{name}: its layout has number {layout}, and this version of slipmap reads number {_core.SCHEMA}; use the "
                "version that wrote it"
            )
        if chunks is not None and not chunks:
            chunks = _blocks(file)
    if verify:
        _verify(name)
    return xr.open_dataset(name, engine="h5netcdf", chunks=chunks)


# Cells in a block: many are quicker, and a few variables in flight should fit into any memory.
_CELLS_OF_BLOCK = 4_000_000


def _blocks(file: h5py.File) -> dict[str, int]:
    """Blocks of whole tiles, as many cells as a block may have along the axes that vary fastest."""
    largest = max((item for item in file.values() if isinstance(item, h5py.Dataset)), key=lambda item: item.ndim)
    names = [item[0].name.removeprefix("/") for item in largest.dims]
    lengths = [int(length) for length in np.atleast_1d(file.attrs["tile_shape"])]
    for axis in reversed(range(len(lengths))):
        more = _CELLS_OF_BLOCK // math.prod(lengths)
        lengths[axis] = min(largest.shape[axis], lengths[axis] * max(1, more))
    return dict(zip(names, lengths, strict=True))


def curves_of(path: str) -> xr.Dataset | None:
    """The curves of codimension one that a map stores."""
    with h5py.File(path, "r") as file:
        if CURVES not in file:
            return None
    with xr.open_dataset(path, engine="h5netcdf", group=CURVES) as data:
        return data.load()


def _verify(path: str) -> None:
    problem = _fingerprints.check_seal(path)
    if problem is not None:
        raise MapError(f"{path}: {problem}")
    with h5py.File(path, "r") as file:
        tile = tuple(int(length) for length in np.atleast_1d(file.attrs["tile_shape"]))
        for name, item in file.items():
            if isinstance(item, h5py.Group):
                for column in item.values():
                    _verify_dataset(path, f"{name}/{column.name}", column)
            else:
                _verify_dataset(path, name, item, tile)


def _verify_dataset(path: str, name: str, dataset: Any, tile: tuple[int, ...] | None = None) -> None:
    expected = dataset.attrs.get("sha256")
    if expected is None:
        raise MapError(f"{path}: {name} has no fingerprint")
    # Cells are fingerprinted in tiles; axes in one piece.
    if _text(expected) not in (_fingerprints.of_values(dataset, own) for own in (tile, None)):
        raise MapError(f"{path}: the cells of {name} are not those that were written")


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
