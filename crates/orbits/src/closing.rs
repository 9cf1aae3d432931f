//! The damping at which the orbit of an amplitude closes: by `circle` for Stribeck's law, by
//! [`super::elements`] for all others; or else from its [`super::quarters`].

use super::circle::{Start, spectral};
use super::elements::closed_orbit;
use super::polar::Closing;
use super::quarters::{Sought, closing_dampings_by_quarters};
use super::work::Work;
use slipmap_model::filippov::HopfRate;
use slipmap_model::friction::{Curve, Stribeck};
use slipmap_model::point::ScaledGroups;
use slipmap_numbers::TimesPlus as _;

/// An orbit: its curve, the belt speed V and its maximum r of x2, 0 < r <= V.
#[derive(Clone, Copy, Debug)]
pub struct Amplitude<'a> {
    /// The friction curve.
    pub curve: &'a Curve,
    /// V.
    pub belt_speed: f64,
    /// r.
    pub radius: f64,
    /// Estimate of the C at which it closes, where one is known.
    pub guess: Option<f64>,
    /// The quota that it draws on, with others or alone.
    pub work: &'a Work,
}

impl<'a> Amplitude<'a> {
    /// The orbit, without an estimate.
    pub fn new(curve: &'a Curve, belt_speed: f64, radius: f64, work: &'a Work) -> Self {
        Self { curve, belt_speed, radius, guess: None, work }
    }
}

/// The C at which orbits close, with errors of about `tolerance` in units of the weakening rate; `Err` with
/// the number of evaluations where the polar form does not apply, or the quota is spent.
pub fn closing_dampings(orbits: &[Amplitude], tolerance: f64) -> Vec<Result<Closing, u64>> {
    let of_circle = |&Amplitude { curve, belt_speed, radius, .. }: &Amplitude| {
        Some(of_stribeck(curve.stribeck()?, belt_speed, radius))
    };
    let (starts, constants): (Vec<Start>, Vec<f64>) = orbits.iter().filter_map(of_circle).unzip();
    let mut stribeck = spectral(&starts, tolerance)
        .into_iter()
        .zip(constants)
        .map(|(found, constant)| found.map(|found| Closing { viscous: found.viscous - constant, ..found }));
    let by_law = |&Amplitude { curve, belt_speed, radius, work, .. }: &Amplitude| {
        let weakening = if work.left() > 0 { curve.compiled(4.0 * belt_speed) } else { return Err(0) };
        closed_orbit(&weakening, belt_speed, radius, tolerance).map(|orbit| orbit.closing)
    };
    let answer = |orbit: &Amplitude| {
        let found = match orbit.curve.stribeck() {
            Some(_) => stribeck.next().unwrap_or(Err(0)),
            None => by_law(orbit),
        };
        let (Ok(Closing { rhs, .. }) | Err(rhs)) = found;
        orbit.work.spend_compiled(rhs).map_err(|_| rhs)?;
        found.or_else(|rhs| of_flat(orbit.curve, orbit.belt_speed, rhs).ok_or(rhs))
    };
    let mut found: Vec<Result<Closing, u64>> = orbits.iter().map(answer).collect();
    let left: Vec<usize> = (0..orbits.len()).filter(|&orbit| found[orbit].is_err()).collect();
    let sharing = |work: &Work| left.iter().filter(|&&orbit| std::ptr::eq(orbits[orbit].work, work)).count();
    let of = |&orbit: &usize| {
        let Amplitude { curve, belt_speed, radius, guess, work } = orbits[orbit];
        Sought::of_amplitude(curve, belt_speed, radius, guess, work).sharing(sharing(work))
    };
    let sought: Vec<Sought> = left.iter().map(of).collect();
    for (orbit, closing) in left.into_iter().zip(closing_dampings_by_quarters(&sought, tolerance)) {
        let (Ok(Closing { rhs: before, .. }) | Err(before)) = found[orbit];
        let closing = closing.map(|found| Closing { rhs: found.rhs + before, ..found });
        found[orbit] = closing.map_err(|rhs| rhs + before);
    }
    found
}

/// The C at which the orbits of flat friction close: between bounds of the even part that differ by rounding alone.
fn of_flat(curve: &Curve, belt_speed: f64, rhs: u64) -> Option<Closing> {
    let bounds = curve.even_weakening_range(belt_speed);
    let error = 0.5 * (bounds.hi - bounds.lo);
    let rounding = HopfRate::new(curve, belt_speed).rounding();
    (error <= rounding).then_some(Closing { viscous: bounds.lo + error, error, rhs, slope: None })
}

/// The start of an orbit of Stribeck's law, as a grazing orbit of another: with v = r R cos th, rho = r / V
/// and s = 1 - rho R cos th, 1 + k s = (1 + k (1 - rho)) (1 + k' (1 - R cos th)), k' = k rho / (1 + k (1 -
/// rho)). In units of its amplitude the orbit is a grazing one with A' = A / (1 + k (1 - rho))^2, b' = b rho
/// and C' = C + 2 b (1 - rho). The first C is the energy balance. The second result is C' - C.
fn of_stribeck(law: &Stribeck, belt_speed: f64, radius: f64) -> (Start, f64) {
    let ScaledGroups { a, k, b, .. } = law.scaled(belt_speed, 0.0);
    let (rho, rest) = (radius / belt_speed, (belt_speed - radius) / belt_speed);
    let slowest = k.times_plus(rest, 1.0);
    let groups = ScaledGroups { a: a / (slowest * slowest), k: k * rho / slowest, b: b * rho, c: 0.0 };
    let q = (1.0 + 2.0 * groups.k).sqrt();
    let c = 2.0 * groups.a / (q * (1.0 + groups.k + q)) - 2.0 * groups.b;
    let unit = groups.a.max(groups.b).max(f64::MIN_POSITIVE);
    (Start { groups: ScaledGroups { c, ..groups }, unit }, 2.0 * b * rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::Closed;
    use slipmap_model::friction::{Expression, Law, Table};
    use slipmap_model::point::LawParameters;
    use slipmap_numbers::random::Random;

    /// Friction that falls, measured with errors at uneven distances.
    fn rough_table(random: &mut Random) -> Law {
        let mut data = vec![(0.0, 1.0)];
        while data[data.len() - 1].0 < 8.0 {
            let u = data[data.len() - 1].0 + 0.1 + random.unit();
            data.push((u, 0.4 + 0.6 * (-u).exp() + 0.05 * random.unit()));
        }
        Law::Table(Table::new("test", &data, 1.0).unwrap())
    }

    /// Orbits of rough tables, whose corners lie where they may be met by chance: answers of every tolerance
    /// hold within their errors, which are no larger than the tolerance.
    #[test]
    fn errors_hold_where_a_law_has_corners() {
        let mut random = Random(93);
        let mut answered = 0;
        for _ in 0..60 {
            let curve = rough_table(&mut random).curve(1.0, &LawParameters::new(&[]));
            for _ in 0..20 {
                let belt_speed = 0.05 * 50_f64.powf(random.unit());
                let radius = belt_speed * random.unit().max(0.01);
                let weakening = curve.compiled(4.0 * belt_speed);
                let rates = weakening.range(belt_speed - radius, belt_speed + radius);
                let largest = rates.hi.abs().max(rates.lo.abs());
                let closing = |tolerance| closed_orbit(&weakening, belt_speed, radius, tolerance);
                let Ok(Closed { closing: exact, .. }) = closing(1e-12) else { continue };
                for tolerance in [1e-5, 1e-6, 1e-8] {
                    let Ok(Closed { closing: found, .. }) = closing(tolerance) else { continue };
                    let apart = (found.viscous - exact.viscous).abs();
                    assert!(
                        apart <= found.error + exact.error,
                        "{curve:?} {belt_speed} {radius} {tolerance}: {found:?} {exact:?}"
                    );
                    // Of the elements and of the law's polynomials at most the tolerance each; the rest is far less.
                    let most = 2.2 * tolerance * largest;
                    assert!(
                        found.error <= most,
                        "{curve:?} {belt_speed} {radius} {tolerance}: {found:?} {most}"
                    );
                    answered += 1;
                }
            }
        }
        assert!(answered > 3_000, "{answered}");
    }

    /// The slopes of the backbone that come with closed orbits are those of differences, within their errors.
    #[test]
    fn slopes_hold_within_their_errors() {
        let mut random = Random(94);
        let mut answered = [0; 2];
        for number in 0..120 {
            let law = if number % 2 == 0 {
                rough_table(&mut random)
            } else {
                let [drop, rate, waves] = [random.unit(), 0.4 + random.unit(), 1.0 + 3.0 * random.unit()];
                let text = format!("1 - {drop} + {drop}/(1 + (u/{rate})^2) + 0.05*sin({waves}*u)");
                Law::Expression(Expression::new(&text, 1.0).unwrap())
            };
            let curve = law.curve(1.0, &LawParameters::new(&[]));
            for _ in 0..10 {
                let belt_speed = 0.05 * 50_f64.powf(random.unit());
                let radius = 0.98 * belt_speed * random.unit().max(0.01);
                let weakening = curve.compiled(4.0 * belt_speed);
                let closing = |radius, tolerance| closed_orbit(&weakening, belt_speed, radius, tolerance);
                let step: f64 = 1e-4;
                let [Ok(above), Ok(below)] =
                    [step, -step].map(|step| closing(radius * step.exp(), 1e-12).map(|orbit| orbit.closing))
                else {
                    continue;
                };
                let difference = (above.viscous - below.viscous) / (2.0 * step);
                // C has a third derivative, but next to corners.
                let allowed = (above.error + below.error) / step + 10.0 * step * step;
                for tolerance in [1e-5, 1e-8] {
                    let Ok(Closed { closing: found, .. }) = closing(radius, tolerance) else { continue };
                    let [slope, error] = found.slope.unwrap();
                    assert!(
                        (slope - difference).abs() <= error + allowed,
                        "{number} {belt_speed} {radius} {tolerance}: {slope} {error} {difference}"
                    );
                    answered[number % 2] += usize::from(error < 1e-2 * slope.abs());
                }
            }
        }
        assert!(answered.into_iter().all(|answered| answered > 800), "{answered:?}");
    }
}
