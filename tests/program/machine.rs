//! Machines in SI units from configuration to map, report and probe, through the real binary.

use std::f64::consts::TAU;

use crate::command::{Says, Scratch};
use serde_json::Value;
use slipmap::machine::{Dimension, Motion};
use slipmap::store::MapFile;

/// An example configuration as distributed.
fn example(name: &str) -> String {
    std::fs::read_to_string(format!("{}/configs/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// The rows of a CSV table by column name.
pub fn rows(text: &str) -> Vec<std::collections::HashMap<String, String>> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
}

fn close(a: f64, b: f64, error: f64) {
    assert!((a - b).abs() <= error * b.abs(), "{a} {b}");
}

#[test]
fn examples_are_mapped_checked_and_probed_in_si_units() {
    for (name, motion, damping, speeds, dampings) in [
        ("brake_pad", Motion::Translation, "20", 40, 51),
        ("drill_string", Motion::Rotation, "222.3067", 40, 41),
    ] {
        let scratch = Scratch::new();
        scratch.file("machine.toml", example(name));
        scratch.run("run machine.toml --set output.path=map.h5").ends_with(0);
        scratch.run("check map.h5").ends_with(0);
        let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
        assert_eq!(map.grid().shape(), [speeds, dampings], "{name}");

        // The map records its machine, and its axes are the requested numbers.
        let machine = map.grid().machine().unwrap().clone();
        assert_eq!(machine.motion, motion);
        let config: toml_edit::DocumentMut = example(name).parse().unwrap();
        let axis = |key: &str| config["machine"][key].as_inline_table().unwrap();
        for (key, values) in
            [("belt_speed", &map.grid().axes()[0].values), ("damping", &map.grid().axes()[1].values)]
        {
            for (end, value) in [("from", values[0]), ("to", *values.last().unwrap())] {
                assert_eq!(value, axis(key).get(end).unwrap().as_float().unwrap());
            }
        }

        // It stick-slips at its lowest speed under the damping of its description; the critical damping and
        // speed end that, in the units of the file.
        let speed = axis("belt_speed").get("from").unwrap().as_float().unwrap();
        let at = |speed: f64, damping: &str| {
            format!("probe --machine machine.toml --set belt_speed={speed:?} --set damping={damping}")
        };
        let probe = |speed: f64, damping: &str| scratch.json(&at(speed, damping));
        let number = |answer: &Value, key: &str| answer["machine"][key].as_f64().unwrap();
        let answer = probe(speed, damping);
        close(
            number(&answer, "natural_frequency"),
            (machine.stiffness / machine.mass).sqrt() / TAU,
            4.0 * f64::EPSILON,
        );
        assert_eq!(answer["methods"]["simulation"]["verdict"], "present", "{name}");
        let critical = number(&answer, "critical_damping");
        let fastest = number(&answer, "critical_belt_speed");
        // The critical damping and speed are located far more closely than to a millionth.
        for (factor, verdict) in [(1.0 - 1e-6, "present"), (1.0 + 1e-6, "absent")] {
            // One of the two commands for each example.
            let here = match name {
                "drill_string" => probe(fastest * factor, damping),
                _ => probe(speed, &format!("{:?}", critical * factor)),
            };
            assert_eq!(here["methods"]["simulation"]["verdict"], verdict, "{name}");
        }
        // While it sticks it moves with the belt, at most from end to end of its motion.
        let travel = number(&answer, "stick_time") * speed;
        assert!(travel > 0.0 && travel <= 2.0 * number(&answer, "amplitude"), "{name}: {answer}");

        // Curves of the map's plane, with the points written beside the figure.
        let plot = "plot map.h5 --x belt_speed --y damping --variable regime --curves --out p.svg";
        scratch.run(plot).ends_with(0);
        let figure = scratch.read("p.svg");
        figure.says(&[
            "grazing",
            &format!("{}, {}", motion.words("belt_speed"), motion.unit(Dimension::Velocity)),
            &format!("damping, {}", motion.unit(Dimension::Damping)),
        ]);
        let mut met = 0;
        for row in rows(&scratch.read("p.csv")).iter().filter(|row| row["curve"] == "grazing_sliding") {
            let number = |key: &str| row[key].parse::<f64>().unwrap();
            let speed = number(&format!("belt_speed [{}]", motion.unit(Dimension::Velocity)));
            let damping = number(&format!("damping [{}]", motion.unit(Dimension::Damping)));
            let model = machine.with("belt_speed", speed).unwrap().model().unwrap();
            let root = slipmap::column::critical_damping(&model.column(), 1e-10).unwrap();
            // c* changes by at most a hundred from side to side, and is located to 1e-10.
            assert!(number("error") < 1e-9);
            assert!((root.c - damping / model.si.damping).abs() < 1e-7, "{row:?} {root:?}");
            met += 1;
        }
        assert!(met > 20, "{name}: {met}");
        std::fs::remove_file(scratch.path().join("p.svg")).unwrap();
        scratch.run(plot).refuses(&["p.csv", "--overwrite"]);

        // The text output has the same numbers.
        let text = scratch.run(&at(speed, damping)).ends_with(0).out;
        let speed = if motion == Motion::Rotation { "critical rotary speed" } else { "critical belt speed" };
        text.says(&["in SI units", speed, motion.unit(Dimension::Damping), "Hz", "amplitude"]);
    }
}

#[test]
fn a_report_has_a_table_in_si_units() {
    let scratch = Scratch::new();
    scratch.file("machine.toml", example("brake_pad"));
    // Few cells: drawing dominates the time.
    let small = "--set machine.belt_speed=[0.05,0.1,0.4] --set machine.damping=[0.0,20.0]";
    let run = format!("run machine.toml --set output.path=map.h5 {small}");
    scratch.run(&run).ends_with(0);
    scratch.run("report map.h5 --out report").ends_with(0);
    let table = rows(&scratch.read("report/tables/machine.csv"));
    let speeds: Vec<f64> = table.iter().map(|row| row["belt_speed [m/s]"].parse().unwrap()).collect();
    assert_eq!(speeds.len(), 3);
    for (speed, wanted) in speeds.iter().zip([0.05, 0.1, 0.4]) {
        close(*speed, wanted, 4.0 * f64::EPSILON);
    }
    // The machine of the report is the one at the middle damping, the larger of two; the other is undamped.
    let probe = "probe --machine machine.toml --set belt_speed=0.1 --set damping=20";
    let answer = scratch.json(probe);
    for (key, unit) in [
        ("critical_damping", " [N s/m]"),
        ("critical_damping_ratio", ""),
        ("slip_time", " [s]"),
        ("stick_time", " [s]"),
        ("amplitude", " [m]"),
    ] {
        // Speeds differ by round-off; the results are computed to 1e-9.
        let shown = table[1][&format!("{key}{unit}")].parse().unwrap();
        close(shown, answer["machine"][key].as_f64().unwrap(), 1e-6);
    }
    let failures = scratch.read("report/tables/failures.csv");
    failures.says(&["cells whose regime is not determined,0"]);
    let words = scratch.read("report/report.html");
    words.says(&["What the machine does at damping 20 N s/m, in SI units"]);
    assert!(
        words.contains("<dt>amplitude</dt>") && words.contains(" at belt speed 0.1 m/s and damping 20 N s/m")
    );
    // Where the mass varies, the machine of the report is that of its figures, and named.
    let run = run.replace("machine.belt_speed=[0.05,0.1,0.4]", "machine.belt_speed=[0.1,0.2]");
    scratch.run(&format!("{run} --overwrite --set machine.mass=[1.0,4.0]")).ends_with(0);
    scratch.run("report map.h5 --out report --overwrite").ends_with(0);
    let words = scratch.read("report/report.html");
    words.says(&["What the machine does at damping 20 N s/m, mass = 1 kg"]);
    let answer = scratch.json(&format!("{probe} --set mass=1"));
    let frequency = answer["machine"]["natural_frequency"].as_f64().unwrap();
    assert!(
        words.contains(&format!("<dt>natural frequency</dt><dd>{frequency:.1} Hz")),
        "{frequency} {words}"
    );
}

/// For a rotation the mass is the moment of inertia, under either name: in a file, as an option, in a table.
#[test]
fn what_rotates_has_an_inertia() {
    let scratch = Scratch::new();
    let named = example("drill_string");
    assert!(named.contains("\nmass = "));
    scratch.file("mass.toml", &named);
    scratch.file("inertia.toml", named.replace("\nmass = ", "\ninertia = "));
    let at = ["--set", "belt_speed=5", "--set", "damping=1000", "--json"];
    let probe =
        |file: &str, more: &[&str]| scratch.run(&[&["probe", "--machine", file], &at[..], more].concat());
    let answer = |file: &str, more: &[&str]| probe(file, more).ends_with(0).out;
    assert_eq!(answer("inertia.toml", &[]), answer("mass.toml", &[]));
    assert_eq!(
        answer("mass.toml", &["--set", "inertia=300"]),
        answer("inertia.toml", &["--set", "mass=300"])
    );
    scratch.file("mass.csv", "mass\n300\n400\n");
    scratch.file("inertia.csv", "inertia\n300\n400\n");
    scratch.file("both.csv", "inertia,mass\n300,300\n");
    let table = |file: &str, more: &[&str]| {
        let points = ["probe", "--machine", "inertia.toml", "--quiet", "--points", file, "--out", "-"];
        scratch.run(&[&points[..], &at[..4], more].concat())
    };
    let answers = |file: &str| table(file, &[]).ends_with(0).out.replace("inertia", "mass");
    assert_eq!(answers("inertia.csv"), answers("mass.csv"));
    scratch.file("units.csv", "mass\n300 g\n");
    table("units.csv", &[]).refuses(&["units.csv:2", "`300 g` is not a number", "unit into the header"]);
    table("both.csv", &[]).refuses(&["both.csv:1", "the same quantity"]);
    table("inertia.csv", &["--set", "mass=1"]).refuses(&["inertia.csv:1", "`inertia`", "mass is given"]);
    scratch.file("both.toml", named.replace("\nmass = ", "\ninertia = 1\nmass = "));
    probe("both.toml", &[]).refuses(&["both.toml", "the same quantity"]);
    scratch.file("pad.toml", example("brake_pad").replace("\nmass = ", "\ninertia = "));
    scratch.run("probe --machine pad.toml").refuses(&["pad.toml", "inertia", "motion", "rotation"]);
}

#[test]
fn bad_machines_are_refused_with_their_place() {
    let scratch = Scratch::new();
    let good = "[friction]\nlaw = \"stribeck\"\n[machine]\nmass = 2.0\nstiffness = 800.0\nnormal_force = 50.0\n\
                static_friction = 0.4\nkinetic_friction = 0.3\nstribeck_velocity = 0.25\nbelt_speed = [0.1, 0.2]\n\
                damping = 4.0\n";
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        scratch.file("bad.toml", good.replace(from, to));
        scratch.run("run bad.toml")
    };
    with("mass = 2.0", "mass = -2.0").refuses(&["bad.toml:4:8", "mass must be greater than 0", "kg"]);
    with("mass = 2.0", "mass = \"2 m\"").refuses(&["bad.toml:4:8", "\"2 m\"", "no unit of mass"]);
    with("mass = 2.0\n", "").refuses(&["bad.toml", "`mass` is missing", "SI units"]);
    with("mass", "mas").refuses(&["bad.toml:4:1", "`mas`", "`mass`"]);
    with("kinetic_friction = 0.3", "kinetic_friction = 0.5")
        .refuses(&["bad.toml:8:20", "kinetic_friction must be from 0 to static_friction"]);
    with("[0.1, 0.2]", "[0.2, 0.1]").refuses(&["bad.toml:10:14", "0.1 follows 0.2", "sort"]);
    with("damping = 4.0", "damping = -4.0").refuses(&["bad.toml:11:11", "damping must be at least 0"]);
    with("damping = 4.0", "damping = 4.0\nstrengthening = -1.0").refuses(&["bad.toml:12:17", "at least 0"]);
    with("law = \"stribeck\"", "law = \"expression\"\nphi = \"1 - 0.1*tanh(u)\"").refuses(&[
        "bad.toml:8:1",
        "`static_friction`",
        "leave it out",
        "it belongs to the laws stribeck, exponential",
    ]);
    with("damping = 4.0", "damping = 4.0\n[grid]\nepsilon = 1.0").refuses(&[
        "bad.toml",
        "machine",
        "leave the other out",
    ]);

    scratch.file("good.toml", good);
    let probe = |more: &[&str]| scratch.run(&[&["probe", "--machine", "good.toml"], more].concat());
    probe(&[]).refuses(&["good.toml", "belt_speed has 2 values", "--set belt_speed=0.1"]);
    probe(&["--set", "belt_speed=-1"]).refuses(&["belt_speed", "-1", "greater than 0"]);
    probe(&["--set", "belt_speed=0.1", "--set", "mas=1"]).refuses(&["`mas`", "`mass`"]);
    probe(&["--set", "belt_speed=nan"]).refuses(&["belt_speed = nan: ", "must be greater than 0"]);
    probe(&["--set", "belt_speed={ value = 0.1, sd = 0.01 }"]).refuses(&["spread", "configuration"]);
    probe(&["--set", "belt_speed=\"0.1 kN\""]).refuses(&["kN is no unit of belt speed"]);
    assert_eq!(
        probe(&["--set", "belt_speed=\"100 mm/s\""]).out,
        probe(&["--set", "belt_speed=100 mm/s"]).ends_with(0).out
    );
    // Every missing key is named at once.
    with("mass = 2.0\nstiffness = 800.0\n", "").refuses(&["`mass` is missing", "also lacks stiffness"]);
    with("mass = 2.0", "mass = { value = 2.0, sd = -1.0 }").refuses(&["bad.toml:4:28", "at least 0"]);
    with("mass = 2.0", "mass = { value = 2.0 }").refuses(&["`sd` is missing", "sd = 0.1"]);
    with("mass = 2.0", "mass = { min = 3.0, max = 2.0 }")
        .refuses(&["bad.toml:4:8", "min must be at most max"]);
    scratch.run("probe --machine none.toml").refuses(&["none.toml"]);
    scratch.file("grid.toml", "[grid]\nepsilon = 1.0\n");
    scratch.run("probe --machine grid.toml").refuses(&["grid.toml", "[machine]"]);
    assert_eq!(scratch.names(), ["bad.toml", "good.toml", "grid.toml"]);
}

/// Two machines on one page: the answers of each, beside each other.
#[test]
fn two_machines_share_a_page() {
    let scratch = Scratch::new();
    scratch.file("before.toml", example("brake_pad"));
    scratch.file("after.toml", example("brake_pad").replace("mass = 2.0", "mass = 3.0"));
    let machine = |more: &str| format!("machine {more} --set belt_speed=0.2 --set damping=180");
    let json = |more: &str| scratch.json(&machine(more));
    let both = json("before.toml after.toml");
    assert_eq!(both, Value::from(vec![json("before.toml"), json("after.toml")]));
    assert_ne!(both[0], both[1]);
    let text = scratch.run(&machine("before.toml after.toml --out both.html")).ends_with(0).out;
    let row = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).unwrap().to_owned();
    assert!(row("mass").contains("2 kg") && row("mass").contains("3 kg"), "{text}");
    let digits = |at: usize| format!("{:.1}", both[at]["may_stick_slip_below_damping"].as_f64().unwrap());
    assert!(row("may stick-slip below damping").contains(&digits(0)), "{text}");
    assert!(row("may stick-slip below damping").contains(&digits(1)), "{text}");
    let html = scratch.read("both.html");
    assert!(
        html.matches("<svg").count() == 4 && html.contains(": before.toml") && html.contains(": after.toml")
    );
    // The kick and its impulse.
    let number = |key: &str| both[1][key].as_f64().unwrap();
    close(number("kick_forward_impulse"), 3.0 * number("kick_forward"), 1e-12);
}

#[test]
fn a_page_assesses_a_machine() {
    let scratch = Scratch::new();
    scratch.file("brake.toml", example("brake_pad"));
    let answer = scratch.json("machine brake.toml --set belt_speed=0.2 --set damping=180");
    let number = |key: &str| answer[key].as_f64().unwrap();
    assert_eq!(answer["regime"], "bistable");
    // Between the two thresholds of damping it depends on the initial state.
    assert!(
        number("always_stick_slips_below_damping") < 180.0 && 180.0 < number("may_stick_slip_below_damping")
    );
    let probed = scratch.json("probe --machine brake.toml --set belt_speed=0.2 --set damping=180");
    close(
        number("may_stick_slip_below_damping"),
        probed["machine"]["critical_damping"].as_f64().unwrap(),
        1e-9,
    );
    for way in ["forward", "backward"] {
        let kick = probed["basin_boundary"]["kick"][way].as_f64().unwrap();
        let unit = probed["machine"]["units"]["velocity"].as_f64().unwrap();
        close(number(&format!("kick_{way}")), kick * unit, 1e-12);
    }
    // The page shows what `probe` proves.
    let proved = answer["proofs"].as_array().unwrap().iter().find(|proof| proof["test"] == "validated");
    assert_eq!(proved.unwrap()["verdict"], probed["methods"]["validated"]["verdict"]);
    assert_eq!(proved.unwrap()["verdict"], "present");
}

/// The page in every format names its source, and shows the friction curve.
#[test]
fn a_page_is_written_in_every_format() {
    let scratch = Scratch::new();
    scratch.file("brake.toml", example("brake_pad"));
    let run = |more: &[&str]| {
        let point = ["machine", "brake.toml", "--set", "belt_speed=0.2", "--set", "damping=180"];
        scratch.run(&[&point[..], more].concat())
    };
    let text = run(&["--out", "page.html"]).ends_with(0).out;
    assert!(!text.contains("stribeck velocity") && text.matches("Stribeck velocity").count() == 2, "{text}");
    let html = scratch.read("page.html");
    assert!(html.contains("<svg") && html.contains("working point"));
    run(&["--out", "page.pdf"]).ends_with(0);
    run(&["--out", "page.pdf"]).refuses(&["page.pdf", "--overwrite"]);
    run(&["--out", "page.svg"]).ends_with(0);
    let svg = scratch.read("page.svg");
    roxmltree::Document::parse(&svg).unwrap();
    for page in [&svg, &html] {
        // The source line of the page, and the friction curve.
        let source = format!("slipmap {}, 20", env!("CARGO_PKG_VERSION"));
        assert!(
            page.contains(&source) && page.contains(": brake.toml --set belt_speed=0.2 --set damping=180")
        );
        assert!(page.contains("Coefficient of friction; dashed: the belt speed"));
        assert!(page.contains("s slope at each slip speed, %") && !page.contains("for the curve through"));
    }
}

/// A probability with its limits, and a damping for each share.
#[test]
fn a_page_of_an_uncertain_machine_has_its_probability() {
    let scratch = Scratch::new();
    let uncertain = example("brake_pad")
        .replace("normal_force = 1000.0", "normal_force = { value = 1000.0, sd = 200.0 }");
    scratch.file("uncertain.toml", uncertain);
    let risk = "machine uncertain.toml --set belt_speed=0.2 --set damping=250 --draws 2000";
    let answer = scratch.json(risk);
    assert_eq!(answer["risk"]["by_itself"]["value"], 0.0);
    let found = &answer["risk"]["probability"];
    let [low, high] = [0, 1].map(|i| found["limits_95"][i].as_f64().unwrap());
    let value = found["value"].as_f64().unwrap();
    assert!(0.0 < low && low < value && value < high && high < 1.0, "{found}");
    let rare = answer["risk"]["rare_by"].as_array().unwrap();
    assert!(rare.len() == 3 && rare[0]["damping"]["value"].as_f64().unwrap() > 250.0, "{rare:?}");
}

#[test]
fn a_machine_is_plotted_in_its_units() {
    let scratch = Scratch::new();
    scratch.file("machine.toml", example("brake_pad"));
    let small = "--set machine.belt_speed=[0.05,0.1,0.2] --set machine.damping=[100.0]";
    let fields = "--set output.fields=['verdict','critical_damping','cycle','basin'] --set curves.planes=[]";
    scratch.run(&format!("run machine.toml --set output.path=map.h5 {small} {fields}")).ends_with(0);
    // One damping: a line over the speed instead of an area, with every unit named.
    let plot = "plot map.h5 --x belt_speed --y damping --variable critical_damping_simulation";
    let run = scratch.run(&format!("{plot} --out a.svg --data a.csv")).ends_with(0);
    run.err.says(&["damping has one node"]);
    let figure = scratch.read("a.svg");
    assert!(figure.contains("belt speed, m/s") && figure.contains("simulation, N s/m"));
    let table = rows(&scratch.read("a.csv"));
    assert_eq!(table.len(), 3);
    for row in table {
        let set = format!("--set belt_speed={}", row["belt_speed [m/s]"]);
        let answer = scratch.json(&format!("probe --machine machine.toml --set damping=100 {set}"));
        close(
            row["critical_damping_simulation [N s/m]"].parse().unwrap(),
            answer["machine"]["critical_damping"].as_f64().unwrap(),
            1e-6,
        );
    }
    // The bifurcation diagram over any range, and an orbit, both in SI units.
    let plot = "plot map.h5 --x damping --range 50,300 --diagram --at belt_speed=0.2";
    scratch.run(&format!("{plot} --out d.svg --data d.csv")).ends_with(0);
    let branches = rows(&scratch.read("d.csv"));
    let kinds: std::collections::BTreeSet<_> =
        branches.iter().map(|row| (row["kind"].clone(), row["attracts"].clone())).collect();
    for (kind, attracts) in [
        ("equilibrium", "true"),
        ("equilibrium", "false"),
        ("slip_cycle", "false"),
        ("stick_slip_cycle", "true"),
    ] {
        assert!(kinds.contains(&(kind.into(), attracts.into())), "{kinds:?}");
    }
    let reach = |kind: &str| {
        let of = branches.iter().filter(|row| row["kind"] == kind);
        of.map(|row| row["damping [N s/m]"].parse::<f64>().unwrap()).fold(0.0, f64::max)
    };
    let probe = "probe --machine machine.toml --set belt_speed=0.2 --set damping=100";
    let answer = scratch.json(probe);
    // Stick-slip ends at the critical damping, where the diagram located its end to a ten-millionth of a
    // step.
    close(reach("stick_slip_cycle"), answer["machine"]["critical_damping"].as_f64().unwrap(), 1e-6);
    scratch.run(&format!("{probe} --orbit o.csv --duration 0.05")).ends_with(0);
    let orbit = rows(&scratch.read("o.csv"));
    let last = |key: &str| orbit.last().unwrap()[key].parse::<f64>().unwrap();
    close(last("t [s]"), 0.05, 1e-15);
    let fastest = orbit.iter().map(|row| row["x2 [m/s]"].parse::<f64>().unwrap()).fold(0.0, f64::max);
    close(fastest, 0.2, 1e-9);
    assert!(orbit.iter().any(|row| row["phase"] == "stick"));
}

/// The command for a cell of a machine probes that machine: its table and its quantities are in SI units.
#[test]
fn the_command_for_a_failed_cell_of_a_machine_asks_about_it() {
    let scratch = Scratch::new();
    scratch.file("pad.csv", "0,0.43\n0.1,0.36\n0.3,0.31\n0.6,0.28\n1.2,0.27\n");
    let text = "[machine]\nmass = 2\nstiffness = 5e5\nnormal_force = 1000\nbelt_speed = [0.1, 0.5997]\ndamping = [0, 300]\n\
                [friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n[methods]\nrun = [\"simulation\"]\n[output]\npath = \"pad.h5\"\n\
                [curves]\nplanes = [{ x = \"belt_speed\", y = \"damping\" }]\n";
    scratch.file("pad.toml", text);
    let run = scratch.run("run pad.toml");
    run.out.says(&["next:", "slipmap plot pad.h5 --x belt_speed --y damping"]);
    // The command that asks about the failed cell.
    let command_of = |run: &str| {
        let told = scratch.run(run).json();
        told["failed_cells"][0]["probe"].as_str().unwrap().replace('\'', "").replacen("slipmap ", "", 1)
    };
    let command = command_of("run pad.toml --overwrite --quiet --json");
    assert!(
        command.starts_with("probe --machine pad.toml --set damping=0 --set belt_speed=0.599"),
        "{command}"
    );
    // The known part of an undetermined regime is told, and how far to measure.
    let answer = scratch.json(&command);
    assert!(
        answer["regime_known"].is_string() && answer["machine"]["needed_slip_speed"].is_f64(),
        "{answer}"
    );
    // The command contains the values that the run overrode.
    let command =
        command_of("run pad.toml --quiet --json --set machine.normal_force=950 --set output.path='set.h5'");
    let set = "probe --machine pad.toml --set damping=0 --set normal_force=950 --set belt_speed=0.599";
    assert!(command.starts_with(set), "{command}");
}

/// Where an orbit leaves the data, the required slip speed is reported in SI units; data up to it suffice.
#[test]
fn an_engineer_is_told_how_far_to_measure() {
    let scratch = Scratch::new();
    let rows = "0,0.43\n0.1,0.36\n0.3,0.31\n0.6,0.28\n1.2,0.27\n";
    scratch.file("pad.csv", rows);
    scratch.file(
        "pad.toml",
        "[machine]\nmass = 2\nstiffness = 5e5\nnormal_force = 1000\nbelt_speed = 0.5997\ndamping = 0\n\
         [friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n",
    );
    let probe = "probe --machine pad.toml";
    let answer = || scratch.json(probe);
    let before = answer();
    let needed = before["machine"]["needed_slip_speed"].as_f64().unwrap();
    assert!(needed > 1.2 && before["machine"]["slip_time"].is_null(), "{before}");
    let [digits, words] = [format!("{needed:.2}"), format!("up to about {needed:.2} m/s")];
    let text = scratch.run(probe).ends_with(0).out;
    let line = text.lines().find(|line| line.contains("measure friction up to"));
    assert!(line.is_some_and(|line| line.contains(&digits) && line.contains("m/s")), "{text}");
    scratch.run("machine pad.toml").ends_with(0).out.says(&["which end at slip speed 1.2 m/s", &words]);
    scratch.file("pad.csv", format!("{rows}{needed},{}\n", 0.27 - 0.01 / 0.6 * (needed - 1.2)));
    let after = answer();
    assert!(after["machine"]["needed_slip_speed"].is_null(), "{after}");
    assert!(after["machine"]["slip_time"].is_f64(), "{after}");
}

/// A table with standard errors that ends too early for any critical damping still has its page.
#[test]
fn a_page_of_data_that_end_early_says_what_is_known() {
    let scratch = Scratch::new();
    scratch.file("early.csv", "v,F,se\n0,450,3\n0.02,390,3\n0.05,350,3\n0.1,320,3\n0.2,300,3\n");
    scratch.file(
        "early.toml",
        "[machine]\nmass = 2\nstiffness = 2e5\nbelt_speed = 0.1\ndamping = 50\n\
         [friction]\nlaw = \"table\"\nfile = \"early.csv\"\nquantity = \"force\"\n",
    );
    let answer = scratch.json("machine early.toml --draws 100 --out page.html");
    assert!(answer["risk"].is_null() && answer["steady_slip_unstable_below_damping"].is_f64(), "{answer}");
    assert_eq!(answer["limits"]["may_stick_slip_below_damping"]["status"], "not_determined");
    assert!(answer["needed_slip_speed"].as_f64().unwrap() > 0.2, "{answer}");
    scratch.read("page.html").says(&["no critical damping was found for any draw"]);
}

/// Where it is proved that there are no slip cycles, they are no reason why the regime is not determined; and programs are
/// told the reasons that people are.
#[test]
fn an_undetermined_regime_has_its_reasons() {
    let scratch = Scratch::new();
    scratch.file("rig.csv", "v [m/s],F [N]\n0,1210\n.02,1060\n.05,900\n.1,780\n.2,725\n");
    scratch.file(
        "rig.toml",
        "[machine]\nmass = 0.4\nstiffness = 3e5\nbelt_speed = 0.09\ndamping = 300\n\
         [friction]\nlaw = \"table\"\nfile = \"rig.csv\"\n",
    );
    let (machine, probe) = ("machine rig.toml", "probe --machine rig.toml");
    let [page, probed] = [machine, probe].map(|command| scratch.run(command).ends_with(0).out);
    // The line with this name.
    let of = |text: &str, name: &str| {
        let values = text.lines().filter_map(|line| line.trim_start().strip_prefix(name));
        values.map(|value| value.trim_start().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(of(&probed, "slip cycles  "), ["none, count proved"], "{probed}");
    let whys = of(&page, "what is not, and why");
    assert!(whys.len() == 1 && whys[0].starts_with("stick-slip: the orbit leaves the data"), "{page}");

    let [told, answer] = [machine, probe].map(|command| scratch.json(command));
    assert_eq!(told["regime"], "failed");
    assert_eq!(told["regime_known"], of(&page, "what is known of it")[0].as_str());
    assert_eq!(told["regime_reasons"], serde_json::json!(whys));
    let kick = told["kick_reason"].as_str().unwrap();
    assert_eq!(of(&page, "kick that starts it"), [format!("not determined: {kick}")]);
    let vibrates = told["limits"]["vibrates_below_damping"]["reason"].as_str().unwrap();
    page.says(&[&format!("not determined: {vibrates}")]);
    assert_eq!(answer["regime_known"], of(&probed, "what is known of it")[0].as_str());
    assert!(
        answer["regime_reason"].as_str().unwrap().starts_with("stick-slip cycle: the orbit leaves the data")
    );
    for proof in told["proofs"].as_array().unwrap() {
        let reason = &proof["reason"];
        assert!(reason.is_string() == (proof["verdict"] == "undecided"), "{proof}");
        assert_eq!(reason, &answer["methods"][proof["test"].as_str().unwrap()]["reason"], "{proof}");
    }
    // What is determined has no reasons.
    scratch.file("rig.csv", "v [m/s],F [N]\n0,1210\n.02,1060\n.05,900\n.1,780\n.2,725\n2,725\n");
    let [told, answer] = [machine, probe].map(|command| scratch.json(command));
    assert!(
        told["regime_known"].is_null() && told["regime_reasons"].is_null() && told["kick_reason"].is_null()
    );
    assert!(answer.get("regime_known").is_none() && answer.get("regime_reason").is_none(), "{answer}");
}

/// `probe --machine` and the page of the machine report the same standard error of the critical damping.
#[test]
fn the_standard_error_of_a_machine_is_told_alike() {
    let scratch = Scratch::new();
    scratch.file(
        "pad.csv",
        "u,mu,se\n0,0.43,0.004\n0.02,0.39,0.004\n0.1,0.33,0.004\n0.3,0.28,0.004\n0.6,0.26,0.004\n1.2,0.26,0.004\n",
    );
    let text = "[machine]\nmass = 2\nstiffness = 5e5\nnormal_force = 1000\nbelt_speed = 0.15\ndamping = 30\n\
                [friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n";
    scratch.file("pad.toml", text);
    let probe = scratch.run("probe --machine pad.toml").ends_with(0).out;
    let line = probe.lines().find(|line| line.trim_start().starts_with("critical damping ")).unwrap();
    let error = line.split_once("+- ").unwrap().1.split(' ').next().unwrap();
    let page = scratch.json("machine pad.toml");
    let of_page = &page["may_stick_slip_below_damping_standard_error"];
    let (error, of_page): (f64, f64) = (error.parse().unwrap(), of_page.as_f64().unwrap());
    // Rounded up to two digits.
    assert!(error >= of_page && error < 1.1 * of_page, "{line} {of_page}");
}
