//! The quantity that a picture shows.

use super::catalogue::differences;
use slipmap_column::{Method, Verdict};
use slipmap_page::palette::{self, CellKind};

#[derive(Clone, Debug)]
pub(super) enum Show {
    Variable(String),
    /// The difference of the verdicts of two methods, by their names.
    Difference([&'static str; 2]),
    /// The first method in the order of the plan that decides.
    Decider,
}

impl Show {
    /// Meanings of the codes of a picture; `None` for numbers.
    pub(super) fn kinds(&self, methods: &[Method]) -> Option<Vec<CellKind>> {
        match self {
            Show::Variable(name) => palette::kinds(name),
            Show::Difference([a, b]) => Some(differences(a, b)),
            Show::Decider => Some(palette::deciders(methods)),
        }
    }

    /// The code of a cell with these verdicts.
    pub(super) fn derived(&self, methods: &[Method], codes: &[i8]) -> i8 {
        match self {
            Show::Difference(pair) => {
                // Plans sort methods.
                let of = |name: &str| methods.iter().position(|method| method.name() == name).unwrap_or(0);
                let [a, b] = pair.map(|name| codes[of(name)]);
                difference(a, b)
            }
            Show::Decider | Show::Variable(_) => palette::decider(codes.iter().copied()),
        }
    }
}

/// The code of [`differences`] for the verdicts of two methods.
fn difference(a: i8, b: i8) -> i8 {
    const PRESENT: i8 = Verdict::Present as i8;
    const ABSENT: i8 = Verdict::Absent as i8;
    const UNDECIDED: i8 = Verdict::Undecided as i8;
    match (a, b) {
        (PRESENT, PRESENT) => 0,
        (ABSENT, ABSENT) => 1,
        (PRESENT, ABSENT) => 2,
        (ABSENT, PRESENT) => 3,
        (UNDECIDED, PRESENT | ABSENT | UNDECIDED) | (PRESENT | ABSENT, UNDECIDED) => 4,
        _ => 5,
    }
}
