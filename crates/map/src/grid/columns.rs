//! The columns of a tile, one after the other.

use super::{Axis, AxisRole, Grid, Tile};
use slipmap_machine::Machine;
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{LawParameters, Point};

impl Grid {
    /// The columns of a tile, in row-major order; `None` at nodes without one.
    pub(crate) fn columns<'a>(&'a self, tile: &'a Tile) -> impl Iterator<Item = Option<Column>> + 'a {
        let mut index: Vec<usize> = tile.ranges.iter().map(|range| range.start).collect();
        let mut values = self.values(&index);
        let mut source = Maker::new(self, &values);
        (0..tile.columns()).map(move |_| {
            let column = source.column(&values);
            // Increments the index, beginning with the fastest axis other than the damping.
            let outer = self.axes.len().saturating_sub(1);
            for axis in (0..outer).rev() {
                index[axis] += 1;
                let ended = index[axis] == tile.ranges[axis].end;
                if ended {
                    index[axis] = tile.ranges[axis].start;
                }
                values[axis] = self.axes[axis].values[index[axis]];
                source.set(axis, values[axis]);
                if !ended {
                    break;
                }
            }
            column
        })
    }
}

/// Makes the columns of a tile one after the other, of each law once.
struct Maker<'a> {
    grid: &'a Grid,
    /// That of the next column, in dimensionless numbers.
    point: Point,
    /// The machine of the next column.
    machine: Option<Machine>,
    /// The law of the machine in dimensionless form, its parameters, and the units of velocity and of its damping,
    /// until a quantity other than the belt speed changes.
    known: Option<(Law, LawParameters, [f64; 2])>,
}

impl<'a> Maker<'a> {
    fn new(grid: &'a Grid, values: &[f64]) -> Self {
        let (machine, none) = (grid.machine_at(values), LawParameters::new(&[]));
        let point = match machine {
            None => grid.assemble(values),
            Some(_) => Point { epsilon: 1.0, law: none, belt_speed: 0.0, damping: 0.0 },
        };
        Self { grid, point, machine, known: None }
    }

    fn set(&mut self, axis: usize, value: f64) {
        let Axis { role, name, .. } = &self.grid.axes[axis];
        match &mut self.machine {
            None => role.set(&mut self.point, value),
            Some(machine) => {
                machine.set(name, value);
                if *role != AxisRole::BeltSpeed {
                    self.known = None;
                }
            }
        }
    }

    fn column(&mut self, values: &[f64]) -> Option<Column> {
        let Some(machine) = &self.machine else { return Some(self.grid.law.column(&self.point)) };
        if self.grid.gap.is_some() {
            return self.grid.column_of(values).ok();
        }
        if self.known.is_none() {
            let model = machine.model()?;
            self.known = Some((model.law, model.point.law, [model.si.velocity, machine.damping_unit()]));
        }
        let (law, parameters, [velocity, damping]) = self.known.as_ref()?;
        let belt_speed = machine.belt_speed / velocity;
        Some(law.column(&Point { law: *parameters, belt_speed, ..self.point }).in_unit(*damping))
    }
}
