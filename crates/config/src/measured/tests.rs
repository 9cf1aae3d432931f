//! Files as rigs and spreadsheets write them.

use super::coverage::job;
use super::*;
use slipmap_column::critical_damping;
use slipmap_column::sensitivity::sensitivity;
use slipmap_machine::risk::{WithError, uncertain_critical_damping};
use slipmap_model::friction::{Law, Table};
use slipmap_model::point::{LawParameters, Point};

fn how(machine: OfMachine) -> How {
    How { machine: Some(machine), ..How::default() }
}

const MACHINE: OfMachine = OfMachine { motion: Some(Motion::Translation), forces: None };

fn law(bytes: &[u8], machine: OfMachine) -> Result<Table, (String, String)> {
    Measured::of_bytes("pad.csv", bytes, how(machine))?.table(Level::First)
}

/// Checks what is read of a file, and told of it; `outcome` and `words` as in files.txt.
fn check(name: &str, bytes: &[u8], outcome: &str, words: &[&str]) {
    let found = law(bytes, MACHINE);
    let mut outcome = outcome.split(' ');
    let kind = outcome.next().unwrap();
    let told = match &found {
        Err((problem, remedy)) => format!("{problem}\n{remedy}"),
        Ok(table) => table.source().told.clone().unwrap_or_default(),
    };
    assert_eq!(found.is_err(), kind == "refused", "{name}: {found:?}");
    assert!(words.iter().all(|word| told.contains(word)), "{name}: {told}");
    let Ok(table) = found else { return };
    assert!(!words.is_empty() || told.is_empty(), "{name}: {told}");
    assert_eq!(table.source().forces, kind == "forces", "{name}");
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut rows: Vec<(f64, f64)> =
        outcome.filter_map(|row| row.split_once(':')).map(|(u, f)| (number(u), number(f))).collect();
    if rows.is_empty() {
        let unit = if kind == "forces" { 1000.0 } else { 1.0 };
        rows = [(0.0, 0.4), (0.1, 0.35), (0.5, 0.3)].map(|(u, f)| (u, unit * f)).into();
    }
    let data: Vec<(f64, f64)> = table.data().collect();
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs().max(1e-3);
    let same = data.iter().zip(&rows).all(|(a, b)| near(a.0, b.0) && near(a.1, b.1));
    assert!(same && data.len() == rows.len(), "{name}: {data:?}");
}

#[test]
fn ugly_files_are_read_or_refused_with_their_line() {
    let cases = include_str!("files.txt").lines().filter(|line| !line.starts_with('#'));
    for case in cases {
        let [name, outcome, text, words] = case.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("{case}")
        };
        let words: Vec<&str> = words.split(" & ").filter(|word| *word != "nothing").collect();
        check(name, text.replace("\\n", "\n").replace("\\t", "\t").as_bytes(), outcome, &words);
    }
}

#[test]
fn files_in_any_encoding_are_read_or_refused() {
    let plain = "v [m/s],mu\n0,0.4\n0.1,0.35\n0.5,0.3\n";
    let wide = |bytes_of: fn(u16) -> [u8; 2]| -> Vec<u8> {
        [0xfeff].into_iter().chain(plain.encode_utf16()).flat_map(bytes_of).collect()
    };
    let latin = "v [m/s];µ [-]\n0;0,4\n0,1;0,35\n0,5;0,3".chars();
    for (name, bytes, outcome, words) in [
        ("UTF-8", plain.into(), "coefficients", &[][..]),
        ("mark of UTF-8", format!("\u{feff}{plain}").into(), "coefficients", &[]),
        ("UTF-16", wide(u16::to_le_bytes), "coefficients", &["UTF-16LE"]),
        ("UTF-16, big end first", wide(u16::to_be_bytes), "coefficients", &["UTF-16BE"]),
        ("Latin-1", latin.map(|c| c as u8).collect(), "coefficients", &["windows-1252"]),
        (
            "Windows-1252",
            b"v [m/s];\xb5 \x93pad\x94 \x80\n0;0,4\n0,1;0,35\n0,5;0,3".into(),
            "coefficients",
            &["windows-1252"],
        ),
        (
            "UTF-16, half a letter more",
            [wide(u16::to_le_bytes), vec![7]].concat(),
            "refused",
            &["not a text"],
        ),
        (
            "UTF-16, half of a pair",
            wide(|c| if c == 48 { [0, 0xd8] } else { c.to_le_bytes() }),
            "refused",
            &["not a text"],
        ),
        ("Windows", plain.replace('\n', "\r\n").into(), "coefficients", &[]),
        ("old Macintosh", plain.replace('\n', "\r").into(), "coefficients", &[]),
        ("a workbook", b"PK\x03\x04 and more".to_vec(), "refused", &["spreadsheet", "save it as CSV"]),
        ("no text", vec![0, 1, 2, 255, 254, 0, 7], "refused", &["not a text"]),
        ("empty", Vec::new(), "refused", &["no row has two numbers"]),
    ] {
        check(name, &bytes, outcome, words);
    }
}

/// Columns that are chosen by name or number.
#[test]
fn columns_are_chosen_by_name_or_number() {
    let text = "t [s],v1 [mm/s],v2 [mm/s],F_1 [N],\"F, 2 [N]\"\n0,0,9,400,4\n1,100,8,350,3\n2,500,7,300,2\n";
    let of = |text: &str, column: &str| {
        let how = How::named(None, None, Some(column))?.of(Some(MACHINE));
        let data: Vec<(f64, f64)> =
            Measured::of_bytes("rig.csv", text.as_bytes(), how)?.table(Level::First)?.data().collect();
        Ok::<_, (String, String)>(data)
    };
    let expected = vec![(0.0, 400.0), (0.1, 350.0), (0.5, 300.0)];
    let header_less = text.split_once('\n').unwrap().1;
    for column in ["speed=v1,friction=F_1", "speed=V1 [mm/s], friction=F_1 [N]", "speed=2,friction=4"] {
        assert_eq!(of(text, column).unwrap(), expected, "{column}");
    }
    assert_eq!(of(header_less, "speed=2,friction=4").unwrap()[1], (100.0, 350.0));
    for (column, problem) in [
        ("speed=v3", "no column of numbers has the name `v3`; there are t [s], v1 [mm/s], v2"),
        ("pace=v1", "`pace=v1` chooses no column"),
        ("speed=v1", "`F_1 [N]` and `F, 2 [N]` may both be the friction"),
    ] {
        let (found, remedy) = of(text, column).unwrap_err();
        assert!(
            found.contains(problem) && remedy.contains("NAME") | remedy.contains("names"),
            "{found} {remedy}"
        );
    }
}

/// Positions over time, rounded as encoders write them, are the record of the speeds that they have, with a wider curve.
#[test]
fn positions_stand_for_speeds() {
    let stated = |step: f64| {
        let mut text = "t [ms],x [mm],F [N]\n".to_owned();
        for i in 0..4000 {
            let t = 1e-3 * f64::from(i);
            let (v, x) = (0.3 * (2.0 * t).sin(), 0.15 * (1.0 - (2.0 * t).cos()));
            let force = v.signum() * friction(v.abs());
            text.push_str(&format!("{i},{},{force:.3}\n", 1e3 * (x / step).round() * step));
        }
        let table = law(text.as_bytes(), MACHINE).unwrap();
        let told = table.source().told.clone().unwrap();
        assert!(
            told.contains("speeds are slopes of `x [mm]` over") && told.contains("a record over time"),
            "{told}"
        );
        stated(&text, "")
    };
    let [fine, coarse] = [1e-8, 2e-5].map(stated);
    for found in [fine, coarse] {
        assert!((found.value - truth()).abs() < 2.0 * found.standard_error, "{found:?} {}", truth());
    }
    assert!(
        fine.standard_error < 0.02 * truth() && coarse.standard_error > fine.standard_error,
        "{fine:?} {coarse:?}"
    );
}

/// Too few readings, and friction of the wrong sign, are the reasons that are given where no law follows from the readings.
#[test]
fn what_cannot_be_fitted_says_why() {
    let why = |rows: &str| {
        let fits = Measured::of_bytes("rig.csv", format!("v [m/s],{rows}").as_bytes(), how(MACHINE))
            .unwrap()
            .fits(None);
        fits.err().map(|(problem, remedy)| format!("{problem}; {remedy}"))
    };
    let five = "F [N]\n0.01,5\n0.02,4.1\n0.03,3.6\n0.05,3.21\n0.1,3.01\n";
    assert_eq!(
        why(five).unwrap(),
        "rig.csv: there are too few slip speeds; give at least 6 readings in slip"
    );
    // Readings at rest are one more, as are standard errors.
    assert_eq!(why(&format!("{five}0.2,3\n")), None);
    assert_eq!(why(&format!("{five}0,6.5\n0,6.5\n")), None);
    assert_eq!(why("F [N],se\n0.01,5,.1\n0.02,4.1,.1\n0.03,3.6,.1\n0.05,3.21,.1\n0.1,3.01,.1\n"), None);
    let negative = why("F [N]\n0.01,-5\n0.02,-4.1\n0.03,-3.6\n0.05,-3.21\n0.1,-3.01\n0.2,-3\n").unwrap();
    assert!(negative.contains("friction is negative at every slip speed; check the sign"), "{negative}");
}

/// Friction that does not fall is an answer; exact coefficients at rest and in slip are those, and nothing more.
#[test]
fn laws_that_do_not_fall_are_answers() {
    let of = |rows: &str| {
        let measured =
            Measured::of_bytes("rig.csv", format!("v [m/s],F [N]\n{rows}").as_bytes(), how(MACHINE)).unwrap();
        let fits = measured.fits(None).unwrap();
        let chosen = fits.chosen();
        (words_of(chosen.form), chosen.values.clone(), chosen.at_rest, measured.no_stick_slip(chosen))
    };
    let (law, values, _, told) = of("0.01,3.02\n0.02,3.09\n0.03,3.16\n0.05,3.24\n0.1,3.51\n0.2,4\n0.3,4.5\n");
    assert!(law == "constant, viscous" && (values[1] - 5.0).abs() < 0.3, "{law} {values:?}");
    let told = told.unwrap();
    assert!(told.contains("rises with the slip speed by 5.0") && told.contains("no stick-slip"), "{told}");
    let level: String = (1..=12).map(|i| format!("{},3\n", 0.02 * f64::from(i))).collect();
    let (law, values, at_rest, told) = of(&format!("0,4\n{level}"));
    assert_eq!(
        (law.as_str(), &values[..], at_rest, told),
        ("two coefficients", &[3.0][..], Some([4.0, 0.0]), None)
    );
    let (law, values, _, told) = of(&level);
    assert!(law == "constant" && values == [3.0] && told.unwrap().contains("neither falls nor drops"));
    // Constant in each direction, which differ, it is the mean.
    let both = level.lines().map(|row| format!("{row}\n-{}\n", row.replace(",3", ",-2"))).collect::<String>();
    let (law, values, ..) = of(&both);
    assert!(law == "constant" && (values[0] - 2.5).abs() < 1e-5, "{law} {values:?}");
    // Six rows that fall are no constant friction.
    let (law, ..) = of("0.01,3.5\n0.02,3.36\n0.04,3.24\n0.08,3.16\n0.16,3.13\n0.32,3.12\n");
    assert!(!law.contains("constant"), "{law}");
}

/// Forces over a normal force are a law in coefficients, for machines with any normal force; without it several normal forces
/// are refused, and one is told.
#[test]
fn normal_forces_are_not_lost() {
    let rows: String = (1..=12)
        .map(|i| 0.02 * f64::from(i))
        .map(|u| format!("{u},{}\n", 0.3 + 0.2 * (-u / 0.05).exp() + 1e-4 * (40.0 * u).sin()))
        .collect();
    let read =
        || Measured::of_bytes("rig.csv", format!("v [m/s],F [kN]\n{rows}").as_bytes(), how(MACHINE)).unwrap();
    let forces = read();
    let fit = forces.fits(None).unwrap();
    let coefficients = read().over("2 kN").unwrap();
    let same = coefficients.fits(None).unwrap();
    assert!((same.chosen().values[0] * 2000.0 / fit.chosen().values[0] - 1.0).abs() < 1e-6);
    let config = |normal: &str| {
        format!("[machine]\nmass = 1.0\nstiffness = 1e4\ndamping = 1.0\nbelt_speed = 0.1\n{normal}\n")
    };
    let of = |measured: &Measured, fits: &Fits, normal: &str| {
        measured.into_configuration(fits.chosen(), &config(normal))
    };
    let (text, _) = of(&coefficients, &same, "normal_force = [1e3, 2e3]").unwrap();
    assert!(text.contains("normal_force = [1e3, 2e3]") && text.contains("mu_k"), "{text}");
    assert!(of(&coefficients, &same, "").unwrap().0.contains("normal_force = 2000.0"));
    let (problem, remedy) = of(&forces, &fit, "normal_force = [1e3, 2e3]").unwrap_err();
    assert!(
        problem.contains("normal_force is more than one number") && remedy.contains("--normal-force"),
        "{problem}"
    );
    assert_eq!(of(&forces, &fit, "normal_force = 2e3").unwrap().1, "normal_force = 2e3");
    assert!(coefficients.over("2 kN").is_err() && read().over("2 m").is_err() && read().over("0").is_err());
}

/// Means of repeated readings have errors by the scatter of all about them; of rows written twice there is none.
#[test]
fn repeated_readings_become_means_with_errors() {
    let of = |rows: &str| {
        let text = format!("v [m/s],mu\n{rows}");
        let measured = Measured::of_bytes("rig.csv", text.as_bytes(), how(MACHINE)).unwrap();
        measured.averaged(&measured.at_rest).iter().map(|row| [row.friction, row.error]).collect::<Vec<_>>()
    };
    // Squares about the means: 2 (0.01)^2 at rest, 2 (0.02)^2 of the last; three readings more than means.
    let sd = (1e-3_f64 / 3.0).sqrt();
    let found = of("0,0.41\n0,0.39\n0.1,0.3\n0.5,0.22\n0.5,0.2\n0.5,0.18\n");
    for ([mean, error], (expected, count)) in found.iter().zip([(0.4, 2.0_f64), (0.3, 1.0), (0.2, 3.0)]) {
        assert!(
            (mean - expected).abs() < 1e-15 && (error * count.sqrt() / sd - 1.0).abs() < 1e-12,
            "{found:?}"
        );
    }
    for rows in ["0,0.4\n0.1,0.3\n0.1,0.3\n0.5,0.2\n", "0,0.4\n0.1,0.3\n0.5,0.2\n"] {
        let found = of(rows);
        assert!(found[1][0] == 0.3 && found.iter().all(|row| row[1].is_nan()), "{found:?}");
    }
}

/// Friction at rest of two directions is the mean of theirs, which scatter alike; one reading in each does not say its error.
#[test]
fn friction_at_rest_has_the_error_that_readings_say() {
    let read = |rest: &str| {
        let rows: String = (1..=12).map(|i| format!("{i}e-2,3\n-{i}e-2,-2\n")).collect();
        Measured::of_bytes("rig.csv", format!("v [m/s],F [N]\n{rows}{rest}").as_bytes(), how(MACHINE))
            .unwrap()
    };
    let of = |rest: &str| {
        let measured = read(rest);
        measured.at_breakaway(&measured.at_rest, 0.5).unwrap()
    };
    let variance = 2.0 * slipmap_fit::widening(1.0);
    let [friction, error] = of("0,10\n0,12\n0,-9\n");
    assert!(friction == 10.0 && (error / (0.25 * variance * 1.5).sqrt() - 1.0).abs() < 1e-12, "{error}");
    assert_eq!(of("0,10\n0,-9\n"), [9.5, 0.5 * 0.5_f64.sqrt()]);
    let told = |rest: &str| {
        let measured = read(rest);
        let fits = measured.fits(None).unwrap();
        (fits.chosen().at_rest.is_some(), measured.error_at_rest(fits.chosen()))
    };
    assert_eq!(told("0,10\n0,-9\n"), (true, None));
    assert!(told("0,10\n0,10.1\n0,-9\n").1.is_some());
}

/// Without a row at rest the first datum moves with the two slowest rows, also where it is less than the friction at rest:
/// the standard error is that of the critical dampings of files whose rows are moved. Below the line friction at rest is
/// exact.
#[test]
fn a_law_that_begins_on_a_line_moves_with_the_two_slowest_rows() {
    // Too few to be reduced to a curve.
    let speeds: [f64; 7] = [0.0003, 0.006, 0.015, 0.03, 0.06, 0.2, 0.6];
    let friction = speeds.map(|u| 700.0 + 500.0 * (-u / 0.015).exp());
    // So small that all is of first order.
    let error = 1e-3;
    let read = |friction: &[f64], level: Level| {
        let rows = speeds.iter().zip(friction).map(|(u, force)| format!("{u},{force},{error}\n"));
        let text = format!("v,F [N],se\n{}", rows.collect::<String>());
        Measured::of_bytes("pad.csv", text.as_bytes(), how(MACHINE)).unwrap().table(level).unwrap()
    };
    let column = |table: Table| {
        let law = Law::Table(table);
        law.column(&Point { epsilon: 1.0, damping: 0.0, belt_speed: 0.0015, law: LawParameters::new(&[]) })
    };
    for level in [Level::First, Level::Given(1300.0)] {
        let table = read(&friction, level);
        let of = |table: Table| sensitivity(&column(table)).unwrap().standard_error.unwrap().value;
        let of_curve = of(table.with_standard_errors(&[0.0; 8]).unwrap());
        let found = (of(table.clone()).powi(2) - of_curve.powi(2)).sqrt();
        let by_row = |row: usize| {
            let at = |moved: f64| {
                let mut friction = friction;
                friction[row] += moved;
                critical_damping(&column(read(&friction, level)), 1e-12).unwrap().c
            };
            (at(0.1) - at(-0.1)) / 0.2
        };
        let expected = error * (0..7).map(|row| by_row(row).powi(2)).sum::<f64>().sqrt();
        // Three deviations of the one of 4,096 draws.
        assert!((found / expected - 1.0).abs() < 3.0 / f64::sqrt(2.0 * 4096.0), "{found} {expected}");
        let mut random = slipmap_numbers::random::Random(2);
        let drawn: Vec<(f64, f64)> = table.drawn(|| random.normal()).unwrap().data().take(3).collect();
        let [rest, near, far] = drawn[..] else { panic!("{drawn:?}") };
        let line = near.1 + near.0 / (far.0 - near.0) * (near.1 - far.1);
        assert!((rest.1 - line).abs() < 1e-12 * line && near.1 != friction[0], "{drawn:?}");
    }
    assert_eq!(read(&friction, Level::Given(1190.0)).standard_errors().unwrap()[0], 0.0);
}

/// Steady friction with a true critical damping, of a machine at 0.03 m/s.
fn friction(u: f64) -> f64 {
    15.0 + 12.0 * (-u / 0.03).exp() + 40.0 * u
}

const MASS_SPEED_DAMPING: [f64; 3] = [24.7, 0.03, 80.0];

/// The critical damping that is stated for a file, with what is added to [friction].
fn stated(rig: &str, more: &str) -> WithError {
    let friction = format!("[friction]\nlaw = \"table\"\nfile = \"rig.csv\"\n{more}");
    let machine = job(&friction, MASS_SPEED_DAMPING, rig).unwrap().machine;
    uncertain_critical_damping(&machine, &[]).unwrap()
}

/// The true one.
fn truth() -> f64 {
    let text =
        "[friction]\nlaw = \"expression\"\nquantity = \"force\"\nphi = \"15 + 12*exp(-u/0.03) + 40*u\"";
    let model = job(text, MASS_SPEED_DAMPING, "").unwrap().machine.model().unwrap();
    critical_damping(&model.column(), 1e-9).unwrap().c * model.si.damping
}

/// Exact staircases and ramps up and down, as records and as tables, in any order, and with a column that is not used: the
/// critical damping is the true one within a few thousandths.
#[test]
fn exact_readings_have_the_true_critical_damping() {
    let stair = |i: usize| 0.005 * 128_f64.powf((i / 8) as f64 / 7.0);
    let ramp = |i: usize| 0.6 - 0.6 * (i as f64 / 200.0 - 1.0).abs() + 1e-3;
    let speeds: [Vec<f64>; 2] = [(0..64).map(stair).collect(), (0..400).map(ramp).collect()];
    for speeds in speeds {
        let count = speeds.len();
        let row = |i: usize| format!("{:.5},{:.4}", speeds[i], friction(speeds[i]));
        let with_time: String = (0..count).map(|i| format!("{:.2},{}\n", 0.01 * i as f64, row(i))).collect();
        let table: String = (0..count).map(|i| format!("{}\n", row(i))).collect();
        let mixed: String = (0..count).map(|i| format!("{},21\n", row(27 * i % count))).collect();
        let record = stated(&format!("t [s],v [m/s],F [N]\n{with_time}"), "");
        let [table, mixed] =
            [("", table), (",T [°C]", mixed)].map(|(more, rows)| format!("v [m/s],F [N]{more}\n{rows}"));
        let (table, mixed) = (stated(&table, "kind = \"curve\""), stated(&mixed, ""));
        assert!((table.value - mixed.value).abs() < 1e-6 * table.standard_error, "{table:?} {mixed:?}");
        for found in [record, table] {
            let off = (found.value - truth()).abs();
            assert!(
                off < 2.0 * found.standard_error && found.standard_error < 2e-3 * truth(),
                "{found:?} {}",
                truth()
            );
        }
    }
}

/// The law of exact readings is found in a record of eight speeds, too, where the curve between them is not known.
#[test]
fn the_law_of_an_exact_staircase_is_found() {
    let row = |i: usize| {
        let u = 0.005 * 128_f64.powf((i / 8) as f64 / 7.0);
        format!("{:.2},{u:.5},{:.4}\n", 0.01 * i as f64, friction(u))
    };
    let text = format!("t [s],v [m/s],F [N]\n{}", (0..64).map(row).collect::<String>());
    let measured = Measured::of_bytes("rig.csv", text.as_bytes(), how(MACHINE)).unwrap();
    let fits = measured.fits(None).unwrap();
    let fit = fits.chosen();
    assert_eq!(words_of(fit.form), "exponential, viscous");
    for ((value, error), truth) in fit.values.iter().zip(fit.errors()).zip([27.0, 15.0, 0.03, 40.0]) {
        assert!((value - truth).abs() < 2.0 * error && error < 2e-3 * truth, "{value} {error} {truth}");
    }
}

/// A column of times of rows that are sorted by speed is none of a record; rows of one speed 1 % apart tell no more than
/// those of one speed.
#[test]
fn what_says_nothing_changes_nothing() {
    let mut random = slipmap_numbers::random::Random(11);
    let mut outside = 0;
    for _ in 0..8 {
        let (mut with_time, mut without, mut apart) = (String::new(), String::new(), String::new());
        for i in 0..70 {
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            let v = sign * 0.002 * 300_f64.powf(f64::from(i) / 69.0);
            let force = sign * friction(v.abs()) * (1.0 + 0.01 * random.normal());
            without.push_str(&format!("{v:.4},{force:.3}\n"));
            with_time.push_str(&format!("{},{v:.4},{force:.3}\n", 30 * i));
            let v = 0.004 * 150_f64.powf(f64::from(i / 2) / 34.0) * if i % 2 == 0 { 1.0 } else { 1.01 };
            apart.push_str(&format!("{v:.5},{:.3}\n", friction(v) * (1.0 + 0.01 * random.normal())));
        }
        let one = stated(&format!("t [s],v [m/s],F [N]\n{with_time}"), "");
        let other = stated(&format!("v [m/s],F [N]\n{without}"), "");
        assert_eq!(one, other);
        let apart = stated(&format!("v [m/s],F [N]\n{apart}"), "");
        for found in [one, apart] {
            outside += usize::from((found.value - truth()).abs() > 1.96 * found.standard_error);
        }
    }
    // Of 16 independent intervals of 95 % more are outside in 4 of 100 samples.
    assert!(outside <= 2, "{outside}");
}

/// Directions at slightly different speeds make no slope; each is taken for itself on demand.
#[test]
fn directions_are_taken_each_for_itself() {
    let rows: String = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32]
        .map(|u| {
            let back = u + 1e-4;
            format!("{u:.4},{:.3}\n-{back:.4},-{:.3}\n", friction(u), 0.99 * friction(back))
        })
        .concat();
    let of = |more: &str| stated(&format!("v [m/s],F [N]\n{rows}"), more);
    let mean = of("");
    assert!((mean.value - 0.995 * truth()).abs() < 2.0 * mean.standard_error, "{mean:?} {}", truth());
    assert!(mean.standard_error < 2e-3 * truth(), "{mean:?}");
    let many = |back: f64| {
        let row = |i: i32| {
            let u = 0.4 * (f64::from(i) / 12.0).powi(2);
            format!("{u:.5},{:.4}\n-{:.5},-{:.4}\n", friction(u), 0.997 * u, back * friction(0.997 * u))
        };
        format!("v [m/s],F [N]\n{}", (1..=12).map(row).collect::<String>())
    };
    for (direction, share) in [("forward", 1.0), ("backward", 0.8), ("mean", 0.9)] {
        let found = stated(&many(0.8), &format!("direction = \"{direction}\""));
        assert!((found.value - share * truth()).abs() < 2.0 * found.standard_error, "{direction} {found:?}");
        assert!(found.standard_error < 4e-3 * truth(), "{direction} {found:?}");
    }
}
