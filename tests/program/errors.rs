//! Critical dampings carry their errors in every output, and are withheld where the error is large; what is not
//! decided is no limit. Laws that fall within a Stribeck velocity vs far below the belt speed V tend to friction
//! that drops by j as slip begins, whose limits are known in closed form; what a finite vs adds is of the order
//! vs ln(1/vs).

use serde_json::Value;
use slipmap::column::Verdict;
use slipmap::store::MapFile;

use crate::command::{Says, Scratch};

/// eps c* of friction that drops by j as slip begins, for V/j = 2, and what vs = 1e-4 and 1e-9 may add.
const OF_DROP: f64 = 0.035_876_191_808_776;
const ADDS: [(f64, f64); 2] = [(1e-4, 3.6e-4), (1e-9, 1e-8)];

/// A law so steep that no engine follows an orbit through its fall, at V = 0.2 and j = 0.1.
const TOO_STEEP: &str = "probe --law exponential --epsilon 1 --mu 0.9 --vs 1e-100 --eta 0 --V 0.2 --c 0.03";

/// The first number of "0.0358 +- 3.6e-6", and the error.
fn told(text: &str) -> [f64; 2] {
    let (value, error) = text.split_once(" +- ").unwrap_or_else(|| panic!("{text}"));
    let last = |text: &str| text.split_whitespace().next_back().unwrap().parse().unwrap();
    [last(value), error.split_whitespace().next().unwrap().parse().unwrap()]
}

#[test]
fn a_map_has_the_errors_of_its_critical_dampings() {
    let scratch = Scratch::new();
    let job = "[friction]\nlaw = \"exponential\"\n[grid]\nepsilon = 1.0\nmu = 0.9\neta = 0.0\n\
               vs = [1e-100, 1e-9, 1e-4]\nV = 0.2\nc = [0.02, 0.05]\n\
               [methods]\nrun = [\"symmetric\", \"simulation\"]\n\
               [output]\npath = \"map.h5\"\nfields = [\"verdict\", \"critical_c\"]\n";
    scratch.file("job.toml", job);
    let run = scratch.run("run job.toml --quiet").ends_with(1).out;
    run.says(&["withheld in 1 of 3 columns, since its error is more than 1 % of it"]);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let cells = [0..1, 0..1, 0..3, 0..1, 0..1, 0..2];
    let all = &cells[..5];
    let [values, errors] = ["critical_c_simulation", "critical_c_error_simulation"]
        .map(|name| map.reals(name, all).unwrap().iter().copied().collect::<Vec<f64>>());
    // The limit of steep laws depends on V/j alone.
    assert!(values[0].is_nan() && errors[0] > 0.01 * OF_DROP, "{values:?} {errors:?}");
    for (column, (vs, adds)) in [(2, ADDS[0]), (1, ADDS[1])] {
        // With vs / V five times larger than at V = 1.
        let (value, error) = (values[column], errors[column]);
        assert!(value - error <= OF_DROP + 5.0 * adds && value + error >= OF_DROP, "{vs}: {value} {error}");
        assert!(error > 0.0 && error <= 0.01 * value, "{vs}: {value} {error}");
    }
    let verdicts = map.codes("verdict_simulation", &cells).unwrap();
    let verdicts: Vec<i8> = verdicts.iter().copied().collect();
    let [present, absent] = [Verdict::Present.code(), Verdict::Absent.code()];
    assert_eq!(verdicts[2..], [present, absent, present, absent]);
    // Beside the value, by the convention for ancillary variables; edges of tests are exact to rounding.
    let file = hdf5::File::open(scratch.path().join("map.h5")).unwrap();
    let attribute = |variable: &str, name: &str| {
        let attribute = file.dataset(variable).unwrap().attr(name).unwrap();
        attribute.read_scalar::<hdf5::types::FixedUnicode<256>>().unwrap().to_string()
    };
    assert_eq!(attribute("critical_c_simulation", "ancillary_variables"), "critical_c_error_simulation");
    assert_eq!(attribute("critical_c_error_simulation", "units"), "1");
    assert!(attribute("critical_c_simulation", "comment").contains("more than 1 % of it"));
    assert!(attribute("critical_c_symmetric", "comment").contains("exact to rounding"));
    assert!(file.dataset("critical_c_error_symmetric").is_err());
}

#[test]
fn a_point_has_the_error_of_its_critical_damping() {
    let scratch = Scratch::new();
    for (vs, adds) in ADDS {
        let point =
            format!("probe --law exponential --epsilon 1 --mu 0.5 --vs {vs:e} --eta 0 --V 1 --c 0.03");
        let text = scratch.run(&point).ends_with(0).out;
        let line = text.lines().find(|line| line.contains("c* = ")).unwrap();
        let [value, error] = told(line);
        assert!(value - error <= OF_DROP + adds && value + error >= OF_DROP, "{line}");
        let found = &scratch.json(&point);
        let [exact, whole] = ["value", "error"].map(|key| found["critical_c"][key].as_f64().unwrap());
        // The text has no digits beyond the error, and its error holds for the digits that it has.
        assert!((value - exact).abs() + whole <= error && error <= 1.2 * whole, "{line} {found}");
        let of_method = &found["methods"]["simulation"];
        assert_eq!([&of_method["critical_c"], &of_method["critical_c_error"]], [exact, whole]);
        assert_eq!(found["methods"]["symmetric"]["critical_c_error"], Value::Null);
    }

    let text = scratch.run(TOO_STEEP).ends_with(0).out;
    assert!(text.contains("not told: it is known to no better than ") && !text.contains("c* = "), "{text}");
    let found = &scratch.json(TOO_STEEP)["critical_c"];
    assert_eq!(found["value"], Value::Null, "{found}");
    assert!(found["error"].as_f64().unwrap() > 0.01 * OF_DROP, "{found}");
    assert!(found["reason"].as_str().unwrap().ends_with("which is more than 1 % of it"), "{found}");
}

#[test]
fn a_table_of_points_has_the_errors_of_its_critical_dampings() {
    let scratch = Scratch::new();
    scratch.file("points.csv", "mu,vs,V\n0.5,1e-9,1\n0.9,1e-100,0.2\n");
    let shared = "--law exponential --epsilon 1 --eta 0 --c 0.03";
    scratch.run(&format!("probe --points points.csv --out answers.csv --quiet {shared}")).ends_with(0);
    let text = scratch.read("answers.csv");
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let at = |name: &str| header.iter().position(|known| *known == name).unwrap();
    let (value, error) = (at("critical_c"), at("critical_c_error"));
    let [first, second] = [rows.next().unwrap(), rows.next().unwrap()];
    let [c, off]: [f64; 2] = [value, error].map(|column| first[column].parse().unwrap());
    assert!((c - OF_DROP).abs() <= off + ADDS[1].1 && off <= 0.01 * c, "{first:?}");
    assert!(second[value].is_empty() && second[error].parse::<f64>().unwrap() > 0.01 * OF_DROP, "{second:?}");
}

/// A machine whose dimensionless oscillator has V = `speed`, j = 0.1 and the Stribeck velocity `vs`.
fn machine(speed: f64, vs: f64) -> String {
    format!(
        "[machine]\nmass = 1.0\nstiffness = 1.0\nnormal_force = 1.0\nbelt_speed = {speed}\ndamping = 0.02\n\
         static_friction = 1.0\nkinetic_friction = 0.9\nstribeck_velocity = {vs}\n\
         [friction]\nlaw = \"exponential\"\n"
    )
}

#[test]
fn a_machine_has_the_errors_of_its_limits() {
    let scratch = Scratch::new();
    scratch.file("steep.toml", machine(0.2, 1e-9));
    scratch.file("too_steep.toml", machine(0.2, 1e-100));

    let found = scratch.json("machine steep.toml");
    let number = |key: &str| found[key].as_f64().unwrap();
    let (value, error) =
        (number("may_stick_slip_below_damping"), number("may_stick_slip_below_damping_error"));
    assert!((value - OF_DROP).abs() <= error + 5.0 * ADDS[1].1, "{value} {error}");
    let text = scratch.run("probe --machine steep.toml").ends_with(0).out;
    let [shown, shown_error] = told(text.lines().find(|line| line.contains("critical damping ")).unwrap());
    assert!(
        (shown - value).abs() <= shown_error && (shown - OF_DROP).abs() <= shown_error + 5.0 * ADDS[1].1,
        "{text}"
    );
    let probed = &scratch.json("probe --machine steep.toml")["machine"];
    assert_eq!([&probed["critical_damping"], &probed["critical_damping_error"]], [value, error]);
    // Stick-slip below V = lambda(zeta) j, by the closed form of the drop at zeta = 0.01.
    let limit = &found["limits"]["may_stick_slip_below_belt_speed"];
    let truth = 0.273_924_041_678_774;
    let near = |value: &Value| (value.as_f64().unwrap() / truth - 1.0).abs();
    match limit["status"].as_str().unwrap() {
        "limit" => assert!(near(&limit["value"]) < 1e-5, "{limit}"),
        status => {
            assert_eq!(status, "between");
            let ends = [0, 1].map(|end| limit["value"][end].as_f64().unwrap());
            assert!(
                ends[0] <= truth * (1.0 + 1e-6) && truth <= ends[1] && near(&limit["value"][0]) < 0.01,
                "{limit}"
            );
        }
    }

    // Speeds at which the flow is not decided are no speeds at which it may stick-slip.
    let found = scratch.json("machine too_steep.toml");
    let limit = &found["limits"]["may_stick_slip_below_belt_speed"];
    let least = match limit["status"].as_str().unwrap() {
        "between" => limit["value"][0].as_f64(),
        "at_least" | "limit" => limit["value"].as_f64(),
        _ => None,
    };
    assert!(least.is_none_or(|least| least <= truth * (1.0 + 1e-5)), "{limit}");
    // Nor are numbers told that are not known.
    assert_eq!(found["may_stick_slip_below_damping"], Value::Null, "{found}");
    assert!(found["may_stick_slip_below_damping_error"].as_f64().unwrap() > 0.01 * OF_DROP, "{found}");
    assert_eq!(found["limits"]["may_stick_slip_below_damping"]["status"], "not_determined");
    let reason = found["limits"]["may_stick_slip_below_damping"]["reason"].as_str().unwrap();
    let text = scratch.run("probe --machine too_steep.toml").ends_with(0).out;
    let line = text.lines().find(|line| line.trim_start().starts_with("critical damping  ")).unwrap();
    assert!(line.contains(" not told: its error, "), "{text}");
    let page = scratch.run("machine too_steep.toml").ends_with(0).out;
    assert!(
        page.contains(&format!("not determined: {reason}")) && reason.ends_with(" is more than 1 % of it"),
        "{page}"
    );
    page.says(&["no critical damping is known next to it"]);
}

/// The page prints digits that are known, in its headline too, and withholds sensitivities that are not.
#[test]
fn the_page_of_a_machine_has_no_digits_that_are_not_known() {
    let scratch = Scratch::new();
    scratch.file("steep.toml", machine(0.2, 1e-9));
    let page = scratch.run("machine steep.toml").ends_with(0).out;
    let headline = page.lines().nth(1).unwrap();
    headline.says(&["; more than 0.0359 N s/m ends"]);
    let line = page.lines().find(|line| line.contains("may stick-slip below damping")).unwrap();
    assert!(line.contains(" ± ") || line.contains("numerical error"), "{line}");
    for of in scratch.json("machine steep.toml")["sensitivities"].as_array().unwrap() {
        let error = of["critical_damping_error"].as_f64().unwrap();
        let is_told = of["critical_damping"].is_f64();
        assert_eq!(
            is_told,
            error <= 0.01 * of["critical_damping"].as_f64().map_or(1.0, |by| by.abs().max(1.0)),
            "{of}"
        );
    }
    // Where it is known to more digits than are printed, they are printed alone.
    scratch.file("mild.toml", machine(0.2, 0.05));
    let page = scratch.run("machine mild.toml").ends_with(0).out;
    assert!(!page.lines().nth(1).unwrap().contains(" ± "), "{page}");
    assert!(!page.contains("not known: its error"), "{page}");
}
