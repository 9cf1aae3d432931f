//! A second proof of every tile of the universal surface, by another argument, in other arithmetic.
//!
//! A [`Tile`] claims that |C* - C0| <= eta over a box of (A, k, b), C0 a polynomial. It was found with
//! Gronwall's lemma, samples and M. Riesz's inequality, in interval arithmetic ([`super::validated`]). This
//! module uses none of that: it reads only the numbers of the tile, and proves the statement again.
//!
//! # Barriers
//! In the scaled groups (see [`super::validated`]) the flow is v' = w, w' = -v + D w, D = A/q^2 - E, with q =
//! 1 + k s, E = C + 2 b s, s = 1 - v. Let rho be a 2 pi-periodic positive function with rho(0) = 1, and q > 0
//! on the closed curve v = rho cos theta, w = -rho sin theta, which bounds a region Omega around the origin.
//! As r' = D r sin^2 and theta' = 1 + D sin cos, orbits cross the curve outwards wherever r' - rho'(theta)
//! theta' > 0 on it, that is where G < 0, and inwards where G > 0, with
//!
//! ```text
//! G = rho' (q^2 + N sin cos) - N rho sin^2,      N = q^2 D = A - q^2 E.
//! ```
//!
//! **If G < 0 on the whole curve, the orbit from (1, 0) comes back to the belt line v = 1 or runs away.**
//! *Proof.* The orbit starts on the curve and stays outside afterwards. As long as v < 1 and w < 0, v falls.
//! If the orbit does not run away it reaches w = 0, since the only equilibrium is the origin, inside; and
//! there v < 0, since the positive axis up to 1 is inside too. Then w > 0 and v rises; w cannot vanish again
//! at v < 0, where w' = -v > 0, nor between 0 and 1, inside. So the orbit passes v = 1, or runs away. []
//!
//! **If G > 0 on the whole curve, it neither comes back nor runs away.** *Proof.* The orbit, continued beyond
//! the belt line by the same formula (Omega is star-shaped, so that s is least, and q > 0 certain, on the
//! curve), stays inside. If it passed v = 1 upwards, v would rise further until w = 0, which must happen,
//! since Omega is bounded and has no equilibrium there; but on the positive axis Omega ends at v = 1. []
//!
//! The polar angle need not be monotone in time, and no solution is followed. By monotonicity in C
//! ([`super::validated`]) a barrier of the first kind at C = C0 - eta and one of the second kind at C0 + eta
//! prove the tile's claim.
//!
//! # The barriers
//! Let r0 be the tile's witness, rho = r0 + t sigma and C = C0 - t with sigma = -sin(2 theta)/4, which
//! vanishes at 0. Then rho(0) = 1 for all t, and G(t = 0) is the tile's defect, close to 0. With a dot for
//! the derivative by t, s. = -sigma cos, (q^2). = -2 k q sigma cos, E. = -1 - 2 b sigma cos:
//!
//! ```text
//! H := -G. = q^2 (rho sin^2 - sigma') - sigma' N sin cos - rho' ((q^2). + N. sin cos) + (N. - q^2) rho sin^2 + N sigma sin^2,
//! N. = -(q^2). E - q^2 E.
//! ```
//!
//! Since sigma' = sin^2 - 1/2, the first term is about q^2/2 wherever r0 is about 1. If H >= h > 0 for |t| <=
//! eta and |G| <= g at t = 0, then G(eta) <= g - eta h and G(-eta) >= eta h - g: **g < eta h proves the
//! tile.**
//!
//! # The bounds
//! h: `Ball`s over cells of the angle and of the box. g: at each of a mesh of exact points of the box, G is
//! computed as a Fourier series (`series`), whose coefficients' absolute values bound it at every angle.
//! Between the points: in A = middle + half-width cos t (k and b likewise) G is a trigonometric polynomial of
//! degree d, four times that of the tile's polynomials plus 0, 2, 1. Where |G| is largest, at t*, its slope
//! vanishes, and by Bernstein's inequality (|G''| <= d^2 max |G|) at a point within delta of t* |G| is at
//! least the share 1 - (d delta)^2 / 2 of its maximum.

mod ball;
mod growth;
mod partition;
mod series;

use rayon::prelude::*;

use super::validated::tile::{GroupBox, Tile};
use ball::Ball;
pub use partition::{Fault, divides};
use series::Series;

/// Degrees of a tile's polynomials in A, k and b; modes are numbered i + 3 (j + 9 l).
const DEGREES: [usize; 3] = [2, 8, 2];
const HIGHEST: usize = 8;
const MODES: usize = 3 * 9 * 3;
/// Number of points of the mesh for each degree of G.
const DENSITY: f64 = 1.75;
/// Largest value of a Chebyshev polynomial at a point of the mesh, which approximates its zero.
const OFF_ZERO: f64 = 1e-3;

/// Reason why a tile is not confirmed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// Its numbers are malformed: wrong numbers of coefficients, or an invalid box or radius.
    #[error("its coefficients, its box or its radius are not ones that the format allows")]
    Malformed,
    /// The witness is not a barrier: it is not positive, reaches the pole of the friction law, or is too
    /// steep.
    #[error("orbits may cross its curve, which then proves nothing")]
    NoBarrier,
    /// The claim is sharper than the witness proves.
    #[error("its curve proves the critical damping up to an error of {proved:.3e} only")]
    TooSharp {
        /// The smallest radius that it proves.
        proved: f64,
    },
}

/// Proves the tile's claim again. Returns the smallest radius that this proof gives, which is less than the
/// tile's.
///
/// # Errors
/// [`Doubt`], if the proof does not go through.
pub fn verify(tile: &Tile) -> Result<f64, Doubt> {
    if !well_formed(tile) {
        return Err(Doubt::Malformed);
    }
    let growth = growth::least(tile, tile.radius).ok_or(Doubt::NoBarrier)?;
    let defect = defect(tile).ok_or(Doubt::Malformed)?;
    // The factor covers the roundings.
    let proved = defect / growth * (1.0 + 1e-9);
    if proved < tile.radius { Ok(proved) } else { Err(Doubt::TooSharp { proved }) }
}

fn well_formed(tile: &Tile) -> bool {
    let rows = || tile.cosines.iter().chain(&tile.sines).chain([&tile.viscous]);
    let flat = |axis: usize| tile.domain.ranges()[axis][0] == tile.domain.ranges()[axis][1];
    let legal = |(mode, c): (usize, &f64)| {
        // On an axis of no width a polynomial is a constant.
        c.abs() < 1e3 && (*c == 0.0 || (0..3).all(|axis| degrees(mode)[axis] == 0 || !flat(axis)))
    };
    tile.domain.ranges().iter().all(|[lo, hi]| *lo >= 0.0 && lo <= hi && *hi < 1e3)
        && tile.cosines.len() == tile.sines.len()
        && tile.cosines.len() < 512
        && rows().all(|row| row.len() == MODES && row.iter().enumerate().all(legal))
        && tile.radius > 0.0
        && tile.radius <= 1.0
}

fn degrees(mode: usize) -> [usize; 3] {
    [mode % 3, mode / 3 % 9, mode / 27]
}

/// The value of every mode, from those of the Chebyshev polynomials in A, k and b.
fn products([a, k, b]: [&[Ball; HIGHEST + 1]; 3]) -> Vec<Ball> {
    let value = |[i, j, l]: [usize; 3]| a[i] * k[j] * b[l];
    (0..MODES).map(|mode| value(degrees(mode))).collect()
}

/// T_n and T_n+1 at `x` by doubling, T_2n = 2 T_n^2 - 1 and T_2n+1 = 2 T_n T_n+1 - x, which multiplies errors
/// by 4 at most; the usual recurrence would let radii grow exponentially.
fn chebyshev_pair(x: Ball, n: usize) -> [Ball; 2] {
    if n == 0 {
        return [Ball::exact(1.0), x];
    }
    let [one, two] = chebyshev_pair(x, n / 2);
    let unit = Ball::exact(1.0);
    let middle = one * two * 2.0 - x;
    if n.is_multiple_of(2) { [one * one * 2.0 - unit, middle] } else { [middle, two * two * 2.0 - unit] }
}

/// T_0, T_1, .. at an exact number.
fn chebyshev(x: f64) -> [Ball; HIGHEST + 1] {
    std::array::from_fn(|n| chebyshev_pair(Ball::exact(x), n)[0])
}

/// An exact point of one parameter's range, in units from -1 to 1.
struct Node {
    value: Ball,
    chebyshev: [Ball; HIGHEST + 1],
}

/// The points of one parameter, and the bound on the ratio of a maximum to the maximum over the points.
struct Mesh {
    nodes: Vec<Node>,
    factor: f64,
}

impl Mesh {
    /// Checks the points; `None` if the library's cosine misplaces them.
    fn new(domain: &GroupBox, axis: usize) -> Option<Self> {
        let [lo, hi] = domain.ranges()[axis];
        if lo == hi {
            let mut chebyshev = [Ball::exact(0.0); HIGHEST + 1];
            chebyshev[0] = Ball::exact(1.0);
            return Some(Self { nodes: vec![Node { value: Ball::exact(lo), chebyshev }], factor: 1.0 });
        }
        let degree = 4 * DEGREES[axis] + [0, 2, 1][axis];
        let count = (DENSITY * degree as f64).ceil() as usize;
        let n = count as f64;
        let points: Vec<f64> =
            (0..count).map(|j| (std::f64::consts::PI * (j as f64 + 0.5) / n).cos()).collect();
        // The cosine is not trusted: with x = cos t, T_n(x) = cos n t, and |cos n t| <= e means that n t is
        // within pi e / 2 of an odd multiple of pi/2. Points farther apart than twice that distance are not
        // at the same zero.
        let off = std::f64::consts::FRAC_PI_2 * OFF_ZERO / n * 1.001;
        for (j, &x) in points.iter().enumerate() {
            let [t, _] = chebyshev_pair(Ball::exact(x), count);
            let apart = j == 0 || points[j - 1] - x > 2.1 * off;
            if !(t.size() <= OFF_ZERO && apart && x.abs() <= 1.0) {
                return None;
            }
        }
        let reach = degree as f64 * (std::f64::consts::FRAC_PI_2 / n * 1.001 + off);
        let factor = 1.0 / (1.0 - 0.5 * reach * reach) * (1.0 + 1e-12);
        let (middle, half) = scale([lo, hi]);
        let node = |&x: &f64| Node { value: middle + half * Ball::exact(x), chebyshev: chebyshev(x) };
        (factor > 0.0).then(|| Self { nodes: points.iter().map(node).collect(), factor })
    }
}

/// Middle and half-width of a range.
fn scale([lo, hi]: [f64; 2]) -> (Ball, Ball) {
    let (lo, hi) = (Ball::exact(lo), Ball::exact(hi));
    ((lo + hi) * 0.5, (hi - lo) * 0.5)
}

/// g, the bound on |G| for t = 0 over all angles and the whole box.
fn defect(tile: &Tile) -> Option<f64> {
    let meshes = [0, 1, 2].map(|axis| Mesh::new(&tile.domain, axis));
    let [Some(a), Some(k), Some(b)] = &meshes else { return None };
    let largest = (0..a.nodes.len() * k.nodes.len())
        .into_par_iter()
        .map(|at| {
            let (one, two) = (&a.nodes[at % a.nodes.len()], &k.nodes[at / a.nodes.len()]);
            // Written so that NaN is kept.
            let most = |most: f64, norm: f64| if norm <= most { most } else { norm };
            b.nodes.iter().map(|three| defect_at(tile, [one, two, three])).fold(0.0, most)
        })
        .reduce(|| 0.0, |one, two| if one <= two { two } else { one });
    let bound = largest * a.factor * k.factor * b.factor * (1.0 + 1e-12);
    bound.is_finite().then_some(bound)
}

/// The bound on |G| over all angles at one point of the box.
fn defect_at(tile: &Tile, nodes: [&Node; 3]) -> f64 {
    let [a, k, b] = nodes.map(|node| node.value);
    let weights = products(nodes.map(|node| &node.chebyshev));
    let mut error = 0.0;
    let mut sum = |row: &Vec<f64>| -> f64 {
        let terms = row.iter().zip(&weights).filter(|(c, _)| **c != 0.0);
        let ball = terms.fold(Ball::exact(0.0), |sum, (c, weight)| sum + *weight * *c);
        error += ball.radius;
        ball.middle
    };
    let mut cosines = vec![0.0];
    cosines.extend(tile.cosines.iter().map(&mut sum));
    let mut sines = vec![0.0];
    sines.extend(tile.sines.iter().map(&mut sum));
    // r0 = 1 + sum of a_n (cos n theta - 1) + b_n sin n theta: an error of a_n counts twice.
    let base = cosines.iter().fold(Ball::exact(1.0), |base, a| base - Ball::exact(*a));
    let r0 = Series::real(&cosines, &sines, 2.0 * error * (1.0 + 1e-9)).plus_number(base);
    let damping =
        tile.viscous.iter().zip(&weights).fold(Ball::exact(0.0), |sum, (c, weight)| sum + *weight * *c);

    let cos = Series::real(&[0.0, 1.0], &[0.0, 0.0], 0.0);
    let product = Series::real(&[0.0, 0.0, 0.0], &[0.0, 0.0, 0.5], 0.0);
    let square = Series::real(&[0.5, 0.0, -0.5], &[0.0, 0.0, 0.0], 0.0);
    let minus = Ball::exact(-1.0);
    let s = r0.times(&cos).scaled(minus).plus_number(Ball::exact(1.0));
    let q = s.clone().scaled(k).plus_number(Ball::exact(1.0));
    let q2 = q.times(&q);
    let e = s.scaled(b * 2.0).plus_number(damping);
    let n = q2.times(&e).scaled(minus).plus_number(a);
    let advance = q2.plus(&n.times(&product));
    let g = r0.derivative().times(&advance).plus(&n.times(&r0).times(&square).scaled(minus));
    g.norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn domain() -> GroupBox {
        GroupBox { a: [0.1, 0.15], k: [0.15, 0.25], b: [0.01, 0.02] }
    }

    #[test]
    fn tiles_pass_and_wrong_ones_do_not() {
        let tile = Tile::prove(domain()).unwrap();
        let proved = verify(&tile).unwrap();
        // Both proofs bound the same defect, by different means.
        assert!(proved < tile.radius && proved > 1e-3 * tile.radius, "{proved} {}", tile.radius);
        // A claim ten times too sharp.
        let sharp = Tile { radius: 0.1 * proved, ..tile.clone() };
        assert!(matches!(verify(&sharp), Err(Doubt::TooSharp { .. })));
        // C* away from the claim, by twice the radius.
        let mut moved = tile.clone();
        moved.viscous[0] += 2.0 * tile.radius;
        assert!(matches!(verify(&moved), Err(Doubt::TooSharp { .. })));
        // A different witness.
        let mut bent = tile.clone();
        bent.sines[2][0] += 100.0 * tile.radius;
        assert!(matches!(verify(&bent), Err(Doubt::TooSharp { .. })));
        // The box next to it.
        let other = Tile { domain: GroupBox { a: [0.15, 0.2], ..tile.domain }, ..tile.clone() };
        assert!(matches!(verify(&other), Err(Doubt::TooSharp { .. })));
        let mut broken = tile.clone();
        broken.sines.pop();
        assert_eq!(verify(&broken), Err(Doubt::Malformed));
        let infinite = Tile { radius: f64::NAN, ..tile };
        assert_eq!(verify(&infinite), Err(Doubt::Malformed));
    }

    #[test]
    fn a_tile_of_no_width_is_a_point() {
        let point = GroupBox { a: [0.2, 0.2], k: [0.3, 0.3], b: [0.0, 0.0] };
        let tile = Tile::prove(point).unwrap();
        assert!(verify(&tile).is_ok_and(|proved| proved < 1e-10), "{:?}", verify(&tile));
    }
}
