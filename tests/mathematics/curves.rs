//! Curves of codimension one compared with closed forms, root-finding along single columns, and direct
//! simulation on both sides.

use crate::sample::slip_cycles;
use slipmap::column::backbone::Backbone;
use slipmap::column::bifurcation::{Bifurcation, CurveWork};
use slipmap::column::continuation::{Branch, CurvePoint, zero_curves};
use slipmap::column::critical_damping;
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::{Expression, Law, Table};
use slipmap::map::{Grid, Plane, PlaneCurves};
use slipmap::point::LawParameters;
use slipmap::witness;

use crate::sample::{at_one, formula};

const TOLERANCE: f64 = 1e-11;

/// The curves in a plane of two parameters, of which `at` maps the unit square to oscillators.
fn curves(kind: Bifurcation, at: &(dyn Fn([f64; 2]) -> Oscillator + Sync)) -> Vec<Branch> {
    let work = CurveWork::default();
    zero_curves(&|place| kind.test(&at(place), TOLERANCE, &work), &|| work.is_spent()).0
}

/// A number between two others.
fn between([from, to]: [f64; 2], share: f64) -> f64 {
    from + (to - from) * share
}

/// The largest distance between a curve and its chords, in sides of the square: an eighth of the longest
/// step, 1/40, times the largest turn, 0.2.
const SAG: f64 = 6.3e-4;

/// y of the curves at x, on their chords.
fn heights(curves: &[Branch], x: f64) -> Vec<f64> {
    let chords = curves.iter().flat_map(|branch| branch.points.windows(2));
    let crossing = |ends: &[CurvePoint]| {
        let [a, b] = [ends[0].place, ends[1].place];
        let share = (x - a[0]) / (b[0] - a[0]);
        (0.0..1.0).contains(&share).then(|| a[1] + (b[1] - a[1]) * share)
    };
    chords.filter_map(crossing).collect()
}

/// Both neighbours of each inner point of a branch on the normal, at a distance.
fn sides(branch: &Branch, distance: f64) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    branch.points.windows(3).map(move |points| {
        let [a, b] = [points[0].place, points[2].place];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let normal = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
        [distance, -distance].map(|d| [0, 1].map(|i| points[1].place[i] + d * normal[i]))
    })
}

/// A block of 10 kg on a spring of 4,000 N/m, whose friction falls within 1 mm/s: the Hopf damping fades to
/// numbers that are rounding, and is no curve there.
#[test]
fn the_hopf_line_of_a_law_that_fades_is_traced_once() {
    let (velocity, width) = (0.3 * 98.1 / 200.0, 1e-3);
    let law = [2.0 / 3.0, width / velocity, 0.0];
    for speeds in [[0.002, 0.2], [0.005, 0.2], [0.005, 0.1], [0.01, 1.0]] {
        let at = |[x, y]: [f64; 2]| {
            let speed = between(speeds, x) / velocity;
            at_one(&Law::Exponential, &law, speed, between([0.0, 0.1], y))
        };
        let curves = curves(Bifurcation::Hopf, &at);
        assert!(curves.len() <= 1, "{speeds:?}: {}", curves.len());
        for point in curves.iter().flat_map(|curve| &curve.points) {
            let belt_speed = between(speeds, point.place[0]) / velocity;
            let rate = at(point.place).curve.weakening(belt_speed);
            // Means over an orbit have the size of all that friction falls, divided by the belt speed.
            assert!(rate > 4.0 * f64::EPSILON * (1.0 - law[0]) / belt_speed, "{speeds:?}: {point:?}");
        }
    }
}

#[test]
fn the_hopf_line_of_the_stribeck_law_is_its_closed_form() {
    // trace zero: c = gamma (1 - alpha) / (1 + eps gamma V)^2 - 2 beta V.
    let (epsilon, alpha, beta, belt_speed) = (0.2, 0.3, 0.05, 1.5);
    let exact = |gamma: f64| {
        gamma * (1.0 - alpha) / (1.0 + epsilon * gamma * belt_speed).powi(2) - 2.0 * beta * belt_speed
    };
    let (gammas, cs) = ([0.1, 12.0], [0.0, 1.0]);
    let at = |[x, y]: [f64; 2]| {
        let law = [alpha, beta, between(gammas, x)];
        let point = Law::Stribeck.point(epsilon, &law, belt_speed, between(cs, y)).unwrap();
        Oscillator::new(&Law::Stribeck, &point)
    };
    let curves = curves(Bifurcation::Hopf, &at);
    assert_eq!(curves.len(), 1);
    for point in &curves[0].points {
        let [gamma, c] = [between(gammas, point.place[0]), between(cs, point.place[1])];
        // |dc/dx| is at most 12 (the range of gamma) times |dc/dgamma| <= 0.7.
        assert!((c - exact(gamma)).abs() <= 8.5 * point.error && point.error < 1e-13, "{point:?}");
    }
    // The curve is complete: wherever the closed form lies inside, so does the curve, and nowhere else.
    for i in 1..400 {
        let x = f64::from(i) / 400.0;
        let wanted = exact(between(gammas, x));
        let found = heights(&curves, x);
        if wanted > 0.01 && wanted < 0.99 {
            assert_eq!(found.len(), 1, "{x}");
            assert!((found[0] - wanted).abs() <= 8.5 * SAG, "{x} {found:?} {wanted}");
        } else if wanted < -0.01 {
            assert!(found.is_empty(), "{x} {found:?}");
        }
    }
}

#[test]
fn grazing_is_the_critical_damping_in_every_plane() {
    let stribeck = |gammas: [f64; 2], speeds: &[f64], cs: &[f64]| {
        vec![vec![0.3], vec![0.2], vec![0.02], gammas.to_vec(), speeds.to_vec(), cs.to_vec()]
    };
    let lorentzian = vec![vec![1.0], vec![0.0], vec![1.0], vec![0.0], vec![0.1, 1.5], vec![0.0, 0.8]];
    for (law, nodes, [x, y]) in [
        (Law::Stribeck, stribeck([0.1, 5.0], &[1.2], &[0.0, 2.0]), [3, 5]),
        (Law::Stribeck, stribeck([0.1, 5.0], &[0.2, 6.0], &[0.4]), [3, 4]),
        (Law::Lorentzian, lorentzian, [5, 4]),
    ] {
        let axes = nodes.clone();
        let grid = Grid::new(law.clone(), nodes).unwrap();
        let name = [x, y].map(|axis| grid.axes()[axis].name.clone()).join(", ");
        let kinds = [Bifurcation::GrazingSliding];
        let found = PlaneCurves::of_kinds(&kinds, &grid, Plane::new(x, y, vec![0; 6]), &false.into());
        assert!(!found.curves.is_empty(), "{name}");
        let range = |axis: usize| [axes[axis][0], axes[axis][1]];
        let mut points = 0;
        for curve in &found.curves {
            let places = curve.points.iter().map(|point| {
                [(x, point.x), (y, point.y)].map(|(axis, value)| {
                    let [from, to] = range(axis);
                    (value - from) / (to - from)
                })
            });
            let places: Vec<[f64; 2]> = places.collect();
            // It has no gap: it ends on the border.
            for end in [places[0], places[places.len() - 1]] {
                assert!(end.iter().any(|share| share.min(1.0 - share).abs() < 1e-12), "{name} {end:?}");
            }
            for (point, &place) in curve.points.iter().zip(&places).step_by(2) {
                let excess = |place: [f64; 2]| {
                    let mut values: Vec<f64> = axes.iter().map(|nodes| nodes[0]).collect();
                    for (axis, share) in [x, y].into_iter().zip(place) {
                        values[axis] = between(range(axis), share);
                    }
                    let root = critical_damping(&grid.column_of(&values).unwrap(), 1e-12).unwrap();
                    (root.c - values[5], root.error)
                };
                let (here, error) = excess(place);
                // Its slope, by differences well above the errors of c*.
                let slope = [0, 1].map(|axis| {
                    let step = if place[axis] > 0.5 { -1e-4 } else { 1e-4 };
                    let mut beside = place;
                    beside[axis] += step;
                    (excess(beside).0 - here) / step
                });
                let allowed = slope[0].hypot(slope[1]) * point.error + error;
                // The slope is right to a thousandth.
                assert!(here.abs() <= 1.01 * allowed, "{name} {point:?} {here} {allowed}");
                assert!(point.error < 1e-9, "{name} {point:?}");
                points += 1;
            }
        }
        assert!(points > 15, "{name}: {points}");
    }
}

/// On one side of every point of the curves of a kind, over belt speeds and dampings, the direct engine finds a
/// fate that `is_so`, and not on the other.
fn direct_simulation_confirms(
    kind: Bifurcation,
    [speeds, cs]: [[f64; 2]; 2],
    is_so: impl Fn(&Fate) -> Option<bool>,
) {
    let at = |[x, y]: [f64; 2]| {
        let (speed, damping) = (between(speeds, x), between(cs, y));
        let point = Law::Stribeck.point(1.0, &[0.0, 0.0, 0.1], speed, damping).unwrap();
        Oscillator::new(&Law::Stribeck, &point)
    };
    let curves = curves(kind, &at);
    assert!(!curves.is_empty());
    let mut points = 0;
    for branch in &curves {
        assert!(branch.points.iter().all(|point| point.error < 1e-8), "{branch:?}");
        // The direct engine locates landings to 1e-10 or so; a millionth of the plane moves wL far more.
        for places in sides(branch, 1e-6) {
            let found = places.map(|place| {
                let fate = witness::flow(&at(place), TOLERANCE).fate;
                is_so(&fate).unwrap_or_else(|| panic!("{place:?} {fate:?}"))
            });
            assert_ne!(found[0], found[1], "{places:?}");
            points += 1;
        }
    }
    assert!(points > 20, "{points}");
}

#[test]
fn direct_simulation_confirms_the_landing_curve() {
    // theory, "Statements that do not hold": at V = 30 the orbit crosses at c = 0 and sticks at c = 0.01.
    direct_simulation_confirms(Bifurcation::Landing, [[10.0, 60.0], [0.0, 0.05]], |fate| match fate {
        Fate::Sticks(landing) => Some(landing.crossings == Some(0)),
        Fate::CrossesForever => Some(false),
        _ => None,
    });
}

#[test]
fn direct_simulation_confirms_the_crossing_curve() {
    direct_simulation_confirms(Bifurcation::Crossing, [[5.0, 60.0], [0.0, 0.02]], |fate| match fate {
        Fate::Sticks(landing) if landing.crossings == Some(1) => Some(false),
        Fate::CrossesForever => Some(true),
        _ => None,
    });
}

#[test]
fn two_slip_cycles_vanish_at_a_fold() {
    // As in slip_laws.rs: the weakening e (1 - a cos k u) feeds e (1 - a cos(k) g(k r)) pi r^2 into a turn at
    // V = 1, to first order in e, with g(x) = 2 J1(x)/x. Two cycles lie around the minimum of g, -0.132280 at
    // x = 5.1356, and vanish at c = e (1 + 0.13228 a cos k).
    let (e, a) = (0.01, 1.5);
    let law = Expression::new("1 - s*(u - a*sin(k*u)/k)", 1.0).unwrap();
    // cos k > 0 on this range.
    let (ks, levels) = ([6.6, 7.4], [1.0, 1.3]);
    let at = |[x, y]: [f64; 2]| Oscillator {
        curve: Law::Expression(law.clone()).curve(1.0, &LawParameters::new(&[e, a, between(ks, x)])),
        viscous: e * between(levels, y),
        belt_speed: 1.0,
    };
    let curves = curves(Bifurcation::Fold, &at);
    assert_eq!(curves.len(), 1, "{curves:?}");
    for point in &curves[0].points {
        let [k, level] = [between(ks, point.place[0]), between(levels, point.place[1])];
        // The next order is smaller by the divergence, at most e (1 + a), times slopes of order one.
        assert!((level - 1.0 - 0.13228 * a * k.cos()).abs() < 2.0 * e * (1.0 + a), "{k} {level}");
        assert!(point.error < 1e-4, "{point:?}");
    }
    // Near the left and right ends cycles may also leave through the belt line or the equilibrium. They
    // change the counts on both sides equally, so the difference of the counts is due to the fold alone.
    for places in sides(&curves[0], 1e-3).step_by(3) {
        let [above, below] = places.map(|place| slip_cycles(&at(place), TOLERANCE).unwrap().len());
        assert_eq!(above.abs_diff(below), 2, "{places:?} {above} {below}");
    }
}

/// Laws with branches that are short, end in cusps next to each other, or lie within the range of a few data.
#[test]
fn folds_of_the_backbone_are_the_fold_curves() {
    let places =
        [0.0, 0.41124, 0.73349, 1.22768, 2.09413, 2.30025, 3.56488, 3.82221, 4.05677, 4.15869, 4.54192, 6.5];
    let friction = [
        1.0, 0.84299, 0.74412, 0.59853, 0.60322, 0.54711, 0.53804, 0.51708, 0.55698, 0.49449, 0.48455,
        0.51276,
    ];
    let data: Vec<(f64, f64)> = places.into_iter().zip(friction).collect();
    let (mut seen, mut asked) = (0, 0);
    for (law, speeds, highest) in [
        (formula("0.79444+0.20556*exp(-u/1.7489)+0.034417*(1-cos(5.55185*u))"), [0.1, 3.0], 0.5),
        (formula("1+0.6*u*exp(-u/0.5)-0.4*(1-exp(-(u/0.9)^2))+0.05*(1-cos(9*u))"), [0.1, 2.5], 0.7),
        (Law::Table(Table::new("data", &data, 1.0).unwrap()), [0.1, 2.9], 0.6),
    ] {
        let nodes = vec![vec![1.0], speeds.to_vec(), vec![0.0, highest]];
        let grid = Grid::new(law.clone(), nodes).unwrap();
        let plane = Plane::new(1, 2, vec![0; 3]);
        let folds = PlaneCurves::of_kinds(&[Bifurcation::Fold], &grid, plane, &false.into()).curves;
        for i in 0..20 {
            let speed = between(speeds, (f64::from(i) + 0.37) / 20.0);
            let column = law.column(&law.point(1.0, &[], speed, 0.0).unwrap());
            let backbone = Backbone::of(&column, 1e-10).unwrap();
            let expected: Vec<f64> = backbone
                .folds()
                .iter()
                .map(|fold| fold.viscous)
                .filter(|c| (0.0..highest).contains(c))
                .collect();
            let crossed = folds.iter().flat_map(|curve| curve.points.windows(2)).filter_map(|ends| {
                let share = (speed - ends[0].x) / (ends[1].x - ends[0].x);
                (0.0..1.0).contains(&share).then(|| ends[0].y + (ends[1].y - ends[0].y) * share)
            });
            let crossed: Vec<f64> = crossed.collect();
            let near = |c: f64, others: &[f64]| others.iter().any(|other| (c - other).abs() < 2e-3 * highest);
            asked += expected.len();
            seen += expected.iter().filter(|c| near(**c, &crossed)).count();
            assert!(crossed.iter().all(|c| near(*c, &expected)), "{speed} {crossed:?} {expected:?}");
        }
    }
    // Next to cusps a fold may lie beyond the end of its curve.
    assert!(seen + 1 >= asked && asked > 50, "{seen} of {asked}");
}
