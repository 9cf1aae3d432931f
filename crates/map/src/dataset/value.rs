//! Attributes: named texts and numbers attached to a map and to its variables.

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Value {
    /// A text. Empty texts are not stored.
    Text(String),
    /// One or more integers.
    Integers(Vec<i64>),
    /// One or more codes of a variable of codes (`flag_values`).
    Codes(Vec<i8>),
    /// One or more real numbers.
    Reals(Vec<f64>),
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Value::Text(text.into())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Value::Text(text)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Value::Integers(vec![number])
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Value::Reals(vec![number])
    }
}

/// The name of an SI unit as readers of the CF conventions know it; 1 for a pure number.
pub fn si_name(unit: &str) -> String {
    if unit.is_empty() { "1".into() } else { unit.replace('²', "2") }
}
