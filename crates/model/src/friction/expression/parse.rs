//! From the text of a formula to a tape of operations in reverse Polish order, with the parser crate
//! `winnow`.
//!
//! The grammar is the usual one: `+ - * / ^`, parentheses, functions, numbers such as 1.5e-3; powers bind
//! tighter than signs (-u^2 is -(u^2)) and to the right; e^x is exp(x). The slip speed is u or v. An operation is appended to the tape as soon as its
//! operands are on the tape. Errors contain their place in the text.

use std::f64::consts::E;

use winnow::combinator::{Infix, Prefix, alt, expression, opt, preceded};
use winnow::error::ParserError;
use winnow::stream::{LocatingSlice, Location, Stateful, Stream};
use winnow::token::{any, one_of, take_while};
use winnow::{Parser, Result};

use super::ExpressionError;
use slipmap_numbers::named;

/// Largest depth of the stack of an evaluation.
pub(super) const DEEPEST: usize = 24;
/// Largest number of signs and parentheses inside one another: each is one level of the parser's recursion.
const DEEPEST_NESTING: usize = 100;

/// Binding strengths of operators.
const SUM: i64 = 10;
const PRODUCT: i64 = 20;
const SIGN: i64 = 30;
const POWER: i64 = 40;

named! {
    /// The functions of one argument; `ln` is also called `log`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Function {
        Exp => "exp",
        Ln => "ln",
        Sqrt => "sqrt",
        Sin => "sin",
        Cos => "cos",
        Tan => "tan",
        Sinh => "sinh",
        Cosh => "cosh",
        Tanh => "tanh",
        Atan => "atan",
        Asinh => "asinh",
        Log10 => "log10",
        Abs => "abs",
        /// Of the slip speed alone, which is positive.
        Sign => "sign",
    }
}

/// An operation of a formula in reverse Polish order: a value, or what is made of the last values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// A number.
    Number(f64),
    /// The slip speed.
    Slip,
    /// The larger one of the slip speed and this number.
    SlipAtLeast(f64),
    /// The parameter eps.
    Epsilon,
    /// A named parameter, by its position.
    Parameter(usize),
    /// The sum of the last two values.
    Add,
    /// Their difference.
    Subtract,
    /// Their product.
    Multiply,
    /// Their quotient.
    Divide,
    /// The negative of the last value.
    Negate,
    /// Its power with this exponent.
    PowerInteger(i32),
    /// Any other power, of the last two values.
    Power,
    /// A function of the last value.
    Call(Function),
}

/// A range of the text, in characters from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) from: usize,
    pub(super) to: usize,
}

impl Place {
    /// An error there.
    pub(super) fn error(self, problem: String, remedy: &str) -> ExpressionError {
        ExpressionError { from: self.from, to: self.to, problem, remedy: remedy.to_owned() }
    }
}

/// A parsed formula.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tape {
    pub(super) ops: Vec<Op>,
    /// For each operation the place in the text at which its errors are reported.
    pub(super) places: Vec<Place>,
    /// Named parameters with the place of their first occurrence, in order of appearance.
    pub(super) parameters: Vec<(String, Place)>,
}

/// The rest of the text, and the tape parsed from the text before it.
type Input<'a> = Stateful<LocatingSlice<&'a [char]>, State>;

#[derive(Debug)]
struct State {
    tape: Tape,
    /// Number of values on the stack.
    waiting: usize,
    /// Places of the signs and parentheses around the text that is being parsed.
    around: Vec<usize>,
    /// The name of the slip speed, where the text has one already.
    slip: Option<String>,
}

/// Reason why a parser stops.
#[derive(Debug)]
enum Stop {
    /// The text here is not what this parser accepts; another parser may accept it.
    NotHere,
    /// The formula is wrong.
    Wrong(ExpressionError),
}

impl Tape {
    /// Slip speeds > 0, increasing, at which the slope of the weakening rate jumps, where the slip speed of the formula is
    /// in this unit.
    pub(super) fn corners(&self, unit: f64) -> Option<Vec<f64>> {
        let corner = |op: &Op| match op {
            Op::SlipAtLeast(floor) => Some(floor / unit),
            _ => None,
        };
        let mut corners: Vec<f64> = self.ops.iter().filter_map(corner).collect();
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        (!corners.is_empty()).then_some(corners)
    }
}

impl ParserError<Input<'_>> for Stop {
    type Inner = Self;

    fn from_input(_: &Input) -> Self {
        Stop::NotHere
    }

    fn is_backtrack(&self) -> bool {
        matches!(self, Stop::NotHere)
    }

    fn into_inner(self) -> Result<Self, Self> {
        Ok(self)
    }
}

pub(super) fn parse(text: &str) -> Result<Tape, ExpressionError> {
    let letters: Vec<char> = text.chars().collect();
    let tape = Tape { ops: Vec::new(), places: Vec::new(), parameters: Vec::new() };
    let state = State { tape, waiting: 0, around: Vec::new(), slip: None };
    let mut input = Stateful { input: LocatingSlice::new(letters.as_slice()), state };
    match sum(&mut input).and_then(|_| end(&mut input)) {
        Ok(()) => Ok(input.state.tape),
        Err(Stop::Wrong(error)) => Err(error),
        Err(Stop::NotHere) => unreachable!("only signs are refused as operands, and they are read before"),
    }
}

fn wrong<T>(place: Place, problem: String, remedy: &str) -> Result<T, Stop> {
    Err(Stop::Wrong(place.error(problem, remedy)))
}

/// A token: a name, a number, `**`, or any other character.
fn token<'a>(input: &mut Input<'a>) -> Result<(&'a [char], Place), Stop> {
    let digits = || take_while(1.., |letter: char| letter.is_ascii_digit());
    let in_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let in_number = |letter: char| letter.is_ascii_digit() || letter == '.';
    let exponent = (one_of(['e', 'E']), opt(one_of(['+', '-'])), digits());
    let number = (take_while(1.., in_number), opt(exponent)).void();
    let name = take_while(1.., in_name).void();
    let power = (one_of('*'), one_of('*')).void();
    let token = alt((number, name, power, any.void())).take().with_span();
    let (token, span) = preceded(take_while(0.., char::is_whitespace), token).parse_next(input)?;
    Ok((token, Place { from: span.start, to: span.end }))
}

/// Operands joined by operators.
fn sum(input: &mut Input) -> Result<Place, Stop> {
    expression(operand).prefix(sign).infix(operator).parse_next(input)
}

fn sign<'a>(input: &mut Input<'a>) -> Result<Prefix<Input<'a>, Place, Stop>, Stop> {
    let (sign, place) = token(input)?;
    let prefix = match sign {
        ['+'] => Prefix(SIGN, |input, of| Ok(Place { from: leave(input), ..of })),
        ['-'] => Prefix(SIGN, |input, of| {
            let whole = Place { from: leave(input), ..of };
            push(input, Op::Negate, whole);
            Ok(whole)
        }),
        _ => return Err(Stop::NotHere),
    };
    enter(input, place)?;
    Ok(prefix)
}

fn operator<'a>(input: &mut Input<'a>) -> Result<Infix<Input<'a>, Place, Stop>, Stop> {
    Ok(match token(input)?.0 {
        ['+'] => Infix::Left(SUM, |input, left, right| Ok(join(input, Op::Add, left, right))),
        ['-'] => Infix::Left(SUM, |input, left, right| Ok(join(input, Op::Subtract, left, right))),
        ['*'] => Infix::Left(PRODUCT, |input, left, right| Ok(join(input, Op::Multiply, left, right))),
        ['/'] => Infix::Left(PRODUCT, |input, left, right| Ok(join(input, Op::Divide, left, right))),
        ['^'] | ['*', '*'] => {
            Infix::Right(POWER, |input, left, right| Ok(join(input, Op::Power, left, right)))
        }
        _ => return Err(Stop::NotHere),
    })
}

fn operand(input: &mut Input) -> Result<Place, Stop> {
    let Some((word, place)) = opt(token).parse_next(input)? else {
        return wrong(after(input), "the formula ends where a value is expected".into(), "complete it");
    };
    match word {
        ['+' | '-'] => Err(Stop::NotHere),
        ['('] => parenthesis(input, place),
        ['0'..='9' | '.', ..] => {
            let digits: String = word.iter().collect();
            match digits.parse::<f64>().ok().filter(|x| x.is_finite()) {
                Some(x) => value(input, Op::Number(x), place),
                None => wrong(place, format!("`{digits}` is not a number"), "write for example 0.5 or 1e-3"),
            }
        }
        ['a'..='z' | 'A'..='Z' | '_', ..] => name(input, word.iter().collect(), place),
        ['*' | '/' | '^' | ')' | ',', ..] => {
            let problem = format!("a value is expected here, not `{}`", word[0]);
            wrong(place, problem, "correct the formula")
        }
        _ => unknown(word, place),
    }
}

/// A parameter, a constant, or a function with its argument.
fn name(input: &mut Input, name: String, place: Place) -> Result<Place, Stop> {
    let bracket = |input: &mut Input| match token(input)? {
        (['('], place) => Ok(place),
        _ => Err(Stop::NotHere),
    };
    let called = if name == "log" { "ln" } else { &name };
    let function = Function::ALL.into_iter().find(|function| function.name() == called);
    if let Some(bracket) = opt(bracket).parse_next(input)? {
        let Some(function) = function else {
            let known = Function::ALL.map(Function::name);
            let remedy = match name.as_str() {
                "max" => return at_least(input, bracket, place),
                "min" => {
                    "it has a kink, where D would jump: give the law as a table with a row there".to_owned()
                }
                _ => {
                    format!("the functions are {}; log is ln; products need a *", known.join(", "))
                }
            };
            return wrong(place, format!("there is no function `{name}`"), &remedy);
        };
        let before = input.state.tape.ops.len();
        let argument = parenthesis(input, bracket)?;
        let whole = Place { from: place.from, ..argument };
        let of_slip = matches!(input.state.tape.ops[before..], [Op::Slip | Op::SlipAtLeast(_)]);
        match function {
            // The slip speed is positive.
            Function::Abs if of_slip => return Ok(whole),
            Function::Sign if of_slip => {
                input.state.tape.ops[before] = Op::Number(1.0);
                return Ok(whole);
            }
            Function::Sign => {
                let remedy = "friction is that of one direction of slip, u > 0: leave it out";
                return wrong(whole, "a sign jumps".into(), remedy);
            }
            _ => {}
        }
        push(input, Op::Call(function), whole);
        return Ok(whole);
    }
    let op = match name.as_str() {
        "u" | "v" => {
            if *input.state.slip.get_or_insert(name.clone()) != name {
                let problem = "u and v are both names of the slip speed".into();
                return wrong(place, problem, "write u everywhere, and give a parameter another name");
            }
            Op::Slip
        }
        "e" => Op::Number(E),
        "eps" | "epsilon" => Op::Epsilon,
        "pi" => Op::Number(std::f64::consts::PI),
        "V" | "c" => {
            let problem = format!("`{name}` is an axis of every map and not part of a friction law");
            return wrong(place, problem, "choose another name");
        }
        _ if function.is_some() => {
            let problem = format!("the function `{name}` needs its argument");
            return wrong(place, problem, "write it in parentheses");
        }
        _ => {
            let parameters = &mut input.state.tape.parameters;
            let known = parameters.iter().position(|(known, _)| *known == name);
            Op::Parameter(known.unwrap_or_else(|| {
                parameters.push((name, place));
                parameters.len() - 1
            }))
        }
    };
    value(input, op, place)
}

/// Parses the rest of `max(u, number)`, whose parenthesis was opened at `bracket`: friction that is constant at slip speeds
/// up to that number. In other units the slip speed is written `(unit*u)`.
fn at_least(input: &mut Input, bracket: Place, place: Place) -> Result<Place, Stop> {
    let before = input.state.tape.ops.len();
    enter(input, bracket)?;
    let argument = sum(input)?;
    let comma = opt(token).parse_next(input)?;
    let floor = opt(token).parse_next(input)?;
    let floor = floor.and_then(|(word, _)| word.iter().collect::<String>().parse::<f64>().ok());
    let end = opt(token).parse_next(input)?;
    let unit = match input.state.tape.ops[before..] {
        [Op::Slip] => 1.0,
        [Op::Number(unit), Op::Slip, Op::Multiply] => unit,
        _ => f64::NAN,
    };
    let floor = floor.map(|floor| floor / unit).filter(|floor| *floor > 0.0 && floor.is_finite());
    let (Some(([','], _)), Some(floor), Some(([')'], Place { to, .. }))) = (comma, floor, end) else {
        let problem = "max is that of the slip speed and a number greater than 0".into();
        return wrong(Place { from: place.from, ..argument }, problem, "write for example max(u, 0.1)");
    };
    leave(input);
    let whole = Place { from: place.from, to };
    let tape = &mut input.state.tape;
    let parts = tape.ops[before..].iter_mut().zip(&mut tape.places[before..]);
    for (op, place) in parts.filter(|(op, _)| **op == Op::Slip) {
        (*op, *place) = (Op::SlipAtLeast(floor), whole);
    }
    Ok(whole)
}

/// Parses the rest of the parenthesis opened at `bracket`, up to its end.
fn parenthesis(input: &mut Input, bracket: Place) -> Result<Place, Stop> {
    enter(input, bracket)?;
    sum(input)?;
    match opt(token).parse_next(input)? {
        Some(([')'], Place { to, .. })) => Ok(Place { from: leave(input), to }),
        Some(([','], place)) => wrong(place, COMMA.into(), DECIMAL),
        Some((word, place)) if begins_operand(word) => {
            wrong(place, "an operator or `)` is expected here".into(), "products need a *")
        }
        Some((word, place)) => unknown(word, place),
        None => wrong(bracket, "this parenthesis is never closed".into(), "close it"),
    }
}

/// What is wrong with a comma, and the remedy.
const COMMA: &str = "functions take one argument, and decimals a point";
const DECIMAL: &str = "write for example 0.5, not 0,5";

/// The end of the formula.
fn end(input: &mut Input) -> Result<(), Stop> {
    let Some((word, place)) = opt(token).parse_next(input)? else { return Ok(()) };
    let problem = match word {
        [')'] => "this parenthesis closes nothing",
        [','] => return wrong(place, COMMA.into(), DECIMAL),
        _ if begins_operand(word) => "an operator such as * is missing before this",
        _ => return unknown(word, place),
    };
    wrong(place, problem.to_owned(), "correct the formula")
}

fn begins_operand(word: &[char]) -> bool {
    matches!(word, [first, ..] if first.is_ascii_alphanumeric() || ['.', '_', '('].contains(first))
}

fn unknown<T>(word: &[char], place: Place) -> Result<T, Stop> {
    match word {
        ['|'] => wrong(place, "`|` is not known".into(), "write the absolute value as abs(...)"),
        _ => {
            let word: String = word.iter().collect();
            wrong(place, format!("`{word}` is not known"), "use numbers, names, + - * / ^ ( ) and functions")
        }
    }
}

/// The place after the last character.
fn after(input: &Input) -> Place {
    let from = input.current_token_start() + input.eof_offset();
    Place { from, to: from + 1 }
}

/// Enters a sign or parenthesis.
fn enter(input: &mut Input, place: Place) -> Result<(), Stop> {
    if input.state.around.len() == DEEPEST_NESTING {
        return wrong(place, "the formula nests too deep here".into(), "simplify it");
    }
    input.state.around.push(place.from);
    Ok(())
}

/// Leaves the innermost sign or parenthesis; returns its place.
fn leave(input: &mut Input) -> usize {
    input.state.around.pop().unwrap_or_default()
}

/// Appends an operation that pushes a value.
fn value(input: &mut Input, op: Op, place: Place) -> Result<Place, Stop> {
    input.state.waiting += 1;
    if input.state.waiting > DEEPEST {
        let problem = format!("more than {DEEPEST} values wait here for their operators");
        return wrong(place, problem, "write it with fewer open parentheses");
    }
    push(input, op, place);
    Ok(place)
}

/// Whether a power is computed by products, so that its base may be negative.
pub(super) fn is_integer(exponent: f64) -> bool {
    exponent.fract() == 0.0 && exponent.abs() <= 64.0
}

/// Appends an operation of two values; returns its place in the text. Errors of a quotient are reported at
/// its denominator, those of a power at its base. A power of e is an exponential function.
fn join(input: &mut Input, op: Op, left: Place, right: Place) -> Place {
    input.state.waiting -= 1;
    let whole = Place { from: left.from, to: right.to };
    let ops = &mut input.state.tape.ops;
    let is_base = |(op, place): (&Op, &Place)| *op == Op::Number(E) && *place == left;
    let base = ops.iter().zip(&input.state.tape.places).position(is_base).filter(|_| op == Op::Power);
    if let Some(base) = base {
        ops.remove(base);
        input.state.tape.places.remove(base);
        push(input, Op::Call(Function::Exp), whole);
        return whole;
    }
    let (exponent, length) = match ops[..] {
        [.., Op::Number(x)] => (Some(x), 1),
        [.., Op::Number(x), Op::Negate] => (Some(-x), 2),
        _ => (None, 0),
    };
    match (op, exponent.filter(|x| is_integer(*x))) {
        (Op::Power, Some(exponent)) => {
            let rest = ops.len() - length;
            ops.truncate(rest);
            input.state.tape.places.truncate(rest);
            push(input, Op::PowerInteger(exponent as i32), left);
        }
        (Op::Power, None) => push(input, op, left),
        (Op::Divide, _) => push(input, op, right),
        _ => push(input, op, whole),
    }
    whole
}

/// Appends an operation whose errors are reported at `blamed`.
fn push(input: &mut Input, op: Op, blamed: Place) {
    input.state.tape.ops.push(op);
    input.state.tape.places.push(blamed);
}
