//! Laws fitted to measured friction, and what a machine makes of them, through the real binary.

use crate::command::{Says, Scratch, random};

/// The critical dampings, in N s/m, at 0.06 and 0.2 m/s of the law below, on 0.4 kg and 3e5 N/m.
const CRITICAL: [(&str, f64); 2] = [("belt_speed=0.06", 3012.0), ("belt_speed=0.2", 439.3)];

/// The friction force of the tests, in N, at a slip speed in m/s.
fn force(v: f64) -> f64 {
    2000.0 * (0.35 + 0.25 * (-v / 0.05).exp() + 0.01 * v)
}

const MACHINE: &str = "[machine]\nmass = 0.4\nstiffness = 3e5\nbelt_speed = 0.2\ndamping = 500\n";

/// A normal number, up to its fourth moment by 1 %.
fn normal(state: &mut u64) -> f64 {
    (0..12).map(|_| random(state)).sum::<f64>() - 6.0
}

/// Readings with an error of 1 %, in a file as a rig writes it: the true critical dampings are within two of the
/// standard errors that the page states for the fit, which are a few per cent.
#[test]
fn a_fit_carries_its_errors_to_the_page() {
    let scratch = Scratch::new();
    let mut state = 11;
    let rows: String = (0..120)
        .map(|i| {
            let v = 2.5 * (f64::from(i) / 119.0).powi(3);
            format!("{:.4};{:.5}\n", 1e3 * v, 1e-3 * (force(v) + 8.0 * normal(&mut state))).replace('.', ",")
        })
        .collect();
    scratch.file("rig.csv", format!("Rig 7\nv [mm/s];F [kN]\n{rows}"));
    let fit = scratch.json("fit rig.csv --out law.toml --figure fit.svg");
    assert_eq!(fit["fit"]["law"], "exponential, viscous", "{fit}");
    let (values, errors) = (&fit["fit"]["values"], &fit["fit"]["standard_errors"]);
    for (i, expected) in [1200.0, 700.0, 0.05, 20.0].into_iter().enumerate() {
        let [value, error] = [values, errors].map(|of| of[i].as_f64().unwrap());
        assert!((value - expected).abs() < 3.0 * error && error < 0.1 * expected, "{i}: {value} {error}");
    }
    assert!(scratch.read("fit.svg").contains("friction, N"));
    scratch.file("rig.toml", format!("{MACHINE}{}", scratch.read("law.toml")));
    let within = |speed: usize, value: f64, error: f64| {
        let expected = CRITICAL[speed].1;
        assert!((value - expected).abs() < 2.0 * error && error < 0.1 * expected, "{value} {error}");
    };
    let probed = scratch.run(&["probe", "--machine", "rig.toml", "--set", CRITICAL[0].0]).ends_with(0).out;
    let line = probed.lines().find(|line| line.ends_with(" N s/m by the covariance of the fit")).unwrap();
    let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    within(0, numbers[0], numbers[1]);
    let page = scratch.json(&["machine", "rig.toml", "--set", CRITICAL[1].0, "--draws", "100"]);
    let of = |key: &str| page[key].as_f64().unwrap_or_else(|| panic!("{key}: {page}"));
    let error = of("may_stick_slip_below_damping_standard_error");
    within(1, of("may_stick_slip_below_damping"), error);
    assert_eq!(page["standard_errors_from"], "fit");
    assert!(of("may_stick_slip_below_belt_speed_standard_error") > 0.0);
    assert_eq!(page["risk"]["critical_damping_standard_error"].as_f64(), Some(error));
    // Within two errors of the critical damping probe leaves open what the page does.
    let near = ["rig.toml", "--set", CRITICAL[1].0, "--set", "damping=440"];
    let page = scratch.json(&[&["machine"], &near[..], &["--draws", "100"]].concat());
    let open = &page["regimes_left_open_by_data"];
    assert!(open.as_array().is_some_and(|regimes| regimes.len() > 1), "{page}");
    let probe = [&["probe", "--machine"], &near[..]].concat();
    let probed = scratch.json(&probe);
    assert_eq!(&probed["machine"]["regimes_left_open_by_data"], open);
    let told = scratch.run(&probe).ends_with(0).out;
    told.says(&[" by the fit, whose errors leave it open; possible as well: "]);
    // A value of its own takes the place of the fitted one.
    let own = ["probe", "--machine", "rig.toml", "--set", "F_k=650"];
    assert!(scratch.run(&own).ends_with(0).out.contains("F_k = 650 "));
    let law = scratch.read("law.toml");
    scratch.file("bad.toml", format!("{MACHINE}{}", law.replace("covariance = [", "covariance = [[1.0],")));
    scratch.run("machine bad.toml").refuses(&["bad.toml:", "no covariance of 4 parameters"]);
    scratch.file("bad.toml", format!("{MACHINE}{}", law.replace("v_s = ", "v_x = ")));
    scratch.run("machine bad.toml").refuses(&["bad.toml:", "v_x"]);
    // A law that there is not is refused before any file is read.
    scratch.run("fit none.csv --law cubic").refuses(&["there is no such law", "lorentzian"]);
    // The machine that `slipmap init` writes, with the fit in place of its coefficients.
    scratch.run("init machine").ends_with(0);
    scratch.run("fit rig.csv --machine machine.toml --out fitted.toml").ends_with(0);
    let fitted = scratch.read("fitted.toml");
    assert!(fitted.contains("mass = 2.0                # kg") && fitted.ends_with(&law), "{fitted}");
    scratch.run("probe --machine fitted.toml").ends_with(0);
    scratch.run("fit rig.csv --out law.toml").refuses(&["law.toml", "--overwrite"]);
}

/// Rows every 0.1 m/s, twice the speed over which friction falls: what the curve between them could be is part of
/// the error, and the page says where to measure.
#[test]
fn rows_far_apart_leave_the_curve_open() {
    let scratch = Scratch::new();
    let rows: String = (0..7).map(|i| 0.1 * f64::from(i)).map(|v| format!("{v},{},6\n", force(v))).collect();
    scratch.file("even.csv", format!("v [m/s],F [N],se [N]\n{rows}"));
    scratch.file("even.toml", format!("{MACHINE}[friction]\nlaw = \"table\"\nfile = \"even.csv\"\n"));
    let (speed, expected) = CRITICAL[0];
    let page = scratch.json(&format!("machine even.toml --set {speed} --draws 100 --out page.html"));
    let of = |key: &str| page[key].as_f64().unwrap();
    let (value, error) =
        (of("may_stick_slip_below_damping"), of("may_stick_slip_below_damping_standard_error"));
    assert!((value - expected).abs() < 2.0 * error, "{value} {error}");
    let words = scratch.read("page.html");
    words.says(&["measure between", "0 and 0.1 m/s"]);
}
