//! Friction laws from configuration to map, report and figure, through the real binary.

use crate::command::{Says, Scratch};

const GRID: &str = "\
[grid]
epsilon = 1.0
mu = [0.3, 0.6]
vs = { from = 0.5, to = 2.0, points = 4 }
eta = 0.0
V = { from = 0.2, to = 1.0, points = 3 }
c = { from = 0.0, to = 0.6, points = 13 }
[audit]
cells = 100
[output]
path = \"map.h5\"
fields = [\"margin\", \"critical_c\", \"regime\", \"landing\"]
";

#[test]
fn every_law_makes_a_map_that_is_checked_drawn_and_reported() {
    let scratch = Scratch::new();
    scratch.file("pad.csv", "# measured\nu [m/s], mu\n0,0.40\n0.1,0.36\n0.5,0.31\n1,0.30\n4,0.33\n");
    let text = "[friction]\nlaw = \"expression\"\nphi = \"mu + (1 - mu)*exp(-u/vs) + eta*u\"\n";
    let table = "[friction]\nlaw = \"table\"\nfile = \"pad.csv\"\nstatic = 0.4\n";
    let table_grid: String = GRID
        .lines()
        .filter(|line| !["mu", "vs", "eta"].iter().any(|key| line.starts_with(key)))
        .fold(String::new(), |mut text, line| {
            text.push_str(line);
            text.push('\n');
            text
        });
    let few = "[methods]\nrun = [\"symmetric\", \"simulation\"]\n";
    let table_grid = format!("{few}{table_grid}");
    for (law, friction, grid) in [
        ("exponential", "[friction]\nlaw = \"exponential\"\n", GRID),
        ("lorentzian", "[friction]\nlaw = \"lorentzian\"\n", GRID),
        ("expression", text, GRID),
        ("table", table, table_grid.as_str()),
    ] {
        scratch.file("job.toml", format!("{friction}{grid}"));
        scratch.run("run job.toml --overwrite --threads 2").ends_with(0);
        scratch.run("check map.h5").ends_with(0);
        let x = if law == "table" { "V" } else { "vs" };
        let plot =
            ["plot", "map.h5", "--x", x, "--y", "c", "--variable", "regime", "--out", "s.svg", "--overwrite"];
        scratch.run(&plot).ends_with(0);
    }
    // A law without parameters and with a definition of many lines.
    scratch.run("report map.h5 --out report --data").ends_with(0);
    // Its orbits are expensive: the curve has fewer points, and each point has a number.
    let curve = std::fs::read_to_string(scratch.path().join("report/figures/critical-damping.csv")).unwrap();
    let (header, rows) = curve.split_once('\n').unwrap();
    let simulation = header.split(',').position(|name| name == "critical_c_simulation").unwrap();
    assert!(rows.lines().count() > 20, "{curve}");
    for row in rows.lines() {
        assert!(row.split(',').nth(simulation).is_some_and(|c| c.parse::<f64>().is_ok()), "{row}");
    }
}

#[test]
fn bad_laws_are_refused_with_their_place() {
    let scratch = Scratch::new();
    let refuse = |friction: &str, parts: &[&str]| {
        scratch.file("job.toml", format!("[friction]\n{friction}\n{GRID}"));
        scratch.run("run job.toml").refuses(parts);
    };
    let phi = |text: &str| format!("law = \"expression\"\nphi = \"{text}\"");
    refuse("law = \"exponentail\"", &["job.toml:2:7", "unknown law", "`exponential`"]);
    refuse("law = \"expression\"", &["`phi` is missing"]);
    refuse("law = \"lorentzian\"\nphi = \"1\"", &["job.toml:3:7", "has no phi"]);
    refuse("law = \"lorentzian\"\nstatic = 2", &["job.toml:3:10", "friction at rest is 1 already"]);
    refuse("law = \"table\"\nfile = \"none.csv\"", &["job.toml:3:8", "cannot be read"]);
    refuse(
        &phi("mu + (1 - mu)*exp(-u/vz)"),
        &["unknown symbol `vz`", "                         ^^", "[grid]"],
    );
    refuse(&phi("mu + (1 - mu)*epx(-u/vs)"), &["no function `epx`", "^^^"]);
    refuse(&phi("mu*eta + 0.5*exp(-u/vs)"), &["phi(0) is 0.5", "not 1"]);
    refuse(&phi("mu*eta + 1 - vs*u/(u - 1)"), &["vanishes at u = 1", "^^^^^^^"]);
    refuse(&phi("1 + mu*eta*vs*tanh(u)/u"), &["vanishes at u = 0"]);
    refuse(&phi("1 - vs*eta - mu*abs(u - 0.5)"), &["kink at u = 0.5"]);
    scratch.file("short.csv", "0,1\n0.5,0.9\n1,0.8\n");
    let no_axes = "[grid]\nepsilon = 1.0\nV = [0.2, 1.0]\nc = 0.1\n";
    scratch.file("job.toml", format!("[friction]\nlaw = \"table\"\nfile = \"short.csv\"\n{no_axes}"));
    scratch.run("run job.toml").refuses(&["job.toml:3:8", "end at slip speed 1", "up to 2"]);
    scratch.file("short.csv", "0,1\n0.5,x\n1,0.8\n");
    scratch.run("run job.toml").refuses(&["short.csv:2: `0.5,x` is not a pair"]);
    assert_eq!(scratch.names(), ["job.toml", "short.csv"]);
}

#[test]
fn a_map_of_another_table_is_not_resumed() {
    let scratch = Scratch::new();
    let grid = "[grid]\nepsilon = 1.0\nV = [0.2, 0.5]\nc = [0.0, 0.1]\n[output]\npath = \"map.h5\"\n";
    scratch.file("job.toml", format!("[friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n{grid}"));
    scratch.file("pad.csv", "0,1\n0.1,0.9\n0.5,0.78\n1,0.75\n4,0.82\n");
    scratch.run("run job.toml").ends_with(0);
    assert!(scratch.run("run job.toml --resume").ends_with(0).err.contains("is complete already"));
    // The configuration is the same, letter by letter.
    scratch.file("pad.csv", "0,1\n0.1,0.9\n0.5,0.8\n1,0.75\n4,0.82\n");
    let parts = ["map.h5 was begun as something else", "law_definition", "- 0.5,0.78", "+ 0.5,0.8"];
    scratch.run("run job.toml --resume").refuses(&parts);
}

#[test]
fn probe_asks_any_law() {
    let scratch = Scratch::new();
    let with = |law: &str| format!("probe --epsilon 1 --V 0.5 --c 0.1 {law}");
    let built_in = scratch.json(&with("--law exponential --mu 0.5 --vs 1 --eta 0"));
    let as_text = scratch.json(&with("--phi mu+(1-mu)*exp(-u/vs) --set mu=0.5 --set vs=1"));
    let with = |law: &str| scratch.run(&with(law));
    for method in ["instability", "bendixson", "symmetric", "harmonic_balance", "simulation"] {
        let of = |answer: &serde_json::Value| answer["methods"][method].clone();
        assert_eq!(of(&built_in)["verdict"], of(&as_text)["verdict"], "{method}");
        let [a, b] = [&built_in, &as_text].map(|answer| of(answer)["margin"].as_f64().unwrap());
        assert!((a - b).abs() <= 1e-12, "{method}: {a} {b}");
    }
    assert_eq!(built_in["methods"]["perturbation"]["verdict"], "undecided");
    let reason = built_in["methods"]["perturbation"]["reason"].as_str().unwrap();
    reason.says(&["does not depend on eps"]);
    with("--law exponential --mu 0.5 --vs 0 --eta 0").refuses(&["--vs 0", "greater than 0"]);
    with("--law exponential --mu 0.5 --vs 1").refuses(&["--eta"]);
    with("--phi mu+(1-mu)*exp(-u/w) --set mu=0.5").refuses(&["also needs --set w="]);
    with("--phi 1-0.1*u/(u-0.7)").refuses(&["vanishes at u = 0.7", "^^^^^^^"]);
    with("--law expression").refuses(&["needs --phi"]);
}

/// At large slip speeds this law gains energy without bound: orbits that reach them are left out.
#[test]
fn cycles_are_told_where_friction_pushes_farther_out() {
    let scratch = Scratch::new();
    let law = "1-1.4*u*exp(-u/1.5)+0.2*sin(7.4*u)-0.16*u";
    let cycles = &scratch.json(&format!("probe --phi {law} --epsilon 1 --V 1.67 --c 0.09"))["cycles"];
    let stable: Vec<bool> =
        cycles["slip"].as_array().unwrap().iter().map(|cycle| cycle["stable"].as_bool().unwrap()).collect();
    assert_eq!(stable, [false, true, false], "{cycles}");
    assert!(cycles["stick_slip"].is_object() && cycles["crossing"] == serde_json::json!([]), "{cycles}");
    let reason = cycles["reason"].as_str().unwrap();
    assert!(reason.starts_with("friction is negative from u = 1."), "{reason}");
}

#[test]
fn the_number_of_slip_cycles_is_proved_for_formulas_alone() {
    let scratch = Scratch::new();
    let point = "probe --epsilon 1 --V 0.58 --c 0.62";
    let lorentzian = format!("{point} --law lorentzian --mu 0 --vs 1 --eta 0");
    let cycles = &scratch.json(&lorentzian)["cycles"];
    assert_eq!(cycles["slip"][0]["stable"], true, "{cycles}");
    let count = &cycles["slip_count"];
    assert_eq!((&count["proved"], &count["at_least"], &count["at_most"]), (&1.into(), &1.into(), &1.into()));
    // A measured law has no formula for proofs.
    let data: String =
        (0..60).map(|i| 0.05 * f64::from(i)).map(|u| format!("{u},{}\n", 1.0 / (1.0 + u * u))).collect();
    scratch.file("data.csv", data);
    let cycles = &scratch.json(&format!("{point} --table data.csv"))["cycles"];
    let open = serde_json::json!([{ "from": 0.0, "to": 0.58 }]);
    assert!(cycles["slip_count"]["proved"].is_null() && cycles["slip_count"]["open"] == open, "{cycles}");
    assert_eq!(cycles["slip"].as_array().unwrap().len(), 1, "{cycles}");
}

/// The paper's test applies to a law without eps if the user states how to read it; all outputs repeat that.
#[test]
fn a_law_without_eps_is_read_as_small_on_request() {
    let scratch = Scratch::new();
    let friction = "[friction]\nlaw = \"exponential\"\n";
    scratch.file("plain.toml", format!("{friction}{GRID}"));
    let few = "[methods]\nrun = [\"perturbation\", \"simulation\"]\n";
    let small = format!("{friction}small = \"eps\"\n{few}{}", GRID.replace("map.h5", "small.h5"));
    scratch.file("small.toml", small);
    for job in ["plain.toml", "small.toml"] {
        scratch.run(&["run", job]).ends_with(0);
    }
    scratch.run("check small.h5").ends_with(0);
    scratch.run("report small.h5 --out report").ends_with(0);
    let report = scratch.read("report/report.html");
    report.says(&["phi read as 1 + eps F(u)"]);
    let point = "probe --law exponential --epsilon 0.1 --mu 0.6 --vs 1 --eta 0 --V 0.5 --c 1";
    let probe = |more: &str| scratch.run(&format!("{point} {more}")).ends_with(0).out;
    let line = |text: &str| text.lines().find(|line| line.starts_with("  perturbation ")).unwrap().to_owned();
    let (plain, small) = (line(&probe("")), line(&probe("--small eps")));
    assert!(plain.contains("undecided") && !plain.contains("read as"), "{plain}");
    small.says(&["present", "phi read as 1 + eps F(u)"]);
    scratch.file("wrong.toml", format!("{friction}small = \"mu\"\n{GRID}"));
    scratch.run("run wrong.toml").refuses(&["wrong.toml:3:9", "eps only", "small = \"eps\""]);
}

#[test]
fn standard_errors_of_a_table_are_read_whole_or_refused() {
    let scratch = Scratch::new();
    let grid = "[grid]\nepsilon = 1\nV = 0.2\nc = 0.1\n";
    scratch.file("job.toml", format!("[friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n{grid}"));
    let probe = |rows: &str| {
        scratch.file("pad.csv", rows);
        scratch.run("run job.toml --dry-run")
    };
    probe("u,mu,sigma\n0,1,0.01\n0.1,0.9,0.01\n0.5,0.8,0.02\n1,0.8,0.01\n").ends_with(0);
    probe("u,mu,remark\n0,1,at rest\n0.1,0.9,\n0.5,0.8,warm\n1,0.8,\n").ends_with(0);
    for header in ["u,mu,sd", "u,mu,std [-]", "u,mu,mu_std_dev", "u,mu,Standard deviation"] {
        probe(&format!("# a rig\n{header}\n0,1,0.01\n0.1,0.9,0.01\n0.5,0.8,0.02\n1,0.8,0.01\n")).refuses(&[
            "pad.csv:2",
            "a standard deviation",
            "square root of the number of readings",
        ]);
    }
    for header in ["u,mu,std_err", "u,mu,SEM", "u,mu,se", "u,mu,standard error", "u,mu,sd of the mean"] {
        probe(&format!("{header}\n0,1,0.01\n0.1,0.9,0.01\n0.5,0.8,0.02\n1,0.8,0.01\n")).ends_with(0);
    }
}

/// Rows of one slip speed are the table of their means, whose standard errors are those of their scatter.
#[test]
fn rows_of_one_slip_speed_are_averaged() {
    let scratch = Scratch::new();
    let probe = |rows: &str| {
        scratch.file("pad.csv", rows);
        scratch.run("probe --table pad.csv --static 1 --epsilon 1 --V 0.2 --c 0.1 --json")
    };
    // Squares about the means: 2 (0.01)^2 at 0.1 and 2 (0.02)^2 at 0.5; five rows more than speeds.
    let repeated = "u,mu\n0,1\n0,1\n0.1,0.91\n0.1,0.9\n0.1,0.89\n0.5,0.82\n0.5,0.78\n0.5,0.8\n1,0.8\n";
    let sd = (1e-3_f64 / 5.0).sqrt();
    let rows: String = [(0.0, 1.0, 2.0), (0.1, 0.9, 3.0), (0.5, 0.8, 3.0), (1.0, 0.8, 1.0_f64)]
        .map(|(u, mu, count)| format!("{u},{mu},{}\n", sd / count.sqrt()))
        .concat();
    let means = format!("u,mu,se\n{rows}");
    let [one, other] = [repeated, &means].map(|rows| {
        let answer = probe(rows).ends_with(0).json();
        let of = &answer["sensitivity"]["standard_error"]["value"];
        of.as_f64().unwrap_or_else(|| panic!("{answer}"))
    });
    // Means are rounded to the last digit.
    assert!(one > 0.0 && (one / other - 1.0).abs() < 1e-9, "{one} {other}");
}

/// What is unusual in a table is told in one line, and the answer is that of the plain table.
#[test]
fn tables_as_spreadsheets_write_them_are_read() {
    let scratch = Scratch::new();
    let probe = |bytes: &[u8]| {
        scratch.file("pad.csv", bytes);
        scratch.run("probe --table pad.csv --epsilon 1 --V 0.2 --c 0.1").ends_with(0)
    };
    let plain = probe(b"u,mu\n0,1\n0.1,0.9\n0.5,0.8\n1,0.8\n");
    let odd = probe(b"Rig 7\r\nu;mu;n\r\n0,5;0,8;3\r\n0;1;3\r\n0,1;0,9;3\r\n1;0,8;3\r\n");
    assert!(odd.out == plain.out && plain.err.is_empty(), "{}", plain.err);
    let told =
        "read: pad.csv: separated by semicolons; decimal commas; `n` not used; rows sorted by slip speed\n";
    assert_eq!(odd.err, told);
}

/// The friction oscillates by 6e-6, and the orbit passes two hundred periods in a turn: with a tolerance of
/// 1e-8 the direct engine steps over them, and is wrong by 26 times its stated error.
#[test]
fn audits_take_smaller_steps_before_they_contradict() {
    let scratch = Scratch::new();
    let map = "[friction]
law = \"expression\"
phi = \"1 - 0.46985804697157035*tanh(u/0.4879903622377221) + 6.162828590613456e-6*sin(2.1901038980749328*u)\"
[grid]
epsilon = 0.1343147215785036
V = 282.6466988754345
c = 0.0003509353964177821
[simulation]
tolerance = 1e-8
[output]
path = \"map.h5\"
";
    scratch.file("map.toml", map);
    let audit = &scratch.json("run map.toml --quiet")["audit"];
    assert_eq!((&audit["checked"], &audit["agreed"]), (&1.into(), &1.into()), "{audit}");
}
