//! Maps over the quantities of a machine, and their cells one by one.

use std::f64::consts::PI;

use crate::command::{Says, Scratch};
use slipmap::column::{Method, Regime, Verdict};
use slipmap::config::load_machine;
use slipmap::map::unravel;
use slipmap::probe::Answer;
use slipmap::store::{MapFile, Pick};

/// A machine under a law; lines of `more` replace or add quantities, and leave those out that have no value.
fn text(friction: &str, more: &str) -> String {
    let usual = "mass = 2.0\nstiffness = 800.0\nnormal_force = 50.0\nbelt_speed = 0.1\ndamping = [0.0, 2.0, 6.0, 12.0]";
    let is_given = |line: &str| more.lines().any(|given| given.split('=').next() == line.split('=').next());
    let kept = usual.lines().filter(|line| !is_given(line)).chain(more.lines());
    let lines: Vec<&str> = kept.filter(|line| !line.ends_with("= ")).collect();
    format!("[friction]\n{friction}\n[machine]\n{}\n[output]\npath = \"map.h5\"\n", lines.join("\n"))
}

/// From 0.3 to 0.4 within 0.25 m/s, less what is given of these.
fn coefficients(more: &str) -> String {
    let all = "static_friction = 0.4\nkinetic_friction = 0.3\nstribeck_velocity = 0.25";
    let kept = all.lines().filter(|line| !more.contains(line.split('=').next().unwrap()));
    kept.chain(more.lines()).collect::<Vec<_>>().join("\n")
}

#[test]
fn cells_of_a_map_over_any_quantities_are_those_of_probe() {
    let forces = "normal_force = { from = 20.0, to = 80.0, points = 5 }";
    let speeds = "belt_speed = { from = 0.05, to = 0.4, points = 6 }";
    let stiffness = "stiffness = { from = 200.0, to = 3000.0, points = 5 }";
    let rest = "static_friction = { from = 0.3, to = 0.6, points = 5 }";
    let two = "mass = [1.0, 3.0]\nstiffness = [400.0, 900.0]\nnormal_force = [30.0, 60.0]\n\
               kinetic_friction = [0.1, 0.3]\nbelt_speed = [0.1, 0.3]";
    let of_formula =
        "muk = [0.2, 0.3]\nvs = 0.25\nnormal_force = [30.0, 60.0]\nbelt_speed = [0.1, 0.3]".to_owned();
    let rotation = "motion = \"rotation\"\nstiffness = \nnormal_force = \ndamping = \nfrequency = [2.0, 4.0]\n\
                    pressure = [1e5, 3e5]\narea = 2e-3\nradius = 0.1\nexponent = [1.0, 1.5]\n\
                    damping_ratio = [0.0, 0.02, 0.1, 0.3]\nbelt_speed = [0.1, 0.3]";
    // At half of the nodes kinetic friction exceeds that at rest.
    let blank = "static_friction = [0.2, 0.4]\nkinetic_friction = [0.1, 0.3]\nbelt_speed = [0.1, 0.2, 0.4]";
    let formula = "law = \"expression\"\nphi = \"muk + (0.4 - muk)*exp(-u/vs)\"";
    let (exponential, stribeck) = ("law = \"exponential\"", "law = \"stribeck\"");
    let with = |lines: &[&str]| coefficients(&lines.join("\n"));
    for (friction, quantities, axes) in [
        (exponential, with(&[forces, speeds]), "normal_force belt_speed damping"),
        (stribeck, with(&[stiffness, speeds]), "stiffness belt_speed damping"),
        (exponential, with(&[rest, forces]), "normal_force static_friction belt_speed damping"),
        (stribeck, with(&[two]), "mass stiffness normal_force kinetic_friction belt_speed damping"),
        (formula, of_formula, "normal_force muk belt_speed damping"),
        (exponential, with(&[rotation]), "frequency pressure exponent belt_speed damping_ratio"),
        (stribeck, with(&[blank]), "static_friction kinetic_friction belt_speed damping"),
    ] {
        let scratch = Scratch::new();
        let axes: Vec<&str> = axes.split(' ').collect();
        scratch.file("machine.toml", text(friction, &quantities));
        let told = scratch.run("run machine.toml --quiet").ends_with(0).out;
        scratch.run("check map.h5").ends_with(0);
        let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
        let grid = map.grid();
        assert_eq!(grid.axes().iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), axes);
        let all = vec![Pick::Every(1); axes.len()];
        let verdicts = map.code_slice("verdict_simulation", &all).unwrap();
        let regimes = map.code_slice("regime", &all).unwrap();
        let last = axes.last().unwrap();
        let critical = map.real_slice(&format!("critical_{last}_simulation"), &all[1..]).unwrap();
        let errors = map.real_slice(&format!("critical_{last}_error_simulation"), &all[1..]).unwrap();
        let shape = grid.shape();
        let mut seen = std::collections::BTreeSet::new();
        let mut blank = 0;
        for cell in 0..grid.cells() {
            let index = unravel(cell, &shape);
            let set =
                grid.axes().iter().zip(grid.values(&index)).map(|(axis, value)| (axis.name.clone(), value));
            let column = &index[..index.len() - 1];
            let Ok(job) = load_machine(&scratch.path().join("machine.toml"), &set.collect::<Vec<_>>()) else {
                // A node without a machine is blank.
                assert_eq!(
                    (verdicts[&index[..]], regimes[&index[..]]),
                    (Verdict::Failed.code(), Regime::Failed.code())
                );
                assert!(critical[column].is_nan() && errors[column].is_nan());
                blank += 1;
                continue;
            };
            let model = job.machine.model().unwrap();
            let answer = Answer::of(&model.law, &model.point, 1e-9, [Method::Simulation].into_iter());
            let verdict = answer.methods[0].verdict;
            assert_eq!(verdicts[&index[..]], verdict.code(), "{job:?}");
            assert_eq!(regimes[&index[..]], answer.regime.code(), "{job:?}");
            seen.insert(verdict.code());
            let root = answer.critical.unwrap();
            let unit = job.machine.damping_unit();
            let (value, error) = (critical[column], errors[column]);
            // Both have errors of their own.
            assert!((value - root.c * unit).abs() <= error + root.error * unit, "{value} {root:?}");
        }
        assert!(seen.len() > 1, "the map has one verdict alone");
        let cells = grid.cells();
        let words =
            format!("no machine in {blank} of {cells} cells, which are blank: at static_friction = 0.2");
        assert_eq!(told.contains(&words), blank > 0, "{told}");
        assert_eq!(blank, if axes.contains(&"kinetic_friction") && axes.len() == 4 { cells / 4 } else { 0 });
        if blank > 0 {
            scratch.run("report map.h5 --out report").ends_with(0);
        }
    }
}

/// A machine as people have its numbers.
fn people() -> String {
    let coefficients =
        "static_friction = \"40 %\"\nkinetic_friction = 0.25\nstribeck_velocity = \"10 rpm\"\nexponent = 2";
    format!(
        "[friction]\nlaw = \"exponential\"\n[machine]\nmotion = \"rotation\"\ninertia = \"4000 kg cm^2\"\n\
         frequency = \"600 1/min\"\ndamping_ratio = \"2 %\"\npressure = \"20 bar\"\narea = \"5 cm2\"\n\
         radius = \"100 mm\"\n{coefficients}\nbelt_speed = {{ from = \"20 rpm\", to = \"60 rpm\", points = 3 }}\n\
         [output]\npath = \"map.h5\"\n"
    )
}

/// Its map over speed and damping ratio, and the command that draws it.
const PLOT: [&str; 6] = ["plot", "plane.h5", "--x", "belt_speed", "--y", "damping_ratio"];

fn plane() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("people.toml", people());
    let plane = ["run", "people.toml", "--quiet", "--set", "machine.damping_ratio=[\"2 %\", \"4 %\"]"];
    scratch.run(&[&plane[..], &["--set", "output.path=plane.h5"]].concat()).ends_with(0);
    scratch
}

#[test]
fn inputs_are_in_the_units_that_people_have() {
    let scratch = Scratch::new();
    scratch.file("people.toml", people());
    let job = load_machine::<f64>(&scratch.path().join("people.toml"), &[]).unwrap();
    // 20 bar on 5 cm^2 are 1 kN, at 100 mm.
    let (mass, stiffness) = (0.4, 0.4 * (20.0 * PI).powi(2));
    let damping = 0.04 * f64::sqrt(mass * stiffness);
    let machine = &job.machine;
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 8.0 * f64::EPSILON, "{a} {b}");
    close(machine.mass, mass);
    close(machine.stiffness, stiffness);
    close(machine.damping, damping);
    close(machine.normal_force, 100.0);
    assert_eq!(job.varied, [("belt_speed", vec![PI * 2.0 / 3.0, PI * 4.0 / 3.0, PI * 2.0])]);
    assert!(job.conversions.contains(&"1 rpm is 0.10472 rad/s".to_owned()), "{:?}", job.conversions);
    // The map, the point, the row of a table and the page.
    scratch.run("run people.toml --quiet").ends_with(0);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let ratio = map.real_slice("critical_damping_ratio_simulation", &[Pick::Node(1)]).unwrap()[[]];
    let name = "critical_damping_ratio_simulation";
    let plot = format!("plot map.h5 --x belt_speed --variable {name} --out c.svg --data c.csv");
    scratch.run(&plot).ends_with(0);
    let drawn = scratch.read("c.csv");
    let speeds: Vec<&str> = drawn.lines().map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(speeds, ["belt_speed [rpm]", "20.0", "40.0", "60.0"], "{drawn}");
    let point = ["probe", "--machine", "people.toml", "--set", "belt_speed=40 rpm"];
    let told = scratch.json(&point);
    let critical = told["machine"]["critical_damping"].as_f64().unwrap();
    assert!(
        (told["machine"]["critical_damping_ratio"].as_f64().unwrap() - ratio).abs() < 1e-9 * ratio,
        "{told}"
    );
    assert!(ratio > 0.02 && (critical * 0.02 / damping / ratio - 1.0).abs() < 1e-9);
    scratch.file("rows.csv", "belt_speed [rpm],pressure [MPa],damping_ratio\n40,2,0.02\n");
    let table = ["probe", "--machine", "people.toml", "--points", "rows.csv", "--out", "out.csv", "--quiet"];
    let run = scratch.run(&table).ends_with(0);
    assert!(run.err.contains("1 MPa is 1e6 Pa") || run.err.contains("1 MPa is 1000000 Pa"), "{}", run.err);
    let rows = scratch.read("out.csv");
    let [head, row] = [0, 1].map(|line| rows.lines().nth(line).unwrap().split(',').collect::<Vec<_>>());
    let position = head.iter().position(|name| *name == "critical_damping [N m s/rad]").unwrap();
    assert!((row[position].parse::<f64>().unwrap() / critical - 1.0).abs() < 1e-9, "{rows}");
}

#[test]
fn marks_are_in_the_units_of_the_figure() {
    let scratch = plane();
    let plot = [&PLOT[..], &["--mark", "marks.csv"]].concat();
    // One in the figure, and its sample in the legend.
    scratch.file("marks.csv", "speed,ratio\n40,3\n");
    scratch.run(&[&plot[..], &["--out", "marks.svg"]].concat()).ends_with(0);
    assert_eq!(scratch.read("marks.svg").matches("fill=\"#d55e00\"").count(), 2);
    // Names of axes tell the columns, and units are converted.
    scratch.file("marks.csv", "ratio,belt_speed [rad/s]\n3,4.1887902047863905\n");
    scratch.run(&[&plot[..], &["--out", "named.svg"]].concat()).ends_with(0);
    let circles = |file: &str| {
        let text = scratch.read(file);
        text.lines().filter(|line| line.starts_with("<circle")).collect::<Vec<_>>().join("")
    };
    assert_eq!(circles("named.svg"), circles("marks.svg"));
    // A spreadsheet's table with words for what was seen: a series for each, of several files.
    scratch.file(
        "rig.csv",
        "Damping ratio;seen;Belt speed [rad/s]\n3;groan;4,1887902047863905\n2,5;smooth;4,5\n",
    );
    scratch.run(&[&plot[..], &["--mark", "rig.csv", "--out", "words.svg"]].concat()).ends_with(0);
    let words = scratch.read("words.svg");
    assert!(["marks", "rig: groan", "rig: smooth"].iter().all(|name| words.contains(name)), "{words}");
}

#[test]
fn marks_that_are_not_in_the_figure_are_told() {
    let scratch = plane();
    let plot = [&PLOT[..], &["--mark", "marks.csv"]].concat();
    scratch.file("marks.csv", "belt_speed [m],ratio\n40,3\n");
    scratch.run(&[&plot[..], &["--out", "wrong.svg"]].concat()).refuses(&["marks.csv:1: column 1"]);
    scratch.file("marks.csv", "pressure,ratio\n40,3\n");
    scratch.run(&[&plot[..], &["--out", "wrong.svg"]].concat()).refuses(&["none of the axes"]);
    scratch.file("marks.csv", "ratio,speed\n3,40\n");
    let run = scratch.run(&[&plot[..], &["--out", "swapped.svg"]].concat()).ends_with(0);
    run.err.says(&["1 of 1 marks lie outside the figure; write belt_speed [rpm], then"]);
}

/// The curves at which regimes change are found without being asked for.
#[test]
fn a_figure_of_regimes_has_the_curves_unless_refused() {
    let scratch = plane();
    let regime = ["--variable", "regime", "--out", "curves.svg"];
    scratch.run(&[&PLOT[..], &regime].concat()).ends_with(0);
    assert!(scratch.read("curves.svg").contains("grazing curve"));
    let regime = ["--variable", "regime", "--no-curves", "--out", "cells.svg"];
    scratch.run(&[&PLOT[..], &regime].concat()).ends_with(0);
    assert!(!scratch.read("cells.svg").contains("grazing curve"));
}

/// The advice is what a run of a machine takes.
#[test]
fn advice_about_a_map_is_what_a_machine_takes() {
    let scratch = plane();
    let few = ["run", "people.toml", "--quiet", "--set", "output.fields=[\"verdict\"]", "--set"];
    scratch.run(&[&few[..], &["output.path=few.h5"]].concat()).ends_with(0);
    let plot_few = "plot few.h5 --x belt_speed --variable critical_damping_simulation --out few.svg";
    scratch.run(plot_few).refuses(&["add \"critical_damping\" to output.fields"]);
    scratch.run("report plane.h5 --epsilon 1").refuses(&["no axis epsilon", "help: leave it out"]);
}

/// Answers are in the unit of the file, and a number without a unit is told to be in SI units.
#[test]
fn answers_are_in_the_units_of_the_file() {
    let scratch = Scratch::new();
    scratch.file("people.toml", people());
    let page = scratch.run(&["machine", "people.toml", "--set", "belt_speed=40 rpm"]).ends_with(0);
    page.out.says(&["at 40 rpm and "]);
    assert!(!page.err.contains("for rpm write"), "{}", page.err);
    let bare = scratch.run("probe --machine people.toml --set belt_speed=4").ends_with(0);
    let told = "belt_speed = 4 is in rad/s; for rpm write --set 'machine.belt_speed=4 rpm'";
    bare.err.says(&[told]);
}

#[test]
fn quantities_that_say_the_same_are_refused() {
    let (scratch, people) = (Scratch::new(), people());
    for (from, to, words) in [
        ("frequency", "stiffness = 1e3\nfrequency", "the mass and the stiffness have a frequency already"),
        ("damping_ratio", "damping = 1.0\ndamping_ratio", "damping_ratio stands in place of damping"),
        ("area = \"5 cm2\"", "", "area"),
        (
            "pressure = \"20 bar\"\narea = \"5 cm2\"\nradius = \"100 mm\"",
            "normal_force = \"50 kN\"",
            "with radius = .. it is a force",
        ),
        ("\"40 %\"", "\"40 N\"", "friction that is a force already"),
    ] {
        assert!(people.contains(from), "{from}");
        scratch.file("wrong.toml", people.replacen(from, to, 1));
        scratch.run("run wrong.toml --dry-run").ends_with(2).err.says(&[words]);
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
                ("normal_force".to_owned(), weight),
                ("belt_speed".to_owned(), rpm * PI / 30.0),
                ("damping".to_owned(), damping),
            ];
            let machine = load_machine(&scratch.path().join("drill.toml"), &values).unwrap().machine;
            let model = machine.model().unwrap();
            model.column().in_unit(model.si.damping)
        };
        // The thresholds have seven digits, those of the Hopf bifurcation six.
        let critical = |rpm: f64| slipmap::column::critical_damping(&column(rpm), 1e-11).unwrap().c;
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
    let quantities = coefficients("normal_force = [20.0, 50.0]");
    scratch.file("machine.toml", text("law = \"exponential\"", &quantities));
    scratch.run("run machine.toml --quiet").ends_with(0);
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
    let plot = "plot map.h5 --x normal_force --y damping --variable regime --curves --out p.svg";
    scratch.run(plot).ends_with(0);
    assert!(scratch.read("p.svg").contains("normal force, N"));
    scratch.run("report map.h5 --out report").ends_with(0);
    assert!(scratch.read("report/figures/regimes.svg").contains(">stick-slip<"));
    let has = |table: &str, line: &str| {
        let text = scratch.read(&format!("report/tables/{table}.csv"));
        assert!(text.contains(line), "{line}: {text}");
    };
    // The law, what is held, and volumes as shares.
    has("law", "\"friction in slip, at slip speed u\",,μ(u) = μk + (μs − μk) exp(−u / vs) + η u,1\n");
    has("law", "static friction,μs,0.4,1\n");
    has("law", "friction at rest,μ(0),0.4,1\n");
    has("law", "\"drop, the difference of these\",,0,1\n");
    has("axes", "mass,mass,1,2.0,2.0,kg,one value\n");
    has(
        "volume",
        "method,percent_of_box,percent_of_box_error_in_c,percent_of_box_error,percent_of_simulation",
    );
    assert!(
        scratch.read("report/report.tex").contains(
            r"\mu(u) = \mu_{k} + \left(\mu_{s} - \mu_{k}\right)\, \exp\left(\frac{-u}{v_{s}}\right)"
        )
    );
}
