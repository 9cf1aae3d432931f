//! `slipmap probe`: one point and tables of points.

use crate::command::{PROBE, Run, Says, Scratch};
use crate::machine::rows;
use serde_json::Value;
use slipmap::column::Method;

const POINT: [(&str, f64); 6] =
    [("epsilon", 0.1), ("alpha", 0.3), ("beta", 0.1), ("gamma", 2.0), ("V", 1.0), ("c", 0.5)];

/// The names of the default methods.
fn usual() -> Vec<&'static str> {
    Method::usual().map(|method| method.name()).collect()
}

/// The arguments of a probe of [`POINT`] with some parameters changed; NaN leaves a parameter out.
fn probe(changes: &[(&str, f64)]) -> Vec<String> {
    let mut arguments = vec!["probe".to_owned()];
    for (name, value) in POINT {
        let value = changes.iter().find(|(changed, _)| *changed == name).map_or(value, |(_, value)| *value);
        if !value.is_nan() {
            arguments.extend([format!("--{name}"), format!("{value:?}")]);
        }
    }
    arguments
}

fn run(arguments: &[String], more: &[&str]) -> Run {
    let all: Vec<&str> = arguments.iter().map(String::as_str).chain(more.iter().copied()).collect();
    Scratch::new().run(&all)
}

fn json(changes: &[(&str, f64)]) -> Value {
    let run = run(&probe(changes), &["--json"]).ends_with(0);
    assert_eq!(run.err, "");
    run.json()
}

/// The belt moves next to a corner of the friction: its orbits have errors that may hide further cycles.
#[test]
fn a_regime_that_is_not_known_has_the_reason_of_its_cycles() {
    let scratch = Scratch::new();
    scratch.file(
        "friction.csv",
        "u,phi\n0.0,1.0\n0.33777823298551246,0.9714259097348013\n0.3389108225930309,0.9473646976533467\n\
         1.079214568967886,0.9246306128466842\n1.0815616201223555,0.9608534838801799\n\
         1.2623887170051706,0.9411881285379828\n1.2994667793414547,0.8687431068802688\n\
         10.395734234731638,0.8687431068802688\n",
    );
    let told = scratch.json(
        "probe --law table --table friction.csv --epsilon 1 --V 0.3389198597574758 --c 0.11241401056629663",
    );
    assert_eq!((&told["regime"], &told["cycles"]["slip"]), (&"failed".into(), &Value::Null), "{told}");
    assert_eq!(told["regime_reason"], told["cycles"]["reason"], "{told}");
    told["regime_reason"].as_str().unwrap().says(&["slip cycles: two cycles meet within the error"]);
}

#[test]
fn json_has_every_answer_and_agrees_with_closed_forms() {
    let answer = json(&[]);
    for (name, value) in POINT {
        assert_eq!(answer["point"][name], value, "{name}");
    }
    let methods = answer["methods"].as_object().unwrap();
    let others = ["validated", "smoothed", "stick_band", "fixed_step", "event_step"];
    assert_eq!(methods.keys().collect::<Vec<_>>(), [usual(), others.to_vec()].concat());
    for (name, method) in methods {
        let verdict = method["verdict"].as_str().unwrap();
        assert!(["present", "absent", "undecided", "failed"].contains(&verdict), "{name}");
        assert_eq!(
            verdict == "undecided",
            method["reason"].is_string(),
            "{name} explains what it leaves open"
        );
        assert!(method["guarantee"].is_string() && method["equation"].is_string(), "{name}");
    }
    let number = |value: &Value| value.as_f64().unwrap();
    // theory, "The tests": -c + gamma (1 - alpha) - 2 beta V, here -0.5 + 1.4 - 0.2; each of the few
    // operations rounds values of order one.
    assert!((number(&methods["perturbation"]["margin"]) - 0.7).abs() < 1e-15);
    // E = (1 - eps c V, V), the equilibrium at phi(V), the eigenvalues' sum the divergence at V.
    assert!((number(&answer["exit_point"]["x1"]) - 0.95).abs() < 1e-15);
    let (weakening, phi) = (1.0 / 1.2, 0.7 / 1.2 + 0.3 + 0.01);
    assert!((number(&answer["equilibrium"]["x1"]) - phi).abs() < 1e-15);
    let divergence = 0.1 * (-0.5 + 1.4 * weakening * weakening - 0.2);
    assert!((number(&answer["equilibrium"]["divergence"]) - divergence).abs() < 1e-15);
    let sum: f64 =
        answer["equilibrium"]["eigenvalues"].as_array().unwrap().iter().map(|e| number(&e["re"])).sum();
    assert!((sum - divergence).abs() < 1e-15);
    assert_eq!(answer["sliding_segment"]["to_x1"], answer["exit_point"]["x1"]);

    // Both engines follow the same orbit.
    let (map, direct) = (&answer["flow"]["arcs"], &answer["flow"]["direct"]);
    assert_eq!((&map["fate"], &direct["fate"]), (&"sticks".into(), &"sticks".into()));
    // Arcs tell no margin so far past the belt line. The angle there magnifies the errors of a landing.
    assert!(map["margin"].is_null() && number(&direct["margin"]) > 0.0);
    let landings = [map, direct].map(|flow| number(&flow["landing"]["x1"]));
    assert!((landings[0] - landings[1]).abs() <= 1e-8, "{landings:?}");
    let landing = &answer["landing"];
    let period = number(&landing["slip_time"]) + number(&landing["stick_time"]);
    assert_eq!(number(&landing["period"]), period);
    // While it sticks the mass moves from x1 to E with the speed V.
    let distance = number(&answer["exit_point"]["x1"]) - number(&landing["x1"]);
    assert!((number(&landing["stick_time"]) - distance).abs() < 1e-15);
}

#[test]
fn numbers_that_do_not_exist_are_null() {
    // No weakening at all: no cycle, and no critical damping.
    let answer = json(&[("alpha", 1.0)]);
    assert_eq!(answer["landing"], Value::Null);
    assert_eq!(answer["regime"], "equilibrium");
    for method in usual() {
        assert_eq!(answer["methods"][method]["critical_c"], Value::Null, "{method}");
        assert_ne!(answer["methods"][method]["verdict"], "present", "{method}");
    }
}

#[test]
fn the_text_names_every_answer() {
    let text = run(&probe(&[]), &[]).ends_with(0).out;
    for part in usual().iter().chain(&[
        "epsilon = 0.1   alpha = 0.3   beta = 0.1   gamma = 2   V = 1   c = 0.5",
        "undecided because",
        "arcs",
        "direct",
        "c* = ",
        "stick_slip: the stick-slip cycle is the only attractor",
        "unstable focus",
        "exit point",
        "landing",
        "period",
        "multiplier",
        "epsilon limit",
        "both attract for c",
    ]) {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

/// Friction that nearly vanishes far beyond the belt speed: orbits that cross the belt line gain there. Where it is
/// negative they are left out.
#[test]
fn cycles_that_cross_the_belt_line_are_named() {
    let dip = "1-a*exp(-((u-m)/s)^2)";
    let point = ["--set", "m=20", "--set", "s=3", "--epsilon", "1", "--V", "10"];
    let text = |depth: &str, damping: &str| {
        let arguments = [&["probe", "--phi", dip, "--c", damping, "--set", depth][..], &point].concat();
        Scratch::new().run(&arguments).ends_with(0).out
    };
    let lines = |text: String, part: &str| -> Vec<String> {
        text.lines().filter(|line| line.contains(part)).map(str::to_owned).collect()
    };
    let found = lines(text("a=0.9", "0.002"), "crossing cycle");
    assert!(found.len() == 1 && found[0].contains("attracts, "), "{found:?}");
    assert!(lines(text("a=0.9", "0.2"), "crossing cycle").is_empty());
    let found = lines(text("a=1.2", "0.2"), "friction is negative from u = ");
    assert!(
        found.len() == 1 && found[0].ends_with(": crossing cycles that reach it are left out"),
        "{found:?}"
    );
}

/// A negative critical damping says that there is no cycle at any.
#[test]
fn a_critical_damping_below_zero_excludes_a_cycle() {
    let point = [("epsilon", 1.0), ("alpha", 0.0), ("gamma", 8.0), ("V", 2.0), ("c", 7.0)];
    let critical = &json(&point)["critical_c"];
    let [value, error] = ["value", "error"].map(|key| critical[key].as_f64().unwrap());
    assert!(value < 0.0 && (value + 0.284_951).abs() <= error + 1e-6, "{critical}");
}

/// On a fast belt the orbit from the exit point sticks from above a damping only: in the band both attract.
#[test]
fn the_bistable_band_ends_where_sticking_does() {
    let regime_at = |c: f64| {
        let point = [("epsilon", 1.0), ("alpha", 0.0), ("beta", 0.0), ("gamma", 0.1), ("V", 30.0), ("c", c)];
        json(&point)
    };
    let band = &regime_at(0.01)["bistable_band"];
    let [from, to] = ["from_c", "to_c"].map(|key| band[key].as_f64().unwrap());
    for (c, regime) in [
        (from - 1e-5, "equilibrium_and_crossing"),
        (from + 1e-5, "bistable"),
        (to - 1e-5, "bistable"),
        (to + 1e-5, "equilibrium"),
    ] {
        assert_eq!(regime_at(c)["regime"], regime, "{c} {band}");
    }
}

/// Orbits of low dampings leave the data: where the band begins is not known, and told so with its bounds.
#[test]
fn a_bistable_band_does_not_begin_where_the_data_end() {
    let scratch = Scratch::new();
    let row = |i: i32| {
        let u = 1.0125 * f64::from(i) / 40.0;
        format!("{u:?},{:?}\n", 0.6 + 0.4 * (-2.0 * u).exp())
    };
    scratch.file("falls.csv", format!("u,mu\n{}", (0..=40).map(row).collect::<String>()));
    let point = ["probe", "--table", "falls.csv", "--epsilon", "1", "--V", "0.5", "--c", "0.32"];
    let band = &scratch.json(&point)["bistable_band"];
    let [low, high] = [0, 1].map(|end| band["from_c_between"][end].as_f64().unwrap());
    assert!(band["from_c"].is_null() && band["from_c_reason"].is_string(), "{band}");
    assert!((low - 0.2943).abs() < 1e-4 && (high - 0.316_213).abs() < 2e-5, "{band}");
}

#[test]
fn bad_points() {
    let nan = f64::NAN;
    run(&probe(&[("V", nan), ("c", nan)]), &[]).refuses(&["also needs --V, --c", "help: "]);
    Scratch::new().run("probe").refuses(&["--epsilon, --alpha, --beta, --gamma, --V, --c", "--points"]);
    run(&probe(&[("alpha", 1.5)]), &[]).refuses(&["--alpha 1.5", "between 0 and 1"]);
    run(&probe(&[("beta", -1.0)]), &[]).refuses(&["--beta -1", "at least 0"]);
    run(&probe(&[("V", 0.0)]), &[]).refuses(&["--V 0", "greater than 0"]);
    run(&probe(&[("V", nan)]), &["--V", "nan"]).refuses(&["--V NaN", "finite"]);
    run(&probe(&[("V", nan)]), &["--V", "fast"]).refuses(&["'fast'", "--V", "not a number"]);
    run(&probe(&[]), &["--law", "tustin"]).refuses(&["'tustin'", "--law", "stribeck"]);
    run(&probe(&[]), &["--law", "1 - 0.3*u"]).refuses(&["'1 - 0.3*u'", "a formula is given with --phi"]);
    run(&probe(&[]), &["--tolerance", "1"]).refuses(&["--tolerance", "from 1e-14 to 1e-2"]);
    run(&probe(&[]), &["--gama", "2"]).refuses(&["--gama", "--gamma"]);
    run(&probe(&[]), &["--out", "x.csv"]).refuses(&["--points"]);
    run(&probe(&[]), &["--points", "x.csv", "--out", "y.csv"]).refuses(&["both a point and a table"]);
}

/// Parameters that all rows share are options of the command; one that is a column too is refused.
#[test]
fn options_hold_for_all_rows_of_a_table() {
    let scratch = Scratch::new();
    scratch.file("whole.csv", "V,epsilon,alpha,beta,gamma,c\n1,0.1,0.3,0.1,2,0.5\n0.5,0.1,0.3,0.1,2,1.3\n");
    scratch.file("short.csv", "V,alpha,beta,gamma,c\n1,0.3,0.1,2,0.5\n0.5,0.3,0.1,2,1.3\n");
    let run = |table: &str, more: &[&str]| {
        let all = [&["probe", "--quiet", "--points", table, "--out", "-"][..], more].concat();
        scratch.run(&all)
    };
    let answers = |table: &str, more: &[&str]| {
        let mut rows = rows(&run(table, more).ends_with(0).out);
        for row in &mut rows {
            row.remove("epsilon");
        }
        rows
    };
    assert_eq!(answers("short.csv", &["--epsilon", "0.1"]), answers("whole.csv", &[]));
    run("whole.csv", &["--epsilon", "0.1"]).refuses(&[
        "whole.csv:1",
        "column `epsilon`",
        "on the command line",
    ]);
    run("short.csv", &[]).refuses(&["short.csv:1", "`epsilon` is missing", "option"]);
    run("short.csv", &["--epsilon", "-1"]).refuses(&["epsilon = -1", "for all rows", "greater than 0"]);
    run("short.csv", &["--epsilon", "1", "--mu", "1"]).refuses(&["--mu is not a parameter of the law"]);
}

/// Columns in another order than the parameters, with further awkward columns among them.
const TABLE: &str = "\
id,gamma,c,V,alpha,\"remark, free\",beta,epsilon
1,2,0.5,1,0.3,\"says \"\"hi\"\", twice\",0.1,0.1
2,2,1.3,1,0.3,\"two
lines\",0.1,0.1
3, 8 ,0,0.25,0,,0,1e-2
4,0,0.1,3,1,\u{e9}\u{3b1},0.5,1
";

#[test]
fn a_table_keeps_its_columns_and_gains_the_answers() {
    let scratch = Scratch::new();
    scratch.file("in.csv", TABLE);
    scratch.run("probe --points in.csv --out out.csv --epsilon-limits").ends_with(0);
    assert_eq!(scratch.names(), ["in.csv", "out.csv"]);

    let text = scratch.read("out.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let mut original = csv::Reader::from_reader(TABLE.as_bytes());
    let kept = original.headers().unwrap().len();
    assert_eq!(
        header.iter().take(kept).collect::<Vec<_>>(),
        original.headers().unwrap().iter().collect::<Vec<_>>()
    );
    let mut added: Vec<String> =
        usual().iter().flat_map(|name| [format!("verdict_{name}"), format!("margin_{name}")]).collect();
    let others = "critical_c critical_c_error regime landing_x1 stick_time slip_time crossings slip_cycles \
                  cycle_period cycle_amplitude_x1 cycle_amplitude_x2 cycle_multiplier boundary_velocity \
                  boundary_multiplier kick_forward kick_backward growth_time";
    added.extend(others.split(' ').map(str::to_owned));
    added.extend(usual().iter().map(|name| format!("epsilon_limit_{name}")));
    assert_eq!(header.iter().skip(kept).collect::<Vec<_>>(), added);

    let at = |row: &csv::StringRecord, name: &str| {
        row[header.iter().position(|column| column == name).unwrap()].trim().to_owned()
    };
    let originals: Vec<csv::StringRecord> = original.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), originals.len());
    for (row, original) in rows.iter().zip(&originals) {
        assert_eq!(row.iter().take(kept).collect::<Vec<_>>(), original.iter().collect::<Vec<_>>());
        // The same answers, to the last bit, as for the point alone.
        let point: Vec<(&str, f64)> =
            POINT.iter().map(|(name, _)| (*name, at(row, name).parse().unwrap())).collect();
        let single = json(&point);
        let same = |text: &str, value: &Value| match value {
            Value::Null => assert_eq!(text, ""),
            Value::String(word) => assert_eq!(text, word),
            number => assert_eq!(text.parse::<f64>().unwrap(), number.as_f64().unwrap()),
        };
        for method in usual() {
            same(&at(row, &format!("verdict_{method}")), &single["methods"][method]["verdict"]);
            same(&at(row, &format!("margin_{method}")), &single["methods"][method]["margin"]);
            same(&at(row, &format!("epsilon_limit_{method}")), &single["methods"][method]["epsilon_limit"]);
        }
        same(&at(row, "critical_c"), &single["critical_c"]["value"]);
        same(&at(row, "regime"), &single["regime"]);
        let landing = |key: &str| single["landing"].get(key).cloned().unwrap_or(Value::Null);
        same(&at(row, "landing_x1"), &landing("x1"));
        same(&at(row, "stick_time"), &landing("stick_time"));
        same(&at(row, "slip_time"), &landing("slip_time"));
        same(&at(row, "crossings"), &landing("crossings"));
        let cycle = single["attracting_cycle"].get("period").cloned().unwrap_or(Value::Null);
        same(&at(row, "cycle_period"), &cycle);
    }
    assert_eq!(at(&rows[0], "verdict_simulation"), "present");
    assert_eq!(at(&rows[1], "verdict_simulation"), "absent");
    // Friction that rises makes no cycle at any damping.
    assert_eq!([at(&rows[3], "margin_symmetric"), at(&rows[3], "critical_c")], ["-inf", "-3"]);
}

#[test]
fn proofs_are_appended_if_they_are_asked_for() {
    let scratch = Scratch::new();
    scratch.file("in.csv", "epsilon,alpha,beta,gamma,V,c\n0.1,0.3,0.1,2,1,0.5\n0.1,0.3,0.1,2,1,1.3\n");
    scratch.run("probe --points in.csv --out out.csv --validated").ends_with(0);
    let text = scratch.read("out.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let [verdict, margin] = ["verdict_validated", "margin_validated"].map(column);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!([&rows[0][verdict], &rows[1][verdict]], ["present", "absent"]);
    let margins = [0, 1].map(|row: usize| rows[row][margin].parse::<f64>().unwrap());
    assert!(margins[0] > 0.0 && margins[1] < 0.0, "{margins:?}");
}

#[test]
fn standard_input_and_output() {
    let scratch = Scratch::new();
    let input = scratch.file("in.csv", TABLE);
    scratch.run("probe --points in.csv --out out.csv").ends_with(0);
    let mut command = scratch.command("probe --points - --out -");
    command.stdin(std::fs::File::open(input).unwrap());
    let piped = Run::of(command.output().unwrap()).ends_with(0);
    assert_eq!(piped.out, scratch.read("out.csv"));
    assert_eq!(piped.err, "", "no progress bar without a terminal");
}

/// A table of `rows` different points.
fn many(rows: usize) -> String {
    let row = |i: usize| {
        format!("0.1,0.3,0.1,2,{},{}\n", 0.5 + i as f64 / rows as f64, 0.25 + (i % 7) as f64 / 4.0)
    };
    "epsilon,alpha,beta,gamma,V,c\n".to_owned() + &(0..rows).map(row).collect::<String>()
}

#[test]
fn rows_keep_their_order_for_any_number_of_threads() {
    let scratch = Scratch::new();
    scratch.file("in.csv", many(500));
    for threads in ["1", "3"] {
        let out = format!("out{threads}.csv");
        scratch.run(&["probe", "--points", "in.csv", "--out", &out, "--threads", threads]).ends_with(0);
    }
    assert_eq!(scratch.read("out1.csv"), scratch.read("out3.csv"));
    for (row, original) in scratch.read("out1.csv").lines().zip(many(500).lines()) {
        assert!(row.starts_with(original));
    }
}

#[test]
fn tables_from_spreadsheets() {
    let scratch = Scratch::new();
    scratch.file("unix.csv", many(3));
    scratch.file("windows.csv", format!("\u{feff}{}", many(3).replace('\n', "\r\n")));
    for name in ["unix", "windows"] {
        let (input, out) = (format!("{name}.csv"), format!("{name}-out.csv"));
        scratch.run(&["probe", "--points", &input, "--out", &out]).ends_with(0);
    }
    assert_eq!(scratch.read("unix-out.csv"), scratch.read("windows-out.csv").replace('\r', ""));
}

#[test]
fn a_table_without_rows_stays_one() {
    let scratch = Scratch::new();
    scratch.file("in.csv", many(0));
    scratch.run("probe --points in.csv --out out.csv").ends_with(0);
    assert_eq!(scratch.read("out.csv").lines().count(), 1);
}

#[test]
fn existing_tables_are_kept_without_overwrite() {
    let scratch = Scratch::new();
    scratch.file("in.csv", many(2));
    scratch.file("out.csv", "precious");
    let arguments = ["probe", "--points", "in.csv", "--out", "out.csv", "--overwrite"];
    scratch.run(&arguments[..5]).refuses(&["out.csv", "exists already", "--overwrite"]);
    assert_eq!(scratch.read("out.csv"), "precious");
    scratch.run(&arguments).ends_with(0);
    assert_eq!(scratch.read("out.csv").lines().count(), 3);
    assert_eq!(scratch.names(), ["in.csv", "out.csv"]);
}

/// Probes the table and checks the refusal and that nothing was written, to a file or to standard output.
#[track_caller]
fn refused(table: impl AsRef<[u8]>, parts: &[&str]) {
    let scratch = Scratch::new();
    scratch.file("in.csv", table);
    for out in ["out.csv", "-"] {
        scratch.run(&["probe", "--points", "in.csv", "--out", out]).refuses(parts).refuses(&["help: "]);
        assert_eq!(scratch.names(), ["in.csv"], "something was written");
    }
}

/// A table whose line 17 has this value of beta.
fn line_17(beta: &str) -> String {
    let mut lines: Vec<String> = many(30).lines().map(str::to_owned).collect();
    lines[16] = lines[16].replacen("0.1,2,", &format!("{beta},2,"), 1);
    lines.join("\n") + "\n"
}

#[test]
fn bad_tables() {
    refused(many(3).replace("gamma", "gama"), &["in.csv:1", "`gamma` is missing", "gama"]);
    refused(
        many(3).replace(',', ";"),
        &["in.csv:1", "`epsilon` is missing", "separate the columns by commas"],
    );
    refused(
        many(3).replace("gamma", "gamma [m/s]"),
        &["in.csv:1: column 4: gamma is a number without a unit"],
    );
    refused(many(3).replace("gamma", "beta"), &["in.csv:1", "`beta` is there twice"]);
    refused("", &["in.csv:1", "`epsilon` is missing"]);
    let wide: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(many(3).encode_utf16().flat_map(u16::to_le_bytes)).collect();
    refused(wide, &["in.csv:1", "UTF-16", "save it as UTF-8"]);
    refused(line_17("high"), &["in.csv:17: column beta: `high`", "not a number"]);
    refused(line_17(""), &["in.csv:17: column beta: ``", "not a number"]);
    refused(line_17("nan"), &["in.csv:17: column beta: `nan`", "finite"]);
    refused(line_17("-2"), &["in.csv:17: column beta: `-2`", "at least 0"]);
    refused(line_17("0.1,0.1"), &["in.csv:17", "7 fields", "the header 6"]);
    refused(
        line_17("high").replace("0.1,0.3,0.1,2,0.5,", "0.1,0.3,low,2,0.5,"),
        &["in.csv:2: column beta: `low`"],
    );
    // Empty lines count, with either kind of line end, and so does a last row without a line end.
    let rows = line_17("high");
    for text in [rows.clone(), rows.replace('\n', "\r\n")] {
        let end = if text.contains('\r') { "\r\n" } else { "\n" };
        let spaced = text.replacen(end, &end.repeat(3), 1);
        refused(text, &["in.csv:17: column beta: `high`"]);
        refused(spaced, &["in.csv:19: column beta: `high`"]);
    }
    let last = many(3).trim_end().replace("\n0.1,0.3,0.1", "\n0.1,0.3,high").replacen("high", "0.1", 2);
    refused(last, &["in.csv:4: column beta: `high`"]);
    let again = many(3).replace("V,c", "V,c,regime").replace(".25\n", ".25,x\n");
    refused(again.lines().next().unwrap(), &["in.csv:1", "`regime` is there already"]);
}

#[test]
fn bad_table_places() {
    let scratch = Scratch::new();
    scratch.file("in.csv", many(2));
    std::fs::create_dir(scratch.path().join("folder")).unwrap();
    let run = |input: &str, out: &str| scratch.run(&["probe", "--points", input, "--out", out]);
    run("none.csv", "out.csv").refuses(&["none.csv: there is no such file", "help: "]);
    run("folder", "out.csv").refuses(&["folder: this is a folder", "help: "]);
    run("in.csv", "folder").refuses(&["--out folder: this is a folder", "help: "]);
    run("in.csv", "none/out.csv").refuses(&["none", "cannot write into the folder", "help: "]);
    run("in.csv", "in.csv/out.csv").refuses(&["cannot write into the folder in.csv", "help: "]);
    assert_eq!(scratch.names(), ["folder", "in.csv"]);
}

#[test]
fn a_reader_that_leaves_ends_the_command_silently() {
    let scratch = Scratch::new();
    // More than a pipe holds, so that a write fails at the closed end.
    scratch.file("in.csv", many(2000));
    let mut child = scratch.start("probe --points in.csv --out -");
    drop(child.stdout.take());
    let run = Run::after(child).ends_with(141);
    assert_eq!(run.err, "");
}

#[test]
fn orbits_are_written_from_any_start() {
    let scratch = Scratch::new();
    let run = |more: &[&str]| scratch.run(&[&PROBE[..], more].concat());
    run(&["--orbit", "o.csv", "--from", "-0.5,0.2", "--duration", "30"]).ends_with(0);
    let csv = scratch.read("o.csv");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("t,x1,x2,phase,slip_velocity"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
    assert!((number(&rows[0], 1) + 0.5).abs() < 1e-15 && (number(&rows[0], 2) - 0.2).abs() < 1e-15);
    assert!(rows.windows(2).all(|pair| number(&pair[0], 0) <= number(&pair[1], 0)), "time runs forward");
    assert_eq!(rows.last().unwrap()[0], "30.0");
    // While it sticks, the mass moves with the belt; V = 1.
    assert!(rows.iter().all(|row| number(row, 4) == 1.0 - number(row, 2)), "slip velocities");
    for pair in rows.windows(2).filter(|pair| pair[0][3] == "stick") {
        let (dt, dx) = (number(&pair[1], 0) - number(&pair[0], 0), number(&pair[1], 1) - number(&pair[0], 1));
        assert!((dt - dx).abs() < 1e-9, "{pair:?}");
    }
    // The cycle is repeated, and its last turn ends incomplete.
    run(&["--orbit", "o.csv", "--from", "-0.5,1", "--duration", "33.3", "--overwrite"]).ends_with(0);
    let csv = scratch.read("o.csv");
    let last = csv.lines().last().unwrap();
    assert!(last.starts_with("33.3,") && last.contains(",slip,"), "{last}");
    run(&["--orbit", "o.csv"]).refuses(&["--orbit o.csv", "choose another name", "--overwrite"]);
    run(&["--from", "0,0"]).refuses(&["--orbit FILE.csv"]);
    run(&["--orbit", "p.csv", "--from", "0"]).refuses(&["position and velocity"]);
    assert_eq!(scratch.names(), ["o.csv"]);
}
