//! Machines under every friction law, and their uncertain quantities, through the real binary.

use std::collections::HashMap;

use crate::command::{Says, Scratch};
use slipmap::dataset::auxiliary::PROBABILITY;
use slipmap::store::{MapFile, Pick};

const BODY: &str =
    "[machine]\nmass = 2.0\nstiffness = 800.0\nnormal_force = 50.0\nbelt_speed = 0.1\ndamping = 4.0\n";

/// A configuration with this law and these further keys of the machine.
fn machine(friction: &str, more: &str) -> String {
    format!("[friction]\n{friction}\n{BODY}{more}\n")
}

/// The coefficient of friction of the tests at a slip speed in m/s.
fn coefficient(u: f64) -> f64 {
    0.3 + 0.1 * (-u / 0.25f64).exp()
}

/// Measured at fifty speeds, in units of `unit`.
fn data(unit: f64) -> String {
    let row = |i: i32| {
        let u = 2.0 * (f64::from(i) / 50.0).powi(2);
        format!("{u},{}\n", coefficient(u) * unit)
    };
    (0..=50).map(row).collect()
}

#[test]
fn one_friction_in_every_form_is_one_machine() {
    let scratch = Scratch::new();
    scratch.file("mu.csv", data(1.0));
    scratch.file("force.csv", data(50.0));
    let coefficients = "static_friction = 0.4\nkinetic_friction = 0.3\nstribeck_velocity = 0.25";
    let formula = "law = \"expression\"\nphi = \"muk + (mus - muk)*exp(-u/vs)\"";
    let force = "law = \"table\"\nfile = \"force.csv\"\nquantity = \"force\"\nkind = \"rows\"";
    let all = [
        ("coefficients", machine("law = \"exponential\"", coefficients)),
        ("formula", machine(formula, "mus = 0.4\nmuk = 0.3\nvs = 0.25")),
        ("table", machine("law = \"table\"\nfile = \"mu.csv\"\nkind = \"rows\"", "")),
        ("force", machine(force, "")),
        // Forces need no normal force.
        ("alone", machine(force, "").replace("normal_force = 50.0\n", "")),
    ];
    let mut critical = HashMap::new();
    for (name, text) in &all {
        let file = format!("{name}.toml");
        scratch.file(&file, text);
        let probed = scratch.json(&["probe", "--machine", &file]);
        critical.insert(*name, probed["machine"]["critical_damping"].as_f64().unwrap());
        // The same value comes from the page and from a map, which has its axes in SI units.
        if matches!(*name, "formula" | "alone") {
            let page = scratch.json(&["machine", &file, "--out", "page.html", "--overwrite"]);
            let number = |key: &str| page[key].as_f64().unwrap();
            assert!((number("may_stick_slip_below_damping") / critical[name] - 1.0).abs() < 1e-8, "{name}");
            // The damping at which steady slip turns stable is the weakening of the force at belt speed.
            let hopf = 50.0 * 0.1 / 0.25 * (-0.1f64 / 0.25).exp();
            // Cubics between fifty data have slopes good to some thousandths.
            let error = if *name == "formula" { 1e-12 } else { 5e-3 };
            assert!((number("always_stick_slips_below_damping") / hopf - 1.0).abs() < error, "{name}");
        }
        let path = format!("{name}.h5");
        let small = "--set machine.belt_speed=[0.1,0.2] --set machine.damping=[0.0,4.0]";
        let fields = "--set output.fields=['verdict','critical_damping']";
        scratch.run(&format!("run {file} --set output.path={path} {small} {fields} --quiet")).ends_with(0);
        scratch.run(&["check", &path]).ends_with(0);
        let map = MapFile::open(&scratch.path().join(&path)).unwrap();
        // A force stays one in its map.
        assert_eq!(map.grid().machine().unwrap().normal_force_is_known, *name != "alone");
        let axes: Vec<_> =
            map.grid().axes().iter().map(|axis| (axis.name.as_str(), &axis.values[..])).collect();
        assert_eq!(axes, [("belt_speed", &[0.1, 0.2][..]), ("damping", &[0.0, 4.0])]);
        assert!(!map.has_probability());
        // A figure and its numbers in SI units.
        let plot = format!("plot {path} --x belt_speed --variable critical_damping_simulation");
        scratch.run(&format!("{plot} --out c.svg --data c.csv --overwrite")).ends_with(0);
        let table = scratch.read("c.csv");
        assert!(table.starts_with("belt_speed [m/s],critical_damping_simulation [N s/m]"), "{table}");
    }
    assert!((critical["formula"] / critical["coefficients"] - 1.0).abs() < 1e-8, "{critical:?}");
    assert!((critical["table"] / critical["coefficients"] - 1.0).abs() < 1e-3, "{critical:?}");
    assert!((critical["force"] / critical["table"] - 1.0).abs() < 1e-8, "{critical:?}");
    assert!((critical["alone"] / critical["force"] - 1.0).abs() < 1e-8, "{critical:?}");
    // Forces have a unit; coefficients have none, even under a normal force of 1 N.
    let alone = scratch.read("page.html");
    assert!(alone.contains("friction force") && !alone.contains("normal force"), "{alone}");
    let table = ["machine", "table.toml", "--set", "normal_force=1", "--set", "belt_speed=0.004"];
    let table = scratch.run(&table).ends_with(0).out;
    table.says(&["coefficient of friction", "normal force"]);
}

#[test]
fn what_a_machine_of_a_law_needs_is_told_at_once() {
    let scratch = Scratch::new();
    let refused = |text: String, parts: &[&str]| {
        scratch.file("bad.toml", text);
        scratch.run("run bad.toml").refuses(parts);
        scratch.run("machine bad.toml").refuses(parts);
    };
    let formula = |phi: &str, more: &str| machine(&format!("law = \"expression\"\nphi = \"{phi}\""), more);
    refused(machine("law = \"table\"", ""), &["`file` is missing", "m/s", "quantity", "mass, stiffness"]);
    refused(
        machine("law = \"expression\"", ""),
        &["`phi` is missing", "slip speed u in m/s", "mass, stiffness"],
    );
    refused(formula("muk + 0.1*exp(-u/vs)", ""), &["`muk` is missing from [machine]", "also lacks vs"]);
    refused(formula("mass*exp(-u)", ""), &["`mass` is a quantity of the machine", "another name"]);
    refused(formula("u*exp(-u)", ""), &["bad.toml:3:7", "at rest, u = 0, is 0", "greater than 0"]);
    refused(formula("0.3 + 0.1*abs(u - 0.15)", ""), &["bad.toml:3:7", "kink at u = 0.15", "^^"]);
    refused(formula("0.3", "mus = 1.0"), &["unknown key `mus`"]);
    scratch.file("mu.csv", "0,0.4\n0.05,0.35\n0.15,0.3\n");
    let table = |more: &str| machine(&format!("law = \"table\"\nfile = \"mu.csv\"\n{more}"), "");
    refused(table(""), &["end at slip speed 0.15 m/s", "up to 0.2 m/s"]);
    refused(table("static = 0.3"), &["friction in slip begins at 0.4", "raise static"]);
    refused(table("quantity = \"forces\""), &["quantity", "force"]);
    // A header that names the unit of another quantity, or none that is known.
    for (header, unit, remedy) in [
        ("rpm,mu", "rpm", "read in m/s; convert"),
        ("v (rad/s),mu", "rad/s", "read in m/s; convert"),
        ("v [furlongs/week],mu", "no unit that is known", "read in m/s; convert"),
        ("v,mu [furlongs]", "no unit that is known", "quantity = \"force\""),
    ] {
        scratch.file("mu.csv", format!("# a rig\n{header}\n0,0.4\n0.5,0.35\n1.5,0.3\n"));
        refused(table(""), &["mu.csv:2: the header", unit, remedy]);
    }
    scratch.file("mu.csv", "v,mu [-]\n0,400\n0.5,350\n1.5,300\n");
    refused(table("quantity = \"force\""), &["mu.csv:1: the header", "in -", "leave out quantity"]);
    for header in [
        "speed (m/s),mu",
        "v_in_m/s,mu",
        "v [m s^-1],mu [-]",
        "sliding speed (relative),mu(v)",
        "v / (m/s),friction (measured)",
    ] {
        scratch.file("mu.csv", format!("{header}\n0,0.4\n0.5,0.35\n1.5,0.3\n"));
        scratch.file("good.toml", table(""));
        scratch.run("probe --machine good.toml").ends_with(0);
    }
    scratch.file("mu.csv", "0,-0.4\n0.05,0.35\n0.3,0.3\n");
    refused(table(""), &["mu.csv:1", "at rest is -0.4", "greater than 0"]);
    scratch.file("mu.csv", "0,1\n0.5,0.8\n2,0.7\n");
    let dimensionless =
        "[friction]\nlaw = \"table\"\nfile = \"mu.csv\"\nquantity = \"force\"\n[grid]\nepsilon = 1.0\n";
    scratch.file("bad.toml", dimensionless);
    scratch.run("run bad.toml").refuses(&["quantity", "leave it out"]);
}

#[test]
fn a_table_of_machines_is_answered_in_si_units() {
    let scratch = Scratch::new();
    let coefficients = "static_friction = 0.4\nkinetic_friction = 0.3\nstribeck_velocity = 0.25";
    scratch.file("machine.toml", machine("law = \"lorentzian\"", coefficients));
    scratch.file("in.csv", "name,belt_speed,mass\na,0.05,2\nb,0.2,4\n");
    let run = ["probe", "--machine", "machine.toml", "--points", "in.csv", "--out", "out.csv", "--quiet"];
    // A misspelt quantity is refused: otherwise it would be kept unread, and the machine's own value taken.
    let written = std::fs::read_to_string(scratch.path().join("in.csv")).unwrap();
    scratch.file("in.csv", "note,dampng,belt_speed\na,3,0.1\n");
    scratch.run(&run).refuses(&["in.csv:1: column 2: the numbers of `dampng` are not read", "is `damping`"]);
    // A unit may follow, as in the tables that the program writes, but not that of another quantity.
    for (column, parts) in [
        ("damping (N m s/rad)", &["damping is read in N s/m", "convert the column"][..]),
        ("static_friction [N]", &["a number without a unit", "convert the column"]),
        ("mass_kg", &["`mass_kg` are not read", "is `mass`"]),
        ("Damping [N s/m]", &["`Damping [N s/m]` are not read", "is `damping`"]),
        ("normal force (N)", &["`normal force (N)` are not read", "is `normal_force`"]),
    ] {
        scratch.file("in.csv", format!("belt_speed,{column}\n0.1,0.5\n"));
        scratch.run(&run).refuses(parts).refuses(&["in.csv:1: column 2"]);
    }
    let answered = |header: &str| {
        scratch.file("in.csv", format!("{header}\n0.1,7,x\n"));
        let to = ["probe", "--machine", "machine.toml", "--points", "in.csv", "--out", "-", "--quiet"];
        let text = scratch.run(&to).ends_with(0).out;
        text.lines().nth(1).unwrap().to_owned()
    };
    let plain = answered("belt_speed,damping,note");
    assert_eq!(answered("belt_speed [m/s],damping [N s/m],note (free)"), plain);
    assert_ne!(answered("belt_speed [m/s],#speed of the day [km/h],note"), plain);
    // A machine is one or not with all numbers of its row: 0.2 is below the kinetic friction of the configuration.
    scratch.file("in.csv", "static_friction,kinetic_friction\n0.2,0.1\n");
    scratch.run(&run).ends_with(0);
    std::fs::remove_file(scratch.path().join("out.csv")).unwrap();
    scratch.file("in.csv", "static_friction,kinetic_friction\n0.2,0.3\n");
    scratch.run(&run).refuses(&["in.csv:2: column kinetic_friction: `0.3` makes no machine"]);
    // Numbers that would not be those of the answer.
    scratch.file("in.csv", "belt_speed,rpm\n0.1,7\n");
    scratch.run(&run).refuses(&["in.csv:1: column 2", "numbers of `rpm` are not read", "call it `#rpm`"]);
    // Also where the first rows leave them out; a column of text may have a number in it.
    scratch.file("in.csv", "belt_speed,rpm\n0.1,\n0.1,7\n");
    scratch.run(&run).refuses(&["numbers of `rpm` are not read"]);
    scratch.file("in.csv", written.replace("b,0.2", "7,0.2"));
    scratch.run(&run).ends_with(0);
    std::fs::remove_file(scratch.path().join("out.csv")).unwrap();
    scratch.file("in.csv", written);
    scratch.run(&run).ends_with(0);
    let text = scratch.read("out.csv");
    let rows: Vec<HashMap<String, String>> =
        csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect();
    for (row, (speed, mass)) in rows.iter().zip([("0.05", "2"), ("0.2", "4")]) {
        let [speed, mass] = [format!("belt_speed={speed}"), format!("mass={mass}")];
        let alone = scratch.json(&["probe", "--machine", "machine.toml", "--set", &speed, "--set", &mass]);
        for (column, key) in
            [("critical_damping [N s/m]", "critical_damping"), ("stick_time [s]", "stick_time")]
        {
            let (here, there) = (row[column].parse::<f64>().ok(), alone["machine"][key].as_f64());
            assert_eq!(here.is_some(), there.is_some(), "{column}: {text}");
            assert!(here.zip(there).is_none_or(|(a, b)| (a / b - 1.0).abs() < 1e-8), "{column}: {text}");
        }
        assert_eq!(row["regime"], alone["machine"]["regime"], "{text}");
    }
    assert!(rows.len() == 2 && rows[1]["name"] == "b");
    std::fs::remove_file(scratch.path().join("out.csv")).unwrap();
    scratch.file("in.csv", "speed\n0.1\n");
    scratch.run(&run).refuses(&["in.csv:1", "no column is a quantity", "belt_speed"]);
    scratch.file("in.csv", "belt_speed\n0.1\n-0.2\n");
    scratch.run(&run).refuses(&["in.csv:3", "belt_speed", "-0.2"]);
    assert!(!scratch.names().contains(&"out.csv".to_owned()));
}

#[test]
fn a_map_of_an_uncertain_machine_has_its_probability() {
    let scratch = Scratch::new();
    let coefficients =
        "static_friction = 0.4\nkinetic_friction = { value = 0.3, sd = 0.02 }\nstribeck_velocity = 0.25\n";
    let text = machine("law = \"exponential\"", coefficients)
        .replace("normal_force = 50.0", "normal_force = { value = 50.0, sd = 10.0 }")
        .replace("belt_speed = 0.1", "belt_speed = [0.1, 0.2]")
        .replace("damping = 4.0", "damping = [2.0, 8.0]");
    scratch.file("machine.toml", text);
    scratch.run("run machine.toml --set output.path=map.h5 --quiet").ends_with(0);
    scratch.run("check map.h5").ends_with(0);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let mut at = vec![Pick::Node(0); map.grid().axes().len()];
    let rank = at.len();
    (at[rank - 2], at[rank - 1]) = (Pick::Every(1), Pick::Every(1));
    let stored = map.real_slice(PROBABILITY, &at).unwrap();
    assert_eq!(stored.shape(), [2, 2]);
    for (i, speed) in ["0.1", "0.2"].into_iter().enumerate() {
        for (j, damping) in ["2", "8"].into_iter().enumerate() {
            let [speed, damping] = [format!("belt_speed={speed}"), format!("damping={damping}")];
            let page = ["machine", "machine.toml", "--set", &speed, "--set", &damping, "--draws", "2000"];
            let risk = &scratch.json(&page)["risk"];
            let (here, p) = (risk["probability"]["value"].as_f64().unwrap(), stored[[i, j]]);
            // Four standard errors of the difference from that of 10000 draws.
            assert!((here - p).abs() <= 4.0 * (1.2 * p * (1.0 - p) / 2000.0).sqrt() + 1e-3, "{here} {p}");
            assert!(risk["critical_damping_error"].as_f64().unwrap() < 1e-4);
        }
    }
    // The spread of a belt speed applies to each speed of a range, and is kept when another value is chosen.
    let text = |belt_speed: &str| {
        let coefficients = "static_friction = 0.4\nkinetic_friction = 0.3\nstribeck_velocity = 0.25\n";
        machine("law = \"exponential\"", coefficients).replace("belt_speed = 0.1", belt_speed)
    };
    scratch.file("range.toml", text("belt_speed = { from = 0.1, to = 0.2, points = 2, sd = 0.03 }"));
    scratch.file("value.toml", text("belt_speed = { value = 0.2, sd = 0.03 }"));
    let page = |file: &str, speed: &str| {
        let speed = format!("belt_speed={speed}");
        scratch.json(&["machine", file, "--set", &speed, "--draws", "1000"])["risk"].clone()
    };
    assert!(page("range.toml", "0.1") == page("value.toml", "0.1") && page("range.toml", "0.1").is_object());
    let damping = text("belt_speed = 0.1")
        .replace("damping = 4.0", "damping = { from = 1.0, to = 9.0, points = 3, sd = 1.0 }");
    scratch.file("damping.toml", damping);
    scratch.run("run damping.toml").refuses(&["damping.toml:8:11", "sd", "write one value"]);
    let run = ["run", "range.toml", "--set", "machine.damping=[2.0, 8.0]", "--set", "output.path=range.h5"];
    let told = scratch.json(&[&run[..], &["--dry-run"]].concat());
    assert!(told["beside"]["probability"].is_string(), "{told}");

    let plot = ["plot", "map.h5", "--x", "belt_speed", "--y", "damping", "--variable", PROBABILITY];
    scratch.run(&[&plot[..], &["--out", "p.svg", "--data", "p.csv"]].concat()).ends_with(0);
    assert!(scratch.read("p.svg").contains("probability that it may stick-slip"));
    assert_eq!(scratch.read("p.csv").lines().count(), 5);
}

#[test]
fn standard_errors_of_friction_make_machines_uncertain() {
    let scratch = Scratch::new();
    let rows = |error: &str| -> String { data(1.0).lines().map(|row| format!("{row}{error}\n")).collect() };
    scratch.file("exact.csv", rows(""));
    scratch.file("measured.csv", format!("u,mu,se\n{}", rows(",0.0005")));
    let text = |file: &str| machine(&format!("law = \"table\"\nfile = \"{file}\"\nkind = \"rows\""), "");
    scratch.file("exact.toml", text("exact.csv"));
    scratch.file("measured.toml", text("measured.csv"));
    let page =
        |file: &str| scratch.json(&["machine", file, "--draws", "500", "--out", "page.html", "--overwrite"]);
    assert!(page("exact.toml")["risk"].is_null());
    // Exact rows leave the curve between them open.
    let exact = scratch.read("page.html");
    exact.says(&["by what the curve between the rows could be"]);
    let page = page("measured.toml");
    let critical = page["may_stick_slip_below_damping"].as_f64().unwrap();
    let error = page["risk"]["critical_damping_standard_error"].as_f64().unwrap();
    assert!(error > 0.0, "{page}");
    // The critical damping and its ratio have one relative error, up to the roundings to two digits of both.
    let told = scratch.run("probe --machine measured.toml").ends_with(0).out;
    let relative = |name: &str| {
        let line = told.lines().find_map(|line| line.trim().strip_prefix(name)).unwrap();
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        numbers[1] / numbers[0]
    };
    let both = relative("critical damping ratio  ") / relative("critical damping  ");
    assert!((0.9..1.1).contains(&both), "{told}");
    // The damping that five per cent of normal deviations exceed.
    let rare = ["machine", "measured.toml", "--draws", "1000", "--rare", "0.05"];
    let rare = scratch.json(&rare)["risk"]["rare_by"][0]["damping"].clone();
    let expected = critical + 1.644_853_6 * error;
    let [low, high] = [0, 1].map(|i| rare["limits_95"][i].as_f64().unwrap());
    // Twice the sampling limits.
    assert!((rare["value"].as_f64().unwrap() - expected).abs() < high - low, "{rare} {expected}");
    let words = scratch.read("page.html");
    words.says(&["standard error of critical damping"]);
    assert!(page["may_stick_slip_below_damping_error"].as_f64().is_some_and(|e| e > 0.0), "{page}");
    assert!(words.contains(" by the standard errors of the data"), "of the critical damping: {words}");
    words.says(&["limits in brackets"]);
    // Errors of the computation are told only where they are not far smaller than those of the data.
    let numerical = ["numerical error", "largest error met"];
    assert!(!numerical.iter().any(|of| words.contains(of)), "{words}");
    words.says(&["for the curve through the data"]);
    assert_eq!(page["may_stick_slip_below_damping_standard_error"].as_f64(), Some(error), "{page}");
    let slope = &page["steady_slip_unstable_below_damping_standard_error"];
    assert!(slope.as_f64().is_some_and(|slope| slope > 0.0 && slope != error), "{page}");
    assert!(
        page["vibrates_below_damping"].as_f64().is_some_and(|it| it >= critical * (1.0 - 1e-9)),
        "{page}"
    );
    // The probabilities of the map are told before the run, and in its measured cost.
    let run = ["run", "measured.toml", "--set", "output.path=map.h5", "--quiet"];
    let told = scratch.json(&[&run[..], &["--dry-run"]].concat());
    assert!(told["beside"]["probability"].as_str().unwrap().contains(" draws in each column"), "{told}");
    let told = scratch.json(&run);
    assert!(told["stages"]["probability"].as_f64().is_some_and(|seconds| seconds > 0.0), "{told}");
    assert!(MapFile::open(&scratch.path().join("map.h5")).unwrap().has_probability());
}

/// The coefficients of a machine's friction are no error of a law of an oscillator: what is wrong is the
/// section.
/// The data of a machine leave its friction so uncertain that some of their draws drive it at any speed.
#[test]
fn draws_of_a_machine_given_by_its_damping_ratio_are_dampings() {
    let scratch = Scratch::new();
    scratch.file(
        "force.csv",
        "v [mm/s],F [N]\n0,8.970417394154667\n0.10009873854250609,8.05767826026976\n\
         0.12772620237950968,6.778626184448105\n0.31147800513882445,7.047012801599613\n\
         1.9276799029406249,5.543784459400512\n4.420334102297013,4.644878122265987\n",
    );
    scratch.file(
        "ratio.toml",
        "[friction]\nlaw = \"table\"\nfile = \"force.csv\"\n[machine]\nmass = 77.55182917263802\n\
         stiffness = 687639.2162142205\nbelt_speed = 0.00032806241971603596\ndamping_ratio = 0.09500778938504367\n",
    );
    scratch.run("machine ratio.toml --json").ends_with(0);
}

#[test]
fn a_wrong_section_is_named_before_the_friction() {
    let scratch = Scratch::new();
    scratch.file("mu.csv", data(1.0));
    let right = machine("law = \"table\"\nfile = \"mu.csv\"", "");
    scratch.file("typo.toml", right.replace("[machine]", "[maschine]"));
    for arguments in [&["run", "typo.toml"][..], &["machine", "typo.toml", "--set", "damping=2"]] {
        let parts = ["typo.toml:4:2", "unknown key `maschine`", "nearest valid key is `machine`"];
        scratch.run(arguments).refuses(&parts);
    }
    scratch.file("both.toml", format!("{right}[grid]\nV = 1.0\n"));
    scratch.run("run both.toml").refuses(&["both.toml:4:", "leave the other out"]);
    // As `slipmap run` takes it.
    scratch.file("right.toml", &right);
    let shares = ["damping=2", "machine.damping=2"].map(|set| {
        scratch.json(&["machine", "right.toml", "--set", set])["damping_over_critical"].as_f64().unwrap()
    });
    assert_eq!(shares[0], shares[1]);
}
