"""Every answer about one point, typed."""

from __future__ import annotations

import html
import json
import math
import types
import typing
from dataclasses import dataclass, is_dataclass
from typing import Any


@dataclass(frozen=True)
class Range:
    """The range of a coordinate."""

    low: float
    high: float


@dataclass(frozen=True)
class State:
    """A state: position and velocity."""

    x1: float
    x2: float


@dataclass(frozen=True)
class Landing:
    """Where and when an orbit from the exit point sticks."""

    x1: float
    """x1 at which the mass begins to stick."""
    slip_time: float
    stick_time: float
    period: float
    crossings: int | None
    """Crossings of the belt line before the mass sticks; None where it lands within its error of the end of the stick
    segment, after 0 or 1."""


@dataclass(frozen=True)
class MethodAnswer:
    """What one method says of a point."""

    verdict: str
    """"present", "absent", "undecided" or "failed"."""
    margin: float | None
    """Signed distance in c to the edge of presence, or m / V of the simulation; None where it is no finite
    number."""
    critical_c: float | None
    """The edge of presence in c; None where there is none at c >= 0, or none that is known to 1 %."""
    guarantee: str
    equation: str
    reason: str | None
    """Why the verdict is neither presence nor absence."""
    epsilon_limit: float | None
    """Up to which epsilon the verdict equals the simulated one; inf: as far as was looked; None: not
    known."""
    epsilon_limit_reason: str | None = None
    """Why `epsilon_limit` is not known."""
    critical_c_error: float | None = None
    """Estimate of the absolute error of `critical_c`; None for methods whose edge is exact to rounding."""


@dataclass(frozen=True)
class Flow:
    """The orbit from the exit point by one engine."""

    fate: str
    verdict: str
    margin: float | None
    """Scaled grazing margin m / V."""
    margin_error: float | None
    rhs: int
    """Evaluations of the right-hand side."""
    landing: Landing | None
    reason: str | None


@dataclass(frozen=True)
class Flows:
    """The orbit from the exit point by both engines."""

    return_map: Flow
    direct: Flow


@dataclass(frozen=True)
class CriticalDamping:
    """The critical damping of a column."""

    value: float | None
    """c*; negative where no legal damping is small enough for a cycle; None where it is not known to 1 %."""
    error: float | None
    """Estimate of the absolute error, also of a c* that is not known to 1 %."""
    rhs: int | None
    reason: str | None


@dataclass(frozen=True)
class Estimate:
    """A number and an estimate of its absolute error; `value` is None where that is more than 1 % of it."""

    value: float | None
    error: float


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of the critical damping; `reason` says why if there are none."""

    derivatives: dict[str, Estimate]
    """By each parameter but the damping."""
    standard_error: Estimate | None
    """The standard error of the critical damping that the standard errors of a table make."""
    reason: str | None


@dataclass(frozen=True)
class Equilibrium:
    """The state of steady slip."""

    x1: float
    x2: float
    divergence: float
    type: str
    eigenvalues: tuple[complex, ...]
    growth_time: float | None = None
    """Time in which small disturbances grow by the factor e, where it is unstable."""


@dataclass(frozen=True)
class SlidingSegment:
    """Where the mass can stick: from_x1 < x1 < to_x1 on the line x2."""

    from_x1: float
    to_x1: float
    x2: float


@dataclass(frozen=True)
class BistableBand:
    """The dampings between which steady slip and stick-slip both attract."""

    from_c: float
    to_c: float
    error: float


@dataclass(frozen=True)
class Cycle:
    """A cycle."""

    period: float
    x1: Range
    x2: Range
    multiplier: float
    """Floquet multiplier; 0 if it sticks."""
    stable: bool = True
    beyond_exit: float | None = None
    """Of a cycle that crosses the belt line: x1 at which it crosses downward, less that of the exit point."""
    separates: tuple[str, ...] | None = None
    """Of a cycle that repels: what orbits just inside it and just outside it tend to."""


@dataclass(frozen=True)
class Kick:
    """Sudden changes of velocity that carry steady slip onto the outermost unstable slip cycle."""

    forward: float
    backward: float


@dataclass(frozen=True)
class BasinBoundary:
    """The edge of a basin, and the kicks of steady slip onto it."""

    separates: tuple[str, ...]
    """What orbits just inside it and just outside it tend to."""
    cycle: Cycle | None
    """The outermost unstable slip cycle; None where the edge is the grazing orbit, which a drop of friction makes one."""
    kick: Kick


@dataclass(frozen=True)
class SlipCount:
    """What is proved of the number of slip cycles."""

    proved: int | None
    at_least: int
    at_most: int | None
    open: tuple[Range, ...]
    """Maxima of x2 between which nothing is proved."""


@dataclass(frozen=True)
class Cycles:
    """All cycles of a point. None for those of a kind that could not be followed; `reason` says why."""

    stick_slip: Cycle | None = None
    slip: tuple[Cycle, ...] | None = ()
    slip_count: SlipCount | None = None
    crossing: tuple[Cycle, ...] | None = ()
    reason: str | None = None


@dataclass(frozen=True)
class MachineUnits:
    """The units of the dimensionless oscillator, in SI."""

    time: float
    length: float
    velocity: float
    force: float


@dataclass(frozen=True)
class MachineAnswer:
    """What a machine does, in SI units (of a rotation: rad for m, N m for N)."""

    motion: str
    belt_speed: float
    damping: float
    critical_belt_speed: float | None
    """The belt speed above which the mass does not come back to the belt, m/s."""
    critical_damping: float | None
    """The damping coefficient above which the same holds, N s/m; None where none is known to 1 %."""
    critical_damping_ratio: float | None
    damping_ratio: float
    natural_frequency: float
    """Hz"""
    regime: str
    slip_time: float | None
    stick_time: float | None
    amplitude: float | None
    """Half the distance between the extremes of x, m."""
    needed_slip_speed: float | None
    """Slip speed up to which measured friction should be known, m/s, where the orbit leaves the data."""
    units: MachineUnits
    critical_damping_error: float | None = None
    """Estimate of the absolute error of the critical damping, N s/m, also of one that is not known to 1 %."""
    growth_time: float | None = None
    """Time in which small disturbances of unstable steady slip grow by the factor e, s."""


@dataclass(frozen=True)
class Probe:
    """Every answer about one point: what ``slipmap probe --json`` prints, typed.

    Examples
    --------
    >>> import slipmap
    >>> answer = slipmap.probe(slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0), V=0.6, c=0.1, epsilon=1.0)
    >>> answer.landing.crossings
    0
    >>> answer.to_dict()["law"]
    'exponential'
    """

    law: str
    point: dict[str, float]
    tolerance: float
    methods: dict[str, MethodAnswer]
    flow: Flows
    critical_c: CriticalDamping
    regime: str
    equilibrium: Equilibrium
    sliding_segment: SlidingSegment
    exit_point: State
    landing: Landing | None
    bistable_band: BistableBand | None
    attracting_cycle: Cycle | None
    basin_boundary: BasinBoundary | None
    cycles: Cycles
    machine: MachineAnswer | None = None
    sensitivity: Sensitivity | None = None
    regime_conjecture: str | None = None
    """What the regime assumes without proof."""
    _data: dict[str, Any] | None = None

    @classmethod
    def from_json(cls, text: str) -> Probe:
        """The answer that `text`, the output of ``slipmap probe --json``, tells."""
        data = json.loads(text)
        return typing.cast(Probe, _build(cls, {**data, "_data": data}))

    def to_dict(self) -> dict[str, Any]:
        """The answer as ``slipmap probe --json`` prints it."""
        return json.loads(json.dumps(self._data))  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        point = ", ".join(f"{name}={value!r}" for name, value in self.point.items())
        said = ", ".join(f"{name}: {answer.verdict}" for name, answer in self.methods.items())
        return f"<slipmap.Probe {self.law} at {point}; regime {self.regime}; {said}>"

    def _repr_html_(self) -> str:
        def table(rows: list[tuple[Any, ...]], head: tuple[str, ...] = ()) -> str:
            def row(cells: tuple[Any, ...], tag: str) -> str:
                return "<tr>" + "".join(f"<{tag}>{html.escape(_short(cell))}</{tag}>" for cell in cells) + "</tr>"

            body = "".join(row(cells, "td") for cells in rows)
            return f"<table>{row(head, 'th') if head else ''}{body}</table>"

        point = ", ".join(f"{name} = {value:g}" for name, value in self.point.items())
        methods = [
            (name, it.verdict, it.margin, _edge(it), it.guarantee, it.reason)
            for name, it in self.methods.items()
        ]
        facts: list[tuple[Any, ...]] = [("regime", self.regime.replace("_", " "))]
        if self.critical_c.value is not None and self.critical_c.error is not None:
            value, error = self.critical_c.value, self.critical_c.error
            # The search of a negative one may end with its sign.
            is_located = value >= 0.0 or error < -value
            words = _with_error(value, error) if is_located else f"negative, above {value - error:.6g}"
            facts.append(("critical damping", words))
        elif self.critical_c.reason is not None:
            facts.append(("critical damping", f"not told: {self.critical_c.reason}"))
        facts.append(("orbit from the exit point", self.flow.return_map.fate.replace("_", " ")))
        if self.landing:
            facts.append(("slip time, stick time", f"{self.landing.slip_time:g}, {self.landing.stick_time:g}"))
        if self.bistable_band:
            band = self.bistable_band
            facts.append(("both attract for c", f"{band.from_c:g} to {_with_error(band.to_c, band.error)}"))
        if self.attracting_cycle:
            cycle = self.attracting_cycle
            facts.append(("attracting cycle", f"period {cycle.period:g}, multiplier {cycle.multiplier:g}"))
        if self.basin_boundary:
            kick, goal = self.basin_boundary.kick, self.basin_boundary.separates[1].replace("_", " ")
            facts.append((f"kick that leads to {goal}", f"{kick.forward:g} with the belt, {kick.backward:g} against"))
        facts.append(("equilibrium", f"({self.equilibrium.x1:g}, 0), {self.equilibrium.type}"))
        if self.machine:
            units = ("", "m/s", "N s/m") if self.machine.motion == "translation" else ("", "rad/s", "N m s/rad")
            facts.append(("critical belt speed", f"{_short(self.machine.critical_belt_speed)} {units[1]}"))
            damping, known_to = self.machine.critical_damping, self.machine.critical_damping_error
            words = _short(damping) if damping is None or known_to is None else _with_error(damping, known_to)
            facts.append(("critical damping (SI)", f"{words} {units[2]}"))
        head = ("method", "verdict", "margin", "critical c", "guarantee", "reason")
        return f"<p>Law <b>{html.escape(self.law)}</b>: {point}</p>{table(methods, head)}{table(facts)}"


def _with_error(value: float, error: float) -> str:
    """A number and its error, which is rounded up, without digits beyond the second of the error."""
    if not error > 0.0:
        return f"{value!r} ± {error:g}"
    last = math.floor(math.log10(error)) - 1
    known = round(value, -last)
    shown = math.ceil((error + abs(known - value)) / 10.0**last) * 10.0**last
    return f"{known:.{min(17, max(1, _digits(known, last)))}g} ± {shown:.2g}"


def _digits(value: float, last: int) -> int:
    """The number of digits of a value down to the one of 10^last."""
    return 1 if value == 0.0 else math.floor(math.log10(abs(value))) - last + 1


def _edge(answer: MethodAnswer) -> str | None:
    if answer.critical_c is None or answer.critical_c_error is None:
        return None if answer.critical_c is None else _short(answer.critical_c)
    return _with_error(answer.critical_c, answer.critical_c_error)


def _short(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _build(kind: Any, data: Any) -> Any:
    """The value of type `kind` that the JSON `data` tells."""
    if data is None or kind is Any:
        return data
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return _build(next(it for it in arguments if it is not type(None)), data)
    if origin is tuple:
        return tuple(_build(arguments[0], entry) for entry in data)
    if origin is dict:
        return {name: _build(arguments[1], entry) for name, entry in data.items()}
    if kind is complex:
        return complex(data["re"], data["im"])
    if kind is Range:
        return Range(data["from"], data["to"])
    if is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        # Strict: what the program tells and a class lacks is an error.
        return kind(**{name: _build(hints[name], entry) for name, entry in data.items()})  # type: ignore[operator]
    # JSON has no infinity: limits beyond all epsilon examined are the text "inf".
    return float(data) if kind is float else data
