//! Maps over the quantities of a machine, and their cells one by one.

use std::f64::consts::PI;

use crate::command::Scratch;
use slipmap::config::load_machine;
use slipmap::map::{Method, unravel};
use slipmap::probe::Answer;
use slipmap::store::{MapFile, Pick};

/// A machine under the law `law`; `more` replaces or adds quantities.
fn text(friction: &str, more: &[(&str, &str)]) -> String {
    let usual = [
        ("mass", "2.0"),
        ("stiffness", "800.0"),
        ("normal_force", "50.0"),
        ("belt_speed", "0.1"),
        ("damping", "[0.0, 2.0, 6.0, 12.0]"),
    ];
    let mut text = format!("[friction]\n{friction}\n[machine]\n");
    let is_given = |name: &str| more.iter().any(|(known, _)| *known == name);
    for (name, value) in usual.iter().filter(|(name, _)| !is_given(name)).chain(more) {
        text += &format!("{name} = {value}\n");
    }
    text + "[output]\npath = \"map.h5\"\n"
}

const EXPONENTIAL: [(&str, &str); 3] =
    [("static_friction", "0.4"), ("kinetic_friction", "0.3"), ("stribeck_velocity", "0.25")];

#[test]
fn cells_of_a_map_over_any_quantities_are_those_of_probe() {
    let range =
        |from: f64, to: f64, points: u32| format!("{{ from = {from:?}, to = {to:?}, points = {points} }}");
    let with = |varied: &[(&'static str, String)]| -> Vec<(&'static str, String)> {
        let kept = EXPONENTIAL.iter().filter(|(name, _)| varied.iter().all(|(known, _)| known != name));
        kept.map(|(name, value)| (*name, (*value).to_owned())).chain(varied.to_vec()).collect()
    };
    let formula = "law = \"expression\"\nphi = \"muk + (0.4 - muk)*exp(-u/vs)\"";
    type Quantities = Vec<(&'static str, String)>;
    let cases: [(&str, Quantities, &[&str]); 5] = [
        (
            "law = \"exponential\"",
            with(&[("normal_force", range(20.0, 80.0, 5)), ("belt_speed", range(0.05, 0.4, 6))]),
            &["normal_force", "belt_speed", "damping"],
        ),
        (
            "law = \"stribeck\"",
            with(&[("stiffness", range(200.0, 3000.0, 5)), ("belt_speed", range(0.05, 0.4, 6))]),
            &["stiffness", "belt_speed", "damping"],
        ),
        (
            "law = \"exponential\"",
            with(&[("static_friction", range(0.3, 0.6, 5)), ("normal_force", range(20.0, 80.0, 5))]),
            &["normal_force", "static_friction", "belt_speed", "damping"],
        ),
        (
            "law = \"stribeck\"",
            with(&[
                ("mass", "[1.0, 3.0]".into()),
                ("stiffness", "[400.0, 900.0]".into()),
                ("normal_force", "[30.0, 60.0]".into()),
                ("kinetic_friction", "[0.1, 0.3]".into()),
                ("belt_speed", "[0.1, 0.3]".into()),
            ]),
            &["mass", "stiffness", "normal_force", "kinetic_friction", "belt_speed", "damping"],
        ),
        (
            formula,
            vec![
                ("muk", "[0.2, 0.3]".into()),
                ("vs", "0.25".into()),
                ("normal_force", "[30.0, 60.0]".into()),
                ("belt_speed", "[0.1, 0.3]".into()),
            ],
            &["normal_force", "muk", "belt_speed", "damping"],
        ),
    ];
    for (friction, quantities, axes) in cases {
        let scratch = Scratch::new();
        let quantities: Vec<(&str, &str)> =
            quantities.iter().map(|(name, value)| (*name, value.as_str())).collect();
        scratch.file("machine.toml", text(friction, &quantities));
        scratch.run(&["run", "machine.toml", "--quiet"]).ends_with(0);
        scratch.run(&["check", "map.h5"]).ends_with(0);
        let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
        let grid = map.grid();
        assert_eq!(grid.axes().iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), axes);
        let all = vec![Pick::Every(1); axes.len()];
        let verdicts = map.code_slice("verdict_simulation", &all).unwrap();
        let regimes = map.code_slice("regime", &all).unwrap();
        let critical = map.real_slice("critical_damping_simulation", &all[1..]).unwrap();
        let errors = map.real_slice("critical_damping_error_simulation", &all[1..]).unwrap();
        let shape = grid.shape();
        let mut seen = std::collections::BTreeSet::new();
        for cell in 0..grid.cells() {
            let index = unravel(cell, &shape);
            let set =
                grid.axes().iter().zip(grid.values(&index)).map(|(axis, value)| (axis.name.clone(), value));
            let job = load_machine(&scratch.path().join("machine.toml"), &set.collect::<Vec<_>>()).unwrap();
            let model = job.machine.model().unwrap();
            let answer = Answer::of(&model.law, &model.point, 1e-9, [Method::Simulation].into_iter());
            let verdict = answer.methods[0].verdict;
            assert_eq!(verdicts[&index[..]], verdict.code(), "{job:?}");
            assert_eq!(regimes[&index[..]], answer.regime.code(), "{job:?}");
            seen.insert(verdict.code());
            let root = answer.critical.unwrap();
            let unit = model.si.units.damping;
            let (value, error) = (critical[&index[..index.len() - 1]], errors[&index[..index.len() - 1]]);
            // Both have errors of their own.
            assert!((value - root.c * unit).abs() <= error + root.error * unit, "{value} {root:?}");
        }
        assert!(seen.len() > 1, "the map has one verdict alone");
    }
}

/// Four published thresholds of the drill string, by weight on bit, and the Hopf bifurcation of steady drilling.
#[test]
fn the_drill_string_starts_to_stick_at_its_thresholds() {
    let scratch = Scratch::new();
    let config = std::fs::read_to_string(format!("{}/configs/drill_string.toml", env!("CARGO_MANIFEST_DIR")));
    scratch.file("drill.toml", config.unwrap());
    let damping = 222.3067;
    for (weight, sticks, hopf) in [
        (20e3, 17.45903, 14.1061),
        (30e3, 24.83689, 18.4082),
        (50e3, 36.42244, 23.8283),
        (80e3, 50.33051, 28.8151),
    ] {
        let column = |rpm: f64| {
            let values = [
                ("normal_force".to_owned(), weight * 0.155_575),
                ("belt_speed".to_owned(), rpm * PI / 30.0),
                ("damping".to_owned(), damping),
            ];
            let machine = load_machine(&scratch.path().join("drill.toml"), &values).unwrap().machine;
            let model = machine.model().unwrap();
            model.column().in_unit(model.si.units.damping)
        };
        // The thresholds have seven digits, those of the Hopf bifurcation six.
        let critical = |rpm: f64| slipmap::simulate::critical_damping(&column(rpm), 1e-11).unwrap().c;
        assert!(critical(sticks - 1e-5) > damping && critical(sticks + 1e-5) < damping, "{weight}");
        let unstable = |rpm: f64| {
            let column = column(rpm);
            column.curve.weakening(column.belt_speed) > column.epsilon * damping
        };
        assert!(unstable(hopf - 1e-4) && !unstable(hopf + 1e-4), "{weight}");
    }
}

/// Units, scalars and coordinates, as readers of NetCDF see them.
#[test]
fn the_file_has_its_axes_in_si_units() {
    let scratch = Scratch::new();
    let mut quantities = EXPONENTIAL.to_vec();
    quantities.push(("normal_force", "[20.0, 50.0]"));
    scratch.file("machine.toml", text("law = \"exponential\"", &quantities));
    scratch.run(&["run", "machine.toml", "--quiet"]).ends_with(0);
    let file = hdf5::File::open(scratch.path().join("map.h5")).unwrap();
    let attribute = |variable: &str, name: &str| {
        let attribute = file.dataset(variable).unwrap().attr(name).unwrap();
        attribute.read_scalar::<hdf5::types::FixedUnicode<256>>().unwrap().to_string()
    };
    for (name, unit) in [
        ("normal_force", "N"),
        ("belt_speed", "m/s"),
        ("damping", "N s/m"),
        ("mass", "kg"),
        ("static_friction", "1"),
        ("critical_damping_simulation", "N s/m"),
        ("critical_damping_error_simulation", "N s/m"),
        ("regime", "1"),
    ] {
        assert_eq!(attribute(name, "units"), unit, "{name}");
    }
    assert_eq!(file.dataset("mass").unwrap().ndim(), 0);
    let fixed = "mass stiffness static_friction kinetic_friction stribeck_velocity strengthening";
    assert_eq!(attribute("critical_damping_simulation", "coordinates"), fixed);
    // The drawing, and the report, of another plane than belt speed and damping.
    let plot =
        ["plot", "map.h5", "--x", "normal_force", "--y", "damping", "--variable", "regime", "--curves"];
    scratch.run(&[&plot[..], &["--out", "p.svg"]].concat()).ends_with(0);
    assert!(scratch.read("p.svg").contains("normal force, N"));
    scratch.run(&["report", "map.h5", "--out", "report"]).ends_with(0);
}
