"""Measured friction as it is given: files, data frames, columns of numbers."""

from __future__ import annotations

import os
import re
import warnings
from typing import Any

import pandas as pd

from . import _core


def header(name: str, quantity: str, column: Any) -> str:
    """The name of a column with its unit, which a Series may have in its name."""
    found = re.search(r"[\[({]([^\[({]+)[\])}]\s*$", str(column.name)) if isinstance(column, pd.Series) else None
    if found is None:
        return name
    for motion in ("translation", "rotation"):
        try:
            size = _core.Law.built_in("stribeck").number_of(f"1 {found[1]}", quantity, motion, "alone", None)[0]
        except ValueError:
            continue
        if size != 1.0:
            # A Series keeps its name when it is divided by 1000.
            warnings.warn(
                f"the name of the Series, {column.name!r}, has a unit that is not of SI; its numbers are taken in SI units, "
                "as any numbers are. Units of a DataFrame of both columns are read",
                stacklevel=4,
            )
            return name
        return f"{name} [{found[1]}]"
    return name


def file(path: Any) -> tuple[str, bytes]:
    """Name and bytes of a file."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError("a file, a DataFrame, or slip speeds and friction are needed")
    name = os.path.expanduser(os.fspath(path))
    with open(name, "rb") as opened:
        return name, opened.read()


def columns(data: pd.DataFrame) -> tuple[str, bytes]:
    """The file that a DataFrame would be."""
    if not isinstance(data, pd.DataFrame):
        raise TypeError(f"a DataFrame is needed, not a {type(data).__name__}; of arrays `fit` and `table` make laws")
    # An index with a name is a column.
    return "the data", data.to_csv(index=data.index.names != [None]).encode()
