//! Machines: boundaries that are known in closed form over their own quantities.

use slipmap::column::bifurcation::Bifurcation;
use slipmap::friction::{Expression, Law, Range};
use slipmap::machine::{Machine, Model, Motion};
use slipmap::map::{Grid, Plane, PlaneCurves};
use slipmap::probe::Answer;

/// 2 kg on 800 N/m, so that sqrt(k m) = 40 N s/m, with friction from 0.4 to 0.3.
fn machine(law: &Law, more: &[(&str, f64)]) -> Machine {
    let usual = [
        ("mass", 2.0),
        ("stiffness", 800.0),
        ("normal_force", 50.0),
        ("static_friction", 0.4),
        ("kinetic_friction", 0.3),
        ("strengthening", 0.0),
        ("belt_speed", 0.1),
    ];
    let value =
        |name: &str| usual.iter().chain(more).find(|(known, _)| *known == name).map(|(_, value)| *value);
    Machine::new(Motion::Translation, law, value).unwrap()
}

/// The points (normal force, belt speed) of curves of a kind.
fn curve(machine: &Machine, speeds: [f64; 2], kind: Bifurcation) -> Vec<[f64; 2]> {
    let varied = [("normal_force", vec![20.0, 80.0]), ("belt_speed", speeds.to_vec())];
    let grid = Grid::of_machine(machine, &varied).unwrap();
    let place = |name: &str| grid.axes().iter().position(|axis| axis.name == name).unwrap();
    let plane = Plane::new(place("normal_force"), place("belt_speed"), vec![0; grid.axes().len()]);
    let found = PlaneCurves::of_kinds(&[kind], &grid, plane, &false.into());
    found.curves.iter().flat_map(|curve| &curve.points).map(|point| [point.x, point.y]).collect()
}

#[test]
fn the_exponential_hopf_curve_is_a_logarithm_of_force() {
    let (width, damping) = (0.25, 4.0);
    let machine = machine(&Law::Exponential, &[("stribeck_velocity", width), ("damping", damping)]);
    let points = curve(&machine, [0.05, 1.0], Bifurcation::Hopf);
    let [from, to] = [0, points.len() - 1].map(|end| points[end][0]);
    assert!((from - to).abs() > 20.0, "{from} {to}");
    for [force, speed] in points {
        let exact = width * (0.1 * force / (width * damping)).ln();
        assert!((speed / exact - 1.0).abs() < 1e-9, "{force} {speed} {exact}");
    }
}

/// lambda = v sqrt(k m)/((mu_s - mu_k) N), by the closed form, see `drop.rs`.
#[test]
fn two_coefficients_have_a_boundary_linear_in_force() {
    for (ratio, lambda) in [(0.01, 2.73924041678774), (0.2, 0.366973926704089)] {
        let machine = machine(&Law::Coulomb, &[("damping_ratio", ratio)]);
        let slope = lambda * 0.1 / 40.0;
        let points = curve(&machine, [10.0 * slope, 100.0 * slope], Bifurcation::GrazingSliding);
        let [from, to] = [0, points.len() - 1].map(|end| points[end][0]);
        assert!((from - to).abs() > 59.0, "{from} {to}");
        for [force, speed] in points {
            assert!((speed / (slope * force) - 1.0).abs() < 1e-9, "{force} {speed}");
        }
    }
}

/// The mass under the bow of S. Bilbao, *Numerical Sound Synthesis* (2009), with friction at rest added, which its law lacks:
/// velocity amplitudes in m/s as they are published, and as SciPy integrates friction that rises to rest within 1 mm/s.
#[test]
fn a_bowed_mass_has_its_published_amplitudes() {
    for (added, published, integrated) in
        [("0.1", 0.3332, 0.333_385), ("0.01", 0.3395, 0.339_624), ("0.001", 0.3402, 0.340_400)]
    {
        let law = Expression::new(&format!("200^0.5*u*exp(-100*u^2 + 0.5) + {added}"), 1.0).unwrap();
        let numbers = [
            ("mass", 1e-3),
            ("stiffness", 1e3),
            ("normal_force", 0.5),
            ("belt_speed", 0.1),
            ("damping", 0.0),
        ];
        let value = |name: &str| numbers.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        let machine = Machine::new(Motion::Translation, &Law::Expression(law), value).unwrap();
        let Model { law, point, si } = machine.model().unwrap();
        let Range { lo, hi } = Answer::of(&law, &point, 1e-9, std::iter::empty()).cycle.unwrap().velocity;
        let amplitude = 0.5 * (hi - lo) * si.velocity;
        assert!((amplitude / published - 1.0).abs() < 1e-3, "{amplitude} {published}");
        assert!((amplitude / integrated - 1.0).abs() < 5e-5, "{amplitude} {integrated}");
    }
}
