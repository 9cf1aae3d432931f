//! The extremes of a backbone, and the pieces that are too flat to decide whether they have any.

use super::panel::{Panel, SAMPLES_PER_INTERVAL};
use super::{Backbone, FAR, TurningPoint};
use slipmap_numbers::chebyshev::node;

/// Largest change of C between neighbouring nodes, in units of the error, for which the error may hide
/// extremes. The error's slope is about pi errors per distance of two nodes; samples miss where C is
/// flattest, and errors are estimates: at cusps of random laws pairs were hidden at 3 and one at 10.
const FLAT: f64 = 30.0;

impl Backbone {
    /// The turning points, and C at samples of the extremes that were left out.
    pub(super) fn find_turning_points(&self) -> (Vec<TurningPoint>, Vec<f64>) {
        let (mut radii, mut values) = (vec![0.0], vec![self.viscous(0.0)]);
        for (in_panel, with_values) in self.panels.iter().map(Panel::samples) {
            radii.extend(in_panel);
            values.extend(with_values);
        }
        let lowest = &self.panels[0].values;
        let mut found = vec![TurningPoint { radius: 0.0, viscous: lowest[lowest.len() - 1] }];
        for i in 1..radii.len() - 1 {
            let [left, here, right] = [values[i - 1], values[i], values[i + 1]];
            let (up, down) = (here > left && here >= right, here < left && here <= right);
            if up || down {
                found.push(TurningPoint { radius: radii[i], viscous: here });
            }
        }
        let highest = self.panels[self.panels.len() - 1].values[0];
        found.push(TurningPoint { radius: self.belt_speed, viscous: highest });
        let mut unresolved = Vec::new();
        // Remove the smallest step between neighbours: both its ends, or the one that is not an end of the
        // curve.
        let step = |found: &[TurningPoint], i: usize| (found[i].viscous - found[i - 1].viscous).abs();
        while let Some(i) = (1..found.len())
            .filter(|&i| found.len() > 2 && step(&found, i) <= 2.0 * self.error)
            .min_by(|&i, &j| step(&found, i).total_cmp(&step(&found, j)))
        {
            let removed = match i {
                1 => 1..2,
                i if i + 1 == found.len() => i - 1..i,
                i => i - 1..i + 1,
            };
            let is_open = |point: &TurningPoint| {
                !self.monotone.iter().any(|it| it.from < point.radius && point.radius < it.to)
            };
            unresolved.extend(found.drain(removed).filter(is_open).map(|point| point.viscous));
        }
        for i in 1..found.len() - 1 {
            let sign = (found[i].viscous - found[i - 1].viscous).signum();
            let place = radii.partition_point(|radius| *radius < found[i].radius);
            let best = golden_section(|r| sign * self.viscous(r), [radii[place - 1], radii[place + 1]]);
            found[i] = TurningPoint { radius: best, viscous: self.viscous(best) };
        }
        (found, unresolved)
    }

    /// Ranges of C about pieces so flat that the error may hide a pair of extremes, as at a cusp of folds. On
    /// such a piece C, at its rate between two samples, changes by at most [`FLAT`] errors from node to node,
    /// and slopes do not show that it is monotone.
    pub(super) fn flat_at_samples(&self) -> Vec<[f64; 2]> {
        let far = FAR * self.error;
        let mut flat: Vec<[f64; 2]> = Vec::new();
        let mut ended = true;
        for (radii, values) in self.panels.iter().map(Panel::samples) {
            for (radii, values) in radii.windows(2).zip(values.windows(2)) {
                let is_monotone = self.monotone.iter().any(|it| it.from <= radii[0] && radii[1] <= it.to);
                if is_monotone
                    || (values[1] - values[0]).abs() * SAMPLES_PER_INTERVAL as f64 > FLAT * self.error
                {
                    ended = true;
                    continue;
                }
                let (low, high) = (values[0].min(values[1]) - far, values[0].max(values[1]) + far);
                match flat.last_mut() {
                    Some(last) if !ended => *last = [last[0].min(low), last[1].max(high)],
                    _ => flat.push([low, high]),
                }
                ended = false;
            }
        }
        flat
    }

    /// Ranges of C about pairs of neighbouring nodes, except the pair next to r = 0, between which C changes
    /// by at most three errors and slopes do not show that it is monotone.
    pub(super) fn flat_between_nodes(&self) -> Vec<[f64; 2]> {
        let (panel, far) = (&self.panels[0], FAR * self.error);
        let radius = |i: usize| panel.radius(node(i, panel.values.len() - 1));
        let is_monotone = |i| self.monotone.iter().any(|it| it.from <= radius(i + 1) && radius(i) <= it.to);
        let pairs = panel.values[..panel.values.len() - 1].windows(2).enumerate();
        let flat = pairs.filter(|(i, pair)| (pair[0] - pair[1]).abs() <= far && !is_monotone(*i));
        flat.map(|(_, pair)| [pair[0].min(pair[1]) - far, pair[0].max(pair[1]) + far]).collect()
    }
}

/// Number of steps to an extreme: enough for the accuracy that rounding errors of the values permit.
const SECTIONS: u32 = 40;

/// The place of the maximum of `f`, which rises and then falls between two places, by golden section.
fn golden_section(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let share = 0.5 * (3.0 - 5.0_f64.sqrt());
    let (mut a, mut b) = (low + share * (high - low), high - share * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..SECTIONS {
        if at_a >= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = low + share * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = high - share * (high - low);
            at_b = f(b);
        }
    }
    0.5 * (low + high)
}
