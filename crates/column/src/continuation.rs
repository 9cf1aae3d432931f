//! Curves on which a test function vanishes in a plane of two parameters, by continuation.
//!
//! The plane is the unit square: callers map it to their parameters. Curves are found by the signs of the
//! function on a grid of `STEPS` steps a side; closed curves that fit between its nodes are missed. Curves
//! are followed in both directions by pseudo-arclength continuation: a step along the secant, then a root on
//! the normal through its end. Steps shrink where the curve turns. A curve ends on the border of the square,
//! where it closes, or where the function is undefined (for instance at a point of codimension two). All
//! curves of a function together have at most `MOST_POINTS` points, as many as a figure as wide as a page can
//! show.
//!
//! **Error.** For each point, its distance from the curve: (|value| + error of the value) over the slope of
//! the function along the normal. Between points the curve leaves its chord by at most about an eighth of the
//! longest step times the largest turn, 6e-4.

use rayon::prelude::*;
use slipmap_numbers::TimesPlus as _;

/// Number of steps of the grid of signs along each side.
pub(crate) const STEPS: usize = 40;
/// Number of nodes of a side of that grid.
const ROW: usize = STEPS + 1;
/// Number of tests together, after which the search looks whether its budget is spent: so it ends at the same place with any
/// number of threads.
pub(crate) const BATCH: usize = 8;
/// Longest step of the continuation.
const LONGEST: f64 = 0.025;
/// Shortest step; a curve that needs shorter ones ends.
const SHORTEST: f64 = 1e-5;
/// Largest angle between successive steps: a step that turns by more is repeated at half the length, one that
/// turns by less than a third of it is followed by a longer one.
const LARGEST_TURN: f64 = 0.2;
/// Largest number of points of all curves of a function.
pub const MOST_POINTS: usize = 2_000;
/// Largest number of trials for one root.
const TRIALS: u32 = 60;
/// Smallest distance of two trials: neighbours in double precision.
const NEAREST: f64 = 1e-14;
/// Largest value, in units of its error, that counts as a zero.
const NOISE: f64 = 16.0;
/// Largest value that counts as a zero even if its error is smaller: test functions are of order one, and
/// their roots are not located more closely.
const SMALL: f64 = 1e-9;
/// Largest ratio of successive values of a function that counts as flat: 1, up to noise.
const FLAT: f64 = 1.000_001;
/// Ratio of successive steps where the function is flat, until its sign changes.
const STRIDE: f64 = 4.0;
/// Largest share of a step by which it may leave the square and yet go on along the border.
const HUGGED: f64 = 1e-3;
/// Half the distance of the central differences that give the first direction.
const DIFFERENCE: f64 = 1e-4;
/// Zeros on the grid within this distance of a curve count as points of it, see the module's text on chords.
const COVERED: f64 = 2e-3;

/// A value of a test function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestValue {
    pub(crate) value: f64,
    /// Estimate of its absolute error.
    pub(crate) error: f64,
}

/// A test function on the unit square; `None` where it is undefined. It is never evaluated outside.
pub(crate) type TestFunction<'a> = &'a (dyn Fn([f64; 2]) -> Option<TestValue> + Sync);

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Its position in the unit square.
    pub place: [f64; 2],
    /// Estimate of its distance from the curve, in sides of the square.
    pub error: f64,
}

/// A connected curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its points in order.
    pub points: Vec<CurvePoint>,
    /// Whether the last point is the first one again.
    pub closed: bool,
}

/// Whether the budget of a search for curves is spent.
pub(crate) type Spent<'a> = &'a (dyn Fn() -> bool + Sync);

/// The curves on which a test function is zero, and whether some may be missing, since `is_spent` or they have
/// [`MOST_POINTS`] points.
pub fn zero_curves(function: TestFunction, is_spent: Spent) -> (Vec<Branch>, bool) {
    let values = grid_values(function, is_spent);
    // From here on one test follows the other, so that the budget is spent at the same one whatever the threads.
    let function: TestFunction = &|place| if is_spent() { None } else { function(place) };
    let mut branches: Vec<Branch> = Vec::new();
    let mut left = MOST_POINTS;
    for seed in seeds(function, &values) {
        if left < 2 {
            break;
        }
        if branches.iter().any(|branch| covers(branch, seed.place)) {
            continue;
        }
        let Some((direction, slope)) = start(function, seed.place) else {
            continue;
        };
        // The seed is a point, too.
        let (ahead, closed) = follow(function, seed, direction, slope, left - 1);
        let mut points = Vec::new();
        if !closed {
            let room = left - 1 - ahead.len();
            let (behind, _) = follow(function, seed, direction.map(|x| -x), -slope, room);
            points.extend(behind.into_iter().rev());
        }
        points.push(seed);
        points.extend(ahead);
        if points.len() > 1 {
            left -= points.len();
            branches.push(Branch { points, closed });
        }
    }
    // The last branch may end one point before the limit.
    (branches, left < 2 || is_spent())
}

/// The values on the grid, row by row.
fn grid_values(function: TestFunction, is_spent: Spent) -> Vec<Option<TestValue>> {
    let at = |i: usize| i as f64 / STEPS as f64;
    let places: Vec<[f64; 2]> = (0..ROW * ROW).map(|n| [at(n / ROW), at(n % ROW)]).collect();
    let mut values: Vec<Option<TestValue>> = Vec::with_capacity(places.len());
    for batch in places.chunks(BATCH) {
        match is_spent() {
            true => values.resize(values.len() + batch.len(), None),
            false => values.par_extend(batch.par_iter().map(|&place| function(place))),
        }
    }
    values
}

/// Zeros on the lines of the grid, in the grid's order.
fn seeds(function: TestFunction, values: &[Option<TestValue>]) -> Vec<CurvePoint> {
    let at = |i: usize| i as f64 / STEPS as f64;
    let side = ROW;
    let edges = (0..side * side)
        .flat_map(|n| [(n, n + side, n / side < STEPS), (n, n + 1, n % side < STEPS)])
        .filter(|(_, _, inside)| *inside)
        .filter_map(|(a, b, _)| {
            let (from, to) = (values[a]?.value, values[b]?.value);
            let place = |n: usize| [at(n / side), at(n % side)];
            ((from > 0.0) != (to > 0.0)).then(|| (place(a), place(b), from, to))
        });
    let root = |(a, b, from, to): ([f64; 2], [f64; 2], f64, f64)| {
        let length = 1.0 / STEPS as f64;
        let along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        let mut line = Line { function, from: a, along, reach: length };
        line.root((0.0, from), (length, to)).map(|root| root.point)
    };
    edges.filter_map(root).collect()
}

/// Returns whether a point lies on a branch, within the distance of chords.
fn covers(branch: &Branch, place: [f64; 2]) -> bool {
    branch.points.windows(2).any(|ends| distance_to_segment(place, ends[0].place, ends[1].place) < COVERED)
}

fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = (minus(b, a), minus(p, a));
    let length = dot(ab, ab);
    let share = if length > 0.0 { (dot(ap, ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off = minus(ap, ab.map(|x| share * x));
    off[0].hypot(off[1])
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0].times_plus(b[0], a[1] * b[1])
}

/// The normal to the left of a direction.
fn normal(direction: [f64; 2]) -> [f64; 2] {
    [-direction[1], direction[0]]
}

fn is_inside(place: [f64; 2]) -> bool {
    place.iter().all(|x| (0.0..=1.0).contains(x))
}

/// The direction of the curve at one of its points, and the slope of the function along the normal.
fn start(function: TestFunction, place: [f64; 2]) -> Option<([f64; 2], f64)> {
    let mut gradient = [0.0; 2];
    for (axis, slope) in gradient.iter_mut().enumerate() {
        let [low, high] = [-DIFFERENCE, DIFFERENCE].map(|step| {
            let mut at = place;
            at[axis] = (at[axis] + step).clamp(0.0, 1.0);
            at
        });
        *slope = (function(high)?.value - function(low)?.value) / (high[axis] - low[axis]);
    }
    let size = gradient[0].hypot(gradient[1]);
    (size > 0.0 && size.is_finite()).then(|| ([-gradient[1] / size, gradient[0] / size], -size))
}

struct Root {
    point: CurvePoint,
    /// Slope of the function along the line there.
    slope: f64,
}

/// A line on which a root is searched, up to `reach` from its start.
struct Line<'a> {
    function: TestFunction<'a>,
    from: [f64; 2],
    along: [f64; 2],
    reach: f64,
}

impl Line<'_> {
    fn place(&self, s: f64) -> [f64; 2] {
        [self.along[0].times_plus(s, self.from[0]), self.along[1].times_plus(s, self.from[1])]
    }

    /// The value at `s`; `None` outside the square, beyond the reach, and where the function is undefined.
    fn value(&self, s: f64) -> Option<TestValue> {
        let place = self.place(s);
        (s.abs() <= self.reach && is_inside(place)).then(|| (self.function)(place)).flatten()
    }

    /// The root near `from`, whose slope is about `slope`.
    fn root_near(&mut self, slope: f64) -> Option<Root> {
        let first = self.value(0.0)?.value;
        let step = if first == 0.0 { SHORTEST } else { -first / slope };
        // A step long enough to show the slope even next to the root.
        let step = step.signum() * step.abs().clamp(1e-3 * SHORTEST, self.reach);
        self.root((0.0, first), (step, self.value(step)?.value))
    }

    /// The root from two points with their values, by secants and, once two signs are known, bisection.
    fn root(&mut self, mut before: (f64, f64), mut here: (f64, f64)) -> Option<Root> {
        let mut bracket: Option<[(f64, f64); 2]> = None;
        let mut slope = f64::NAN;
        for trial in 1..=TRIALS {
            if (before.1 > 0.0) != (here.1 > 0.0) {
                bracket = Some([before, here]);
            } else if let Some([a, b]) = bracket {
                // Replace the end whose sign is that of the newest value.
                bracket = Some(if (a.1 > 0.0) == (here.1 > 0.0) { [here, b] } else { [a, here] });
            }
            let secant = (here.1 - before.1) / (here.0 - before.0);
            if secant.is_finite() && secant != 0.0 {
                slope = secant;
            }
            let mut next = here.0 - here.1 / slope;
            if let Some([a, b]) = bracket {
                let (low, high) = (a.0.min(b.0), a.0.max(b.0));
                if !(next > low && next < high) || trial % 4 == 0 {
                    next = 0.5 * (low + high);
                }
            } else if before.1 != 0.0 && (0.5..=FLAT).contains(&(here.1 / before.1)) {
                // The function is flat here and steep at its root, like the margin of an overdamped orbit.
                // Secants would hardly move.
                next = (here.0 + STRIDE * (here.0 - before.0)).clamp(-self.reach, self.reach);
                if next == here.0 {
                    return None;
                }
            }
            let TestValue { value, error } = self.value(next)?;
            let moved = (next - here.0).abs();
            if value.abs() <= error || moved <= NEAREST {
                // A jump of sign is not a zero.
                let zero = value.abs() <= (NOISE * error).max(SMALL);
                let distance = (value.abs() + error) / slope.abs();
                let point = CurvePoint { place: self.place(next), error: distance + NEAREST };
                return (zero && distance < SHORTEST).then_some(Root { point, slope });
            }
            (before, here) = (here, (next, value));
        }
        None
    }
}

/// The points after `start` in a direction, at most `most` of them, and whether they lead back to it.
fn follow(
    function: TestFunction,
    start: CurvePoint,
    first_direction: [f64; 2],
    mut slope: f64,
    most: usize,
) -> (Vec<CurvePoint>, bool) {
    let mut points: Vec<CurvePoint> = Vec::new();
    let (mut here, mut direction, mut h) = (start.place, first_direction, 0.25 * LONGEST);
    while points.len() < most && h >= SHORTEST {
        let back = minus(start.place, here);
        let ahead = dot(back, direction);
        let aside = dot(back, normal(direction)).abs();
        let comes_round = points.len() > 2 && dot(direction, first_direction) > 0.0;
        if comes_round && ahead > 0.0 && ahead <= 1.2 * h && aside <= 0.3 * ahead {
            points.push(start);
            return (points, true);
        }
        let predicted = [direction[0].times_plus(h, here[0]), direction[1].times_plus(h, here[1])];
        // A curve that hugs the border ends where it meets it, not where rounding leaves the square.
        let from = predicted.map(|x| x.clamp(0.0, 1.0));
        let [off_x, off_y] = minus(predicted, from);
        let is_near = off_x.hypot(off_y) <= HUGGED * h;
        let mut line = Line { function, from, along: normal(direction), reach: 0.5 * h };
        let Some(root) = is_near.then(|| line.root_near(slope)).flatten() else {
            if !is_inside(predicted) {
                match on_border(function, here, direction, h, slope) {
                    // A curve that touches the border may turn away from the chord to it, like any other step.
                    Some(end) if turn_of(direction, minus(end.place, here)) <= LARGEST_TURN => {
                        points.push(end);
                        return (points, false);
                    }
                    Some(_) | None => {}
                }
            }
            h *= 0.5;
            continue;
        };
        let step = minus(root.point.place, here);
        let length = step[0].hypot(step[1]);
        let turn = turn_of(direction, step);
        if turn > LARGEST_TURN {
            h *= 0.5;
            continue;
        }
        if turn < LARGEST_TURN / 3.0 {
            h = (1.5 * h).min(LONGEST);
        }
        direction = step.map(|x| x / length);
        here = root.point.place;
        slope = root.slope;
        points.push(root.point);
    }
    (points, false)
}

fn turn_of(direction: [f64; 2], step: [f64; 2]) -> f64 {
    dot(step, normal(direction)).atan2(dot(step, direction)).abs()
}

/// The end of a curve on the border of the square, less than a step ahead.
fn on_border(
    function: TestFunction,
    here: [f64; 2],
    direction: [f64; 2],
    h: f64,
    slope: f64,
) -> Option<CurvePoint> {
    // The side that is met first, and its distance.
    let sides = [0, 1].map(|axis| {
        let border = if direction[axis] > 0.0 { 1.0 } else { 0.0 };
        let away =
            if direction[axis] == 0.0 { f64::INFINITY } else { (border - here[axis]) / direction[axis] };
        (axis, border, away)
    });
    let (axis, border, away) = if sides[0].2 <= sides[1].2 { sides[0] } else { sides[1] };
    let mut from = [direction[0].times_plus(away, here[0]), direction[1].times_plus(away, here[1])];
    from[axis] = border;
    from[1 - axis] = from[1 - axis].clamp(0.0, 1.0);
    if away == 0.0 {
        // The curve begins on this side and leaves the square at once.
        return None;
    }
    let mut along = [0.0; 2];
    along[1 - axis] = 1.0;
    let across = dot(along, normal(direction));
    let mut line = Line { function, from, along, reach: h };
    line.root_near(slope * across).map(|root| root.point)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function whose error is round-off.
    fn exact(f: impl Fn(f64, f64) -> f64 + Sync) -> impl Fn([f64; 2]) -> Option<TestValue> + Sync {
        move |[x, y]| Some(TestValue { value: f(x, y), error: 4.0 * f64::EPSILON })
    }

    /// Rings within rings: what a figure cannot show is left out.
    #[test]
    fn all_curves_together_have_as_many_points_as_a_figure_shows() {
        let rings = exact(|x, y| (250.0 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5))).sin());
        let (curves, is_cut) = zero_curves(&rings, &|| false);
        let points: usize = curves.iter().map(|curve| curve.points.len()).sum();
        assert!(points > MOST_POINTS / 2 && points <= MOST_POINTS && is_cut, "{points}");
    }

    #[test]
    fn a_circle_closes() {
        let circle = exact(|x, y| (x - 0.45).times_plus(x - 0.45, (y - 0.52) * (y - 0.52)) - 0.09);
        let (curves, is_cut) = zero_curves(&circle, &|| false);
        assert!(!is_cut);
        // A budget that is spent ends the search.
        assert_eq!(zero_curves(&circle, &|| true), (Vec::new(), true));
        assert_eq!(curves.len(), 1);
        let branch = &curves[0];
        assert!(branch.closed && branch.points[0] == *branch.points.last().unwrap());
        let mut around = 0.0;
        for ends in branch.points.windows(2) {
            let [a, b] = [ends[0], ends[1]].map(|end| minus(end.place, [0.45, 0.52]));
            assert!((a[0].hypot(a[1]) - 0.3).abs() <= ends[0].error + f64::EPSILON, "{ends:?}");
            assert!(ends[0].error < 1e-13);
            let turn = (a[0] * b[1] - a[1] * b[0]).atan2(dot(a, b));
            // A chord's turn about the centre is that of the curve.
            assert!(turn.abs() < 1.1 * LARGEST_TURN);
            around += turn;
        }
        assert!((around.abs() - std::f64::consts::TAU).abs() < 1e-12, "{around}");
    }

    #[test]
    fn curves_end_on_the_border_and_near_neighbours_are_kept_apart() {
        // Two branches of a hyperbola 0.014 apart at their nearest.
        let hyperbola = exact(|x, y| (x - 0.5) * (y - 0.5) - 2.5e-5);
        let (curves, _) = zero_curves(&hyperbola, &|| false);
        assert_eq!(curves.len(), 2);
        for branch in &curves {
            assert!(!branch.closed);
            for end in [branch.points[0], *branch.points.last().unwrap()] {
                assert!(end.place.iter().any(|x| *x == 0.0 || *x == 1.0), "{end:?}");
            }
            for point in &branch.points {
                let [x, y] = point.place.map(|x| x - 0.5);
                assert!((x * y - 2.5e-5).abs() <= 1e-15, "{point:?}");
            }
        }
    }

    #[test]
    fn a_curve_that_touches_the_border_is_found_once() {
        // The law 1 + h sin(w u) has its Hopf curve at c = -h w cos(w V), here up to the largest c there is.
        for touch in [0.4, 0.4 - 1e-12, 0.4 + 1e-12] {
            let hopf = exact(move |x, y| -touch * (4.0 * (0.5 + 2.0 * x)).cos() - 0.4 * y);
            let (curves, _) = zero_curves(&hopf, &|| false);
            // Four flanks, two of which may be joined where the curve stays inside.
            assert!((2..=4).contains(&curves.len()), "{touch}: {}", curves.len());
            for (i, branch) in curves.iter().enumerate() {
                for other in &curves[..i] {
                    let double = branch.points.iter().filter(|point| covers(other, point.place)).count();
                    // Next to where they touch the border, two flanks are near each other.
                    let all = branch.points.len();
                    assert!(2 * double < all, "{touch}: {double} of {all} points lie on another");
                }
            }
        }
    }

    /// The margin of overdamped orbits is flat but for a narrow strip about the curve: steps as long as
    /// elsewhere follow it.
    #[test]
    fn a_steep_function_takes_no_more_points() {
        let curve = |x: f64, y: f64| y - 0.3 - 0.4 * x * x;
        let points = |steepness: f64| {
            let steep = |[x, y]: [f64; 2]| {
                let value = (steepness * curve(x, y)).tanh();
                Some(TestValue { value, error: 1e-8 })
            };
            let (curves, _) = zero_curves(&steep, &|| false);
            assert_eq!(curves.len(), 1);
            for point in &curves[0].points {
                let [x, y] = point.place;
                assert!(curve(x, y).abs() <= 1e-8 / steepness + 1e-14, "{point:?}");
            }
            curves[0].points.len()
        };
        let usual = points(1.0);
        for steepness in [1e3, 1e5, 1e7] {
            let steep = points(steepness);
            assert!(steep <= usual + 2, "{steepness}: {steep} points, not {usual}");
        }
    }

    #[test]
    fn jumps_are_no_curves_and_curves_end_with_functions() {
        assert!(
            zero_curves(&exact(|x, y| if x + 0.3 * y > 0.6 { 1.0 } else { -1.0 }), &|| false).0.is_empty()
        );
        let half = |[x, y]: [f64; 2]| {
            (x < 0.613).then_some(TestValue { value: y - 0.2 - 0.5 * x, error: f64::EPSILON })
        };
        let (curves, _) = zero_curves(&half, &|| false);
        assert_eq!(curves.len(), 1);
        let ends = [curves[0].points[0], *curves[0].points.last().unwrap()].map(|end| end.place[0]);
        let (left, right) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        assert!(left == 0.0 && (0.613 - right).abs() < 2.0 * SHORTEST, "{ends:?}");
    }
}
