//! Files as rigs and spreadsheets write them.

use super::*;
use slipmap_model::friction::Table;

/// What a file is.
enum Outcome {
    /// A law with these rows, of which the friction is a force if the flag is set; and words of what is told.
    Read(&'static [(f64, f64)], bool, &'static [&'static str]),
    /// Refused with these words in the problem and the remedy.
    Refused(&'static [&'static str]),
}
use Outcome::{Read, Refused};

const MACHINE: OfMachine = OfMachine { motion: Some(Motion::Translation), forces: None };
const THREE: &[(f64, f64)] = &[(0.0, 0.4), (0.1, 0.35), (0.5, 0.3)];
const NEWTONS: &[(f64, f64)] = &[(0.0, 400.0), (0.1, 350.0), (0.5, 300.0)];

fn law(bytes: &[u8], machine: OfMachine) -> Result<Table, (String, String)> {
    Measured::of_bytes("pad.csv", bytes, Some(machine))?.table(Level::First)
}

fn wide(text: &str, mark: bool, bytes_of: fn(u16) -> [u8; 2]) -> Vec<u8> {
    mark.then_some(0xfeff).into_iter().chain(text.encode_utf16()).flat_map(bytes_of).collect()
}

#[test]
fn ugly_files_are_read_or_refused_with_their_line() {
    let plain = "v,mu\n0,0.4\n0.1,0.35\n0.5,0.3\n";
    let text = |text: &str| text.as_bytes().to_vec();
    let latin = |text: &str| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<u8>>();
    /// A name, what a file contains, and words that are told of it.
    type Texts = &'static [(&'static str, &'static str, &'static [&'static str])];
    let coefficients: Texts = &[
        ("no header", "0,0.4\n0.1,0.35\n0.5,0.3", &["no header: slip speed in column 1"]),
        ("semicolons", "v;mu\n0;0.4\n0.1;0.35\n0.5;0.3", &["semicolons"]),
        ("decimal commas", "v;mu\n0;0,4\n0,1;0,35\n0,5;0,3", &["decimal commas"]),
        ("quoted commas", "\"0\",\"0,4\"\n\"0,1\",\"0,35\"\n\"0,5\",\"0,3\"", &["commas"]),
        ("tabs", "v\tmu\n0\t0,4\n0,1\t0,35\n0,5\t0,3", &["tabs", "decimal commas"]),
        ("spaces", "  0   0.4\n  0.1 0.35\n  0.5 0.3", &["spaces"]),
        ("bars", "v|mu\n0|0.4\n0.1|0.35\n0.5|0.3", &["bars"]),
        ("mm/s", "v [mm/s],mu\n0,0.4\n100,0.35\n500,0.3", &["slip speeds in mm/s"]),
        ("per cent", "v,mu [%]\n0,40\n0.1,35\n0.5,30", &["friction in %"]),
        ("empty columns", "v,mu,,\n0,0.4,,\n0.1,0.35,,\n0.5,0.3,,", &[]),
        ("remarks", "v,mu,remark\n0,0.4,cold\n0.1,0.35,\n0.5,0.3,warm", &[]),
        ("temperature", "v [m/s],mu,T [°C]\n0,0.4,20\n0.1,0.35,21\n0.5,0.3,22", &["`T [°C]` not used"]),
        (
            "other order",
            "mu,n,v\n0.4,3,0\n0.35,3,0.1\n0.3,3,0.5",
            &["slip speed in column 3, friction in column 1", "`n` not used"],
        ),
        ("downward", "v,mu\n0.5,0.3\n0.1,0.35\n0,0.4", &["sorted"]),
        ("a static row", "v,mu\nstatic,0.4\n0.1,0.35\n0.5,0.3", &[]),
        ("readings of breakaway", "v,mu\n0,0.41\n0,0.4\n0,0.39\n0.1,0.35\n0.5,0.3", &[]),
        (
            "gaps",
            "v,mu\n0,0.4\n0.1,0.35\n0.2,NaN\n0.3,\n0.5,0.3",
            &["2 rows without numbers left out (lines 4, 5)"],
        ),
        ("minus signs", "v,mu\n0,0.4\n−0.1,0.35\n−0.5,0.3", &["negative"]),
        ("Fortran", "0.0D0 4.0D-1\n1.0D-1 3.5D-1\n5.0D-1 3.0D-1", &["spaces"]),
        (
            "errors of a spreadsheet",
            "v,mu\n0,0.4\n0,#DIV/0!\n0.1,0.35\n0.1,#N/A\n0.2,#WERT!\n0.5,0.3",
            &["3 rows without numbers left out (lines 3, 5, 6)"],
        ),
        (
            "dates",
            "Rig;1.2\nDatum;v;mu\n26.11.2026;0;0,4\n26.11.2026;0,1;0,35\n27.11.2026;0,5;0,3",
            &["decimal commas", "slip speed in column 2"],
        ),
        (
            "LabVIEW",
            "LabVIEW Measurement\n***End_of_Header***\nSamples\t3\t3\n***End_of_Header***\nX\tv\tmu\n0\t0\t0.4\n1\t0.1\t0.35\n2\t0.5\t0.3",
            &["slip speed in column 2"],
        ),
        (
            "few rows with their times",
            "t [min],v,mu\n0,0,0.4\n5,0.1,0.35\n10,0.5,0.3",
            &["slip speed in column 2"],
        ),
        (
            "a column of numbers without a name before the others",
            ",v,mu\n0,0,0.4\n1,0.1,0.35\n2,0.5,0.3",
            &["column 1 not used"],
        ),
    ];
    let forces: Texts = &[
        ("kN", "v [m/s],F [kN]\n0,0.4\n0.1,0.35\n0.5,0.3", &["friction in kN"]),
        ("units in a line of their own", "v;F\n[mm/s];[kN]\n0;0,4\n100;0,35\n500;0,3", &["mm/s", "kN"]),
        (
            "titles",
            "Rig 7, pad B\nMeasured on a Tuesday\n\nspeed (mm/s),force (N)\n0,400\n100,350\n500,300",
            &["mm/s"],
        ),
        (
            "normal force beside",
            "v [m/s],F_n [N],F_t [N]\n0,1000,400\n0.1,1000,350\n0.5,1000,300",
            &["`F_n [N]` not used"],
        ),
        ("negative speeds", "v,F [N]\n0,-400\n-0.1,-350\n-0.5,-300", &["slip is negative in all rows"]),
        (
            "both directions",
            "v,F [N]\n-0.5,-310\n-0.1,-360\n0,400\n0.1,340\n0.5,290",
            &["both directions", "106 %"],
        ),
        ("units after a stroke", "v / mm·s⁻¹,F / N\n0,400\n100,350\n500,300", &["mm·s⁻¹"]),
        ("units in names", "speed_mps,force_N\n0,400\n0.1,350\n0.5,300", &[]),
        (
            "files joined",
            "v,F\nm/s,N\n0,400\n0.1,350\nv,F\nm/s,N\n0.5,300",
            &["2 rows without numbers left out (lines 5, 6)"],
        ),
    ];
    let refused: Texts = &[
        (
            "a row at the beginning",
            "v,mu\n0,0.4?\n0.1,0.35\n0.5,0.3\n1,0.3",
            &["pad.csv:2", "`0,0.4?` is not a pair"],
        ),
        (
            "logarithms",
            "log10(v),mu\n-2,0.4\n-1,0.35\n0,0.3",
            &["pad.csv:1", "`log10(v)`, a logarithm", "themselves"],
        ),
        (
            "units beside numbers",
            "v,F\n0 m/s,400 N\n0.1 m/s,350 N\n0.5 m/s,300 N",
            &["no row has two numbers", "units belong into the header"],
        ),
        (
            "thousands or decimals",
            "v;F [N]\n0;1,400\n1;1,350\n2;1,300",
            &["pad.csv:2: `1,400`", "thousands or decimals", "write 1400 or 1.400"],
        ),
        (
            "two decimal signs",
            "v;mu\n0;0.4\n0,1;0,35\n0,5;0,3",
            &["pad.csv:3", "`0.4` in line 2 has a decimal point"],
        ),
        (
            "commas for both",
            "v,mu\n0,0,0,4\n0,1,0,3\n0,5,0,3",
            &["pad.csv:2", "column 3, and the header names 2", "decimal commas"],
        ),
        (
            "commas between thousands",
            "v [m/s],F [N]\n0,940\n0.01,1,234\n0.1,930\n0.2,920",
            &["pad.csv:3", "column 3, and the header names 2", "separate thousands, leave them out"],
        ),
        (
            "spaces between thousands",
            "v F\n0 1 234\n0.1 1 200\n0.2 920",
            &["pad.csv:2", "column 3, and the header names 2"],
        ),
        (
            "three columns",
            "0,0.4,0.01\n0.1,0.35,0.01\n0.5,0.3,0.01",
            &["pad.csv", "three columns", "speed,friction,se", "time,speed,friction"],
        ),
        ("four columns", "0,0.4,1,2\n0.1,0.35,1,2\n0.5,0.3,1,2", &["4 columns", "name them"]),
        (
            "two speeds",
            "v1 speed,v2 speed,mu\n0,0,0.4\n1,1,0.3\n2,2,0.3",
            &["pad.csv:1", "both be the slip speed"],
        ),
        ("furlongs", "v [furlongs/week],mu\n0,0.4\n1,0.3\n2,0.3", &["pad.csv:1", "no unit that is known"]),
        ("rotation", "rpm,mu\n0,0.4\n1,0.3\n2,0.3", &["pad.csv:1", "in rpm", "read in m/s"]),
        (
            "standard deviations",
            "v,mu,sd\n0,0.4,0.01\n1,0.3,0.01\n2,0.3,0.01",
            &["pad.csv:1", "standard deviation", "square root"],
        ),
        (
            "errors in some rows",
            "v,mu,se\n0,0.4,0.01\n1,0.3,\n2,0.3,0.01",
            &["pad.csv:3", "no standard error", "in every row"],
        ),
        (
            "a negative error",
            "v,mu,se\n0,0.4,0.01\n1,0.3,-1\n2,0.3,0.01",
            &["pad.csv:3", "-1 is not a valid"],
        ),
        ("words", "v,mu\n0,0.4\n0.1,x\n0.5,0.3\n1,0.3\n2,0.3", &["pad.csv:3", "`0.1,x` is not a pair"]),
        (
            "the force while it sticks",
            "v,F [N]\n0,20\n0,60\n0,100\n0.1,90\n0.5,80",
            &["pad.csv:2", "goes from 20 to 100", "breaks loose"],
        ),
        ("too few", "v,mu\n0,0.4\n1,0.3", &["only 2 data", "at least three"]),
        ("one column", "0.4\n0.35\n0.3", &["pad.csv", "no row has two numbers"]),
    ];
    let mut files: Vec<(&str, Vec<u8>, Outcome)> = vec![
        ("plain", text(plain), Read(THREE, false, &[])),
        ("mark of UTF-8", text(&format!("\u{feff}{plain}")), Read(THREE, false, &[])),
        ("UTF-16", wide(plain, true, u16::to_le_bytes), Read(THREE, false, &["UTF-16LE"])),
        ("UTF-16, big end first", wide(plain, true, u16::to_be_bytes), Read(THREE, false, &["UTF-16BE"])),
        ("UTF-16 without mark", wide(plain, false, u16::to_le_bytes), Read(THREE, false, &["UTF-16LE"])),
        ("Latin-1", latin("v [m/s];µ [-]\n0;0,4\n0,1;0,35\n0,5;0,3"), Read(THREE, false, &["windows-1252"])),
        ("Windows", text(&plain.replace('\n', "\r\n")), Read(THREE, false, &[])),
        ("old Macintosh", text(&plain.replace('\n', "\r")), Read(THREE, false, &[])),
        (
            "directions at other speeds",
            text("v,F [N]\n-0.25,-350\n0,400\n0.1,380\n0.3,340"),
            Read(&[(0.0, 400.0), (0.1, 380.0), (0.25, 350.0), (0.3, 340.0)], true, &["100 %"]),
        ),
        (
            "no row at rest",
            text("v,mu\n0.1,0.38\n0.2,0.36\n0.5,0.3"),
            Read(
                &[(0.0, 0.4), (0.1, 0.38), (0.2, 0.36), (0.5, 0.3)],
                false,
                &["no row at rest", "begins at 0.4"],
            ),
        ),
        (
            "thousands",
            text("v [mm/s];F [N]\n0;1.400,5\n100;1.350,5\n1.500;1.300,5"),
            Read(&[(0.0, 1400.5), (0.1, 1350.5), (1.5, 1300.5)], true, &["decimal commas"]),
        ),
        (
            "thousands apart",
            text("v [mm/s];F [N]\n0;1 400,5\n100;1'350,5\n1500;1300,5"),
            Read(&[(0.0, 1400.5), (0.1, 1350.5), (1.5, 1300.5)], true, &["decimal commas"]),
        ),
        (
            "forces without a unit",
            text("v,F\n0,400\n0.1,350\n0.5,300"),
            Read(NEWTONS, false, &["no unit and is read as a coefficient"]),
        ),
        ("a workbook", b"PK\x03\x04 and more".to_vec(), Refused(&["spreadsheet", "save it as CSV"])),
        ("no text", vec![0, 1, 2, 255, 254, 0, 7], Refused(&["not a text"])),
        ("empty", Vec::new(), Refused(&["no row has two numbers"])),
    ];
    let of = |texts: Texts, outcome: fn(&'static [&'static str]) -> Outcome| {
        texts.iter().map(move |(name, contents, words)| (*name, contents.as_bytes().to_vec(), outcome(words)))
    };
    files.extend(of(coefficients, |words| Read(THREE, false, words)));
    files.extend(of(forces, |words| Read(NEWTONS, true, words)));
    files.extend(of(refused, Refused));
    assert!(files.len() >= 40);
    for (name, bytes, outcome) in files {
        let found = law(&bytes, MACHINE);
        match (outcome, found) {
            (Read(rows, forces, words), Ok(table)) => {
                let data: Vec<(f64, f64)> = table.data().collect();
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs().max(1e-3);
                let same = data.iter().zip(rows).all(|(a, b)| near(a.0, b.0) && near(a.1, b.1));
                assert!(same && data.len() == rows.len(), "{name}: {data:?}");
                assert_eq!(table.source().forces, forces, "{name}");
                let told = table.source().told.clone().unwrap_or_default();
                assert!(words.iter().all(|word| told.contains(word)), "{name}: {told}");
                assert!(!words.is_empty() || told.is_empty(), "{name}: {told}");
            }
            (Refused(words), Err((problem, remedy))) => {
                let told = format!("{problem}\n{remedy}");
                assert!(words.iter().all(|word| told.contains(word)), "{name}: {told}");
            }
            (_, found) => panic!("{name}: {found:?}"),
        }
    }
}

/// Too few readings, and friction of the wrong sign, are the reasons that are given where no law follows from the readings.
#[test]
fn what_cannot_be_fitted_says_why() {
    let why = |rows: &str| {
        let fits = Measured::of_bytes("rig.csv", format!("v [m/s],{rows}").as_bytes(), Some(MACHINE))
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
    let rises = why("F [N]\n0.01,3\n0.02,3.1\n0.03,3.2\n0.05,3.4\n0.1,3.9\n0.2,4.9\n0.3,5.9\n").unwrap();
    assert!(rises.contains("no law that falls"), "{rises}");
}

/// Rows in any order are the readings that they are in order of their speeds, and no record over time.
#[test]
fn the_order_of_rows_says_nothing() {
    let row = |i: usize| {
        let speed = 0.3 * (i as f64 / 150.0).powi(3);
        format!("{speed},{}\n", 300.0 + 100.0 / (1.0 + 20.0 * speed))
    };
    let of = |order: &dyn Fn(usize) -> usize| {
        let rows: String = (0..150).map(|i| row(order(i))).collect();
        Measured::of_bytes("rig.csv", format!("v,F [N]\n{rows}").as_bytes(), Some(MACHINE)).unwrap()
    };
    // 59 and 150 have no common divisor.
    let (sorted, shuffled) = (of(&|i| i), of(&|i| 59 * i % 150));
    assert!(!shuffled.is_record, "{:?}", shuffled.said);
    let pairs = |measured: &Measured| {
        measured
            .readings()
            .unwrap()
            .map(|rows| rows.iter().map(|it| [it.speed, it.friction]).collect::<Vec<_>>())
    };
    assert_eq!(pairs(&shuffled), pairs(&sorted));
}

/// The speed of a record goes up and down, with a phase of rest each time in which the force rises to 50.
#[test]
fn a_record_over_time_is_reduced() {
    let friction = |u: f64| 30.0 + 20.0 * (-u / 0.2).exp();
    let mut record = "t [s],v [m/s],F [N]\n".to_owned();
    let mut random = slipmap_numbers::random::Random(3);
    for row in 0..2000 {
        let phase = f64::from(row % 400) / 400.0;
        let speed = (2.0 * (1.0 - (2.0 * phase - 1.0).abs()) - 0.2).max(0.0);
        let force = if speed > 0.0 {
            friction(speed) + 0.5 * random.normal()
        } else {
            50.0 * (phase + 0.1).fract() / 0.15
        };
        record.push_str(&format!("{},{speed},{force}\n", 1e-3 * f64::from(row)));
    }
    let table = law(record.as_bytes(), MACHINE).unwrap();
    let told = table.source().told.clone().unwrap();
    assert!(told.contains("phases of rest") && told.contains("reduced to"), "{told}");
    let errors = table.standard_errors().unwrap();
    let rows: Vec<(f64, f64)> = table.data().collect();
    assert!(rows[0].0 == 0.0 && (rows[0].1 / 50.0 - 1.0).abs() < 0.01 && rows.len() < 40, "{rows:?}");
    for (row, error) in rows.iter().zip(errors).skip(1) {
        assert!((row.1 - friction(row.0)).abs() < 5.0 * error && *error < 0.5, "{row:?} {error}");
    }
}
