//! What a report says where answers are unknown or uncertain.

use crate::command::Scratch;

/// A table that ends before the orbits of the fastest belts do.
fn early() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("pad.csv", "0,0.43\n0.1,0.36\n0.3,0.31\n0.6,0.28\n1.2,0.27\n");
    scratch.file(
        "pad.toml",
        "[machine]\nmass = 2\nstiffness = 5e5\nnormal_force = 1000\n\
         belt_speed = { from = 0.05, to = 0.599, points = 12 }\ndamping = { from = 0, to = 500, points = 11 }\n\
         [friction]\nlaw = \"table\"\nfile = \"pad.csv\"\n[methods]\nrun = [\"symmetric\", \"simulation\"]\n\
         [output]\npath = \"pad.h5\"\nfields = [\"verdict\", \"regime\"]\n",
    );
    scratch
}

#[test]
fn cells_without_an_answer_are_drawn_named_and_counted() {
    let scratch = early();
    let run = scratch.run(&["run", "pad.toml", "--quiet"]);
    assert!(run.out.contains("verdicts failed"), "{}", run.out);
    scratch.run(&["report", "pad.h5", "--out", "report", "--quiet"]).ends_with(0);
    let page = scratch.read("report/report.html");
    let failed = scratch.read("report/tables/failures.csv");
    let count = |what: &str| {
        let row = failed.lines().find(|line| line.starts_with(what));
        row.unwrap_or_else(|| panic!("{what}: {failed}")).rsplit(',').next().unwrap().to_owned()
    };
    let [cells, regimes] = [count("simulation: cells failed"), count("cells whose regime")];
    // What the simulation leaves unknown agrees with nothing.
    let agreement = scratch.read("report/tables/agreement.csv");
    let rows = crate::machine::rows(&agreement);
    let of = |method: &str| rows.iter().find(|row| row["method"] == method).unwrap();
    assert_eq!([&of("simulation")["failed"], &of("symmetric")["not_compared"]], [&cells; 2], "{agreement}");
    // Two methods are drawn over 132 cells, and which decides over as many.
    for words in [
        format!("Failed, in black: {cells} of the 264 verdicts drawn"),
        format!("Failed, in black: {cells} of the 132 cells drawn"),
    ] {
        assert!(page.contains(&words), "no {words} in\n{page}");
    }
    let figure = |name: &str| scratch.read(&format!("report/figures/{name}.svg"));
    let deciders = figure("deciders");
    assert!(deciders.contains(">failed<"), "a legend");
    // The plain blue of cycles is no colour of a test.
    let plain = "fill=\"#0072b2\"";
    assert!(figure("slice-belt_speed-damping").contains(plain) && !deciders.contains(plain));
    let plot = [
        "plot",
        "pad.h5",
        "--x",
        "belt_speed",
        "--y",
        "damping",
        "--variable",
        "regime",
        "--out",
        "regime.svg",
    ];
    scratch.run(&plot).ends_with(0);
    assert!(
        scratch.read("regime.svg").contains(&format!("Failed, in black: {regimes} of the 132 cells drawn"))
    );
}

#[test]
fn the_probabilities_of_a_map_are_in_its_report() {
    let scratch = early();
    let uncertain = scratch.read("pad.toml").replace("mass = 2", "mass = { value = 2, sd = 0.2 }");
    scratch.file("pad.toml", uncertain);
    scratch.run(&["run", "pad.toml", "--quiet", "--set", "machine.belt_speed=[0.1, 0.2]"]).ends_with(0);
    scratch.run(&["report", "pad.h5", "--out", "report", "--quiet"]).ends_with(0);
    let page = scratch.read("report/report.html");
    assert!(page.contains(
        "<dt>probability that it may stick-slip, by the uncertain quantities</dt><dd>0 to 100 % over "
    ));
    assert!(page.contains("<figure id=\"figure-probability\">"), "{page}");
    assert!(scratch.read("report/figures/probability.svg").contains("probability that it may stick-slip"));
}
