//! The nodes of one axis: a number, a list, or a range.

use super::source::{ConfigError, Node, Section, Shape};

/// Largest number of nodes. A longer axis is a mistake, and would fill the memory before the grid could be
/// refused.
const MOST_POINTS: i64 = 1_000_000;

pub(super) const RANGE_KEYS: [&str; 4] = ["from", "to", "points", "spacing"];

/// Reads a number, as [`Node::number`] or with a unit.
pub(super) type Number<'a> = &'a dyn Fn(&Node) -> Result<f64, ConfigError>;

pub(super) fn nodes(node: &Node) -> Result<Vec<f64>, ConfigError> {
    match node.shape() {
        Shape::Text => Err(node.wrong_kind(NODES)),
        _ => nodes_by(node, &|node: &Node| node.number()),
    }
}

/// What the nodes of an axis are.
const NODES: &str = "a number, a list of numbers, or { from = 0.0, to = 1.0, points = 11 }";

/// The nodes of an axis whose numbers `number` reads.
pub(super) fn nodes_by(node: &Node, number: Number) -> Result<Vec<f64>, ConfigError> {
    match node.shape() {
        Shape::Number | Shape::Text => Ok(vec![number(node)?]),
        Shape::List(elements) if elements.is_empty() => {
            Err(node.error("the axis has no values", "give it at least one number"))
        }
        Shape::List(elements) => elements.iter().map(number).collect(),
        Shape::Table(range) => {
            refuse_step(&range)?;
            super::refuse_unknown_keys(&range, &RANGE_KEYS)?;
            nodes_of_range(node, &range, number)
        }
        Shape::Other => Err(node.wrong_kind(NODES)),
    }
}

/// Refuses a range given by its step; the error states the number of points instead. A step that does not
/// divide the range would leave out its end.
fn refuse_step(range: &Section) -> Result<(), ConfigError> {
    let Some(step) = range.get("step") else { return Ok(()) };
    let number = |key: &str| range.get(key).map_or(Ok(f64::NAN), |node| node.number());
    let (from, to) = (number("from")?, number("to")?);
    let steps = ((to - from) / step.number()?).round();
    let written = match (1.0..=1e6).contains(&steps) {
        true => format!("{{ from = {from}, to = {to}, points = {} }}", steps + 1.0),
        false => "{ from = 0.0, to = 1.0, points = 11 }".to_owned(),
    };
    Err(range.unknown("step", format!("a range has a number of points, both ends included: {written}")))
}

/// Reads `{ from, to, points, spacing }`; other keys are the caller's.
pub(super) fn nodes_of_range(node: &Node, range: &Section, number: Number) -> Result<Vec<f64>, ConfigError> {
    let required = |key: &str| {
        range.get(key).ok_or_else(|| {
            range.missing(key, "a range is written { from = 0.0, to = 1.0, points = 11 }".into())
        })
    };
    let (from_node, to_node, points_node) = (required("from")?, required("to")?, required("points")?);
    let (from, to) = (number(&from_node)?, number(&to_node)?);
    for (end, value) in [(&from_node, from), (&to_node, to)] {
        if !value.is_finite() {
            return Err(end.error("the ends of a range must be finite", "write a number"));
        }
    }
    let points: usize = points_node.integer(1, MOST_POINTS)?;
    let spacings = [("linear", false), ("log", true)];
    let log = range.get_or("spacing", false, |word| super::choice(word, &spacings, "spacing"))?;

    if from > to {
        return Err(node.error(
            &format!("the range runs backwards, from {from} to {to}"),
            "swap `from` and `to`; axes increase",
        ));
    }
    if from == to {
        return match points {
            1 => Ok(vec![from]),
            _ => Err(points_node.error(
                &format!("{points} points between {from} and {to} would all be the same"),
                format!("write the axis as the number {from}, or move `to` above `from`"),
            )),
        };
    }
    if points == 1 {
        return Err(points_node.error(
            &format!("one point cannot be both ends of the range, {from} and {to}"),
            format!("take at least 2 points, or write the axis as one number such as {from}"),
        ));
    }
    if log && from <= 0.0 {
        return Err(from_node.error(
            "a logarithmic axis cannot start at or below 0",
            "start above 0, or leave `spacing` out",
        ));
    }
    let nodes = range_nodes(from, to, points, log);
    if nodes.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(points_node.error(
            &format!("{points} points between {from} and {to} are too close to be told apart"),
            "take fewer points",
        ));
    }
    Ok(nodes)
}

/// The nodes that a configuration's range `{ from, to, points, spacing }` has: `points` >= 2 values from
/// `from` to `to`, both exact, with equal steps, or with equal ratios if `log`. Neighbours may be equal where
/// the ends are too close.
///
/// A linear node is `(from * (n-1-i) + to * i) / (n-1)`, which gives 0.3 where `from + i * step` gives
/// 0.30000000000000004.
pub fn range_nodes(from: f64, to: f64, points: usize, log: bool) -> Vec<f64> {
    let last = points - 1;
    let between = |i: usize| {
        let (done, left, all) = (i as f64, (last - i) as f64, last as f64);
        match log {
            false => (from * left + to * done) / all,
            true => ((from.ln() * left + to.ln() * done) / all).exp(),
        }
    };
    (0..points)
        .map(|i| match i {
            0 => from,
            i if i == last => to,
            i => between(i),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_exact_and_tenths_are_tenths() {
        let tenths = range_nodes(0.0, 1.0, 11, false);
        assert_eq!(tenths, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]);
        for log in [false, true] {
            let nodes = range_nodes(0.1, 0.7, 1000, log);
            assert_eq!((nodes[0], nodes[999]), (0.1, 0.7));
            assert!(nodes.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn log_spacing_has_equal_ratios() {
        let nodes = range_nodes(0.01, 100.0, 5, true);
        for (node, exact) in nodes.iter().zip([0.01, 0.1, 1.0, 10.0, 100.0]) {
            // exp and ln are accurate to an ulp each and |ln| <= 4.6, so the relative error is a few eps.
            assert!((node / exact - 1.0).abs() < 16.0 * f64::EPSILON, "{node} is not {exact}");
        }
    }
}
