"""Fingerprints of maps, as the program computes them: of cells, of the whole file.

That of a variable is the SHA-256 of its tiles' fingerprints, row-major, each the SHA-256 of the tile's cells,
little-endian, with one bit pattern for NaN.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np

SEAL = b"\nslipmap seal, sha256 of every byte before this line: "


def of_values(values: Any, tile: Iterable[int] | None = None) -> str:
    """Fingerprint of the cells of an array (or a dataset of h5py) in tiles of the given shape."""
    whole = hashlib.sha256()
    lengths = values.shape if tile is None else tuple(tile)[: values.ndim]
    starts = [range(0, size, length) for size, length in zip(values.shape, lengths, strict=True)]
    for corner in itertools.product(*starts):
        box = tuple(slice(start, start + length) for start, length in zip(corner, lengths, strict=True))
        whole.update(hashlib.sha256(_bytes(np.asarray(values[box]))).digest())
    return whole.hexdigest()


def _bytes(cells: np.ndarray) -> bytes:
    if cells.dtype.kind == "f":
        cells = np.where(np.isnan(cells), np.nan, cells).astype("<f8")
    else:
        cells = cells.astype(cells.dtype.newbyteorder("<"))
    return np.ascontiguousarray(cells).tobytes()


def check_seal(path: str) -> str | None:
    """What is wrong with the seal of a file, the line after its last byte; None if it holds or is missing."""
    with open(path, "rb") as file:
        size = file.seek(0, 2)
        length = len(SEAL) + 65
        if size < length:
            return None
        file.seek(size - length)
        line = file.read()
        if not line.startswith(SEAL):
            return None
        file.seek(0)
        digest, left = hashlib.sha256(), size - length
        while left > 0:
            part = file.read(min(left, 1 << 20))
            digest.update(part)
            left -= len(part)
    expected = line[len(SEAL) :].strip().decode(errors="replace")
    return None if digest.hexdigest() == expected else "its bytes are not those that were sealed at the end of the run"
