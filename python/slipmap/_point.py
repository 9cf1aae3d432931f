"""One parameter point."""

from __future__ import annotations

import functools
from typing import Any

from . import _core
from ._law import Law, _scalar, arguments_of, no_machine
from ._probe import Probe


class Point:
    """One point of parameter space: a friction law with all parameters fixed, belt speed and damping.

    Parameters
    ----------
    law : Law
        The friction law.
    V : float
        Belt speed, greater than 0.
    c : float
        Viscous damping, at least 0.
    epsilon : float, optional
        Size of the small terms, greater than 0; by default 1 for a law that does not contain it.
    **parameters : float
        The law's own parameters that it does not hold itself.

    Examples
    --------
    >>> import slipmap
    >>> point = slipmap.Point(slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0), V=1.0, c=0.6, epsilon=0.1)
    >>> point["gamma"]
    2.0
    >>> point.replace(c=0.3)
    Point(stribeck, epsilon=0.1, alpha=0.4, beta=0.2, gamma=2.0, V=1.0, c=0.3)
    """

    __slots__ = ("_values", "law")

    def __init__(self, law: Law, *, V: float, c: float, epsilon: float | None = None, **parameters: float):
        values = arguments_of(law, parameters, epsilon=epsilon, V=V, c=c)
        self._values = {name: _scalar(name, value) for name, value in values.items()}
        self.law = law.replace(**{name: self._values[name] for name in law.parameters})

    @property
    def values(self) -> dict[str, float]:
        """Value of every axis, in the order of a map's dimensions."""
        return dict(self._values)

    def replace(self, **changes: float) -> Point:
        """The point with other values of some axes."""
        return Point(self.law, **{**self._values, **changes})

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._values)

    def __getitem__(self, axis: str) -> float:
        return self._values[axis]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Point) and (self.law, self._values) == (other.law, other._values)

    def __hash__(self) -> int:
        return hash((self.law, *self._values.values()))

    def __reduce__(self) -> tuple[Any, ...]:
        return (functools.partial(Point, self.law, **self._values), ())

    def __repr__(self) -> str:
        return f"Point({self.law.name}, {', '.join(f'{name}={value!r}' for name, value in self._values.items())})"


def probe(
    at: Point | Law,
    *,
    V: float | None = None,
    c: float | None = None,
    epsilon: float | None = None,
    tolerance: float = 1e-9,
    **parameters: float,
) -> Probe:
    """Every answer about one point: what ``slipmap probe`` says.

    Parameters
    ----------
    at : Point or Law
        The point, or a law with the point's parameters in the other arguments.
    V, c, epsilon, **parameters : float
        The point, if `at` is a law; as in :class:`Point`.
    tolerance : float
        Bound on the error of the scaled grazing margin m / V that the simulation aims at.

    Returns
    -------
    Probe
        Typed; shown as tables in a notebook.

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    >>> answer = slipmap.probe(law, V=1.0, c=0.6, epsilon=0.1)
    >>> answer.regime, answer.methods["symmetric"].verdict
    ('equilibrium', 'absent')
    """
    if isinstance(at, Law):
        missing = [name for name, value in (("V", V), ("c", c)) if value is None]
        if missing:
            raise TypeError(f"a point also needs {', '.join(missing)}")
        at = Point(at, V=V, c=c, epsilon=epsilon, **parameters)  # type: ignore[arg-type]
    elif not isinstance(at, Point):
        raise TypeError(f"at: {no_machine(at, 'Point or Law')}")
    elif V is not None or c is not None or epsilon is not None or parameters:
        at = at.replace(
            **{k: v for k, v in {"V": V, "c": c, "epsilon": epsilon, **parameters}.items() if v is not None}
        )
    return Probe.from_json(_core.probe(at.law._law, list(at.values.values()), tolerance))
