//! The bound of the amplitude for many columns of Stribeck's law at once, one per lane of vector registers.
//!
//! Each lane does the operations of [`super::amplitude_bound`] in the same order, on D in units of the belt
//! speed; branches become selections between two results.

use super::{approach, exit_energy, turning_point};
use slipmap_model::friction::Column;
use slipmap_model::point::ScaledGroups;

/// Number of columns that are bounded together: two registers of the widest kind.
const LANES: usize = 16;

type Lanes = [f64; LANES];

/// [`super::amplitude_bound`] of each column at its damping.
pub(crate) fn amplitude_bounds(columns: &[(&Column, f64)], strips: u32) -> Vec<f64> {
    let groups: Option<Vec<ScaledGroups>> = columns
        .iter()
        .map(|(column, c)| {
            column.curve.stribeck().map(|law| law.scaled(column.belt_speed, column.epsilon * c))
        })
        .collect();
    let Some(groups) = groups else {
        return columns.iter().map(|&(column, c)| super::amplitude_bound(column, c, strips)).collect();
    };
    let arch = pulp::Arch::new();
    let mut bounds = Vec::with_capacity(columns.len());
    for (columns, groups) in columns.chunks(LANES).zip(groups.chunks(LANES)) {
        let of = |lane: usize| groups[lane.min(groups.len() - 1)];
        let lanes = Scaled {
            a: std::array::from_fn(|lane| of(lane).a),
            k: std::array::from_fn(|lane| of(lane).k),
            b: std::array::from_fn(|lane| of(lane).b),
            viscous: std::array::from_fn(|lane| of(lane).c),
        };
        let Reached { energy, s } = arch.dispatch(Dispatched { lanes: &lanes, strips });
        for (lane, (column, _)) in columns.iter().enumerate() {
            // Infinite or not a number: the strips found no bound.
            let found = energy[lane].is_finite();
            let amplitude = match found {
                true => turning_point(energy[lane], s[lane], |_| of(lane).divergence(1.0 + s[lane])),
                false => f64::INFINITY,
            };
            bounds.push(column.belt_speed * amplitude);
        }
    }
    bounds
}

/// The scaled groups of the lanes.
struct Scaled {
    a: Lanes,
    k: Lanes,
    b: Lanes,
    viscous: Lanes,
}

impl Scaled {
    /// D at the slip speed 1 + s, which is its maximum at higher slip speeds, since D falls.
    #[inline(always)]
    fn divergence(&self, s: &Lanes) -> Lanes {
        std::array::from_fn(|lane| {
            let slip = 1.0 + s[lane];
            let q = 1.0 + self.k[lane] * slip;
            self.a[lane] / (q * q) - self.viscous[lane] - 2.0 * self.b[lane] * slip
        })
    }
}

/// The end of the last strip that the orbit reaches, and the bound of e there.
struct Reached {
    energy: Lanes,
    s: Lanes,
}

/// Arguments of [`lower_half`] for the function whose vector width pulp selects at run time.
struct Dispatched<'a> {
    lanes: &'a Scaled,
    strips: u32,
}

impl pulp::WithSimd for Dispatched<'_> {
    type Output = Reached;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Reached {
        lower_half(self.lanes, self.strips)
    }
}

/// The strips of the lower half: those of `Flow::to_axis` and of `Flow::axis_to_turning` in [`super`].
#[inline(always)]
fn lower_half(lanes: &Scaled, strips: u32) -> Reached {
    let (mut energy, mut s) = ([1.0; LANES], [-1.0; LANES]);
    for i in 1..=strips {
        let tau = f64::from(i) / f64::from(strips);
        let next = -(1.0 - tau * tau);
        let d = lanes.divergence(&s);
        for lane in 0..LANES {
            energy[lane] = approach(energy[lane], s[lane], next, d[lane]);
            s[lane] = next;
        }
    }
    let scale: Lanes = std::array::from_fn(|lane| energy[lane].sqrt());
    let mut on = [true; LANES];
    for i in 1..strips {
        let tau = f64::from(strips - i) / f64::from(strips);
        let d = lanes.divergence(&s);
        for lane in 0..LANES {
            let next = scale[lane] * (1.0 - tau * tau);
            let kick = d[lane] * (next - s[lane]);
            let m = if d[lane] >= 0.0 { 0.5 * (s[lane] + next) } else { next };
            let gap = energy[lane] - m * m;
            let reach = if d[lane] >= 0.0 { kick * kick + gap } else { gap };
            // The lane of an orbit that turns before the strip's end stops here.
            on[lane] &= !(reach < 0.0);
            let after = exit_energy(kick, gap, m);
            energy[lane] = if on[lane] { after } else { energy[lane] };
            s[lane] = if on[lane] { next } else { s[lane] };
        }
    }
    Reached { energy, s }
}
