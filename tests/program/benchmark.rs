//! The work-precision study: its reference compared with the tables of `tests/data`, which come from an
//! integration in other variables, and its results.

use std::path::Path;
use std::sync::LazyLock;

use crate::command::{Says, Scratch};
use slipmap::column::Verdict;
use slipmap::config::StudySettings;
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::map::Grid;
use slipmap::report::figure::Width;
use slipmap::report::figure::work_precision::chart;
use slipmap::report::work_precision::{add_peers, write_study};
use slipmap::store::fingerprint;
use slipmap::study::benchmark::double_double::Double2;
use slipmap::study::benchmark::reference::{Exact, reference};
use slipmap::study::benchmark::{Contestant, ContestantKind, Errors, Labels, contestants};
use slipmap::study::benchmark::{Row, Study};
use slipmap::witness;
use slipmap_numbers::random::Random;

/// Rows of a table as texts, by the names of the columns.
fn rows(name: &str) -> (csv::StringRecord, Vec<csv::StringRecord>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    (reader.headers().unwrap().clone(), reader.records().map(Result::unwrap).collect())
}

/// A decimal such as `-1.234e-05` with up to 25 digits, to all of them.
fn decimal(text: &str) -> Double2 {
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let (head, tail) = digits.split_at(13);
    let whole = Double2::from(head.parse::<f64>().unwrap()) * 10.0_f64.powi(tail.len() as i32)
        + Double2::from(tail.parse::<f64>().unwrap());
    let exponent = exponent.parse::<i32>().unwrap() - (digits.len() as i32 - 1);
    let value =
        (0..exponent.abs()).fold(whole, |value, _| if exponent < 0 { value / 10.0 } else { value * 10.0 });
    if mantissa.starts_with('-') { -value } else { value }
}

#[track_caller]
fn assert_agrees(found: &Exact, text: &str) {
    let expected = decimal(text);
    let apart = (found.value - expected).value().abs();
    // The table's last digit, and the rounding of reading it: a chain of at most some 40 operations.
    let last = 1e-24 * expected.value().abs();
    assert!(apart <= found.error + last, "{apart:e} from {text}, {found:?}");
}

#[test]
fn the_reference_has_more_than_twenty_digits() {
    let point = |header: &csv::StringRecord, row: &csv::StringRecord| {
        let number = |name: &str| {
            header.iter().position(|h| h == name).map_or(0.0, |column| row[column].parse().unwrap())
        };
        let law = [number("alpha"), number("beta"), number("gamma")];
        Law::Stribeck.point(number("epsilon"), &law, number("V"), number("c")).unwrap()
    };
    let (header, all) = rows("margins.csv");
    let column = header.iter().position(|name| name == "margin").unwrap();
    let mut checked = 0;
    for row in all.iter().filter(|row| !row[column].is_empty()) {
        // Outside the domain of the polar form there is no reference.
        if let Some(margin) = reference(&Law::Stribeck, &point(&header, row), None).margin {
            assert_agrees(&margin, &row[column]);
            checked += 1;
        }
    }
    assert!(checked > 250, "{checked} margins");
    let (header, all) = rows("critical_damping.csv");
    let column = header.iter().position(|name| name == "critical_c").unwrap();
    for row in all.iter().step_by(3) {
        let known: f64 = row[column].parse().unwrap();
        let found = reference(&Law::Stribeck, &point(&header, row), Some(known)).critical.unwrap();
        assert_agrees(&found, &row[column]);
        assert!(found.error < 1e-20, "{found:?}");
    }
}

/// Digits beyond a double's come from two rules that agree; the equation is that of the direct engine.
#[test]
fn the_reference_of_other_laws_is_that_of_the_direct_engine() {
    let mut random = Random(71);
    let mut checked = 0;
    for trial in 0..200 {
        let (speed, damping) = (0.3 + random.unit(), 0.8 * random.unit());
        let [a, b] = [0; 2].map(|_| random.unit());
        let (law, parameters) = match trial % 2 {
            0 => (Law::Exponential, vec![0.5 + 0.5 * a, 0.1 + b, 0.2 * a]),
            _ => (Law::Coulomb, vec![0.6 * a, 0.3 * b]),
        };
        let point = law.point(1.0, &parameters, speed, damping).unwrap();
        let Some(margin) = reference(&law, &point, None).margin else { continue };
        let flow = witness::flow(&Oscillator::new(&law, &point), 1e-13);
        if flow.margin.is_finite() {
            let apart = (margin.value - flow.margin).value().abs();
            assert!(apart <= flow.margin_error.max(1e-14), "{law:?} {point:?}: {apart:e}, {flow:?}");
            checked += 1;
        }
    }
    assert!(checked > 120, "{checked} margins");
}

/// A study of some contestants on a few cells.
static STUDY: LazyLock<Study> = LazyLock::new(|| {
    let nodes = [vec![0.05], vec![0.0, 0.9], vec![0.0, 0.3], vec![0.5, 4.0], vec![0.2, 1.5], vec![0.0, 2.0]];
    let grid = Grid::new(Law::Stribeck, nodes.to_vec()).unwrap();
    let settings = StudySettings { cells: 60, near: 0.02, seconds: 0.02 };
    let fast = |one: &Contestant| {
        one.kind != ContestantKind::Naive || (one.name == "event_step" && one.setting == 1e-3)
    };
    let who: Vec<Contestant> = contestants().into_iter().filter(fast).collect();
    Study::run(&grid, settings, &who, &|_| (), &|| true).unwrap()
});

fn row(name: &str, setting: Option<f64>) -> &'static Row {
    let found =
        STUDY.rows.iter().find(|row| row.name == name && row.setting.as_ref().map(|s| s.1) == setting);
    found.unwrap_or_else(|| panic!("no {name} at {setting:?}"))
}

#[test]
fn a_closed_forms_errors_and_labels_are_those_of_its_formula() {
    let found = row("perturbation", None);
    assert_eq!(found.cells, STUDY.cells.len());
    let (mut near, mut anywhere) = (Labels::default(), Labels::default());
    let (mut dampings, mut margins) = (Vec::new(), Vec::new());
    for cell in &STUDY.cells {
        let &[alpha, beta, gamma] = cell.point.law.as_slice() else { unreachable!() };
        let edge = gamma * (1.0 - alpha) - 2.0 * beta * cell.point.belt_speed;
        let truth = cell.reference.margin.unwrap().value.value() > 0.0;
        assert_eq!(truth, cell.verdict == Verdict::Present, "no orbit of this box overshoots");
        let labels = if cell.near { &mut near } else { &mut anywhere };
        labels.cells += 1;
        labels.wrong += usize::from((cell.point.damping < edge) != truth);
        if let (Some(critical), Some(slope)) = (cell.reference.critical, cell.reference.slope) {
            dampings.push((edge - critical.value.value()).abs());
            margins.push((edge - critical.value.value()).abs() * slope);
        }
    }
    assert!(near.cells > 15 && near.wrong > 0);
    assert_eq!((found.near, found.anywhere), (Some(near), Some(anywhere)));
    // The edge is rounded in another order: to a few units in the last place of numbers up to 4.
    let close = |found: &Errors, sizes: &mut Vec<f64>| {
        sizes.sort_by(f64::total_cmp);
        let at = |q: f64| sizes[(q * sizes.len() as f64).ceil() as usize - 1];
        for (a, b) in [(found.median, at(0.5)), (found.high, at(0.95)), (found.worst, at(1.0))] {
            assert!((a - b).abs() <= 8.0 * f64::EPSILON * 4.0, "{a} {b}");
        }
        assert_eq!(found.count, sizes.len());
    };
    close(&found.critical.unwrap(), &mut dampings);
    close(&found.margin.unwrap(), &mut margins);
}

#[test]
fn engines_keep_their_tolerance_and_theorems_never_err() {
    for tolerance in [1e-4, 1e-8, 1e-12] {
        // The knob is the error that it aims at and estimates.
        let worst = row("direct", Some(tolerance)).margin.unwrap().worst;
        assert!(worst <= tolerance, "{tolerance:e}: {worst:e}");
    }
    for name in ["instability", "bendixson", "symmetric", "validated"] {
        let found = row(name, None);
        assert_eq!((found.near.unwrap().wrong, found.anywhere.unwrap().wrong), (0, 0), "{name}");
    }
    let event_step = row("event_step", Some(1e-3));
    assert!(event_step.critical.is_some_and(|errors| errors.worst > 1e-6), "a naive method has an error");
    assert!(STUDY.rows.iter().all(|row| row.seconds > 0.0));
}

#[test]
fn no_row_dominates_a_row_on_the_front() {
    let point = |row: &Row| row.margin.map(|errors| (row.seconds, errors.worst));
    let all: Vec<(f64, f64)> = STUDY.rows.iter().filter_map(point).collect();
    for row in &STUDY.rows {
        let Some(at) = point(row) else {
            assert!(!row.front_error);
            continue;
        };
        let beaten = all.iter().any(|other| other.0 <= at.0 && other.1 <= at.1 && *other != at);
        assert_eq!(row.front_error, !beaten, "{}", row.name);
    }
}

#[test]
fn table_and_chart_hold_the_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    write_study(&STUDY, &out, slipmap::files::Existing::Refuse, Width::TwoColumns).unwrap();
    let csv = std::fs::read_to_string(out.join("work-precision.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(records.len(), STUDY.rows.len());
    let check = |name: &str, of: fn(&Row) -> Option<f64>| {
        let column = header.iter().position(|column| column == name).unwrap();
        for (record, row) in records.iter().zip(&STUDY.rows) {
            assert_eq!(record[column].parse::<f64>().ok(), of(row), "{name}");
        }
    };
    check("seconds_per_cell", |row| Some(row.seconds));
    check("setting", |row| row.setting.as_ref().map(|(_, setting)| *setting));
    check("margin_error_worst", |row| row.margin.map(|errors| errors.worst));
    for width in [Width::OneColumn, Width::TwoColumns] {
        let chart = chart(&STUDY, width);
        let svg = chart.scene.svg("chart", &chart.caption);
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.contains("critical damping") && !svg.contains("NaN"), "{svg}");
    }
}

/// The stored charts have every method at every setting, and the peers.
#[test]
fn stored_charts_have_the_methods_of_today() {
    for scene in ["paper", "brake", "coefficients"] {
        let (header, records) = rows(&format!("../../results/work-precision/{scene}/work-precision.csv"));
        let column = |name: &str| header.iter().position(|column| column == name).unwrap();
        let [kind, method, setting] = ["kind", "method", "setting"].map(column);
        let own = records.iter().filter(|record| &record[kind] != ContestantKind::Peer.name());
        let stored: Vec<(String, Option<f64>)> =
            own.map(|record| (record[method].to_owned(), record[setting].parse().ok())).collect();
        let today: Vec<(String, Option<f64>)> = contestants()
            .iter()
            .map(|one| (one.name.to_owned(), Some(one.setting).filter(|setting| !setting.is_nan())))
            .collect();
        assert_eq!(stored, today, "{scene}");
        assert!(records.len() > today.len(), "{scene} has no peers");
    }
}

/// What has no answer or a wrong one is seen beside the marks: a number, and the lower end of a bar.
#[test]
fn a_chart_shows_what_is_unanswered() {
    let told = |unanswered: fn(&Row) -> usize| {
        let mut study = STUDY.clone();
        study.rows.retain(|row| row.name == "direct");
        study.rows.iter_mut().for_each(|row| row.unanswered = unanswered(row));
        let chart = chart(&study, Width::OneColumn);
        chart.scene.svg("chart", &chart.caption).matches(">100<").count()
    };
    // Once for the seven settings, which are all like this.
    assert_eq!([told(|_| 0), told(|row| row.cells)], [0, 1]);
}

#[test]
fn peers_are_those_about_the_same_cells() {
    let folder = tempfile::tempdir().unwrap();
    let mut study = STUDY.clone();
    let write = |text: &str| std::fs::write(folder.path().join("peers.csv"), text).unwrap();
    let peers = |cells: &str| {
        write(&format!(
            "# cells sha256 {cells}\npeer,form,tolerance,cells,seconds_per_cell,median_error,max_error,near_cells,\
             near_wrong,near_no_answer\nSciPy solve_ivp,\"(x1,x2), DOP853 + events\",1e-9,50,2e-3,1e-12,2e-3,20,1,0\n"
        ));
    };
    let rows = study.rows.len();
    add_peers(&mut study, folder.path()).unwrap();
    assert_eq!(study.rows.len(), rows);
    peers(&fingerprint(&study.cells_csv()));
    add_peers(&mut study, folder.path()).unwrap();
    let added: Vec<&Row> = study.rows.iter().filter(|row| row.kind == ContestantKind::Peer).collect();
    assert_eq!(added.len(), 1);
    assert_eq!((added[0].name.as_str(), added[0].seconds), ("SciPy DOP853", 2e-3));
    assert_eq!(added[0].margin.map(|errors| errors.worst), Some(2e-3));
    assert_eq!(added[0].near, Some(Labels { cells: 20, wrong: 1, none: 0 }));
    peers("0");
    let error = add_peers(&mut study, folder.path()).unwrap_err().to_string();
    error.says(&["peers.csv", "other cells"]);
    write(&format!("# cells sha256 {}\na,b\n1,2\n", fingerprint(&study.cells_csv())));
    let error = add_peers(&mut study, folder.path()).unwrap_err().to_string();
    error.says(&["peers.csv", "no column `peer`"]);
}

#[test]
fn the_command_writes_everything_or_nothing() {
    let scratch = Scratch::new();
    let config = "[grid]\nepsilon = 0.05\nalpha = 0.3\nbeta = 0.1\ngamma = [1, 3]\nV = 1.0\nc = [0, 2]\n\
                  [work_precision]\ncells = 4\nseconds = 1e-6\n";
    scratch.file("study.toml", config);
    let run = scratch.run("work-precision study.toml").ends_with(0);
    assert_eq!(run.out.trim(), "results/study/work-precision.csv");
    let table = scratch.read("results/study/work-precision.csv");
    table.says(&["perturbation", "critical_damping", "direct", "smoothed", "event_step"]);
    scratch.run("work-precision study.toml").refuses(&["results/study exists already", "--overwrite"]);
    scratch
        .run("work-precision study.toml --out x --set work_precision.near=0")
        .refuses(&["near", "greater than 0"]);
    assert_eq!(scratch.names(), ["results", "study.toml"]);
    // One cell outside the domain of the reference, so that nothing can be measured.
    scratch
        .run("work-precision study.toml --out x --set grid.epsilon=10 --set grid.c=[2,3]")
        .refuses(&["no reference"]);
}
