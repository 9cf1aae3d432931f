//! One turn of many orbits by collocation.
//!
//! # Angle
//! In a skew pair of axes that turns the flow with constant divergence d0 = D at belt speed into a pure
//! spiral (mu = -d0 / (2 omega), omega = sqrt(1 - d0^2/4)),
//!
//! ```text
//! v = r (cos t + mu sin t),    w = -r sin t / omega,    t in [0, 2 pi],
//! d ln r / dt = -mu + sin^2 t H,    H = E / (omega^2 (omega + E Q)),    Q = sin t (cos t + mu sin t)
//! ```
//!
//! with E = D - d0. The ray t = 0 is still w = 0, v > 0, so that ln r(2 pi) is that of the polar form; but
//! only the *variation* of D has to be integrated, and the integral vanishes if D is constant. With x = v/V
//! and q = 1 + k (1 - x), Stribeck's law has E = x (A k (1 + k + q) / ((1+k)^2 q^2) + 2 b), free of
//! cancellation.
//!
//! # Method
//! H is collocated on [`Nodes`]. With the residual r = H - h of the iterate's slope h, a sweep is
//! y <- y + (1 + S J) S r: Newton's method to second order in S J, where S integrates with weight sin^2
//! from the start of the turn and J = dH/dy is taken at the first guess. The last evaluation of H only
//! enters ln r(2 pi), weighted by exp(K(2 pi) - K(t)) with K = S J, which makes its error quadratic in that
//! of the iterate.
//!
//! The method is for orbits near the circle, where D hardly varies along the orbit: there two to four
//! evaluations of H on 8 to 40 angles reach any tolerance, in 0.2 microseconds a turn. [`super::stepping`]
//! takes seven times as long; other orbits are handed over to it.

mod field;
mod ladder;
mod lanes;
mod nodes;
mod orbit;

use pulp::{Simd, WithSimd};

use field::{Field, exp_m1};
pub(super) use ladder::turns;
use lanes::Lanes;
use nodes::Nodes;
use orbit::Orbit;
use slipmap_model::point::ScaledGroups;

/// Largest number of orbits together: two registers of the widest vectors.
const MOST_LANES: usize = 16;

/// The result of one turn of an orbit.
#[derive(Clone, Copy, Debug, Default)]
struct Lap {
    /// r(2 pi) / V - 1: the margin m / V.
    margin: f64,
    /// Estimate of the error of ln r(2 pi) that more nodes would remove.
    truncation: f64,
    /// Estimate of the error that more sweeps would remove.
    iteration: f64,
    /// Estimate of the rounding error.
    rounding: f64,
    /// Distance of the orbit from the border of the domain. If it is not positive, the lap is invalid.
    room: f64,
}

/// Arguments of the laps of the orbits that `orbits` selects from `groups`.
struct Laps<'a> {
    nodes: &'a Nodes,
    /// Number of evaluations of H per node, at least 2.
    evaluations: u32,
    groups: &'a [ScaledGroups],
    orbits: &'a [u32],
    laps: &'a mut Vec<Lap>,
}

impl WithSimd for Laps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let count = Lanes::<S>::COUNT;
        let mut orbit = Orbit::new(simd);

        for orbits in self.orbits.chunks(count) {
            let [mut a, mut k, mut b, mut c] = [[0.0; MOST_LANES]; 4];
            for lane in 0..count {
                // A last vector that is not full repeats its last orbit.
                let groups = &self.groups[orbits[lane.min(orbits.len() - 1)] as usize];
                (a[lane], k[lane], b[lane], c[lane]) = (groups.a, groups.k, groups.b, groups.c);
            }
            let field = Field::new(
                Lanes::load(simd, &a),
                Lanes::load(simd, &k),
                Lanes::load(simd, &b),
                Lanes::load(simd, &c),
            );
            orbit.guess(self.nodes, &field);
            for _ in 1..self.evaluations {
                orbit.sweep(self.nodes, &field);
            }
            let end = orbit.finish(self.nodes, &field);
            let [mut margin, mut truncation, mut iteration, mut rounding, mut room] = [[0.0; MOST_LANES]; 5];
            exp_m1(end.log).store(&mut margin);
            end.truncation.store(&mut truncation);
            end.iteration.store(&mut iteration);
            end.rounding.store(&mut rounding);
            end.room.store(&mut room);
            for lane in 0..orbits.len() {
                self.laps.push(Lap {
                    margin: margin[lane],
                    truncation: truncation[lane],
                    iteration: iteration[lane],
                    rounding: rounding[lane],
                    room: room[lane],
                });
            }
        }
    }
}
