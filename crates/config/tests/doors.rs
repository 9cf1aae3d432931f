//! Random laws and machines go round the doors: a configuration, its overrides, a table of points and JSON. What
//! comes out is what went in.

#![allow(clippy::unwrap_used)] // a test

use std::fs;
use std::path::Path;

use slipmap_config::{About, Job, LawText, MachineJob, PointTable, load_machine, machine_of, point_of};
use slipmap_machine::risk::{MOST_JOINT, Spread, Uncertain};
use slipmap_machine::{Coefficients, DAMPING, Machine, Motion};
use slipmap_map::Shown;
use slipmap_model::friction::{Law, Source, Table};
use slipmap_numbers::random::Random;
use tempfile::TempDir;

const CASES: usize = 200;

/// Formulas with their names.
const FORMULAS: [&str; 4] = [
    "0.3 + 0.1*exp(-u/0.5)",
    "muk + (mus - muk)*exp(-u/vs)",
    "muk + (mus - muk)*exp(-(u/vs)^2) + 0.01*u",
    "(muk + (mus - muk)/(1 + (u/vs)^2))",
];

fn chance(random: &mut Random, share: f64) -> bool {
    random.unit() < share
}

fn one_of<T: Clone>(random: &mut Random, all: &[T]) -> T {
    all[((random.unit() * all.len() as f64) as usize).min(all.len() - 1)].clone()
}

/// Rows of a curve that falls from `rest`, with noise in the last bits that decimal texts would lose.
fn table(random: &mut Random, rest: f64) -> Table {
    let count = 3 + (50.0 * random.unit()) as usize;
    let data: Vec<(f64, f64)> = (0..count)
        .map(|i| {
            let u = 8.0 * (i as f64 / count as f64).powi(2);
            (u, rest * (0.5 + 0.5 * (-u).exp()) * if i > 0 { 1.0 + 0.2 * random.unit() } else { 1.0 })
        })
        .collect();
    let table = match chance(random, 0.5) {
        true => Table::with_static("rig; \"7\".csv", &data, rest * (1.0 + random.unit())),
        false => Table::new("rig; \"7\".csv", &data, rest),
    };
    let mut table = table.unwrap();
    if chance(random, 0.5) {
        let errors: Vec<f64> = data.iter().map(|_| 0.01 * random.unit()).collect();
        table = table.with_standard_errors(&errors).unwrap();
    } else if chance(random, 0.5) {
        let root = (0..count).map(|i| (0..=i).map(|_| 0.01 * random.unit()).collect()).collect();
        table = table.with_root_of_covariance(root).unwrap();
    }
    let no_rest = chance(random, 0.3);
    let told = chance(random, 0.3).then(|| "rig.csv: both directions".to_owned());
    let lines = if chance(random, 0.5) { (2..2 + count).collect() } else { Vec::new() };
    let readings = count + (9.0 * random.unit()) as usize;
    table.with_error_of_curve().with_source(Source {
        lines,
        readings,
        told,
        forces: false,
        no_rest,
        named_errors: true,
    })
}

/// A law of the dimensionless oscillator.
fn law(random: &mut Random) -> Law {
    let law = match (4.0 * random.unit()) as usize {
        0 => Law::Table(table(random, 1.0)),
        1 => {
            let at_peak = chance(random, 0.3);
            let phi = if at_peak { "tanh(9*u)*(0.5 + 0.5*exp(-u))" } else { "mu + (1 - mu)*exp(-u/vs)" };
            let text = LawText {
                name: "expression".into(),
                phi: Some(phi.into()),
                static_level: (!at_peak && chance(random, 0.5)).then(|| 1.0 + random.unit()),
                rest: at_peak.then(|| "peak".to_owned()),
                ..LawText::default()
            };
            text.law(About::Oscillator).unwrap()
        }
        _ => one_of(random, &Law::BUILT_IN),
    };
    let law = if chance(random, 0.5) { law.with_exponent() } else { law };
    let law = if chance(random, 0.3) && !law.may_drop() { law.with_drop() } else { law };
    if chance(random, 0.3) { law.read_as_small() } else { law }
}

/// The values of its axes: legal for every law here.
fn values(random: &mut Random, law: &Law) -> Vec<f64> {
    let of = |name: &str, unit: f64| match name {
        "V" => 0.2 + unit,
        "exponent" => 1.0 + unit,
        "drop" => 0.3 * unit,
        _ => 0.1 + 0.8 * unit,
    };
    law.axis_names().into_iter().map(|name| of(name, random.unit())).collect()
}

fn by_json(text: &LawText) -> LawText {
    serde_json::from_str(&serde_json::to_string(text).unwrap()).unwrap()
}

#[test]
fn laws_go_round() {
    let folder = TempDir::new().unwrap();
    let (job, rows) = (folder.path().join("job.toml"), folder.path().join("points.csv"));
    let mut random = Random(72);
    for _ in 0..CASES {
        let law = law(&mut random);
        let text = LawText::of(&law, About::Oscillator).unwrap();
        assert_eq!(by_json(&text), text);
        assert_eq!(text.law(About::Oscillator).unwrap(), law);
        // As a map and a certificate have it.
        assert_eq!(Law::from_definition(law.name(), &law.definition()).as_ref(), Some(&law));
        let values = values(&mut random, &law);
        let grid: Vec<String> =
            law.axis_names().iter().zip(&values).map(|(name, value)| format!("{name} = {value:?}")).collect();
        fs::write(&job, format!("{}\n[grid]\n{}\n", text.to_toml(), grid.join("\n"))).unwrap();
        // An override has the last word.
        let sets = ["grid.c=0.25".to_owned()];
        let grid = Job::load(&job, &sets).unwrap().plan.grid;
        assert_eq!(grid.law(), &law);
        let mut expected = values.clone();
        *expected.last_mut().unwrap() = 0.25;
        assert_eq!(grid.axes().iter().map(|axis| axis.values[0]).collect::<Vec<_>>(), expected);
        // The parameters `exponent` and `drop` come from the columns.
        let plain = LawText { axes: Vec::new(), ..text }.law(About::Oscillator).unwrap();
        let numbers: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        fs::write(&rows, format!("{}\n{}\n", law.axis_names().join(","), numbers.join(","))).unwrap();
        let (mut points, of_points) = PointTable::open(&rows, &plain, &[]).unwrap();
        // The parameter comes before the reading by eps.
        assert_eq!(of_points, law);
        let row = points.rows().unwrap().remove(0);
        assert_eq!(points.point(&row, &of_points).unwrap(), point_of(&law, &values).unwrap());
    }
}

/// A machine with spreads, units and what varies.
fn machine(random: &mut Random) -> MachineJob {
    let motion = one_of(random, &Motion::ALL);
    let forces = chance(random, 0.3);
    let law = match (3.0 * random.unit()) as usize {
        0 => {
            let table = table(random, 0.4);
            let source = Source { forces, ..table.source().clone() };
            Law::Table(table.with_source(source))
        }
        1 => {
            let text = LawText {
                name: "expression".into(),
                phi: Some(one_of(random, &FORMULAS).into()),
                static_level: chance(random, 0.5).then(|| 2.0 + random.unit()),
                ..LawText::default()
            };
            text.law(About::Machine(motion)).unwrap()
        }
        _ => one_of(random, &Law::BUILT_IN),
    };
    let law = if chance(random, 0.3) { law.with_exponent() } else { law };
    let law = if chance(random, 0.2) { law.read_as_small() } else { law };
    let is_own = law.built_in().is_none();
    let mut given = Vec::new();
    for name in ["frequency", "damping_ratio"] {
        given.extend(chance(random, 0.3).then_some(name));
    }
    if !(forces && is_own) {
        given.extend(chance(random, 0.3).then_some(["pressure", "area"]).into_iter().flatten());
        given.extend((motion == Motion::Rotation && chance(random, 0.3)).then_some("radius"));
    }
    // A frequency stands for the stiffness or for the mass.
    if chance(random, 0.5) && given.contains(&"frequency") {
        given.push("stiffness");
    }
    let names = Machine::names(&law, |name| given.contains(&name));
    let names = names.into_iter().filter(|name| !(forces && is_own && *name == "normal_force"));
    let of = |name: &'static str, unit: f64| match name {
        "exponent" => 1.0 + unit,
        "static_friction" | "mus" => 0.5 + 0.4 * unit,
        "kinetic_friction" | "muk" => 0.1 + 0.3 * unit,
        "stiffness" => 1e5 * (1.0 + unit),
        _ => 0.1 + unit,
    };
    let known: Vec<(&'static str, f64)> = names.map(|name| (name, of(name, random.unit()))).collect();
    let value = |name: &str| known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    let machine = machine_of(motion, &law, value, value).unwrap();
    let mut uncertain: Vec<Uncertain> = Vec::new();
    if let Law::Expression(formula) = law.as_written()
        && chance(random, 0.5)
    {
        for (at, parameter) in formula.parameters().iter().enumerate() {
            let mut row = [0.0; MOST_JOINT];
            row[..=at].iter_mut().for_each(|entry| *entry = 0.01 * (random.unit() - 0.3));
            uncertain.push((parameter.name, Spread::Joint { row }));
        }
    }
    let quantities = machine.quantities();
    let mut varied = Vec::new();
    let mut units = Vec::new();
    for (name, value) in quantities {
        let free = !uncertain.iter().any(|(known, _)| *known == name);
        let of_formula = law.parameters().iter().any(|parameter| parameter.name == name);
        match (3.0 * random.unit()) as usize {
            0 if free && name == DAMPING => varied.push((name, vec![value, 1.5 * value, 4.0 * value])),
            1 if free && !Coefficients::NAMES.contains(&name) => {
                uncertain.push((name, Spread::Normal { sd: 0.1 * value }));
            }
            _ => {}
        }
        if name == "mass" && motion == Motion::Translation && !of_formula {
            units.push((name, Some(Shown { unit: "g".into(), size: 1e-3 })));
        }
    }
    MachineJob { machine, varied, uncertain, units, conversions: Vec::new(), title: Some("Rig \"7\"".into()) }
}

fn read(folder: &Path, job: &MachineJob) -> (MachineJob, std::path::PathBuf) {
    let file = folder.join("machine.toml");
    let text = job.to_toml().unwrap();
    fs::write(&file, &text).unwrap();
    let values: [(String, f64); 0] = [];
    (load_machine(&file, &values).unwrap_or_else(|error| panic!("{error}\n{text}")), file)
}

/// Equal but for the rounding of a covariance, of which a factor is made.
fn assert_same_spreads(one: &[Uncertain], other: &[Uncertain], text: &str) {
    let name =
        |uncertain: &[Uncertain], name: &str| uncertain.iter().find(|(known, _)| *known == name).copied();
    assert_eq!(one.len(), other.len(), "{text}");
    let product =
        |a: &[f64; MOST_JOINT], b: &[f64; MOST_JOINT]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    for (of, spread) in one {
        let (_, again) = name(other, of).unwrap();
        let (Spread::Joint { row }, Spread::Joint { row: again }) = (spread, again) else {
            assert_eq!(*spread, again, "{of} {text}");
            continue;
        };
        for (with, spread) in one {
            let Spread::Joint { row: second } = spread else { continue };
            let Some((_, Spread::Joint { row: second_again })) = name(other, with) else { panic!("{with}") };
            let (covariance, covariance_again) = (product(row, second), product(&again, &second_again));
            let size = (product(row, row) * product(second, second)).sqrt();
            // A product of eight terms, its factor, and the product again.
            assert!(
                (covariance - covariance_again).abs() <= 32.0 * f64::EPSILON * size,
                "{of} {with} {text}"
            );
        }
    }
}

#[test]
fn machines_go_round() {
    let folder = TempDir::new().unwrap();
    let mut random = Random(75);
    for _ in 0..CASES {
        let job = machine(&mut random);
        let text = job.to_toml().unwrap();
        let (again, file) = read(folder.path(), &job);
        assert_eq!(again.machine, job.machine, "{text}");
        assert_eq!((&again.title, &again.varied), (&job.title, &job.varied), "{text}");
        assert_same_spreads(&job.uncertain, &again.uncertain, &text);
        let unit = |job: &MachineJob| job.units.iter().find(|(name, _)| *name == "mass")?.1.clone();
        // In g where a number of grams is this mass, to the last bit.
        let line = text.lines().find(|line| line.starts_with("mass")).unwrap_or_default();
        let in_grams = line.split(", sd").next().unwrap_or_default().contains(" g\"");
        assert_eq!(unit(&again), unit(&job).filter(|_| in_grams), "{text}");
        // As JSON.
        let of_machine = LawText::of_machine(&job.machine, &job.uncertain).unwrap();
        assert_eq!(by_json(&of_machine), of_machine);
        let law = of_machine.law(About::Machine(job.machine.motion)).unwrap();
        let known = job.machine.quantities();
        let value = |name: &str| known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        let by_json = machine_of(job.machine.motion, &law, value, value).unwrap();
        assert_eq!(by_json, job.machine, "{text}");
        // By --set.
        let (name, value) = ("belt_speed".to_owned(), 0.077);
        let set = load_machine(&file, &[(name, value)]).unwrap();
        assert_eq!(set.machine, job.machine.with("belt_speed", value).unwrap(), "{text}");
    }
}

/// A table without rest, in forces, with scattered rows: what is read of the file is written as rows.
#[test]
fn a_file_goes_round() {
    let folder = TempDir::new().unwrap();
    let mut random = Random(7);
    let rows: String = (1..200)
        .map(|i| {
            let v = 10 * i;
            format!("{v};{:.5}\n", 0.7 + 0.5 * (-f64::from(v) / 100.0).exp() + 0.02 * random.normal())
                .replace('.', ",")
        })
        .collect();
    fs::write(folder.path().join("rig.csv"), format!("v [mm/s];F [kN]\n{rows}")).unwrap();
    let text = "[friction]\nlaw = \"table\"\nfile = \"rig.csv\"\n[machine]\nmass = 0.4\nstiffness = 3e5\n\
                belt_speed = 0.1\ndamping = 300\n";
    let file = folder.path().join("rig.toml");
    fs::write(&file, text).unwrap();
    let values: [(String, f64); 0] = [];
    let job = load_machine(&file, &values).unwrap();
    assert_eq!(read(folder.path(), &job).0.machine, job.machine);
}
