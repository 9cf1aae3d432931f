"""The words behind codes in maps, and the methods."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from . import _core

Verdict = IntEnum("Verdict", {name.upper(): code for name, code in _core.VERDICTS}, module=__name__)  # type: ignore[misc]
Verdict.__doc__ = "Codes of verdicts: does a stick-slip limit cycle exist?"
Regime = IntEnum("Regime", {name.upper(): code for name, code, _ in _core.REGIMES}, module=__name__)  # type: ignore[misc]
Regime.__doc__ = "Codes of the long-run behaviour."


class Method(NamedTuple):
    """A method that answers whether a stick-slip limit cycle exists."""

    name: str
    long_name: str
    guarantee: str
    equation: str


METHODS: dict[str, Method] = {name: Method(name, *rest) for name, *rest in _core.METHODS}


def flags(pairs: list[tuple[str, int]]) -> dict[str, Any]:
    """CF attributes of codes with meanings."""
    ordered = sorted(pairs, key=lambda pair: pair[1])
    return {
        "flag_values": np.array([code for _, code in ordered], dtype=np.int8),
        "flag_meanings": " ".join(name for name, _ in ordered),
    }


VERDICT_FLAGS = flags(list(_core.VERDICTS))
REGIME_FLAGS = flags([(name, code) for name, code, _ in _core.REGIMES])
