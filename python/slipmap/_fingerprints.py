"""Fingerprints of maps, as the program computes them: of cells, of attributes, of the whole file.

That of a variable is the SHA-256 of its tiles' fingerprints, row-major, each the SHA-256 of the tile's cells,
little-endian, with one bit pattern for NaN.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

SEAL = b"\nslipmap seal, sha256 of every byte before this line: "
ATTRIBUTES = "sha256_attributes"
# These tie variables to their dimensions; they hold references, not values.
STRUCTURAL = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST")


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


def of_attributes(attributes: Mapping[str, Any]) -> str:
    """Fingerprint of an object's attributes, its own fingerprint left out."""
    digest = hashlib.sha256()

    def piece(content: bytes) -> None:
        digest.update(len(content).to_bytes(8, "little"))
        digest.update(content)

    for name in sorted(attributes, key=lambda name: name.encode()):
        if name == ATTRIBUTES or name in STRUCTURAL:
            continue
        value = attributes[name]
        if isinstance(value, bytes):
            value = value.decode()
        if isinstance(value, str):
            kind, content = b"t", value.encode()
        else:
            numbers = np.asarray(value)
            if numbers.dtype == np.int8:
                kind, content = b"c", numbers.tobytes()
            elif numbers.dtype.kind in "iu":
                kind, content = b"i", numbers.astype("<i8").tobytes()
            else:
                kind, content = b"r", numbers.astype("<f8").tobytes()
        piece(name.encode())
        digest.update(kind)
        piece(content)
    return digest.hexdigest()


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
