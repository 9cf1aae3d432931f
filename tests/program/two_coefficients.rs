//! Friction at rest above friction in slip, through the program: machines that were published, the ways to write a drop,
//! and a map over it.

use serde_json::Value;
use slipmap::friction::Law;
use slipmap::store::MapFile;

use crate::command::Scratch;

fn near(value: &Value, expected: f64, relative: f64) {
    let value = value.as_f64().unwrap();
    assert!((value / expected - 1.0).abs() <= relative, "{value} {expected}");
}

/// A sliding block, a rotating disc and a pull test, each from its static and kinetic friction alone.
#[test]
fn published_machines_have_their_numbers() {
    let scratch = Scratch::new();
    let machine = |[motion, mass, numbers]: [&str; 3]| {
        let text =
            format!("[friction]\nlaw = \"coulomb\"\n[machine]\nmotion = \"{motion}\"\n{mass}\n{numbers}\n");
        scratch.file("machine.toml", text);
        scratch.json("machine machine.toml")
    };
    let block = machine([
        "translation",
        "mass = 10.0",
        "stiffness = 4000.0\nnormal_force = 98.1\nstatic_friction = 0.3\nkinetic_friction = 0.2\nbelt_speed = 0.01\ndamping = 0.0",
    ]);
    // Nine printed digits.
    near(&block["may_stick_slip_below_damping"], 127.484753, 5e-9);
    near(&block["period"], 0.66769, 1e-5);
    let disc = machine([
        "rotation",
        "inertia = 0.0089",
        "stiffness = 0.288\nnormal_force = 0.65\nstatic_friction = 0.7\nkinetic_friction = 0.6\nbelt_speed = 2.0\ndamping = 0.001",
    ]);
    near(&disc["may_stick_slip_below_damping"], 0.00283276133, 5e-9);
    let pull = machine([
        "translation",
        "mass = 1.0",
        "stiffness = 50.0\nnormal_force = 9.81\nstatic_friction = 0.5\nkinetic_friction = 0.3\nbelt_speed = 0.05\ndamping = 0.0",
    ]);
    // It sticks while the spring takes up twice the drop: 2 (0.5 - 0.3) 9.81 / (50 * 0.05).
    near(&pull["stick_time"], 1.5696, 1e-9);
    let page = scratch.run("machine machine.toml").ends_with(0).out;
    assert!(!page.contains("Stribeck velocity"), "{page}");
}

/// The curve that engineers write, with an exponent: by its name, as a formula, and over a map whose axis it is.
#[test]
fn the_exponent_of_the_fall_is_a_parameter() {
    let scratch = Scratch::new();
    let point = ["--epsilon", "1", "--V", "0.5", "--c", "0.1", "--mu", "0.6", "--vs", "0.3", "--eta", "0.02"];
    let formula = |exponent: &str| {
        let phi = format!("0.6 + 0.4*exp(-(u/0.3)^{exponent}) + 0.02*u");
        scratch.json(&["probe", "--phi", &phi, "--epsilon", "1", "--V", "0.5", "--c", "0.1"])
    };
    let named =
        |more: &[&str]| scratch.json(&[&["probe", "--law", "exponential"], &point[..], more].concat());
    let mut dampings = vec![named(&["--exponent", "1"])["critical_c"]["value"].clone()];
    for exponent in ["1.5", "3"] {
        let (named, formula) = (named(&["--exponent", exponent]), formula(exponent));
        assert_eq!(named["regime"], formula["regime"]);
        near(&named["critical_c"]["value"], formula["critical_c"]["value"].as_f64().unwrap(), 1e-10);
        dampings.push(named["critical_c"]["value"].clone());
    }
    assert_eq!(dampings[0], named(&[])["critical_c"]["value"]);
    let refused = [&["probe", "--law", "exponential"], &point[..], &["--exponent", "0.5"]].concat();
    scratch.run(&refused).refuses(&["exponent must be between 1 and 100", "drop"]);
    scratch.file(
        "map.toml",
        "[friction]\nlaw = \"exponential\"\n[grid]\nepsilon = 1.0\nmu = 0.6\nvs = 0.3\neta = 0.02\nexponent = [1.0, 1.5, 3.0]\n\
         V = 0.5\nc = [0.05, 0.1]\n[output]\npath = \"map.h5\"\nfields = [\"critical_c\"]",
    );
    scratch.run("run map.toml --quiet").ends_with(0);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let grid = map.grid();
    assert_eq!(grid.law(), &Law::Stretched);
    assert_eq!(grid.axes()[4].name, "exponent");
    for (i, damping) in dampings.iter().enumerate() {
        let stored = map.reals("critical_c_simulation", &[0..1, 0..1, 0..1, 0..1, i..i + 1, 0..1]).unwrap();
        near(damping, stored[[0; 6]], 1e-6);
    }
}

/// The same friction as a formula and as tables, beside the law of two coefficients.
#[test]
fn a_drop_is_the_same_however_it_is_written() {
    let scratch = Scratch::new();
    scratch.file("two.csv", "u,friction\n0,0.5\n0,0.35\n1,0.35\n10,0.35\n");
    scratch.file("slip.csv", "u,friction\n0,0.35\n1,0.35\n10,0.35\n");
    let point = ["--epsilon", "1", "--V", "0.5", "--c", "0.01"];
    let ask = |law: &[&str]| scratch.json(&[&["probe"], law, &point].concat());
    let coulomb = ask(&["--law", "coulomb", "--drop", "0.3", "--eta", "0"]);
    for law in [
        &["--phi", "0.35", "--static", "0.5"][..],
        &["--phi", "1 + 0*u", "--drop", "0.3"],
        &["--table", "two.csv"],
        &["--table", "slip.csv", "--static", "0.5"],
    ] {
        let found = ask(law);
        assert_eq!(found["regime"], coulomb["regime"], "{law:?}");
        for of in ["value", "error"] {
            assert!(found["critical_c"][of].is_number(), "{law:?}");
        }
        near(&found["critical_c"]["value"], coulomb["critical_c"]["value"].as_f64().unwrap(), 1e-11);
        near(&found["landing"]["stick_time"], coulomb["landing"]["stick_time"].as_f64().unwrap(), 1e-9);
    }
    // The kicks of steady slip onto the grazing orbit, in the middle of the band between C(V) and c* (theory,
    // "Breakaway"); computed with 25 digits.
    for (belt_speed, c, forward) in
        [("0.5", "0.178213689002", 0.498613145150848), ("1", "0.0894123558135", 0.996536071726422)]
    {
        let law = ["probe", "--phi", "0.6 + 0.2*exp(-u/0.5)", "--static", "1", "--epsilon", "1"];
        let found = scratch.json(&[&law[..], &["--V", belt_speed, "--c", c]].concat());
        near(&found["basin_boundary"]["kick"]["forward"], forward, 1e-11);
        assert_eq!(found["basin_boundary"]["cycle"], Value::Null);
        assert_eq!(found["regime"], "bistable");
    }
    // Twice is once too often, and slip cannot begin above rest.
    let refused =
        |law: &[&str], parts: &[&str]| scratch.run(&[&["probe"], law, &point].concat()).refuses(parts);
    refused(&["--phi", "0.35", "--static", "0.5", "--drop", "0.1"], &["--drop", "twice"]);
    refused(&["--table", "two.csv", "--static", "0.6"], &["two.csv:2", "twice"]);
    refused(&["--phi", "0.35", "--static", "0.3"], &["begins at 0.35", "at rest is 0.3"]);
    refused(&["--phi", "0.35"], &["phi(0) is 0.35", "static = 0.35", "more if it drops"]);
    refused(
        &["--law", "coulomb", "--static", "0.5", "--drop", "0.3", "--eta", "0"],
        &["1 already", "--drop"],
    );
    // A column of a table of points is an axis of the law.
    scratch.file("points.csv", "drop,exponent,V,c\n0.3,2,0.5,0.01\n0,1,0.5,0.01\n");
    let law = ["probe", "--law", "exponential", "--epsilon", "1", "--mu", "0.8", "--vs", "0.5", "--eta", "0"];
    let table = ["--points", "points.csv", "--out", "out.csv"];
    scratch.run(&[&law[..], &table].concat()).ends_with(0);
    let written = scratch.read("out.csv");
    let mut rows = csv::Reader::from_reader(written.as_bytes());
    let header = rows.headers().unwrap().clone();
    let column = header.iter().position(|name| name == "critical_c").unwrap();
    for (row, more) in rows.records().zip([&["--drop", "0.3", "--exponent", "2"][..], &[]]) {
        let alone = scratch.json(&[&law[..], more, &point[2..]].concat());
        near(&alone["critical_c"]["value"], row.unwrap()[column].parse().unwrap(), 1e-15);
    }
    let formula = ["probe", "--phi", "0.35", "--static", "0.5", "--epsilon", "1"];
    scratch.run(&[&formula[..], &table].concat()).refuses(&["points.csv:1", "drop", "friction at rest"]);
}

/// Laws that rise from 0 at rest have none; with the rest at the peak they are the law beyond it.
#[test]
fn a_smoothed_law_rests_at_its_peak() {
    let scratch = Scratch::new();
    let probe = |phi: &str, more: &[&str]| {
        let line = ["probe", "--phi", phi, "--epsilon", "1"];
        [&line[..], more].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let ask = |line: &[String]| scratch.json(&line.iter().map(String::as_str).collect::<Vec<_>>());
    let point = ["--V", "0.5", "--c", "0.1"];
    let rest = [&point[..], &["--rest", "peak"]].concat();
    // A ramp that vanishes leaves the law itself: its width shifts c* at first order.
    let smooth = ask(&probe("tanh(u/1e-3)*(0.6 + 0.4*exp(-u/0.5))", &rest));
    let plain = ask(&probe("0.6 + 0.4*exp(-u/0.5)", &point));
    near(&smooth["critical_c"]["value"], plain["critical_c"]["value"].as_f64().unwrap(), 1e-2);
    assert_eq!(smooth["regime"], plain["regime"]);
    // Bilbao's bow: 0.001 kg, 1,000 N/m, 0.5 N, 0.1 m/s, so that the velocity is in units of 0.5 m/s. The least
    // velocity, beside that of a classical Runge-Kutta method in SI units.
    let bow = ask(&probe(
        "sqrt(200)*(0.5*u)*exp(-100*(0.5*u)^2 + 1/2)",
        &["--V", "0.2", "--c", "0.01", "--rest", "peak"],
    ));
    near(&bow["attracting_cycle"]["x2"]["from"], -0.590695097 / 0.5, 1e-6);
    let refused = |line: Vec<String>, parts: &[&str]| {
        scratch.run(&line.iter().map(String::as_str).collect::<Vec<_>>()).refuses(parts);
    };
    refused(probe("tanh(u/0.01)", &point), &["vanishes at rest", "viscous contact", "--rest peak"]);
    refused(probe("tanh(u/0.01)", &rest), &["does not rise from rest to a peak", "coulomb"]);
    refused(probe("1 - 0.1*u", &rest), &["does not rise from rest to a peak", "leave out rest"]);
    scratch.file("ramp.csv", "u,phi\n0,0\n0.01,0.5\n1,0.35\n10,0.35\n");
    scratch.file("flat.csv", "u,phi\n0,0.5\n0.01,0.5\n1,0.35\n10,0.35\n");
    let table = ["probe", "--epsilon", "1", "--V", "0.5", "--c", "0.1", "--table"];
    scratch.run(&[&table[..], &["ramp.csv"]].concat()).refuses(&["ramp.csv:2", "vanishes at rest"]);
    let [at_peak, flat] = [&["ramp.csv", "--rest", "peak"][..], &["flat.csv", "--static", "0.5"]]
        .map(|more| scratch.json(&[&table[..], more].concat()));
    assert_eq!(at_peak["critical_c"], flat["critical_c"]);
    let job = |more: &str| {
        format!(
            "[friction]\nlaw = \"expression\"\nphi = \"tanh(30*u)*(0.6 + 0.4*exp(-u))\"\n{more}\n\
             [grid]\nepsilon = 1.0\nV = 0.5\nc = [0.1, 0.2]\n[output]\npath = \"peak.h5\"\n"
        )
    };
    scratch.file("job.toml", job(""));
    scratch.run("run job.toml").refuses(&["vanishes at rest", "rest = \"peak\""]);
    scratch.file("job.toml", job("rest = \"peak\"\nstatic = 0.5"));
    scratch.run("run job.toml").refuses(&["written twice"]);
    scratch.file("job.toml", job("rest = \"peak\""));
    scratch.run("run job.toml --quiet").ends_with(0);
    scratch.run("check peak.h5").ends_with(0);
}

/// Slip speeds below the peak are those of constant friction, of which nothing is proved: the belt is neutral. At V = 0.1 the
/// critical damping is that of an integrator of events in extended precision.
#[test]
fn up_to_its_peak_a_law_is_flat() {
    let scratch = Scratch::new();
    let law =
        "tanh(24.692021080803926*u)*(0.8627723410693893+(1-0.8627723410693893)*exp(-u/0.32105559944617307))";
    let probe = |belt_speed: &str| {
        let line = ["probe", "--phi", law, "--rest", "peak", "--epsilon", "1", "--V", belt_speed, "--c", "0"];
        scratch.json(&line)
    };
    let slow = probe("0.005");
    let critical = &slow["critical_c"];
    let (c, error) = (critical["value"].as_f64().unwrap(), critical["error"].as_f64().unwrap());
    assert!(c.abs() <= error.max(1e-300), "{critical}");
    assert_eq!(slow["regime"], "neutral");
    let theorems = ["instability", "bendixson", "symmetric", "validated"];
    assert_eq!(theorems.map(|name| slow["methods"][name]["verdict"].as_str().unwrap()), ["undecided"; 4]);
    let fast = &probe("0.1")["critical_c"];
    let (c, error) = (fast["value"].as_f64().unwrap(), fast["error"].as_f64().unwrap());
    assert!(c - error <= 0.074_468_814_773_791_6 && c + error >= 0.074_468_814_773_788_4, "{fast}");
}

/// A map over the drop has the dampings and regimes of its points, and ends where there is none.
#[test]
fn a_map_over_the_drop_is_that_of_its_points() {
    let scratch = Scratch::new();
    let job = "[friction]\nlaw = \"exponential\"\n[grid]\nepsilon = 1.0\nmu = 0.8\nvs = 0.5\neta = 0.0\ndrop = [0.0, 0.1, 0.3]\n\
               V = [0.2, 1.0]\nc = [0.01, 0.1, 0.3]\n\
               [output]\npath = \"map.h5\"\nfields = [\"verdict\", \"critical_c\", \"regime\", \"basin\"]\n";
    scratch.file("job.toml", job);
    scratch.run("run job.toml --quiet").ends_with(0);
    scratch.run("check map.h5").ends_with(0);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let grid = map.grid();
    let names: Vec<_> = grid.axes().iter().map(|axis| axis.name.clone()).collect();
    assert_eq!(names, ["epsilon", "mu", "vs", "eta", "drop", "V", "c"]);
    let drops: Vec<f64> = grid.axes()[4].values.clone();
    for (i, drop) in drops.iter().enumerate() {
        for (j, belt_speed) in [0.2, 1.0].iter().enumerate() {
            let cell = [0..1, 0..1, 0..1, 0..1, i..i + 1, j..j + 1];
            let stored = map.reals("critical_c_simulation", &cell).unwrap()[[0; 6]];
            let text = |x: f64| x.to_string();
            let (drop, speed) = (text(*drop), text(*belt_speed));
            let point = ["--mu", "0.8", "--vs", "0.5", "--eta", "0", "--drop", &drop, "--V", &speed];
            let law = ["probe", "--law", "exponential", "--epsilon", "1", "--c", "0.1"];
            let found = scratch.json(&[&law[..], &point].concat());
            near(&found["critical_c"]["value"], stored, 1e-6);
        }
    }
}
