//! Points of codimension two compared with closed forms, and the number of slip cycles around each with simulated turns.

use slipmap::column::bifurcation::Bifurcation;
use slipmap::column::slip_cycle_count;
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::map::{Grid, Plane, PlaneCurves, PlanePoint};
use slipmap::orbits::arc::{SlipTurn, turn};
use slipmap::orbits::flow;

use crate::sample::formula;

/// The points of a kind in the plane of two axes; `nodes` of eps, the law's parameters, V and c.
fn points(law: &Law, nodes: &[Vec<f64>], [x, y]: [usize; 2], kind: Bifurcation) -> Vec<PlanePoint> {
    let grid = Grid::new(law.clone(), nodes.to_vec()).unwrap();
    let plane = Plane::new(x, y, vec![0; nodes.len()]);
    let kinds = [kind.along().unwrap(), kind];
    let all = PlaneCurves::of_kinds(&kinds, &grid, plane, &false.into()).curves;
    all.into_iter().filter(|curve| curve.bifurcation == kind).flat_map(|curve| curve.points).collect()
}

/// Asserts that there is one point, at `exact` up to its error, which is small.
fn is_at(found: &[PlanePoint], exact: [f64; 2], sides: [f64; 2], context: &str) {
    let [point] = found else { panic!("{context}: {found:?}") };
    let off = ((point.x - exact[0]) / sides[0]).hypot((point.y - exact[1]) / sides[1]);
    assert!(point.error < 1e-7, "{context}: {point:?}");
    assert!(off <= point.error + 1e-9, "{context}: {point:?} {exact:?} {off:e}");
}

/// phi = mu + (1 - mu) exp(-x^2), x = u / vs: w is proportional to x exp(-x^2), and w'' vanishes at x^2 = 3/2.
#[test]
fn bautin_points_have_a_closed_form_in_every_plane() {
    let law = Law::Exponential.with_exponent();
    let (fall, vs) = (0.4_f64, 0.3_f64);
    let x = 1.5_f64.sqrt();
    let rate = |vs: f64| fall * 2.0 * x / vs * (-1.5_f64).exp();
    // eps, mu, vs, eta, exponent, V, c.
    let nodes = |vs: Vec<f64>, v: Vec<f64>, c: Vec<f64>| {
        vec![vec![1.0], vec![1.0 - fall], vs, vec![0.0], vec![2.0], v, c]
    };
    let at = |nodes: Vec<Vec<f64>>, plane| points(&law, &nodes, plane, Bifurcation::Bautin);
    let of_speed = at(nodes(vec![vs], vec![0.2, 0.6], vec![0.1, 2.0]), [5, 6]);
    is_at(&of_speed, [vs * x, rate(vs)], [0.4, 1.9], "V, c");
    let of_width = at(nodes(vec![0.2, 0.5], vec![0.4], vec![0.1, 2.0]), [2, 6]);
    is_at(&of_width, [0.4 / x, rate(0.4 / x)], [0.3, 1.9], "vs, c");
    let of_both = at(nodes(vec![0.2, 0.5], vec![0.2, 0.6], vec![0.7]), [2, 5]);
    let width = rate(1.0) / 0.7;
    is_at(&of_both, [width, width * x], [0.3, 0.4], "vs, V");
}

/// J_n(x) by its series.
fn bessel(n: i32, x: f64) -> f64 {
    let mut term = (1..=n).fold(1.0, |term, i| term * 0.5 * x / f64::from(i));
    let mut sum = 0.0;
    for k in 1..60 {
        sum += term;
        term *= -0.25 * x * x / f64::from(k * (k + n));
    }
    sum
}

fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let sign = f(low).signum();
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *(if f(middle).signum() == sign { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The weakening rate s (6 + cos u + a u^2).
fn waves(s: f64) -> Law {
    formula(&format!("1 - {s:e}*(6*u + sin(u) + a*u^3/3)"))
}

/// C(r)/s of [`waves`] as s tends to 0: the mean of the even part over the circle. Time backward turns w into -w, so that what is
/// left out is smaller by s^2.
fn backbone(a: f64, v: f64, r: f64) -> f64 {
    let share = if r > 0.0 { 2.0 * bessel(1, r) / r } else { 1.0 };
    6.0 + v.cos() * share + a * (v * v + 0.25 * r * r)
}

/// A point of codimension two of [`waves`] for small s: its a and V, and C(r)/s there with its r over V.
#[derive(Clone, Copy, Debug)]
struct Exact {
    kind: Bifurcation,
    a: f64,
    v: f64,
    c: f64,
    r: f64,
}

/// One of each kind. The degeneracies are Bessel functions of the belt speed and the amplitude.
fn exact() -> [Exact; 4] {
    let at = |kind: Bifurcation, a: f64, v: f64, r: f64| Exact { kind, a, v, c: backbone(a, v, r), r: r / v };
    // w'' = 0.
    let bautin = at(Bifurcation::Bautin, 0.4, std::f64::consts::TAU - 0.8_f64.acos(), 0.0);
    // dC/dr = 0 at r = V.
    let v = 3.6_f64;
    let fold = at(Bifurcation::FoldAtGrazing, 4.0 * v.cos() * bessel(2, v) / (v * v), v, v);
    // C(V) = w(V).
    let v = 5.2_f64;
    let a = 4.0 * v.cos() * (1.0 - 2.0 * bessel(1, v) / v) / (v * v);
    let hopf = at(Bifurcation::HopfAtGrazing, a, v, 0.0);
    // dC/dr = 0, and the derivative of (dC/dr)/r: J3(r) = 0.
    let r = root(6.0, 7.0, |r| bessel(3, r));
    let v = 12.0_f64;
    let cusp = at(Bifurcation::Cusp, 4.0 * v.cos() * bessel(2, r) / (r * r), v, r);
    [bautin, fold, hopf, cusp]
}

impl Exact {
    /// The axes a, V and c, 1 to 3, from and to next to the point.
    fn sides(&self, s: f64) -> [[f64; 2]; 4] {
        let Self { a, v, c, .. } = *self;
        [[1.0; 2], [a - 0.012, a + 0.009], [v - 0.37, v + 0.3], [s * (c - 1.0), s * (c + 0.9)]]
    }

    /// The one point that is found in a plane of two of these axes.
    fn found(&self, law: &Law, s: f64, plane: [usize; 2]) -> PlanePoint {
        let Self { kind, a, v, c, .. } = *self;
        let mut nodes = [1.0, a, v, s * c].map(|node| vec![node]);
        plane.iter().for_each(|&axis| nodes[axis] = self.sides(s)[axis].to_vec());
        let found = points(law, &nodes, plane, kind);
        let [point] = found[..] else { panic!("{self:?} {plane:?}: {found:?}") };
        assert!(point.error < 1e-6, "{self:?} {plane:?}: {point:?}");
        point
    }
}

/// Twelve planes, of which four do not have the damping.
#[test]
fn points_of_small_friction_are_those_of_the_averages() {
    let s = 1e-5;
    for exact in exact() {
        for [x, y] in [[2, 3], [1, 3], [1, 2]] {
            let point = exact.found(&waves(s), s, [x, y]);
            let known = [1.0, exact.a, exact.v, s * exact.c];
            let [across, up] = [(x, point.x), (y, point.y)].map(|(axis, at)| {
                let [from, to] = exact.sides(s)[axis];
                (at - known[axis]) / (to - from)
            });
            let off = across.hypot(up);
            assert!(off <= point.error + 1e-8, "{exact:?} {x} {y}: {point:?} {off:e}");
        }
    }
}

/// Of two fold curves next to each other one alone may be followed: their cusp is found in the plane without the damping as in
/// that with it.
#[test]
fn a_cusp_is_the_same_in_every_plane() {
    let s = 0.02;
    let law = waves(s);
    let [.., exact] = exact();
    let with = exact.found(&law, s, [2, 3]);
    for [x, y] in [[1, 3], [1, 2]] {
        let mut nodes = [1.0, exact.a, with.x, with.y].map(|node| vec![node]);
        let known = [exact.a, with.x, with.y];
        let sides = [0.03, 0.8, 1.5 * s];
        for axis in [x, y] {
            nodes[axis] = [-0.4, 0.6].map(|share| known[axis - 1] + share * sides[axis - 1]).to_vec();
        }
        let found = points(&law, &nodes, [x, y], exact.kind);
        let [point] = found[..] else { panic!("{x} {y}: {found:?}") };
        let off = [(x, point.x), (y, point.y)].map(|(axis, at)| (at - known[axis - 1]) / sides[axis - 1]);
        // The point of the other plane has its error, too, in other sides.
        assert!(off[0].hypot(off[1]) <= point.error + 10.0 * with.error + 1e-8, "{x} {y}: {point:?} {off:?}");
    }
}

/// The number of slip cycles: changes of sign of what a simulated turn adds to an amplitude.
fn cycles(oscillator: &Oscillator) -> usize {
    let outward = |i: u32| {
        let r = oscillator.belt_speed * f64::from(i) / 600.0;
        match turn(oscillator, r, 1e-13).unwrap() {
            SlipTurn::Returns { radius, .. } => radius > r,
            SlipTurn::MeetsBelt { .. } => true,
            SlipTurn::Rests => false,
        }
    };
    let signs: Vec<bool> = (1..=600).map(outward).collect();
    signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Around each point the number of slip cycles changes as its unfolding demands: by two across folds, by one across Hopf and
/// grazing curves.
#[test]
fn unfoldings_have_the_simulated_numbers_of_cycles() {
    const PLACES: usize = 48;
    let s = 0.02;
    let law = waves(s);
    for (exact, distance, expected) in exact()
        .into_iter()
        .zip([[0.1, 0.004], [0.15, 0.002], [0.1, 0.1], [0.2, 0.002]])
        .zip([&[0, 1, 2][..], &[0, 1, 2], &[0, 1, 2, 1], &[0, 2]])
        .map(|((exact, distance), expected)| (exact, distance, expected))
    {
        let point = exact.found(&law, s, [2, 3]);
        // A circle in coordinates along the curves, which meet at a tangent in V.
        let level = |v: f64| backbone(exact.a, v, exact.r * v);
        let slope = (level(exact.v + 1e-4) - level(exact.v - 1e-4)) / 2e-4;
        let around = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * (i as f64 + 0.5) / PLACES as f64).sin_cos();
            let along = distance[0] * cos;
            let at = [point.x + along, point.y + s * (slope * along + distance[1] * sin)];
            Oscillator::new(&law, &law.point(1.0, &[exact.a], at[0], at[1]).unwrap())
        };
        let places: Vec<usize> =
            (0..PLACES).map(|i| slip_cycle_count(&around(i), &flow(&around(i), 1e-9)).unwrap()).collect();
        // One place of each region is simulated.
        let (mut counts, mut first) = (Vec::new(), 0);
        for region in places.chunk_by(|a, b| a == b) {
            let middle = first + region.len() / 2;
            assert_eq!(cycles(&around(middle)), region[0], "{exact:?} {middle}");
            counts.push(region[0]);
            first += region.len();
        }
        if counts.len() > 1 && counts.first() == counts.last() {
            counts.pop();
        }
        // In the order in which the circle passes them, from the fewest; cycles far from the point are in all.
        let least = (0..counts.len()).min_by_key(|i| counts[*i]).unwrap();
        counts.rotate_left(least);
        let fewest = counts[0];
        counts.iter_mut().for_each(|count| *count -= fewest);
        let mut turned = expected.to_vec();
        turned[1..].reverse();
        assert!(counts == expected || counts == turned, "{exact:?} {counts:?} {expected:?}");
    }
}
