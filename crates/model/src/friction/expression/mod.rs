//! A friction law given as text, such as `mu + (1 - mu)*exp(-u/vs)`: phi in the slip speed u or v, in eps, and in
//! any other names, which become parameters of the law and axes of maps.
//!
//! The crate `winnow` parses the text to a tape of operations, which is evaluated on Taylor series
//! ([`slipmap_numbers::jet`]): over numbers for phi and its derivative, over intervals for proved bounds, over series
//! in eps for the first-order theory. A series is as exact as a formula for the derivative, and cheaper: a
//! third derivative costs ten products for each product of the law, while its formula has hundreds of terms.
//!
//! **Legal laws** are checked by [`Expression::check`]: phi(0) = 1 (after division by a stated static
//! level), in double and in interval arithmetic, phi and D finite and continuous over the slip speeds of the
//! check. `abs` is legal if its argument does not change its sign there, and `max(u, peak)` if D does not jump at that
//! slip speed. A power with an exponent that is not
//! an integer requires a base >= 0, and, where the base vanishes, an exponent of at least 1.

mod parse;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use super::{Gradient, NoFirstOrder, Parameter};
use super::{NO_REST, REST_AT_PEAK};
use crate::point::{LawParameters, MAX_LAW_PARAMETERS};
pub use parse::Op;
use parse::{DEEPEST, Function, Place, Tape, is_integer};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Points, Real};
use slipmap_numbers::random::Random;

/// Largest number of operations of a formula: with more, one evaluation would cost as much as hundreds of
/// evaluations of a usual law.
const MOST_OPERATIONS: usize = 500;

/// What friction at the onset of slip has to be, in words.
const ONSET: &str = "friction in slip begins above 0 and at most at the friction at rest";

/// What to write for friction without a finite slope, in words.
const STEEP: &str = "if friction falls at once as slip begins, write that fall as a drop, with static above the formula at \
                     u = 0; for the rest use an exponent of at least 1";

/// Tolerance of phi(0) = 1: formulas have rounding errors.
const STATIC_SLACK: f64 = 1e-12;
/// Number of draws by which a formula is compared with the friction at rest.
const DRAWS: usize = 4;
/// Distance from 1 within which phi(0) must be known: of terms that cancel, the computed value alone may be
/// anything. The friction that it leaves open is a constant, which the statements of certificates take out.
const KNOWN_WITHIN: f64 = 1e-9;
/// Largest number of ranges of slip speed on which a formula is checked: as many as hundreds of features need.
const MOST_CHECKED: u32 = 20_000;

/// An error in a formula, with its place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{problem} (character {} of the formula)\n  help: {remedy}", .from + 1)]
pub struct ExpressionError {
    /// First character concerned, from 0.
    pub from: usize,
    /// One past the last character concerned.
    pub to: usize,
    /// What is wrong.
    pub problem: String,
    /// The remedy.
    pub remedy: String,
}

/// A law given as text. Clones share what was parsed.
#[derive(Clone, Debug)]
pub struct Expression {
    parsed: Arc<Parsed>,
    /// Every u or v of the text stands for this times the slip speed.
    unit: f64,
    /// See [`super::Curve::corners`]; `None` where there are none. Small, since each column has a copy of its law.
    corners: Option<Arc<Vec<f64>>>,
    /// phi is the formula divided by this, the friction at rest.
    static_level: f64,
    /// Whether friction in slip may begin below the friction at rest.
    may_drop: bool,
}

#[derive(Debug)]
struct Parsed {
    text: String,
    tape: Tape,
    parameters: Vec<Parameter>,
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.unit == other.unit && self.differs_in_unit(other)
    }
}

/// Keeps each name of a parameter once, for the life of the program: names of axes have the lifetime
/// `'static`.
fn interned(name: String) -> &'static str {
    static KNOWN: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(name) = known.get(name.as_str()) {
        return name;
    }
    let name: &'static str = Box::leak(name.into_boxed_str());
    known.insert(name);
    name
}

impl Expression {
    /// Compiles `text`; phi is the value of the formula divided by `static_level` > 0, its value at u = 0.
    ///
    /// # Errors
    /// [`ExpressionError`] where the text is no formula, or has too many parameters.
    pub fn new(text: &str, static_level: f64) -> Result<Self, ExpressionError> {
        Self::compiled(text, static_level, false)
    }

    /// Compiles `text`, friction in slip, with the friction `static_level` > 0 at rest: at least the value of
    /// the formula at u = 0. Where that is less, friction drops as slip begins, see [`super::Curve::drop`].
    ///
    /// # Errors
    /// As [`Expression::new`].
    pub fn with_static(text: &str, static_level: f64) -> Result<Self, ExpressionError> {
        let law = Self::compiled(text, static_level, true)?;
        match law.seems_to_begin_at_rest() {
            true => Self::new(text, static_level),
            false => Ok(law),
        }
    }

    /// Returns whether the formula has the value of the friction at rest at u = 0, at random values of eps and
    /// of all parameters. Analytic functions that are equal there are equal.
    fn seems_to_begin_at_rest(&self) -> bool {
        let mut random = Random(DRAWS as u64);
        (0..DRAWS).all(|_| {
            let values: Vec<f64> = self.parameters().iter().map(|_| 0.1 + 2.0 * random.unit()).collect();
            let epsilon = 0.1 + random.unit();
            (self.phi_at(0.0, epsilon, &values) - 1.0).abs() <= STATIC_SLACK
        })
    }

    fn compiled(text: &str, static_level: f64, may_drop: bool) -> Result<Self, ExpressionError> {
        let tape = parse::parse(text)?;
        if let Some(place) = tape.places.get(MOST_OPERATIONS) {
            let problem = format!(
                "the formula has {} operations; this is the first of more than {MOST_OPERATIONS}",
                tape.ops.len()
            );
            return Err(place.error(problem, "simplify it, or give the law as a table"));
        }
        if let Some((name, place)) = tape.parameters.get(MAX_LAW_PARAMETERS) {
            let problem = format!("`{name}` is one parameter more than {MAX_LAW_PARAMETERS}");
            return Err(place.error(problem, "write some of them as numbers"));
        }
        let parameters = tape.parameters.iter().map(|(name, _)| Parameter {
            name: interned(name.clone()),
            long_name: interned(format!("parameter {name} of the friction law")),
            min: f64::MIN,
            max: f64::MAX,
        });
        let corners = tape.corners(1.0).map(Arc::new);
        let parsed = Arc::new(Parsed { text: text.to_owned(), parameters: parameters.collect(), tape });
        Ok(Self { parsed, unit: 1.0, corners, static_level, may_drop })
    }

    /// The law with its slip speed in units of `unit`, divided by `static_level`: in the text, every u or v is replaced by
    /// (unit*u).
    #[must_use]
    pub fn in_units(&self, unit: f64, static_level: f64) -> Self {
        Self { static_level, ..self.with_unit(self.unit * unit) }
    }

    fn with_unit(&self, unit: f64) -> Self {
        Self { unit, corners: self.parsed.tape.corners(unit).map(Arc::new), ..self.clone() }
    }

    /// Whether the laws are the same but for the unit of the slip speed, or in all.
    fn differs_in_unit(&self, other: &Self) -> bool {
        self.static_level == other.static_level
            && self.may_drop == other.may_drop
            && (Arc::ptr_eq(&self.parsed, &other.parsed) || self.parsed.text == other.parsed.text)
    }

    /// The formula as it was written, or in its units.
    #[must_use]
    pub fn text(&self) -> Cow<'_, str> {
        let written = self.parsed.text.as_str();
        if self.unit == 1.0 {
            return Cow::Borrowed(written);
        }
        Cow::Owned(self.with_slip(|slip| format!("({:?}*{slip})", self.unit)))
    }

    /// The formula as it was written, with another term for the slip speed.
    pub(super) fn with_slip(&self, term: impl Fn(&str) -> String) -> String {
        let written = self.parsed.text.as_str();
        let mut text = String::with_capacity(2 * written.len());
        let is_part = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '.';
        let mut rest = written;
        while !rest.is_empty() {
            let word = &rest[..rest.find(|letter| !is_part(letter)).unwrap_or(rest.len())];
            match word {
                "u" | "v" => text.push_str(&term(word)),
                word => text.push_str(word),
            }
            rest = &rest[word.len()..];
            let gap = rest.find(is_part).unwrap_or(rest.len());
            text.push_str(&rest[..gap]);
            rest = &rest[gap..];
        }
        text
    }

    /// The operations of the formula as it was written, in reverse Polish order.
    pub fn operations(&self) -> &[Op] {
        &self.parsed.tape.ops
    }

    /// The friction at rest, by which the formula is divided.
    pub fn static_level(&self) -> f64 {
        self.static_level
    }

    /// Whether friction in slip may begin below the friction at rest.
    pub fn may_drop(&self) -> bool {
        self.may_drop
    }

    /// The named parameters in order of appearance.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parsed.parameters
    }

    /// The range of characters in which a parameter first occurs in the text.
    pub fn place_of(&self, parameter: &str) -> Option<(usize, usize)> {
        let found = self.parsed.tape.parameters.iter().find(|(name, _)| name == parameter);
        found.map(|(_, place)| (place.from, place.to))
    }

    /// Returns whether eps occurs in the formula.
    #[must_use]
    pub fn depends_on_epsilon(&self) -> bool {
        self.parsed.tape.ops.contains(&Op::Epsilon)
    }

    /// The curve at one eps and one choice of parameters. The curves of a formula without eps are equal for
    /// all eps.
    pub(super) fn curve(&self, epsilon: f64, parameters: &LawParameters) -> ExpressionCurve {
        let epsilon = if self.depends_on_epsilon() { epsilon } else { 0.0 };
        ExpressionCurve { law: self.clone(), epsilon, parameters: *parameters }
    }

    /// The friction in slip as u -> 0, in units of that at rest, at these values of the parameters.
    #[must_use]
    pub fn at_onset(&self, parameters: &LawParameters) -> f64 {
        self.phi_at(0.0, 1.0, parameters.as_slice())
    }

    /// phi at slip speed `u`, eps and parameters in any arithmetic.
    pub(super) fn phi_at<T: Real>(&self, u: T, epsilon: T, parameters: &[T]) -> T {
        self.curve(0.0, &LawParameters::new(&[])).run_with(u, epsilon, |i| parameters[i], |_, _| ())
    }

    /// Checks that the law is legal at one eps and one choice of parameters for slip speeds in
    /// [0, `fastest`]: phi(0) = 1, phi and phi' finite and phi' continuous.
    ///
    /// # Errors
    /// [`ExpressionError`] that names the operation at fault and the slip speed.
    pub fn check(
        &self,
        epsilon: f64,
        parameters: &LawParameters,
        fastest: f64,
    ) -> Result<(), ExpressionError> {
        self.curve(epsilon, parameters).check(fastest)
    }
}

/// A formula with all its parameters fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionCurve {
    pub(super) law: Expression,
    epsilon: f64,
    parameters: LawParameters,
}

fn call<T: Real>(function: Function, x: T) -> T {
    let half = T::constant(0.5);
    match function {
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Sqrt => x.sqrt(),
        Function::Sin => x.sin_cos().0,
        Function::Cos => x.sin_cos().1,
        Function::Tan => {
            let (sin, cos) = x.sin_cos();
            sin / cos
        }
        Function::Sinh => half * (x.exp() - (-x).exp()),
        Function::Cosh => half * (x.exp() + (-x).exp()),
        Function::Tanh => x.tanh(),
        Function::Atan => x.atan(),
        Function::Asinh => (x + (x * x + T::constant(1.0)).sqrt()).ln(),
        Function::Log10 => x.ln() * T::constant(std::f64::consts::LOG10_E),
        Function::Abs => x.abs(),
        Function::Sign => unreachable!("the parser leaves no sign on the tape"),
    }
}

/// A power in any arithmetic.
pub(super) fn power<T: Real>(base: T, exponent: T) -> T {
    match exponent.as_constant() {
        Some(exponent) if is_integer(exponent) => base.powi(exponent as i32),
        Some(exponent) => base.power(exponent),
        None => (exponent * base.ln()).exp(),
    }
}

impl ExpressionCurve {
    /// The unit of the slip speed, where that is not the one of the formula as it was written; and the curve of that formula.
    pub(super) fn unit(&self) -> Option<(f64, Self)> {
        let written = || Self { law: self.law.with_unit(1.0), ..self.clone() };
        (self.law.unit != 1.0).then(|| (self.law.unit, written()))
    }

    /// Whether another curve is that of the same formula, perhaps in another unit of the slip speed.
    pub(super) fn is_of_same_formula(&self, other: &Self) -> bool {
        self.epsilon == other.epsilon
            && self.parameters == other.parameters
            && self.law.differs_in_unit(&other.law)
    }

    /// See [`super::Curve::cost`]: two operations of a formula take about as long as the Stribeck law.
    pub(super) fn cost(&self) -> u64 {
        1 + self.law.parsed.tape.ops.len() as u64 / 2
    }

    /// Evaluates the tape; `watch` is called with the number and the result of every operation.
    #[inline]
    fn run<T: Real>(&self, u: T, epsilon: T, watch: impl FnMut(usize, &T)) -> T {
        self.run_with(u, epsilon, |i| T::constant(self.parameters.as_slice()[i]), watch)
    }

    /// As `run`, with any values of the parameters.
    #[inline]
    fn run_with<T: Real>(
        &self,
        u: T,
        epsilon: T,
        parameter: impl Fn(usize) -> T,
        mut watch: impl FnMut(usize, &T),
    ) -> T {
        // Both factors are operands of a product in the text.
        let unit = self.law.unit;
        let of_text = |u: T| if unit == 1.0 { u } else { T::constant(unit) * u };
        let slip = of_text(u);
        let mut stack = [u; DEEPEST];
        let mut top = 0;
        for (number, op) in self.law.parsed.tape.ops.iter().enumerate() {
            let (operands, result) = match *op {
                Op::Number(x) => (0, T::constant(x)),
                Op::Slip => (0, slip),
                Op::SlipAtLeast(floor) => (0, of_text(u.at_least(floor / unit))),
                Op::Epsilon => (0, epsilon),
                Op::Parameter(i) => (0, parameter(i)),
                Op::Add => (2, stack[top - 2] + stack[top - 1]),
                Op::Subtract => (2, stack[top - 2] - stack[top - 1]),
                Op::Multiply => (2, stack[top - 2] * stack[top - 1]),
                Op::Divide => (2, stack[top - 2] / stack[top - 1]),
                Op::Power => (2, power(stack[top - 2], stack[top - 1])),
                Op::Negate => (1, -stack[top - 1]),
                Op::PowerInteger(exponent) => (1, stack[top - 1].powi(exponent)),
                Op::Call(function) => (1, call(function, stack[top - 1])),
            };
            top = top - operands + 1;
            stack[top - 1] = result;
            watch(number, &result);
        }
        let level = self.law.static_level;
        if level == 1.0 { stack[0] } else { stack[0] / T::constant(level) }
    }

    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        self.run(u, T::constant(self.epsilon), |_, _| ())
    }

    #[inline]
    fn series<T: Real, const N: usize>(&self, u: T) -> Jet<T, N> {
        self.run(Jet::variable(u, 1.0), Jet::of(T::constant(self.epsilon)), |_, _| ())
    }

    pub(super) fn corners(&self) -> &[f64] {
        self.law.corners.as_deref().map_or(&[], Vec::as_slice)
    }

    /// The friction at rest less that in slip at u -> 0.
    pub(super) fn drop(&self) -> f64 {
        if !self.law.may_drop {
            return 0.0;
        }
        let drop = 1.0 - self.run(0.0, self.epsilon, |_, _| ());
        // Formulas have rounding errors.
        if drop.abs() <= STATIC_SLACK { 0.0 } else { drop }
    }

    /// phi(u); below u = 0, where the flow is continued, the formula's value, or 1 where that is not finite.
    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        let phi = self.run(u, self.epsilon, |_, _| ());
        if phi.is_finite() || u >= 0.0 { phi } else { 1.0 }
    }

    /// -phi'(u).
    #[inline]
    pub(super) fn weakening(&self, u: f64) -> f64 {
        let slope = self.series::<f64, 2>(u).0[1];
        if slope.is_finite() || u >= 0.0 { -slope } else { -self.series::<f64, 2>(0.0).0[1] }
    }

    /// -phi'(u) at several slip speeds >= 0, with one run of the tape: formulas are compiled a third faster.
    pub(super) fn weakenings<const N: usize>(&self, u: [f64; N]) -> [f64; N] {
        (-self.series::<Points<N>, 2>(Points(u)).0[1]).0
    }

    /// Derivatives of -phi, or of its slope if the `order` is 1, from series in eps and in one parameter after the other.
    pub(super) fn derivatives(&self, u: f64, order: usize) -> Gradient {
        type Mixed = Jet<Jet<f64, 2>, 2>;
        let values = self.parameters.as_slice();
        // The derivative with respect to variable `n`: eps for 0, else parameter n - 1.
        let by = |n: usize| {
            let input = |i: usize, x: f64| Mixed::of(if i == n { Jet::variable(x, 1.0) } else { Jet::of(x) });
            let slip = Mixed::variable(Jet::of(u), 1.0);
            let phi = self.run_with(slip, input(0, self.epsilon), |i| input(i + 1, values[i]), |_, _| ());
            -phi.0[order].0[1]
        };
        let parameters: Vec<f64> = (1..=values.len()).map(by).collect();
        Gradient { epsilon: by(0), parameters: LawParameters::new(&parameters) }
    }

    /// F1(u), where phi = 1 + eps F1 + O(eps^2), from the series in eps at eps = 0.
    pub(super) fn leading<T: Real>(&self, u: T) -> T {
        self.run(Jet::<T, 2>::of(u), Jet::variable(T::constant(0.0), 1.0), |_, _| ()).0[1]
    }

    /// Checks at samples that the law is 1 + O(eps) on slip speeds up to twice the belt speed.
    pub(super) fn check_leading(&self, belt_speed: f64) -> Result<(), NoFirstOrder> {
        if !self.law.depends_on_epsilon() {
            return Err(NoFirstOrder::NoEpsilon);
        }
        for i in 0..=32 {
            let u = 2.0 * belt_speed * f64::from(i) / 32.0;
            let at = self.run::<Jet<Interval, 2>>(
                Jet::of(Interval::of(u)),
                Jet::variable(Interval::ZERO, 1.0),
                |_, _| (),
            );
            let [phi, slope] = at.0;
            if !(phi.is_bounded() && slope.is_bounded()) {
                return Err(NoFirstOrder::NotDifferentiable);
            }
            if !(1.0 - phi.lo <= KNOWN_WITHIN && phi.hi - 1.0 <= KNOWN_WITHIN) {
                return Err(NoFirstOrder::NotSmall);
            }
        }
        Ok(())
    }

    fn check(&self, fastest: f64) -> Result<(), ExpressionError> {
        let Expression { parsed, static_level, may_drop, .. } = &self.law;
        let Parsed { tape, text, .. } = &**parsed;
        // Singular operations are searched first, because their errors are more specific than a wrong value.
        // A range of slip speeds on which an operation's value or derivative has no bounds is bisected down
        // to a share of 1e-9.
        let shortest = 1e-9 * fastest;
        let mut ends = vec![0.0];
        ends.extend(self.corners().iter().filter(|corner| **corner < fastest));
        ends.push(fastest);
        let mut pieces: Vec<(f64, f64)> = ends.windows(2).rev().map(|ends| (ends[0], ends[1])).collect();
        pieces.push((0.0, 0.0));
        let mut left = MOST_CHECKED;
        while let Some((a, b)) = pieces.pop() {
            let mut culprit = None;
            let u = Jet::<Interval, 3>::variable(Interval::new(a, b), 1.0);
            let epsilon = Jet::of(Interval::of(self.epsilon));
            self.run(u, epsilon, |number, jet: &Jet<Interval, 3>| {
                let bounded = jet.0[0].is_bounded() && jet.0[1].is_bounded();
                if culprit.is_none() && !bounded {
                    culprit = Some(number);
                }
            });
            let Some(number) = culprit else { continue };
            left = left.saturating_sub(1);
            if b - a > shortest && left > 0 {
                let middle = 0.5 * (a + b);
                pieces.push((middle, b));
                pieces.push((a, middle));
                continue;
            }
            return Err(self.singular(tape, number, [a, b], left > 0));
        }
        let kinked = |corner: &&f64| {
            let jump = self.weakening(**corner) - self.weakening(corner.next_down());
            **corner < fastest && !(jump.abs() * **corner <= KNOWN_WITHIN * self.phi(**corner).abs())
        };
        let kink = self.corners().iter().find(kinked);
        let of_kink = |op: &Op| matches!(op, Op::SlipAtLeast(_));
        if let Some((corner, number)) = kink.zip(tape.ops.iter().position(of_kink)) {
            return Err(self.singular(tape, number, [*corner; 2], true));
        }
        let whole = |problem: String, remedy: String| {
            Err(ExpressionError { from: 0, to: text.chars().count(), problem, remedy })
        };
        let phi_0 = self.phi(0.0);
        let value = phi_0 * static_level;
        if *may_drop && !(phi_0 > 0.0 && phi_0 <= 1.0 + STATIC_SLACK) {
            let problem = format!(
                "friction in slip begins at {value}{}, and friction at rest is {static_level}",
                self.at_parameters()
            );
            return match phi_0.abs() <= STATIC_SLACK {
                true => whole(NO_REST.into(), REST_AT_PEAK.into()),
                false => whole(problem, format!("{ONSET}; static is at least that of slip at u -> 0")),
            };
        }
        if !*may_drop && phi_0.abs() <= STATIC_SLACK {
            return whole(format!("phi(0) is 0{}: {NO_REST}", self.at_parameters()), REST_AT_PEAK.into());
        }
        if !*may_drop && !((phi_0 - 1.0).abs() <= STATIC_SLACK) {
            return whole(
                format!("phi(0) is {phi_0}, not 1{}", self.at_parameters()),
                format!(
                    "write the friction at rest with the key static: static = {value} if friction falls from there, more \
                     if it drops as slip begins"
                ),
            );
        }
        let level = if *may_drop { phi_0 } else { 1.0 };
        let Interval { lo, hi } = self.formula(Interval::ZERO);
        let [lo, hi] = [lo + (1.0 - level), hi + (1.0 - level)];
        if !(1.0 - lo <= KNOWN_WITHIN && hi - 1.0 <= KNOWN_WITHIN) {
            return whole(
                format!(
                    "phi(0) is 1 only up to rounding: it is between {lo:.3} and {hi:.3}{}, since terms cancel",
                    self.at_parameters()
                ),
                "write the formula without large terms that cancel".into(),
            );
        }
        Ok(())
    }

    /// The error for an operation, given by its number, that is singular for slip speeds within [a, b]; or
    /// of which too many ranges of slip speed, the last one [a, b], leave that open.
    fn singular(&self, tape: &Tape, number: usize, [a, b]: [f64; 2], is_decided: bool) -> ExpressionError {
        let Place { from, to } = tape.places[number];
        let part: String = self.law.parsed.text.chars().skip(from).take(to - from).collect();
        let where_ = if b == 0.0 { "u = 0".to_owned() } else { format!("u = {:.6}", 0.5 * (a + b)) };
        let at = format!("{where_}{}", self.at_parameters());
        let (problem, remedy) = match tape.ops[number] {
            _ if !is_decided => (
                format!(
                    "whether `{part}` is regular was not decided on {MOST_CHECKED} ranges of slip speed, the last from \
                     {a:.6} to {b:.6}{}",
                    self.at_parameters()
                ),
                "write a formula with fewer features, or give the law as a table",
            ),
            Op::PowerInteger(exponent) if exponent > 0 => {
                (format!("the power {exponent} of `{part}` overflows at {at}"), "scale the formula")
            }
            Op::Divide | Op::PowerInteger(_) => (
                format!("division by zero: `{part}` vanishes at {at}"),
                "write the law without that pole, in a form that also holds in the limit",
            ),
            Op::Call(Function::Abs) | Op::SlipAtLeast(_) => (
                format!("`{part}` has a kink at {at}, where D would jump"),
                "give the law as a table with a row at the kink; a formula that smooths it is another law",
            ),
            Op::Call(Function::Sqrt) => (format!("`{part}` has no finite derivative at {at}"), STEEP),
            Op::Call(Function::Ln | Function::Log10) => {
                (format!("`{part}` is not defined at {at}"), "keep its argument positive")
            }
            Op::Power => (
                format!(
                    "the base `{part}` of a power is negative at {at}, or 0 with an exponent below 1: no finite slope"
                ),
                STEEP,
            ),
            Op::Call(Function::Tan) => (format!("`{part}` has a pole at {at}"), "keep away from it"),
            _ => (format!("`{part}` overflows at {at}"), "scale the formula"),
        };
        tape.places[number].error(problem, remedy)
    }

    /// The parameters in words, for messages.
    fn at_parameters(&self) -> String {
        let named = self.law.parameters().iter().zip(self.parameters.as_slice());
        let mut words: Vec<String> = named.map(|(p, value)| format!("{} = {value}", p.name)).collect();
        if self.law.depends_on_epsilon() {
            words.insert(0, format!("epsilon = {}", self.epsilon));
        }
        if words.is_empty() { String::new() } else { format!(" for {}", words.join(", ")) }
    }
}

#[cfg(test)]
mod derivatives;
#[cfg(test)]
mod tests;
