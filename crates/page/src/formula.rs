//! Friction laws as formulas set in each format: LaTeX, MathML and plain text.

use slipmap_figure::text::{Formula, Rich, Symbol, raised};
use slipmap_machine::{Friction, Machine};
use slipmap_model::friction::{Expression, Law, Op};

/// The friction phi(u) of a law in slip, in units of that at rest; `None` for data and functions.
pub fn of_law(law: &Law) -> Option<Formula> {
    let (mut text, level) = match law.as_written() {
        Law::Expression(formula) => (formula.text().into_owned(), formula.static_level()),
        law => (law.built_in()?.formula.to_owned(), 1.0),
    };
    if level != 1.0 {
        text = format!("({text})/{level:?}");
    }
    // The parameter of `Law::with_drop`.
    if law.parameters().len() > law.as_written().parameters().len() {
        text.push_str(" - drop");
    }
    set("phi", &text)
}

/// The friction of a machine in slip, in SI units; `None` for data.
pub fn of_machine(machine: &Machine) -> Option<Formula> {
    let name = if machine.normal_force_is_known { "mu" } else { "F" };
    match &machine.friction {
        Friction::Coefficients(law, _) => set(name, law.built_in()?.of_coefficients),
        Friction::Formula(formula, _) => set(name, &formula.text()),
        Friction::Measured(_) => None,
    }
}

/// The symbol of one of a machine's coefficients in [`of_machine`]; other names stand for themselves.
pub fn symbol(coefficient: &str) -> &str {
    match coefficient {
        "static_friction" => "mu_s",
        "kinetic_friction" => "mu_k",
        "stribeck_velocity" => "v_s",
        "strengthening" => "eta",
        "exponent" => "delta",
        name => name,
    }
}

/// How strongly the parts of a formula hold together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Bound {
    Sum,
    /// A product that begins with a minus.
    Negative,
    Product,
    Power,
    Atom,
}

struct Part {
    bound: Bound,
    set: Formula,
}

fn part(bound: Bound, plain: String, html: String, latex: String) -> Part {
    Part { bound, set: Formula { plain, html, latex } }
}

/// "name(u) = text"; `None` where the text is no formula.
fn set(name: &str, text: &str) -> Option<Formula> {
    let mut stack: Vec<Part> = Vec::new();
    let law = Expression::new(text, 1.0).ok()?;
    for &op in law.operations() {
        let next = match op {
            Op::Number(x) => number(x),
            Op::Slip => named("u"),
            Op::Epsilon => named("epsilon"),
            Op::Parameter(i) => named(law.parameters()[i].name),
            Op::Negate => {
                let of = within(stack.pop()?, Bound::Product);
                let [plain, latex] =
                    [("−", of.plain), ("-", of.latex)].map(|(sign, of)| format!("{sign}{of}"));
                part(Bound::Negative, plain, format!("<mo>−</mo>{}", of.html), latex)
            }
            Op::PowerInteger(exponent) => {
                let plain = exponent.to_string().chars().map(raised).collect();
                power(stack.pop()?, plain, number(exponent.into()).set)
            }
            Op::SlipAtLeast(floor) => {
                let [of, floor] = [named("u").set, number(floor).set];
                let html = format!("<mi>max</mi><mo>(</mo>{}<mo>,</mo>{}<mo>)</mo>", of.html, floor.html);
                let latex = format!(r"\max\left({}, {}\right)", of.latex, floor.latex);
                part(Bound::Atom, format!("max({}, {})", of.plain, floor.plain), html, latex)
            }
            Op::Call(function) => call(function.name(), stack.pop()?.set),
            Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::Power => {
                let right = stack.pop()?;
                join(op, stack.pop()?, right)
            }
        };
        stack.push(next);
    }
    let (of, right) = (named(name).set, stack.pop()?.set);
    let slip = named("u").set;
    Some(Formula {
        plain: format!("{}(u) = {}", of.plain, right.plain),
        html: format!("{}<mo>(</mo>{}<mo>)</mo><mo>=</mo>{}", of.html, slip.html, right.html),
        latex: format!("{}({}) = {}", of.latex, slip.latex, right.latex),
    })
}

/// A part with parentheses, if it is bound more loosely than `least`.
fn within(part: Part, least: Bound) -> Formula {
    let Formula { plain, html, latex } = part.set;
    match part.bound >= least {
        true => Formula { plain, html, latex },
        false => Formula {
            plain: format!("({plain})"),
            html: format!("<mrow><mo>(</mo>{html}<mo>)</mo></mrow>"),
            latex: format!(r"\left({latex}\right)"),
        },
    }
}

fn named(name: &str) -> Part {
    let symbol = Symbol::of(name);
    let html = match symbol.index.as_str() {
        "" => format!("<mi>{}</mi>", symbol.base),
        index => format!("<msub><mi>{}</mi><mi>{index}</mi></msub>", symbol.base),
    };
    let latex = Rich::symbol(name).latex();
    part(Bound::Atom, format!("{}{}", symbol.base, symbol.index), html, latex.trim_matches('$').to_owned())
}

fn number(x: f64) -> Part {
    let atom = |text: &str| part(Bound::Atom, text.into(), format!("<mn>{text}</mn>"), text.into());
    if x == std::f64::consts::E {
        return named("e");
    }
    if x == std::f64::consts::PI {
        return part(Bound::Atom, "π".into(), "<mi>π</mi>".into(), r"\pi".into());
    }
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) {
        return atom(&format!("{x}"));
    }
    // The fewest digits that are the number.
    let text = format!("{x:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let raised: String = exponent.chars().map(raised).collect();
    let ten = format!("<msup><mn>10</mn><mn>{exponent}</mn></msup>");
    part(
        Bound::Product,
        format!("{mantissa} × 10{raised}"),
        format!("<mn>{mantissa}</mn><mo>×</mo>{ten}"),
        format!(r"{mantissa} \times 10^{{{exponent}}}"),
    )
}

/// A power; `exponent` in plain text is what follows the base.
fn power(base: Part, plain: String, exponent: Formula) -> Part {
    let base = within(base, Bound::Atom);
    part(
        Bound::Power,
        format!("{}{plain}", base.plain),
        format!("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", base.html, exponent.html),
        format!("{}^{{{}}}", base.latex, exponent.latex),
    )
}

fn call(function: &str, of: Formula) -> Part {
    let Formula { plain, html, latex } = of;
    match function {
        "sqrt" => {
            let (html, latex) = (format!("<msqrt>{html}</msqrt>"), format!(r"\sqrt{{{latex}}}"));
            part(Bound::Atom, format!("sqrt({plain})"), html, latex)
        }
        "abs" => {
            let html = format!("<mrow><mo>|</mo>{html}<mo>|</mo></mrow>");
            part(Bound::Atom, format!("|{plain}|"), html, format!(r"\left|{latex}\right|"))
        }
        _ => {
            let name = match function {
                "atan" => r"\arctan".to_owned(),
                "log10" => r"\log_{10}".to_owned(),
                "asinh" => r"\mathrm{arsinh}".to_owned(),
                name => format!(r"\{name}"),
            };
            let html = format!("<mi>{function}</mi><mo>(</mo>{html}<mo>)</mo>");
            part(Bound::Power, format!("{function}({plain})"), html, format!(r"{name}\left({latex}\right)"))
        }
    }
}

fn join(op: Op, left: Part, right: Part) -> Part {
    let begins_with_digit = right.set.plain.starts_with(|letter: char| letter.is_ascii_digit());
    // What binds the operands in plain text: a fraction in the other formats needs no parentheses.
    let plain = |of: &Part, least| match of.bound >= least {
        true => of.set.plain.clone(),
        false => format!("({})", of.set.plain),
    };
    let bound = if left.bound == Bound::Negative { Bound::Negative } else { Bound::Product };
    match op {
        Op::Power => {
            let exponent = match right.bound {
                Bound::Atom => format!("^{}", right.set.plain),
                _ => format!("^({})", right.set.plain),
            };
            power(left, exponent, right.set)
        }
        Op::Divide => {
            let text = format!("{} / {}", plain(&left, Bound::Negative), plain(&right, Bound::Power));
            let html =
                format!("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", left.set.html, right.set.html);
            part(bound, text, html, format!(r"\frac{{{}}}{{{}}}", left.set.latex, right.set.latex))
        }
        Op::Multiply => {
            let (left, right) = (within(left, Bound::Negative), within(right, Bound::Product));
            let [plain, html, latex] = match begins_with_digit {
                true => [" · ", "<mo>·</mo>", r" \cdot "],
                false => [" ", "<mo>\u{2062}</mo>", r"\, "],
            };
            let both = |left: &str, sign: &str, right: &str| format!("{left}{sign}{right}");
            part(
                bound,
                both(&left.plain, plain, &right.plain),
                both(&left.html, html, &right.html),
                both(&left.latex, latex, &right.latex),
            )
        }
        _ => {
            let left = left.set;
            let right = within(right, Bound::Product);
            let [sign, shown] = if op == Op::Subtract { ['-', '−'] } else { ['+'; 2] };
            part(
                Bound::Sum,
                format!("{} {shown} {}", left.plain, right.plain),
                format!("{}<mo>{shown}</mo>{}", left.html, right.html),
                format!("{} {sign} {}", left.latex, right.latex),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_machine::Motion;
    use slipmap_model::point::LawParameters;

    /// The formulas are those of the laws, and of machines.
    #[test]
    fn formulas_are_those_of_the_laws() {
        let values = [("mu_s", 0.4), ("mu_k", 0.25), ("v_s", 0.02), ("eta", 0.3), ("delta", 1.5)];
        for law in Law::BUILT_IN.into_iter().chain([Law::Stretched]) {
            let parameters = &[0.3, 0.2, 0.7, 1.5][..law.parameters().len()];
            let point = LawParameters::new(parameters);
            let (own, built_in) = (law.curve(0.1, &point), law.built_in().unwrap());
            let formula = Law::Expression(Expression::new(built_in.formula, 1.0).unwrap());
            let named = |name: &str| law.parameters().iter().position(|it| it.name == name).unwrap();
            let named = formula.parameters().iter().map(|it| parameters[named(it.name)]);
            let written = formula.curve(0.1, &LawParameters::new(&named.collect::<Vec<f64>>()));

            let numbers = [2.0, 800.0, 4.0, 50.0, 0.4, 0.25, 0.02, 0.3, 0.1];
            let mut machine = Machine::from_array(Motion::Translation, law.clone(), numbers);
            machine.set("exponent", 1.5);
            let model = machine.model().unwrap();
            let of_machine = Law::Expression(Expression::new(built_in.of_coefficients, 1.0).unwrap());
            let named = |name: &str| values.iter().find(|(known, _)| *known == name).unwrap().1;
            let named = of_machine.parameters().iter().map(|it| named(it.name));
            let in_si = of_machine.curve(1.0, &LawParameters::new(&named.collect::<Vec<f64>>()));
            for u in [0.01, 0.1, 0.5] {
                assert!((own.phi(u) - written.phi(u)).abs() < 1e-14, "{law:?}");
                let friction = 0.4 * model.column().curve.phi(u / model.si.velocity);
                assert!((friction - in_si.phi(u)).abs() < 1e-14, "{law:?}: {friction}");
            }
        }
    }

    #[test]
    fn formulas_are_set_with_the_parentheses_that_they_need() {
        let of = |text: &str| set("phi", text).unwrap();
        let stribeck = of_law(&Law::Stribeck).unwrap();
        assert_eq!(stribeck.plain, "φ(u) = (1 − α) / (1 + ε γ u) + α + ε β u²");
        assert_eq!(
            stribeck.latex,
            r"\varphi(u) = \frac{1 - \alpha}{1 + \varepsilon\, \gamma\, u} + \alpha + \varepsilon\, \beta\, u^{2}"
        );
        for (text, plain) in [
            ("mu - (1 + mu)", "μ − (1 + μ)"),
            ("mu/(vs*u)", "μ / (vs u)"),
            ("exp(-(u/v_s)^delta)", "exp(−(u / vs)^δ)"),
            ("1 - -u/vs", "1 − (−u / vs)"),
            ("-u*mu + (mu + 1)*u", "−u μ + (μ + 1) u"),
            ("1e-7*2*u", "1 × 10⁻⁷ · 2 u"),
            ("(-u)^2 + u^(1 + mu)", "(−u)² + u^(1 + μ)"),
            ("sqrt(abs(u - 1))^3", "sqrt(|u − 1|)³"),
        ] {
            assert_eq!(of(text).plain, format!("φ(u) = {plain}"), "{text}");
        }
        let math = |formula: &Formula| format!("<math>{}</math>", formula.html);
        assert!(roxmltree::Document::parse(&math(&stribeck)).is_ok(), "{}", stribeck.html);
    }
}
