//! The journal's contents as bytes: attributes, tiles and accounts, by serde in the format of `postcard`.
//!
//! Decoded data are not trusted: every length is compared with the number of bytes that are left before
//! memory is allocated for it, and every number is compared with the plan.

use serde::{Deserialize, Serialize};

use crate::map::{
    Account, Audit, Axis, Contradiction, Contradictions, Disagreement, FailedCell, Grid, MethodAccount,
    Paths, Plan, Stages, Unknown, Verdict,
};
use crate::point::Point;

pub(super) fn to_bytes(value: &impl Serialize) -> Vec<u8> {
    match postcard::to_stdvec(value) {
        Ok(bytes) => bytes,
        Err(error) => panic!("lists of known length can be written to memory: {error}"),
    }
}

/// Decodes the bytes of a value of this type; `None` for other bytes.
pub(super) fn from_bytes<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<T> {
    postcard::take_from_bytes(bytes).ok().filter(|(_, rest)| rest.is_empty()).map(|(value, _)| value)
}

/// A stored account. Points are stored as values on the axes of the grid, methods as positions in the plan.
#[derive(Serialize, Deserialize)]
pub(super) struct AccountRecord {
    cells: u64,
    methods: Vec<MethodAccount>,
    paths: Paths,
    rhs: u64,
    /// The audit without its disagreements.
    audit: Audit,
    /// Point, method, and whether the verdict in the map is present.
    disagreements: Vec<(Vec<f64>, usize, bool)>,
    contradicted_cells: u64,
    /// Tile, point and codes of the verdicts.
    contradictions: Vec<(usize, Vec<f64>, Vec<i8>)>,
    unknown: Unknown,
    stages: Stages,
    /// Tile, point and method.
    failed: Vec<(usize, Vec<f64>, usize)>,
}

impl AccountRecord {
    pub(super) fn of(plan: &Plan, account: &Account) -> Self {
        let point = |point: &Point| plan.grid.axes().iter().map(|axis| axis.role.of(point)).collect();
        let method = |name: &str| plan.methods.iter().position(|m| m.name() == name).unwrap_or(usize::MAX);
        let parts = |d: &Disagreement| (point(&d.point), method(d.method), d.stored == Verdict::Present);
        let contradiction = |cell: &Contradiction| {
            (cell.tile, point(&cell.point), cell.verdicts.iter().map(|verdict| verdict.code()).collect())
        };
        let failed = |cell: &FailedCell| (cell.tile, point(&cell.point), method(cell.method.name()));
        Self {
            cells: account.cells,
            methods: account.methods.clone(),
            paths: account.paths,
            rhs: account.rhs,
            audit: account.audit.clone(),
            disagreements: account.audit.disagreements.iter().map(parts).collect(),
            contradicted_cells: account.contradictions.cells,
            contradictions: account.contradictions.first.iter().map(contradiction).collect(),
            unknown: account.unknown,
            stages: account.stages,
            failed: account.failed.iter().map(failed).collect(),
        }
    }

    /// Restores the account; `None` if it does not fit `plan`.
    pub(super) fn account(self, plan: &Plan) -> Option<Account> {
        let method = |position: usize| plan.methods.get(position).copied();
        let disagreement = |(point, position, present): (Vec<f64>, usize, bool)| {
            let stored = if present { Verdict::Present } else { Verdict::Absent };
            Some(Disagreement::again(plan, point_of(plan, &point)?, method(position)?.name(), stored))
        };
        let contradiction = |(tile, point, codes): (usize, Vec<f64>, Vec<i8>)| {
            let verdicts: Vec<Verdict> = codes.into_iter().map(Verdict::of_code).collect::<Option<_>>()?;
            let fits = verdicts.len() == plan.methods.len();
            Some(Contradiction { tile, point: point_of(plan, &point)?, verdicts }).filter(|_| fits)
        };
        let failed = |(tile, point, position): (usize, Vec<f64>, usize)| {
            Some(FailedCell { tile, point: point_of(plan, &point)?, method: method(position)? })
        };
        let disagreements = self.disagreements.into_iter().map(disagreement).collect::<Option<_>>()?;
        let first = self.contradictions.into_iter().map(contradiction).collect::<Option<_>>()?;
        Some(Account {
            cells: self.cells,
            methods: Some(self.methods).filter(|of| of.len() == plan.methods.len())?,
            paths: self.paths,
            rhs: self.rhs,
            audit: Audit { disagreements, ..self.audit },
            contradictions: Contradictions { cells: self.contradicted_cells, first },
            unknown: self.unknown,
            stages: self.stages,
            failed: self.failed.into_iter().map(failed).collect::<Option<_>>()?,
        })
    }
}

/// The point with these values on the axes of the plan; `None` if they are not legal.
fn point_of(plan: &Plan, values: &[f64]) -> Option<Point> {
    let (law, axes) = (plan.grid.law(), plan.grid.axes());
    let legal = |(axis, &value): (&Axis, &f64)| Grid::check_value(law, axis.role, &axis.name, value).is_ok();
    let fits = values.len() == axes.len() && axes.iter().zip(values).all(legal);
    fits.then(|| plan.grid.point_of(values))
}

#[cfg(test)]
mod tests {
    use super::super::pack::PackedTile;
    use super::*;
    use crate::dataset::Value;

    #[test]
    fn attributes_read_back() {
        let attributes = vec![
            ("text".to_owned(), Value::from("für tests")),
            ("integers".to_owned(), Value::Integers(vec![i64::MIN, -1, 0, i64::MAX])),
            ("codes".to_owned(), Value::Codes(vec![-1, 0, 1])),
            ("reals".to_owned(), Value::Reals(vec![0.1, -0.0, f64::INFINITY])),
        ];
        let bytes = to_bytes(&attributes);
        for cut in 0..bytes.len() {
            assert_eq!(from_bytes::<Vec<(String, Value)>>(&bytes[..cut]), None, "{cut} bytes");
        }
        assert_eq!(from_bytes(&bytes), Some(attributes));
    }

    #[test]
    fn absurd_lengths_are_refused_before_room_is_made_for_them() {
        for length in [1, 1 << 20, u64::MAX / 16, u64::MAX] {
            let bytes = to_bytes(&length);
            assert_eq!(from_bytes::<Vec<(String, Value)>>(&bytes), None);
            assert_eq!(from_bytes::<Vec<f64>>(&bytes), None);
            assert!(from_bytes::<PackedTile>(&to_bytes(&(0, length))).is_none());
        }
    }
}
