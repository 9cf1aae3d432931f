//! How often the true answers lie within the 95 % intervals that a machine page states for measured friction:
//!
//! ```text
//! cargo run --release -p slipmap-config --example coverage -- fits|tables CASES [FIRST] [pages]
//! ```
//!
//! Each case is a measurement of a known law, as a rig writes it: 15 to 4,000 rows, even or dense next to rest, with
//! an error of 0.5 to 5 %, and at random repeated, unsorted, in both directions, in mm/s and kN with decimal commas,
//! with readings at rest or standard errors. The answers are read as the program reads them: the critical damping, and
//! with `pages` the critical belt speed and the kick, too, which take seconds a case. One line a case.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use slipmap_config::{Measured, OfMachine, load_machine};
use slipmap_map::assessment::{Assessment, assess, assess_fitted};
use slipmap_map::behaviour::Limit;
use slipmap_map::machine::{Friction, Machine, Motion};
use slipmap_map::risk::{WithError, uncertain_critical_damping};
use slipmap_model::friction::Expression;
use slipmap_model::point::LawParameters;
use slipmap_numbers::random::Random;
use slipmap_simulate::critical::critical_damping;
use slipmap_simulate::sensitivity::influence;

/// The laws: names and falls g.
const LAWS: [(&str, &str, fn(f64) -> f64); 5] = [
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

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments.get(k).and_then(|text| text.parse::<u64>().ok());
    let (Some(what), Some(cases)) = (arguments.first(), number(1)) else {
        return Err("name fits or tables, and the number of cases".into());
    };
    let folder = std::env::temp_dir().join(format!("slipmap-coverage-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let first = number(2).unwrap_or(0);
    let mut counts = [[0_u32; 3]; 3];
    for case in first..first + cases {
        let start = std::time::Instant::now();
        let told = match one(case, what == "fits", number(2).is_some() && arguments.len() > 3, &folder) {
            Err(problem) => format!("no case: {problem}"),
            Ok(answers) => {
                let mut words = answers.words;
                for ((name, true_value, stated), counts) in answers.stated.into_iter().zip(&mut counts) {
                    let Some(expected) = true_value else { continue };
                    let Some(of) = stated else {
                        counts[2] += 1;
                        write!(words, " {name} withheld")?;
                        continue;
                    };
                    let z = (of.value - expected) / of.standard_error;
                    counts[usize::from(z.abs() > NORMAL)] += 1;
                    let relative = of.standard_error / expected;
                    write!(words, " {name} {expected:.4} z {z:.2} se {relative:.3}")?;
                }
                words
            }
        };
        println!("{case} {told} seconds {:.2}", start.elapsed().as_secs_f64());
    }
    for (name, [inside, outside, withheld]) in ["c*", "speed", "kick"].into_iter().zip(counts) {
        let share = 100.0 * f64::from(inside) / f64::from(inside + outside);
        println!("{name}: {share:.1} % of {} within; {withheld} withheld", inside + outside);
    }
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}

/// What is known of one case: the true value and the one stated, by name.
struct Answers {
    words: String,
    stated: [(&'static str, Option<f64>, Option<WithError>); 3],
}

fn one(case: u64, fits: bool, pages: bool, folder: &Path) -> Result<Answers, Box<dyn Error>> {
    let mut random = Random(case.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 50);
    let (name, formula, fall) = LAWS[(case % 5) as usize];
    let far = REST * (0.4 + 0.4 * random.unit());
    let rise = if random.unit() < 0.5 { 0.0 } else { 40.0 * random.unit() };
    let force = |u: f64| far + (REST - far) * fall(u / FALL) + rise * u;
    let mut between = |from: f64, to: f64| from * (to / from).powf(random.unit());
    let (belt_speed, mass) = (FALL * between(0.5, 8.0), between(0.4, 10.0));
    let (rows, noise) = (between(15.0, 4000.0) as usize, REST * between(0.005, 0.05));
    let text = format!("{far} + {}*{} + {rise}*u", REST - far, formula.replace('W', &FALL.to_string()));
    let friction = Friction::Formula(Expression::new(&text, REST)?, LawParameters::new(&[]));
    let machine = |damping: f64| Machine {
        motion: Motion::Translation,
        mass,
        stiffness: STIFFNESS,
        damping,
        normal_force: 1.0,
        normal_force_is_known: false,
        friction: friction.clone(),
        small: false,
        belt_speed,
    };
    let model = machine(0.0).model().ok_or("no model")?;
    let reach = influence(&model.column(), 2)?[1].to * model.si.units.velocity;
    let critical = critical_damping(&model.column(), 1e-9)?.c * model.si.units.damping;
    let hopf = model.column().curve.weakening(model.point.belt_speed) * model.si.units.damping / model.point.epsilon;
    // Steady slip needs a kick between the two limits.
    let damping = if hopf < 0.8 * critical { 0.5 * (hopf.max(0.0) + critical) } else { 0.7 * critical };

    let data = readings(&mut random, rows, 1.5 * reach, noise, &force);
    let csv = folder.join("data.csv");
    std::fs::write(&csv, &data)?;
    let mut law = String::new();
    let friction = if fits {
        let of = OfMachine { motion: None, forces: Some(true) };
        let told = |(problem, _): (String, String)| problem;
        let measured = Measured::read(&csv, Some(of)).map_err(told)?;
        let [in_slip, at_rest] = measured.readings().map_err(told)?;
        let found = slipmap_fit::fits(&in_slip, &at_rest).map_err(|why| format!("{why:?}"))?;
        law = format!("law {}", slipmap_config::words_of(found[0].form));
        measured.to_toml(&found[0])
    } else {
        "[friction]\nlaw = \"table\"\nfile = \"data.csv\"\nquantity = \"force\"\n".into()
    };
    let file = folder.join("machine.toml");
    let quantities =
        format!("mass = {mass}\nstiffness = {STIFFNESS}\nbelt_speed = {belt_speed}\ndamping = {damping}\n");
    std::fs::write(&file, format!("[machine]\n{quantities}{friction}"))?;
    let job = load_machine(&file, &[]).map_err(|error| error.to_string())?;
    if !pages {
        // Rows without errors have them on a page alone.
        let of_page = || assess(&job.machine)?.standard_errors?.critical_damping;
        let found = uncertain_critical_damping(&job.machine, &job.uncertain).or_else(of_page);
        let knots = if let Friction::Measured(table) = &job.machine.friction { table.data().count() } else { 0 };
        let words = format!("{name} {law} rows {rows} knots {knots} noise {:.4} v/v_s {:.2}", noise / REST, belt_speed / FALL);
        return Ok(Answers { words, stated: [("c*", Some(critical), found), ("", None, None), ("", None, None)] });
    }
    let truth = assess(&machine(damping)).ok_or("no assessment")?;
    let all = assess_fitted(&job.machine, &job.uncertain).ok_or("no assessment of the data")?;
    let limit = |of: &Assessment| match of.behaviour.critical_belt_speed {
        Limit::Below(value) => Some(value),
        _ => None,
    };
    let kick = |of: &Assessment| of.kick.map(|kick| kick.forward);
    let errors = all.standard_errors;
    let of_kick = errors.and_then(|errors| errors.kick).zip(kick(&all));
    let words = format!(
        "{name} {law} rows {rows} noise {:.4} v/v_s {:.2} {}",
        noise / REST,
        belt_speed / FALL,
        errors.map_or_else(String::new, |errors| format!("{:?}", errors.from))
    );
    Ok(Answers {
        words,
        stated: [
            ("c*", Some(critical), errors.and_then(|errors| errors.critical_damping)),
            ("speed", limit(&truth), errors.and_then(|errors| errors.critical_belt_speed)),
            ("kick", kick(&truth), of_kick.map(|(relative, value)| WithError { value, standard_error: relative * value })),
        ],
    })
}

/// A file of readings.
fn readings(random: &mut Random, rows: usize, fastest: f64, noise: f64, force: &dyn Fn(f64) -> f64) -> String {
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
    let header = match (german, errors) {
        (false, false) => "v [m/s],F [N]\n",
        (false, true) => "v [m/s],F [N],se [N]\n",
        (true, false) => "Versuch 7\n\nv [mm/s];F [kN]\n",
        (true, true) => "Versuch 7\n\nv [mm/s];F [kN];se [kN]\n",
    };
    let mut text = header.to_owned();
    for [u, f] in data {
        let line = match german {
            false => format!("{u:.6},{f:.3}{}", if errors { format!(",{noise:.3}") } else { String::new() }),
            true => {
                let error = if errors { format!(";{:.6}", 1e-3 * noise) } else { String::new() };
                format!("{:.4};{:.6}{error}", 1e3 * u, 1e-3 * f).replace('.', ",")
            }
        };
        text.push_str(&line);
        text.push('\n');
    }
    text
}
