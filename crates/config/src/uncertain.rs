//! Uncertain numbers of a machine, as people write them: `{ value = 2.0, sd = 0.1 }`, `{ min = 1.8, max = 2.2 }`, and
//! `"12 bar +- 10 %"`. Percents of a spread are those of the value, also of a quantity that is a pure number.

use super::axis;
use super::refuse_unknown_keys;
use super::source::{ConfigError, Node, Section, Shape};
use super::units::{has_unit, with_unit};
use slipmap_machine::risk::Spread;

/// Reads a number in SI units from a node, or from this text in it.
pub(super) type Read<'a> = &'a dyn Fn(&Node, Option<&str>) -> Result<f64, ConfigError>;

const REMEDY: &str = "write \"2 kg +- 5 %\", { value = 2.0, sd = 0.1 } or { min = 1.8, max = 2.2 }";

/// The value and the standard deviation of a text such as `12 bar +- 10 %`; a unit that one of them lacks is that of the
/// other. `None` without such a sign.
#[must_use]
pub fn with_deviation(text: &str) -> Option<(String, String)> {
    let (value, sd) = ["+-", "+/-", "±"].into_iter().find_map(|sign| text.split_once(sign))?;
    let (value, sd) = (value.trim(), sd.trim());
    let unit = |text: &str| with_unit(text).map_or(String::new(), |(_, unit)| format!(" {unit}"));
    Some(match (has_unit(value), has_unit(sd)) {
        (true, false) => (value.to_owned(), sd.to_owned() + &unit(value)),
        (false, true) if share(sd).is_none() => (value.to_owned() + &unit(sd), sd.to_owned()),
        _ => (value.to_owned(), sd.to_owned()),
    })
}

/// The number before a sign of percent, over 100.
#[must_use]
pub fn share(text: &str) -> Option<f64> {
    with_unit(text).filter(|(_, unit)| *unit == "%").map(|(number, _)| number / 100.0)
}

/// What a text of a node says, if it is a share.
fn share_at(node: &Node) -> Option<f64> {
    node.text().ok().and_then(share)
}

/// Reads an uncertain quantity: its nominal value and its spread; `None` for anything else.
pub(super) fn uncertain(node: &Node, read: Read) -> Result<Option<(f64, Spread)>, ConfigError> {
    if let Some((value, sd)) = node.text().ok().and_then(with_deviation) {
        let value = read(node, Some(&value))?;
        let sd = share(&sd).map_or_else(|| read(node, Some(&sd)), |share| Ok(share * value.abs()))?;
        return Ok(Some((value, legal(node, sd)?)));
    }
    let Shape::Table(table) = node.shape() else { return Ok(None) };
    let keys = table.keys();
    let has = |key: &str| keys.iter().any(|other| other == key);
    if !["value", "sd", "min", "max"].into_iter().any(has) || axis::RANGE_KEYS.into_iter().any(has) {
        return Ok(None);
    }
    let at = |key: &str| table.get(key).ok_or_else(|| table.missing(key, REMEDY.into()));
    let [is_uniform, has_value] = [has("min") || has("max"), has("value")];
    if !is_uniform {
        refuse_unknown_keys(&table, &["value", "sd"])?;
        let value = read(&at("value")?, None)?;
        at("sd")?;
        return Ok(normal(&table, Some(value), read)?.map(|spread| (value, spread)));
    }
    refuse_unknown_keys(&table, if has_value { &["value", "min", "max"] } else { &["min", "max"] })?;
    let value = table.get("value").map(|node| read(&node, None)).transpose()?;
    let end = |key: &str| {
        let node = at(key)?;
        match (share_at(&node), value) {
            // "+10 %" is so much more than the value, "110 %" so much of it.
            (Some(share), Some(value)) => {
                let is_more = node.text().is_ok_and(|text| text.trim_start().starts_with(['+', '-']));
                Ok(value * if is_more { 1.0 + share } else { share })
            }
            _ => read(&node, None),
        }
    };
    let (min, max) = (end("min")?, end("max")?);
    let value = value.unwrap_or(0.5 * (min + max));
    match min.is_finite() && max.is_finite() && min <= value && value <= max {
        true => Ok(Some((value, Spread::Uniform { min, max }))),
        false if has_value => Err(node.error("the value must be from min to max", "change one of them")),
        false => Err(node.error("min must be at most max", "swap them")),
    }
}

/// The normal spread of a table with the key `sd`, around this value or around each of several; `None` without it.
pub(super) fn normal(table: &Section, value: Option<f64>, read: Read) -> Result<Option<Spread>, ConfigError> {
    let Some(node) = table.get("sd") else { return Ok(None) };
    match (share_at(&node), value) {
        (Some(share), None) => legal(&node, share).map(|_| Some(Spread::Relative { sd: share })),
        (Some(share), Some(value)) => legal(&node, share * value.abs()).map(Some),
        (None, _) => legal(&node, read(&node, None)?).map(Some),
    }
}

fn legal(node: &Node, sd: f64) -> Result<Spread, ConfigError> {
    match sd.is_finite() && sd >= 0.0 {
        true => Ok(Spread::Normal { sd }),
        false => Err(node.error("the standard deviation must be at least 0", "choose another sd")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_read_as_people_write_them() {
        for (text, value, sd) in [
            ("12 bar +- 10 %", "12 bar", "10 %"),
            ("12 bar ± 1", "12 bar", "1 bar"),
            ("12 +/- 1 bar", "12 bar", "1 bar"),
            ("12 +- 10 %", "12", "10 %"),
            ("12+-1", "12", "1"),
            ("40 % +- 5 %", "40 %", "5 %"),
        ] {
            assert_eq!(with_deviation(text), Some((value.to_owned(), sd.to_owned())), "{text}");
        }
        assert_eq!(with_deviation("12 bar"), None);
        assert_eq!(
            [share("10 %"), share("10%"), share("10 bar"), share("10")],
            [Some(0.1), Some(0.1), None, None]
        );
    }
}
