//! A friction curve on a belt: all parameters but the damping.

use std::sync::Arc;

use super::{Curve, FirstOrder, NoFirstOrder, Range, Weakening};

/// All parameters except the damping: the unit of work of a map. Verdicts along a column change at most
/// twice, because every orbit's amplitude falls with c. [`super::Law::column`] makes columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The friction curve.
    pub curve: Curve,
    /// The viscous damping of the oscillator at damping 1: eps > 0 if dampings are c.
    pub epsilon: f64,
    /// Belt speed V > 0.
    pub belt_speed: f64,
    /// What c = 1 is in the unit of the dampings: 1 if they are c, sqrt(k m) if they are a machine's.
    pub unit: f64,
}

impl Column {
    /// The weakening rate as polynomials up to 4 V, enough for orbits that start within the belt speed.
    pub fn compiled(&self) -> Arc<Weakening> {
        self.curve.compiled(4.0 * self.belt_speed)
    }

    /// The law to first order in eps, in units of c: its slopes compare with a damping c.
    ///
    /// # Errors
    /// As [`Curve::first_order`].
    pub fn first_order(&self) -> Result<FirstOrder, NoFirstOrder> {
        let FirstOrder { mean_weakening, mean_error, weakening_range: Range { lo, hi } } =
            self.curve.first_order(self.belt_speed)?;
        let unit = self.unit;
        Ok(FirstOrder {
            mean_weakening: mean_weakening * unit,
            mean_error: mean_error * unit,
            weakening_range: Range { lo: lo * unit, hi: hi * unit },
        })
    }

    /// The column with its dampings in another unit: `unit` is what c = 1 is in it.
    #[must_use]
    pub fn in_unit(self, unit: f64) -> Self {
        Self { epsilon: self.epsilon / unit, unit: self.unit * unit, ..self }
    }
}
