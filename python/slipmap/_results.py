"""The classes of answers, of the structs of the program: tests/documents/results.rs writes them."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Probe:
    """All answers about one point; `slipmap probe --json` prints its serialised form."""

    law: str
    point: dict[str, float]
    """Each axis of the law with its value, in the order of a map's dimensions."""
    tolerance: float
    """Requested bound on the error of the scaled grazing margin m / V of the simulation."""
    methods: dict[str, MethodResult]
    flow: Flows
    """The orbit from the exit point by both engines."""
    critical_c: CriticalResult
    sensitivity: SensitivityResult
    regime: str
    """Name of the long-run behaviour."""
    regime_known: str | None = None
    """What is known of a regime that is not determined in full."""
    regime_reason: str | None = None
    """Reason why the rest of it is not."""
    equilibrium: Equilibrium
    """The state of steady slip."""
    sliding_segment: SlidingSegment
    """The segment on which the mass can stick."""
    exit_point: State
    """The point at which every sticking orbit leaves the belt."""
    landing: LandingResult | None
    """Place and times of sticking again, for the orbit from the exit point."""
    changes: tuple[ChangeResult, ...]
    """The dampings c > 0 at which the behaviour changes at this belt speed, by growing damping."""
    bistable_band: BistableBand | None
    """The dampings between which steady slip and stick-slip both attract."""
    attracting_cycle: Cycle | None
    basin_boundary: BasinBoundary | None
    cycles: Cycles
    """All cycles, with their stability."""
    machine: MachineResult | None = None
    """Behaviour of the machine, in SI units; only if one was given."""


@dataclass(frozen=True, kw_only=True)
class MethodResult:
    verdict: str
    """"present", "absent", "undecided" or "failed"."""
    margin: float | None
    """Signed distance in c to the edge of presence, -infinity where the method claims none;
    None where there is none."""
    critical_c: float | None
    """The edge of presence in c; `None` where there is none at c >= 0, or none that is known to 1 %."""
    critical_c_error: float | None
    """Estimate of its absolute error; `None` for methods whose edge is exact to rounding."""
    guarantee: str
    equation: str
    """Equation in the paper, or section of the theory pages."""
    reason: str | None
    """Reason why the verdict is neither presence nor absence, or what it follows from where that is not the claim
    with this edge."""
    epsilon_limit: float | None
    """Largest epsilon up to which the verdict equals the simulated one; infinite as far as was looked, null where it is unknown."""
    epsilon_limit_reason: str | None
    """Reason why that limit is not known."""


@dataclass(frozen=True, kw_only=True)
class Flows:
    """The orbit from the exit point by both engines."""

    arcs: FlowResult
    direct: FlowResult
    """By integration in (x1, x2)."""


@dataclass(frozen=True, kw_only=True)
class FlowResult:
    """The orbit from the exit point by one engine."""

    fate: str
    """"sticks", "spirals_inward", "crosses_forever", "too_close_to_call" or "failed"."""
    verdict: str
    """The verdict that follows from this fate."""
    margin: float | None
    """The scaled grazing margin m / V; None where the flow has none."""
    margin_error: float | None
    """Estimate of the absolute error of `margin`; None where there is none."""
    rhs: int
    """Evaluations of the right-hand side."""
    landing: LandingResult | None
    """Place and times of sticking."""
    reason: str | None
    """Reason why there is no answer."""


@dataclass(frozen=True, kw_only=True)
class LandingResult:
    """Place and times of sticking."""

    x1: float
    """x1 at which the mass begins to stick."""
    slip_time: float
    stick_time: float
    period: float
    """Sum of slip time and stick time."""
    crossings: int | None
    """Crossings of the belt line before the mass sticks; `None` where the landing is within its error of
    the end of the stick segment."""


@dataclass(frozen=True, kw_only=True)
class CriticalResult:
    """The critical damping of a column."""

    value: float | None
    """c*; negative where no legal damping is small enough for a cycle. `None` where it is not known to 1 %."""
    error: float | None
    """Estimate of the absolute error, also of a c* that is not known to 1 %."""
    rhs: int | None
    """Evaluations of the right-hand side."""
    reason: str | None
    """Reason why there is none."""


@dataclass(frozen=True, kw_only=True)
class SensitivityResult:
    """Derivatives of the critical damping."""

    derivatives: dict[str, Estimate]
    """By each axis but the damping, in the order of a map's dimensions; empty if they are unknown."""
    standard_error: Estimate | None
    """The standard error of the critical damping, of a table with standard errors."""
    reason: str | None
    """Reason why there are none."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A number with its error."""

    value: float | None
    """The number; of a derivative by a parameter, V or eps None where its error is more than 1 % of it and
    1e-9."""
    error: float
    """Estimate of its absolute error."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """The state of steady slip."""

    x1: float
    x2: float
    """Velocity, 0."""
    divergence: float
    type: str
    """Type, for instance "unstable focus"."""
    eigenvalues: tuple[complex, ...]
    growth_time: float | None
    """Time in which small disturbances grow by the factor e, where it is unstable."""


@dataclass(frozen=True, kw_only=True)
class SlidingSegment:
    """The stick segment: from_x1 < x1 < to_x1 on the line x2."""

    from_x1: float
    """The end at which the upper field is tangent."""
    to_x1: float
    """The exit point."""
    x2: float


@dataclass(frozen=True, kw_only=True)
class State:
    x1: float
    x2: float
    """Velocity."""


@dataclass(frozen=True, kw_only=True)
class ChangeResult:
    """A damping at which the behaviour changes."""

    kind: str
    """"hopf", "fold", "unresolved", "grazing", "return" (the critical damping), "crossing" or "far_crossing"."""
    c: float | None
    """The damping; `None` where it is not known to 1 %."""
    at_least: float
    """Bounds of it; the upper one `None` where none is known."""
    at_most: float | None
    """See `at_least`."""
    reason: str | None
    """Reason why the bounds are far apart, where orbits between them cannot be followed."""


@dataclass(frozen=True, kw_only=True)
class BistableBand:
    """The dampings c >= 0 between which steady slip and stick-slip both attract."""

    from_c: float | None
    """Damping above which the equilibrium is stable and the orbit from the exit point sticks; `None` where it is not
    known to 1 %."""
    from_c_between: tuple[float, ...]
    """Bounds of that damping."""
    from_c_reason: str | None
    """Reason why it is not known."""
    to_c: float
    """The critical damping."""
    error: float
    """Estimate of the absolute error of `to_c`."""


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """A limit cycle."""

    period: float
    """Period."""
    x1: Range
    """Positions x1 on it."""
    x2: Range
    """Velocities x2 on it."""
    multiplier: float
    """Floquet multiplier: the cycle attracts if it is below 1 and repels if it is above; 0 for the
    stick-slip cycle, which is reached in finite time."""


@dataclass(frozen=True, kw_only=True)
class Range:
    """A closed interval [lo, hi] that encloses every value of a function."""

    lo: float = field(metadata={"key": "from"})
    """Lower bound."""
    hi: float = field(metadata={"key": "to"})
    """Upper bound."""


@dataclass(frozen=True, kw_only=True)
class BasinBoundary:
    """The edge of a basin, and the kicks of steady slip onto it."""

    separates: tuple[str, ...]
    """The attractors of orbits just inside it and just outside it."""
    cycle: StabilityResult | None
    """The outermost unstable slip cycle; `None` where the edge is the grazing orbit, which a drop of
    friction makes one."""
    kick: Kick


@dataclass(frozen=True, kw_only=True)
class StabilityResult:
    """A cycle with its stability."""

    stable: bool
    """Whether it attracts."""
    multiplier: float
    """Floquet multiplier; 0 if it sticks, infinite above the largest double."""
    separates: tuple[str, ...] | None = None
    """For a repelling cycle: the attractors of the orbits just inside it and just outside it,
    "equilibrium", "slip_cycle", "stick_slip", "crossing" or "unknown"."""
    period: float
    beyond_exit: float | None = None
    """For a cycle that crosses the belt line: x1 at which it crosses downward, less that of the exit
    point."""
    x1: Range
    """Positions on it."""
    x2: Range
    """Velocities on it."""


@dataclass(frozen=True, kw_only=True)
class Kick:
    """Sudden changes of velocity that carry the mass from steady slip, at rest at the equilibrium, onto an
    unstable slip cycle: a slightly larger one leads to the attractor that lies outside of it."""

    forward: float
    """Along the belt's motion, > 0."""
    backward: float
    """Against it, as a positive number."""


@dataclass(frozen=True, kw_only=True)
class Cycles:
    """All cycles; `None` for those of a kind that could not be followed."""

    stick_slip: StabilityResult | None
    """`None` also where there is none."""
    slip: tuple[StabilityResult, ...] | None
    """Cycles below the belt line, by growing amplitude."""
    slip_count: SlipCountResult
    """Bounds on their number."""
    crossing: tuple[StabilityResult, ...] | None
    """Cycles that cross the belt line, by growing size: those that are certain where `reason` says that there may be
    others."""
    reason: str | None = None
    """Reason why some kinds could not be followed."""


@dataclass(frozen=True, kw_only=True)
class SlipCountResult:
    """Proved bounds on the number of slip cycles."""

    proved: int | None
    """The number, where it is proved."""
    at_least: int
    at_most: int | None
    """Upper bound; `None` where there is none."""
    open: tuple[Range, ...]
    """Ranges of the maximum of x2 in which nothing is proved."""


@dataclass(frozen=True, kw_only=True)
class MachineResult:
    """Behaviour of a machine, in SI units (for a rotation: rad for m, N m for N, kg m^2 for kg)."""

    motion: str
    """"translation" or "rotation"."""
    belt_speed: float
    """Belt speed, m/s."""
    damping: float
    """Damping coefficient, N s/m."""
    critical_belt_speed: float | None
    """Belt speed above which the mass does not come back to the belt, m/s."""
    critical_damping: float | None
    """Damping coefficient above which the same holds, N s/m; `None` where none is positive, or known to 1 %."""
    critical_damping_error: float | None
    """Estimate of its absolute error, N s/m, also of one that is not known to 1 %."""
    critical_damping_standard_error: float | None = None
    """Its standard error by measured or fitted friction, N s/m; absent for friction without errors."""
    critical_damping_ratio: float | None
    """The critical damping as a damping ratio."""
    damping_ratio: float
    """Damping ratio d / (2 sqrt(k m))."""
    natural_frequency: float
    """Undamped natural frequency, Hz."""
    regime: str
    """Name of the long-run behaviour."""
    regimes_left_open_by_data: tuple[str, ...] | None = None
    """The regimes that are possible within two standard errors of the friction, that of its nominal values first;
    none where the data decide. Absent for friction without errors."""
    slip_time: float | None
    """Slip time of the stick-slip cycle, s."""
    stick_time: float | None
    """Stick time of the stick-slip cycle, s."""
    growth_time: float | None
    """Time in which disturbances of unstable steady slip grow by the factor e, s."""
    amplitude: float | None
    """Half the distance between the extremes of x of the attracting cycle, m."""
    needed_slip_speed: float | None
    """Slip speed up to which measured friction should be known, m/s, where the orbit leaves the data."""
    units: Units
    """The units of the dimensionless oscillator."""


@dataclass(frozen=True, kw_only=True)
class Units:
    """The units of the dimensionless oscillator, in SI."""

    time: float
    """s."""
    length: float
    """m."""
    velocity: float
    """m/s."""
    force: float
    """N."""


@dataclass(frozen=True, kw_only=True)
class Risk:
    """The result of the draws."""

    draws: int
    """Number of draws that are legal and whose critical damping was found."""
    failed: int
    """Number of draws without a critical damping; the limits of all estimates hold whatever it is."""
    redrawn: int
    """Number of illegal machines that were drawn: those of illegal damping were left out; others, such as
    one of negative mass, were drawn again."""
    fewer_than_usual: bool
    """Whether there are fewer draws than usual, since each takes long."""
    critical_damping_error: float
    """Largest error of the critical dampings found, N s/m (for a rotation N m s/rad)."""
    critical_damping_standard_error: float | None
    """Standard error of the critical damping of the machine as given, N s/m (for a rotation N m s/rad), due
    to those of its measured friction, which the draws include. `None` for friction without them."""
    probability: WithLimits
    """The probability that the machine may stick-slip."""
    by_itself: WithLimits
    """The probability that it vibrates by itself: steady slip is unstable, and every start but that ends in a vibration."""
    rare_by: tuple[RareBy, ...]
    """The dampings for the given probabilities."""


@dataclass(frozen=True, kw_only=True)
class WithLimits:
    """An estimate of a number, with its 95 % confidence limits."""

    value: float
    """The estimate."""
    limits_95: tuple[float, ...]
    """Smallest and largest legal value."""


@dataclass(frozen=True, kw_only=True)
class RareBy:
    """The nominal damping for a given probability of stick-slip."""

    probability: float
    """Its probability."""
    damping: WithLimits | None
    """The damping, N s/m (for a rotation N m s/rad); `None` if there are too few draws for limits."""


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """Laws fitted to measured friction: what `slipmap fit --json` prints."""

    data: str
    """The file."""
    read: tuple[str, ...]
    """What has been understood of it, one phrase each."""
    quantity: str
    """"force" (of a rotation a torque) or "coefficient"."""
    speed_unit: str
    friction_unit: str
    """Empty for a coefficient."""
    fastest: float | None
    """Largest slip speed of the readings."""
    fit: FittedLaw
    """The best law, or the one that was asked for."""
    fits: tuple[FittedLaw, ...]
    """All laws, the best one first."""
    about_as_good: int
    """The number of laws that are about as good as the best one."""
    no_stick_slip: str | None
    """That there is no stick-slip, and why; `None` for friction that falls or drops."""
    slip_speeds: tuple[float, ...]
    """Slip speeds of the residuals: those of the readings, of a record over time those of its means."""
    residuals: tuple[float, ...]
    """Readings less the law."""
    lack_of_fit: float
    """How much more the residuals follow smooth curves than by chance, in standard deviations: far above 0 where the law does
    not follow the readings."""


@dataclass(frozen=True, kw_only=True)
class FittedLaw:
    """A law fitted to measured friction, in SI units."""

    law: str
    """Its name in the table of laws."""
    formula: str
    """Friction as a formula in the slip speed u."""
    aicc: float
    """Akaike's criterion for small samples: only differences between laws fitted to the same readings mean anything."""
    residual: float
    """Root mean square of the residuals in slip."""
    reduced_chi_squared: float | None
    """The sum of the squares of the residuals in units of the standard errors, divided by the degrees of freedom;
    `None` for readings without standard errors."""
    names: tuple[str, ...]
    """The parameters."""
    values: tuple[float, ...]
    standard_errors: tuple[float, ...]
    units: tuple[str, ...]
    """Their units; empty for a pure number."""
    covariance: tuple[tuple[float, ...], ...]
    static: float | None
    """Friction at rest, where it drops as slip begins."""
    static_standard_error: float | None
    """`None` of a single reading, which does not say."""
