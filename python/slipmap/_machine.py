"""Machines in SI units."""

from __future__ import annotations

import functools
import html
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from . import _core
from ._broadcast import Numbers, Output, elementwise
from ._codes import REGIME_FLAGS
from ._decode import decode
from ._law import BUILT_IN, Law, _scalar
from ._point import Point
from ._probe import Probe
from ._progress import Progress, told
from ._results import Risk


@runtime_checkable
class Quantity(Protocol):
    """A number with a unit, such as one of pint."""

    @property
    def magnitude(self) -> Any: ...
    def to(self, unit: str) -> Any: ...


# A number in SI units or with its own, as text or of pint, or one of the configuration's tables for what is uncertain.
Given: TypeAlias = float | str | Quantity | Mapping[str, float | str | Quantity]


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


@dataclass(frozen=True)
class Page:
    """The page of a machine; see :meth:`Machine.page`."""

    html: str = field(repr=False)
    """A document that needs no other file."""
    answers: dict[str, Any] = field(repr=False)
    """What ``slipmap machine --json`` prints."""

    def _repr_html_(self) -> str:
        # In a frame, so that its style is its own.
        return f'<iframe srcdoc="{html.escape(self.html)}" style="width: 100%; height: 60em; border: 0"></iframe>'


# Numbers in a row of correlated errors.
_MOST_JOINT = 6


class Machine:
    """A mass on a spring, pressed onto a moving belt, in SI units.

    ``m x'' + d x' + k x = -sign(x' - v) N mu(|x' - v|)``

    Parameters
    ----------
    belt_speed : float or quantity
        v in m/s, greater than 0; rad/s.
    mass : float or quantity
        m in kg; of a rotation the moment of inertia, kg m^2. In place of it or of the stiffness ``frequency``, Hz.
    stiffness : float or quantity
        k in N/m; N m/rad.
    damping : float or quantity
        d in N s/m, at least 0; N m s/rad. In place of it ``damping_ratio``, d/(2 sqrt(k m)).
    normal_force : float or quantity, optional
        N in newton; times its lever arm, N m, of a rotation, but N with a ``radius``, m, at which it presses. In place of it
        ``pressure``, Pa, and ``area``, m^2. Left out where `friction` is the force itself.
    friction : Law or str, optional
        mu as a function of the slip speed in m/s (rad/s): one of the laws ``Law.stribeck()`` (the default),
        ``Law.exponential()``, ``Law.lorentzian()`` and ``Law.coulomb()``, also by their names, ``"coulomb"``, whose coefficients
        are then among the quantities;
        a formula, ``Law.expression("0.3 + 0.1*exp(-u/0.05)")``; measurements, ``Law.table(u, mu)`` or ``Law.from_csv(..)``;
        or the law of a fit, ``Law.fit(..).law``, whose values are quantities with correlated errors.
    motion : {"translation", "rotation"}
        How it moves, which names its units.
    **quantities : float or quantity
        Those named above that stand in place of others. Of a built-in law ``static_friction``, ``kinetic_friction``,
        ``stribeck_velocity`` (m/s; rad/s) and, if it is not 0, ``strengthening``: the rise of the coefficient at high speed, per
        (m/s)^2 in the law `stribeck`, per m/s in others; of the exponential law, if it is not 1, ``exponent``. Of a formula
        the names in it that it does not hold.

    Raises
    ------
    ValueError
        If a quantity is outside its domain; the message names it.
    TypeError
        If one is missing or unknown.

    Notes
    -----
    Quantities of pint are converted, and so is text with a unit, ``"10 mm/s"``. What is uncertain is written as in a
    configuration, ``{"value": 2.0, "sd": 0.1}`` or ``{"min": 1.8, "max": 2.2}``, also with units; see :meth:`risk`.

    Examples
    --------
    >>> import slipmap
    >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
    ...                       kinetic_friction=0.3, stribeck_velocity=0.25, strengthening=0.02, belt_speed=0.1)
    >>> pad.units.velocity
    0.5
    >>> round(pad.probe().machine.critical_belt_speed, 3)
    0.351
    >>> measured = slipmap.Law.table([0.0, 0.1, 0.3, 0.6, 1.0], [0.40, 0.36, 0.33, 0.32, 0.32])
    >>> own = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, belt_speed=0.1, friction=measured)
    >>> own.critical_damping(belt_speed=[0.1, 0.2]).round(1)
    array([14.5,  8.8])
    """

    __slots__ = ("_core", "_friction")

    def __init__(
        self,
        *,
        belt_speed: Given,
        mass: Given | None = None,
        stiffness: Given | None = None,
        damping: Given | None = None,
        normal_force: Given | None = None,
        friction: Law | str | None = None,
        motion: str = "translation",
        **quantities: Given,
    ):
        given = {
            "mass": mass,
            "stiffness": stiffness,
            "damping": damping,
            "normal_force": normal_force,
            "belt_speed": belt_speed,
            **quantities,
        }
        self._set(Law.stribeck() if friction is None else friction, motion, given, {}, {}, {})

    def _set(
        self,
        law: Law | str,
        motion: str,
        given: Mapping[str, Any],
        values: dict[str, float],
        spreads: dict[str, list[float]],
        written: dict[str, tuple[str, float]],
    ) -> None:
        """Makes the machine of these numbers, spreads and units, with what is given in their place."""
        if isinstance(law, str) and law in BUILT_IN:
            law = BUILT_IN[law]()
        if not isinstance(law, Law):
            named = ", ".join(f"slipmap.Law.{name}()" for name in BUILT_IN)
            raise TypeError(f"friction: a Law is needed, not {law!r:.60}: {named}, slipmap.Law.expression(..), ..")
        held = {name: value for name, value in law.parameters.items() if value is not None}
        if law._quantity == "force" and any(name in values or given.get(name) is not None for name in ("normal_force", "pressure")):
            raise ValueError(
                "the measured friction is a force already: leave the normal force out\n  help: friction divided by the normal "
                "force at which it was measured is a coefficient, which has any normal force"
            )
        if law.name in ("expression", "table"):
            own = {name: value for name, value in held.items() if name not in values and name not in given}
            given = {**own, **given}
            joint = {name: row for name, row in law._joint.items() if name in own}
            spreads.update({name: [*row, *[0.0] * (_MOST_JOINT - len(row))] for name, row in joint.items()})
        else:
            # The parameters of a built-in law follow from the coefficients.
            if any(item != ("eta", 0.0) for item in held.items()):
                raise TypeError(f"friction: leave out {next(iter(held))}; the parameters of this law follow from the coefficients")
            law = Law(law._law, {})
            values.setdefault("strengthening", 0.0)
        units = _Units.of_machine(law._law, motion, {**values, **given})
        for name, value in given.items():
            if value is None:
                values.pop(name, None)
                continue
            values[name], spread = units.read(name, value)
            written.pop(name, None)
            written.update(units.written_of(name, value))
            if spread is not None:
                spreads[name] = spread
            elif len(spreads.get(name, ())) == 2:
                # A number in place of a range.
                del spreads[name]
        self._friction, self._core = law, _core.Machine(law._law, motion, values, list(spreads.items()), written)

    @classmethod
    def from_toml(cls, config: str | os.PathLike[str], **changes: float | str) -> Machine:
        """The machine of a configuration file, with other values of some quantities.

        Parameters
        ----------
        config : str or path
            The file (TOML), with a table ``[machine]``.
        **changes : float or str
            Quantities in SI units, or text with a unit, in place of those of the file.

        Raises
        ------
        ValueError
            With the program's message: file, line, key, value and remedy.
        """
        core = _core.Machine.from_toml(os.path.expanduser(config), list(changes.items()))
        friction = Law(core.friction, {}, quantity="force" if core.holds_forces else None)
        return cls._again(friction, core.motion, dict(core.quantities), dict(core.uncertain), core.written)

    @classmethod
    def _again(
        cls,
        law: Law,
        motion: str,
        values: dict[str, float],
        spreads: dict[str, list[float]],
        written: dict[str, tuple[str, float]],
    ) -> Machine:
        machine = cls.__new__(cls)
        machine._set(law, motion, {}, values, spreads, written)
        return machine

    @property
    def quantities(self) -> dict[str, float]:
        """All its numbers, in SI units; of an uncertain quantity that in the middle."""
        return dict(self._core.quantities)

    @property
    def uncertain(self) -> dict[str, dict[str, float]]:
        """The uncertain quantities, each with ``sd``, or ``min`` and ``max``."""
        return {name: _told(spread) for name, spread in self._core.uncertain}

    @property
    def friction(self) -> Law:
        """The coefficient of friction, of the slip speed in SI units."""
        return self._friction

    @property
    def motion(self) -> str:
        """"translation" or "rotation"."""
        return self._core.motion

    @property
    def notes(self) -> list[str]:
        """What was read, in words: units that are not those of SI, and how measured friction was understood."""
        return self._core.notes

    @property
    def doubts(self) -> list[str]:
        """Numbers that suggest other units, in words."""
        return self._core.doubts

    def __getitem__(self, quantity: str) -> float:
        return self.quantities[quantity]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.quantities)

    @property
    def _units(self) -> _Units:
        return _Units.of_machine(self._core.friction, self.motion, self.quantities)

    @property
    def units(self) -> Units:
        """The units of the dimensionless oscillator."""
        return Units(*self._core.point()[2])

    def point(self) -> Point:
        """The dimensionless point of the machine, at epsilon = 1."""
        core, values, _ = self._core.point()
        law = Law(core, {})
        return Point(law, **dict(zip(law.axes, values, strict=True)))

    def probe(self, *, tolerance: float = 1e-9) -> Probe:
        """Every answer about the machine, with those in SI units in its field ``machine``."""
        return Probe.from_json(self._core.probe(tolerance))

    def critical_damping(
        self,
        *,
        return_error: bool = False,
        tolerance: float = 1e-9,
        threads: int | None = None,
        progress: Progress = False,
        **quantities: Numbers | Quantity,
    ) -> Any:
        """The critical damping coefficient, N s/m, where some quantities have other values.

        Parameters
        ----------
        return_error, tolerance, threads, progress
            As in :func:`critical_c`.
        **quantities : array_like
            Quantities of the machine, in SI units or with those of text or of pint, which broadcast as in :func:`critical_c`.

        Returns
        -------
        damping : ndarray, scalar, DataArray, Series or dask array
            Below it the mass comes back to the belt. Negative and NaN as in :func:`critical_c`; of the first NaN a warning
            tells the reason.
        error : like `damping`
            Only if `return_error`: its standard error by measured or fitted friction, without that of what is given here; of
            other friction, and where it is larger, the estimate of the absolute error of the computation.
        """
        names = list(quantities) or ["belt_speed"]

        def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
            bar = told(progress, max(array.size for array in arrays), "values")
            values, errors, unknown = self._core.critical_damping(names, arrays, tolerance, return_error, threads, bar)
            if unknown is not None:
                element, reason = unknown
                place = f" of element {element}" if values.size > 1 else ""
                warnings.warn(f"the critical damping{place} is not known: {reason}", RuntimeWarning, stacklevel=5)
            return (values, errors) if return_error else (values,)

        units = {"units": "N s/m" if self.motion == "translation" else "N m s/rad"}
        outputs = [
            Output("critical_damping", np.float64, "critical damping", units),
            Output("critical_damping_error", np.float64, "error estimate of the critical damping", units),
        ]
        values = {name: self._units.magnitude(name, value) for name, value in quantities.items()}
        results = elementwise(kernel, values or {"belt_speed": self["belt_speed"]}, outputs[: 1 + return_error])
        return results if return_error else results[0]

    def _over(
        self, outputs: list[Output], pick: Any, tolerance: float, threads: int | None, progress: Progress, quantities: Any
    ) -> tuple[Any, ...]:
        """What the core's `behaviour` says where quantities have other values; `pick` takes it from the codes and numbers."""
        names = list(quantities) or ["belt_speed"]

        def kernel(arrays: list[np.ndarray]) -> tuple[np.ndarray, ...]:
            bar = told(progress, max(array.size for array in arrays), "values")
            every = outputs[0].name != "by_itself_below"
            picked: tuple[np.ndarray, ...] = pick(*self._core.behaviour(names, arrays, every, tolerance, threads, bar))
            return picked

        values = {name: self._units.magnitude(name, value) for name, value in quantities.items()}
        return elementwise(kernel, values or {"belt_speed": self["belt_speed"]}, outputs)

    def regime(
        self,
        *,
        tolerance: float = 1e-9,
        threads: int | None = None,
        progress: Progress = False,
        **quantities: Numbers | Quantity,
    ) -> Any:
        """What it does in the long run where some quantities have other values: codes of :class:`Regime`.

        Parameters and results are as in :meth:`critical_damping`; ``FAILED`` where it is not determined.

        Examples
        --------
        >>> import slipmap
        >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
        ...                       kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
        >>> [slipmap.Regime(code).name for code in pad.regime(belt_speed=[0.1, 0.6])]
        ['STICK_SLIP', 'EQUILIBRIUM']
        """
        output = Output("regime", np.int8, "long-run behaviour according to the simulated flow", REGIME_FLAGS)
        return self._over([output], lambda codes, _: (codes,), tolerance, threads, progress, quantities)[0]

    def kick(
        self,
        *,
        tolerance: float = 1e-9,
        threads: int | None = None,
        progress: Progress = False,
        **quantities: Numbers | Quantity,
    ) -> tuple[Any, Any]:
        """The kicks of steady slip, with the belt and against it, beyond which it vibrates: changes of velocity in SI units.

        0 where it vibrates without a kick, infinite where none starts it, NaN where it is not known. Parameters are as in
        :meth:`critical_damping`.

        Examples
        --------
        >>> import slipmap
        >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
        ...                       kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
        >>> [float(kick) for kick in pad.kick(belt_speed=[0.1, 0.6])[0]]
        [0.0, inf]
        """
        units = {"units": "m/s" if self.motion == "translation" else "rad/s"}
        outputs = [
            Output("kick_forward", np.float64, "kick with the belt", units),
            Output("kick_backward", np.float64, "kick against the belt", units),
        ]
        return self._over(outputs, lambda _, numbers: tuple(numbers[:2]), tolerance, threads, progress, quantities)

    def limits(
        self,
        *,
        tolerance: float = 1e-9,
        threads: int | None = None,
        progress: Progress = False,
        **quantities: Numbers | Quantity,
    ) -> tuple[Any, Any]:
        """The dampings below which it vibrates by itself, since steady slip is unstable, and below which it may stick-slip.

        Parameters are as in :meth:`critical_damping`, which is the second; negative where no damping is small enough.

        Examples
        --------
        >>> import slipmap
        >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
        ...                       kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
        >>> by_itself, may = pad.limits(belt_speed=[0.1, 0.3])
        >>> bool((by_itself < may).all())
        True
        """
        units = {"units": "N s/m" if self.motion == "translation" else "N m s/rad"}
        output = Output("by_itself_below", np.float64, "damping below which steady slip is unstable", units)
        by_itself = self._over([output], lambda _, numbers: (numbers[2],), tolerance, threads, False, quantities)[0]
        given: Any = quantities
        may = self.critical_damping(tolerance=tolerance, threads=threads, progress=progress, **given)
        return by_itself, may

    def risk(
        self, *, draws: int | None = None, rare: Sequence[float] = (0.1, 0.01, 0.001), seconds: float | None = None
    ) -> Risk:
        """The probability that the machine may stick-slip, given what is uncertain, and the dampings that make it rare.

        Parameters
        ----------
        draws : int, optional
            Draws of the uncertain quantities; by default 100000, or as many as take some seconds.
        rare : sequence of float
            Probabilities for which the damping is sought.
        seconds : float, optional
            Time after which no more is drawn; how many draws there are depends on it then.

        Returns
        -------
        Risk
            ``probability`` (its ``value`` and 95 % ``limits_95``), ``by_itself`` (likewise: that steady slip is
            unstable, so that it needs no knock), ``rare_by`` (for each probability the ``damping``), the
            ``critical_damping_standard_error`` that measured friction makes, and how many ``draws`` there were.

        Examples
        --------
        >>> import slipmap
        >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping={"value": 10.0, "sd": 1.0}, normal_force=50.0,
        ...                       static_friction=0.4, kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
        >>> 0.0 < pad.risk(draws=1000).probability.value < 1.0
        True
        """
        return decode(Risk, json.loads(self._core.risk(_draws(draws), list(rare), seconds)))

    def page(
        self, *, title: str = "Machine", draws: int | None = None, rare: Sequence[float] = (0.1, 0.01, 0.001)
    ) -> Page:
        """The engineer's page of the machine: limits of speed and damping, motion, kick, sensitivities, proofs and risk.

        Quantities that were given with units are told in these.

        Parameters
        ----------
        title : str
            Its title.
        draws, rare
            As in :meth:`risk`.

        Returns
        -------
        Page
            Shown as HTML in a notebook; ``answers`` has its numbers.

        Examples
        --------
        >>> import slipmap
        >>> pad = slipmap.Machine(mass=2.0, stiffness=800.0, damping=4.0, normal_force=50.0, static_friction=0.4,
        ...                       kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
        >>> page = pad.page(title="A pad")
        >>> round(page.answers["may_stick_slip_below_belt_speed"], 3), page.answers["kick_status"]
        (0.422, 'not_needed')
        """
        document, answers = self._core.page(title, _draws(draws), list(rare))
        return Page(document, json.loads(answers))

    def explorer(self, *, title: str = "Machine") -> str:
        """The explorer that begins with the machine, as an HTML document that computes in the browser and needs no other file.

        Parameters
        ----------
        title : str
            Of what is exported from it.

        Returns
        -------
        str
            What ``slipmap explore machine.toml --out pad.html`` writes.

        Raises
        ------
        NotImplementedError
            Where the package was built without its part for browsers.
        """
        return self._core.explorer(title)

    def replace(self, **changes: Any) -> Machine:
        """The machine with other quantities, friction or motion; an uncertain one keeps its ``sd`` around its new value."""
        values, spreads = self.quantities, dict(self._core.uncertain)
        law, motion = changes.pop("friction", self.friction), changes.pop("motion", self.motion)
        if law != self.friction:
            # Numbers of the old law are none of the new one.
            values = {name: value for name, value in values.items() if name in _core.OWN_QUANTITIES}
            spreads = {name: spread for name, spread in spreads.items() if name in _core.OWN_QUANTITIES}
        machine = Machine.__new__(Machine)
        machine._set(law, motion, changes, values, spreads, self._core.written)
        return machine

    def _key(self) -> tuple[Any, ...]:
        core = self._core
        spreads = tuple((name, tuple(spread)) for name, spread in core.uncertain)
        return (self._friction, core.motion, tuple(core.quantities), spreads)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Machine) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        core = self._core
        numbers = dict(core.quantities), dict(core.uncertain), core.written
        return (functools.partial(Machine._again, self._friction, core.motion, *numbers), ())

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value!r}" for name, value in self.quantities.items())
        return f"Machine({values}, friction={self.friction!r}, motion={self.motion!r})"

    def _repr_html_(self) -> str:
        units, uncertain = self._units, self.uncertain
        spreads = {name: " to ".join(f"{value:g}" for value in spread.values()) for name, spread in uncertain.items()}
        rows = "".join(
            f"<tr><td>{html.escape(name.replace('_', ' '))}</td><td>{value:g}</td>"
            f"<td>{html.escape(units.of(name) or '')}</td>"
            f"<td>{'&plusmn; ' if 'sd' in uncertain.get(name, {}) else ''}{html.escape(spreads.get(name, ''))}</td></tr>"
            for name, value in self.quantities.items()
        )
        doubts = "".join(f"<p>{html.escape(doubt)}</p>" for doubt in self.doubts)
        si = self.units
        curve = self.point().law._curve(si.velocity, si.force / self.quantities.get("normal_force", 1.0))
        return f"<p>Machine, {self.motion}; friction: {html.escape(repr(self.friction))}</p><table>{rows}</table>{curve}{doubts}"


def _draws(draws: int | None) -> int | None:
    if draws is not None and not draws >= 1:
        raise ValueError(f"draws = {draws}: must be at least 1")
    return draws


def _told(spread: list[float]) -> dict[str, float]:
    """A spread in words; what is correlated with others is a row of numbers."""
    return {"min": spread[0], "max": spread[1]} if len(spread) == 2 else {"sd": float(np.hypot.reduce(spread))}


class _Units:
    """The units of a machine's quantities, in which numbers with units of their own are read."""

    def __init__(self, law: _core.Law, motion: str, normal: str, radius: float | None):
        self._law, self._motion, self._normal, self._radius = law, motion, normal, radius

    @classmethod
    def of_machine(cls, law: _core.Law, motion: str, given: Mapping[str, Any]) -> _Units:
        """Those of a machine of these quantities."""
        radius = given.get("radius")
        if all(given.get(name) is None for name in ("normal_force", "pressure")):
            normal = "in_friction"
        else:
            normal = "alone" if radius is None else "at_radius"
        number = None if radius is None else cls(law, motion, normal, None).read("radius", radius)[0]
        return cls(law, motion, normal, number)

    def of(self, name: str) -> str | None:
        """The SI unit of a quantity: "" of a pure number, None of a name in a formula."""
        return self._law.unit_of(name, self._motion, self._normal)

    def number(self, name: str, value: Any) -> float:
        """A number in SI units."""
        return _scalar(name, self.magnitude(name, value))

    def magnitude(self, name: str, value: Any) -> Any:
        """Numbers in SI units; text with a unit is read, and quantities of pint are converted."""
        if isinstance(value, str):
            return self._number(name, value)[0]
        unit = self.of(name)
        if unit is None or not isinstance(value, Quantity):
            return value
        try:
            return value.to(unit or "dimensionless").magnitude
        except Exception as error:
            raise ValueError(f"{name}: {error}") from None

    def _number(self, name: str, text: str) -> tuple[float, str]:
        return self._law.number_of(text, name, self._motion, self._normal, self._radius)

    def written_of(self, name: str, given: Any) -> dict[str, tuple[str, float]]:
        """The unit of what is given as text, and its size in SI."""
        value = next(iter(given.values()), None) if isinstance(given, Mapping) else given
        if not isinstance(value, str):
            return {}
        value = (_core.with_deviation(value) or (value,))[0]
        unit = self._number(name, value)[1]
        return {name: (unit, self._number(name, f"1 {unit}")[0])}

    def read(self, name: str, given: Any) -> tuple[float, list[float] | None]:
        """The number of a quantity in SI units, and its spread: a standard deviation, or both ends of a range."""
        if isinstance(given, str) and (both := _core.with_deviation(given)) is not None:
            given = dict(zip(("value", "sd"), both, strict=True))
        if not isinstance(given, Mapping):
            return self.number(name, given), None
        value = self.number(name, given["value"]) if "value" in given else None

        def part(key: str, text: Any) -> float:
            share = _core.share(text) if isinstance(text, str) else None
            if share is None or value is None:
                return self.number(name, text)
            if key == "sd":
                return abs(value) * share
            return value * (share + (text.strip()[0] in "+-"))

        parts = {key: part(key, text) for key, text in given.items() if key != "value"}
        if value is not None and set(parts) == {"sd"} and parts["sd"] >= 0.0:
            return value, [parts["sd"]]
        if set(parts) == {"min", "max"}:
            middle = 0.5 * (parts["min"] + parts["max"]) if value is None else value
            if parts["min"] <= middle <= parts["max"]:
                return middle, [parts["min"], parts["max"]]
        raise ValueError(f'{name} = {dict(given)}: write "2 kg +- 5 %", {{"value": 2.0, "sd": 0.1}} or {{"min": 1.8, "max": 2.2}}')
