//! Compares the bounds of compiled laws with the laws in interval arithmetic and with samples.

use super::*;
use crate::friction::*;
use crate::point::LawParameters;
use slipmap_numbers::interval::Interval;
use std::sync::Arc;

fn formula(text: &str) -> Curve {
    Law::Expression(Expression::new(text, 1.0).unwrap()).curve(0.7, &LawParameters::new(&[]))
}

/// A formula whose slip speed is in units of `unit`, divided by 0.4.
fn formula_in_units(text: &str, unit: f64) -> Curve {
    let law = Law::Expression(Expression::new(text, 1.0).unwrap().in_units(unit, 0.4));
    law.curve(1.0, &LawParameters::new(&[]))
}

fn table() -> Curve {
    let data = [(0.0, 1.0), (0.1, 0.8), (0.3, 0.65), (0.6, 0.6), (1.0, 0.62), (2.0, 0.7), (8.0, 0.9)];
    Law::Table(Table::new("falling", &data, 1.0).unwrap()).curve(1.0, &LawParameters::new(&[]))
}

fn smooth() -> Vec<Curve> {
    let built_in = |law: Law, parameters: &[f64]| law.curve(0.7, &LawParameters::new(parameters));
    vec![
        built_in(Law::Stribeck, &[0.3, 0.05, 8.0]),
        built_in(Law::Exponential, &[0.4, 0.05, 0.02]),
        built_in(Law::Stretched, &[0.4, 0.3, 0.02, 2.0]),
        built_in(Law::Stretched, &[0.4, 0.3, 0.02, 7.0]),
        built_in(Law::Lorentzian, &[0.1, 0.3, 0.0]),
        formula("1/(1 + 3*u)"),
        formula("0.3 + 0.7*exp(-2*u) + 0.05*eps*u^2"),
        formula("1 - 0.1*u + 0.02*sin(7*u)"),
        formula("0.4 + 0.6/cosh(5*u) + 0.01*atan(u/0.03)"),
        formula("1 - 0.2*tanh(30*u)*(1 - 0.3*exp(-u)) + 0.01*sqrt(u + 0.2) - 0.01*sqrt(0.2)"),
        formula_in_units("0.1 + 0.3*exp(-2*u) + 0.05*u^2", 0.37),
        formula_in_units("0.4 - 0.1*u + 0.02*sin(u)", 3.1),
        formula_in_units("0.3 + 0.1/cosh(50*u) + 0.01*atan(u/0.003)", 0.0123),
    ]
}

/// Slip speeds spread over [0, reach], dense next to 0.
fn slips(reach: f64) -> impl Iterator<Item = f64> {
    (0..=4000).map(move |i| reach * (f64::from(i) / 4000.0).powi(3))
}

#[test]
fn the_slip_speed_minus_zero_is_zero() {
    for curve in smooth().into_iter().chain([table()]) {
        let compiled = curve.compiled(3.0);
        assert_eq!(compiled.at(-0.0), compiled.at(0.0));
    }
}

/// What steps and proofs take of the pieces is what the whole answers.
#[test]
fn pieces_join_and_their_polynomials_are_the_answers() {
    for curve in smooth().into_iter().chain([table()]) {
        let compiled = curve.compiled(3.0);
        let proved: Vec<ProvedPiece> = compiled.proved_pieces(0.0, compiled.reach()).collect();
        let ends: Vec<f64> = proved.iter().map(|piece| piece.ends[1]).collect();
        assert!(
            ends == compiled.breaks()[1..] && proved[1..].iter().all(|piece| ends.contains(&piece.ends[0]))
        );
        for &u in &ends {
            let u = 0.99 * u;
            let Polynomial { middle, scale, c } = compiled.polynomial(compiled.piece_of(u));
            let value = c.iter().rev().fold(0.0, |sum, c| sum * (u - middle) * scale + c);
            let size: f64 = c.iter().map(|c| c.abs()).sum();
            assert!((value - compiled.at(u)).abs() <= 64.0 * f64::EPSILON * size, "{u}");
        }
        let slope = |piece: usize, u: f64| compiled.pieces[piece].slope_at(u);
        for (piece, &end) in ends[..ends.len() - 1].iter().enumerate() {
            let (before, after) = (slope(piece, end), slope(piece + 1, end));
            let jump = if curve.corners().is_empty() { 0.0 } else { compiled.jump(piece + 1) };
            let size = before.abs() + after.abs();
            assert!(((before - after).abs() - jump).abs() <= 1e-9 * size.max(1.0), "{end}");
        }
    }
}

#[test]
fn friction_that_pushes_is_not_proved_to_resist() {
    assert!(formula("0.3 + 0.7*exp(-2*u)").is_proved_to_resist());
    assert!(!formula("1 - 0.3*u").is_proved_to_resist());
}

#[test]
fn a_law_with_more_waves_than_pieces_is_not_resolved() {
    for curve in smooth().into_iter().chain([table(), formula("1 - 0.1*sin(100*u)")]) {
        assert!(curve.compiled(3.0).is_resolved(0.0, 3.0), "{curve:?}");
    }
    for waves in ["1e8", "1e200"] {
        assert!(!formula(&format!("1 - 0.1*sin({waves}*u)")).compiled(3.0).is_resolved(1.0, 2.0), "{waves}");
    }
}

#[test]
fn laws_below_the_normal_numbers_are_not_cut_in_vain() {
    for (text, reach) in
        [("1 - sin(6.9e-317*u)", 1.8e-83), ("1 - u*exp(-u)", 3e-305), ("1 - 1e-310*tanh(u)", 3.0)]
    {
        let compiled = formula(text).compiled(reach);
        assert!(compiled.breaks().len() <= 32, "{text}: {} pieces", compiled.breaks().len());
    }
}

/// Next to 0 the weakening of this law is so small that its values have few digits.
#[test]
fn a_law_that_is_flat_before_it_falls_is_resolved() {
    for (at, reach) in [(0.3, 3.0), (0.5, 3.0), (0.59, 3.7), (0.9, 2.6), (0.94, 3.1)] {
        let curve = formula(&format!("1 - 0.2*(tanh((u - {at})/0.02) + tanh({at}/0.02))"));
        let compiled = curve.compiled(reach);
        assert!(compiled.breaks().len() <= 512, "{at}: {} pieces", compiled.breaks().len());
        let error = compiled.error(0.0, reach);
        assert!(matches!(error, Accuracy::Proved(error) if error <= 1e-12), "{at}: {error:?}");
        for u in slips(reach) {
            assert!((compiled.at(u) - curve.weakening(u)).abs() <= 2e-12, "{at} {u}");
        }
    }
}

#[test]
fn errors_hold_and_are_small() {
    for curve in smooth().into_iter().chain([table()]) {
        let compiled = curve.compiled(3.0);
        let reach = compiled.reach();
        let largest = slips(reach).map(|u| curve.weakening(u).abs()).fold(0.0, f64::max);
        let Accuracy::Proved(worst) = compiled.error(0.0, reach) else {
            panic!("nothing proved of {curve:?}");
        };
        assert!(worst <= 1e-13 * largest, "{worst} of {largest}: {curve:?}");
        for u in slips(reach) {
            // Where there is no formula, the law is a parabola with a few roundings.
            let exact = curve.form.series::<2>(Interval::of(u), 1.0).map_or_else(
                || Interval::new(curve.weakening(u) - 1e-14 * largest, curve.weakening(u) + 1e-14 * largest),
                |phi| -phi.0[1],
            );
            let (found, error) = (compiled.at(u), compiled.error(u, u).bound());
            assert!(exact.lo - error <= found && found <= exact.hi + error, "{u}: {exact:?} {found} {error}");
            let slope = compiled.slope(u);
            let near = 1e-6 * (u + 1e-3);
            let difference = (curve.weakening(u + near) - curve.weakening(u)) / near;
            let at_corner = curve.corners().iter().any(|corner| (u..=u + near).contains(corner));
            // The curvature of these laws is below 1e4.
            assert!(
                u >= reach - near || at_corner || (slope - difference).abs() <= 1e4 * near,
                "{u}: {slope}"
            );
        }
    }
}

#[test]
fn outside_the_reach_the_law_answers_itself() {
    let curve = formula("1/(1 + 3*u)");
    let compiled = curve.compiled(1.0);
    for u in [-0.1, 2.5, 1e9] {
        assert_eq!(compiled.at(u), curve.weakening(u));
    }
    assert_eq!(compiled.range(0.0, 3.0).hi, f64::INFINITY);
    let longer = curve.compiled(50.0);
    assert!(longer.reach() >= 50.0);
    assert!(Arc::ptr_eq(&longer, &curve.clone().compiled(60.0)), "clones share what is compiled");
    let beyond = table().compiled(100.0);
    assert_eq!(beyond.reach(), 8.0);
    assert!(beyond.at(8.1).is_nan());
}

/// Searches for limits in eps, maps with an axis of eps, and maps and draws of a machine with a formula would otherwise
/// compile the same law again.
#[test]
fn curves_of_other_eps_or_unit_share_what_is_compiled() {
    let forms = |law: &Law, parameters: &[f64]| {
        [0.1, 0.2].map(|epsilon| law.curve(epsilon, &LawParameters::new(parameters)).compiled(1.0))
    };
    let formula = |text: &str| Law::Expression(Expression::new(text, 1.0).unwrap());
    let [a, b] = forms(&formula("1 - 0.3*u*exp(-u)"), &[]);
    assert!(Arc::ptr_eq(&a, &b));
    let [a, b] = forms(&Law::Lorentzian, &[0.5, 0.2, 0.01]);
    assert!(Arc::ptr_eq(&a, &b));
    let [a, b] = [0.3, 0.7].map(|unit| {
        let curve = formula_in_units("0.4 - 0.3*u*exp(-u)", unit);
        let _ = curve.compiled(1.0);
        Arc::clone(&curve.compiled.lock().unwrap().written)
    });
    assert!(Arc::ptr_eq(&a, &b) && !a.lock().unwrap().is_empty());
    let [a, b] = forms(&formula("1 - eps*u*exp(-u)"), &[]);
    assert_ne!(a.at(0.5), b.at(0.5));
}

/// Maps are equal for any number of threads only if it does not matter what a thread compiled before.
#[test]
fn a_compiled_law_does_not_depend_on_what_was_compiled_before() {
    let text = "1 - 0.3*u*exp(-u) + 0.05*sin(7*u)";
    let (short_first, long_first) = (formula(text), formula(text));
    let (a, b) = (short_first.compiled(0.7), short_first.compiled(40.0));
    let (c, d) = (long_first.compiled(40.0), long_first.compiled(0.7));
    assert!(a.breaks() == d.breaks() && b.breaks() == c.breaks());
    // Beginnings of the longest, and forms between two others.
    for reach in [0.01, 0.2, 1.5, 3.0, 7.0, 20.0] {
        let (alone, within) = (formula(text).compiled(reach), long_first.compiled(reach));
        assert_eq!(alone.breaks(), within.breaks(), "{reach}");
        assert_eq!(format!("{:?}", alone.pieces), format!("{:?}", within.pieces), "{reach}");
    }
    for i in 0..400 {
        let u = 0.1 * f64::from(i);
        assert_eq!(a.at(u).to_bits(), d.at(u).to_bits(), "{u}");
        assert_eq!(b.at(u).to_bits(), c.at(u).to_bits(), "{u}");
    }
}

/// Extreme belt speeds ask one law for hundreds of lengths, each of up to a megabyte.
#[test]
fn few_compiled_forms_of_a_law_are_kept() {
    let Curve { form, .. } = formula("1 - 0.1*sin(300*u)");
    let mut known = Vec::new();
    for exponent in 0..40 {
        compile(&form, 2_f64.powi(exponent), &mut known);
    }
    let pieces: usize = known.iter().map(|form| form.pieces.len()).sum();
    assert!(known.len() < 40 && pieces <= 17 * 4096, "{} {pieces}", known.len());
}

/// Least and greatest of f on a fine grid of [lo, hi].
fn sampled(f: impl Fn(f64) -> f64, lo: f64, hi: f64) -> Range {
    let values = (0..=20_000).map(|i| f(lo + (hi - lo) * f64::from(i) / 20_000.0));
    let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    Range { lo, hi }
}

#[test]
fn ranges_hold_at_samples_and_are_met() {
    let check = |found: Range, samples: Range, miss: f64, place: &dyn std::fmt::Debug| {
        let low = found.lo <= samples.lo + 1e-13 && samples.lo - found.lo <= miss;
        let high = found.hi >= samples.hi - 1e-13 && found.hi - samples.hi <= miss;
        assert!(low && high, "{found:?} {samples:?} {place:?}");
    };
    for curve in smooth().into_iter().chain([table()]) {
        let compiled = curve.compiled(4.0);
        for (lo, hi) in [(0.0, 4.0), (0.05, 0.25), (0.2, 2.5), (0.7, 0.7), (0.0, 1e-3)] {
            let samples = sampled(|u| curve.weakening(u), lo, hi);
            // Samples miss an extreme by half the curvature, below 1e4, times the square of half their
            // distance.
            let miss = 2e3 * ((hi - lo) / 20_000.0).powi(2) + 1e-11;
            check(compiled.range(lo, hi), samples, miss, &(lo, hi, &curve));
        }
        for belt_speed in [0.05, 0.29, 1.1, 2.0] {
            for within in [belt_speed, 0.3 * belt_speed] {
                let even = |v: f64| 0.5 * (curve.weakening(belt_speed - v) + curve.weakening(belt_speed + v));
                let samples = sampled(even, 0.0, within);
                // At corners the slope, below 20, jumps.
                let spacing = within / 20_000.0;
                let kink = if curve.corners().is_empty() { 0.0 } else { 20.0 * spacing };
                let miss = 2e3 * spacing.powi(2) + kink + 1e-11;
                check(compiled.even_range(belt_speed, within), samples, miss, &(belt_speed, within, &curve));
            }
        }
    }
}

/// Next to rest a power that is not whole has no polynomial; it has one on all pieces but the first.
#[test]
fn powers_at_rest_are_resolved() {
    for exponent in [1.01, 1.5, 2.5] {
        let curve = Law::Stretched.curve(1.0, &LawParameters::new(&[0.4, 0.3, 0.02, exponent]));
        let compiled = curve.compiled(3.0);
        let Accuracy::Proved(worst) = compiled.error(0.0, 3.0) else { panic!("{exponent}") };
        assert!(worst < 1e-9 && compiled.is_resolved(0.0, 3.0), "{exponent}: {worst}");
        for u in slips(3.0).filter(|u| *u > compiled.breaks()[1]) {
            // A few roundings of logarithms up to 40.
            let missed = (compiled.at(u) - curve.weakening(u)).abs();
            assert!(missed <= 1e-12, "{exponent} {u}: {missed}");
        }
    }
}

#[test]
fn unresolved_laws_have_a_large_error() {
    // phi'' is infinite at 0: the piece there is never short enough.
    let curve = formula("1 - 0.1*u*sqrt(u + 1e-300)");
    let compiled = curve.compiled(1.0);
    let error = compiled.error(0.5, 1.0);
    assert!(matches!(error, Accuracy::Proved(error) if error < 1e-14), "{error:?}");
    assert!(compiled.breaks().len() < 400, "{}", compiled.breaks().len());
    // Too many waves for the budget: the last piece contains the rest.
    let compiled = formula("1 - 1e-9*sin(1e6*u)").compiled(1.0);
    assert!(compiled.error(0.0, 1e-4).bound() < 1e-15);
    assert!(compiled.error(0.0, 1.0).bound() > 1e-3);
    let range = compiled.range(0.0, 1.0);
    assert!(range.lo < -1e-3 && range.hi > 1e-3);
    // A law with a pole has no bounds.
    let compiled = formula("1 - 0.1*u/(0.3 - u)").compiled(1.0);
    assert!(matches!(compiled.error(0.0, 0.2), Accuracy::Proved(error) if error < 1e-12));
    assert!(matches!(compiled.error(0.0, 1.0), Accuracy::Sampled(_)));
    assert_eq!(compiled.range(0.0, 1.0), Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY });
}

#[test]
fn the_mean_is_a_bessel_function() {
    // (1/pi) integral of exp(-x + x cos t) sin^2 t = 2 exp(-x) I1(x) / x, and I1(1) = 0.565159103992485 from
    // its series.
    let exact = 2.0 * 0.565_159_103_992_485 / std::f64::consts::E;
    let law = Law::Exponential.curve(1.0, &LawParameters::new(&[0.0, 1.0, 0.0]));
    for curve in [law, formula("exp(-u)")] {
        assert!((curve.mean_weakening(1.0) - exact).abs() < 32.0 * f64::EPSILON);
    }
}

/// Falls narrower than any spacing of angles. The values are from quadrature with 40 digits between slip speeds in and
/// about the fall.
#[test]
fn the_mean_sees_narrow_falls() {
    let stretched = |parameters: [f64; 4]| Law::Stretched.curve(1.0, &LawParameters::new(&parameters));
    let lorentzian = Law::Lorentzian.curve(1.0, &LawParameters::new(&[0.5, 1e-4, 0.0]));
    for (curve, exact) in [
        (stretched([0.5, 1e-4, 0.001, 1.0]), 0.002_989_273_195_983_662),
        (stretched([0.5, 5e-4, 0.001, 2.0]), 0.008_122_548_022_515_742),
        (stretched([0.5, 1e-3, 0.001, 4.0]), 0.012_402_779_709_928_785),
        (stretched([0.5, 3e-3, 0.001, 10.0]), 0.022_985_634_016_803_66),
        (stretched([0.5, 1e-12, 0.0, 3.0]), 4.176_204_264_406_613e-7),
        (stretched([0.5, 1e-4, 0.0, 1.5]), 0.004_019_707_579_642_821),
        (stretched([0.5, 2.0, 0.0, 100.0]), 0.040_373_264_703_116_88),
        (lorentzian, 0.004_999_625_007_812_773),
        (formula("0.5 + 0.5*exp(-u/1e-4) + 0.001*u"), 0.002_989_273_195_983_662),
        (formula("0.5 + 0.5*exp(-(u/3e-3)^10) + 0.001*u"), 0.022_985_634_016_803_66),
        (formula("0.5 + 0.5*exp(-(u/1e-4)^1.5)"), 0.004_019_707_579_642_821),
        (formula("1 - 0.3*tanh(u) - 0.05*(tanh((u - 0.5)/0.001) + 1)"), 0.196_504_714_473_315_03),
        (formula("1 - 0.2*tanh(u) + 0.1*exp(-((u - 1.6)/0.005)^2)"), 0.093_824_748_597_753_34),
    ] {
        let [mean, error] = curve.mean_weakening_with_error(1.0);
        // Sums of some hundred terms of one sign, but for the bump, whose terms are 2,000 times its mean.
        assert!((mean - exact).abs() <= error + 16.0 * f64::EPSILON * exact, "{curve:?}: {mean} {exact}");
        assert!(error < 1e-12, "{error}");
    }
    // Thousands of waves in each piece: the mean, about 0, is not known.
    let [mean, error] = formula("1 - 0.001*sin(3e7*u)").mean_weakening_with_error(1.0);
    assert!(mean.abs() < error, "{mean} {error}");
}

#[test]
fn waves_of_a_short_belt_and_of_a_long_one() {
    // Belt speeds from one end of the range of doubles to the other.
    let curve = formula("0.4 + 0.6*exp(-u/1e-5)");
    for belt_speed in [1e-140, 1e-30, 1e-9, 1e-5, 1.0, 1e9] {
        let range = curve.even_weakening_range(belt_speed);
        let largest = 0.6e5 * 0.5 * (1.0 + (-2.0 * belt_speed / 1e-5).exp());
        assert!(
            range.hi >= largest * (1.0 - 1e-12) && range.hi <= largest * (1.0 + 1e-9),
            "{belt_speed}: {range:?}"
        );
    }
}

/// A kink that lies between the last sample of a piece and its end: the piece is halved until the kink is an end, and integrators
/// stop there.
#[test]
fn kinks_between_samples_are_found() {
    let law = Law::Expression(Expression::new("1 - 0.2*u + 0.1*(abs(u - 0.32808) - 0.32808)", 1.0).unwrap());
    let curve = law.curve(1.0, &LawParameters::new(&[]));
    let form = curve.compiled(4.0);
    let near = |places: &[f64]| places.iter().any(|place| (place - 0.32808).abs() < 1e-12);
    assert!(near(form.breaks()) && near(&curve.stops(1.0)), "{:?} {:?}", form.breaks(), curve.stops(1.0));
    for u in [0.3, 0.328, 0.328_07, 0.328_09, 0.3281, 0.33] {
        let w = if u < 0.32808 { 0.3 } else { 0.1 };
        assert!((form.at(u) - w).abs() < 1e-12, "{u} {}", form.at(u));
    }
}
