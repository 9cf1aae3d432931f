//! One quarter of a closed orbit: the law that it follows, and where it starts.

use crate::dop853::STAGES;
use slipmap_model::corners::{LEAST_STEP, Layers};
use slipmap_model::friction::{Curve, ExponentialFall, Range, Weakening};
use slipmap_numbers::TimesPlus as _;

/// Rate of the polar angle by the law, from which on quarters are followed.
const STEEP: f64 = 0.6;
/// Share of that rate which is more than it, where sin and cos are those of a small angle: sin cos is less than the angle,
/// by at most a third at the angles of layers that are steep.
const CERTAINLY: f64 = 1.5;
/// Largest relative error of W where a quarter starts late, and the ratio of the slip speeds at which such a place is
/// sought.
const BALANCED: f64 = 0.1;
const SAMPLES_RATIO: f64 = 0.84;
/// Largest such ratio. Smaller ratios of the brakings at two such places, and a smaller effect of braking between them,
/// tell nothing new: a quarter that is braked by exp(-2) at most forgets its start no sooner than it is followed anyway. Of
/// 600 random falls of widths from 1e-7 to 0.1 next to rest, this from 0.84 to 0.999999 and the second from 1 to 16 moved
/// no c* beyond its error, and the work by a tenth at most, but for the second at 1: by up to 29 %. Of 200 random falls
/// away from rest, 11 of c* were off beyond their errors where this was 0.84, and none from 0.9999 on.
const FINEST_RATIO: f64 = 0.9999;
const BRAKED: f64 = 2.0;
/// Braking in the second half of a quarter from which on it may start there, and the latest such start, as a share of the
/// way. Steps that follow a creeping quarter are as many as the square of its braking: of 18,000 orbits over steep steps
/// four closed no more within the budget, and on plateaus of canards one took ten times as long.
const STIFF: f64 = 4.0;
const LATEST: f64 = 1e-3;
/// First step, in units of the width of the layer in q.
const FIRST_STEP: f64 = 0.2;
/// Share of the tolerance for the local error estimate of one step.
pub(super) const SHARE: f64 = 0.04;

/// The weakening rate.
#[derive(Clone, Copy)]
pub(super) enum Rate<'a> {
    Exponential(ExponentialFall),
    Law(&'a Curve),
    Polynomials(&'a Weakening),
}

impl Rate<'_> {
    #[inline(always)]
    pub(super) fn at(&self, u: f64) -> f64 {
        match self {
            Rate::Exponential(fall) => fall.at(u),
            Rate::Law(curve) => curve.weakening(u),
            Rate::Polynomials(weakening) => weakening.at(u),
        }
    }

    /// Bounds over slip speeds.
    fn range(&self, lo: f64, hi: f64) -> Range {
        match self {
            Rate::Exponential(fall) => fall.range(lo, hi),
            Rate::Law(curve) => curve.weakening_range(lo, hi),
            Rate::Polynomials(weakening) => weakening.range(lo, hi),
        }
    }
}

/// The least slip speed beyond `least` = V - `radius`, to a factor of two, at which |w sin cos| of the polar angle comes near
/// 1: where the layer begins that is too steep for the polar form of the orbit through the maximum `radius` of x2.
/// `None` where the law is not too steep.
pub(super) fn layer(curve: &Curve, belt_speed: f64, radius: f64) -> Option<f64> {
    let least = belt_speed - radius;
    let size = |range: Range| range.hi.abs().max(range.lo.abs());
    // Where a rate this large is too steep, if it is so from `from` on.
    let steep_from = |from: f64, rate: f64| {
        let beyond = from.max(0.5 * radius * (CERTAINLY * STEEP / rate).powi(2));
        let v = radius - beyond;
        let sin_cos = (beyond * (radius + v)).sqrt() * v / (radius * radius);
        (v > 0.0 && rate * sin_cos > STEEP).then_some(beyond)
    };
    if curve.has_closed_form() {
        let first = steep_from(0.0, size(curve.weakening_range(least, belt_speed)))?;
        let octaves = std::iter::successors(Some(first), |beyond| Some(2.0 * beyond));
        let mut octaves = octaves.take_while(|beyond| *beyond < radius);
        return octaves.find_map(|beyond| {
            let range = curve.weakening_range(least + beyond, least + 2.0 * beyond);
            steep_from(beyond, size(range)).filter(|from| *from < 2.0 * beyond)
        });
    }
    let weakening = curve.compiled(4.0 * belt_speed);
    weakening.sizes().find_map(|([from, to], rate)| {
        steep_from((from - least).max(0.0), rate).filter(|beyond| *beyond < to - least)
    })
}

/// Where a quarter starts.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub(super) q: f64,
    pub(super) h: f64,
    pub(super) by_damping: f64,
    /// Error of h.
    pub(super) error: f64,
    /// Length of the first step.
    pub(super) step: f64,
}

/// A quarter to be followed to x2 = 0.
#[derive(Clone, Copy)]
pub(super) struct Quarter<'a> {
    pub(super) rate: Rate<'a>,
    pub(super) stops: &'a [f64],
    pub(super) layers: &'a Layers,
    /// |x2| at the start.
    pub(super) radius: f64,
    /// The slip speed at the start, and 1 where it rises from there, -1 where it falls.
    pub(super) slip: f64,
    pub(super) toward: f64,
    /// |x2'| at the start.
    pub(super) speed: f64,
    /// See [`layer`]; `radius` where the law is not steep.
    pub(super) layer: f64,
    pub(super) viscous: f64,
    /// 1 forward in time, -1 backward.
    pub(super) sign: f64,
    /// Error allowed of h at the end.
    pub(super) allowed: f64,
    /// Largest number of trial steps.
    pub(super) most_steps: u32,
}

impl Quarter<'_> {
    /// Bounds of the weakening rate between two distances from the start.
    fn range(&self, from: f64, to: f64) -> Range {
        let [one, other] = [from, to].map(|beyond| self.toward.times_plus(beyond, self.slip));
        self.rate.range(one.min(other), one.max(other))
    }

    /// The longest step from this angle that passes over no piece of the law.
    pub(super) fn longest(&self, angle: f64) -> f64 {
        let half = (0.5 * angle).sin();
        let beyond = 2.0 * self.radius * half * half;
        let [low, high] = self.layers.around(self.toward.times_plus(beyond, self.slip));
        let way = if self.toward > 0.0 { high - self.slip } else { self.slip - low };
        let to = 2.0 * (0.5 * way / self.radius).min(1.0).sqrt().asin();
        (to - angle).max(LEAST_STEP * angle)
    }

    /// Whether the quarter with W = `speed` at this angle creeps up to the equilibrium: where -s D is at least 2 on the rest of
    /// the way, a - m, W stays below that once it is.
    pub(super) fn creeps_to_rest(&self, angle: f64, speed: f64) -> bool {
        let rest = self.radius * angle.cos();
        let Range { lo, hi } = self.range(self.radius - rest, self.radius);
        let least = if self.sign > 0.0 { self.viscous - hi } else { lo - self.viscous };
        speed <= rest && least >= 2.0
    }

    /// The start, with the number of evaluations.
    pub(super) fn start(&self) -> (Start, u64) {
        let Self { rate, radius, slip, toward, speed, layer, viscous, sign, allowed, .. } = *self;
        let braking = |beyond: f64| -sign * (rate.at(toward.times_plus(beyond, slip)) - viscous);
        // A drop is felt until W by the spring, (2 radius)^(1/2) q, exceeds it.
        let of_drop = if speed > 0.0 { speed / (2.0 * radius).sqrt() } else { f64::INFINITY };
        let step = FIRST_STEP * layer.sqrt().min(of_drop);
        let immediate = Start { q: 0.0, h: 0.5 * speed * speed, by_damping: 0.0, error: 0.0, step };
        // The most braking between two places.
        let most = |from: f64, to: f64| {
            let Range { lo, hi } = self.range(from, to);
            if sign > 0.0 { viscous - lo } else { hi - viscous }
        };
        let is_stiff = most(0.5 * radius, radius) > STIFF;
        if speed > 0.0 || !is_stiff && most(layer.min(0.5 * radius), 0.5 * radius) <= BRAKED {
            return (immediate, 2);
        }
        // W by the balance of braking and spring, from the end, or from the middle where braking beyond it costs little,
        // towards the start, and its change by u.
        let (mut beyond, mut forgotten) =
            (if is_stiff { (1.0 - LATEST) * radius } else { 0.5 * radius }, 0.0);
        let nearer = |beyond: f64, ratio: f64| match radius - beyond {
            rest if rest < beyond => (radius - rest / ratio).max(0.5 * radius),
            _ => ratio * beyond,
        };
        let (mut farther, mut change, mut before) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
        let (mut rhs, mut ratio, mut width) = (0, SAMPLES_RATIO, 0.0);
        // Whether a step would forget much more than the braking `here` at its beginning tells.
        let is_hidden = |from: f64, to: f64, here: f64| {
            let most = most(from, to);
            let forgotten = most * most / (radius - from) * (to - from);
            most > BRAKED * here && forgotten > BRAKED && most.is_finite()
        };
        // No quarter is faster than one that is driven by at most the largest rate.
        let highest = |beyond: f64| {
            let Range { lo, hi } = self.range(0.0, beyond);
            let driven = if sign > 0.0 { hi - viscous } else { viscous - lo };
            (beyond * (2.0 * radius - beyond)).sqrt() + beyond * driven.max(0.0)
        };
        // The start, if the quarter has come down to the balance there; W there and its relative error, the largest W of the
        // balance from there towards the start, and how far braking has slowed the quarter on the way.
        let mut late: Option<(Start, f64, f64)> = None;
        let (mut fastest, mut slowed, mut braking_before) = (0.0_f64, 0.0, 0.0_f64);
        // A search that takes as much as following it is not worth while.
        let most_samples = u64::from(self.most_steps) * STAGES as u64;
        while beyond > layer && rhs < most_samples {
            let here = braking(beyond);
            rhs += 1;
            let speed = if here > 0.0 { (radius - beyond) / here } else { f64::INFINITY };
            if let Some((start, balance, off)) = late {
                if speed.is_infinite() {
                    // Driven on the way, the quarter does not come down to the balance.
                    break;
                }
                slowed += here.min(braking_before) * width;
                fastest = fastest.max(speed);
                // An excess over the balance falls by the braking until it is of the order of W, then exponentially.
                let excess = highest(beyond);
                if slowed > excess + fastest * (1.0 + (excess / balance).max(1.0).ln() - off.ln()) {
                    return (start, rhs);
                }
            }
            let stiffness = (radius - beyond) / (speed * speed);
            // Both fall exponentially where the law does.
            let rise = stiffness / before;
            let mean = if rise > 2.0 { (stiffness - before) / rise.ln() } else { stiffness.min(before) };
            forgotten += mean * width;
            // Where the balance turns its change vanishes, and the error does not: the larger change of two steps counts.
            let changes = [(farther - speed).abs() / (width * here), change];
            change = changes[0];
            let off = f64::max(changes[0], changes[1]);
            let error = speed * speed * off;
            if late.is_none() && off < BALANCED && error < SHARE * allowed * f64::exp(forgotten) {
                let h = 0.5 * speed.times_plus(speed, -beyond * (2.0 * radius - beyond));
                let (q, by_damping) = (beyond.sqrt(), -sign * speed * speed / here);
                let error = error + f64::EPSILON * radius * radius;
                let start = Start { q, h, by_damping, error, step: 0.5 / (stiffness * q) };
                (late, fastest) = (Some((start, speed, off.max(f64::EPSILON))), speed);
            }
            (farther, before, braking_before) = (speed, stiffness, here);
            // Steps are short where a law begins to brake, or would be passed over.
            ratio = (ratio * ratio).max(SAMPLES_RATIO);
            let is_known = matches!(rate, Rate::Exponential(fall) if !fall.is_squared);
            while !is_known && ratio < FINEST_RATIO && is_hidden(nearer(beyond, ratio), beyond, here) {
                ratio = ratio.sqrt();
            }
            let next = nearer(beyond, ratio);
            width = beyond - next;
            beyond = next;
        }
        (immediate, rhs)
    }
}
