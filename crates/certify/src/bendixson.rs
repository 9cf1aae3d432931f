//! Bendixson's criterion at finite eps: one sign of the divergence along the whole orbit.
//!
//! ```text
//! present if  D(u) > 0 for all u in [0, V + R], R the orbit's amplitude, and the landing speed is below 2
//! absent  if  D(u) < 0 for all u in [0, 2 V]
//!
//! with a drop j of friction as slip begins
//! present if  D(u) > -d* for all u in [0, V + R], and the landing speed is below 2 - j
//! absent  if  D(u) < -d* for all u in [0, V + hypot(V, j)]
//! ```
//!
//! where d*(j/V) > 0 is the damping that the drop alone sustains, see "Constant divergence" and "Comparison with
//! it" in the source of `certify::drop`.
//!
//! **Domain**: every law. **Guarantee**: a theorem at every eps > 0, evaluated in double precision.
//!
//! **Proof.** r^2 = x2^2 + x2'^2 obeys (r^2)' = 2 D x2'^2 below the belt line. *Absence*: while r <= V, the
//! slip speed V - x2 is in [0, 2 V], where D < 0; so r falls from V and never returns to it, nor does the
//! orbit to x2 = V. *Presence*: r rises, since the slip speed stays in [0, V + R]: the lower half ends at -x2
//! = R by definition. The upper half cannot turn at 0 < x2 <= V, where it would have r <= V; so it reaches
//! the belt line with r > V, that is `wL` > 0. It sticks if `wL` < 2, see [`super::landing`]. By monotonicity
//! in c ([`super`]) presence at one damping is presence at every smaller one, down to where the landing is
//! proved. []
//!
//! **The edge.** R is replaced by its proved bound ([`landing::amplitude_bounds`]), which falls with c. So the
//! right side of eps c <= min of weakening over [0, V + R(c)] rises with c as the left side does, and the
//! edge is the largest fixed point of c -> min / eps. Secants starting with R = V approach it from above and
//! pass it slightly; the edge returned satisfies the inequality as computed.
//!
//! Departures from the paper (section 5.1): the paper keeps only the first order in eps and takes x2 >= -V
//! along the orbit. That is [`super::bendixson_leading`]; where D > 0 the orbit in fact overshoots -V.

use super::{Claim, Columns, Guarantee, Test, absence_edge, drop, landing, presence_edge};
use slipmap_model::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "bendixson",
    long_name: "Bendixson criterion at finite eps",
    equation: "paper section 5.1 at finite eps",
    guarantee: Guarantee::FiniteEpsilon,
    first_order: false,
    claims,
};

/// Number of strips per quarter turn of the amplitude's bound. In random columns the edge is lower than with
/// 512 strips by 0.02 % in the median and by 2 % at the ninetieth percentile.
const STRIPS: u32 = 8;

/// Largest number of evaluations of the amplitude's bound; three to six are usual.
const EVALUATIONS: u32 = 40;

/// Relative distance to the fixed point at which the search stops.
const SHARPNESS: f64 = 1e-9;

/// Largest slope of the map with which a secant is drawn. At slope 1 the secant has no root; below it, what the
/// search certifies does not depend on this number.
const STEEPEST: f64 = 0.9;

/// Number of columns whose edges are searched together.
const LANES: usize = 8;

fn claims(columns: &Columns) -> Vec<Claim> {
    let of = |(number, edge): (usize, Option<f64>)| {
        let column = &columns[number];
        let present_below = edge.unwrap_or(f64::NEG_INFINITY);
        // Where `symmetric` has proved the landing at every damping, there is nothing to search.
        let lands = edge.map(|_| columns.symmetric(number));
        let lands = lands.is_some_and(|known| known.present_below > 0.0 && known.sticks_from == 0.0);
        let sticks_from = if lands { 0.0 } else { landing::sticks_from(column, present_below) };
        Claim { sticks_from, present_below, absent_above: absence_edge(column, highest(column)) }
    };
    presence_edges(columns).into_iter().enumerate().map(of).collect()
}

/// eps c from which on the divergence excludes a return.
fn highest(column: &Column) -> f64 {
    let Column { curve, belt_speed, .. } = column;
    match curve.drop() {
        0.0 => curve.weakening_range(0.0, 2.0 * belt_speed).hi,
        j => curve.weakening_range(0.0, drop::fastest(column)).hi + drop::sustained(j, *belt_speed).hi,
    }
}

/// The least weakening on slip speeds from 0 to V + `amplitude`, with what a drop sustains, as a damping.
fn lowest(column: &Column, amplitude: f64) -> f64 {
    let Column { curve, belt_speed, .. } = column;
    let least = curve.weakening_range(0.0, belt_speed + amplitude).lo;
    match curve.drop() {
        0.0 => presence_edge(column, least),
        j => presence_edge(column, least + drop::sustained(j, *belt_speed).lo),
    }
}

/// For each column a damping c > 0 with eps c <= weakening on [0, V + R(c)], the largest that the search finds; `None` if
/// it finds none.
fn presence_edges(columns: &[Column]) -> Vec<Option<f64>> {
    let mut searches: Vec<Search> = columns.iter().map(Search::new).collect();
    // Apart, for a bound must not depend on the columns beside it.
    let (stribeck, others): (Vec<_>, Vec<_>) =
        searches.iter_mut().partition(|search| search.column.curve.stribeck().is_some());
    for mut going in [stribeck, others] {
        for _ in 0..EVALUATIONS {
            going.retain(|search| !search.is_over);
            let (groups, rest) = going.as_chunks_mut::<LANES>();
            groups.iter_mut().for_each(evaluate);
            rest.as_chunks_mut::<1>().0.iter_mut().for_each(evaluate);
        }
    }
    searches.into_iter().map(|search| search.certified).collect()
}

/// Evaluates the bound of the amplitude in each search once.
fn evaluate<const N: usize>(searches: &mut [&mut Search; N]) {
    let orbits = searches.each_ref().map(|search| (search.column, search.c));
    for (search, amplitude) in searches.iter_mut().zip(landing::amplitude_bounds(orbits, STRIPS)) {
        search.step(amplitude);
    }
}

/// The search for the edge of one column.
struct Search<'a> {
    column: &'a Column,
    /// The damping at which the amplitude is asked next.
    c: f64,
    is_over: bool,
    /// The largest damping found that satisfies the inequality.
    certified: Option<f64>,
    /// Slope of the map c -> min / eps, and where it was evaluated last.
    slope: f64,
    previous: Option<(f64, f64)>,
}

impl<'a> Search<'a> {
    fn new(column: &'a Column) -> Self {
        let c = lowest(column, column.belt_speed);
        // The image of dampings that are not positive is not positive either.
        Self { column, c, is_over: !(c > 0.0), certified: None, slope: 0.0, previous: None }
    }

    /// Goes on from the bound of the amplitude at `c`.
    fn step(&mut self, amplitude: f64) {
        let c = self.c;
        let image = if amplitude.is_finite() { lowest(self.column, amplitude) } else { f64::NEG_INFINITY };
        if image >= c {
            // From below, the iteration of the map rises towards the fixed point.
            self.certified = Some(c);
            self.is_over = image <= c * (1.0 + SHARPNESS);
            self.c = image;
        } else if self.certified.is_none() && image > f64::NEG_INFINITY {
            if let Some((c_before, image_before)) = self.previous {
                self.slope = ((image_before - image) / (c_before - c)).clamp(0.0, STEEPEST);
            }
            self.previous = Some((c, image));
            let root = c - (c - image) / (1.0 - self.slope) - c * (0.5 * SHARPNESS);
            // A steep secant must not jump over a fixed point down to zero.
            self.c = root.max(0.5 * image);
            self.is_over = !(self.c > 0.0);
        } else {
            self.is_over = true;
        }
    }
}
