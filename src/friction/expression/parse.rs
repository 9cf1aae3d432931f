//! From the text of a formula to a tape of operations in reverse Polish order.
//!
//! The grammar is that of pencil and paper: `+ - * / ^`, parentheses, functions, numbers such as 1.5e-3;
//! powers bind tighter than signs (-u^2 is -(u^2)) and to the right. Errors carry the place in the text.

use super::ExpressionError;

/// Depth of the stack that evaluation may use.
pub(super) const DEEPEST: usize = 24;

/// The functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Exp,
    Ln,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    Atan,
    Abs,
}

impl Function {
    const ALL: [(&'static str, Function); 12] = [
        ("exp", Function::Exp),
        ("ln", Function::Ln),
        ("log", Function::Ln),
        ("sqrt", Function::Sqrt),
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("sinh", Function::Sinh),
        ("cosh", Function::Cosh),
        ("tanh", Function::Tanh),
        ("atan", Function::Atan),
        ("abs", Function::Abs),
    ];

    /// The names of all functions.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        Self::ALL.iter().map(|(name, _)| *name)
    }

    fn by_name(name: &str) -> Option<Function> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }
}

/// One operation of the tape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    Number(f64),
    /// The slip speed.
    Slip,
    Epsilon,
    /// A named parameter, by its position.
    Parameter(usize),
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    /// An integer power.
    PowerInteger(i32),
    /// Any other power.
    Power,
    Call(Function),
}

/// A stretch of the text, in characters from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) from: usize,
    pub(super) to: usize,
}

/// A parsed formula.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tape {
    pub(super) ops: Vec<Op>,
    /// Where each operation stands in the text.
    pub(super) places: Vec<Place>,
    /// Named parameters with where they first stand, in order of appearance.
    pub(super) parameters: Vec<(String, Place)>,
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Sign(char),
}

/// Parses a formula.
pub(super) fn parse(text: &str) -> Result<Tape, ExpressionError> {
    let tokens = tokens(text)?;
    let end = text.chars().count();
    let mut parser = Parser {
        tokens,
        next: 0,
        end,
        depth: 0,
        tape: Tape { ops: Vec::new(), places: Vec::new(), parameters: Vec::new() },
    };
    parser.sum()?;
    if let Some((token, place)) = parser.tokens.get(parser.next) {
        let problem = match token {
            Token::Sign(')') => "this parenthesis closes nothing".to_owned(),
            Token::Sign(',') => "functions take one argument".to_owned(),
            _ => "an operator such as * is missing before this".to_owned(),
        };
        return Err(error(*place, problem, "mend the formula"));
    }
    let depth = parser.tape.deepest();
    if depth > DEEPEST {
        let place = Place { from: 0, to: end };
        let problem = format!("the formula nests {depth} deep, more than {DEEPEST}");
        return Err(error(place, problem, "write it with fewer open parentheses"));
    }
    Ok(parser.tape)
}

fn error(place: Place, problem: String, remedy: &str) -> ExpressionError {
    ExpressionError { from: place.from, to: place.to, problem, remedy: remedy.to_owned() }
}

/// Splits the text.
fn tokens(text: &str) -> Result<Vec<(Token, Place)>, ExpressionError> {
    let letters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < letters.len() {
        let from = i;
        let letter = letters[i];
        if letter.is_whitespace() {
            i += 1;
            continue;
        }
        let token = if letter.is_ascii_digit() || letter == '.' {
            let digit = |i: usize| letters.get(i).is_some_and(char::is_ascii_digit);
            while digit(i) || letters.get(i) == Some(&'.') {
                i += 1;
            }
            if matches!(letters.get(i), Some('e' | 'E')) {
                let signed = matches!(letters.get(i + 1), Some('+' | '-'));
                if digit(i + 1) || (signed && digit(i + 2)) {
                    i += if signed { 2 } else { 1 };
                    while digit(i) {
                        i += 1;
                    }
                }
            }
            let word: String = letters[from..i].iter().collect();
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            Token::Number(number.ok_or_else(|| {
                error(
                    Place { from, to: i },
                    format!("`{word}` is not a number"),
                    "write for example 0.5 or 1e-3",
                )
            })?)
        } else if letter.is_ascii_alphabetic() || letter == '_' {
            while letters.get(i).is_some_and(|c| c.is_ascii_alphanumeric() || *c == '_') {
                i += 1;
            }
            Token::Name(letters[from..i].iter().collect())
        } else if "+-*/^(),".contains(letter) {
            i += 1;
            if letter == '*' && letters.get(i) == Some(&'*') {
                i += 1;
                Token::Sign('^')
            } else {
                Token::Sign(letter)
            }
        } else if letter == '|' {
            let place = Place { from, to: i + 1 };
            return Err(error(place, "`|` is not known".into(), "write the absolute value as abs(...)"));
        } else {
            let place = Place { from, to: i + 1 };
            let known = "use numbers, names, + - * / ^ ( ) and functions";
            return Err(error(place, format!("`{letter}` is not known"), known));
        };
        tokens.push((token, Place { from, to: i }));
    }
    Ok(tokens)
}

struct Parser {
    tokens: Vec<(Token, Place)>,
    next: usize,
    end: usize,
    /// Nesting of the grammar, limited so that a hostile text cannot overflow the machine's stack.
    depth: usize,
    tape: Tape,
}

impl Parser {
    fn sign(&self) -> Option<char> {
        match self.tokens.get(self.next) {
            Some((Token::Sign(sign), _)) => Some(*sign),
            _ => None,
        }
    }

    /// The place of the next token, or the end of the text.
    fn place(&self) -> Place {
        let end = Place { from: self.end, to: self.end + 1 };
        self.tokens.get(self.next).map_or(end, |(_, place)| *place)
    }

    fn push(&mut self, op: Op, place: Place) {
        self.tape.ops.push(op);
        self.tape.places.push(place);
    }

    /// term { + term | - term }
    fn sum(&mut self) -> Result<Place, ExpressionError> {
        self.depth += 1;
        if self.depth > 200 {
            return Err(error(self.place(), "the formula nests too deep here".into(), "simplify it"));
        }
        let mut whole = self.term()?;
        while let Some(sign @ ('+' | '-')) = self.sign() {
            self.next += 1;
            let right = self.term()?;
            whole.to = right.to;
            self.push(if sign == '+' { Op::Add } else { Op::Subtract }, whole);
        }
        self.depth -= 1;
        Ok(whole)
    }

    /// signed { * signed | / signed }
    fn term(&mut self) -> Result<Place, ExpressionError> {
        let mut whole = self.signed()?;
        while let Some(sign @ ('*' | '/')) = self.sign() {
            self.next += 1;
            let right = self.signed()?;
            whole.to = right.to;
            // What can go wrong with a quotient is its denominator.
            if sign == '*' { self.push(Op::Multiply, whole) } else { self.push(Op::Divide, right) }
        }
        Ok(whole)
    }

    /// { + | - } power
    fn signed(&mut self) -> Result<Place, ExpressionError> {
        match self.sign() {
            Some(sign @ ('+' | '-')) => {
                let from = self.place().from;
                self.next += 1;
                self.depth += 1;
                if self.depth > 200 {
                    return Err(error(self.place(), "too many signs".into(), "simplify the formula"));
                }
                let Place { to, .. } = self.signed()?;
                self.depth -= 1;
                let whole = Place { from, to };
                if sign == '-' {
                    self.push(Op::Negate, whole);
                }
                Ok(whole)
            }
            _ => self.power(),
        }
    }

    /// atom [ ^ signed ]
    fn power(&mut self) -> Result<Place, ExpressionError> {
        let mut whole = self.atom()?;
        if self.sign() == Some('^') {
            let base = whole;
            self.next += 1;
            let start = self.tape.ops.len();
            let right = self.signed()?;
            whole.to = right.to;
            let integer = match self.tape.ops[start..] {
                [Op::Number(x)] => Some(x),
                [Op::Number(x), Op::Negate] => Some(-x),
                _ => None,
            };
            match integer.filter(|x| x.fract() == 0.0 && x.abs() <= 64.0) {
                Some(x) => {
                    self.tape.ops.truncate(start);
                    self.tape.places.truncate(start);
                    self.push(Op::PowerInteger(x as i32), base);
                }
                None => self.push(Op::Power, base),
            }
        }
        Ok(whole)
    }

    fn atom(&mut self) -> Result<Place, ExpressionError> {
        let place = self.place();
        let Some((token, _)) = self.tokens.get(self.next).cloned() else {
            return Err(error(place, "the formula ends where a value is expected".into(), "complete it"));
        };
        self.next += 1;
        match token {
            Token::Number(x) => self.push(Op::Number(x), place),
            Token::Sign('(') => {
                self.sum()?;
                let to = self.close(place)?;
                return Ok(Place { from: place.from, to });
            }
            Token::Sign(sign) => {
                return Err(error(
                    place,
                    format!("a value is expected here, not `{sign}`"),
                    "mend the formula",
                ));
            }
            Token::Name(name) if self.sign() == Some('(') => {
                let Some(function) = Function::by_name(&name) else {
                    let known: Vec<_> = Function::names().collect();
                    let remedy = format!("the functions are {}; products need a *", known.join(", "));
                    return Err(error(place, format!("there is no function `{name}`"), &remedy));
                };
                let open = self.place();
                self.next += 1;
                self.sum()?;
                let to = self.close(open)?;
                let whole = Place { from: place.from, to };
                self.push(Op::Call(function), whole);
                return Ok(whole);
            }
            Token::Name(name) => match name.as_str() {
                "u" => self.push(Op::Slip, place),
                "eps" | "epsilon" => self.push(Op::Epsilon, place),
                "pi" => self.push(Op::Number(std::f64::consts::PI), place),
                "V" | "c" => {
                    let problem = format!("`{name}` is an axis of every map and no part of a friction law");
                    return Err(error(place, problem, "choose another name"));
                }
                _ if Function::by_name(&name).is_some() => {
                    let problem = format!("the function `{name}` needs its argument");
                    return Err(error(place, problem, "write it in parentheses"));
                }
                _ => {
                    let known = self.tape.parameters.iter().position(|(known, _)| *known == name);
                    let position = known.unwrap_or_else(|| {
                        self.tape.parameters.push((name, place));
                        self.tape.parameters.len() - 1
                    });
                    self.push(Op::Parameter(position), place);
                }
            },
        }
        Ok(place)
    }

    /// Takes the closing parenthesis and returns where it ends.
    fn close(&mut self, open: Place) -> Result<usize, ExpressionError> {
        match self.tokens.get(self.next) {
            Some((Token::Sign(')'), place)) => {
                self.next += 1;
                Ok(place.to)
            }
            None => Err(error(open, "this parenthesis is never closed".into(), "close it")),
            Some((Token::Sign(','), place)) => {
                Err(error(*place, "functions take one argument".into(), "mend the formula"))
            }
            Some((_, place)) => {
                Err(error(*place, "an operator or `)` is expected here".into(), "products need a *"))
            }
        }
    }
}

impl Tape {
    /// The largest number of values on the stack.
    fn deepest(&self) -> usize {
        let (mut depth, mut most) = (0_usize, 0);
        for op in &self.ops {
            match op {
                Op::Number(_) | Op::Slip | Op::Epsilon | Op::Parameter(_) => depth += 1,
                Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::Power => depth -= 1,
                Op::Negate | Op::PowerInteger(_) | Op::Call(_) => {}
            }
            most = most.max(depth);
        }
        most
    }
}
