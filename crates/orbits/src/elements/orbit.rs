//! An iterate of Newton's method: a closed curve about the equilibrium, cut into elements.

use std::f64::consts::{PI, TAU};

use super::arithmetic::{apply, dot, first, turned, weakening};
use super::element::Element;
use slipmap_model::friction::Weakening;
use slipmap_numbers::Aligned;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::elementary::{exp, sin_cos, sin_cos_of_turn};
use slipmap_numbers::gauss::{MOST, Rule};

/// Least dth/dt: the polar form applies as long as it is positive, but near zero g is hard to resolve.
const SLOWEST_TURN: f64 = 0.02;
/// Largest |ln(r / radius)|.
const LARGEST_LOG: f64 = 1.0;
/// Largest |A| in a step of Newton's method.
const LARGEST_GROWTH: f64 = 8.0;
/// Largest change of p in a step.
const LONGEST_STEP: f64 = 0.25;
/// Distance from the middle of its piece up to which a polynomial is used, in halves of the piece's width.
const OUTSIDE: f64 = 1.1;
/// Widest element of the coarsest rung.
const WIDEST: f64 = 0.5 * PI;

/// The orbit through a maximum of x2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Problem<'a> {
    pub(super) weakening: &'a Weakening,
    pub(super) belt_speed: f64,
    pub(super) radius: f64,
}

/// The elements between two neighbouring passages of ends of pieces, or of the angle pi.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    piece: usize,
    parts: usize,
}

/// An iterate.
pub(super) struct Orbit<'a> {
    pub(super) problem: Problem<'a>,
    pub(super) viscous: f64,
    /// Largest ratio of the error left by a step to the square of that before it, near the solution.
    pub(super) curvature: f64,
    /// The spans, as many before the angle pi as after it.
    spans: Vec<Span>,
    /// Angles at which spans begin and end.
    bounds: Vec<f64>,
    /// Sines and cosines of `bounds`.
    sin_cos: Vec<[f64; 2]>,
    pub(super) elements: Vec<Element>,
}

/// A step of Newton's method, before it is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// dC.
    pub(super) change: f64,
    /// Bound to first order of the error of C before the step.
    pub(super) left: f64,
    /// Distance from the border of the domain of the polar form.
    pub(super) room: f64,
    /// The integral of D over the time of a turn, and that of exp(-A) dg/dC, before the step.
    expansion: f64,
    by_damping: f64,
}

impl Step {
    /// dC / d ln r of the curve before the step. At the end of a closed orbit exp(-A) is the inverse of its
    /// multiplier, the exponential of the expansion, which misplaced corners change to second order.
    pub(super) fn slope(&self) -> f64 {
        (-self.expansion).exp_m1() / self.by_damping
    }
}

impl Orbit<'_> {
    /// The circle of the problem's radius, with the least number of elements.
    pub(super) fn circle<'a>(problem: Problem<'a>) -> Orbit<'a> {
        let Problem { weakening, belt_speed, radius, .. } = problem;
        let breaks = weakening.breaks();
        let (from, to) = (weakening.piece_of(belt_speed - radius), weakening.piece_of(belt_speed + radius));
        let passes = || (from..to).map(|piece| ((belt_speed - breaks[piece + 1]) / radius).clamp(-1.0, 1.0));
        let passes = || std::iter::once(1.0).chain(passes());
        let falling = passes().map(|cos: f64| [((1.0 - cos) * (1.0 + cos)).sqrt(), cos]);
        let mut sin_cos: Vec<[f64; 2]> = falling.collect();
        let rising: Vec<[f64; 2]> = sin_cos.iter().rev().map(|[sin, cos]| [-sin, *cos]).collect();
        sin_cos.push([0.0, -1.0]);
        sin_cos.extend(rising);
        let mut bounds: Vec<f64> = passes().map(f64::acos).collect();
        let mirrored: Vec<f64> = bounds.iter().rev().map(|angle| TAU - angle).collect();
        bounds.push(PI);
        bounds.extend(mirrored);
        let spans = (from..=to).chain((from..=to).rev()).zip(bounds.windows(2));
        let spans = spans.map(|(piece, ends)| Span { piece, parts: parts(ends[1] - ends[0]) });
        let spans: Vec<Span> = spans.collect();
        let mut elements = Vec::with_capacity(spans.iter().map(|span| span.parts).sum());
        for span in &spans {
            elements.resize(elements.len() + span.parts, Element::new(span.piece));
        }
        Orbit { problem, viscous: 0.0, curvature: 0.0, spans, bounds, sin_cos, elements }
    }

    /// Puts the elements into their spans, and moves the functions with them, to first order.
    #[inline(always)]
    pub(super) fn place<const N: usize>(&mut self, rule: &Rule<N>) {
        let mut elements = self.elements.iter_mut();
        let mut start = 0.0;
        for ((span, ends), at_start) in self.spans.iter().zip(self.bounds.windows(2)).zip(&self.sin_cos) {
            let half = 0.5 * (ends[1] - ends[0]) / span.parts as f64;
            let (mut at, by_half) = (*at_start, sin_cos(half));
            for (part, element) in (0..span.parts).zip(&mut elements) {
                let middle = half.times_plus(2.0 * part as f64 + 1.0, ends[0]);
                at = turned(at, by_half);
                element.place(rule, middle, half, at);
                at = turned(at, by_half);
                start = element.integrate(rule, start);
            }
        }
    }

    /// Prepares a step of Newton's method.
    #[inline(always)]
    pub(super) fn step<const N: usize>(&mut self, rule: &Rule<N>) -> Step {
        let Self { problem: Problem { weakening: law, belt_speed, radius }, viscous, .. } = *self;
        // A, and the integrals of exp(-A) times dg/dC and the residual, at the beginning of an element.
        let [mut growth, mut by_damping, mut residual] = [0.0; 3];
        // Sums over all elements for each node.
        let [mut size, mut slopes, mut slopes_by_damping, mut expansion] = [[0.0; N]; 4];
        let mut room = [f64::INFINITY; N];
        for element in &mut self.elements {
            let piece = law.polynomial(element.piece);
            let [mut g, mut a, mut b, mut rho] = [[0.0; N]; 4];
            let [mut v, mut x, mut w, mut steepness] = [[0.0; N]; 4];
            let mut outermost = [0.0_f64; N];
            for j in 0..N {
                let log_r = element.log_r[j].clamp(-LARGEST_LOG, LARGEST_LOG);
                v[j] = radius * exp::<4>(log_r) * element.cos[j];
                x[j] = (belt_speed - v[j] - piece.middle) * piece.scale;
                outermost[j] = x[j].abs();
            }
            if outermost.iter().all(|x| *x <= OUTSIDE) {
                [w, steepness] = weakening(&piece, &x);
            } else {
                // The ends of the span do not follow the orbit yet.
                for j in 0..N {
                    let u = (belt_speed - v[j]).clamp(0.0, law.reach());
                    let piece = law.polynomial(law.piece_of(u));
                    [[w[j]], [steepness[j]]] = weakening(&piece, &[(u - piece.middle) * piece.scale]);
                }
            }
            for j in 0..N {
                let d = w[j] - viscous;
                let left = LARGEST_LOG - element.log_r[j].abs();
                let turn = d.times_plus(element.sin_cos[j], 1.0);
                let left = left.min(turn - SLOWEST_TURN);
                room[j] = room[j].min(left);
                let inverse = 1.0 / turn.max(SLOWEST_TURN);
                let part = element.sin_squared[j] * inverse;
                g[j] = part * d;
                b[j] = -part * inverse;
                a[j] = b[j] * steepness[j] * v[j];
                rho[j] = g[j] - element.slope[j];
                expansion[j] = (element.half * d).times_plus(inverse, expansion[j]);
            }
            element.next[..N].copy_from_slice(&g);
            element.by_damping[..N].copy_from_slice(&b);
            element.a[..N].copy_from_slice(&a);
            element.rho[..N].copy_from_slice(&rho);
        }
        // A loop of its own: the processor works on several elements at once where each takes few instructions.
        for element in &mut self.elements {
            let half = element.half;
            let [a, b, g, rho] =
                [&element.a, &element.by_damping, &element.next, &element.rho].map(|of| first::<N>(of));
            let grown = apply(&rule.antiderivative, &a);
            let (mut weight, mut inverse, mut weighted_b, mut weighted_rho) =
                ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
            for j in 0..N {
                let exponent = half.times_plus(grown[j], growth).clamp(-LARGEST_GROWTH, LARGEST_GROWTH);
                weight[j] = exp::<4>(-exponent);
                inverse[j] = a[j] / weight[j];
                weighted_b[j] = weight[j] * b[j];
                weighted_rho[j] = weight[j] * rho[j];
            }
            let at_b = apply(&rule.antiderivative, &weighted_b);
            let at_rho = apply(&rule.antiderivative, &weighted_rho);
            for j in 0..N {
                let next = inverse[j].times_plus(half.times_plus(at_rho[j], residual), g[j]);
                let by = inverse[j].times_plus(half.times_plus(at_b[j], by_damping), b[j]);
                (element.next[j], element.by_damping[j]) = (next, by);
                size[j] = half.times_plus(weighted_rho[j].abs(), size[j]);
                slopes[j] = half.times_plus(next, slopes[j]);
                slopes_by_damping[j] = half.times_plus(by, slopes_by_damping[j]);
            }
            growth += half * dot(&rule.weights, &a);
            by_damping += half * dot(&rule.weights, &weighted_b);
            residual += half * dot(&rule.weights, &weighted_rho);
        }
        let change = -dot(&rule.weights, &slopes) / dot(&rule.weights, &slopes_by_damping);
        Step {
            change,
            left: dot(&rule.weights, &size) / by_damping.abs(),
            room: room.iter().copied().fold(f64::INFINITY, f64::min),
            expansion: dot(&rule.weights, &expansion),
            by_damping,
        }
    }

    /// Makes the step, or as much of it as moves p by no more than [`LONGEST_STEP`]. Returns whether it was
    /// made whole.
    #[inline(always)]
    pub(super) fn advance<const N: usize>(&mut self, rule: &Rule<N>, change: f64) -> bool {
        let mut start = 0.0;
        let mut longest = [0.0_f64; N];
        for element in &mut self.elements {
            // From here on the two arrays hold the new p' and p.
            for j in 0..N {
                element.next[j] = change.times_plus(element.by_damping[j], element.next[j]);
            }
            let next = first::<N>(&element.next);
            let rise = apply(&rule.antiderivative, &next);
            for j in 0..N {
                element.by_damping[j] = element.half.times_plus(rise[j], start);
                longest[j] = longest[j].max((element.by_damping[j] - element.log_r[j]).abs());
            }
            start = element.half.times_plus(dot(&rule.weights, &next), start);
            element.end = start;
        }
        let longest = longest.iter().copied().fold(0.0, f64::max);
        let share = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        self.viscous += share * change;
        let is_whole = share == 1.0;
        let mut start = 0.0;
        for element in &mut self.elements {
            if is_whole {
                (element.slope, element.log_r) = (element.next, element.by_damping);
            } else {
                for j in 0..N {
                    element.slope[j] = share.times_plus(element.next[j] - element.slope[j], element.slope[j]);
                }
                start = element.integrate(rule, start);
            }
        }
        is_whole
    }

    /// Puts the elements of a circle into their spans, with the C at which it closes to first order in D.
    /// Returns the size of D: the largest |w| on the circle.
    #[inline(always)]
    pub(super) fn start<const N: usize>(&mut self, rule: &Rule<N>) -> f64 {
        self.place(rule);
        let Problem { weakening: law, belt_speed, radius } = self.problem;
        let (mut sum, mut largest) = ([0.0; N], [0.0_f64; N]);
        for element in &self.elements {
            let piece = law.polynomial(element.piece);
            let mut x = first::<N>(&element.cos);
            for x in &mut x {
                *x = (radius.times_plus(-*x, belt_speed) - piece.middle) * piece.scale;
            }
            let [w, _] = weakening(&piece, &x);
            for j in 0..N {
                sum[j] = (element.half * element.sin_squared[j]).times_plus(w[j], sum[j]);
                largest[j] = largest[j].max(w[j].abs());
            }
        }
        self.viscous = dot(&rule.weights, &sum) / PI;
        largest.iter().copied().fold(0.0, f64::max)
    }

    /// Moves the ends of the spans to the angles at which the orbit passes the ends of the pieces, unless all
    /// are closer than `allowed`, in units of the narrower piece, and none causes an error of C above
    /// `allowed_at_corners` as a corner. Returns whether they were moved; `None` where the orbit leaves the
    /// pieces.
    #[inline(always)]
    pub(super) fn follow(&mut self, allowed: f64, allowed_at_corners: f64) -> Option<bool> {
        let Problem { weakening, belt_speed, radius, .. } = self.problem;
        let breaks = weakening.breaks();
        let (mut allowed, mut allowed_at_corners) = (allowed, allowed_at_corners);
        let mut at_bounds = self.at_bounds();
        loop {
            let half = self.spans.len() / 2;
            let farthest = radius * exp::<4>(at_bounds[half].clamp(-LARGEST_LOG, LARGEST_LOG));
            let last = self.spans[half].piece;
            if belt_speed + farthest <= breaks[last + 1] {
                break;
            }
            if last + 2 == breaks.len() {
                return None;
            }
            self.append(last + 1, PI - angle((belt_speed - breaks[last + 1]) / farthest), at_bounds[half]);
            at_bounds = self.at_bounds();
            (allowed, allowed_at_corners) = (0.0, 0.0);
        }
        let half = self.spans.len() / 2;
        let first = self.spans[0].piece;
        let kinked = !weakening.corners().is_empty();
        // Closures of iterators would leave the function that is compiled for the machine's vectors.
        let mut is_off = false;
        for (i, at_bound) in at_bounds.iter_mut().enumerate().take(2 * half).skip(1) {
            if i == half {
                continue;
            }
            let number = first + if i < half { i } else { 2 * half - i };
            let r = radius * exp::<4>(at_bound.clamp(-LARGEST_LOG, LARGEST_LOG));
            let [below, slip, above] = [breaks[number - 1], breaks[number], breaks[number + 1]];
            // From here on the cosine of the passage, instead of p.
            *at_bound = ((belt_speed - slip) / r).clamp(-1.0, 1.0);
            let cos = self.sin_cos[i][1];
            let off = r * (cos - *at_bound).abs();
            is_off = is_off
                || off > allowed * (slip - below).min(above - slip)
                || kinked && {
                    let by_corner =
                        |sin: f64| by_corner(weakening.jump(number), off, belt_speed - slip, r, cos, sin);
                    // The bound of the sine, at most 3, takes longer.
                    by_corner(3.0) > allowed_at_corners
                        && by_corner(sin_beside(off, r, cos)) > allowed_at_corners
                };
        }
        if !is_off {
            return Some(false);
        }
        let mut bounds = self.bounds.clone();
        for i in 1..2 * half {
            if i == half {
                continue;
            }
            // Newton's step, in which r varies.
            let (before_pi, number) = (i < half, first + if i < half { i } else { 2 * half - i });
            let [sin, cos] = self.sin_cos[i];
            let d = weakening.at(breaks[number]) - self.viscous;
            let turn = (d * sin).times_plus(cos, 1.0).clamp(SLOWEST_TURN, 2.0);
            let target = if before_pi { angle(at_bounds[i]) } else { TAU - angle(at_bounds[i]) };
            let moved = turn.times_plus(target - self.bounds[i], self.bounds[i]);
            let [lowest, highest] =
                if before_pi { [bounds[i - 1], PI] } else { [bounds[i - 1].max(PI), TAU] };
            bounds[i] = moved.clamp(lowest, highest);
        }
        self.set_bounds(bounds);
        Some(true)
    }

    /// p at the angles where spans begin.
    #[inline(always)]
    fn at_bounds(&self) -> Vec<f64> {
        let mut at_bounds = Vec::with_capacity(self.spans.len() + 1);
        at_bounds.push(0.0);
        let mut next = 0;
        for span in &self.spans {
            next += span.parts;
            at_bounds.push(self.elements[next - 1].end);
        }
        at_bounds
    }

    /// Adds a piece at the lowest point, where p has the value `log_r`, as yet without width.
    #[inline(never)]
    fn append(&mut self, piece: usize, width: f64, log_r: f64) {
        let half = self.spans.len() / 2;
        let span = Span { piece, parts: parts(width) };
        let mut element = Element::new(piece);
        (element.log_r, element.end) = (Aligned::all(log_r), log_r);
        let before: usize = self.spans[..half].iter().map(|span| span.parts).sum();
        self.elements.splice(before..before, std::iter::repeat_n(element, 2 * span.parts));
        self.spans.splice(half..half, [span; 2]);
        let mut bounds = std::mem::take(&mut self.bounds);
        bounds.splice(half..half, [PI, PI]);
        self.set_bounds(bounds);
    }

    #[inline(always)]
    pub(super) fn set_bounds(&mut self, bounds: Vec<f64>) {
        self.sin_cos.clear();
        for angle in &bounds {
            self.sin_cos.push(sin_cos_of_turn(*angle));
        }
        self.bounds = bounds;
    }

    /// Cuts every element into parts, and interpolates p' to them.
    #[inline(always)]
    pub(super) fn refine(&mut self, transfers: &[[[f64; MOST]; MOST]]) {
        let parts = transfers.len();
        for span in &mut self.spans {
            span.parts *= parts;
        }
        let old = std::mem::take(&mut self.elements);
        self.elements = Vec::with_capacity(parts * old.len());
        for element in &old {
            let width = element.half / parts as f64;
            for (part, matrix) in transfers.iter().enumerate() {
                let slope = Aligned(apply(matrix, &element.slope));
                let middle = width.times_plus(2.0 * part as f64 + 1.0, element.middle - element.half);
                self.elements.push(Element { slope, middle, half: width, ..Element::new(element.piece) });
            }
        }
    }

    /// Errors of C and of its slope by corners that lie off the ends of their spans, where an element has a
    /// jump in the slope of w inside.
    pub(super) fn misplaced(&self) -> [f64; 2] {
        let Problem { weakening: law, belt_speed, radius, .. } = self.problem;
        let mut sums = [0.0; 2];
        if law.corners().is_empty() {
            return sums;
        }
        let mut last = 0;
        for (spans, [_, cos]) in self.spans.windows(2).zip(&self.sin_cos[1..]) {
            last += spans[0].parts;
            let corner = spans[0].piece.max(spans[1].piece);
            if spans[0].piece != spans[1].piece {
                let r = radius * self.elements[last - 1].end.exp();
                let velocity = belt_speed - law.breaks()[corner];
                let (jump, off) = (law.jump(corner), r * (cos - (velocity / r).clamp(-1.0, 1.0)).abs());
                let sin = sin_beside(off, r, *cos);
                sums[0] += by_corner(jump, off, velocity, r, *cos, sin);
                sums[1] += jump * off * sin / PI;
            }
        }
        sums
    }

    /// -x2 at the lowest point of the orbit, at the angle pi.
    pub(super) fn depth(&self) -> f64 {
        let before: usize = self.spans[..self.spans.len() / 2].iter().map(|span| span.parts).sum();
        self.problem.radius * self.elements[before - 1].end.exp()
    }

    /// Number of evaluations of g in a step.
    pub(super) fn cost<const N: usize>(&self) -> u64 {
        (self.elements.len() * N) as u64
    }
}

/// Error of C by a corner at which x2 = `velocity`, where the orbit passes it `off`, in slip speeds, the end
/// of its span, or does not reach it there: w is wrong by at most the jump of its slope times the distance of
/// the corner from the span's end, over the angles between that and the passage, or the turning point, with
/// the weight sin^2 theta, where |sin theta| is at most `sin`.
#[inline(always)]
fn by_corner(jump: f64, off: f64, velocity: f64, r: f64, cos: f64, sin: f64) -> f64 {
    jump * (velocity - r * cos).abs() * off * sin / (PI * r)
}

/// Bound of |sin theta| up to this distance from the end of a span, in slip speeds.
#[inline(always)]
fn sin_beside(off: f64, r: f64, cos: f64) -> f64 {
    (1.0 - cos * cos).max(0.0).sqrt() + (2.0 * off / r).sqrt()
}

/// The angle in [0, pi] with this cosine, or the nearest one.
fn angle(cos: f64) -> f64 {
    cos.clamp(-1.0, 1.0).acos()
}

/// The number of elements in a span.
fn parts(width: f64) -> usize {
    // The width has rounding errors.
    ((width / WIDEST - 1e-9).ceil() as usize).max(1)
}
