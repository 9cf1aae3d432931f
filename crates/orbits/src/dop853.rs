//! One step of the explicit Runge-Kutta method of Dormand and Prince, order 8 with embedded orders 5 and 3
//! (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, section II.5; coefficients as
//! published there).
//!
//! The step is a pure function of stage values, so that the same code serves eight orbits in the lanes of a
//! vector and the components of one orbit. Every product is fused with its sum, which makes results equal on
//! all machines, whatever their vector width.

use super::polar::LANES;
use slipmap_numbers::Aligned;
use slipmap_numbers::TimesPlus as _;

/// Number of stages, and of right-hand sides per step.
pub const STAGES: usize = 12;

/// Abscissae of the stages, in units of the step.
pub(super) const NODES: [f64; STAGES] = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    1.0 / 3.0,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
];

/// Nonzero entries (stage, weight) of the Runge-Kutta matrix, row by row.
const MATRIX: [&[(usize, f64)]; STAGES] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[(0, 0.2413651341592667), (2, -0.8845494793282861), (3, 0.924834003261792)],
    &[(0, 0.037037037037037035), (3, 0.17082860872947386), (4, 0.12546768756682242)],
    &[(0, 0.037109375), (3, 0.17025221101954405), (4, 0.06021653898045596), (5, -0.017578125)],
    &[
        (0, 0.03709200011850479),
        (3, 0.17038392571223998),
        (4, 0.10726203044637328),
        (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ],
    &[
        (0, 0.6241109587160757),
        (3, -3.3608926294469414),
        (4, -0.868219346841726),
        (5, 27.59209969944671),
        (6, 20.154067550477894),
        (7, -43.48988418106996),
    ],
    &[
        (0, 0.47766253643826434),
        (3, -2.4881146199716677),
        (4, -0.590290826836843),
        (5, 21.230051448181193),
        (6, 15.279233632882423),
        (7, -33.28821096898486),
        (8, -0.020331201708508627),
    ],
    &[
        (0, -0.9371424300859873),
        (3, 5.186372428844064),
        (4, 1.0914373489967295),
        (5, -8.149787010746927),
        (6, -18.52006565999696),
        (7, 22.739487099350505),
        (8, 2.4936055526796523),
        (9, -3.0467644718982196),
    ],
    &[
        (0, 2.273310147516538),
        (3, -10.53449546673725),
        (4, -2.0008720582248625),
        (5, -17.9589318631188),
        (6, 27.94888452941996),
        (7, -2.8589982771350235),
        (8, -8.87285693353063),
        (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ],
];

/// Nonzero weights (stage, order 8, error of order 5, error of order 3).
const WEIGHTS: [(usize, f64, f64, f64); 8] = [
    (0, 0.054293734116568765, 0.01312004499419488, -0.18980075407240762),
    (5, 4.450312892752409, -1.2251564463762044, 4.450312892752409),
    (6, 1.8915178993145003, -0.4957589496572502, 1.8915178993145003),
    (7, -5.801203960010585, 1.6643771824549864, -5.801203960010585),
    (8, 0.3111643669578199, -0.35032884874997366, -0.4226823213237919),
    (9, -0.1521609496625161, 0.3341791187130175, -0.1521609496625161),
    (10, 0.20136540080403034, 0.08192320648511571, 0.20136540080403034),
    (11, 0.04471061572777259, -0.022355307863886294, 0.02265179219836082),
];

/// A right-hand side y' = f within one step.
///
/// It has to be inlined into the function whose vector width is selected at run time: without that every
/// fused product becomes a library call.
pub(super) trait Field<const N: usize> {
    /// f at the abscissa `NODES[stage]` of the step.
    fn slope(&mut self, stage: usize, state: &Aligned<N>) -> Aligned<N>;
}

/// Advances `state` by one step `h` of y' = f and returns the new state and the estimate of each
/// component's local error (the combination of the two embedded errors that the authors propose).
#[inline(always)]
pub(super) fn step<const N: usize>(
    h: f64,
    state: &Aligned<N>,
    field: &mut impl Field<N>,
) -> (Aligned<N>, Aligned<N>) {
    // Loops over lanes are plain: adapters such as `zip` may be compiled in another codegen unit than this
    // function, and then they are not inlined.
    let mut k = [Aligned::default(); STAGES];
    for stage in 0..STAGES {
        let mut at = *state;
        // One vector of lanes after the other: sums of all of them may lack registers.
        let width = const { if N.is_multiple_of(LANES) { LANES } else { N } };
        for from in (0..N).step_by(width) {
            let mut sum = Aligned::<LANES>::default();
            for &(other, weight) in MATRIX[stage] {
                for lane in 0..width {
                    sum[lane] = k[other][from + lane].times_plus(weight, sum[lane]);
                }
            }
            for lane in 0..width {
                at[from + lane] = sum[lane].times_plus(h, at[from + lane]);
            }
        }
        k[stage] = field.slope(stage, &at);
    }
    let [mut sum, mut error_5, mut error_3] = [Aligned::<N>::default(); 3];
    for (stage, weight, weight_5, weight_3) in WEIGHTS {
        for lane in 0..N {
            sum[lane] = k[stage][lane].times_plus(weight, sum[lane]);
            error_5[lane] = k[stage][lane].times_plus(weight_5, error_5[lane]);
            error_3[lane] = k[stage][lane].times_plus(weight_3, error_3[lane]);
        }
    }
    let mut next = *state;
    let mut error = Aligned::default();
    for lane in 0..N {
        next[lane] = sum[lane].times_plus(h, next[lane]);
        let (e5, e3) = (error_5[lane].abs(), error_3[lane].abs());
        let scale = e5.times_plus(e5, 0.01 * e3 * e3).sqrt();
        // Squares of the errors of very slow orbits vanish.
        error[lane] = if scale > 0.0 { h.abs() * e5 * e5 / scale } else { h.abs() * e5 };
    }
    (next, error)
}
