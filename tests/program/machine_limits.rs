//! The limits of a machine and the checks of its configuration, through the real binary.

use serde_json::{Value, json};

use crate::command::{Says, Scratch};

const MACHINE: &str = "[machine]\nmass = 2\nstiffness = 5e5\nnormal_force = 1000\nbelt_speed = 0.1\ndamping = 30\n\
                       [friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n";

fn machine(rows: &str) -> Scratch {
    let scratch = Scratch::new();
    scratch.file("pad.csv", rows);
    scratch.file("pad.toml", MACHINE);
    scratch
}

fn page(scratch: &Scratch, more: &[&str]) -> Value {
    scratch.json(&[&["machine", "pad.toml"], more].concat())
}

/// What a page of HTML says, without its tags.
fn words(html: &str) -> String {
    html.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text)).collect()
}

const FALLS: &str = "0,0.43\n0.05,0.36\n0.12,0.31\n0.3,0.28\n0.6,0.275\n1.2,0.275\n";

#[test]
fn every_limit_says_what_its_value_means() {
    let falls = page(&machine(FALLS), &[]);
    let status = |page: &Value, key: &str| page["limits"][key]["status"].as_str().unwrap().to_owned();
    for key in
        ["may_stick_slip_below_damping", "vibrates_below_damping", "steady_slip_unstable_below_damping"]
    {
        assert_eq!(status(&falls, key), "limit", "{key}");
        assert_eq!(falls["limits"][key]["value"], falls[key], "{key}");
    }
    assert_eq!(falls["kick_status"], "not_needed");
    assert_eq!(falls["standard_errors_from"], "curve");
    assert_eq!(page(&machine(FALLS), &["--set", "damping=2000"])["kick_status"], "none");

    // Friction that rises needs no damping at any speed up to half the end of the data.
    let rises = page(&machine("0,0.3\n0.1,0.31\n0.3,0.35\n1.2,0.4\n"), &[]);
    let limits = &rises["limits"];
    assert_eq!(limits["may_stick_slip_below_belt_speed"], json!({ "status": "none", "value": 0.6 }));
    for key in ["may_stick_slip_below_damping", "vibrates_below_damping", "always_stick_slips_below_damping"]
    {
        assert_eq!(limits[key], json!({ "status": "none", "value": 0.0 }), "{key}");
    }
    assert_eq!(status(&rises, "always_stick_slips_below_belt_speed"), "none");

    // Data that end early: the second limit lies beyond them, and no damping is known.
    let early = page(&machine("0,0.43\n0.05,0.36\n0.1,0.33\n0.2,0.31\n"), &["--set", "damping=0"]);
    let limits = &early["limits"];
    assert_eq!(limits["may_stick_slip_below_belt_speed"]["status"], "at_least", "{limits}");
    assert_eq!(limits["may_stick_slip_below_damping"], json!({ "status": "not_determined", "value": null }));
}

/// Of slip cycles whose orbits would leave the data it is told where the data end and how far they should reach,
/// as it is of stick-slip; and where they do, the cycles are known.
#[test]
fn slip_cycles_beyond_the_data_name_what_to_measure() {
    let of = |rows: &str| {
        let scratch = Scratch::new();
        scratch.file("f.csv", rows);
        scratch.file(
            "rig.toml",
            "[machine]\nmotion = \"rotation\"\ninertia = 0.0137\nstiffness = 0.5\nnormal_force = 1\nbelt_speed = 8\n\
             damping = 0.01\n[friction]\nlaw = \"table\"\nfile = \"f.csv\"\n",
        );
        let of = |command: &[&str]| scratch.run(&[command, &["rig.toml"]].concat()).ends_with(0).out;
        (of(&["machine"]), of(&["probe", "--machine"]))
    };
    const ROWS: &str = "u,F\n0,2\n1,2\n2,3\n17,1\n18,1\n";
    let (page, probed) = of(ROWS);
    page.says(&[
        "slip cycles: the orbit leaves the data, which end at slip speed 18 rad/s; measure up to about 35.9 rad/s",
        "not determined: slip cycles: the orbit leaves the data",
    ]);
    let line = probed.lines().find(|line| line.trim_start().starts_with("slip cycles  ")).unwrap();
    line.says(&["leaves the data of f.csv", "needs them up to about"]);
    assert!(!page.contains("finite numbers") && !line.contains("finite numbers"), "{page}{line}");
    let (page, probed) = of(&(ROWS.to_owned() + "36,1\n"));
    assert!(!page.contains("not determined: slip cycles") && !page.contains("leaves the data"), "{page}");
    let line = probed.lines().find(|line| line.trim_start().starts_with("slip cycles  ")).unwrap();
    assert!(!line.contains("not determined"), "{line}");
}

/// A configuration that `run` refuses is refused by `machine` and `probe`, too, with the same message.
#[test]
fn a_configuration_is_valid_for_all_commands_or_for_none() {
    let scratch = machine(FALLS);
    for (more, part) in [
        ("[output]\nfields = [\"nonsense\"]\n", "output.fields[0]"),
        ("[output]\nfield = [\"regime\"]\n", "unknown key `field`"),
        ("[audit]\ncells = -1\n", "audit.cells"),
        ("[simulation]\ntolerance = 2.0\n", "simulation.tolerance"),
    ] {
        scratch.file("pad.toml", format!("{MACHINE}{more}"));
        let refused = scratch.run("run pad.toml").refuses(&["pad.toml:1", part]).err;
        for command in [&["machine", "pad.toml"][..], &["probe", "--machine", "pad.toml"]] {
            assert_eq!(scratch.run(command).refuses(&[part]).err, refused, "{command:?}");
        }
    }
    // Also where --set replaces what is wrong in the file.
    let range = MACHINE.replace("belt_speed = 0.1", "belt_speed = { from = 0.1, to = 0.4, points = 0 }");
    scratch.file("pad.toml", range);
    let refused = scratch.run("run pad.toml").refuses(&["belt_speed.points = 0"]).err;
    let set = ["machine", "pad.toml", "--set", "belt_speed=0.1"];
    assert_eq!(scratch.run(&set).refuses(&[]).err, refused);
    // What is missing from the file may be set.
    scratch.file("pad.toml", MACHINE.replace("belt_speed = 0.1\n", ""));
    scratch.run(&set).ends_with(0);
}

#[test]
fn negative_friction_is_told_with_its_line() {
    let scratch = machine("# a rig\nu,mu\n0,0.43\n\n0.05,0.36\n0.12,0.31\n0.3,0.28\n0.6,0.275\n1.2,-0.005\n");
    let warning = "warning: pad.csv:9: the friction is negative, -0.005 at slip speed 1.2";
    for command in [
        &["probe", "--machine", "pad.toml"][..],
        &["run", "pad.toml", "--dry-run"],
        &["probe", "--table", "pad.csv", "--static", "0.43", "--epsilon", "1", "--V", "0.1", "--c", "0.2"],
    ] {
        let run = scratch.run(command).ends_with(0);
        assert!(run.err.contains(warning), "{command:?}: {}", run.err);
    }
}

/// Within two standard errors of a limit the page names the behaviours that are possible, in place of one,
/// and gives no digits of a kick.
#[test]
fn data_may_leave_open_what_the_machine_does() {
    let speeds = [
        0.0, 0.01, 0.02, 0.035, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1, 0.11, 0.12, 0.13, 0.16, 0.2, 0.28, 0.4,
        0.6, 0.8, 1.0,
    ];
    let row = |u: f64| format!("{u},{},0.0001\n", 0.27 + 0.16 * (-u / 0.07).exp() + 0.01 * u);
    let scratch = machine(&format!("speed,friction,se\n{}", speeds.map(row).concat()));
    let at = |damping: f64| {
        let set = format!("damping={damping}");
        let told = page(&scratch, &["--set", &set, "--draws", "100", "--out", "page.html", "--overwrite"]);
        (told, words(&scratch.read("page.html")))
    };
    let (decided, text) = at(30.0);
    let number = |key: &str| decided[key].as_f64().unwrap();
    let [hopf, error] =
        ["", "_standard_error"].map(|end| number(&format!("steady_slip_unstable_below_damping{end}")));
    assert!(hopf - 30.0 > 3.0 * error && number("may_stick_slip_below_damping") > hopf + 3.0 * error);
    assert_eq!(decided["regimes_left_open_by_data"], json!([]));
    assert_eq!(decided["standard_errors_from"], "data");
    assert_eq!(decided["warnings"], json!([]));
    text.says(&["Stick-slips from every start at 0.1 m/s"]);
    // By the curve through the data: bistable on one side, stick-slip on the other.
    for (damping, regimes) in
        [(hopf + error, ["bistable", "stick_slip"]), (hopf - error, ["stick_slip", "bistable"])]
    {
        let (open, text) = at(damping);
        assert_eq!(open["regime"], regimes[0]);
        assert_eq!(open["regimes_left_open_by_data"], json!(regimes));
        let limits = json!(["steady_slip_unstable_below_damping"]);
        assert_eq!(open["damping_within_two_standard_errors_of"], limits);
        text.says(&[
            "the data leave open what it does: it s",
            "it stick-slips from every start",
            "it slips steadily or stick-slips, depending on the start",
            "The damping lies within two standard errors of ",
            "for the curve through the data",
        ]);
        let kick = text.lines().find(|line| line.contains("kick that starts it")).unwrap();
        assert!(!kick.chars().any(|c| c.is_ascii_digit()), "{kick}");
        assert_eq!(open["kick_status"], "not_determined");
        assert!(open["kick_forward"].is_null() && open["kick_backward_standard_error"].is_null(), "{open}");
        assert!(open["kick_reason"].as_str().unwrap().contains("the data leave open"), "{open}");
    }
    // A table of points tells the same of each row.
    scratch.file("rows.csv", format!("damping\n30\n{}\n", hopf + error));
    let table = ["probe", "--machine", "pad.toml", "--points", "rows.csv", "--out", "-", "--quiet"];
    let table = scratch.run(&table).ends_with(0).out;
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|it| *it == name).unwrap();
    let open = rows[1..].iter().map(|row| row[column("regimes_left_open_by_data")]);
    assert_eq!(open.collect::<Vec<_>>(), ["", "bistable stick_slip"]);
    let of_row: f64 = rows[1][column("critical_damping_standard_error [N s/m]")].parse().unwrap();
    let of_page = number("may_stick_slip_below_damping_standard_error");
    assert!((of_row / of_page - 1.0).abs() < 1e-5, "{of_row} {of_page}");
    // Where the data decide for two attractors, the kick has an error and the digits that it leaves.
    let (bistable, text) = at(0.15 * hopf + 0.85 * number("may_stick_slip_below_damping"));
    assert_eq!(bistable["regimes_left_open_by_data"], json!([]), "{bistable}");
    let [error, value] =
        ["kick_forward_standard_error", "kick_forward"].map(|key| bistable[key].as_f64().unwrap());
    assert!(error > 1e-3 * value && error < value, "{error} {value}");
    let kick = text.lines().find(|line| line.contains("kick that starts it")).unwrap();
    assert!(kick.matches(" ± ").count() == 4, "{kick}");
}

/// Scatter is told on the page and in JSON, and its size makes standard errors where the data have none.
#[test]
fn scatter_is_told_on_the_page() {
    let row = |i: u32| {
        let u = 0.06 * f64::from(i);
        let mu = 0.28 + 0.15 * (-u / 0.1).exp() + if i.is_multiple_of(2) { 0.004 } else { -0.004 };
        format!("{u},{mu}\n")
    };
    let scratch = machine(&(0..20).map(row).collect::<String>());
    // Rows that are the law itself; others are reduced to a curve.
    scratch.file("pad.toml", format!("{MACHINE}kind = \"rows\"\n"));
    let answer = page(&scratch, &["--out", "page.html"]);
    let warnings = answer["warnings"].as_array().unwrap();
    assert!(warnings[0].as_str().unwrap().contains("into at most 20 speeds"), "{warnings:?}");
    assert_eq!(answer["standard_errors_from"], "scatter");
    let page = scratch.read("page.html");
    page.says(&["Warning: the friction of pad.csv rises and falls by turns"]);
    page.says(&["standard error by the scatter of the rows"]);
}

/// A formula of thousands of characters is quoted around its mistake.
#[test]
fn a_long_formula_is_quoted_around_the_place_of_the_error() {
    let scratch = Scratch::new();
    let terms = |from: u32, to: u32| {
        (from..to).map(|i| format!("0.001*exp(-u/0.{i})")).collect::<Vec<_>>().join(" + ")
    };
    let phi = format!("0.5 + {} + foo(u) + {}", terms(100, 180), terms(180, 240));
    let point = ["--epsilon", "1", "--V", "0.1", "--c", "0.2"];
    let run = scratch.run(&[&["probe", "--phi", &phi], &point[..]].concat()).refuses(&["foo(u)", ".. "]);
    let lines: Vec<&str> = run.err.lines().collect();
    assert!(lines.iter().all(|line| line.len() < 140), "{}", run.err);
    let quoted = lines.iter().position(|line| line.contains("foo(u)")).unwrap();
    let mark = lines[quoted + 1].find('^').unwrap();
    assert_eq!(&lines[quoted][mark..mark + 3], "foo", "{}", run.err);
}
