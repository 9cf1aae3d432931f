"""One parameter point, and machines in SI units."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any

from . import _core
from ._law import Law, _scalar
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
    epsilon : float
        Size of the small terms, greater than 0.
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

    def __init__(self, law: Law, *, V: float, c: float, epsilon: float, **parameters: float):
        values = law._arguments(parameters, epsilon=epsilon, V=V, c=c)
        self._values = {name: _scalar(name, value) for name, value in values.items()}
        self.law = law.replace(**{name: self._values[name] for name in law.parameters})

    @property
    def values(self) -> dict[str, float]:
        """Value of every axis, in the order of a map's dimensions."""
        return dict(self._values)

    def replace(self, **changes: float) -> Point:
        """The point with other values of some axes."""
        return Point(self.law, **{**self._values, **changes})

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


@dataclass(frozen=True)
class Units:
    """The units of the dimensionless oscillator, in SI (of a rotation: rad for m, N m for N)."""

    time: float
    """s"""
    length: float
    """m"""
    velocity: float
    """m/s"""
    force: float
    """N"""
    damping: float
    """N s/m, of c = 1 at epsilon = 1"""


# Names and units of quantities: of a translation, of a rotation. Their order is that of the compiled part.
_QUANTITIES = {
    "mass": ("kg", "kg*m**2"),
    "stiffness": ("N/m", "N*m/rad"),
    "damping": ("N*s/m", "N*m*s/rad"),
    "normal_force": ("N", "N*m"),
    "static_friction": ("dimensionless", "dimensionless"),
    "kinetic_friction": ("dimensionless", "dimensionless"),
    "stribeck_velocity": ("m/s", "rad/s"),
    "strengthening": (None, None),
    "belt_speed": ("m/s", "rad/s"),
}
_MAY_BE_ZERO = ("damping", "kinetic_friction", "strengthening")


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A mass on a spring, pressed onto a moving belt, in SI units.

    ``m x'' + d x' + k x = -sign(x' - v) N mu(|x' - v|)``

    Quantities of pint are converted; the attributes are numbers. The laws `stribeck`, `exponential`, `lorentzian` and `coulomb`
    describe its friction. Measured friction or a formula belongs into a configuration, which ``slipmap.run`` and
    ``slipmap probe --machine`` read.

    Parameters
    ----------
    mass : float or pint.Quantity
        m in kg; of a rotation the moment of inertia, kg m^2.
    stiffness : float or pint.Quantity
        k in N/m; N m/rad.
    damping : float or pint.Quantity
        d in N s/m, at least 0; N m s/rad.
    normal_force : float or pint.Quantity
        N in newton; times its lever arm, N m, of a rotation.
    static_friction, kinetic_friction : float
        Coefficients of friction at rest and at high slip speed.
    stribeck_velocity : float or pint.Quantity
        Slip speed over which friction falls, m/s; rad/s.
    belt_speed : float or pint.Quantity
        v in m/s, greater than 0; rad/s.
    strengthening : float
        Rise of the coefficient of friction at high speed: per (m/s)^2 in the law `stribeck`, per m/s in
        others.
    motion : {"translation", "rotation"}
        How it moves, which names its units.

    Raises
    ------
    ValueError
        If a quantity is outside its domain; the message names it.

    Examples
    --------
    >>> import slipmap
    >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
    ...                       kinetic_friction=0.3, stribeck_velocity=0.25, strengthening=0.02, belt_speed=0.1)
    >>> pad.units.velocity
    0.5
    >>> round(pad.probe().machine.critical_belt_speed, 3)
    0.351
    """

    mass: Any
    stiffness: Any
    damping: Any
    normal_force: Any
    static_friction: Any
    kinetic_friction: Any
    stribeck_velocity: Any
    belt_speed: Any
    strengthening: Any = 0.0
    motion: str = "translation"

    def __post_init__(self) -> None:
        if self.motion not in ("translation", "rotation"):
            raise ValueError(f"motion: there is no motion `{self.motion}`; choose from: translation, rotation")
        for name, units in _QUANTITIES.items():
            value = _si(name, getattr(self, name), units[self.motion == "rotation"])
            legal = value >= 0.0 if name in _MAY_BE_ZERO else value > 0.0
            if not legal or value == float("inf"):
                wanted = "at least 0" if name in _MAY_BE_ZERO else "greater than 0"
                raise ValueError(f"{name} = {value}: must be {wanted}")
            # The one place where the frozen value is set: from a quantity to its number.
            object.__setattr__(self, name, value)
        if self.kinetic_friction > self.static_friction:
            raise ValueError(f"kinetic_friction = {self.kinetic_friction}: must be from 0 to static_friction")

    def _numbers(self) -> list[float]:
        return [getattr(self, name) for name in _QUANTITIES]

    @property
    def units(self) -> Units:
        """The units of the dimensionless oscillator."""
        _, units = _core.machine_point(Law.stribeck()._law, self.motion, self._numbers())
        return Units(*units)

    def point(self, law: Law | None = None) -> Point:
        """The dimensionless point of the machine under `law` (by default the paper's), at epsilon = 1."""
        law = Law.stribeck() if law is None else law
        values, _ = _core.machine_point(law._law, self.motion, self._numbers())
        return Point(law, **dict(zip(law.axes, values, strict=True)))

    def probe(self, law: Law | None = None, *, tolerance: float = 1e-9) -> Probe:
        """Every answer about the machine, with those in SI units in its field ``machine``."""
        law = Law.stribeck() if law is None else law
        return Probe.from_json(_core.machine_probe(law._law, self.motion, self._numbers(), tolerance))

    def replace(self, **changes: Any) -> Machine:
        """The machine with other quantities."""
        return dataclasses.replace(self, **changes)


def _si(name: str, value: Any, unit: str | None) -> float:
    """The number in SI units; pint's quantities are converted."""
    if unit is not None and hasattr(value, "to") and hasattr(value, "magnitude"):
        try:
            value = value.to(unit).magnitude
        except Exception as error:
            raise ValueError(f"{name}: {error}") from None
    return _scalar(name, value)


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
        given = {name: value for name, value in (("V", V), ("c", c), ("epsilon", epsilon)) if value is None}
        if given:
            raise TypeError(f"a point also needs {', '.join(given)}")
        at = Point(at, V=V, c=c, epsilon=epsilon, **parameters)  # type: ignore[arg-type]
    elif V is not None or c is not None or epsilon is not None or parameters:
        at = at.replace(
            **{k: v for k, v in {"V": V, "c": c, "epsilon": epsilon, **parameters}.items() if v is not None}
        )
    return Probe.from_json(_core.probe(at.law._law, list(at.values.values()), tolerance))
