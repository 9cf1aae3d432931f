"""Every answer about one point, typed."""

from __future__ import annotations

import html
import json
import math
from dataclasses import dataclass, field
from typing import Any

from . import _results
from ._decode import decode


@dataclass(frozen=True, kw_only=True)
class Probe(_results.Probe):
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

    _data: dict[str, Any] = field(repr=False)

    @classmethod
    def from_json(cls, text: str) -> Probe:
        """The answer that `text`, the output of ``slipmap probe --json``, tells."""
        data = json.loads(text)
        return decode(cls, {**data, "_data": data})

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
            facts.append(("critical damping", _with_error(value, error)))
        elif self.critical_c.reason is not None:
            facts.append(("critical damping", f"not told: {self.critical_c.reason}"))
        facts.append(("orbit from the exit point", self.flow.arcs.fate.replace("_", " ")))
        if self.landing:
            facts.append(("slip time, stick time", f"{self.landing.slip_time:g}, {self.landing.stick_time:g}"))
        if self.bistable_band:
            band = self.bistable_band
            low, high = band.from_c_between
            begins = f"from between {low:g} and {high:g}" if band.from_c is None else f"{band.from_c:g}"
            why = f"; where it begins is not known closer: {band.from_c_reason}" if band.from_c is None else ""
            facts.append(("both attract for c", f"{begins} to {_with_error(band.to_c, band.error)}{why}"))
        if self.attracting_cycle:
            cycle = self.attracting_cycle
            facts.append(("attracting cycle", f"period {cycle.period:g}, multiplier {cycle.multiplier:g}"))
        if self.basin_boundary:
            kick, goal = self.basin_boundary.kick, self.basin_boundary.separates[1].replace("_", " ")
            facts.append((f"kick that leads to {goal}", f"{kick.forward:g} with the belt, {kick.backward:g} against"))
        facts.append(("equilibrium", f"({self.equilibrium.x1:g}, 0), {self.equilibrium.type}"))
        head = ("method", "verdict", "margin", "critical c", "guarantee", "reason")
        shown = f"<p>Law <b>{html.escape(self.law)}</b>: {point}</p>{table(methods, head)}{table(facts)}"
        if self.machine is None:
            return shown
        return f"<h4>The machine, in SI units</h4>{table(self._of_machine(self.machine))}<h4>In dimensionless terms</h4>{shown}"

    def _of_machine(self, machine: _results.MachineResult) -> list[tuple[str, str]]:
        """The answers in SI units."""
        turns = machine.motion == "rotation"
        velocity, damping, length = ("rad/s", "N m s/rad", "rad") if turns else ("m/s", "N s/m", "m")

        def of(value: float | None, unit: str) -> str:
            return _short(value) if value is None else f"{value:.6g} {unit}"

        critical, known_to = machine.critical_damping, machine.critical_damping_error
        if critical is not None and known_to is not None:
            by_friction = machine.critical_damping_standard_error or 0.0
            words = f"{_with_error(critical, max(known_to, by_friction))} {damping}"
        else:
            words = "–" if self.critical_c.reason is None else f"not told: {self.critical_c.reason}"
        facts = [
            ("regime", machine.regime.replace("_", " ")),
            ("belt speed", of(machine.belt_speed, velocity)),
            ("critical belt speed", of(machine.critical_belt_speed, velocity)),
            ("damping", of(machine.damping, damping)),
            ("critical damping", words),
            ("natural frequency", of(machine.natural_frequency, "Hz")),
            ("slip time, stick time", f"{of(machine.slip_time, 's')}, {of(machine.stick_time, 's')}"),
            ("growth time of steady slip", of(machine.growth_time, "s")),
            ("amplitude", of(machine.amplitude, length)),
        ]
        if self.basin_boundary:
            kick, unit = self.basin_boundary.kick, machine.units.velocity
            goal = self.basin_boundary.separates[1].replace("_", " ")
            words = f"{kick.forward * unit:.6g} {velocity} with the belt, {kick.backward * unit:.6g} {velocity} against"
            facts.append((f"kick that leads to {goal}", words))
        return facts


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


def _edge(answer: _results.MethodResult) -> str | None:
    if answer.critical_c is None or answer.critical_c_error is None:
        return None if answer.critical_c is None else _short(answer.critical_c)
    return _with_error(answer.critical_c, answer.critical_c_error)


def _short(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
