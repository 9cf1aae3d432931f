use super::super::{FirstOrder, Law};
use super::*;

fn at(text: &str, epsilon: f64, parameters: &[f64]) -> ExpressionCurve {
    Expression::new(text, 1.0).unwrap().curve(epsilon, &LawParameters::new(parameters))
}

fn first_order(text: &str) -> Result<FirstOrder, NoFirstOrder> {
    let law = Law::Expression(Expression::new(text, 1.0).unwrap());
    law.curve(0.3, &LawParameters::new(&[])).first_order(1.0)
}

fn value(text: &str, u: f64) -> f64 {
    at(text, 0.1, &[]).phi(u)
}

#[test]
fn reads_formulas_as_on_paper() {
    for (text, expected) in [
        ("-u^2", -9.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("2**3", 8.0),
        ("1 - 2 - 3", -4.0),
        ("12/2/3", 2.0),
        ("1.5e-3 + .5", 0.5015),
        ("2*-u", -6.0),
        ("2^-u*8", 1.0),
        ("-2^2*3", -12.0),
        ("2^-1^2", 0.5),
        ("8/2*3", 12.0),
        (" - + - u\u{a0}", 3.0),
        ("--u", 3.0),
        ("exp(0) + ln(1) + sqrt(4) + tanh(0) + atan(0) + abs(-2)", 5.0),
        ("sin(pi/2) + cos(0) + tan(0) + sinh(0) + cosh(0)", 3.0),
        ("eps*10 + epsilon*10", 2.0),
        ("(((u)))", 3.0),
        ("v^2 + abs(v)*sign(v)", 12.0),
        ("e^(u - 1)^1*e^-2 + -e**0*(e)^1/e", 0.0),
        ("log10(u/3) + asinh(0)", 0.0),
    ] {
        // One rounding in the functions.
        assert!((value(text, 3.0) - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{text}");
    }
    let law = Expression::new("b + a*u + b", 1.0).unwrap();
    assert_eq!(law.parameters().iter().map(|p| p.name).collect::<Vec<_>>(), ["b", "a"]);
    assert_eq!(law.place_of("a"), Some((4, 5)));
}

#[test]
fn equal_texts_are_one_law() {
    assert_eq!(Expression::new("1 - u/8", 1.0).unwrap(), Expression::new("1 - u/8", 1.0).unwrap());
    assert_ne!(Expression::new("1 - u/8", 1.0).unwrap(), Expression::new("1 - u/8", 2.0).unwrap());
}

#[test]
fn errors_of_syntax_name_their_place() {
    for (text, place, words) in [
        ("", (0, 1), "ends where a value"),
        ("1 + ", (4, 5), "ends where a value"),
        ("exp(-u/vs", (3, 4), "never closed"),
        ("1 + epx(u)", (4, 7), "no function `epx`"),
        ("1 - u)", (5, 6), "closes nothing"),
        ("2 u", (2, 3), "operator such as *"),
        ("1 + 2 sin(u)", (6, 9), "operator such as *"),
        ("exp(u vs)", (6, 8), "an operator or `)`"),
        ("exp(u, vs)", (5, 6), "one argument"),
        ("2 - 3e", (5, 6), "operator such as *"),
        ("1e999", (0, 5), "not a number"),
        ("1 +  - ", (7, 8), "ends where a value"),
        ("()", (1, 2), "a value is expected"),
        ("é + 1", (0, 1), "`é` is not known"),
        ("u\u{2003}+ ü", (4, 5), "`ü` is not known"),
        ("|u - 1|", (0, 1), "`|` is not known"),
        ("1 + #", (4, 5), "`#` is not known"),
        ("1.2.3", (0, 5), "not a number"),
        ("1 + V", (4, 5), "not part of a friction law"),
        ("1 - v*u", (6, 7), "both names of the slip speed"),
        ("1 - 0,1*u", (5, 6), "decimals a point"),
        ("min(0.5, 1 - u)", (0, 3), "no function `min`"),
        ("max(1 - u, 0.5)", (0, 9), "the slip speed and a number"),
        ("max(u, -1)", (0, 5), "the slip speed and a number"),
        ("max(u, 0.5", (0, 5), "the slip speed and a number"),
        ("exp + 1", (0, 3), "needs its argument"),
        ("1 * / 2", (4, 5), "a value is expected"),
        ("a+b+d+k+f+g+h+i+j", (16, 17), "one parameter more"),
    ] {
        let error = Expression::new(text, 1.0).unwrap_err();
        assert_eq!((error.from, error.to), place, "{text}: {error}");
        assert!(error.problem.contains(words), "{text}: {error}");
    }
}

#[test]
fn hostile_nesting_is_refused_on_a_small_stack() {
    let refused = || {
        const MANY: usize = 1_000_000;
        let times = |part: &str| part.repeat(MANY);
        for (text, from) in [
            (format!("{}1{}", times("("), times(")")), 100),
            (times("-"), 100),
            (times("+-"), 100),
            (times("exp("), 403),
            (times("-("), 100),
            // Each power, and each sum in parentheses, leaves its base on the stack.
            (times("2^"), 48),
            (times("2+("), 72),
            (times("2^-"), 72),
        ] {
            let error = Expression::new(&text, 1.0).unwrap_err();
            assert_eq!((error.from, error.to), (from, from + 1), "{}: {error}", &text[..8]);
        }
        // A formula without nesting may be long, up to the limit of operations.
        let long = format!("1{}", times("+1").split_at(400).0);
        assert_eq!(value(&long, 0.0), 201.0);
    };
    // A quarter of the default stack of threads.
    std::thread::Builder::new().stack_size(512 * 1024).spawn(refused).unwrap().join().unwrap();
}

/// A slip speed times its unit over a width is two operations at u = 0, where a power of it needs a number >= 0.
#[test]
fn powers_of_the_slip_speed_are_legal_in_every_unit() {
    for (text, parameters) in
        [("0.25 + 0.15*exp(-(u/vs)^1.5)", &[0.03][..]), ("0.25 + 0.15*exp(-((u + u*u)/vs)^d)", &[0.03, 1.18])]
    {
        let law = Expression::new(text, 0.4).unwrap();
        for unit in [1.0, 0.1199, 1e-3] {
            let parameters = LawParameters::new(parameters);
            let checked = law.in_units(unit, 0.4).check(1.0, &parameters, 2.0 / unit);
            assert_eq!(checked.map_err(|error| error.problem), Ok(()), "{text} {unit}");
        }
    }
}

#[test]
fn errors_are_found_with_their_place() {
    for (text, parameters, place, words) in [
        ("0.5 + exp(-u)", &[][..], (0, 13), "phi(0) is 1.5, not 1"),
        ("tanh(20*u)", &[], (0, 10), "phi(0) is 0: friction vanishes at rest"),
        ("1 - 0.1*u/(u - a)", &[0.7], (10, 17), "vanishes at u = 0.7"),
        ("tanh(u)/u", &[], (8, 9), "vanishes at u = 0"),
        ("1 - 0.1*abs(u - 1)", &[], (8, 18), "kink at u = 1"),
        ("1 - 0.1*sqrt(u)", &[], (8, 15), "no finite derivative at u = 0"),
        ("1 - 0.1*sqrt(1 - u)", &[], (8, 19), "no finite derivative at u = 1"),
        ("1 - 0.1*u^0.5", &[], (8, 9), "no finite slope"),
        ("1 - 0.1*(u/2)^d", &[0.9], (8, 13), "no finite slope"),
        ("1 - 0.1*(u - 1)^1.5", &[], (8, 15), "negative at u = 0"),
        ("1 + 0.1*u*ln(2 - u)", &[], (10, 19), "not defined at u = 2"),
        ("1 - 0.1*tan(u)", &[], (8, 14), "pole at u = 1.57"),
        ("1 - 0.1*(u - 1)^-2 + 0.1", &[], (8, 15), "vanishes at u = 1"),
        (
            "0.9 + 0.1*exp(-(u/1e-12)^40)",
            &[],
            (15, 24),
            "the power 40 of `(u/1e-12)` overflows at u = 0.0000",
        ),
        // 1 in double precision only, or with bounds too wide to say so.
        ("0.5+0.5*exp(-u)-0.9*((1e16+1)-1e16)", &[], (0, 35), "1 only up to rounding"),
        ("(1e16+1)-1e16+0.5+0.5*exp(-u)-0", &[], (0, 31), "1 only up to rounding"),
        ("0.5+0.5*exp(-u)+(u+1e5)^3-u^3-1e5^3", &[], (0, 35), "1 only up to rounding"),
        ("0.5+0.5*exp(-u)+sin(1e20+u)-sin(1e20+u)", &[], (0, 39), "1 only up to rounding"),
        // Tens of thousands of near poles.
        ("1 + 1e-9*(1/(1.5 + sin(9e4*u) + cos(9e4*u)) - 1/2.5)", &[], (12, 43), "20000 ranges of slip speed"),
    ] {
        let law = Expression::new(text, 1.0).unwrap();
        let error = law.check(0.1, &LawParameters::new(parameters), 3.0).unwrap_err();
        assert_eq!((error.from, error.to), place, "{text}: {error}");
        assert!(error.problem.contains(words), "{text}: {error}");
    }
}

#[test]
fn legal_laws_pass() {
    for (text, level, parameters) in [
        ("mu + (1 - mu)*exp(-u/vs)", 1.0, &[0.4, 0.3][..]),
        ("0.2 + 0.25*exp(-u)", 0.45, &[]),
        ("1 - 0.1*abs(u + 1) + 0.1", 1.0, &[]),
        ("(1 + u)^-0.4", 1.0, &[]),
        ("1 - 0.1*tanh(u) + 0.01*u^3", 1.0, &[]),
        ("1 - 0.1*(sqrt(u^2 + 0.01) - 0.1)", 1.0, &[]),
        ("1 - 0.1*u^1.5", 1.0, &[]),
        ("mu + (1 - mu)*exp(-(u/vs)^d)", 1.0, &[0.5, 0.3, 1.0]),
        ("mu + (1 - mu)*exp(-(u/vs)^d)", 1.0, &[0.5, 0.3, 2.0]),
        ("mu + (1 - mu)*exp(-(u/vs)^d)", 1.0, &[0.5, 0.3, 1.2]),
    ] {
        let law = Expression::new(text, level).unwrap();
        law.check(0.1, &LawParameters::new(parameters), 3.0).unwrap();
    }
    // Outside the range of slip speeds the same pole does no harm.
    let law = Expression::new("1 - 0.1*u/(5 - u)", 1.0).unwrap();
    law.check(0.1, &LawParameters::new(&[]), 3.0).unwrap();
    assert!(law.check(0.1, &LawParameters::new(&[]), 6.0).is_err());
}

#[test]
fn first_order_is_the_paper_s_condition_six() {
    // With a nonlinear F1: -sin u at V = 1 gives 2 J1'(..): compare with (6) summed by brute force.
    let first = first_order("1 - eps*sin(u)").unwrap();
    let n = 4000;
    let sum: f64 = (0..n)
        .map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(n))
        .map(|t| -(1.0 - t.cos()).sin() * t.cos())
        .sum();
    assert!((first.mean_weakening - 2.0 * sum / f64::from(n)).abs() <= 1e-14);
}

#[test]
fn without_eps_there_is_no_first_order() {
    let why = |text: &str| first_order(text).unwrap_err();
    assert_eq!(why("exp(-u)"), NoFirstOrder::NoEpsilon);
    assert_eq!(why("exp(-u) + eps*u"), NoFirstOrder::NotSmall);
    assert_eq!(why("exp(-u/eps)"), NoFirstOrder::NotDifferentiable);
}

#[test]
fn continued_below_zero_slip_as_written_or_flat() {
    let curve = at("(1 - 0.1*u)^0.5", 0.1, &[]);
    assert!((curve.phi(-0.5) - 1.05f64.sqrt()).abs() < 1e-15);
    let curve = at("(1 + 10*u)^0.5", 0.1, &[]);
    assert_eq!(curve.weakening(-0.5), curve.weakening(0.0));
}

#[test]
fn several_slip_speeds_at_once_give_the_same_numbers() {
    let text = "1 - 0.1*tanh(3*u) + 0.2*exp(-u)*sin(2*u)*cos(u) + sqrt(1 + u)/(2 + u^2) - 0.1*ln(1 + u)*atan(u) \
                + 0.01*cosh(u) - 0.02*sinh(0.5*u) + 0.1*tan(0.2*u) + abs(u - 9)*eps + (1 + u)^0.3";
    let curve = at(text, 0.1, &[]);
    // A hyperbolic tangent next to 1 has another form where all speeds lie there, equal within rounding.
    for (together, u) in
        curve.weakenings([0.0, 0.3, 1.0, 2.5, 7.0]).into_iter().zip([0.0, 0.3, 1.0, 2.5, 7.0])
    {
        assert!((together - curve.weakening(u)).abs() <= 1e-15 * (1.0 + together.abs()), "{u}");
    }
}

/// Stribeck's law with an exponent is, at the exponents 1 and 2, the law with that number, to the last bit;
/// at others its weakening vanishes at rest, and its polynomials hold there, too.
#[test]
fn a_parameter_may_be_the_exponent() {
    let law = |text: &str| Law::Expression(Expression::new(text, 1.0).unwrap());
    let general = law("mu + (1 - mu)*exp(-(u/vs)^d)");
    for d in [1.0, 2.0] {
        let special = law(&format!("mu + (1 - mu)*exp(-(u/vs)^{d})"));
        let [general, special] = [
            general.curve(1.0, &LawParameters::new(&[0.5, 0.3, d])),
            special.curve(1.0, &LawParameters::new(&[0.5, 0.3])),
        ];
        for u in [0.0, 1e-9, 0.2, 0.3, 2.0] {
            assert_eq!(
                (general.phi(u), general.weakening(u)),
                (special.phi(u), special.weakening(u)),
                "{d} {u}"
            );
        }
    }
    let curve = general.curve(1.0, &LawParameters::new(&[0.5, 0.3, 1.5]));
    assert_eq!((curve.phi(0.0), curve.weakening(0.0)), (1.0, 0.0));
    let compiled = curve.compiled(4.0);
    for i in 0..=400 {
        let u = 0.01 * f64::from(i);
        let exact = 0.5 * 1.5 / 0.3 * (u / 0.3).sqrt() * (-(u / 0.3).powf(1.5)).exp();
        assert!((curve.weakening(u) - exact).abs() < 1e-14, "{u}");
        let found = curve.weakening_range(u, u + 0.01);
        assert!(found.lo <= exact && exact <= found.hi, "{u} {found:?}");
        assert!((compiled.at(u) - exact).abs() < 1e-9, "{u}");
    }
}

/// Random sums of terms that cancel: what is accepted is 1 at rest in real numbers, and far loops end.
#[test]
fn formulas_that_cancel_must_be_one_at_rest() {
    let mut random = slipmap_numbers::random::Random(46);
    let (mut accepted, mut refused, mut false_ones) = (0, 0, 0);
    for _ in 0..300 {
        let mut text = "0.5+0.5*exp(-u)".to_owned();
        // The value at rest beyond 1.
        let mut beyond = 0.0;
        for _ in 0..1 + random.bits() % 3 {
            let a = format!("1e{}", random.bits() % 22);
            let k = [0.0, 0.25, 0.9][(random.bits() % 3) as usize];
            let (term, value) = match random.bits() % 6 {
                0 => (format!("-{k}*(({a}+1)-{a})"), -k),
                1 => (format!("+(u+{a})^3-u^3-{a}^3"), 0.0),
                2 => (format!("+sin({a}+u)-sin({a}+u)"), 0.0),
                3 => (format!("+{k}*u*(({a}+u)-{a})/(1+u^2)"), 0.0),
                4 => (format!("+0.1*(sqrt(u^2+{a})-sqrt({a}))"), 0.0),
                _ => (format!("+{a}*u-{a}*u"), 0.0),
            };
            text += &term;
            beyond += value;
        }
        let law = Expression::new(&text, 1.0).unwrap();
        false_ones += u32::from(beyond != 0.0);
        match law.check(1.0, &LawParameters::new(&[]), 2.0) {
            Ok(()) => {
                accepted += 1;
                assert_eq!(beyond, 0.0, "{text}");
            }
            Err(_) => refused += 1,
        }
        // Whatever it is, bounds of its friction are found.
        let curve = Law::Expression(law).curve(1.0, &LawParameters::new(&[]));
        let range = curve.friction_between(0.0, 4.0, 0.0);
        let phi = curve.formula(Interval::ZERO).unwrap();
        assert!(range.lo <= phi.hi && phi.lo <= range.hi, "{text}: {range:?} {phi:?}");
    }
    assert!(accepted > 50 && refused > 50 && false_ones > 50, "{accepted} {refused} {false_ones}");
}
