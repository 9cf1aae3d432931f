//! How often the true answers lie within the 95 % intervals that are stated for measured friction.
//!
//! Each case is a measurement of a known law, as a rig writes it: 15 to 4,000 rows, even or dense next to rest, with
//! an error of 0.5 to 5 %, and at random repeated, unsorted, in both directions, in mm/s and kN with decimal commas,
//! with readings at rest or standard errors; or a record over time: ramps, staircases and sweeps with errors that remember
//! or not, in one direction or both, with phases of rest or without. The answers are those of the best fit, or of the curve.

use super::{How, Measured, OfMachine};
use crate::{MachineJob, load_machine};
use rayon::prelude::*;
use slipmap_column::critical::critical_damping;
use slipmap_column::sensitivity::influence;
use slipmap_machine::Machine;
use slipmap_machine::assessment::{Assessment, assess, assess_fitted};
use slipmap_machine::behaviour::Limit;
use slipmap_machine::risk::{WithError, uncertain_critical_damping};
use slipmap_numbers::random::Random;
use std::sync::Mutex;

/// A law: its name, its fall g as a formula, and g itself.
type Fall = (&'static str, &'static str, fn(f64) -> f64);

const LAWS: [Fall; 5] = [
    ("exponential", "exp(-(u/W))", |x| (-x).exp()),
    ("gaussian", "exp(-(u/W)^2)", |x| (-x * x).exp()),
    ("stretched", "exp(-(u/W)^1.5)", |x| (-x.powf(1.5)).exp()),
    ("lorentzian", "1/(1 + (u/W)^2)", |x| 1.0 / (1.0 + x * x)),
    ("hyperbolic", "1/(1 + u/W)", |x| 1.0 / (1.0 + x)),
];
/// Friction at rest in N, the speed in m/s over which it falls, and the stiffness in N/m.
const REST: f64 = 1200.0;
const FALL: f64 = 0.05;
const STIFFNESS: f64 = 3e5;
/// 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.96;

/// What is made of the readings.
#[derive(Clone, Copy, PartialEq)]
enum As {
    Fit,
    Table,
}

/// The true law of a case, and the file of what was measured.
struct Case {
    words: String,
    rows: usize,
    machine: Machine,
    rig: String,
}

/// The machine of a configuration with this friction, beside a file of readings; `None` where it is refused.
pub(super) fn job(friction: &str, [mass, belt_speed, damping]: [f64; 3], rig: &str) -> Option<MachineJob> {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("machine.toml");
    let machine =
        format!("mass = {mass}\nstiffness = {STIFFNESS}\ndamping = {damping}\nbelt_speed = {belt_speed}");
    std::fs::write(folder.path().join("rig.csv"), rig).unwrap();
    std::fs::write(&config, format!("[machine]\n{machine}\n{friction}")).unwrap();
    load_machine::<f64>(&config, &[]).ok()
}

/// What is measured: readings in any order, or a record over time.
#[derive(Clone, Copy, PartialEq)]
enum Sort {
    Readings,
    Record,
}

impl Case {
    fn new(sort: Sort, number: u64, most_rows: f64) -> Self {
        let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 50);
        let (name, formula, fall) = LAWS[(number % 5) as usize];
        let far = REST * (0.4 + 0.4 * random.unit());
        let rise = if random.unit() < 0.5 { 0.0 } else { 40.0 * random.unit() };
        let force = |u: f64| far + (REST - far) * fall(u / FALL) + rise * u;
        let mut between = |from: f64, to: f64| from * (to / from).powf(random.unit());
        let (belt_speed, mass) = (FALL * between(0.5, 8.0), between(0.4, 10.0));
        let fewest = if sort == Sort::Record { 64.0 } else { 15.0 };
        let (rows, noise) = (between(fewest, most_rows) as usize, REST * between(0.005, 0.05));
        let text = format!("{far} + {}*{} + {rise}*u", REST - far, formula.replace('W', &FALL.to_string()));
        let friction = format!("[friction]\nlaw = \"expression\"\nquantity = \"force\"\nphi = \"{text}\"");
        let mut machine = job(&friction, [mass, belt_speed, 0.0], "").unwrap().machine;
        let model = machine.model().unwrap();
        let reach = influence(&model.column(), 2).unwrap()[1].to * model.si.velocity;
        let critical = critical_damping(&model.column(), 1e-9).unwrap().c * model.si.damping;
        let rate = model.column().curve.weakening(model.point.belt_speed);
        let hopf = rate * model.si.damping / model.point.epsilon;
        // Steady slip needs a kick between the two limits.
        machine.damping =
            if hopf < 0.8 * critical { 0.5 * (hopf.max(0.0) + critical) } else { 0.7 * critical };
        let (what, rig) = match sort {
            Sort::Readings => (String::new(), readings(&mut random, rows, 1.5 * reach, noise, &force)),
            Sort::Record => record(&mut random, rows, 1.5 * reach, noise, &force),
        };
        let (noise, speed) = (noise / REST, belt_speed / FALL);
        let words = format!("{what}{name}, {rows} rows, noise {noise:.4}, V/v_s {speed:.2}");
        Self { words, rows, machine, rig }
    }

    /// The machine with the measured friction, and the errors of that; `None` where no law is fitted.
    fn measured(&self, what: As) -> Option<MachineJob> {
        let friction = match what {
            As::Table => "[friction]\nlaw = \"table\"\nquantity = \"force\"\nfile = \"rig.csv\"".to_owned(),
            As::Fit => {
                let of = OfMachine { motion: None, forces: Some(true) };
                let measured = Measured::of_bytes(
                    "rig.csv",
                    self.rig.as_bytes(),
                    How { machine: Some(of), ..How::default() },
                )
                .unwrap();
                measured.to_toml(measured.fits(None).ok()?.chosen())
            }
        };
        let Machine { mass, belt_speed, damping, .. } = self.machine;
        job(&friction, [mass, belt_speed, damping], &self.rig)
    }

    /// The true critical damping, and the one that is stated.
    fn critical(&self, what: As) -> (f64, Option<WithError>) {
        let model = self.machine.model().unwrap();
        let expected = critical_damping(&model.column(), 1e-9).unwrap().c * model.si.damping;
        let Some(MachineJob { machine, uncertain, .. }) = self.measured(what) else {
            return (expected, None);
        };
        // Rows without errors have them on a page alone.
        let of_page = || assess(&machine)?.standard_errors?.critical_damping;
        (expected, uncertain_critical_damping(&machine, &uncertain).or_else(of_page))
    }

    /// The true critical belt speed and kick, and those that are stated.
    fn of_page(&self, what: As) -> [(Option<f64>, Option<WithError>); 2] {
        let all = self.measured(what).and_then(|job| assess_fitted(&job.machine, &job.uncertain));
        let (Some(truth), Some(all)) = (assess(&self.machine), all) else { return [(None, None); 2] };
        let limit = |of: &Assessment| match of.behaviour.critical_belt_speed {
            Limit::Below(value) => Some(value),
            _ => None,
        };
        let kick = |of: &Assessment| of.kick.map(|kick| kick.forward);
        let errors = all.standard_errors;
        if errors.and_then(|errors| errors.critical_belt_speed).is_none() {
            let [found, needed] = [limit(&all), all.needed_for_speeds];
            let words = &self.words;
            println!("{words}: no error of the belt speed {found:.3?}; data needed up to {needed:.3?}");
        }
        let of_kick = errors.and_then(|errors| Some(errors.kick?.forward)).zip(kick(&all));
        let of_kick = of_kick.map(|(standard_error, value)| WithError { value, standard_error });
        [(limit(&truth), errors.and_then(|errors| errors.critical_belt_speed)), (kick(&truth), of_kick)]
    }
}

/// How many true values lie within the stated interval, outside it, and without one.
#[derive(Default)]
struct Count {
    within: u32,
    outside: u32,
    withheld: u32,
}

impl Count {
    /// Counts a value; returns its distance in standard errors.
    fn count(&mut self, expected: f64, stated: Option<WithError>) -> f64 {
        let Some(WithError { value, standard_error }) = stated else {
            self.withheld += 1;
            return f64::NAN;
        };
        let distance = (value - expected) / standard_error;
        if distance.abs() <= NORMAL {
            self.within += 1
        } else {
            self.outside += 1
        }
        distance
    }
}

/// Of some 12 measurements each, fitted and joined by a curve, at most two intervals miss the true critical damping:
/// of independent ones with 95 % there are more in 2 of 100 samples; of 24 records at most four, more in 1 of 100. One answer at
/// most is withheld.
#[test]
fn true_critical_dampings_lie_within_their_intervals() {
    for (sort, what, cases, most) in [
        (Sort::Readings, As::Fit, 16, 2),
        (Sort::Readings, As::Table, 16, 2),
        (Sort::Record, As::Table, 24, 4),
    ] {
        let mut count = Count::default();
        let all = (0..cases)
            .map(|number| Case::new(sort, number, if sort == Sort::Record { 2000.0 } else { 150.0 }));
        for case in all.filter(|case| case.rows >= 40) {
            let (expected, stated) = case.critical(what);
            let distance = count.count(expected, stated);
            println!("{}: {distance:.2}", case.words);
        }
        assert!(count.outside <= most && count.withheld <= 1, "{} {}", count.outside, count.withheld);
    }
}

/// The same of as many measurements as the variable SLIPMAP_CASES says, from the number SLIPMAP_FIRST on, of up to 4,000
/// rows, records of up to 50,000, with critical belt speeds and kicks of as many as SLIPMAP_PAGES, or only of the kind
/// SLIPMAP_WHAT: scripts/evidence/measured.py.
#[test]
#[ignore = "takes a second a case"]
fn coverage() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(0_u64);
    let [first, cases, pages] = ["SLIPMAP_FIRST", "SLIPMAP_CASES", "SLIPMAP_PAGES"].map(number);
    let all = [
        (Sort::Readings, As::Fit, "fits"),
        (Sort::Readings, As::Table, "tables"),
        (Sort::Record, As::Fit, "fits of records"),
        (Sort::Record, As::Table, "records"),
    ];
    let wanted = std::env::var("SLIPMAP_WHAT").unwrap_or_default();
    for (sort, what, name) in all.into_iter().filter(|(.., name)| wanted.is_empty() || *name == wanted) {
        let counts: [Mutex<Count>; 3] = Default::default();
        (0..cases.max(pages)).into_par_iter().for_each(|k| {
            let most = if sort == Sort::Record { 50_000.0 } else { 4000.0 };
            let case = Case::new(sort, first + k, most);
            let mut answers = Vec::new();
            if k < cases {
                let (expected, stated) = case.critical(what);
                answers.push((0, expected, stated));
            }
            if k < pages {
                let of_page = (1..).zip(case.of_page(what));
                answers.extend(of_page.filter_map(|(of, (expected, stated))| Some((of, expected?, stated))));
            }
            let count =
                |(of, expected, stated): (usize, f64, _)| counts[of].lock().unwrap().count(expected, stated);
            let distances: Vec<f64> = answers.into_iter().map(count).collect();
            println!("{name} {}: {}: {distances:.2?}", first + k, case.words);
        });
        for (of, count) in ["critical damping", "critical belt speed", "kick"].into_iter().zip(counts) {
            let Count { within, outside, withheld } = count.into_inner().unwrap();
            let share = 100.0 * f64::from(within) / f64::from(within + outside);
            println!("{name}, {of}: {share:.1} % of {} within, {withheld} withheld", within + outside);
        }
    }
}

/// A file of readings.
fn readings(
    random: &mut Random,
    rows: usize,
    fastest: f64,
    noise: f64,
    force: &dyn Fn(f64) -> f64,
) -> String {
    let mut likely = |share: f64| random.unit() < share;
    let (repeated, unsorted, both, german, rest, errors) =
        (likely(0.3), likely(0.3), likely(0.2), likely(0.3), likely(0.7), likely(0.3));
    let power = f64::from(1 + u8::from(likely(0.7)) + u8::from(likely(0.5)));
    let speeds = if repeated { (rows / 3).max(8) } else { rows };
    let mut data: Vec<[f64; 2]> = Vec::new();
    for i in 0..rows.max(speeds) {
        let u = fastest * ((i % speeds + 1) as f64 / speeds as f64).powf(power);
        data.push([u, force(u) + noise * random.normal()]);
    }
    if rest {
        (0..3 + rows / 300).for_each(|_| data.push([0.0, force(0.0) + noise * random.normal()]));
    }
    for row in &mut data {
        if both && row[0] > 0.0 && random.unit() < 0.5 {
            *row = row.map(|x| -x);
        }
    }
    if unsorted {
        for i in (1..data.len()).rev() {
            data.swap(i, (random.unit() * (i + 1) as f64) as usize);
        }
    } else {
        data.sort_by(|one, other| one[0].abs().total_cmp(&other[0].abs()));
    }
    let (header, scale, digits, separator) = match german {
        false => ("v [m/s],F [N]", [1.0; 2], [6, 3], ","),
        true => ("Versuch 7\n\nv [mm/s];F [kN]", [1e3, 1e-3], [4, 6], ";"),
    };
    let mut text = header.to_owned();
    if errors {
        text.push_str(if german { ";se [kN]" } else { ",se [N]" });
    }
    for [u, f] in data {
        let columns = if errors { vec![f, noise] } else { vec![f] };
        let mut line = format!("\n{:.*}", digits[0], scale[0] * u);
        columns.iter().for_each(|f| line.push_str(&format!("{separator}{:.*}", digits[1], scale[1] * f)));
        text.push_str(&if german { line.replace('.', ",") } else { line });
    }
    text
}

/// What it is, and the file of a record over time: its speeds are exact, its errors white or with a correlation of 0.9 from
/// row to row, and friction backward differs by up to 20 %; the mean of both directions is the law.
fn record(
    random: &mut Random,
    rows: usize,
    fastest: f64,
    noise: f64,
    force: &dyn Fn(f64) -> f64,
) -> (String, String) {
    let mut likely = |share: f64| random.unit() < share;
    let (remembers, both, rests) = (likely(0.5), likely(0.4), likely(0.4));
    let kind = (3.0 * random.unit()) as usize;
    let difference = if both { 0.2 * random.unit() } else { 0.0 };
    let most: f64 = if kind == 1 { 2.0 } else { 20.0 };
    // Every direction has a passage.
    let passes = (most.powf(random.unit()) as usize).min(rows / 30).max(if both { 2 } else { 1 });
    let levels = (8 + (33.0 * random.unit()) as usize).min(rows / passes / 4);
    let slowest = 1e-3 * fastest;
    let each = rows / passes;
    let (mut error, phi) = (random.normal(), if remembers { 0.9_f64 } else { 0.0 });
    let mut text = "t [s],v [m/s],F [N]".to_owned();
    let mut count = 0;
    let mut write = |random: &mut Random, v: f64, f: f64| {
        error = phi * error + (1.0 - phi * phi).sqrt() * random.normal();
        text.push_str(&format!("\n{},{v:.6},{:.3}", 1e-3 * f64::from(count), f + noise * error));
        count += 1;
    };
    for pass in 0..passes {
        let sign = if both && pass % 2 == 1 { -1.0 } else { 1.0 };
        let share = 1.0 + 0.5 * sign * difference;
        if rests && pass > 0 {
            (0..20).for_each(|i| write(random, 0.0, sign * share * force(0.0) * (f64::from(i) + 0.5) / 20.0));
        }
        for i in 0..each {
            let done = (i as f64 + 0.5) / each as f64;
            let up = if pass % 2 == 0 { done } else { 1.0 - done };
            let u = match kind {
                0 => slowest + (fastest - slowest) * up,
                1 => fastest * 100_f64.powf((up * levels as f64).floor() / (levels as f64 - 1.0) - 1.0),
                _ => slowest + (fastest - slowest) * (0.5 * std::f64::consts::PI * up).sin(),
            };
            write(random, sign * u, sign * share * force(u));
        }
    }
    let kind = ["ramps", "staircases", "sweeps"][kind];
    let which = [("remembers, ", remembers), ("both, ", both), ("rests, ", rests)];
    let which: String = which.iter().filter(|(_, is)| *is).map(|(word, _)| *word).collect();
    (format!("{kind} {passes}, {which}"), text)
}
