//! A law given as a function of a Python program: sampled once and stored as piecewise polynomials.
//!
//! The distance of their weakening rate from that of the function is estimated by samples ([`Function::error`]), and nothing
//! is proved of it: a constant that is sampled falls somewhere, by rounding. So the law has no enclosures, and no theorem
//! uses it. By the comparison lemma of [`slipmap_certify`] an error delta of the weakening rate moves the critical damping by
//! at most delta / eps, which the error of the critical damping includes. Beyond the largest slip speed the law is
//! unknown: phi is NaN there, as for a table.

use std::sync::{Arc, LazyLock};

use slipmap_numbers::chebyshev::{points, sum, transform};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// Number of Chebyshev coefficients of phi on a piece.
const COUNT: usize = 16;
/// Tolerance of phi(0) = 1: values of a function have rounding errors.
const STATIC_SLACK: f64 = 1e-12;
/// Largest difference of two polynomials where they meet. The polynomials of [`Fitted`] differ by rounding
/// errors and, where a function is rough, by the errors of the shortest pieces.
const LARGEST_GAP: f64 = 1e-9;
/// A piece is short enough if the sum of its last two |coefficients| is at most this times the largest |phi|.
const SHARPNESS: f64 = 64.0 * f64::EPSILON;
/// Largest difference at other samples, in units of the largest |phi|: rounding of the function, and of its argument.
const LARGEST_MISS: f64 = 4.0 * SHARPNESS;
/// Largest number of pieces, and of bisections of a piece. A piece that is too long after these is accepted,
/// and the error includes it.
const MOST_PIECES: usize = 512;
const MOST_HALVINGS: u32 = 40;

/// Least number of samples on each piece, besides those of its polynomial, and on the whole range, that test it: multiples
/// of the golden ratio, which fall on new places as pieces are halved. A dip is seen where one of them falls into it.
const TESTS: f64 = 24.0;
const TESTS_IN_ALL: f64 = 4096.0;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Number of samples next to rest and to corners, each half as far from there as the one before: friction may fall next
/// to rest faster than anywhere else, and a corner may lie next to where it was said to be.
const NEXT_TO_ENDS: i32 = 40;
/// Step of slopes, in units of the length of a piece.
const STEP: f64 = 1e-5;

/// Reason why a function is not a friction law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{problem}\n  help: {remedy}")]
pub struct FunctionError {
    pub(crate) problem: String,
    pub(crate) remedy: String,
}

/// A law given as a function. Clones share its samples.
#[derive(Clone, Debug)]
pub struct Function(Arc<Pieces>);

#[derive(Debug, PartialEq)]
struct Pieces {
    origin: String,
    /// Ends of the pieces, the first 0.
    ends: Vec<f64>,
    corners: Vec<f64>,
    coefficients: Vec<[f64; COUNT]>,
    error: f64,
}

impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

/// The Chebyshev points in [-1, 1].
static POINTS: LazyLock<[f64; COUNT]> = LazyLock::new(points);
/// Chebyshev coefficient k of the polynomial through values at the points, as a sum of the values.
static TRANSFORM: LazyLock<[[f64; COUNT]; COUNT]> = LazyLock::new(transform);

impl Function {
    /// Samples `phi` once: the friction in units of the static friction at slip speeds from 0 to `fastest`.
    /// `corners` are slip speeds in between at which its slope may jump; elsewhere it should be smooth.
    /// `origin` is the name of the function.
    ///
    /// # Errors
    /// [`FunctionError`] if a value is not finite, phi(0) is not 1, or a corner is not in (0, `fastest`).
    pub fn new(
        origin: &str,
        mut phi: impl FnMut(f64) -> f64,
        fastest: f64,
        corners: &[f64],
    ) -> Result<Self, FunctionError> {
        let error_of = |problem: String, remedy: &str| Err(FunctionError { problem, remedy: remedy.into() });
        if !(fastest > 0.0 && fastest.is_finite()) {
            return error_of(
                format!("the largest slip speed is {fastest}"),
                "choose one greater than 0: at least twice the largest belt speed, better four times",
            );
        }
        let mut ends = vec![0.0];
        ends.extend(corners);
        ends.push(fastest);
        if ends.windows(2).any(|pair| !(pair[0] < pair[1])) {
            let remedy = "give growing slip speeds greater than 0 and below the largest";
            return error_of(format!("the corners {corners:?} do not lie between 0 and {fastest}"), remedy);
        }
        let at_rest = phi(0.0);
        if !((at_rest - 1.0).abs() <= STATIC_SLACK) {
            let remedy = match at_rest {
                0.0 => {
                    "friction vanishes at rest, a viscous contact: give that of the peak up to the peak, divided by it"
                }
                _ => {
                    "divide the function by its value at slip speed 0, if friction falls from there; if it drops from 1, add \
                     the drop to the function and give it as the parameter drop (with_drop)"
                }
            };
            return error_of(format!("phi(0) is {at_rest}, not 1"), remedy);
        }
        let mut bad = None;
        let mut checked = |u: f64| {
            let value = phi(u);
            if !value.is_finite() && bad.is_none() {
                bad = Some((u, value));
            }
            value
        };
        let fitted = Fitted::new(&mut checked, &ends);
        if let Some((u, value)) = bad {
            return error_of(
                format!("the friction at slip speed {u} is {value}"),
                "make it a finite number at all slip speeds up to the largest",
            );
        }
        let Fitted { ends, coefficients, error } = fitted;
        let (origin, corners) = (origin.to_owned(), corners.to_vec());
        let law = Self(Arc::new(Pieces { origin, ends, corners, coefficients, error }));
        let onset = law.phi(0.0);
        if (onset - 1.0).abs() > STATIC_SLACK {
            return error_of(
                format!("the friction at slip speed 0 is 1, and just above it is {onset}"),
                "make it continuous there, with a finite slope; if it drops as slip begins, add the drop to the function and \
                 give it as the parameter drop (with_drop); of values with errors make a table, or fit them",
            );
        }
        Ok(law)
    }

    /// The function's name.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.0.origin
    }

    /// The largest slip speed for which the law is known.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.0.ends[self.0.coefficients.len()]
    }

    /// Estimate, from samples, of the difference of this law's weakening rate and that of the function.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.0.error
    }

    pub(super) fn corners(&self) -> &[f64] {
        &self.0.corners
    }

    /// Slip speeds at which two polynomials meet.
    pub(super) fn seams(&self) -> &[f64] {
        &self.0.ends[1..self.0.coefficients.len()]
    }

    /// phi by the polynomial of a piece, at `u` within it or near it.
    fn on_piece<T: Real>(&self, piece: usize, u: T) -> T {
        let (from, to) = (self.0.ends[piece], self.0.ends[piece + 1]);
        let (middle, scale) = (0.5 * (from + to), 2.0 / (to - from));
        sum(&self.0.coefficients[piece], (u - T::constant(middle)) * T::constant(scale))
    }

    /// Index of the piece that contains `u`; the first one below zero.
    fn piece_at(&self, u: f64) -> usize {
        let after = self.0.ends.partition_point(|end| *end <= u);
        after.saturating_sub(1).min(self.0.coefficients.len() - 1)
    }

    /// phi(u); below u = 0, where the flow is continued, by the first polynomial.
    pub(super) fn phi(&self, u: f64) -> f64 {
        if u > self.fastest() { f64::NAN } else { self.on_piece(self.piece_at(u), u) }
    }

    /// -phi'(u).
    pub(super) fn weakening(&self, u: f64) -> f64 {
        if u > self.fastest() {
            return f64::NAN;
        }
        -self.on_piece(self.piece_at(u), Jet::<f64, 2>::variable(u, 1.0)).0[1]
    }

    /// The whole law as text, from which [`Function::from_definition`] restores every bit.
    pub(super) fn definition(&self) -> String {
        let Pieces { origin, ends, corners, coefficients, error } = &*self.0;
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let head = [format!("{error} {origin}"), words(corners), words(ends)];
        let rows = coefficients.iter().map(|row| words(row));
        head.into_iter().chain(rows).collect::<Vec<_>>().join("\n")
    }

    /// The law of the text of [`Function::definition`]; `None` if the text is malformed, if its pieces do not
    /// meet, or if friction at rest is not 1.
    pub(super) fn from_definition(definition: &str) -> Option<Self> {
        let numbers = |line: &str| -> Option<Vec<f64>> {
            let words = line.split(',').filter(|_| !line.is_empty());
            words.map(|word| word.parse().ok()).collect()
        };
        let mut lines = definition.split('\n');
        let (error, origin) = lines.next()?.split_once(' ')?;
        let (corners, ends) = (numbers(lines.next()?)?, numbers(lines.next()?)?);
        let rows = lines.map(|line| numbers(line)?.try_into().ok());
        let coefficients: Vec<[f64; COUNT]> = rows.collect::<Option<_>>()?;
        let grows = ends.windows(2).all(|pair| pair[0] < pair[1]);
        let fits = ends.len() == coefficients.len() + 1 && !coefficients.is_empty() && ends[0] == 0.0;
        let finite = ends.iter().chain(coefficients.iter().flatten()).all(|number| number.is_finite());
        let error: f64 = error.parse().ok()?;
        let at_ends = corners.iter().all(|corner| ends.contains(corner));
        let inside = corners.windows(2).all(|pair| pair[0] < pair[1]) && at_ends;
        if !(grows && fits && finite && inside && error.is_finite() && error >= 0.0) {
            return None;
        }
        let law = Self(Arc::new(Pieces { origin: origin.to_owned(), ends, corners, coefficients, error }));
        (law.meets() && (law.phi(0.0) - 1.0).abs() <= STATIC_SLACK).then_some(law)
    }

    /// Whether neighbouring polynomials meet, and the first is 1 at rest; enclosed, since coefficients that were
    /// made to cancel give any number in double precision.
    fn meets(&self) -> bool {
        let at = |piece: usize, end: f64| self.on_piece(piece, Interval::of(end));
        let gap = |(piece, end): (usize, &f64)| at(piece, *end) - at(piece + 1, *end);
        let at_rest = at(0, 0.0) - Interval::ONE;
        self.seams().iter().enumerate().map(gap).chain([at_rest]).all(|gap| gap.size() <= LARGEST_GAP)
    }
}

/// The pieces and the error of a law while it is fitted.
struct Fitted {
    ends: Vec<f64>,
    coefficients: Vec<[f64; COUNT]>,
    error: f64,
}

impl Fitted {
    /// Fits `phi` between each two of `ends`, on pieces as short as needed.
    fn new(phi: &mut impl FnMut(f64) -> f64, ends: &[f64]) -> Self {
        let mut fitted = Self { ends: vec![0.0], coefficients: Vec::new(), error: 0.0 };
        let range = ends[ends.len() - 1];
        let mut waiting: Vec<(f64, f64, u32)> =
            ends.windows(2).rev().map(|pair| (pair[0], pair[1], 0)).collect();
        while let Some((a, b, halvings)) = waiting.pop() {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let values = POINTS.map(|x| phi((middle + half * x).clamp(a, b)));
            let coefficients = TRANSFORM
                .map(|row| row.iter().zip(&values).map(|(weight, value)| weight * value).sum::<f64>());
            let size = values.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
            let tail = coefficients[COUNT - 2].abs() + coefficients[COUNT - 1].abs();
            let last = halvings >= MOST_HALVINGS
                || !(a < middle && middle < b)
                || fitted.coefficients.len() + waiting.len() >= MOST_PIECES;
            // The error of an interpolant is largest between the points, and unknown where the function is not as smooth
            // as its values at these.
            let between = POINTS.windows(2).map(|pair| middle + half * 0.5 * (pair[0] + pair[1]));
            let count = TESTS.max((TESTS_IN_ALL * (b - a) / range).ceil()) as u32;
            let spread = (1..=count).map(|k| a + (b - a) * (f64::from(k) * GOLDEN).fract());
            let next = [(a, b - a), (b, a - b)].into_iter().filter(|(end, _)| ends.contains(end));
            let next =
                next.flat_map(|(end, length)| (1..=NEXT_TO_ENDS).map(move |k| end + length * 2f64.powi(-k)));
            let tests = between.chain(spread).chain(next);
            let mut miss = |u: f64| sum(&coefficients, (u - middle) / half) - phi(u);
            let is_sharp = tail <= SHARPNESS * size;
            let missed = match is_sharp || last {
                true => tests.clone().map(|u| miss(u).abs()).fold(tail, f64::max),
                false => tail,
            };
            let is_known = is_sharp && missed <= LARGEST_MISS * size;
            if !(last || is_known) {
                waiting.extend([(middle, b, halvings + 1), (a, middle, halvings + 1)]);
                continue;
            }
            // By Markov's inequality the slope of a polynomial of degree n is at most n^2 / half times its largest
            // value. What is no polynomial may be steeper.
            let degree = (COUNT - 1) as f64;
            let of_polynomial = degree * degree / half * (missed + 4.0 * f64::EPSILON * size);
            let step = STEP * (b - a);
            let slope = |u: f64| (miss((u + step).min(b)) - miss((u + step).min(b) - step)).abs() / step;
            let steepest = if is_known { 0.0 } else { tests.map(slope).fold(0.0, f64::max) };
            fitted.error = fitted.error.max(of_polynomial).max(steepest);
            fitted.coefficients.push(coefficients);
            fitted.ends.push(b);
        }
        fitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponential() -> Function {
        Function::new("test", |u| 0.5 + 0.5 * (-u).exp(), 8.0, &[]).unwrap()
    }

    #[test]
    fn a_smooth_function_is_interpolated_within_the_stated_error() {
        let law = exponential();
        assert!(law.seams().len() < 16 && law.error() < 1e-10, "{} {}", law.seams().len(), law.error());
        for i in 0..=800 {
            let u = f64::from(i) / 100.0;
            assert!((law.phi(u) - (0.5 + 0.5 * (-u).exp())).abs() < 1e-13, "{u}");
            assert!((law.weakening(u) - 0.5 * (-u).exp()).abs() <= law.error(), "{u}");
        }
        assert!(law.phi(8.1).is_nan() && law.weakening(8.1).is_nan());
    }

    /// A fall within 1e-7 of the range and a dip as wide as 1e-4 of it are found, and a corner next to where it was said to
    /// be; a jump at rest is refused, and one elsewhere is in the error, as are ripples that take too many pieces.
    #[test]
    fn narrow_falls_and_dips_are_found() {
        let fall = |u: f64| 0.6 + 0.4 * (-u / 1e-6).exp();
        let law = Function::new("falls", fall, 8.0, &[]).unwrap();
        let dip = |u: f64| 1.0 - 0.2 * (-((u - 3.3) / 8e-4).powi(2)).exp();
        let dips = Function::new("dips", dip, 8.0, &[]).unwrap();
        for i in 0..=400 {
            let u = 1e-8 * 1.05f64.powi(i);
            assert!((law.phi(u) - fall(u)).abs() < 1e-12, "{u}");
            let u = 3.298 + 1e-5 * f64::from(i);
            assert!((dips.phi(u) - dip(u)).abs() < 1e-12, "{u}");
        }
        assert!(law.error() < 1e-2 && dips.error() < 1e-7, "{} {}", law.error(), dips.error());
        let kink = Function::new("kink", |u| 1.0 - 0.1 * u.min(1.7), 8.0, &[1.701]).unwrap();
        assert!(kink.error() > 0.1, "{}", kink.error());
        let ripples = Function::new("ripples", |u| 1.0 - 1e-3 * (1e4 * u).sin(), 8.0, &[]).unwrap();
        assert!(ripples.error() > 10.0, "{}", ripples.error());
        let drops = Function::new("drops", |u| if u > 0.0 { 0.7 } else { 1.0 }, 8.0, &[]).unwrap_err();
        assert!(drops.problem.contains("just above it is 0.69999"), "{drops}");
        let jumps = Function::new("jumps", |u| if u > 1.3 { 0.7 } else { 1.0 }, 8.0, &[]).unwrap();
        assert!(jumps.error() > 1.0, "{}", jumps.error());
    }

    #[test]
    fn a_corner_is_exact_if_it_is_declared() {
        let kinked = |u: f64| if u < 1.0 { 1.0 - 0.2 * u } else { 0.8 - 0.1 * (u - 1.0) };
        let law = Function::new("kinked", kinked, 4.0, &[1.0]).unwrap();
        assert_eq!(law.corners(), [1.0]);
        assert!((law.weakening(0.999_999) - 0.2).abs() < 1e-12 && (law.weakening(1.0) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_definition_is_the_law_and_nonsense_is_none() {
        let law = exponential();
        assert_eq!(Function::from_definition(&law.definition()), Some(law));
        for nonsense in ["", "0 x\n\n0,1", "0 x\n\n1,2\n1"] {
            assert_eq!(Function::from_definition(nonsense), None);
        }
        let constant = |error: &str, corners: &str, values: [&str; 2]| {
            let rows = values.map(|value| format!("{value}{}", ",0".repeat(COUNT - 1))).join("\n");
            Function::from_definition(&format!("{error} x\n{corners}\n0,1,2\n{rows}"))
        };
        // At rest it is 1.1, and 1 in double precision.
        let cancels =
            "0 x\n\n0,1\n4000000000000001,4000000000000000,0.1".to_owned() + &",0".repeat(COUNT - 3);
        assert_eq!(Function::from_definition(&cancels), None);
        assert!(constant("0", "", ["1", "1"]).is_some() && constant("0", "1", ["1", "1"]).is_some());
        // A jump of friction, another one at rest, no error, no corners.
        assert_eq!(constant("0", "", ["1", "0.8"]), None);
        assert_eq!(constant("0", "", ["2", "2"]), None);
        for (error, corners) in [("-1", ""), ("nan", ""), ("0", "nan"), ("0", "1,1"), ("0", "0.5")] {
            assert_eq!(constant(error, corners, ["1", "1"]), None, "{error} {corners}");
        }
    }

    #[test]
    fn invalid_laws_are_refused() {
        let problem = |law: Result<Function, FunctionError>| law.unwrap_err().problem;
        assert!(problem(Function::new("bad", |u| 2.0 - u, 1.0, &[])).contains("phi(0) is 2"));
        assert!(
            problem(Function::new("bad", |u| if u > 1.5 { f64::NAN } else { 1.0 }, 2.0, &[])).contains("NaN")
        );
        assert!(problem(Function::new("bad", |_| 1.0, 0.0, &[])).contains("largest slip speed"));
        assert!(problem(Function::new("bad", |_| 1.0, 2.0, &[3.0])).contains("corners"));
    }
}
