//! Monotone ranges and extremes of C between the nodes, by its slopes at the nodes.
//!
//! Between two nodes C is taken to be monotone where both slopes have the sign of the secant and are at most
//! 2.5 times as steep. The cubic with these values and slopes is monotone up to three times. At a cusp of
//! folds, where C is nearly a multiple of the cube of the distance from it, one slope is three times as steep
//! or steeper wherever the nodes lie, and terms of higher order may make C turn. Corners of the law may hide
//! an extreme, so where orbits may reach one, C also has to change by several errors of the backbone. Across
//! corners the extremes of these cubics stand for extremes of C that a polynomial through all nodes lacks.

use super::panel::Panel;
use super::{Backbone, FAR};
use slipmap_orbits::Closing;

/// Largest slope, in units of the secant's, for which C is taken to be monotone.
const STEEPEST: f64 = 2.5;
/// Bound of an orbit's depth, in units of its amplitude, that decides which corners it may reach.
const DEEPEST: f64 = 2.0;

/// A range of amplitudes on which C rises or falls, and C at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Monotone {
    pub(super) from: f64,
    pub(super) to: f64,
    viscous: [f64; 2],
}

impl Monotone {
    pub(super) fn change(&self) -> f64 {
        (self.viscous[1] - self.viscous[0]).abs()
    }

    /// Whether the next range begins at the end of this one, and C has the same direction on both.
    fn goes_on_in(&self, next: &Self) -> bool {
        let rises = |it: &Self| it.viscous[1] > it.viscous[0];
        self.to == next.from && rises(self) == rises(next)
    }
}

/// A node with dC / dr and its error.
#[derive(Clone, Copy)]
struct Node {
    radius: f64,
    viscous: f64,
    slope: [f64; 2],
}

impl Node {
    /// Whether the slope at this node is compatible with a C that is monotone along a secant.
    fn is_along(&self, secant: f64) -> bool {
        let [slope, error] = self.slope;
        let along = slope / secant;
        along <= STEEPEST && (self.radius == 0.0 || along > 0.0 && slope.abs() > error)
    }

    /// C at the extremes between this node and a higher one of the cubic with these values and slopes.
    fn extremes_between(self, high: Self) -> impl Iterator<Item = f64> {
        let width = high.radius - self.radius;
        let (start, change) = (self.viscous, high.viscous - self.viscous);
        let (from, to) = (width * self.slope[0], width * high.slope[0]);
        // start + from t + b t^2 + a t^3 for 0 < t < 1.
        let (a, b) = (from + to - 2.0 * change, 3.0 * change - 2.0 * from - to);
        let root = (b * b - 3.0 * a * from).sqrt();
        let sum = -(b + root.copysign(b));
        let inside = [sum / (3.0 * a), from / sum].into_iter().filter(|t| 0.0 < *t && *t < 1.0);
        inside.map(move |t| start + t * (from + t * (b + t * a)))
    }
}

impl Panel {
    /// Neighbouring nodes whose slopes are known, by increasing amplitude.
    fn pairs_with_slopes(&self) -> Vec<[Node; 2]> {
        let known = self.orbits.iter().enumerate().rev().filter_map(|(i, orbit)| Some((i, (*orbit)?)));
        let node = |(i, orbit): (usize, Closing)| {
            let radius = self.radius(slipmap_numbers::chebyshev::node(i, self.orbits.len() - 1));
            // At r = 0 C is even.
            let slope = if radius == 0.0 { [0.0; 2] } else { orbit.slope?.map(|slope| slope / radius) };
            Some(Node { radius, viscous: orbit.viscous, slope })
        };
        let nodes: Vec<Option<Node>> = known.map(node).collect();
        nodes.windows(2).filter_map(|pair| Some([pair[0]?, pair[1]?])).collect()
    }
}

impl Backbone {
    /// The ranges of amplitudes on which C is monotone, increasing, each as long as possible. Corners are at
    /// least `nearest_corner` away from the belt speed.
    pub(super) fn monotone_ranges(panels: &[Panel], error: f64, nearest_corner: f64) -> Vec<Monotone> {
        let mut ranges: Vec<Monotone> = Vec::new();
        for panel in panels {
            for [low, high] in panel.pairs_with_slopes() {
                let next =
                    Monotone { from: low.radius, to: high.radius, viscous: [low.viscous, high.viscous] };
                let secant = (high.viscous - low.viscous) / (high.radius - low.radius);
                let is_smooth = panel.in_root || DEEPEST * high.radius < nearest_corner;
                let is_certain = is_smooth || low.radius > 0.0 && next.change() > FAR * error;
                if !(is_certain && low.is_along(secant) && high.is_along(secant)) {
                    continue;
                }
                match ranges.last_mut() {
                    Some(last) if last.goes_on_in(&next) => {
                        (last.to, last.viscous[1]) = (next.to, next.viscous[1]);
                    }
                    _ => ranges.push(next),
                }
            }
        }
        ranges
    }

    /// C at the extremes of the cubics between the nodes.
    pub(super) fn extremes_by_slopes(panels: &[Panel]) -> Vec<f64> {
        let pairs = panels.iter().flat_map(Panel::pairs_with_slopes);
        pairs.flat_map(|[low, high]| low.extremes_between(high)).collect()
    }
}
