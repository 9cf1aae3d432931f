//! The critical damping over a whole box of (A, k, b) by one proof.
//!
//! Approximate grazing orbits at Chebyshev points of the box are interpolated: C0 and every Fourier
//! coefficient of r0 become polynomials of the degrees `DEGREES` in A, k and b. The defect polynomial G of
//! `defect` is then a polynomial in the parameters too, of four times those degrees plus 0, 2 and 1:
//! with A = middle + half-width cos t it is a trigonometric polynomial in t, and samples at Chebyshev points
//! bound it as they do in theta. The bounds of the cells are taken over the box.

use rayon::prelude::*;

use super::circle::{Circle, reach, riesz_factor};
use super::defect::{Bounds, Candidates, Factors, Groups, LANES, Sampled, radius_of_proof, sampling};
use super::orbit::{Guess, Orbit, approximate};
use slipmap_numbers::interval::Interval;

/// Degrees of the candidates in A, k and b. D is linear in A and b but not in k.
pub(super) const DEGREES: [usize; 3] = [2, 8, 2];
/// The largest of these degrees.
pub(super) const HIGHEST: usize = 8;
/// Size of a harmonic, relative to the first, below which it is left out.
const NEGLIGIBLE: f64 = 1e-12;
/// Coefficients are multiples of this, so that they are short in a file.
pub(crate) const UNIT: f64 = 1.0 / (1u64 << 46) as f64;
/// Numbers of Chebyshev points; four times each is the size of a circle of [`super::circle`].
const POINTS: [usize; 6] = [8, 12, 16, 24, 32, 48];
/// Largest product x of a degree and the reach of the samples; 1/cos x is their factor.
const LARGEST_ANGLE: f64 = 1.3;

/// A box of the scaled groups; its ends are exact.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupBox {
    /// Range of A = eps gamma (1 - alpha).
    #[serde(rename = "A")]
    pub a: [f64; 2],
    /// Range of k = eps gamma V.
    pub k: [f64; 2],
    /// Range of b = eps beta V.
    pub b: [f64; 2],
}

impl GroupBox {
    /// The three ranges, A, k, b.
    #[must_use]
    pub fn ranges(&self) -> [[f64; 2]; 3] {
        [self.a, self.k, self.b]
    }

    /// The halves of the box along one of its three axes.
    pub(crate) fn halves(&self, axis: usize) -> [GroupBox; 2] {
        let [lo, hi] = self.ranges()[axis];
        let middle = 0.5 * (lo + hi);
        [[lo, middle], [middle, hi]].map(|half| {
            let mut ranges = self.ranges();
            ranges[axis] = half;
            let [a, k, b] = ranges;
            GroupBox { a, k, b }
        })
    }

    /// Returns whether the boxes have a point in common.
    pub(crate) fn meets(&self, other: &GroupBox) -> bool {
        self.ranges().iter().zip(other.ranges()).all(|(one, two)| one[0] <= two[1] && two[0] <= one[1])
    }

    /// The smallest box that holds these groups.
    pub(super) fn around(groups: &Groups) -> Self {
        let [a, k, b] = [groups.a, groups.k, groups.b].map(|x| [x.lo, x.hi]);
        Self { a, k, b }
    }

    pub(super) fn groups(&self) -> Groups {
        let [a, k, b] = self.ranges().map(|[lo, hi]| Interval::new(lo, hi));
        Groups { a, k, b }
    }
}

/// An enclosure proved over a box: |C*(A, k, b) - polynomial| <= `radius`.
///
/// Polynomials are sums over modes, number i + 3 (j + 9 l) the mode T_i T_j T_l of the Chebyshev polynomials
/// in A, k and b scaled to [-1, 1] over the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub(crate) domain: GroupBox,
    /// The proved bound on |C* - polynomial|.
    pub(crate) radius: f64,
    /// The polynomial, by modes; every coefficient is a multiple of [`UNIT`].
    pub(crate) viscous: Vec<f64>,
    /// The witness: r0 = 1 + sum over n of cosines\[n-1\] (cos n theta - 1) + sines\[n-1\] sin n theta, each
    /// by modes.
    pub(crate) cosines: Vec<Vec<f64>>,
    /// The sines of the witness, as `cosines`.
    pub(crate) sines: Vec<Vec<f64>>,
}

/// Number of modes.
pub(crate) const MODES: usize = (DEGREES[0] + 1) * (DEGREES[1] + 1) * (DEGREES[2] + 1);

/// The degrees of mode `mode` in A, k, b.
pub(super) fn degrees(mode: usize) -> [usize; 3] {
    let [one, two, _] = DEGREES.map(|degree| degree + 1);
    [mode % one, mode / one % two, mode / (one * two)]
}

impl Tile {
    /// Proves an enclosure of C* over the box; `None` where the proof fails.
    #[must_use]
    pub fn prove(domain: GroupBox) -> Option<Tile> {
        let mut tile = interpolate(domain)?;
        let (circle, factors) = sampling(tile.cosines.len())?;
        let (sampled, factors) = tile.survey(circle, factors)?;
        tile.radius = radius_of_proof(&domain.groups(), &Bounds::new(&sampled, &factors), circle)?;
        Some(tile)
    }

    /// Samples the candidates at points of the box; returns the samples and the factors from them to bounds.
    fn survey(&self, circle: &Circle, factors: Factors) -> Option<(Sampled, Factors)> {
        let domain = self.domain;
        let axes = [0, 1, 2].map(|axis| Samples::new(&domain, axis));
        let [a, k, b] = &axes;
        let (a, k, b) = (a.as_ref()?, k.as_ref()?, b.as_ref()?);
        let factors = Factors {
            defect: product(&[factors.defect, a.defect, k.defect, b.defect]),
            radius: product(&[a.radius, k.radius, b.radius]),
            slope: product(&[factors.slope, a.radius, k.radius, b.radius]),
        };
        let total = a.nodes.len() * k.nodes.len() * b.nodes.len();
        let node = |at: usize| {
            let (rest, one) = (at / a.nodes.len(), at % a.nodes.len());
            [&a.nodes[one], &k.nodes[rest % k.nodes.len()], &b.nodes[rest / k.nodes.len()]]
        };
        // Maxima and hulls do not depend on the order of the samples, nor on one taken twice.
        let sampled = (0..total.div_ceil(LANES))
            .into_par_iter()
            .map(|group| {
                let nodes = std::array::from_fn(|lane| node((LANES * group + lane).min(total - 1)));
                Some(self.sample(nodes, circle))
            })
            .reduce(
                || None,
                |one, two| match (one, two) {
                    (Some(one), Some(two)) => Some(one.with(&two)),
                    (one, two) => one.or(two),
                },
            )?;
        Some((sampled, factors))
    }

    /// Samples the candidates at some points of the box.
    fn sample(&self, nodes: [[&Node; 3]; LANES], circle: &Circle) -> Sampled {
        let mut weights = [[0.0; LANES]; MODES];
        let mut viscous = [Interval::ZERO; LANES];
        for (mode, weights) in weights.iter_mut().enumerate() {
            let [i, j, l] = degrees(mode);
            for (lane, [a, k, b]) in nodes.iter().enumerate() {
                let exact = a.chebyshev[i] * k.chebyshev[j] * b.chebyshev[l];
                viscous[lane] = viscous[lane] + Interval::of(self.viscous[mode]) * exact;
                weights[lane] = 0.5 * (exact.lo + exact.hi);
            }
        }
        // A weight, of size at most 1, is known to within its interval's width, far below 32 units; a sum of
        // products of MODES terms rounds by at most (MODES + 1) units of their sizes.
        let mut most: f64 = 0.0;
        let mut sums = |rows: &[Vec<f64>]| -> Vec<[f64; LANES]> {
            let mut sums = Vec::with_capacity(rows.len());
            for row in rows {
                most = most.max(row.iter().map(|c| c.abs()).sum());
                let mut sum = [0.0; LANES];
                for (c, weights) in row.iter().zip(&weights) {
                    for (sum, weight) in sum.iter_mut().zip(weights) {
                        *sum += c * weight;
                    }
                }
                sums.push(sum);
            }
            sums
        };
        let (cosines, sines) = (sums(&self.cosines), sums(&self.sines));
        let width = |node: &Node| node.chebyshev.iter().map(|t| t.hi - t.lo).fold(0.0, f64::max);
        let widest = nodes.iter().map(|nodes| nodes.iter().map(|node| width(node)).sum::<f64>());
        let unit = (MODES as f64 + 4.0) * f64::EPSILON + 4.0 * widest.fold(0.0, f64::max);
        let candidates = Candidates {
            groups: nodes.map(|[a, k, b]| Groups { a: a.value, k: k.value, b: b.value }),
            viscous,
            cosines: &cosines,
            sines: &sines,
            error: unit * most + f64::MIN_POSITIVE,
        };
        Sampled::of(&candidates, circle)
    }

    /// The axis along which the candidates are least resolved.
    pub(super) fn roughest_axis(&self) -> usize {
        let rough = |axis: usize| -> f64 {
            let rows = self.cosines.iter().chain(&self.sines).chain([&self.viscous]);
            let top = rows.flat_map(|row| {
                row.iter().enumerate().filter(|(mode, _)| degrees(*mode)[axis] == DEGREES[axis])
            });
            top.map(|(_, c)| c.abs()).sum()
        };
        (0..3).max_by(|&i, &j| rough(i).total_cmp(&rough(j))).unwrap_or(0)
    }
}

fn product(factors: &[f64]) -> f64 {
    factors.iter().fold(Interval::ONE, |product, &factor| product * Interval::of(factor)).hi
}

/// A Chebyshev point of one parameter.
struct Node {
    /// The parameter.
    value: Interval,
    /// T_0, T_1, .. at that parameter.
    chebyshev: [Interval; HIGHEST + 1],
}

/// The Chebyshev points of one parameter, and the factors of the samples there.
struct Samples {
    nodes: Vec<Node>,
    defect: f64,
    radius: f64,
}

impl Samples {
    fn new(domain: &GroupBox, axis: usize) -> Option<Self> {
        let [lo, hi] = domain.ranges()[axis];
        if lo == hi {
            let mut chebyshev = [Interval::ZERO; HIGHEST + 1];
            chebyshev[0] = Interval::ONE;
            let node = Node { value: Interval::of(lo), chebyshev };
            return Some(Self { nodes: vec![node], defect: 1.0, radius: 1.0 });
        }
        let degree = 4 * DEGREES[axis] + [0, 2, 1][axis];
        // In t, points are pi/n apart.
        let enough = |n: &usize| degree as f64 * std::f64::consts::PI / (2 * n) as f64 <= LARGEST_ANGLE;
        let count = POINTS.into_iter().find(enough)?;
        let circle = Circle::with_at_least(4 * count).filter(|circle| circle.size() == 4 * count)?;
        let half = Interval::of(0.5);
        let (low, high) = (Interval::of(lo), Interval::of(hi));
        let nodes = (0..count)
            .map(|j| {
                let chebyshev = std::array::from_fn(|n| circle.cos(n * (2 * j + 1)));
                let value = half * (low + high) + half * (high - low) * chebyshev[1];
                Node { value, chebyshev }
            })
            .collect();
        let reach = reach(2 * count);
        Some(Self { nodes, defect: riesz_factor(degree, reach), radius: riesz_factor(DEGREES[axis], reach) })
    }
}

/// Interpolates approximate orbits at as many Chebyshev points of each parameter as it has modes.
fn interpolate(domain: GroupBox) -> Option<Tile> {
    let table = |axis: usize, i: usize, n: usize| {
        (std::f64::consts::PI * (n * (2 * i + 1)) as f64 / (2 * DEGREES[axis] + 2) as f64).cos()
    };
    let point = |axis: usize, i: usize| {
        let [lo, hi] = domain.ranges()[axis];
        0.5 * (lo + hi) + 0.5 * (hi - lo) * table(axis, i, 1)
    };
    let orbits = (0..MODES)
        .into_par_iter()
        .map(|mode| {
            let [i, j, l] = degrees(mode);
            approximate(Guess { a: point(0, i), k: point(1, j), b: point(2, l) })
        })
        .collect::<Option<Vec<Orbit>>>()?;
    // Harmonics below the error of the interpolation would only cost time.
    let size = |orbit: &Orbit, n: usize| {
        let at = |row: &[f64]| row.get(n).map_or(0.0, |c| c.abs());
        at(&orbit.cosines).max(at(&orbit.sines))
    };
    let harmonics = orbits.iter().map(|orbit| orbit.cosines.len()).max()?;
    let largest = orbits.iter().map(|orbit| size(orbit, 0)).fold(0.0, f64::max);
    let counts = |n: &usize| orbits.iter().any(|orbit| size(orbit, *n) > NEGLIGIBLE * largest);
    let harmonics = (0..harmonics).rev().find(counts).map_or(0, |last| last + 1);
    // Zero-width axes need the constant mode alone; all their points coincide.
    let flat = domain.ranges().map(|[lo, hi]| lo == hi);
    let modes = |value: &dyn Fn(&Orbit) -> f64| -> Vec<f64> {
        (0..MODES)
            .map(|mode| {
                let wanted = degrees(mode);
                if (0..3).any(|axis| flat[axis] && wanted[axis] > 0) {
                    return 0.0;
                }
                let share =
                    |axis: usize| (if wanted[axis] == 0 { 1.0 } else { 2.0 }) / (DEGREES[axis] + 1) as f64;
                let sum: f64 = orbits
                    .iter()
                    .enumerate()
                    .map(|(at, orbit)| {
                        let at = degrees(at);
                        value(orbit) * (0..3).map(|axis| table(axis, at[axis], wanted[axis])).product::<f64>()
                    })
                    .sum();
                (sum * (0..3).map(share).product::<f64>() / UNIT).round() * UNIT
            })
            .collect()
    };
    let harmonic = |row: fn(&Orbit) -> &Vec<f64>, n: usize| {
        modes(&move |orbit: &Orbit| row(orbit).get(n).copied().unwrap_or(0.0))
    };
    Some(Tile {
        domain,
        radius: f64::INFINITY,
        viscous: modes(&|orbit| orbit.viscous),
        cosines: (0..harmonics).map(|n| harmonic(|orbit| &orbit.cosines, n)).collect(),
        sines: (0..harmonics).map(|n| harmonic(|orbit| &orbit.sines, n)).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chebyshev points lie inside a box, so its corners show what the samples miss.
    #[test]
    fn bounds_hold_between_the_samples_and_samples_alone_do_not() {
        let domain = GroupBox { a: [0.1, 0.3], k: [0.15, 0.4], b: [0.0, 0.05] };
        let tile = interpolate(domain).unwrap();
        let (circle, factors) = sampling(tile.cosines.len()).unwrap();
        let (sampled, factors) = tile.survey(circle, factors).unwrap();
        let bounds = Bounds::new(&sampled, &factors);
        let samples_alone = Bounds::new(&sampled, &Factors { defect: 1.0, radius: 1.0, slope: 1.0 });
        let mut missed = 0;
        for corner in 0..8 {
            let node = |axis: usize| {
                let end = corner >> axis & 1;
                // T_n(1) = 1, T_n(-1) = (-1)^n.
                let chebyshev =
                    std::array::from_fn(|n| Interval::of(if end == 0 && n % 2 == 1 { -1.0 } else { 1.0 }));
                Node { value: Interval::of(domain.ranges()[axis][end]), chebyshev }
            };
            let there = tile.sample([[&node(0), &node(1), &node(2)]; LANES], circle);
            assert!(there.is_within(&bounds), "{corner}");
            missed += u32::from(!there.is_within(&samples_alone));
        }
        // C0 is nearly linear: its least and largest values are at corners.
        assert!(missed >= 2, "{missed}");
    }

    #[test]
    fn halving_a_tile_sharpens_the_proof() {
        let whole = GroupBox { a: [0.1, 0.2], k: [0.2, 0.2], b: [0.0, 0.0] };
        let radius = |domain| Tile::prove(domain).unwrap().radius;
        // Third order in the width.
        let [low, high] = whole.halves(0).map(radius);
        assert!(low.max(high) < radius(whole) / 5.0, "{low} {high} {}", radius(whole));
    }
}
