//! Columns of tables.

use super::Value;

/// The numbers or words of a series.
#[derive(Clone, Debug, PartialEq)]
pub enum Contents {
    /// Real numbers; NaN for missing values.
    Reals(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i32>),
    /// Words without blanks, stored as their positions in `flag_meanings`.
    Words(Vec<String>),
}

/// One column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Along which it lies.
    pub dimension: &'static str,
    /// Its name.
    pub name: String,
    long_name: String,
    units: String,
    contents: Contents,
}

impl Series {
    /// A column along `dimension`.
    pub fn new(dimension: &'static str, name: &str, long_name: &str, contents: Contents) -> Self {
        Self { dimension, name: name.into(), long_name: long_name.into(), units: "1".into(), contents }
    }

    /// The column with its numbers in this unit.
    #[must_use]
    pub fn in_unit(self, units: &str) -> Self {
        Self { units: units.into(), ..self }
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match &self.contents {
            Contents::Reals(values) => values.len(),
            Contents::Integers(values) => values.len(),
            Contents::Words(values) => values.len(),
        }
    }

    /// The column as it is stored, and its attributes: words are codes with meanings.
    pub fn stored(&self) -> (Stored<'_>, Vec<(&'static str, Value)>) {
        let mut attributes = Vec::new();
        let stored = match &self.contents {
            Contents::Reals(values) => Stored::Reals(values),
            Contents::Integers(values) => Stored::Integers(values),
            Contents::Words(words) => {
                let mut meanings: Vec<&String> = Vec::new();
                let code = |word| {
                    let known = meanings.iter().position(|meaning| *meaning == word);
                    let code = known.unwrap_or_else(|| {
                        meanings.push(word);
                        meanings.len() - 1
                    });
                    i8::try_from(code).unwrap_or(i8::MAX)
                };
                let codes: Vec<i8> = words.iter().map(code).collect();
                let flags = (0..meanings.len()).map(|code| i8::try_from(code).unwrap_or(i8::MAX)).collect();
                let meanings: Vec<&str> = meanings.into_iter().map(String::as_str).collect();
                attributes.push(("flag_values", Value::Codes(flags)));
                attributes.push(("flag_meanings", meanings.join(" ").into()));
                Stored::Codes(codes)
            }
        };
        attributes.push(("long_name", self.long_name.as_str().into()));
        attributes.push(("units", self.units.as_str().into()));
        (stored, attributes)
    }
}

/// The numbers of a column as they are stored.
pub enum Stored<'a> {
    /// Real numbers.
    Reals(&'a [f64]),
    /// Whole numbers.
    Integers(&'a [i32]),
    /// Codes of words.
    Codes(Vec<i8>),
}
