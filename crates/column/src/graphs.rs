//! Curves in planes with the damping as one axis that are graphs over the other: the folds, which are the extremes
//! of [the backbone](super::backbone) C(r), and the grazing curve, which is its end C(r) = eps c* at r = V. One column gives
//! a point of each.
//!
//! The other axis is cut into `PARTS` parts. Each is halved until the extremes at neighbouring sections
//! correspond to each other one by one, move little, and lie on a line within `FLAT`. Where two extremes meet
//! in a cusp, or one leaves through an end of the backbone, the part is halved `HALVINGS` times: branches end
//! there. All parts are halved alike, so that `MOST_SECTIONS` sections are spread over the plane. Two
//! extremes that appear and vanish again between neighbouring sections are missed.

use rayon::prelude::*;

use super::continuation::{BATCH, Branch, CurvePoint, Spent};

/// Number of parts of the other axis, each of which is halved at least once.
const PARTS: usize = 64;
/// Largest number of halvings of a part.
const HALVINGS: u32 = 8;
/// Largest number of sections, as many as a figure can show. Each is a column; extremes of noisy ones
/// correspond nowhere.
pub const MOST_SECTIONS: usize = 600;
/// Largest distance, in amplitude over belt speed and in sides of the plane, of extremes that correspond.
const NEAR: f64 = 0.04;
/// Largest distance of the middle of a part from its chord, in sides.
const FLAT: f64 = 1e-3;
/// Cost of an extreme that corresponds to none at the neighbouring section, as a distance.
const ALONE: f64 = 0.1;
/// Accuracy of the ends of a curve on the border of the plane, and largest number of trials for one.
const ON_BORDER: f64 = 1e-9;
const TRIALS: u32 = 30;

/// An extreme of the backbone, where two cycles meet; or its end, where the cycle with sticking ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Its amplitude over the belt speed.
    pub amplitude: f64,
    /// Its damping, in sides of the plane: 0 and 1 are the border.
    pub height: f64,
    /// Estimate of the error of the height.
    pub error: f64,
    /// Whether it is a maximum of the damping.
    pub is_maximum: bool,
}

impl Extreme {
    /// Whether two extremes lie beyond the same side of the plane, where their heights do not matter.
    fn is_outside_with(self, other: Extreme) -> bool {
        self.height.max(other.height) < 0.0 || self.height.min(other.height) > 1.0
    }

    /// The distance of two extremes of one kind; others do not correspond.
    fn distance(self, other: Extreme) -> Option<f64> {
        let up = if self.is_outside_with(other) { 0.0 } else { (self.height - other.height).abs() };
        (self.is_maximum == other.is_maximum).then_some((self.amplitude - other.amplitude).abs().max(up))
    }

    /// Whether its height is that in the middle of a chord.
    fn is_on_chord(self, from: Extreme, to: Extreme) -> bool {
        from.is_outside_with(to) || (self.height - 0.5 * (from.height + to.height)).abs() <= FLAT
    }
}

/// The extremes at one place of the other axis, by rising amplitude.
#[derive(Clone, Debug)]
struct Section {
    share: f64,
    extremes: Vec<Extreme>,
}

impl Section {
    /// Whether the extremes of both correspond one by one and move little.
    fn corresponds(&self, other: &Section) -> bool {
        let pairs = self.extremes.iter().zip(&other.extremes);
        self.extremes.len() == other.extremes.len()
            && pairs.into_iter().all(|(a, b)| a.distance(*b).is_some_and(|distance| distance <= NEAR))
    }
}

/// The extremes at a place in [0, 1] of the other axis, by rising amplitude; none where the backbone is
/// unknown.
pub(crate) type Extremes<'a> = &'a (dyn Fn(f64) -> Vec<Extreme> + Sync);

/// The curves in the unit square, with the damping along `damping_axis`, as fine as they are when `is_spent`.
pub fn graphs(extremes: Extremes, damping_axis: usize, is_spent: Spent) -> Vec<Branch> {
    let at = |share: f64| Section { share, extremes: extremes(share) };
    let shares: Vec<f64> = (0..=PARTS).map(|i| i as f64 / PARTS as f64).collect();
    let Some(nodes) = sections_at(&at, &shares, is_spent) else { return Vec::new() };
    let sections = refined(&at, nodes, is_spent);
    let place = |share: f64, height: f64| if damping_axis == 0 { [height, share] } else { [share, height] };
    let point = |&(share, extreme): &Followed| CurvePoint {
        place: place(share, extreme.height),
        error: extreme.error,
    };
    let inside = chains(&sections).into_iter().flat_map(|chain| clipped(extremes, &chain));
    let curves: Vec<Vec<Followed>> = inside.filter(|points| points.len() > 1).collect();
    curves.iter().map(|points| Branch { points: points.iter().map(point).collect(), closed: false }).collect()
}

/// The sections at these places; `None` if the budget is spent before all of them are computed.
fn sections_at(
    at: &(dyn Fn(f64) -> Section + Sync),
    shares: &[f64],
    is_spent: Spent,
) -> Option<Vec<Section>> {
    let mut sections = Vec::with_capacity(shares.len());
    for some in shares.chunks(BATCH) {
        if is_spent() {
            return None;
        }
        sections.par_extend(some.par_iter().map(|&share| at(share)));
    }
    Some(sections)
}

/// The sections with those that are needed between them. Gaps are halved together, level by level, as long as
/// the halves of all of them are within the limit; so the result does not depend on the order of the work.
fn refined(at: &(dyn Fn(f64) -> Section + Sync), nodes: Vec<Section>, is_spent: Spent) -> Vec<Section> {
    // Each section with whether the gap after it is to be halved.
    let last = nodes.len() - 1;
    let mut sections: Vec<(Section, bool)> =
        nodes.into_iter().enumerate().map(|(i, node)| (node, i < last)).collect();
    for _ in 0..HALVINGS {
        let open: Vec<usize> = (0..sections.len()).filter(|&i| sections[i].1).collect();
        if open.is_empty() || sections.len() + open.len() > MOST_SECTIONS {
            break;
        }
        let shares: Vec<f64> =
            open.iter().map(|&i| 0.5 * (sections[i].0.share + sections[i + 1].0.share)).collect();
        let Some(middles) = sections_at(at, &shares, is_spent) else { break };
        let is_smooth: Vec<bool> = open
            .iter()
            .zip(&middles)
            .map(|(&i, middle)| is_between(&sections[i].0, middle, &sections[i + 1].0))
            .collect();
        let mut halves = middles.into_iter().zip(is_smooth);
        let mut finer = Vec::with_capacity(sections.len() + open.len());
        for (section, is_open) in sections {
            match is_open.then(|| halves.next()).flatten() {
                None => finer.push((section, false)),
                Some((middle, is_smooth)) => finer.extend([(section, !is_smooth), (middle, !is_smooth)]),
            }
        }
        sections = finer;
    }
    sections.into_iter().map(|(section, _)| section).collect()
}

/// Whether the extremes of three sections correspond and lie on lines.
fn is_between(from: &Section, middle: &Section, to: &Section) -> bool {
    let mut ends = from.extremes.iter().zip(&to.extremes);
    from.corresponds(middle)
        && middle.corresponds(to)
        && middle
            .extremes
            .iter()
            .all(|middle| ends.next().is_some_and(|(from, to)| middle.is_on_chord(*from, *to)))
}

/// An extreme at a place of the other axis.
type Followed = (f64, Extreme);

/// The chains of corresponding extremes through all sections.
fn chains(sections: &[Section]) -> Vec<Vec<Followed>> {
    let mut chains: Vec<Vec<Followed>> = Vec::new();
    // The chain of each extreme of the section before.
    let mut before: Vec<usize> = Vec::new();
    for (number, section) in sections.iter().enumerate() {
        let links = match number {
            0 => vec![None; section.extremes.len()],
            _ => links(&sections[number - 1].extremes, &section.extremes),
        };
        before = section
            .extremes
            .iter()
            .zip(links)
            .map(|(extreme, link)| {
                let chain = link.map_or(chains.len(), |i: usize| before[i]);
                if chain == chains.len() {
                    chains.push(Vec::new());
                }
                chains[chain].push((section.share, *extreme));
                chain
            })
            .collect();
    }
    chains
}

/// For each extreme of `to`, the corresponding one of `from`: links keep the order and have the smallest sum
/// of distances.
fn links(from: &[Extreme], to: &[Extreme]) -> Vec<Option<usize>> {
    // The smallest cost of the first i and j extremes.
    let mut costs = vec![vec![0.0; to.len() + 1]; from.len() + 1];
    let linked = |costs: &[Vec<f64>], i: usize, j: usize| {
        from[i - 1].distance(to[j - 1]).map_or(f64::INFINITY, |distance| costs[i - 1][j - 1] + distance)
    };
    for i in 0..=from.len() {
        for j in 0..=to.len() {
            costs[i][j] = match (i, j) {
                (0, _) | (_, 0) => (i + j) as f64 * ALONE,
                _ => (costs[i - 1][j] + ALONE).min(costs[i][j - 1] + ALONE).min(linked(&costs, i, j)),
            };
        }
    }
    let mut links = vec![None; to.len()];
    let (mut i, mut j) = (from.len(), to.len());
    while i > 0 && j > 0 {
        if costs[i][j] == linked(&costs, i, j) {
            links[j - 1] = Some(i - 1);
            (i, j) = (i - 1, j - 1);
        } else if costs[i][j] == costs[i - 1][j] + ALONE {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    links
}

/// The parts of a chain within the plane, with their ends on its border.
fn clipped(extremes: Extremes, chain: &[Followed]) -> Vec<Vec<Followed>> {
    let is_inside = |followed: &Followed| (0.0..=1.0).contains(&followed.1.height);
    let mut parts: Vec<Vec<Followed>> = vec![Vec::new()];
    for (i, here) in chain.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &chain[i]);
        let crossed = before.filter(|before| is_inside(before) != is_inside(here));
        let end = crossed.and_then(|before| on_border(extremes, *before, *here));
        let last = parts.len() - 1;
        parts[last].extend(end);
        if is_inside(here) {
            parts[last].push(*here);
        } else if !parts[last].is_empty() {
            parts.push(Vec::new());
        }
    }
    parts
}

/// The end of a curve on the border of the plane, between an extreme inside and one outside.
fn on_border(extremes: Extremes, mut a: Followed, mut b: Followed) -> Option<Followed> {
    let level = if a.1.height.min(b.1.height) < 0.0 { 0.0 } else { 1.0 };
    for trial in 1..=TRIALS {
        let secant = (level - a.1.height) / (b.1.height - a.1.height);
        let part = if trial % 3 == 0 { 0.5 } else { secant };
        let share = a.0 + part * (b.0 - a.0);
        let expected = Extreme {
            amplitude: a.1.amplitude + part * (b.1.amplitude - a.1.amplitude),
            height: a.1.height + part * (b.1.height - a.1.height),
            ..a.1
        };
        let found = extremes(share).into_iter().filter_map(|it| Some((it.distance(expected)?, it)));
        let (_, found) = found.min_by(|x, y| x.0.total_cmp(&y.0))?;
        let off = found.height - level;
        if off.abs() <= ON_BORDER {
            return Some((share, Extreme { height: level, error: found.error + off.abs(), ..found }));
        }
        *(if (off > 0.0) == (a.1.height > level) { &mut a } else { &mut b }) = (share, found);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;

    #[test]
    fn extremes_that_die_and_are_born_are_not_joined() {
        // A pair of extremes of the same heights near r = 0.25 up to s = 0.4055, and near 0.75 from there on.
        let pair = |middle: f64| {
            let of = |amplitude: f64, height: f64, is_maximum: bool| Extreme {
                amplitude,
                height,
                error: 0.0,
                is_maximum,
            };
            vec![of(middle - 0.1, 0.4, true), of(middle + 0.1, 0.3, false)]
        };
        let at = |s: f64| pair(if s < 0.4055 { 0.25 } else { 0.75 });
        let curves = graphs(&at, 1, &|| false);
        assert_eq!(curves.len(), 4, "{curves:?}");
        for curve in curves {
            let left = curve.points.iter().all(|point| point.place[0] < 0.4055);
            let right = curve.points.iter().all(|point| point.place[0] > 0.4055);
            assert!(left || right, "{curve:?}");
        }
    }

    /// Extremes of a noisy backbone, which do not correspond anywhere: the work is bounded, and spread
    /// evenly.
    #[test]
    fn noise_does_not_multiply_the_sections() {
        let sections = std::sync::Mutex::new(Vec::new());
        let at = |s: f64| {
            sections.lock().unwrap().push(s);
            let height = 0.3 + 0.4 * Random(s.to_bits()).unit();
            vec![Extreme { amplitude: 0.5, height, error: 0.0, is_maximum: true }]
        };
        let points: usize = graphs(&at, 1, &|| false).iter().map(|curve| curve.points.len()).sum();
        let mut sections = sections.into_inner().unwrap();
        sections.sort_by(f64::total_cmp);
        assert!(points <= MOST_SECTIONS && sections.len() <= MOST_SECTIONS, "{points} {}", sections.len());
        let widest = sections.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        // Some three sections correspond by chance.
        assert!(sections.len() > MOST_SECTIONS / 2 && widest < 1.5 / PARTS as f64, "{widest}");
    }

    #[test]
    fn curves_end_on_the_border() {
        let at = |s: f64| {
            vec![Extreme {
                amplitude: 0.5,
                height: 1.7 * s - 0.3 + 0.1 * s * s,
                error: 0.0,
                is_maximum: true,
            }]
        };
        let curves = graphs(&at, 1, &|| false);
        assert_eq!(curves.len(), 1);
        let [first, last] = [curves[0].points[0], *curves[0].points.last().unwrap()].map(|point| point.place);
        assert!(first[1] == 0.0 && (at(first[0])[0].height).abs() < 1e-9, "{first:?}");
        assert!(last[1] == 1.0 && (at(last[0])[0].height - 1.0).abs() < 1e-9, "{last:?}");
    }
}
