//! Columns of tables.

use super::Value;

/// The numbers of a column as they are stored.
#[derive(Clone, Debug, PartialEq)]
pub enum Contents {
    /// Real numbers; NaN for missing values.
    Reals(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i32>),
    /// Codes of words: their positions in `flag_meanings`.
    Codes(Vec<i8>),
}

/// One column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Along which it lies.
    pub dimension: &'static str,
    /// Its name.
    pub name: String,
    /// Its numbers.
    pub contents: Contents,
    /// What describes them.
    pub attributes: Vec<(&'static str, Value)>,
}

impl Series {
    /// A column along `dimension` with its numbers in this unit.
    pub fn new(
        dimension: &'static str,
        name: &str,
        long_name: &str,
        units: &str,
        contents: Contents,
    ) -> Self {
        let attributes = vec![("long_name", long_name.into()), ("units", units.into())];
        Self { dimension, name: name.into(), contents, attributes }
    }

    /// A column of words without blanks: their codes, with their meanings.
    pub fn of_words(dimension: &'static str, name: &str, long_name: &str, words: &[&str]) -> Self {
        let mut meanings: Vec<&str> = Vec::new();
        let of_position = |position| i8::try_from(position).unwrap_or(i8::MAX);
        let mut codes = Vec::new();
        for word in words {
            if !meanings.contains(word) {
                meanings.push(word);
            }
            codes.push(of_position(meanings.iter().position(|meaning| meaning == word).unwrap_or(0)));
        }
        let flags = Value::Codes((0..meanings.len()).map(of_position).collect());
        let mut series = Self::new(dimension, name, long_name, "1", Contents::Codes(codes));
        series
            .attributes
            .splice(0..0, [("flag_values", flags), ("flag_meanings", meanings.join(" ").into())]);
        series
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match &self.contents {
            Contents::Reals(values) => values.len(),
            Contents::Integers(values) => values.len(),
            Contents::Codes(codes) => codes.len(),
        }
    }
}
