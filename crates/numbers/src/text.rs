//! Numbers as text, for messages, tables and command lines; and what messages quote.

use std::borrow::Cow;

/// A number with six significant digits, trailing zeros dropped: 0.25, 1.5e-9, 123457.
pub fn short(x: f64) -> String {
    const DIGITS: i32 = 6;
    if x == 0.0 {
        return "0".into();
    }
    if !x.is_finite() {
        return if x.is_nan() { "-".into() } else { format!("{x:+}") };
    }
    // The exponent after rounding to six digits, so that 0.9999999 becomes 1 and not 1.00000.
    let (mantissa, exponent) = scientific(x, DIGITS as usize);
    if (-4..DIGITS).contains(&exponent) {
        without_zeros(&format!("{x:.*}", (DIGITS - 1 - exponent) as usize)).to_owned()
    } else {
        format!("{}e{exponent}", without_zeros(&mantissa))
    }
}

/// A number rounded to `digits` significant digits, in the format of [`short`].
pub fn rounded(x: f64, digits: usize) -> String {
    let (mantissa, exponent) = scientific(x, digits);
    format!("{mantissa}e{exponent}").parse().map_or_else(|_| short(x), short)
}

/// Number of significant digits of a value up to the second digit of its error, at most `most`.
pub fn digits_within(value: f64, error: f64, most: usize) -> usize {
    if error == 0.0 || !error.is_finite() {
        return most;
    }
    let place = |x: f64| x.abs().log10().floor() as i32;
    (place(value).max(place(error) - 1) - place(error) + 2).clamp(1, most as i32) as usize
}

/// A number without the digits beyond the second of its error, and that error, which is rounded up and
/// holds for the rounded number.
pub fn known_part(value: f64, error: f64) -> [f64; 2] {
    /// Digits of an f64.
    const ALL: usize = 17;
    let parse = |(mantissa, exponent): (String, i32)| format!("{mantissa}e{exponent}").parse().ok();
    // What has no digit down to the second of its error is zero.
    let second = 10_f64.powf(error.abs().log10().floor() - 1.0);
    let known = match error.is_finite() && value.abs() < 0.5 * second {
        true => 0.0,
        false => parse(scientific(value, digits_within(value, error, ALL))).unwrap_or(value),
    };
    let whole = error + (known - value).abs();
    let (mantissa, exponent) = scientific(whole, 2);
    let unit = 10_f64.powi(exponent - 1);
    match parse((mantissa, exponent)) {
        Some(below) if below < whole => [known, parse(scientific(below + unit, 2)).unwrap_or(whole)],
        Some(error) => [known, error],
        None => [known, whole],
    }
}

/// A number with its error, and no digits beyond the second of that: "0.0497 +- 0.00031".
pub fn with_error(value: f64, error: f64) -> String {
    let [value, error] = known_part(value, error);
    format!("{} +- {}", exact(value), short(error))
}

/// A number rounded to `digits` significant digits: a decimal with one digit before the point, and the power
/// of ten. For a number that is not finite: its name, and 0.
pub fn scientific(x: f64, digits: usize) -> (String, i32) {
    let text = format!("{x:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.to_owned(), exponent.parse().unwrap_or(0))
}

/// A decimal without the zeros at its end.
pub fn without_zeros(decimal: &str) -> &str {
    if decimal.contains('.') { decimal.trim_end_matches('0').trim_end_matches('.') } else { decimal }
}

/// A number with its sign, see [`short`].
pub fn signed(x: f64) -> String {
    let text = short(x);
    if x > 0.0 && x.is_finite() { format!("+{text}") } else { text }
}

/// A number that reads back as itself: the shortest such decimal.
pub fn exact(x: f64) -> String {
    // Unlike `{}`, `{:?}` uses an exponent for very large and very small numbers.
    let text = format!("{x:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A count and its noun, with an s unless it is one: 1 tile, 1,234 tiles.
pub fn number_of(n: impl TryInto<u128>, noun: &str) -> String {
    let n = n.try_into().unwrap_or(u128::MAX);
    format!("{} {noun}{}", count(n), if n == 1 { "" } else { "s" })
}

/// A count in groups of three digits: 1,234,567.
pub fn count(n: impl TryInto<u128>) -> String {
    in_groups(&n.try_into().unwrap_or(u128::MAX).to_string(), ',')
}

/// Digits in groups of three.
pub fn in_groups(digits: &str, separator: char) -> String {
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(separator);
        }
        text.push(digit);
    }
    text
}

/// Largest number of characters of a text that is quoted in a message.
const LONGEST: usize = 60;

/// A text that is quoted in a message: one line of at most 60 characters.
pub fn quoted(text: &str) -> String {
    // Before the words are joined, since the text may be a whole file.
    let begin: String = text.trim_start().chars().take(4 * LONGEST).collect();
    let line = begin.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(LONGEST) {
        Some((cut, _)) => format!("{} ..", &line[..cut]),
        None if begin.len() < text.trim().len() => format!("{line} .."),
        None => line,
    }
}

/// A message in which every text between backticks is short, see [`quoted`]: users may write a megabyte where a
/// name is read.
pub fn with_short_quotes(message: &str) -> String {
    /// Length in bytes of what no message of this program has between two backticks or outside of them.
    const ENDLESS: usize = 4000;
    let parts = message.split('`').enumerate().map(|(i, part)| match i % 2 == 1 || part.len() > ENDLESS {
        true if part.chars().nth(LONGEST).is_some() => Cow::Owned(quoted(part)),
        _ => Cow::Borrowed(part),
    });
    parts.collect::<Vec<_>>().join("`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let cases = [
            (0.25, "0.25"),
            (1.5e-9, "1.5e-9"),
            (123_456.7, "123457"),
            (1_234_567.0, "1.23457e6"),
            (0.999_999_99, "1"),
            (-0.1, "-0.1"),
            (0.0001, "0.0001"),
            (100.0, "100"),
            (f64::NAN, "-"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
        assert_eq!(signed(0.5), "+0.5");
    }

    #[test]
    fn numbers_have_no_digits_beyond_their_errors() {
        let cases = [
            (0.049_712_3, 3.1e-4, "0.04971 +- 0.00032"),
            (0.451_057_229_876_123, 3.2e-12, "0.4510572298761 +- 3.3e-12"),
            (1218.7, 2050.0, "1200 +- 2100"),
            (-13.72, 0.000_99, "-13.72 +- 0.00099"),
            (0.25, 0.0, "0.25 +- 0"),
            (0.0, 1e-17, "0 +- 1e-17"),
            (3e-20, 1e-10, "0 +- 1.1e-10"),
        ];
        for (value, error, text) in cases {
            assert_eq!(with_error(value, error), text);
            let [known, whole] = known_part(value, error);
            assert!((known - value).abs() + error <= whole, "{value} {error}: {known} {whole}");
        }
    }

    #[test]
    fn exact_numbers_read_back() {
        for x in [0.1, 1.0, 1e-300, 5e-324, f64::MAX, -2.5e17, 1.0 / 3.0] {
            assert_eq!(exact(x).parse::<f64>().unwrap().to_bits(), x.to_bits(), "{}", exact(x));
            assert!(exact(x).len() < 25, "{}", exact(x));
        }
        assert_eq!(exact(32.0), "32");
    }

    #[test]
    fn quotations_in_messages_are_short() {
        let long = "many words ".repeat(50_000);
        assert_eq!(with_short_quotes("`a` is no name, `b` is"), "`a` is no name, `b` is");
        let cut = with_short_quotes(&format!("unknown name `{long}` in line 3"));
        assert!(cut.starts_with("unknown name `many words") && cut.ends_with(" ..` in line 3"), "{cut}");
        assert!(cut.chars().count() < 100, "{cut}");
        // A backtick in a quotation shifts the pairs.
        assert!(with_short_quotes(&format!("no `a`b{long}` here")).len() < 200);
        assert_eq!(quoted("  two\n  lines "), "two lines");
        assert_eq!(quoted(&"é".repeat(61)), format!("{} ..", "é".repeat(60)));
    }

    #[test]
    fn nouns_agree_with_their_numbers() {
        assert_eq!(number_of(1, "tile"), "1 tile");
        assert_eq!(number_of(0, "tile"), "0 tiles");
        assert_eq!(number_of(1_234_567, "cell"), "1,234,567 cells");
    }
}
