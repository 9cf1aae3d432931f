//! The numbers behind a figure, as a table in CSV.

use slipmap_files::csv::csv_text;

/// A column of numbers or words.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real numbers; one that is not finite is an empty cell.
    Reals(Vec<f64>),
    Words(Vec<String>),
    /// Codes with their names.
    Codes(Vec<i8>, Vec<(i8, &'static str)>),
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Values::Reals(values) => values.len(),
            Values::Words(words) => words.len(),
            Values::Codes(codes, _) => codes.len(),
        }
    }

    fn text(&self, row: usize) -> String {
        match self {
            Values::Reals(values) if values[row].is_finite() => format!("{:?}", values[row]),
            Values::Reals(_) => String::new(),
            Values::Words(words) => words[row].clone(),
            Values::Codes(codes, names) => {
                let name = names.iter().find(|(code, _)| *code == codes[row]);
                name.map_or("unknown", |(_, name)| name).to_owned()
            }
        }
    }
}

/// The table behind a figure: columns of equal length, with the unit in each header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Data {
    columns: Vec<(String, Values)>,
}

impl Data {
    pub fn with(mut self, header: impl Into<String>, values: Values) -> Self {
        assert!(self.columns.iter().all(|(_, other)| other.len() == values.len()));
        self.columns.push((header.into(), values));
        self
    }

    pub fn reals(self, header: impl Into<String>, values: Vec<f64>) -> Self {
        self.with(header, Values::Reals(values))
    }

    pub fn words(self, header: impl Into<String>, values: Vec<String>) -> Self {
        self.with(header, Values::Words(values))
    }

    /// Appends the columns of another table.
    pub fn join(mut self, other: Data) -> Self {
        self.columns.extend(other.columns);
        self
    }

    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    pub fn csv(&self) -> String {
        let headers = self.columns.iter().map(|(header, _)| header.clone()).collect();
        let row = |row| self.columns.iter().map(|(_, values)| values.text(row)).collect();
        csv_text(headers, (0..self.rows()).map(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_words_are_quoted() {
        let data = Data::default()
            .reals("x [m/s]", vec![0.1, f64::NAN])
            .words("what, \"now\"", vec!["a,b".into(), "c".into()])
            .with("verdict", Values::Codes(vec![1, 9], vec![(1, "present")]));
        assert_eq!(data.csv(), "x [m/s],\"what, \"\"now\"\"\",verdict\n0.1,\"a,b\",present\n,c,unknown\n");
    }
}
