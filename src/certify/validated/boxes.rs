//! Whole boxes of the Stribeck oscillator's parameters: what part of the volume is proved.
//!
//! Two subdivisions work together. The universal surface C*(A, k, b) is proved on pieces of the image of
//! the box ([`super::surface`]); it is an explicit function, so that the c axis needs no subdivision: of
//! every column all is decided but the width of its enclosure. The box itself is cut where the landing is
//! not yet proved, or where pieces of different quality meet.
//!
//! Every point (epsilon, alpha, beta, gamma, V, c) of the box is then in one of three sets: proved present
//! (c at or above the damping from which the landing is proved in its part of the box, and eps c below the
//! enclosure of C*), proved absent (eps c above it), undecided. Membership is a theorem at every real
//! point. The volume of the undecided set is bounded rigorously from above; all three volumes are also
//! measured on a fixed low-discrepancy set of columns.

use super::defect::Groups;
use super::even_part_bounds;
use super::interval::Interval;
use super::landing::Flow;
use super::surface::Surface;
use super::tile::GroupBox;

/// Columns on which volumes are measured.
const SAMPLES: usize = 1 << 14;
/// `sticks_from` of a part is located to 2^-6 of the range of c.
const HALVINGS: u32 = 6;
/// Pieces that hold no more than this share of the undecided volume aimed at are left alone.
const NEGLIGIBLE: f64 = 1e-9;

/// Ranges of the six parameters of the Stribeck oscillator; their ends are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterBox {
    /// Range of epsilon > 0.
    pub epsilon: [f64; 2],
    /// Range of alpha in [0, 1].
    pub alpha: [f64; 2],
    /// Range of beta >= 0.
    pub beta: [f64; 2],
    /// Range of gamma >= 0.
    pub gamma: [f64; 2],
    /// Range of the belt speed V > 0.
    pub belt_speed: [f64; 2],
    /// Range of the damping c >= 0, of positive width.
    pub damping: [f64; 2],
}

/// How far to subdivide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Proofs of tiles of the universal surface.
    pub tiles: usize,
    /// Parts of the parameter box.
    pub parts: usize,
}

/// Shares of the box's volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volumes {
    /// Proved present, as measured.
    pub present: f64,
    /// Proved absent, as measured.
    pub absent: f64,
    /// Neither, as measured.
    pub undecided: f64,
    /// Proved upper bound of the undecided share.
    pub undecided_at_most: f64,
    /// Proofs of tiles tried.
    pub tiles: usize,
    /// Parts of the parameter box.
    pub parts: usize,
}

/// The five ranges without the damping.
type Ranges = [[f64; 2]; 5];

/// A box in the course of being proved.
pub struct BoxProof {
    ranges: Ranges,
    damping: [f64; 2],
    surface: Surface,
    columns: Vec<Sampled>,
    parts: Vec<Part>,
}

/// A column on which volumes are measured.
#[derive(Clone, Copy, Debug)]
struct Sampled {
    at: [f64; 5],
    groups: [f64; 3],
}

/// A part of the parameter box.
#[derive(Clone, Debug)]
struct Part {
    ranges: Ranges,
    /// Indices of the sampled columns in it.
    columns: Vec<usize>,
    judged: Judged,
}

/// What is known of a part.
#[derive(Clone, Copy, Debug)]
struct Judged {
    /// The landing is proved from this damping on.
    sticks_from: f64,
    /// Bound on the undecided share of the whole box that lies in this part.
    undecided: f64,
}

impl BoxProof {
    /// A box of which nothing is proved yet.
    #[must_use]
    pub fn new(parameters: &ParameterBox) -> Self {
        let ParameterBox { epsilon, alpha, beta, gamma, belt_speed, damping } = *parameters;
        let ranges = [epsilon, alpha, beta, gamma, belt_speed];
        let columns: Vec<Sampled> = (0..SAMPLES).map(|i| Sampled::new(&ranges, i)).collect();
        let surface = Surface::new(GroupBox::around(&groups(&ranges)));
        let mut proof = Self { ranges, damping, surface, columns, parts: Vec::new() };
        let judged = proof.judge(&ranges);
        proof.parts.push(Part { ranges, columns: (0..SAMPLES).collect(), judged });
        proof
    }

    /// Subdivides up to the budget.
    pub fn refine(&mut self, budget: Budget) {
        let columns = &self.columns;
        let share = |domain: &GroupBox| {
            let inside = |column: &&Sampled| {
                domain.ranges().iter().zip(column.groups).all(|(range, x)| range[0] <= x && x <= range[1])
            };
            columns.iter().filter(inside).count() as f64 / SAMPLES as f64
        };
        let width = (self.damping[1] - self.damping[0]) * self.ranges[0][0];
        self.surface.refine(budget.tiles, NEGLIGIBLE * width, &share);
        // Widths may have changed everywhere.
        for part in 0..self.parts.len() {
            self.parts[part].judged = self.judge(&self.parts[part].ranges);
        }
        while self.parts.len() < budget.parts {
            let worse = |i: &usize, j: &usize| {
                let undecided = |at: usize| self.parts[at].judged.undecided;
                undecided(*i).total_cmp(&undecided(*j)).then(j.cmp(i))
            };
            let Some(worst) = (0..self.parts.len()).max_by(worse) else { return };
            if !(self.parts[worst].judged.undecided > NEGLIGIBLE) {
                return;
            }
            let Some(halves) = self.best_halves(&self.parts[worst].ranges) else { return };
            let part = self.parts.swap_remove(worst);
            let (low, high): (Vec<usize>, Vec<usize>) =
                part.columns.iter().partition(|&&column| inside(&halves[0].0, &self.columns[column]));
            for ((ranges, judged), columns) in halves.into_iter().zip([low, high]) {
                self.parts.push(Part { ranges, columns, judged });
            }
        }
    }

    /// The halves along the axis that leaves least undecided.
    fn best_halves(&self, ranges: &Ranges) -> Option<[(Ranges, Judged); 2]> {
        let wide = (0..5).filter(|&axis| ranges[axis][0] < ranges[axis][1]);
        let candidates = wide.map(|axis| {
            let [lo, hi] = ranges[axis];
            let middle = 0.5 * (lo + hi);
            [[lo, middle], [middle, hi]].map(|half| {
                let mut ranges = *ranges;
                ranges[axis] = half;
                (ranges, self.judge(&ranges))
            })
        });
        let left = |halves: &[(Ranges, Judged); 2]| halves[0].1.undecided + halves[1].1.undecided;
        // Where no half is better, the largest extent relative to the whole box is cut.
        let extent = |halves: &[(Ranges, Judged); 2]| {
            (0..5)
                .map(|axis| (halves[0].0[axis][1] - halves[0].0[axis][0], self.ranges[axis]))
                .filter(|(_, [lo, hi])| hi > lo)
                .map(|(width, [lo, hi])| width / (hi - lo))
                .fold(0.0, f64::max)
        };
        candidates
            .min_by(|one, two| left(one).total_cmp(&left(two)).then(extent(one).total_cmp(&extent(two))))
    }

    /// Bounds what is undecided in a part.
    fn judge(&self, ranges: &Ranges) -> Judged {
        let [c_lo, c_hi] = self.damping;
        let groups = groups(ranges);
        let epsilon = Interval::new(ranges[0][0], ranges[0][1]);
        let belt_speed = Interval::new(ranges[4][0], ranges[4][1]);
        // The extremes of C* are at opposite corners.
        let even = even_part_bounds(&groups).over(epsilon);
        if even.hi < c_lo {
            return Judged { sticks_from: c_lo, undecided: 0.0 };
        }
        let lands = |c: f64| Flow { groups, viscous: epsilon * Interval::of(c), belt_speed }.lands();
        let sticks_from = if lands(c_lo) {
            c_lo
        } else if !lands(c_hi) {
            c_hi
        } else {
            let (mut failed, mut verified) = (c_lo, c_hi);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (failed + verified);
                if lands(middle) { verified = middle } else { failed = middle }
            }
            verified
        };
        let whole = Interval::of(c_hi) - Interval::of(c_lo);
        let around_critical = match even.lo > c_hi {
            true => Interval::ZERO,
            false => Interval::of(self.surface.width(&GroupBox::around(&groups))).over(epsilon),
        };
        let open = Interval::of(around_critical.hi) + Interval::of(sticks_from) - Interval::of(c_lo);
        let share = Interval::of(open.over(whole).hi.min(1.0)) * self.share(ranges);
        // Rounding alone is not undecided: where both parts are 0 so is their sum.
        let nothing = around_critical.hi == 0.0 && sticks_from == c_lo;
        Judged { sticks_from, undecided: if nothing { 0.0 } else { share.hi } }
    }

    /// Volume of a part as a share of the whole.
    fn share(&self, ranges: &Ranges) -> Interval {
        let wide = ranges.iter().zip(self.ranges).filter(|(_, [lo, hi])| lo < hi);
        wide.fold(Interval::ONE, |share, ([lo, hi], [whole_lo, whole_hi])| {
            let width = Interval::of(*hi) - Interval::of(*lo);
            share * width.over(Interval::of(whole_hi) - Interval::of(whole_lo))
        })
    }

    /// The volumes proved so far.
    #[must_use]
    pub fn volumes(&self) -> Volumes {
        let [c_lo, c_hi] = self.damping;
        let (mut present, mut absent) = (0.0, 0.0);
        for part in &self.parts {
            for &column in &part.columns {
                let Sampled { at, groups: [a, k, b] } = self.columns[column];
                let groups = Groups { a: Interval::of(a), k: Interval::of(k), b: Interval::of(b) };
                let critical = self.surface.critical(&groups).over(Interval::of(at[0]));
                present += (critical.lo.min(c_hi) - part.judged.sticks_from).max(0.0);
                absent += (c_hi - critical.hi.max(c_lo)).max(0.0);
            }
        }
        let all = SAMPLES as f64 * (c_hi - c_lo);
        let sum =
            self.parts.iter().fold(Interval::ZERO, |sum, part| sum + Interval::of(part.judged.undecided));
        let (present, absent) = (present / all, absent / all);
        Volumes {
            present,
            absent,
            undecided: (1.0 - present - absent).max(0.0),
            undecided_at_most: sum.hi.clamp(0.0, 1.0),
            tiles: self.surface.tried(),
            parts: self.parts.len(),
        }
    }

    /// The surface as far as it is proved.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }
}

impl Sampled {
    /// The `i`-th column of a sequence that fills the box evenly: multiples of powers of 1/g, g^6 = g + 1,
    /// modulo 1 (Roberts' sequence in five dimensions).
    fn new(ranges: &Ranges, i: usize) -> Self {
        const G: f64 = 1.134_724_138_401_519_3;
        let at: [f64; 5] = std::array::from_fn(|axis| {
            let [lo, hi] = ranges[axis];
            let unit = (0.5 + (i + 1) as f64 / G.powi(axis as i32 + 1)).fract();
            lo + (hi - lo) * unit
        });
        let [epsilon, alpha, beta, gamma, belt_speed] = at;
        let rate = epsilon * gamma;
        Self { at, groups: [rate * (1.0 - alpha), rate * belt_speed, epsilon * beta * belt_speed] }
    }
}

/// Whether the column is in the part.
fn inside(ranges: &Ranges, column: &Sampled) -> bool {
    ranges.iter().zip(column.at).all(|([lo, hi], x)| *lo <= x && x <= *hi)
}

/// The ranges of the scaled groups over a part.
fn groups(ranges: &Ranges) -> Groups {
    let [epsilon, alpha, beta, gamma, belt_speed] = ranges.map(|[lo, hi]| Interval::new(lo, hi));
    let rate = epsilon * gamma;
    Groups {
        a: (rate * (Interval::ONE - alpha)).at_least_zero(),
        k: (rate * belt_speed).at_least_zero(),
        b: (epsilon * beta * belt_speed).at_least_zero(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> ParameterBox {
        ParameterBox {
            epsilon: [0.05, 0.05],
            alpha: [0.0, 0.95],
            beta: [0.0, 0.1],
            gamma: [0.1, 1.0],
            belt_speed: [0.2, 1.5],
            damping: [0.0, 1.0],
        }
    }

    #[test]
    fn more_subdivision_leaves_less() {
        let mut proof = BoxProof::new(&parameters());
        let mut last = f64::INFINITY;
        for (tiles, parts) in [(0, 1), (0, 64), (1, 128), (3, 128)] {
            proof.refine(Budget { tiles, parts });
            let volumes = proof.volumes();
            assert!(volumes.undecided_at_most < last, "{volumes:?}");
            // Measured on 16384 columns: good to a few thousandths of the whole.
            assert!(volumes.undecided <= volumes.undecided_at_most + 0.005, "{volumes:?}");
            last = volumes.undecided_at_most;
        }
        assert!(last < 1e-4, "{last}");
    }

    /// The sets that the volumes are of, against the columns' own proofs.
    #[test]
    fn the_box_and_its_columns_agree() {
        let mut proof = BoxProof::new(&parameters());
        proof.refine(Budget { tiles: 1, parts: 16 });
        for column in proof.columns.iter().step_by(97) {
            let [epsilon, alpha, beta, gamma, belt_speed] = column.at;
            let single = crate::certify::test_columns::stribeck(epsilon, alpha, beta, gamma, belt_speed);
            let own = crate::certify::validated::Enclosed::of(&single).unwrap().critical();
            let [a, k, b] = column.groups.map(Interval::of);
            let whole = proof.surface.critical(&Groups { a, k, b });
            assert!(whole.lo <= own.lo && own.hi <= whole.hi, "{column:?} {own:?} {whole:?}");
        }
    }
}
