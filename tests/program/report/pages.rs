//! Figures and documents: degenerate maps, failed cells, hostile texts, and the command line.

use super::{SMALL, gather, plan, store_map};
use crate::command::{PROBE, Scratch};
use slipmap::map::Field;
use slipmap::report::figure::plot::At;
use slipmap::report::figure::{Plot, Width};
use slipmap::report::{View, figure, tables};
use slipmap::store::MapFile;
use slipmap::store::Pick::Node;

/// Asserts that a text is well-formed XML with readable words.
fn check_svg(svg: &str) {
    roxmltree::Document::parse(svg).unwrap();
    assert!(svg.contains("<text") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(!svg.contains("href") && !svg.contains("<script"), "nothing from elsewhere");
}

/// A description of a degenerate map, its axes and its methods.
type Case<'a> = (&'a str, [&'a [f64]; 6], &'a [&'a str]);

#[test]
fn degenerate_maps_have_reports() {
    let cases: [Case; 7] = [
        ("one cell", [&[0.1], &[0.3], &[0.1], &[2.0], &[1.0], &[0.5]], &["perturbation", "simulation"]),
        (
            "one eps",
            [&[0.1], &[0.0, 0.5], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 0.5, 1.0]],
            &["symmetric", "simulation"],
        ),
        (
            "one c",
            [&[0.1, 0.2], &[0.0, 0.5], &[0.1], &[1.0, 2.0], &[1.0], &[0.0]],
            &["symmetric", "simulation"],
        ),
        ("no simulation", [&[0.1], &[0.0, 0.5], &[0.1], &[1.0], &[1.0], &[0.0, 1.0]], &["instability"]),
        (
            "no cycles",
            [&[0.1, 0.3], &[1.0], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 1.0]],
            &["bendixson", "simulation"],
        ),
        (
            "decides nothing",
            [&[0.1], &[0.9], &[0.5], &[1.0, 2.0], &[1.0, 2.0], &[1.0, 2.0]],
            &["instability", "simulation"],
        ),
        (
            "eps alone",
            [&[0.1, 0.2, 0.3], &[0.1], &[0.1], &[1.0], &[1.0], &[0.1]],
            &["harmonic_balance", "simulation"],
        ),
    ];
    for (what, nodes, methods) in cases {
        let folder = tempfile::tempdir().unwrap();
        let map = store_map(folder.path(), &plan(nodes, methods, &[Field::Verdict, Field::Regime]), what);
        let report = gather(&map);
        let widths = [Width::OneColumn, Width::TwoColumns].into_iter();
        for figure in widths.flat_map(|width| figure::all(&View::new(&map), &report, width).unwrap()) {
            let height = figure.scene.height;
            // With its caption on a page of A4.
            assert!(height > 50.0 && height < 660.0, "{what}: {} is {height} high", figure.name);
            check_svg(&figure.scene.svg(&figure.name, &figure.caption));
        }
        for table in tables::all(&View::new(&map), &report) {
            assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{what}: {}", table.name);
            for text in [table.latex(), table.html(), table.csv()] {
                assert!(!text.contains("NaN") && !text.contains("inf"), "{what}: {text}");
            }
        }
        let volume = report.verdicts.volumes[0][0];
        assert!(volume.claimed >= 0.0 && volume.error >= 0.0, "{what}: {volume:?}");
    }
}

/// A plot over a plane.
fn over_plane<'a>(x: &'a str, y: &'a str, at: &'a [At], variables: &'a [String]) -> Plot<'a> {
    Plot { x, y: Some(y), at, variables, panels: None, curves: false, marks: &[], width: Width::OneColumn }
}

#[test]
fn plots_report_fixed_axes_and_refuse_unknown_names() {
    let view = View::new(&SMALL);
    let at = [("V".to_owned(), vec![1.6]), ("epsilon".to_owned(), vec![0.06])];
    let variables: Vec<String> = view.map.variables().map(str::to_owned).collect();
    for variable in &variables {
        for (x, y) in [("gamma", "alpha"), ("alpha", "gamma")] {
            let plotted =
                figure::plot(&view, &over_plane(x, y, &at, std::slice::from_ref(variable))).unwrap();
            check_svg(&plotted.scene.svg("plot", &plotted.caption));
            let held = |axis: &str| plotted.held.iter().find(|held| held.axis == axis).map(|held| held.used);
            assert_eq!((held("V"), held("epsilon")), (Some(2.0), Some(0.05)));
            assert_eq!(held("c").is_none(), variable.starts_with("critical_c_"));
            assert!(plotted.caption.plain().contains("V = 2"), "{}", plotted.caption.plain());
            assert_eq!(plotted.data.rows(), 9, "a row for each cell");
        }
    }
    let refused = |x: &str, y: &str, at: &[At], variable: Option<&str>| {
        let variables: Vec<String> = variable.iter().map(|name| (*name).to_owned()).collect();
        figure::plot(&view, &over_plane(x, y, at, &variables)).unwrap_err().to_string()
    };
    let at = |axis: &str, value: f64| [(axis.to_owned(), vec![value])];
    assert!(refused("gama", "c", &[], None).contains("the nearest is `gamma`"));
    assert!(refused("gamma", "c", &at("bet", 1.0), None).contains("`beta`"));
    assert!(refused("gamma", "c", &[], Some("verdict_simulatoin")).contains("`verdict_simulation`"));
    assert!(refused("c", "c", &[], None).contains("different axes"));
    assert!(refused("gamma", "c", &at("c", 1.0), None).contains("shown"));
    assert!(refused("gamma", "c", &[], Some("critical_c_symmetric")).contains("does not vary along `c`"));
    assert!(refused("gamma", "c", &at("V", f64::NAN), None).contains("finite"));
    assert!(refused("gamma", "c", &at("V", 99.0), None).contains("from 0.5 to 2"));
    let several = [("V".to_owned(), vec![1.0, 2.0])];
    assert!(refused("gamma", "c", &several, None).contains("several values"));
    let folder = tempfile::tempdir().unwrap();
    let bare = super::small(folder.path(), &["symmetric", "simulation"], &[Field::Verdict]);
    let variables = ["margin_simulation".to_owned()];
    let why =
        figure::plot(&View::new(&bare), &over_plane("gamma", "c", &[], &variables)).unwrap_err().to_string();
    assert!(why.contains("add \"margin\" to output.fields"), "{why}");
}

#[test]
fn an_axis_of_one_node_is_not_drawn_as_an_area() {
    // beta has one node: a line over the other axis is drawn, with a note.
    let view = View::new(&SMALL);
    let variables = ["critical_c_simulation".to_owned()];
    for (x, y) in [("beta", "gamma"), ("gamma", "beta")] {
        let plotted = figure::plot(&view, &over_plane(x, y, &[], &variables)).unwrap();
        assert_eq!(plotted.notes, ["beta has one node: drawn over gamma alone"]);
        assert_eq!(plotted.data.rows(), 3);
        assert!(!plotted.scene.svg("plot", &plotted.caption).contains("crispEdges"), "no area");
    }
    let curves = Plot { curves: true, ..over_plane("gamma", "beta", &[], &[]) };
    assert!(figure::plot(&view, &curves).unwrap_err().to_string().contains("one node"));
    // A report of a map with one gamma and one V: rows of cells over c, no area over either.
    let folder = tempfile::tempdir().unwrap();
    let nodes: [&[f64]; 6] = [&[0.1], &[0.3], &[0.1], &[2.0], &[1.0], &[0.0, 0.5, 1.0]];
    let map = store_map(folder.path(), &plan(nodes, &["symmetric", "simulation"], &[Field::Verdict]), "one");
    let figures = figure::all(&View::new(&map), &gather(&map), Width::OneColumn).unwrap();
    let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    assert!(
        names.contains(&"slice-c") && !names.iter().any(|name| name.starts_with("slice-gamma")),
        "{names:?}"
    );
    assert!(!names.contains(&"deciders"), "{names:?}");
    // Two gammas are two rows for each method: an area would show what lies between them.
    let nodes: [&[f64]; 6] = [&[0.1], &[0.3], &[0.1], &[2.0, 3.0], &[1.0], &[0.0, 0.5, 1.0]];
    let folder = tempfile::tempdir().unwrap();
    let map = store_map(folder.path(), &plan(nodes, &["symmetric", "simulation"], &[Field::Verdict]), "two");
    let view = View::new(&map);
    let figures = figure::all(&view, &gather(&map), Width::OneColumn).unwrap();
    let slices: Vec<_> = figures.iter().filter(|figure| figure.name.starts_with("slice")).collect();
    let [rows] = slices[..] else { panic!("{} slices", slices.len()) };
    let drawn = rows.scene.svg("rows", &rows.caption);
    assert!(
        rows.name == "slice-c" && drawn.contains("<tspan>2</tspan>") && drawn.contains("<tspan>3</tspan>"),
        "{}",
        rows.name
    );
    assert!(figures.iter().all(|figure| figure.name != "deciders"));
    let area = figure::plot(&view, &over_plane("gamma", "c", &[], &[])).unwrap();
    assert!(area.notes[0].contains("gamma has 2 nodes") && area.notes[0].contains("--x c --at gamma=2,3"));
}

#[test]
fn methods_that_decide_nothing_are_named_and_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    // Far above the damping at which the equilibrium becomes stable.
    let nodes: [&[f64]; 6] = [&[0.1], &[0.3], &[0.1], &[1.0, 2.0, 3.0], &[1.0], &[5.0, 6.0, 7.0]];
    let methods = ["instability", "symmetric", "simulation"];
    let map = store_map(folder.path(), &plan(nodes, &methods, &[Field::Verdict]), "stable");
    let figures = figure::all(&View::new(&map), &gather(&map), Width::OneColumn).unwrap();
    let slice = figures.iter().find(|figure| figure.name.starts_with("slice-gamma-c")).unwrap();
    let caption = slice.caption.plain();
    assert!(caption.contains("undecided in every cell of this plane: instability."), "{caption}");
    let drawn = slice.scene.svg("slice", &slice.caption);
    assert!(drawn.contains("undecided everywhere") && drawn.contains("(b) ") && !drawn.contains("(c) "));
}

#[test]
fn one_axis_plots_draw_what_the_map_stores() {
    let view = View::new(&SMALL);
    let variables = ["critical_c_simulation".to_owned(), "critical_c_symmetric".to_owned()];
    let at = [("V".to_owned(), vec![0.5, 2.0]), ("epsilon".to_owned(), vec![0.05])];
    let panels = ("alpha".to_owned(), vec![0.0, 0.3]);
    let plot = Plot {
        x: "gamma",
        y: None,
        at: &at,
        variables: &variables,
        panels: Some(&panels),
        curves: false,
        marks: &[],
        width: Width::TwoColumns,
    };
    let plotted = figure::plot(&view, &plot).unwrap();
    let svg = plotted.scene.svg("plot", &plotted.caption);
    check_svg(&svg);
    // Critical dampings of all methods share a panel.
    assert!(svg.contains(">(b) <") && !svg.contains(">(c) <"), "one panel for each alpha");
    let csv = plotted.data.csv();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<std::collections::HashMap<String, String>> =
        reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2 * 2 * 2 * 3, "panels, curves, variables, nodes");
    for row in rows {
        let number = |key: &str| row[key].parse::<f64>().unwrap();
        let node = |axis: usize, name: &str| Node(view.map.grid().axes()[axis].nearest(number(name)));
        let picks = [Node(0), node(1, "alpha"), Node(0), node(3, "gamma"), node(4, "V")];
        let is_stored = |text: &str, variable: &str| {
            let stored = view.map.real_slice(variable, &picks).unwrap();
            let stored = stored.iter().next().copied().unwrap();
            match text {
                "" => assert!(stored.is_nan() || stored.is_infinite()),
                value => assert_eq!(value.parse::<f64>().unwrap(), stored),
            }
        };
        is_stored(&row["value"], &row["variable"]);
        // The critical dampings of the test are exact.
        match row["variable"].as_str() {
            "critical_c_simulation" => is_stored(&row["error"], "critical_c_error_simulation"),
            _ => assert_eq!(row["error"], ""),
        }
    }
    assert!(plotted.notes.is_empty(), "{:?}", plotted.notes);
    // A value that is not a node is replaced by the nearest node, with a note.
    let between = ("alpha".to_owned(), vec![0.01, 0.3]);
    let over_axis = Plot { panels: Some(&between), ..plot.clone() };
    let over_plane = Plot { y: Some("V"), at: &at[1..], variables: &variables[..1], ..over_axis.clone() };
    for plot in [over_axis, over_plane] {
        assert_eq!(figure::plot(&view, &plot).unwrap().notes, ["alpha = 0: the node nearest to 0.01"]);
    }
    let both = ["critical_c_simulation".to_owned(), "verdict_simulation".to_owned()];
    let mixed = Plot { variables: &both, panels: None, ..plot.clone() };
    assert!(figure::plot(&view, &mixed).unwrap_err().to_string().contains("draw them in two"));
    let verdicts = ["verdict_simulation".to_owned(), "regime".to_owned()];
    let strips = figure::plot(&view, &Plot { variables: &verdicts, panels: None, ..plot }).unwrap();
    assert!(strips.data.csv().contains("stick_slip"));
}

#[test]
fn data_of_areas_have_the_errors_of_critical_dampings() {
    let view = View::new(&SMALL);
    let header = |variable: &str| {
        let plotted = figure::plot(&view, &over_plane("gamma", "V", &[], &[variable.to_owned()])).unwrap();
        plotted.data.csv().lines().next().unwrap().to_owned()
    };
    assert_eq!(header("critical_c_simulation"), "gamma,V,critical_c_simulation,critical_c_error_simulation");
    assert_eq!(header("critical_c_symmetric"), "gamma,V,critical_c_symmetric");
    assert_eq!(header("critical_c_error_simulation"), "gamma,V,critical_c_error_simulation");
}

/// On a fast belt orbits of this law run away to no cycle, and some are carried beyond the stick segment again
/// and again: the legend says what all of them do.
#[test]
fn legends_name_orbits_that_cross_for_ever() {
    let scratch = Scratch::new();
    scratch.file(
        "map.toml",
        "[friction]\nlaw = \"expression\"\nphi = \"1-0.6*u\"\n[grid]\nepsilon = 1.0\nV = [0.5, 1.0, 1.5]\n\
         c = [0.0, 0.3, 0.7]\n[output]\npath = \"map.h5\"\nfields = [\"verdict\", \"regime\"]\n",
    );
    scratch.run(&["run", "map.toml", "--quiet"]).ends_with(0);
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let plotted = figure::plot(&View::new(&map), &over_plane("V", "c", &[], &["regime".to_owned()])).unwrap();
    let drawn = plotted.scene.svg("plot", &plotted.caption);
    assert!(drawn.contains("crossing for ever"), "{}", plotted.data.csv());
    assert!(!drawn.contains("crossing cycle"), "{drawn}");
}

#[test]
fn the_commands_write_everything_or_nothing() {
    let scratch = Scratch::new();
    drop(store_map(
        scratch.path(),
        &plan(
            [&[0.1], &[0.3], &[0.1], &[1.0, 2.0, 3.0], &[1.0], &[0.0, 0.5, 1.0]],
            &["symmetric", "simulation"],
            &[Field::Verdict],
        ),
        "Commands",
    ));
    let run = scratch.run(&["report", "map.h5"]).ends_with(0);
    assert_eq!(run.out.trim(), "map-report/report.html");
    assert_eq!(run.err, "");
    assert_eq!(scratch.names(), ["map-report", "map.h5"]);
    let made = |folder: &str, ending: &str| {
        let entries = std::fs::read_dir(scratch.path().join("map-report").join(folder)).unwrap();
        entries.filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|e| e == ending)).count()
    };
    assert_eq!(made("tables", "tex"), made("tables", "csv"));
    assert!(made("figures", "svg") >= 4);
    assert_eq!(
        (made("figures", "svg"), made("figures", "svg")),
        (made("figures", "pdf"), made("figures", "png"))
    );
    // The LaTeX document includes every table and every figure.
    let document = scratch.read("map-report/report.tex");
    // Tables without their ending, figures with it.
    let included = |command: &str, ending: &str| {
        let names = document.split(command).skip(1).filter_map(|rest| rest.split('}').next());
        names.filter(|name| scratch.path().join(format!("map-report/{name}{ending}")).is_file()).count()
    };
    assert_eq!(included("\\input{", ".tex"), made("tables", "tex"));
    assert_eq!(included("\\includegraphics{", ""), made("figures", "pdf"));
    scratch.run(&["report", "map.h5"]).refuses(&["map-report", "exists already", "--overwrite"]);
    scratch.file("map-report/mine.txt", "kept");
    scratch.run(&["report", "map.h5", "--overwrite"]).ends_with(0);
    assert_eq!(scratch.read("map-report/mine.txt"), "kept");
    scratch.run(&["report", "nothing.h5"]).refuses(&["nothing.h5"]);
    scratch.file("text.h5", "no map");
    scratch.run(&["report", "text.h5"]).refuses(&["not a map", "slipmap run"]);

    let plot = |rest: &[&str]| scratch.run(&[&["plot", "map.h5", "--x", "gamma", "--y", "c"], rest].concat());
    let rows = ["plot", "map.h5", "--x", "c", "--at", "gamma=2.2", "--out", "rows.svg"];
    let run = scratch.run(&rows).ends_with(0);
    let told = "gamma = 2 (the node nearest to 2.2, 0.2 away; nothing between the nodes is stored)";
    assert!(run.err.contains(told), "{}", run.err);
    let run = plot(&["--out", "slice.svg"]).ends_with(0);
    plot(&["--out", "far.svg", "--at", "alpha=0.5"]).refuses(&[
        "`alpha`",
        "0.3 alone",
        "cannot be held at 0.5",
    ]);
    assert!(run.err.contains("alpha = 0.3\n"), "an axis of one node has no middle: {}", run.err);
    assert!(scratch.read("slice.svg").contains("<text"), "text stays text");
    plot(&["--out", "slice.svg"]).refuses(&["slice.svg", "--overwrite"]);
    plot(&["--out", "slice.png", "--width", "two-columns"]).ends_with(0);
    plot(&["--out", "slice.jpg"]).refuses(&[".svg, .pdf or .png"]);
    plot(&["--out", "a.svg", "--at", "V"]).refuses(&["gamma=2.0"]);
    plot(&["--out", "/proc/z.svg"]).refuses(&["/proc/z.svg: cannot write into the folder /proc", "choose"]);
    plot(&["--out", "nodir/a.svg"]).refuses(&["nodir/a.svg: there is no folder nodir"]);
    plot(&["--out", "a.svg", "--variable", "verdict_symetric"]).refuses(&["`verdict_symmetric`"]);
    scratch.run(&["plot", "map.h5", "--x", "gamm", "--y", "c", "--out", "a.svg"]).refuses(&["`gamma`"]);
    assert!(
        !scratch.names().iter().any(|name| name.starts_with('.') || name == "a.svg"),
        "{:?}",
        scratch.names()
    );

    scratch.run(&[&PROBE[..], &["--figure", "point.svg"]].concat()).ends_with(0);
    let svg = scratch.read("point.svg");
    assert!(svg.contains("stick segment") && svg.contains("landing"), "{svg}");
    scratch.run(&[&PROBE[..], &["--figure", "point.svg"]].concat()).refuses(&[
        "--figure point.svg",
        "choose another name",
        "--overwrite",
    ]);
}
