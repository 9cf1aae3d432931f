//! Byte encoding of the journal's contents: attributes, tiles, accounts. Little-endian; every list is
//! preceded by its length. The decoder trusts nothing: it checks every length against the bytes that are
//! there.

use crate::dataset::{Schema, Value};
use crate::map::{
    Account, Audit, Axis, Contradiction, Contradictions, Disagreement, FailedCell, Grid, Method,
    MethodAccount, Paths, Plan, Stages, Verdict,
};
use crate::point::{LawParameters, MAX_LAW_PARAMETERS, Point};

use super::pack::{PackedChunk, PackedTile};

/// Encoder that appends to a byte vector.
#[derive(Debug, Default)]
pub(super) struct Encoder(pub(super) Vec<u8>);

impl Encoder {
    pub(super) fn number(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn length(&mut self, value: usize) {
        self.number(value as u64);
    }

    pub(super) fn real(&mut self, value: f64) {
        self.number(value.to_bits());
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.0.extend_from_slice(bytes);
    }

    pub(super) fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    fn point(&mut self, point: &Point) {
        self.real(point.epsilon);
        self.length(point.law.as_slice().len());
        point.law.as_slice().iter().for_each(|&value| self.real(value));
        self.real(point.belt_speed);
        self.real(point.damping);
    }

    pub(super) fn attributes(&mut self, attributes: &[(String, Value)]) {
        self.length(attributes.len());
        for (name, value) in attributes {
            self.text(name);
            match value {
                Value::Text(text) => {
                    self.number(0);
                    self.text(text);
                }
                Value::Integers(values) => {
                    self.number(1);
                    self.length(values.len());
                    values.iter().for_each(|&v| self.number(v.cast_unsigned()));
                }
                Value::Codes(values) => {
                    self.number(2);
                    self.bytes(bytemuck::cast_slice(values));
                }
                Value::Reals(values) => {
                    self.number(3);
                    self.length(values.len());
                    values.iter().for_each(|&v| self.real(v));
                }
            }
        }
    }

    /// Encodes a tile: its number, then for each of its chunks what does not follow from the number.
    pub(super) fn tile(&mut self, tile: &PackedTile) {
        self.length(tile.number);
        for chunk in &tile.chunks {
            self.0.extend_from_slice(&chunk.fingerprint);
            chunk.counts.iter().for_each(|&count| self.number(count));
            self.bytes(&chunk.bytes);
        }
    }

    pub(super) fn account(&mut self, plan: &Plan, account: &Account) {
        let method = |name: &str| plan.methods.iter().position(|m| m.name() == name).unwrap_or(usize::MAX);
        self.number(account.cells);
        for MethodAccount { seconds, counts } in &account.methods {
            self.real(*seconds);
            counts.iter().for_each(|&count| self.number(count));
        }
        account.paths.named().iter().for_each(|&(_, cells)| self.number(cells));
        self.number(account.rhs);
        let Audit { cells, checked, agreed, within_margin, unresolved, disagreements } = &account.audit;
        for &count in [cells, checked, agreed, within_margin, unresolved] {
            self.number(count);
        }
        self.length(disagreements.len());
        for disagreement in disagreements {
            self.point(&disagreement.point);
            self.length(method(disagreement.method));
            self.number(u64::from(disagreement.stored == Verdict::Present));
        }
        let Contradictions { cells, first } = &account.contradictions;
        self.number(*cells);
        self.length(first.len());
        for cell in first {
            self.length(cell.tile);
            self.point(&cell.point);
            self.0.extend(cell.verdicts.iter().map(|verdict| verdict.code().cast_unsigned()));
        }
        account.stages.named().iter().for_each(|&(_, seconds)| self.real(seconds));
        self.length(account.failed.len());
        for cell in &account.failed {
            self.length(cell.tile);
            self.point(&cell.point);
            self.length(method(cell.method.name()));
        }
    }
}

/// Decoder that consumes a byte slice. Every method returns `None` where the bytes do not fit.
#[derive(Debug)]
pub(super) struct Decoder<'a>(pub(super) &'a [u8]);

impl<'a> Decoder<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    pub(super) fn number(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    /// Decodes the length of a list whose entries take at least `each` bytes.
    fn length(&mut self, each: usize) -> Option<usize> {
        let length = usize::try_from(self.number()?).ok()?;
        (length.checked_mul(each)? <= self.0.len()).then_some(length)
    }

    pub(super) fn real(&mut self) -> Option<f64> {
        self.number().map(f64::from_bits)
    }

    pub(super) fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = self.length(1)?;
        self.take(length)
    }

    pub(super) fn text(&mut self) -> Option<String> {
        String::from_utf8(self.bytes()?.to_vec()).ok()
    }

    fn point(&mut self) -> Option<Point> {
        let epsilon = self.real()?;
        let parameters = self.length(8).filter(|&n| n <= MAX_LAW_PARAMETERS)?;
        let law: Vec<f64> = (0..parameters).map(|_| self.real()).collect::<Option<_>>()?;
        let (belt_speed, damping) = (self.real()?, self.real()?);
        Some(Point { epsilon, law: LawParameters::new(&law), belt_speed, damping })
    }

    pub(super) fn attributes(&mut self) -> Option<Vec<(String, Value)>> {
        let length = self.length(16)?;
        (0..length)
            .map(|_| {
                let name = self.text()?;
                let value = match self.number()? {
                    0 => Value::Text(self.text()?),
                    1 => {
                        let length = self.length(8)?;
                        let values = (0..length).map(|_| self.number().map(u64::cast_signed));
                        Value::Integers(values.collect::<Option<_>>()?)
                    }
                    2 => Value::Codes(bytemuck::cast_slice(self.bytes()?).to_vec()),
                    3 => {
                        let length = self.length(8)?;
                        Value::Reals((0..length).map(|_| self.real()).collect::<Option<_>>()?)
                    }
                    _ => return None,
                };
                Some((name, value))
            })
            .collect()
    }

    /// Decodes a tile of a map of this layout.
    pub(super) fn tile(&mut self, schema: &Schema) -> Option<PackedTile> {
        let number = usize::try_from(self.number()?).ok().filter(|&number| number < schema.tiles())?;
        let mut chunks = Vec::new();
        for (position, variable) in schema.variables.iter().enumerate() {
            let Some(chunk) = schema.chunk_number(variable, number) else { continue };
            let fingerprint = self.take(32)?.try_into().ok()?;
            let codes = variable.codes().map_or(0, |codes| codes.len());
            let counts = (0..codes).map(|_| self.number()).collect::<Option<_>>()?;
            let bytes = self.bytes()?.to_vec();
            let offset = schema.offset(variable, number);
            chunks.push(PackedChunk {
                variable: position,
                number: chunk,
                offset,
                bytes,
                fingerprint,
                counts,
            });
        }
        self.0.is_empty().then_some(PackedTile { number, chunks })
    }

    pub(super) fn account(&mut self, plan: &Plan) -> Option<Account> {
        let cells = self.number()?;
        let methods = plan
            .methods
            .iter()
            .map(|_| {
                let seconds = self.real()?;
                let mut counts = [0; 5];
                for count in &mut counts {
                    *count = self.number()?;
                }
                Some(MethodAccount { seconds, counts })
            })
            .collect::<Option<_>>()?;
        let mut paths = Paths::default();
        for cells in paths.counts_mut() {
            *cells = self.number()?;
        }
        let rhs = self.number()?;
        let mut audit = Audit {
            cells: self.number()?,
            checked: self.number()?,
            agreed: self.number()?,
            within_margin: self.number()?,
            unresolved: self.number()?,
            disagreements: Vec::new(),
        };
        for _ in 0..self.length(16)? {
            let (point, method) = (self.point_of(plan)?, self.method(plan)?);
            let stored = if self.number()? == 1 { Verdict::Present } else { Verdict::Absent };
            audit.disagreements.push(Disagreement::again(plan, point, method.name(), stored));
        }
        let mut contradictions = Contradictions { cells: self.number()?, first: Vec::new() };
        for _ in 0..self.length(16)? {
            let tile = usize::try_from(self.number()?).ok()?;
            let point = self.point_of(plan)?;
            let codes = self.take(plan.methods.len())?;
            let verdict = |code: &u8| Verdict::ALL.into_iter().find(|v| v.code() == code.cast_signed());
            let verdicts = codes.iter().map(verdict).collect::<Option<_>>()?;
            contradictions.first.push(Contradiction { tile, point, verdicts });
        }
        let mut stages = Stages::default();
        for seconds in stages.seconds_mut() {
            *seconds = self.real()?;
        }
        let length = self.length(24)?;
        let failed = (0..length)
            .map(|_| {
                let tile = usize::try_from(self.number()?).ok()?;
                Some(FailedCell { tile, point: self.point_of(plan)?, method: self.method(plan)? })
            })
            .collect::<Option<_>>()?;
        Some(Account { cells, methods, paths, rhs, audit, contradictions, stages, failed })
    }

    /// Decodes a parameter point under the friction law of this plan.
    fn point_of(&mut self, plan: &Plan) -> Option<Point> {
        let (point, law, axes) = (self.point()?, plan.grid.law(), plan.grid.axes());
        let legal = |axis: &Axis| Grid::check_value(law, axis.role, &axis.name, axis.role.of(&point)).is_ok();
        (point.law.as_slice().len() + 3 == axes.len() && axes.iter().all(legal)).then_some(point)
    }

    fn method(&mut self, plan: &Plan) -> Option<Method> {
        plan.methods.get(usize::try_from(self.number()?).ok()?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_read_back() {
        let attributes = vec![
            ("text".to_owned(), Value::from("für tests")),
            ("integers".to_owned(), Value::Integers(vec![i64::MIN, -1, 0, i64::MAX])),
            ("codes".to_owned(), Value::Codes(vec![-1, 0, 1])),
            ("reals".to_owned(), Value::Reals(vec![0.1, -0.0, f64::INFINITY])),
        ];
        let mut encoder = Encoder::default();
        encoder.attributes(&attributes);
        let bytes = encoder.0;
        assert_eq!(Decoder(&bytes).attributes(), Some(attributes));
        for cut in 0..bytes.len() {
            assert_eq!(Decoder(&bytes[..cut]).attributes(), None, "{cut} bytes");
        }
    }

    #[test]
    fn absurd_lengths_are_refused_before_room_is_made_for_them() {
        for length in [1, 1 << 20, u64::MAX / 16, u64::MAX] {
            assert_eq!(Decoder(&length.to_le_bytes()).attributes(), None);
            assert_eq!(Decoder(&length.to_le_bytes()).bytes(), None);
        }
    }
}
