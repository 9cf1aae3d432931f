//! What a map can store in each cell: fields as configurations name them, and the quantities they consist of.

/// A quantity that a map can store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Field {
    /// `verdict_METHOD`, always stored.
    Verdict,
    /// `margin_METHOD`.
    Margin,
    /// `critical_c_METHOD`, without the damping axis.
    CriticalC,
    /// `regime`.
    Regime,
    /// `landing_x1`, `stick_time`, `slip_time` and `crossings`.
    Landing,
    /// Period, amplitudes and multiplier of the attracting cycle.
    Cycle,
    /// The outermost unstable slip cycle, and the kicks of steady slip onto it.
    Basin,
    /// `epsilon_limit_METHOD`.
    EpsilonLimit,
    /// `dc_dAXIS`.
    Sensitivity,
}

impl Field {
    /// Every field.
    pub const ALL: [Field; 9] = [
        Field::Verdict,
        Field::Margin,
        Field::CriticalC,
        Field::Regime,
        Field::Landing,
        Field::Cycle,
        Field::Basin,
        Field::EpsilonLimit,
        Field::Sensitivity,
    ];

    /// Name in configurations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Field::Verdict => "verdict",
            Field::Margin => "margin",
            Field::CriticalC => "critical_c",
            Field::Regime => "regime",
            Field::Landing => "landing",
            Field::Cycle => "cycle",
            Field::Basin => "basin",
            Field::EpsilonLimit => "epsilon_limit",
            Field::Sensitivity => "sensitivity",
        }
    }

    /// Returns whether it is computed from the simulated flow, whatever the methods.
    pub(crate) fn needs_flow(self) -> bool {
        match self {
            Field::Verdict | Field::Margin | Field::CriticalC => false,
            Field::Regime
            | Field::Landing
            | Field::Cycle
            | Field::Basin
            | Field::EpsilonLimit
            | Field::Sensitivity => true,
        }
    }
}

/// A real number per cell; NaN where the cell has no such number.
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
    /// Half the range of its positions.
    CycleAmplitudeX1,
    /// Half the range of its velocities.
    CycleAmplitudeX2,
    /// Its Floquet multiplier.
    CycleMultiplier,
    /// Largest velocity on the outermost unstable slip cycle, which separates two attractors.
    BoundaryVelocity,
    /// Floquet multiplier of that cycle.
    BoundaryMultiplier,
    /// The sudden change of velocity with the belt that carries steady slip onto that cycle.
    KickForward,
    /// The same against the belt.
    KickBackward,
    /// Limit in eps of the method with this position.
    EpsilonLimit(usize),
    /// Derivative of the critical damping by the axis with this position.
    CriticalDerivative(usize),
}

impl Quantity {
    /// The quantities of a field, with `methods` methods and a law of `parameters` parameters.
    pub(crate) fn of(field: Field, methods: usize, parameters: usize) -> Vec<Quantity> {
        use Quantity::*;
        match field {
            Field::Verdict | Field::Margin | Field::CriticalC | Field::Regime => Vec::new(),
            Field::Landing => vec![LandingX1, StickTime, SlipTime, Crossings],
            Field::Cycle => {
                vec![SlipCycles, CyclePeriod, CycleAmplitudeX1, CycleAmplitudeX2, CycleMultiplier]
            }
            Field::Basin => vec![BoundaryVelocity, BoundaryMultiplier, KickForward, KickBackward],
            Field::EpsilonLimit => (0..methods).map(EpsilonLimit).collect(),
            // By eps, by each parameter and by V.
            Field::Sensitivity => (0..parameters + 2).map(CriticalDerivative).collect(),
        }
    }

    /// Its name in a map; that of [`Quantity::EpsilonLimit`] is followed by its method's, that of
    /// [`Quantity::CriticalDerivative`] by its axis's.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Quantity::LandingX1 => "landing_x1",
            Quantity::StickTime => "stick_time",
            Quantity::SlipTime => "slip_time",
            Quantity::Crossings => "crossings",
            Quantity::SlipCycles => "slip_cycles",
            Quantity::CyclePeriod => "cycle_period",
            Quantity::CycleAmplitudeX1 => "cycle_amplitude_x1",
            Quantity::CycleAmplitudeX2 => "cycle_amplitude_x2",
            Quantity::CycleMultiplier => "cycle_multiplier",
            Quantity::BoundaryVelocity => "boundary_velocity",
            Quantity::BoundaryMultiplier => "boundary_multiplier",
            Quantity::KickForward => "kick_forward",
            Quantity::KickBackward => "kick_backward",
            Quantity::EpsilonLimit(_) => "epsilon_limit",
            Quantity::CriticalDerivative(_) => "dc_d",
        }
    }

    /// One phrase for `long_name`.
    pub(crate) fn long_name(self) -> &'static str {
        match self {
            Quantity::LandingX1 => "x1 at which the mass begins to stick",
            Quantity::StickTime => "time of sticking per period",
            Quantity::SlipTime => "time of slipping per period",
            Quantity::Crossings => "crossings of the belt line before the mass sticks",
            Quantity::SlipCycles => {
                "number of cycles, stable or not, that slip all the time below the belt line"
            }
            Quantity::CyclePeriod => "period of the attracting cycle",
            Quantity::CycleAmplitudeX1 => "half the range of x1 on the attracting cycle",
            Quantity::CycleAmplitudeX2 => "half the range of x2 on the attracting cycle",
            Quantity::CycleMultiplier => "Floquet multiplier of the attracting cycle, 0 if it sticks",
            Quantity::BoundaryVelocity => {
                "largest x2 on the outermost unstable slip cycle, which separates two attractors"
            }
            Quantity::BoundaryMultiplier => "Floquet multiplier of the outermost unstable slip cycle",
            Quantity::KickForward => {
                "smallest kick along the belt's motion from steady slip beyond the outermost unstable slip cycle"
            }
            Quantity::KickBackward => {
                "smallest kick against the belt's motion from steady slip beyond the outermost unstable slip cycle"
            }
            Quantity::EpsilonLimit(_) => {
                "largest epsilon up to which the verdict equals the simulated one, at these other parameters \
                 (0: never; inf: up to 10 at least)"
            }
            Quantity::CriticalDerivative(_) => "derivative of the exact critical damping by",
        }
    }
}
