//! Reproducible points of the Stribeck law for the tests of the theory.

use slipmap::column;
use slipmap::column::slip_cycle::CyclesUnknown;
use slipmap::filippov::Oscillator;
use slipmap::flow::{Fate, Flow};
use slipmap::friction::{Column, Expression, Law};
use slipmap::orbits::{Cycle, flow};
use slipmap::point::{Point, ScaledGroups};
use slipmap::witness;
pub use slipmap_numbers::random::Random;

/// An engine that follows the orbit from the exit point.
pub type Follow = fn(&Oscillator, f64) -> Flow;

/// Both engines, by name.
pub const ENGINES: [(&str, Follow); 2] = [("arcs", flow), ("direct", witness::flow)];

/// Whether the orbit from the exit point comes back to the belt line; `None` where its fate does not tell.
pub fn returns(fate: &Fate) -> Option<bool> {
    match fate {
        Fate::Sticks(_) | Fate::CrossesForever => Some(true),
        Fate::SpiralsInward => Some(false),
        Fate::TooCloseToCall | Fate::Failed(_) => None,
    }
}

/// All slip cycles of an oscillator.
pub fn slip_cycles(oscillator: &Oscillator, tolerance: f64) -> Result<Vec<Cycle>, CyclesUnknown> {
    column::slip_cycles(oscillator, &flow(oscillator, 1e-9), tolerance)
}

/// A law by its formula, which is 1 at rest.
pub fn formula(text: &str) -> Law {
    Law::Expression(Expression::new(text, 1.0).unwrap())
}

/// The oscillator of a law at eps = 1.
pub fn at_one(law: &Law, parameters: &[f64], belt_speed: f64, damping: f64) -> Oscillator {
    Oscillator::new(law, &law.point(1.0, parameters, belt_speed, damping).unwrap())
}

/// The six parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub epsilon: f64,
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    pub belt_speed: f64,
    pub damping: f64,
}

impl Sample {
    pub fn point(&self) -> Point {
        let law = [self.alpha, self.beta, self.gamma];
        Law::Stribeck.point(self.epsilon, &law, self.belt_speed, self.damping).unwrap()
    }

    pub fn column(&self) -> Column {
        Law::Stribeck.column(&self.point())
    }

    pub fn oscillator(&self) -> Oscillator {
        Oscillator::new(&Law::Stribeck, &self.point())
    }

    pub fn at(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// An equivalent sample with the small parameter `l` times as large.
    pub fn rescaled(self, l: f64) -> Self {
        Self {
            epsilon: l * self.epsilon,
            beta: self.beta / l,
            gamma: self.gamma / l,
            damping: self.damping / l,
            ..self
        }
    }

    /// gamma (1 - alpha), the weakening at rest per unit eps.
    pub fn drop_rate(&self) -> f64 {
        self.gamma * (1.0 - self.alpha)
    }

    /// Edge of the first-order test, gamma (1 - alpha) - 2 beta V.
    pub fn first_order_edge(&self) -> f64 {
        self.drop_rate() - 2.0 * self.beta * self.belt_speed
    }

    /// Edge of the divergence test, gamma (1 - alpha)/(1 + k)^2 - 2 beta V.
    pub fn divergence_edge(&self) -> f64 {
        self.drop_rate() / (1.0 + self.k()).powi(2) - 2.0 * self.beta * self.belt_speed
    }

    /// Edge of the energy balance on the grazing circle.
    pub fn balance_edge(&self) -> f64 {
        let q = (1.0 + 2.0 * self.k()).sqrt();
        2.0 * self.drop_rate() / (q * (1.0 + self.k() + q)) - 2.0 * self.beta * self.belt_speed
    }

    /// k = eps gamma V.
    pub fn k(&self) -> f64 {
        self.epsilon * self.gamma * self.belt_speed
    }

    /// A, k, b, C.
    pub fn groups(&self) -> ScaledGroups {
        ScaledGroups {
            a: self.epsilon * self.drop_rate(),
            k: self.k(),
            b: self.epsilon * self.beta * self.belt_speed,
            c: self.epsilon * self.damping,
        }
    }
}

/// Random points.
pub trait Sampling {
    /// Between `lo` and `hi`, evenly.
    fn between(&mut self, lo: f64, hi: f64) -> f64;

    /// Between `lo` and `hi`, evenly over the decades.
    fn log(&mut self, lo: f64, hi: f64) -> f64;

    /// A point of the box eps in [1e-3, 1], V in [0.1, 10], alpha and beta in [0, 1], gamma in [0, 10], c in
    /// [0, 3]; often at a limit of the law.
    fn anywhere(&mut self) -> Sample;

    /// A point of the same box, with c within a factor 1 +- 10^-12 to 1 +- 1 of the energy balance: near the
    /// boundary, where methods fail.
    fn near_boundary(&mut self) -> Sample;
}

impl Sampling for Random {
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    fn log(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    fn anywhere(&mut self) -> Sample {
        let mut sample = Sample {
            epsilon: self.log(1e-3, 1.0),
            alpha: self.unit(),
            beta: self.unit(),
            gamma: 10.0 * self.unit(),
            belt_speed: self.log(0.1, 10.0),
            damping: 3.0 * self.unit(),
        };
        let mut limit = |value: &mut f64, limit| {
            if self.unit() < 0.08 {
                *value = limit;
            }
        };
        limit(&mut sample.alpha, 0.0);
        limit(&mut sample.alpha, 1.0);
        limit(&mut sample.beta, 0.0);
        limit(&mut sample.gamma, 0.0);
        limit(&mut sample.damping, 0.0);
        sample
    }

    fn near_boundary(&mut self) -> Sample {
        loop {
            let sample = self.anywhere();
            let side = if self.unit() < 0.5 { -1.0 } else { 1.0 };
            let damping = sample.balance_edge() * (1.0 + side * self.log(1e-12, 1.0));
            if damping > 0.0 {
                return sample.at(damping);
            }
        }
    }
}

/// A measured difference, its leading term, and the known corrections: the next term, relative to the leading
/// one, and a bound of the rest.
pub struct Expansion {
    pub epsilon: f64,
    pub measured: f64,
    pub leading: f64,
    pub next: f64,
    pub rest: f64,
}

/// The measured values follow the leading term with the relative deviation `next`, up to `rest`; so their
/// order along halvings of eps is that of the leading term, which tends to `order`.
pub fn check_order(name: &str, order: f64, halvings: &[Expansion]) {
    for e in halvings {
        let deviation = e.measured / e.leading - 1.0;
        println!(
            "{name}: eps {:.5}, ratio - 1 {deviation:+.3e}, next term {:+.3e} +- {:.1e}",
            e.epsilon, e.next, e.rest
        );
        assert!((deviation - e.next).abs() <= e.rest, "{name} at eps = {}", e.epsilon);
    }
    let mut last_order = f64::NAN;
    for pair in halvings.windows(2) {
        let measured = (pair[0].measured / pair[1].measured).log2();
        let leading = (pair[0].leading / pair[1].leading).log2();
        println!("{name}: measured order {measured:.4}, of the leading term {leading:.4}");
        let slack = |e: &Expansion| (e.next.abs() + e.rest) / (1.0 - e.next.abs() - e.rest);
        let slack = (slack(&pair[0]) + slack(&pair[1])) / std::f64::consts::LN_2;
        assert!((measured - leading).abs() <= slack, "{name}: order {measured} instead of {leading}");
        last_order = leading;
    }
    // The leading term is a power of eps only in the limit: the nearest integer identifies it.
    assert!((last_order - order).abs() < 0.5 && halvings.len() >= 4, "{name}: order {last_order}");
}
