//! The fields that a map can store, named as in configurations, and the quantities that they consist of.

use super::Grid;
use slipmap_column::Method;
use slipmap_machine::{DAMPING_RATIO, Dimension, Machine};
use slipmap_numbers::named;

named! {
    /// A field that a map can store, with its name in configurations.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Field {
        /// `verdict_METHOD`, always stored.
        Verdict => "verdict",
        /// `margin_METHOD`.
        Margin => "margin",
        /// `critical_c_METHOD` and `critical_c_error_simulation`, without the damping axis; of a machine
        /// `critical_damping_METHOD` and its errors.
        CriticalC => "critical_c",
        /// `regime`.
        Regime => "regime",
        /// `landing_x1`, `stick_time`, `slip_time` and `crossings`.
        Landing => "landing",
        /// The number of slip cycles; period, amplitudes and multiplier of the attracting cycle.
        Cycle => "cycle",
        /// The outermost unstable slip cycle, and the kicks of steady slip onto it.
        Basin => "basin",
        /// The e-folding time of unstable steady slip.
        Growth => "growth",
        /// `epsilon_limit_METHOD`.
        EpsilonLimit => "epsilon_limit",
        /// `dc_dAXIS`.
        Sensitivity => "sensitivity",
    }
}

impl Field {
    /// What the name of a method follows in that of the variable with its critical dampings: c, or a machine's as
    /// they are given, as a ratio or in SI units.
    pub const CRITICAL: [&str; 3] = ["critical_c_", "critical_damping_ratio_", "critical_damping_"];
    /// The same for their errors.
    pub const CRITICAL_ERROR: [&str; 3] =
        ["critical_c_error_", "critical_damping_ratio_error_", "critical_damping_error_"];

    /// Those of [`Field::CRITICAL`] and [`Field::CRITICAL_ERROR`] in the maps of a grid.
    pub fn critical_of(grid: &Grid) -> [&'static str; 2] {
        let kind = match grid.machine().map(Machine::damping_name) {
            None => 0,
            Some(DAMPING_RATIO) => 1,
            Some(_) => 2,
        };
        [Self::CRITICAL[kind], Self::CRITICAL_ERROR[kind]]
    }

    /// Its name in configurations and maps of a grid in dimensionless numbers, or of a machine.
    pub fn name_for(self, is_machine: bool) -> &'static str {
        match (self, is_machine) {
            (Field::CriticalC, true) => "critical_damping",
            (field, _) => field.name(),
        }
    }

    /// Whether a variable holds critical dampings or their errors: it has no damping axis.
    pub fn is_critical(variable: &str) -> bool {
        Self::CRITICAL.iter().any(|prefix| variable.starts_with(prefix))
    }

    /// Returns whether the field is computed from the simulated flow, whichever methods the plan has.
    pub fn needs_flow(self) -> bool {
        !matches!(self, Field::Verdict | Field::Margin | Field::CriticalC)
    }

    /// The field to which a variable of a map belongs by its name, and the method in the name.
    pub fn of_variable(variable: &str) -> Option<(Self, Option<Method>)> {
        let after = |prefix: &&str| variable.strip_prefix(*prefix);
        if let Some(method) = Self::CRITICAL_ERROR.iter().chain(&Self::CRITICAL).find_map(after) {
            return Some((Field::CriticalC, Some(Method::by_name(method)?)));
        }
        Field::ALL.into_iter().find_map(|field| {
            let is_one = match field {
                Field::Verdict | Field::Margin | Field::EpsilonLimit => {
                    let method = variable.strip_prefix(field.name())?.strip_prefix('_')?;
                    return Some((field, Some(Method::by_name(method)?)));
                }
                Field::CriticalC => false,
                Field::Regime => variable == field.name(),
                Field::Sensitivity => variable.starts_with(Quantity::CriticalDerivative(0).name()),
                _ => Quantity::of(field, 0, 0).iter().any(|quantity| quantity.name() == variable),
            };
            is_one.then_some((field, None))
        })
    }
}

/// What is shown of a quantity besides its values.
pub struct About {
    /// Name in a map.
    pub(crate) name: &'static str,
    /// One phrase for legends and axes of figures, with symbols in braces; those of quantities of a method or
    /// an axis are in `crates/report/src/units.rs`.
    pub label: &'static str,
    /// `None` for a pure number.
    pub(crate) dimension: Option<Dimension>,
    /// One phrase for `long_name`.
    pub(crate) long_name: &'static str,
}

/// A real number in each cell; NaN where the cell has no such number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// x1 at which the mass begins to stick.
    LandingX1,
    /// Time of sticking per period.
    StickTime,
    /// Time of slipping per period.
    SlipTime,
    /// Crossings of the belt line before the mass sticks.
    Crossings,
    /// Number of cycles, stable or not, that slip all the time below the belt line.
    SlipCycles,
    /// Period of the attracting cycle.
    CyclePeriod,
    /// Half the range of x1 on the attracting cycle.
    CycleAmplitudeX1,
    /// Half the range of x2 on the attracting cycle.
    CycleAmplitudeX2,
    /// Floquet multiplier of the attracting cycle.
    CycleMultiplier,
    /// Largest velocity on the outermost unstable slip cycle, which separates two attractors.
    BoundaryVelocity,
    /// Floquet multiplier of the outermost unstable slip cycle.
    BoundaryMultiplier,
    /// The sudden change of velocity along the belt's motion that carries steady slip onto that cycle.
    KickForward,
    /// The sudden change of velocity against the belt's motion that does so, as a positive number.
    KickBackward,
    /// Time in which small disturbances of unstable steady slip grow by the factor e.
    GrowthTime,
    /// Limit in eps of the method at this position in the plan.
    EpsilonLimit(usize),
    /// Derivative of the critical damping with respect to the axis at this position.
    CriticalDerivative(usize),
}

impl Quantity {
    /// The quantities of a field, for a plan with `methods` methods and a grid of `axes` axes besides the damping.
    pub(crate) fn of(field: Field, methods: usize, axes: usize) -> Vec<Quantity> {
        use Quantity::*;
        match field {
            Field::Verdict | Field::Margin | Field::CriticalC | Field::Regime => Vec::new(),
            Field::Landing => vec![LandingX1, StickTime, SlipTime, Crossings],
            Field::Cycle => {
                vec![SlipCycles, CyclePeriod, CycleAmplitudeX1, CycleAmplitudeX2, CycleMultiplier]
            }
            Field::Basin => vec![BoundaryVelocity, BoundaryMultiplier, KickForward, KickBackward],
            Field::Growth => vec![GrowthTime],
            Field::EpsilonLimit => (0..methods).map(EpsilonLimit).collect(),
            Field::Sensitivity => (0..axes).map(CriticalDerivative).collect(),
        }
    }

    /// The quantities of a cell's orbits: those that belong to no method and to no axis.
    pub fn of_orbits() -> impl Iterator<Item = Quantity> {
        let all = Field::ALL.into_iter().flat_map(|field| Quantity::of(field, 0, 0));
        all.filter(|quantity| {
            !matches!(quantity, Quantity::EpsilonLimit(_) | Quantity::CriticalDerivative(_))
        })
    }

    /// The quantity of this name; `None` for those of methods and axes.
    pub fn by_name(name: &str) -> Option<Quantity> {
        Self::of_orbits().find(|quantity| quantity.name() == name)
    }

    /// Its name in a map. A map appends the name of the method to that of [`Quantity::EpsilonLimit`], and the
    /// name of the axis to that of [`Quantity::CriticalDerivative`].
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// What it is, in a few words.
    pub fn long_name(self) -> &'static str {
        self.about().long_name
    }

    /// All that is shown of it besides its values.
    pub fn about(self) -> About {
        use Dimension::{Length, Time, Velocity};
        use Quantity::*;
        let about = |name, label, dimension, long_name| About { name, label, dimension, long_name };
        match self {
            LandingX1 => {
                about("landing_x1", "{x_1} of landing", Some(Length), "x1 at which the mass begins to stick")
            }
            StickTime => about("stick_time", "stick time", Some(Time), "time of sticking per period"),
            SlipTime => about("slip_time", "slip time", Some(Time), "time of slipping per period"),
            Crossings => about(
                "crossings",
                "crossings before it sticks",
                None,
                "crossings of the belt line before the mass sticks",
            ),
            SlipCycles => about(
                "slip_cycles",
                "slip cycles",
                None,
                "number of cycles, stable or not, that slip all the time below the belt line",
            ),
            CyclePeriod => about("cycle_period", "period", Some(Time), "period of the attracting cycle"),
            CycleAmplitudeX1 => about(
                "cycle_amplitude_x1",
                "amplitude of {x_1}",
                Some(Length),
                "half the range of x1 on the attracting cycle",
            ),
            CycleAmplitudeX2 => about(
                "cycle_amplitude_x2",
                "amplitude of {x_2}",
                Some(Velocity),
                "half the range of x2 on the attracting cycle",
            ),
            CycleMultiplier => about(
                "cycle_multiplier",
                "Floquet multiplier",
                None,
                "Floquet multiplier of the attracting cycle, 0 if it sticks",
            ),
            BoundaryVelocity => about(
                "boundary_velocity",
                "largest {x_2} on the unstable cycle",
                Some(Velocity),
                "largest x2 on the outermost unstable slip cycle, which separates two attractors",
            ),
            BoundaryMultiplier => about(
                "boundary_multiplier",
                "Floquet multiplier of the unstable cycle",
                None,
                "Floquet multiplier of the outermost unstable slip cycle",
            ),
            KickForward => about(
                "kick_forward",
                "kick with the belt",
                Some(Velocity),
                "smallest kick along the belt's motion from steady slip beyond the outermost unstable slip cycle",
            ),
            KickBackward => about(
                "kick_backward",
                "kick against the belt",
                Some(Velocity),
                "smallest kick against the belt's motion from steady slip beyond the outermost unstable slip cycle",
            ),
            GrowthTime => about(
                "growth_time",
                "growth time of unstable steady slip",
                Some(Time),
                "time in which small disturbances of steady slip grow by the factor e, where it is unstable",
            ),
            EpsilonLimit(_) => about(
                "epsilon_limit",
                "largest {epsilon} of agreement",
                None,
                "largest epsilon up to which the verdict equals the simulated one, at these other parameters \
                 (0: never; inf: up to 10 at least)",
            ),
            CriticalDerivative(_) => about(
                "dc_d",
                "derivative of the critical damping",
                // A damping by a velocity or by a pure number, which has no unit of its own here.
                None,
                "derivative of the exact critical damping by",
            ),
        }
    }
}
