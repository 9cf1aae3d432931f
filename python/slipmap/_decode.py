"""Answers of the compiled part, read into the classes of ``_results``."""

from __future__ import annotations

import types
import typing
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

T = TypeVar("T")


def decode(kind: type[T], data: Any) -> T:
    """The value of type `kind` that the JSON `data` tells."""
    return typing.cast(T, _decode(kind, data))


def _decode(kind: Any, data: Any) -> Any:
    if data is None or kind == dict[str, Any]:
        return data
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return _decode(arguments[0], data)
    if origin is tuple:
        return tuple(_decode(arguments[0], entry) for entry in data)
    if origin is dict:
        return {name: _decode(arguments[1], entry) for name, entry in data.items()}
    if kind is complex:
        return complex(data["re"], data["im"])
    if is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        names = {it.metadata.get("key", it.name): it.name for it in fields(kind)}
        # Strict: what the compiled part tells and a class lacks is an error.
        return kind(**{names[key]: _decode(hints[names[key]], entry) for key, entry in data.items()})  # type: ignore[operator]
    # JSON has no infinity: it is the text "inf" or "-inf".
    return float(data) if kind is float else data
