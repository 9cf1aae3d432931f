//! Units as people write them in the headers of tables: `mm/s`, `mm s^-1`, `mm_per_s`, `N·s/m`, `kg m²`,
//! `rpm`.

use slipmap_machine::{Dimension, Motion};
use slipmap_numbers::text::rounded;

/// Exponents of kg, m, s and rad.
type Exponents = [i64; 4];

/// A unit: its size in SI, and the exponents of the base units in it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Unit {
    factor: f64,
    exponents: Exponents,
}

const NONE: Unit = Unit { factor: 1.0, exponents: [0; 4] };

impl Unit {
    /// The product with another unit to a power.
    fn times(self, other: Unit, power: i32) -> Self {
        let exponents = std::array::from_fn(|i| self.exponents[i] + i64::from(power) * other.exponents[i]);
        Self { factor: self.factor * other.factor.powi(power), exponents }
    }
}

/// Units with a name of their own: their names, their size in SI and their exponents.
const NAMED: [(&[&str], f64, Exponents); 29] = [
    (&["m", "metre", "metres", "meter", "meters"], 1.0, [0, 1, 0, 0]),
    (&["s", "sec", "second", "seconds"], 1.0, [0, 0, 1, 0]),
    (&["g", "gram", "grams"], 1e-3, [1, 0, 0, 0]),
    (&["kilogram", "kilograms"], 1.0, [1, 0, 0, 0]),
    (&["N", "newton", "newtons"], 1.0, [1, 1, -2, 0]),
    (&["rad", "radian", "radians"], 1.0, [0, 0, 0, 1]),
    (&["min", "minute", "minutes"], 60.0, [0, 0, 1, 0]),
    (&["h", "hr", "hour", "hours"], 3600.0, [0, 0, 1, 0]),
    (&["deg", "°", "degree", "degrees"], std::f64::consts::PI / 180.0, [0, 0, 0, 1]),
    (
        &["rev", "r", "U", "tr", "revolution", "revolutions", "turn", "turns"],
        std::f64::consts::TAU,
        [0, 0, 0, 1],
    ),
    (&["rpm"], std::f64::consts::TAU / 60.0, [0, 0, -1, 1]),
    (&["mps"], 1.0, [0, 1, -1, 0]),
    (&["kph", "kmh"], 1.0 / 3.6, [0, 1, -1, 0]),
    (&["mph"], 0.44704, [0, 1, -1, 0]),
    (&["in", "inch", "inches"], 0.0254, [0, 1, 0, 0]),
    (&["ft", "foot", "feet"], 0.3048, [0, 1, 0, 0]),
    (&["t", "tonne", "tonnes"], 1e3, [1, 0, 0, 0]),
    (&["lb", "lbm", "lbs"], 0.453_592_37, [1, 0, 0, 0]),
    (&["lbf"], 4.448_221_615_260_5, [1, 1, -2, 0]),
    (&["kgf", "kp"], 9.80665, [1, 1, -2, 0]),
    (&["Hz", "hertz"], 1.0, [0, 0, -1, 0]),
    (&["Pa", "pascal", "pascals"], 1.0, [1, -1, -2, 0]),
    (&["bar"], 1e5, [1, -1, -2, 0]),
    (&["psi"], 6_894.757_293_168_36, [1, -1, -2, 0]),
    (&["ksi"], 6_894_757.293_168_36, [1, -1, -2, 0]),
    (&["atm"], 101_325.0, [1, -1, -2, 0]),
    (&["kip", "kips", "klbf"], 4_448.221_615_260_5, [1, 1, -2, 0]),
    (&["krpm"], std::f64::consts::TAU / 0.06, [0, 0, -1, 1]),
    // A damping of rotations, not newton-milliseconds.
    (&["Nms"], 1.0, [1, 2, -1, 0]),
];

/// The units that may have prefixes.
const PREFIXED: [&str; 8] = ["m", "s", "g", "N", "rad", "Hz", "Pa", "bar"];
const PREFIXES: [(&str, f64); 11] = [
    ("da", 10.0),
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 0.1),
    ("k", 1e3),
    // No other prefix is meant.
    ("K", 1e3),
    ("M", 1e6),
];

/// The unit of a name. Words such as rpm, which no prefix begins, may be in capitals.
fn named(symbol: &str) -> Option<Unit> {
    let is_word = |name: &str| name.len() > 2 && name.bytes().all(|c| c.is_ascii_lowercase());
    let is_it = |name: &&str| *name == symbol || is_word(name) && name.eq_ignore_ascii_case(symbol);
    let of = NAMED.iter().find(|(names, ..)| names.iter().any(is_it));
    of.map(|&(_, factor, exponents)| Unit { factor, exponents })
}

/// The unit of a symbol without spaces: a name, a prefix and a name, or products written together, as Nm, mNm and
/// Ns.
fn symbol(text: &str) -> Option<Unit> {
    let prefixed = || {
        PREFIXES.iter().find_map(|(prefix, factor)| {
            let base = text.strip_prefix(prefix).filter(|base| PREFIXED.contains(base))?;
            named(base).map(|base| Unit { factor: factor * base.factor, ..base })
        })
    };
    // A force or a mass before another unit.
    let together = || {
        let end = text.find(['N', 'g'])? + 1;
        let (first, rest) = text.split_at(end);
        let is_first = first == "kg" || first == "N" || first.ends_with('N') && first.chars().count() <= 3;
        (is_first && !rest.is_empty()).then(|| Some(symbol(first)?.times(symbol(rest)?, 1)))?
    };
    named(text).or_else(prefixed).or_else(together)
}

/// The spellings of known symbols that differ from this one by capitals alone.
fn spellings(text: &str) -> Vec<String> {
    let names = NAMED.iter().flat_map(|(names, ..)| names.iter().map(|name| (*name).to_owned()));
    let prefixed = PREFIXES.iter().flat_map(|(prefix, _)| PREFIXED.map(|base| format!("{prefix}{base}")));
    let together = ["kg", "mN", "kN", "MN", "N"].into_iter().flat_map(|first| {
        let rest = text.get(..first.len()).filter(|start| start.eq_ignore_ascii_case(first));
        let rest = rest.map_or("", |_| &text[first.len()..]);
        let rest = if rest.is_empty() { Vec::new() } else { spellings(rest) };
        rest.into_iter().map(move |rest| format!("{first}{rest}"))
    });
    let all = names.chain(prefixed).filter(|known| known.eq_ignore_ascii_case(text));
    all.chain(together).filter(|known| !known.starts_with('K')).collect()
}

/// The unit of the `wanted` kind that differs from an unknown one by capitals alone: m/s for M/s.
pub(super) fn meant(text: &str, wanted: &str) -> Option<String> {
    /// Number of combinations of spellings that are tried.
    const MOST: usize = 64;
    let is_letter = |c: char| c.is_alphabetic();
    let mut found = vec![String::new()];
    for word in text.split_inclusive(|c| !is_letter(c)).flat_map(|word| {
        let end = word.find(|c| !is_letter(c)).unwrap_or(word.len());
        <[&str; 2]>::from(word.split_at(end))
    }) {
        let of_word = if word.starts_with(is_letter) { spellings(word) } else { vec![word.to_owned()] };
        found =
            found.iter().flat_map(|start| of_word.iter().map(move |word| format!("{start}{word}"))).collect();
        found.truncate(MOST);
    }
    found.into_iter().find(|text| matches!(compare(text, wanted), Match::Same | Match::Factor(_)))
}

/// Reads a unit; `None` if it is not known.
fn read(text: &str) -> Option<Unit> {
    /// Length in bytes above which a text is not taken for a unit.
    const LONGEST: usize = 60;
    if text.len() > LONGEST {
        return None;
    }
    let mut plain = text.trim().to_owned();
    for (from, to) in [
        ("**", "^"),
        ("⁻¹", "^-1"),
        ("⁻²", "^-2"),
        ("²", "^2"),
        ("³", "^3"),
        ("−", "-"),
        ("⋅", " "),
        ("·", " "),
        ("×", " "),
        ("*", " "),
        (" per ", "/"),
        ("%", "0.01"),
    ] {
        plain = plain.replace(from, to);
    }
    if plain.is_empty() || plain == "-" {
        return (plain == "-").then_some(NONE);
    }
    let mut rest = plain.as_str();
    let unit = product(&mut rest)?;
    rest.is_empty().then_some(unit)
}

/// Reads factors until the end or a closing parenthesis.
fn product(rest: &mut &str) -> Option<Unit> {
    let mut unit = factor(rest)?;
    loop {
        *rest = rest.trim_start_matches([' ', '.']);
        if rest.is_empty() || rest.starts_with(')') {
            return Some(unit);
        }
        let sign = match rest.strip_prefix('/') {
            Some(after) => {
                *rest = after.trim_start();
                -1
            }
            None => 1,
        };
        unit = unit.times(factor(rest)?, sign);
    }
}

/// Reads a number, a symbol or a product in parentheses, with its power.
fn factor(rest: &mut &str) -> Option<Unit> {
    let base = if let Some(inner) = rest.strip_prefix('(') {
        *rest = inner.trim_start();
        let inside = product(rest)?;
        *rest = rest.strip_prefix(')')?;
        inside
    } else if rest.starts_with(|c: char| c.is_ascii_digit()) {
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let (number, after) = rest.split_at(end);
        *rest = after;
        return Some(Unit { factor: number.parse().ok()?, ..NONE });
    } else {
        let end = rest.find(|c: char| !c.is_alphabetic() && c != '°').unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        *rest = after;
        symbol(name)?
    };
    let power = rest.strip_prefix('^').unwrap_or(rest);
    let digits = power.strip_prefix('-').unwrap_or(power);
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    if end == 0 {
        // A sign or a caret needs a number.
        return (power.len() == rest.len() && digits.len() == power.len()).then_some(base);
    }
    let sign = if digits.len() < power.len() { -1 } else { 1 };
    let exponent: i32 = digits[..end].parse().ok().filter(|exponent| *exponent < 10)?;
    *rest = &digits[end..];
    Some(NONE.times(base, sign * exponent))
}

/// Result of comparing the unit in a header with that in which the column is read.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Match {
    /// The units are equal.
    Same,
    /// The header's unit is this many times the column's unit, for the same quantity.
    Factor(f64),
    /// The header's unit is that of another quantity.
    Other,
    /// The header's unit is not known.
    Unknown,
}

/// Compares a unit in a header with the SI unit in which the column is read, `""` for a pure number.
pub(super) fn compare(text: &str, wanted: &str) -> Match {
    let wanted_unit = read(wanted).unwrap_or(NONE);
    // Rotary speeds in 1/min are turns per minute.
    let minute = Unit { factor: 1.0 / 60.0, exponents: [0, 0, -1, 0] };
    let turns = wanted == Motion::Rotation.unit(Dimension::Velocity);
    let Some(mut unit) = read(text) else { return Match::Unknown };
    if turns && unit == minute {
        unit = Unit { factor: std::f64::consts::TAU / 60.0, exponents: [0, 0, -1, 1] };
    }
    // The radian may be left out, as in a stiffness in N m; not in speeds: 1/s may mean turns per second.
    let without_angle = |[mass, length, time, _]: Exponents| [mass, length, time];
    let is_force = wanted_unit.exponents[0] != 0;
    let same = without_angle(unit.exponents) == without_angle(wanted_unit.exponents)
        && (unit.exponents[3] == wanted_unit.exponents[3] || is_force && unit.exponents[3] == 0);
    let ratio = unit.factor / wanted_unit.factor;
    // 1/s may be meant as rad/s: that it is read as cycles is told.
    let is_told = wanted == "Hz" && !text.to_lowercase().contains('h');
    match same {
        false => Match::Other,
        true if (ratio - 1.0).abs() < 1e-9 && !is_told => Match::Same,
        true => Match::Factor(ratio),
    }
}

/// The size of a unit of speed of the other motion in the SI unit of this one, at a radius in m: of rpm in m/s. `None`
/// if it is no such unit.
#[must_use]
pub fn size_on_disc(text: &str, motion: Motion, radius: f64) -> Option<f64> {
    let (other, ratio) = match motion {
        Motion::Translation => (Motion::Rotation, radius),
        Motion::Rotation => (Motion::Translation, radius.recip()),
    };
    match compare(text, other.unit(Dimension::Velocity)) {
        Match::Same => Some(ratio),
        Match::Factor(factor) => Some(factor * ratio),
        Match::Other | Match::Unknown => None,
    }
}

/// The size of a unit in SI; `None` if it is not known.
#[must_use]
pub fn size(text: &str) -> Option<f64> {
    read(text).map(|unit| unit.factor)
}

/// A number and the unit after it, as people write them: `20 rpm`, `10mm/s`, `35 %`. `None` without a number or
/// without a unit.
pub fn with_unit(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    if text.parse::<f64>().is_ok() {
        return None;
    }
    let ends = text.char_indices().map(|(at, _)| at).rev().filter(|&at| at > 0);
    let (at, number) = ends.filter_map(|at| Some((at, text[..at].trim_end().parse::<f64>().ok()?))).next()?;
    number.is_finite().then(|| (number, text[at..].trim_start()))
}

/// The number that a text tells with its unit, in the unit `si`, which is empty for a pure number; and its unit.
///
/// # Errors
/// What is wrong, in words.
pub fn number_in<'a>(text: &'a str, si: &str) -> Result<(f64, &'a str), String> {
    let Some((number, unit)) = with_unit(text) else {
        return Err(format!("`{text}` is no number with a unit"));
    };
    match compare(unit, si) {
        Match::Same => Ok((number, unit)),
        Match::Factor(factor) => Ok((converted(number, factor), unit)),
        Match::Other if si.is_empty() => Err(format!("it is a pure number, not one in {unit}")),
        Match::Other => {
            Err(format!("{unit} is no unit of it; write it in {si}, or in a unit of the same kind"))
        }
        Match::Unknown => Err(match meant(unit, si) {
            Some(meant) => format!("the unit {unit} is not known; write {meant}"),
            None => format!("the unit {unit} is not known"),
        }),
    }
}

/// Whether a text is a number with a unit after it.
pub fn has_unit(text: &str) -> bool {
    with_unit(text)
        .is_some_and(|(_, unit)| unit.starts_with(|c: char| c.is_alphabetic() || ['°', '%'].contains(&c)))
}

/// A number in units of `factor`, rounded once where the factor is one over a whole number, as of mm/s.
pub(super) fn converted(number: f64, factor: f64) -> f64 {
    let parts = (1.0 / factor).round();
    if factor < 1.0 && (parts * factor - 1.0).abs() < 4.0 * f64::EPSILON {
        number / parts
    } else {
        number * factor
    }
}

/// The conversion of this unit to the wanted one, for messages: "1 mm/s is 0.001 m/s".
#[must_use]
pub fn conversion(unit: &str, factor: f64, wanted: &str) -> String {
    format!("1 {unit} is {} {wanted}", rounded(factor, 6)).trim_end().to_owned()
}

/// The name in a header, and its unit.
#[must_use]
pub fn head_of(header: &str) -> (&str, Option<&str>) {
    bracketed(header).map_or((header.trim(), None), |(name, unit)| (name, Some(unit)))
}

/// The name in a header and the text in the brackets at its end, `damping [N s/m]`, or the unit by which it is divided,
/// `F / N`.
pub(super) fn bracketed(header: &str) -> Option<(&str, &str)> {
    let header = header.trim();
    let close = header.chars().last()?;
    let open = match close {
        ']' => '[',
        ')' => '(',
        '}' => '{',
        '>' => '<',
        _ => return header.rsplit_once(" / ").filter(|(_, unit)| read(unit).is_some()),
    };
    // Brackets of the same kind may be inside: (N/(m/s)).
    let mut depth = 0;
    let start = header.char_indices().rev().find(|(_, c)| {
        depth += i32::from(*c == close) - i32::from(*c == open);
        depth == 0
    });
    let (start, _) = start?;
    let inside = &header[start + 1..header.len() - 1];
    Some((header[..start].trim_end().trim_end_matches(['/', ',']).trim_end(), inside.trim()))
}

/// A unit of speed or force that a header names without brackets: `u_mm_s`, `speed in mm/s`, `rpm`. Only
/// words that form such a unit count, since `s` or `m` alone may mean anything.
pub(super) fn in_words(header: &str, wanted: &str) -> Option<String> {
    let words: Vec<&str> = header.split([' ', ',', ';', '_']).filter(|word| !word.is_empty()).collect();
    let speeds: [Exponents; 2] = [[0, 1, -1, 0], [0, 0, -1, 1]];
    let forces: [Exponents; 2] = [[1, 1, -2, 0], [1, 2, -2, 0]];
    let is_speed = Motion::ALL.map(|motion| motion.unit(Dimension::Velocity)).contains(&wanted);
    let kinds = if is_speed { speeds } else { forces };
    // A quotient in other capitals is one, to be refused.
    let is_meant = |text: &str| match read(text) {
        Some(unit) => kinds.contains(&unit.exponents),
        None => text.contains('/') && meant(text, wanted).is_some(),
    };
    let three = words.windows(3).filter(|of| of[1] == "per").map(|of| format!("{}/{}", of[0], of[2]));
    let two =
        words.windows(2).filter(|of| is_speed && of[0] != "in").map(|of| format!("{}/{}", of[0], of[1]));
    let one = words.iter().map(|word| (*word).to_owned());
    three.chain(one).chain(two).find(|text| is_meant(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_every_usual_spelling() {
        let speed = Motion::Translation.unit(Dimension::Velocity);
        for text in ["m/s", "m s^-1", "m.s-1", "m·s⁻¹", "m*s**-1", "m per s", "mps", "MPS", "m/sec", "m/(s)"]
        {
            assert_eq!(compare(text, speed), Match::Same, "{text}");
        }
        for (text, factor) in [
            ("mm s^-1", 1e-3),
            ("mm.s-1", 1e-3),
            ("mm/sec", 1e-3),
            ("µm/s", 1e-6),
            ("ft/s", 0.3048),
            ("km/h", 1.0 / 3.6),
            ("m/min", 1.0 / 60.0),
        ] {
            let Match::Factor(found) = compare(text, speed) else { panic!("{text}") };
            assert!((found / factor - 1.0).abs() < 1e-12, "{text}: {found}");
        }
        for text in ["rad/s", "s", "mm", "rpm", "N", "1/s", "ms^-1"] {
            assert_eq!(compare(text, speed), Match::Other, "{text}");
        }
        for text in ["", "furlongs/week", "m/", "m^", "m/s)", "(m/s", "knots"] {
            assert_eq!(compare(text, speed), Match::Unknown, "{text}");
        }
        let turning = Motion::Rotation.unit(Dimension::Velocity);
        for text in ["rpm", "1/min", "r/min", "rev/min", "min^-1"] {
            let Match::Factor(found) = compare(text, turning) else { panic!("{text}") };
            assert!((found - std::f64::consts::PI / 30.0).abs() < 1e-15, "{text}: {found}");
        }
        assert_eq!(compare("1/s", turning), Match::Other);
        assert_eq!(compare("%", ""), Match::Factor(0.01));
        assert_eq!(compare("-", ""), Match::Same);
    }

    /// Prefixes have their case: a spelling that is none is refused, with the one that was meant.
    #[test]
    fn capitals_are_not_guessed() {
        let of = |dimension: Dimension| Motion::Translation.unit(dimension);
        for (text, wanted, spelling) in [
            ("M/s", of(Dimension::Velocity), "m/s"),
            ("MM/S", of(Dimension::Velocity), "mm/s"),
            ("T", of(Dimension::Mass), "t"),
            ("kG", of(Dimension::Mass), "kg"),
            ("NM", Motion::Rotation.unit(Dimension::Force), "Nm"),
            ("n", of(Dimension::Force), "N"),
            ("hz", "Hz", "Hz"),
            ("n s/M", of(Dimension::Damping), "N s/m"),
        ] {
            assert_eq!(compare(text, wanted), Match::Unknown, "{text}");
            assert_eq!(meant(text, wanted).as_deref(), Some(spelling), "{text}");
        }
        assert_eq!(meant("furlongs/week", "m/s"), None);
        assert_eq!(number_in("1 M/s", "m/s").unwrap_err(), "the unit M/s is not known; write m/s");
        // No other prefix is meant, and no prefix.
        assert_eq!(compare("KN", of(Dimension::Force)), Match::Factor(1e3));
        assert_eq!(compare("Kg", of(Dimension::Mass)), Match::Same);
        assert!(matches!(compare("RPM", Motion::Rotation.unit(Dimension::Velocity)), Match::Factor(_)));
    }

    #[test]
    fn forces_pressures_and_speeds_of_practice_are_known() {
        let [force, torque] = [Motion::Translation, Motion::Rotation].map(|it| it.unit(Dimension::Force));
        let speed = Motion::Rotation.unit(Dimension::Velocity);
        for (text, wanted, factor) in [
            ("mNm", torque, 1e-3),
            ("uN", force, 1e-6),
            ("kip", force, 4448.2216152605),
            ("klbf", force, 4448.2216152605),
            ("mbar", "Pa", 100.0),
            ("atm", "Pa", 101_325.0),
            ("ksi", "Pa", 6_894_757.293_168),
            ("krpm", speed, 104.719_755_119_66),
        ] {
            let Match::Factor(found) = compare(text, wanted) else { panic!("{text}") };
            assert!((found / factor - 1.0).abs() < 1e-12, "{text}: {found}");
        }
        // Said, since rad/s may be meant.
        assert_eq!(compare("1/s", "Hz"), Match::Factor(1.0));
        assert_eq!(compare("Hz", "Hz"), Match::Same);
        assert_eq!(conversion("1/s", 1.0, "Hz"), "1 1/s is 1 Hz");
    }

    #[test]
    fn numbers_have_units_after_them() {
        for (text, number, unit) in
            [("20 rpm", 20.0, "rpm"), ("1e3N", 1e3, "N"), (" -0.5 mm/s ", -0.5, "mm/s"), ("35 %", 35.0, "%")]
        {
            assert_eq!(with_unit(text), Some((number, unit)));
        }
        assert_eq!(with_unit("rpm").or(with_unit("20")).or(with_unit("")), None);
        assert_eq!([converted(35.0, 0.01), converted(3.0, 1e3), converted(7.0, 1e-3)], [0.35, 3e3, 0.007]);
    }

    #[test]
    fn the_units_of_a_machine_are_their_own() {
        for motion in Motion::ALL {
            for dimension in [
                Dimension::Time,
                Dimension::Length,
                Dimension::Velocity,
                Dimension::Force,
                Dimension::Damping,
                Dimension::Mass,
                Dimension::Stiffness,
            ] {
                let unit = motion.unit(dimension);
                assert_eq!(compare(unit, unit), Match::Same, "{dimension:?}");
                assert_eq!(compare(&format!("5 {unit}"), unit), Match::Factor(5.0));
            }
        }
        let damping = Motion::Rotation.unit(Dimension::Damping);
        assert_eq!(compare("Nms/rad", damping), Match::Same);
        assert_eq!(compare("N m s", damping), Match::Same);
        assert_eq!(compare("N s/m", damping), Match::Other);
        assert_eq!(compare("N/(m/s)", Motion::Translation.unit(Dimension::Damping)), Match::Same);
        assert_eq!(compare("kN", Motion::Translation.unit(Dimension::Force)), Match::Factor(1e3));
    }

    #[test]
    fn units_are_found_in_headers() {
        assert_eq!(bracketed("damping [N s/m]"), Some(("damping", "N s/m")));
        assert_eq!(bracketed("v / (m/s)"), Some(("v", "m/s")));
        assert_eq!(bracketed("d (N/(m/s))"), Some(("d", "N/(m/s)")));
        assert_eq!(bracketed("v / mm·s⁻¹"), Some(("v", "mm·s⁻¹")));
        assert_eq!(bracketed("F_t / F_n"), None);
        assert_eq!(bracketed("mass"), None);
        let speed = Motion::Translation.unit(Dimension::Velocity);
        for (header, unit) in [
            ("u_mm_s", Some("mm/s")),
            ("velocity_mm_per_s", Some("mm/s")),
            ("v_in_m/s", Some("m/s")),
            ("speed in mm/s", Some("mm/s")),
            ("rpm", Some("rpm")),
            ("slip speed in s", None),
            ("U_MM_S", Some("MM/S")),
            ("u", None),
            ("v_rel", None),
        ] {
            assert_eq!(in_words(header, speed).as_deref(), unit, "{header}");
        }
        let force = Motion::Translation.unit(Dimension::Force);
        assert_eq!(in_words("F_kN", force).as_deref(), Some("kN"));
        assert_eq!(in_words("mu_k", force), None);
        assert_eq!(in_words("F_n", force), None);
    }
}
