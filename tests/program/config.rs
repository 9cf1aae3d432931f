//! Every unusable configuration gives one message with place, value and remedy, exit code 2, and no file.

use slipmap::config::Job;
use slipmap::map::Plane;

use crate::command::Scratch;

/// A legal configuration, one statement per line, so that a test can replace one.
const LEGAL: &str = "\
title = \"legal\"
[friction]
law = \"stribeck\"
[grid]
epsilon = 0.1
alpha = [0.0, 0.5]
beta = 0.0
gamma = { from = 1.0, to = 2.0, points = 3 }
V = 1.0
c = { from = 0.0, to = 2.0, points = 5 }
[methods]
run = [\"perturbation\", \"simulation\"]
[simulation]
# of margins
tolerance = 1e-9
[audit]
cells = 3
[output]
path = \"map.h5\"
fields = [\"verdict\"]
compression = 4
";

/// Replaces the line that begins with `key`.
fn with(key: &str, line: &str) -> String {
    let old: Vec<&str> = LEGAL.lines().filter(|old| old.starts_with(key)).collect();
    assert_eq!(old.len(), 1, "{key}");
    LEGAL.replacen(&format!("{}\n", old[0]), &format!("{line}\n"), 1)
}

/// The configuration with this line in place of that of its key.
fn line(line: &str) -> String {
    with(&line[..line.find('=').unwrap() + 1], line)
}

/// Runs the configuration and checks the refusal and that the folder is unchanged.
#[track_caller]
fn refused(text: impl AsRef<[u8]>, parts: &[&str]) {
    let scratch = Scratch::new();
    scratch.file("bad.toml", text);
    scratch.run("run bad.toml").refuses(parts).refuses(&["help: "]);
    assert_eq!(scratch.names(), ["bad.toml"], "something was written");
}

/// Checks the refusal of this line in place of that of its key, at this place of the file.
#[track_caller]
fn wrong(text: &str, place: &str, parts: &[&str]) {
    refused(line(text), &[&[format!("bad.toml:{place}").as_str()], parts].concat());
}

/// Checks the refusal of an override of a legal configuration.
#[track_caller]
fn override_refused(set: &str, parts: &[&str]) {
    let scratch = Scratch::new();
    scratch.file("legal.toml", LEGAL);
    scratch
        .run(&["run", "legal.toml", "--set", set])
        .refuses(parts)
        .refuses(&[&format!("--set {set}"), "help: "]);
    assert_eq!(scratch.names(), ["legal.toml"], "something was written");
}

#[test]
fn missing_axes_and_sections() {
    refused(with("beta", ""), &["bad.toml:4:", "`beta` is missing from [grid]", ":\n    beta = 1.0\n"]);
    refused("title = \"x\"\n", &["bad.toml:1:1", "`epsilon` is missing from [grid]"]);
}

#[test]
fn unknown_keys_name_the_nearest() {
    for (key, line, place, unknown) in [
        ("alpha", "alfa = 0.5", "bad.toml:6:1", "unknown key `alfa` in [grid]"),
        ("title", "titel = \"x\"", "bad.toml:1:1", "unknown key `titel`"),
        ("tolerance", "tolerence = 1e-9", "bad.toml:15:1", "unknown key `tolerence` in [simulation]"),
        ("[audit]", "[audits]", "bad.toml:16:", "unknown key `audits`"),
    ] {
        let nearest = format!(
            "valid key {}is `{}`",
            if key == "tolerance" { "here " } else { "" },
            key.trim_matches(['[', ']'])
        );
        refused(with(key, line), &[place, unknown, &nearest]);
    }
    refused(with("cells", "tolerance = 1e-9"), &["bad.toml:17:1", "`tolerance` belongs in [simulation]"]);
    refused(with("cells", "title = \"x\""), &["bad.toml:17:1", "belongs at the top of the file"]);
    wrong(
        "gamma = { from = 1.0, to = 2.0, point = 3 }",
        "8:33",
        &["unknown key `point` in grid.gamma", "nearest valid key is `points`"],
    );
}

#[test]
fn the_remedy_is_what_to_write() {
    wrong(
        "gamma = { from = 1.0, to = 2.0, step = 0.25 }",
        "8:33",
        &["unknown key `step` in grid.gamma", "{ from = 1, to = 2, points = 5 }"],
    );
    refused(line("gamma = { step = 0.25 }"), &["`step` in grid.gamma", "points = 11 }"]);
    refused(line("alpha = \"0.5\""), &["grid.alpha = \"0.5\"", "this is text", "without quotes: 0.5"]);
    refused(line("alpha = \"0,5\""), &["grid.alpha = \"0,5\"", "write decimals with a point: 0.5"]);
    wrong("alpha = 0.5 kg # of sand", "6:", &["write the number alone", ": 0.5\n"]);
    wrong("alpha = .5", "6:", &["write 0.5\n"]);
    // The value without the comment behind it.
    refused(line("alpha = -0.5 # a comment"), &["grid.alpha = -0.5: "]);
}

#[test]
fn wrong_types() {
    wrong("alpha = \"0.5\"", "6:9", &["grid.alpha = \"0.5\"", "this is text", "a list of numbers"]);
    wrong("alpha = [0.0, true]", "6:15", &["grid.alpha[1] = true", "a truth value, not a number"]);
    wrong(
        "gamma = { from = 1, to = 2, points = 3.5 }",
        "8:38",
        &["grid.gamma.points = 3.5", "not a whole number"],
    );
    wrong(
        "gamma = { from = \"a\", to = 2, points = 3 }",
        "8:18",
        &["grid.gamma.from = \"a\"", "not a number"],
    );
    wrong("gamma = { from = 1, to = 2 }", "8:9", &["`points` is missing from grid.gamma"]);
    wrong("title = 3", "1:9", &["title = 3", "not text"]);
    wrong("run = \"simulation\"", "12:7", &["methods.run", "not a list of methods"]);
    wrong("cells = 2.5", "17:9", &["audit.cells = 2.5", "not a whole number"]);
    refused("grid = 3\n", &["bad.toml:1:8", "grid = 3", "not a table"]);
    refused("[[grid]]\nalpha = 1\n", &["bad.toml:1:1", "grid", "a list of tables, not a table"]);
}

#[test]
fn bad_axes() {
    wrong("alpha = []", "6:9", &["grid.alpha = []", "no values"]);
    wrong("alpha = [0.5, 0.2]", "6:15", &["grid.alpha[1] = 0.2", "0.2 follows 0.5", "sort"]);
    wrong("alpha = [0.2, 0.5, 0.5]", "6:20", &["grid.alpha[2] = 0.5", "appears twice"]);
    wrong("gamma = { from = 2.0, to = 1.0, points = 3 }", "8:9", &["backwards, from 2 to 1", "swap"]);
    wrong("gamma = { from = 2.0, to = 2.0, points = 3 }", "8:", &["3 points between 2 and 2"]);
    wrong("gamma = { from = 1.0, to = 2.0, points = 1 }", "8:42", &["one point cannot be both ends"]);
    wrong("gamma = { from = 1.0, to = 2.0, points = 0 }", "8:42", &["must be from 1 to"]);
    wrong("gamma = { from = 1.0, to = 2.0, points = 1000000000000 }", "8:42", &["must be from 1 to"]);
    wrong("gamma = { from = 1.0, to = 1.0000000000000004, points = 9 }", "8:", &["too close"]);
    wrong(
        "gamma = { from = 0, to = 2, points = 3, spacing = \"log\" }",
        "8:18",
        &["grid.gamma.from = 0", "logarithmic"],
    );
    wrong(
        "gamma = { from = 1, to = 2, points = 3, spacing = \"logarithmic\" }",
        "8:51",
        &["unknown spacing", "nearest valid spacing is `log`"],
    );
    wrong("gamma = { from = 1, to = inf, points = 3 }", "8:26", &["grid.gamma.to = inf", "finite"]);
}

#[test]
fn values_outside_their_domains() {
    let cases = [
        ("epsilon = 0", "5:11", "greater than 0"),
        ("epsilon = -0.1", "5:11", "greater than 0"),
        ("alpha = [0.5, 1.5]", "6:15", "between 0 and 1"),
        ("alpha = -0.5", "6:9", "between 0 and 1"),
        ("beta = -1", "7:8", "at least 0"),
        ("gamma = -1", "8:9", "at least 0"),
        ("V = 0", "9:5", "greater than 0"),
        ("V = -1", "9:5", "greater than 0"),
        ("V = [nan, 1.0]", "9:6", "finite"),
        ("c = -0.5", "10:5", "at least 0"),
        ("c = inf", "10:5", "finite"),
        ("c = 1e400", "10:5", "overflow"),
        ("tolerance = 1e-15", "15:13", "from 1e-14 to 1e-2"),
        ("tolerance = 0.1", "15:13", "from 1e-14 to 1e-2"),
        ("tolerance = nan", "15:13", "from 1e-14 to 1e-2"),
        ("cells = -1", "17:9", "from 0 to 10000000"),
        ("compression = 10", "21:15", "from 0 to 9"),
        ("compression = -1", "21:15", "from 0 to 9"),
    ];
    for (text, place, wanted) in cases {
        wrong(text, place, &[wanted]);
    }
}

#[test]
fn unknown_names() {
    wrong(
        "run = [\"simulation\", \"pertubation\"]",
        "12:22",
        &["\"pertubation\"", "nearest valid method is `perturbation`", "harmonic_balance"],
    );
    wrong("fields = [\"margins\"]", "20:11", &["nearest valid field is `margin`"]);
    wrong("law = \"stribek\"", "3:7", &["law", "`stribeck`"]);
    wrong("run = []", "12:7", &["no method"]);
    wrong("run = [\"simulation\", \"simulation\"]", "12:22", &["twice"]);
    refused(
        line("run = [\"perturbation\"]").replace("\"verdict\"", "\"regime\""),
        &["bad.toml:20:10", "`regime` comes from the method `simulation`"],
    );
}

#[test]
fn unreadable_files() {
    refused("title = \"unclosed\n", &["bad.toml:1:", "not valid TOML"]);
    refused("[grid]\nc = 1\nc = 2\n", &["bad.toml:3:1", "not valid TOML", "duplicate"]);
    refused(b"# h\xc3\xa9\ntitle = \"\xff\"\n", &["bad.toml:2:10", "not UTF-8"]);
    let scratch = Scratch::new();
    scratch.run("run none.toml").refuses(&["none.toml: there is no such file", "help: "]);
    scratch.run("run .").refuses(&[".: this is a folder", "help: "]);
    assert!(scratch.names().is_empty());
}

#[test]
fn bad_overrides() {
    override_refused("grid.alpha=1.5", &["grid.alpha = 1.5", "between 0 and 1"]);
    override_refused("grid.alpha=[0.1, 0.1]", &["grid.alpha[1]", "appears twice"]);
    override_refused("grid.alfa=1", &["unknown key `alfa`", "`alpha`"]);
    override_refused("simulation.tolerance=tight", &["\"tight\"", "not a number"]);
    override_refused("grid.alpha.points=3", &["`alpha` is a list"]);
    override_refused("grid.gamma.points=0", &["must be from 1 to"]);
    override_refused("methods.run=[\"simulation\"", &["not valid TOML"]);
    override_refused("noequals", &["no `=`"]);
    override_refused("a..b=1", &["not a key path"]);
    override_refused("compression=4", &["belongs in [output]"]);
}

#[test]
fn errors_beside_an_override_are_those_of_the_file() {
    let scratch = Scratch::new();
    scratch.file("bad.toml", line("beta = -1"));
    let sets = ["run", "bad.toml", "--set", "grid.V=2", "--set", "grid.gamma.points=4"];
    scratch.run(&sets).refuses(&["bad.toml:7:8", "grid.beta = -1"]);
}

#[test]
fn overrides_rescue_a_bad_file() {
    let scratch = Scratch::new();
    scratch.file("bad.toml", line("beta = -1"));
    scratch.run("run bad.toml --dry-run --set grid.beta=0.25").ends_with(0);
}

#[test]
fn outputs_that_cannot_be_written() {
    wrong("path = \"\"", "19:8", &["empty"]);
    wrong("path = \"..\"", "19:8", &["names no file"]);
    wrong("path = \"a\\u0000b\"", "19:8", &["control characters"]);
    wrong("title = \"two\\nlines\"", "1:9", &["control characters"]);
    wrong("path = \"folder/\"", "19:8", &["names no file"]);
    refused(line("path = \"bad.toml\""), &["output.path bad.toml: this is what is read"]);
    refused(line("path = \"bad.toml/map.h5\""), &["bad.toml/map.h5: cannot write into the folder bad.toml"]);
    let scratch = Scratch::new();
    scratch.file("legal.toml", line("path = \"sub\""));
    std::fs::create_dir(scratch.path().join("sub")).unwrap();
    scratch.run("run legal.toml").refuses(&["legal.toml:19:8", "this is a folder"]);
}

#[test]
fn grids_larger_than_the_disk() {
    let million = "{ from = 0, to = 1, points = 1000000 }";
    let huge = format!(
        "[grid]\nepsilon = 0.1\nV = 1\nalpha = {million}\nbeta = {million}\ngamma = 1\nc = {million}\n"
    );
    refused(&huge, &["1,000,000,000,000,000,000 cells", "before compression", "is free", "fewer points"]);
    let uncountable = huge.replace("gamma = 1", &format!("gamma = {million}"));
    refused(uncountable, &["more cells than can be counted"]);
}

#[test]
fn planes_of_curves() {
    let planes = |planes: &str| format!("{LEGAL}[curves]\nplanes = {planes}\n");
    let cases: [(&str, &[&str]); 12] = [
        (
            "3",
            &[
                "bad.toml:23:10",
                "curves.planes = 3: this is a whole number, not a list of planes",
                "x = \"V\"",
            ],
        ),
        (
            "[[\"gamma\", \"c\"]]",
            &["bad.toml:23:11", "curves.planes[0] =", "this is a list, not a plane such as"],
        ),
        ("[{ x = \"gamma\" }]", &["bad.toml:23:11", "`y` is missing from curves.planes[0]"]),
        (
            "[{ x = \"gama\", y = \"c\" }]",
            &["curves.planes[0].x = \"gama\": unknown axis", "nearest valid axis is `gamma`"],
        ),
        ("[{ x = \"V\", y = \"c\" }]", &["curves.planes[0].x = \"V\": the axis V has one node"]),
        ("[{ x = \"c\", y = \"c\" }]", &["curves.planes[0].y = \"c\": both axes of the plane are the same"]),
        (
            "[{ x = \"gamma\", y = \"c\", z = 1 }]",
            &["unknown key `z` in curves.planes[0]", "valid are: x, y, at"],
        ),
        ("[{ x = \"gamma\", y = \"c\", at = { d = 1 } }]", &["unknown key `d` in curves.planes[0].at"]),
        ("[{ x = \"gamma\", y = \"c\", at = { c = 1 } }]", &["curves.planes[0].at", "extends along `c`"]),
        (
            "[{ x = \"gamma\", y = \"c\", at = { alpha = 0.6 } }]",
            &["bad.toml:23:50", "curves.planes[0].at.alpha = 0.6: the axis alpha goes from 0 to 0.5"],
        ),
        ("[{ x = \"gamma\", y = \"c\", at = { alpha = true } }]", &["this is a truth value, not a number"]),
        (
            "[{ x = \"gamma\", y = \"c\" }, { x = \"c\", y = \"gamma\" }]",
            &["curves.planes[1] =", "this plane is named twice"],
        ),
    ];
    for (value, parts) in cases {
        refused(planes(value), parts);
    }
    refused(
        format!("{LEGAL}[curves]\nplane = []\n"),
        &["bad.toml:23:1", "unknown key `plane` in [curves]", "`planes`"],
    );
    refused(format!("{LEGAL}[curves]\n"), &["`planes` is missing from [curves]"]);
    let law = "[friction]\nlaw = \"expression\"\nphi = \"1/(1 + error*u)\"\n[grid]\nepsilon = 0.1\nerror = [1.0, 2.0]\nV = [1.0, 2.0]\nc = [0.0, 1.0]\n";
    let planes = "[curves]\nplanes = [{ x = \"V\", y = \"c\" }]\n";
    refused(format!("{law}{planes}"), &["curves cannot be stored beside a parameter called `error`"]);
}

/// Of a machine the place of a plane may have a unit.
#[test]
fn planes_of_curves_of_a_machine() {
    let text = |force: &str| {
        format!(
            "[machine]\nmass = 2.0\nstiffness = 5e5\nnormal_force = {{ from = \"10 kN\", to = \"100 kN\", points = 4 }}\n\
             static_friction = 0.4\nkinetic_friction = 0.25\nstribeck_velocity = 0.05\nbelt_speed = [0.1, 0.2]\n\
             damping = [0.0, 50.0]\n[curves]\nplanes = [{{ x = \"belt_speed\", y = \"damping\", at = {{ normal_force = {force} }} }}]\n"
        )
    };
    let scratch = Scratch::new();
    for force in ["\"40 kN\"", "\"0.042 MN\"", "\"41000 N\"", "40000"] {
        scratch.file("pad.toml", text(force));
        let job = Job::load(&scratch.path().join("pad.toml"), &[]).unwrap();
        assert_eq!(job.plan.planes, [Plane::new(1, 2, vec![1, 0, 0])], "{force}");
    }
    let place = |value: &str| format!("bad.toml:11:68 & curves.planes[0].at.normal_force = {value}: ");
    for (force, problem) in [
        ("50", "the axis normal_force goes from 10000 N to 100000 N & a number without a unit is in N"),
        ("\"200 kN\"", "the axis normal_force goes from 10000 N to 100000 N"),
        ("\"50 mm\"", "mm is no unit of normal force & write it in N"),
        ("\"fifty\"", "this is text, not a number"),
    ] {
        let parts = format!("{}{problem}", place(force));
        refused(text(force), &parts.split(" & ").collect::<Vec<_>>());
    }
}

/// A name, a unit or a row may be a whole file by mistake: the message says where it is and how it begins.
#[test]
fn messages_quote_the_beginning_of_long_texts_only() {
    let scratch = Scratch::new();
    let long = "words and ".repeat(4_000);
    let of_pad = "[machine]\nmotion = \"translation\"\nmass = 2.0\nstiffness = 5e5\nnormal_force = 1000.0\n\
                  belt_speed = 0.1\ndamping = 50.0\n";
    let coefficients = format!(
        "[friction]\nlaw = \"exponential\"\n{of_pad}static_friction = 0.4\nkinetic_friction = 0.25\n\
         stribeck_velocity = 0.05\n"
    );
    scratch.file("machine.toml", &coefficients);
    let grid = "[grid]\nepsilon = 1\nV = 1\nc = 1\n[output]\npath = \"map.h5\"\n";
    let table = |header: &str, row: &str| {
        scratch.file("table.csv", format!("{header}\n0,1\n{row}\n1,0.5\n2,0.4\n"));
        scratch.file("rig.toml", format!("[friction]\nlaw = \"table\"\nfile = \"table.csv\"\n{of_pad}"));
        vec![vec!["machine", "rig.toml"]]
    };
    let config = |text: String| {
        scratch.file("job.toml", text);
        vec![vec!["run", "job.toml"]]
    };
    let rows = |header: &str, row: &str| {
        scratch.file("rows.csv", format!("{header}\n{row}\n"));
        vec![vec!["probe", "--machine", "machine.toml", "--points", "rows.csv", "--out", "out.csv"]]
    };
    let check = |commands: Vec<Vec<&str>>| {
        for arguments in commands {
            let run = scratch.run(&arguments).ends_with(2);
            assert!(run.err.len() < 2000, "{arguments:?}: {} characters: {:.500}", run.err.len(), run.err);
            assert!(run.err.contains("words and"), "{arguments:?}: {}", run.err);
        }
    };
    check(table(&format!("u [{long}],phi"), "0.5,0.7"));
    check(table("u,phi", &format!("0.5,{long}")));
    check(table("u,phi", &format!("{long},0.7")));
    check(rows(&format!("belt_speed [{long}]"), "0.1"));
    check(rows(&format!("belt_speed_{long}"), "0.1"));
    check(rows("belt_speed", &format!("\"{long}\"")));
    check(config(format!("[friction]\nlaw = \"{long}\"\n{grid}")));
    check(config(format!("[friction]\nlaw = \"expression\"\nphi = \"{long}\"\n{grid}")));
    let formula = "[friction]\nlaw = \"expression\"\nphi = \"exp(-u)\"\n";
    check(config(format!("{formula}{grid}[methods]\nrun = [\"{long}\"]\n")));
    check(config(format!("{grid}\"{long}\" = 3\n")));
    check(config(coefficients.replace("translation", &long)));
}

/// Of two values of one quantity neither wins silently.
#[test]
fn what_is_said_twice_is_refused() {
    let scratch = Scratch::new();
    scratch.run("init machine").ends_with(0);
    scratch.run("init grid").ends_with(0);
    let point = "probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2 --V 1 --c 0.5";
    let formula = "probe --phi mu+(1-mu)*exp(-u) --epsilon 0.1 --V 1 --c 0.5";
    for command in [
        &format!("{point} --set c=0.9"),
        &format!("{formula} --set mu=0.5 --set mu=0.6"),
        "probe --machine machine.toml --set belt_speed=0.1 --set belt_speed=1rpm",
        "machine machine.toml --set damping=1 --set damping=2",
        "machine machine.toml --set damping=1 --set machine.damping=2",
        "machine machine.toml --set mass=1 --set inertia=2",
        "run grid.toml --dry-run --set simulation.tolerance=1e-8 --set simulation.tolerance=1e-9",
        "run grid.toml --dry-run --set simulation.tolerance=1e-8 --set simulation={}",
    ] {
        scratch.run(command).refuses(&["twice"]);
    }
}
