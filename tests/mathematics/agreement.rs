//! One test over every engine: at random points of every law, all say the same within their own errors.
//!
//! An opinion is the set of fates that an engine leaves possible and, where it has one, a margin with the error
//! that it states. Opinions agree if they have a fate in common, and margins that are no farther apart than
//! their errors.

use crate::interpolation::{How, verdicts};
use crate::sample::{Random, Sample, Sampling, formula};
use rayon::prelude::*;
use slipmap::certify::{Decision, Guarantee, TESTS, validated};
use slipmap::column::backbone::Backbone;
use slipmap::column::{CriticalDamping, critical_damping};
use slipmap::column::{Method, Verdict};
use slipmap::filippov::Oscillator;
use slipmap::flow::{Fate, Flow, Landing};
use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::map::{Control, Each, Grid, Plan, decide, run, unravel};
use slipmap::orbits::flow;
use slipmap::witness;
use std::collections::BTreeMap;
use std::fmt;

/// The tolerance of maps.
const TOLERANCE: f64 = 1e-9;

/// A random law that falls by a share in `drop` within about a slip speed in `scale`, with its kind.
pub fn law(random: &mut Random, drop: [f64; 2], scale: [f64; 2]) -> (&'static str, Law, Vec<f64>) {
    let kind = (6.0 * random.unit()) as usize;
    let (drop, scale) = (random.between(drop[0], drop[1]), random.log(scale[0], scale[1]));
    let (rise, wave) = (random.between(0.0, 0.03), random.log(1.0, 6.0));
    let formula = |text: String| formula(&text);
    match kind {
        0 => ("stribeck", Law::Stribeck, vec![1.0 - drop, rise, 1.0 / scale]),
        1 if wave > 2.0 => {
            let exponent = 1.0 + 70.0 * rise;
            ("exponent", Law::Stretched, vec![1.0 - drop, scale, rise, exponent])
        }
        1 => ("exponential", Law::Exponential, vec![1.0 - drop, scale, rise]),
        2 => ("lorentzian", Law::Lorentzian, vec![1.0 - drop, scale, rise]),
        3 => ("formula", formula(format!("1 - {drop}*tanh(u/{scale}) + {rise}*sin({wave}*u)")), vec![]),
        4 => ("formula", formula(format!("1 - {drop}*atan(u/{scale}) + {rise}*u^2")), vec![]),
        _ => {
            let (spacing, noise) = (random.log(0.05, 0.4), random.log(1e-5, 1e-2));
            let mut data = vec![(0.0, 1.0)];
            while data[data.len() - 1].0 < 12.0 {
                let u = data[data.len() - 1].0 + spacing * random.between(0.5, 1.5);
                let scatter = noise * random.between(-1.0, 1.0);
                data.push((u, 1.0 - drop + drop * (-u / scale).exp() + rise * u + scatter));
            }
            ("table", Law::Table(Table::new("random", &data, 1.0).unwrap()), vec![])
        }
    }
}

/// A damping of the column: half of them anywhere, the others near the critical one.
pub fn damping(column: &Column, random: &mut Random) -> f64 {
    let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
    let anywhere = random.between(0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
    let distance = random.between(-1.0, 1.0) * random.log(1e-6, 1.0);
    match critical_damping(column, TOLERANCE) {
        Ok(found) if found.c > 0.0 && random.unit() < 0.5 => (found.c * (1.0 + distance)).max(0.0),
        _ => anywhere,
    }
}

/// A column of a random law, and a damping.
struct Case {
    column: Column,
    c: f64,
    law: Law,
    parameters: Vec<f64>,
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { column: Column { epsilon, belt_speed, .. }, c, law, parameters } = self;
        let definition = law.definition();
        write!(f, "{} {definition:?} {parameters:?}, eps {epsilon}, V {belt_speed}, c {c}", law.name())
    }
}

impl Case {
    fn new((_, law, parameters): (&str, Law, Vec<f64>), epsilon: f64, belt_speed: f64) -> Self {
        let column = law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap());
        Self { column, c: 0.0, law, parameters }
    }

    fn of_sample(sample: &Sample) -> Self {
        let parameters = vec![sample.alpha, sample.beta, sample.gamma];
        Self { column: sample.column(), c: sample.damping, law: Law::Stribeck, parameters }
    }

    /// Any law, on belts so slow that orbits creep to those so fast that they cross. Tables end at 12.
    fn any_law(number: u64) -> Self {
        let mut random = Random(0x5eed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let law = law(&mut random, [0.05, 0.95], [0.15, 1.5]);
        let belt_speed = random.log(0.03, if law.0 == "table" { 4.0 } else { 300.0 });
        let case = Self::new(law, random.log(0.1, 1.0), belt_speed);
        Self { c: damping(&case.column, &mut random), ..case }
    }

    /// Laws so steep that the divergence passes 2 or -2: half of the points next to that at the equilibrium or
    /// at the belt line, the others next to the critical damping.
    fn node(random: &mut Random) -> Self {
        let law = law(random, [0.3, 0.95], [0.03, 0.5]);
        let case = Self::new(law, random.log(0.3, 1.0), random.log(0.03, 3.0));
        let rate =
            case.column.curve.weakening(if random.unit() < 0.5 { 0.0 } else { case.column.belt_speed });
        let side = if random.unit() < 0.5 { -2.0 } else { 2.0 };
        let c =
            (rate + side * (1.0 + random.between(-1.0, 1.0) * random.log(1e-6, 0.5))) / case.column.epsilon;
        let c = if random.unit() < 0.5 && c >= 0.0 { c } else { damping(&case.column, random) };
        Self { c, ..case }
    }

    /// Belts so fast that orbits cross the belt line.
    fn fast(random: &mut Random) -> Self {
        let (kind, law, mut parameters) = law(random, [0.05, 0.95], [0.15, 30.0]);
        // Friction that rises with the square of the speed stops every orbit from crossing.
        if kind == "stribeck" {
            parameters[1] *= 1e-4;
        }
        let belt_speed = if kind == "table" { random.log(2.0, 5.0) } else { random.log(3.0, 150.0) };
        let case = Self::new((kind, law, parameters), 1.0, belt_speed);
        let top = critical_damping(&case.column, TOLERANCE).map_or(0.1, |found| found.c.abs());
        Self { c: top * random.between(0.0, 1.1).powi(3), ..case }
    }

    /// Any law with a drop, from nodes to friction that pushes, on belts that are slow or fast beside the drop.
    fn dropping(random: &mut Random) -> Self {
        let belt_speed = random.log(0.02, 40.0);
        let drop = if random.unit() < 0.3 { random.log(1e-4, 0.9) } else { 0.9 * random.unit() };
        let onset = 1.0 - drop;
        // Velocities of the law, on the scale of the orbit.
        let size = belt_speed + drop;
        let width = size * random.log(0.02, 2.0);
        let fall = onset * random.unit();
        let rise = if random.unit() < 0.5 { 0.0 } else { random.log(1e-3, 0.3) };
        let formula = |text: String| Law::Expression(Expression::with_static(&text, 1.0).unwrap());
        let (kind, law, parameters) = match (6.0 * random.unit()) as u32 {
            0 => {
                // Viscous parts up to nodes.
                let eta = if random.unit() < 0.5 { rise } else { 3.0 * random.unit() };
                ("coulomb", Law::Coulomb, vec![drop, eta])
            }
            1 => ("stribeck", Law::Stribeck.with_drop(), vec![random.unit(), rise / size, 1.0 / width, drop]),
            2 => ("exponential", Law::Exponential.with_drop(), vec![random.unit(), width, rise, drop]),
            3 => ("lorentzian", Law::Lorentzian.with_drop(), vec![random.unit(), width, rise, drop]),
            4 => {
                let text = match (5.0 * random.unit()) as u32 {
                    0 => format!("{onset} - {fall}*tanh(u/{width}) + {rise}*u"),
                    1 => format!("{onset} + {fall}*(exp(-(u/{width})^2) - 1)"),
                    2 => format!("{onset} - {fall}*tanh(u/{width}) + {}*sin(u/{width})^2", 0.2 * fall),
                    // It rises first.
                    3 => format!("{onset} + {rise}*u*exp(-u/{width}) + 0.01*u"),
                    // It pushes at high slip speeds.
                    _ => format!("{onset} - {}*u/({width} + u)", onset + random.unit()),
                };
                ("formula", formula(text), vec![])
            }
            _ => {
                let (mut u, mut data) = (0.0, vec![(0.0, onset)]);
                while u < 5.0 * size {
                    u += (0.1 * width + 0.1 * u) * (0.5 + random.unit());
                    let noise = 0.01 * fall * (random.unit() - 0.5);
                    data.push((u, onset - fall * (u / width).tanh() + rise * u + noise));
                }
                ("table", Law::Table(Table::with_static("random", &data, 1.0).unwrap()), vec![])
            }
        };
        let case = Self::new((kind, law, parameters), random.log(0.1, 1.0), belt_speed);
        Self { c: damping(&case.column, random), ..case }
    }

    fn numbered(number: u64) -> Self {
        // A stream of random numbers per point: the points do not depend on the threads, and the larger
        // surveys contain the smaller.
        let mut random = Random(number.wrapping_mul(0xd134_2543_de82_ef95));
        match number % 6 {
            0 => Self::of_sample(&random.anywhere()),
            1 => Self::of_sample(&random.near_boundary()),
            2 => Self::any_law(number / 6),
            3 => Self::node(&mut random),
            4 => Self::fast(&mut random),
            _ => Self::dropping(&mut random),
        }
    }

    fn oscillator(&self) -> Oscillator {
        Oscillator::in_column(&self.column, self.c)
    }
}

/// Sets of fates.
const LANDS: u8 = 1;
const LANDS_FROM_ABOVE: u8 = 2;
const CROSSES: u8 = 4;
const INWARD: u8 = 8;
const RETURNS: u8 = LANDS | LANDS_FROM_ABOVE | CROSSES;
const ANY: u8 = RETURNS | INWARD;

/// What an engine says.
#[derive(Clone, Copy, Debug)]
struct Opinion {
    by: &'static str,
    fates: u8,
    margin: Option<[f64; 2]>,
}

impl Opinion {
    fn of_flow(by: &'static str, flow: &Flow) -> Self {
        let fates = match flow.fate {
            Fate::Sticks(Landing { crossings: Some(0), .. }) => LANDS,
            Fate::Sticks(Landing { crossings: Some(_), .. }) => LANDS_FROM_ABOVE,
            Fate::Sticks(Landing { crossings: None, .. }) => LANDS | LANDS_FROM_ABOVE,
            Fate::SpiralsInward => INWARD,
            Fate::CrossesForever => CROSSES,
            Fate::TooCloseToCall | Fate::Failed(_) => ANY,
        };
        let margin = Some([flow.margin, flow.margin_error]).filter(|[margin, _]| !margin.is_nan());
        Self { by, fates, margin }
    }

    /// By a number that is positive where the orbit returns.
    fn of_sign(by: &'static str, value: f64, error: f64) -> Self {
        let fates = if value > error {
            RETURNS
        } else if value < -error {
            INWARD
        } else {
            ANY
        };
        Self { by, fates, margin: None }
    }

    fn of_claim(by: &'static str, decision: Decision) -> Self {
        let fates = match decision {
            Decision::Present => LANDS,
            Decision::Absent => INWARD,
            Decision::Undecided => ANY,
        };
        Self { by, fates, margin: None }
    }
}

/// The witness and `flow` at one point, with the opinions of all engines.
#[derive(Debug)]
struct Heard {
    witness: Flow,
    flow: Flow,
    opinions: Vec<Opinion>,
}

impl Heard {
    /// The engines that take long are asked at few points.
    fn new(case: &Case, tolerance: f64, asks_all: bool) -> Self {
        let Case { column, c, .. } = case;
        let oscillator = case.oscillator();
        let (witness, flow) = (witness::flow(&oscillator, tolerance), flow(&oscillator, tolerance));
        let of_critical = |by, found: CriticalDamping| Opinion::of_sign(by, found.c - c, found.error);
        let mut opinions = vec![Opinion::of_flow("witness", &witness), Opinion::of_flow("flow", &flow)];
        opinions.extend(
            critical_damping(column, tolerance).ok().map(|found| of_critical("critical damping", found)),
        );
        let theorems = TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon);
        opinions.extend(theorems.map(|test| Opinion::of_claim(test.name, test.claim(column).decide(*c))));
        if asks_all {
            // With a drop orbits close at another damping than the critical one.
            let backbone = Some(column)
                .filter(|_| oscillator.drop() == 0.0)
                .and_then(|column| Backbone::of(column, tolerance).ok());
            opinions.extend(backbone.map(|backbone| {
                let apart = backbone.viscous(column.belt_speed) - oscillator.viscous;
                Opinion::of_sign("backbone", apart, backbone.error)
            }));
            opinions.push(Opinion::of_claim("validated", validated::TEST.claim(column).decide(*c)));
        }
        Self { witness, flow, opinions }
    }

    fn agree_on_fates(&self) -> bool {
        self.opinions.iter().fold(ANY, |fates, opinion| fates & opinion.fates) != 0
    }

    /// The largest distance of two margins, or of the landings, in units of the sum of their errors.
    fn discord(&self, oscillator: &Oscillator) -> f64 {
        let margins: Vec<[f64; 2]> = self.opinions.iter().filter_map(|opinion| opinion.margin).collect();
        let pairs = margins.iter().flat_map(|a| margins.iter().map(move |b| (a, b)));
        let ratios = pairs.map(|(a, b)| if a == b { 0.0 } else { (a[0] - b[0]).abs() / (a[1] + b[1]) });
        ratios.fold(self.landing_discord(oscillator), f64::max)
    }

    /// Along the belt line the error of x2 is magnified by the slope at which the orbit meets it: x1 has
    /// the error V margin_error (1 + V / wL), where the mass sticks for (wL + j) / V.
    fn landing_discord(&self, oscillator: &Oscillator) -> f64 {
        let (Fate::Sticks(one), Fate::Sticks(two)) = (self.witness.fate, self.flow.fate) else { return 0.0 };
        if one.crossings != Some(0) || two.crossings != Some(0) || one.x1 == two.x1 {
            return 0.0;
        }
        let belt_speed = oscillator.belt_speed;
        let across = belt_speed * (self.witness.margin_error + self.flow.margin_error);
        let slope = one.stick_time - oscillator.drop() / belt_speed;
        (one.x1 - two.x1).abs() / (across * (1.0 + 1.0 / slope))
    }
}

/// The counts of a survey.
#[derive(Default)]
struct Tally {
    /// Points by fate of the witness and of `flow`.
    fates: BTreeMap<[&'static str; 2], u64>,
    /// Opinions that leave a part of the fates only, by engine.
    decided: BTreeMap<&'static str, u64>,
    /// Points whose margins or landings differ by more than their errors, and the largest ratio.
    discords: u64,
    worst_discord: f64,
    /// Points that `flow` does not decide, with those of the witness.
    open: Vec<String>,
    problems: Vec<String>,
}

fn name(fate: &Fate) -> &'static str {
    match fate {
        Fate::Sticks(Landing { crossings: Some(0), .. }) => "sticks",
        Fate::Sticks(_) => "sticks from above",
        Fate::SpiralsInward => "spirals inward",
        Fate::CrossesForever => "crosses for ever",
        Fate::TooCloseToCall => "too close to call",
        Fate::Failed(_) => "failed",
    }
}

impl Tally {
    fn of(case: &Case, asks_all: bool) -> Self {
        let mut heard = Heard::new(case, TOLERANCE, asks_all);
        // As an audit does: smaller steps before a contradiction is reported.
        if !heard.agree_on_fates() {
            heard.witness = witness::flow(&case.oscillator(), 1e-4 * TOLERANCE);
            heard.opinions[0] = Opinion::of_flow("witness", &heard.witness);
        }
        let mut tally = Self::default();
        tally.fates.insert([name(&heard.witness.fate), name(&heard.flow.fate)], 1);
        for opinion in heard.opinions.iter().filter(|opinion| opinion.fates != ANY) {
            tally.decided.insert(opinion.by, 1);
        }
        let mut judge = |right: bool, what: &str| {
            if !right {
                tally.problems.push(format!("{what}: {case:?}\n  {heard:?}"));
            }
        };
        judge(heard.agree_on_fates(), "fates");
        // No theorem claims more than the critical damping leaves, but for the rounding of its edges.
        if let Ok(found) = critical_damping(&case.column, TOLERANCE) {
            let error = found.error + 1e-13 * (1.0 + found.c.abs()) / case.column.epsilon;
            for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
                let claim = test.claim(&case.column);
                let holds = claim.present_below <= found.c + error && claim.absent_above >= found.c - error;
                judge(holds, test.name);
            }
        }
        tally.worst_discord = heard.discord(&case.oscillator());
        // Next to the witness the flow has hardly an error, so that this judges the estimate of the witness: it is small
        // by a fifth at times (its documentation), and never by half.
        tally.discords = u64::from(tally.worst_discord > 1.5);
        if tally.worst_discord > 1.0 {
            // The witness' estimate is sometimes too small where friction is steep next to the belt line.
            let finer = Heard::new(case, 1e-3 * TOLERANCE, false);
            judge(tally.worst_discord <= 10.0 && finer.discord(&case.oscillator()) <= 1.0, "margins");
        }
        for flow in [&heard.witness, &heard.flow] {
            judge_landing(flow, &case.oscillator(), &mut judge);
            let returns = matches!(flow.fate, Fate::Sticks(_) | Fate::CrossesForever | Fate::Failed(_));
            judge(returns || flow.margin.is_finite(), "no margin");
            judge(flow.margin_error >= 0.0 && flow.rhs > 0, "no error estimate");
        }
        if heard.opinions[1].fates == ANY {
            tally.open.push(format!("{case:?}\n  {heard:?}"));
        }
        tally
    }

    fn plus(mut self, other: Self) -> Self {
        for (pair, count) in other.fates {
            *self.fates.entry(pair).or_default() += count;
        }
        for (by, count) in other.decided {
            *self.decided.entry(by).or_default() += count;
        }
        self.discords += other.discords;
        self.worst_discord = self.worst_discord.max(other.worst_discord);
        self.open.extend(other.open);
        self.problems.extend(other.problems);
        self
    }
}

/// Landings are on the stick segment, and sticking ends at the exit point.
fn judge_landing(flow: &Flow, oscillator: &Oscillator, judge: &mut impl FnMut(bool, &str)) {
    let Fate::Sticks(landing) = flow.fate else { return };
    let exit = oscillator.exit_x1();
    // Three roundings of numbers of this size.
    let rounding = 4.0 * f64::EPSILON * (1.0 + exit.abs() + landing.x1.abs());
    let on_segment = exit - 2.0 - rounding <= landing.x1 && landing.x1 <= exit;
    judge(on_segment && landing.slip_time > 0.0, "landing off the segment");
    let leaves_at = landing.x1 + oscillator.belt_speed * landing.stick_time;
    judge((leaves_at - exit).abs() <= rounding, "stick time");
}

/// Compares the opinions at `count` points, and requires agreement.
fn survey(count: u64) -> Tally {
    let tally = (0..count)
        .into_par_iter()
        .map(|number| Tally::of(&Case::numbered(number), number % 23 == 0))
        .reduce(Tally::default, Tally::plus);
    println!("{count} points; fates of the witness and of the map:");
    for (fates, points) in &tally.fates {
        println!("{points:8}  {fates:?}");
    }
    println!("decided by engine: {:?}", tally.decided);
    println!("{} discords, by {:.2} errors at worst", tally.discords, tally.worst_discord);
    println!("{} open, {} problems", tally.open.len(), tally.problems.len());
    assert!(tally.problems.is_empty(), "{}", tally.problems[..tally.problems.len().min(20)].join("\n"));
    // One estimate in five thousand points may be too small, as the witness' documentation states.
    assert!(5000 * tally.discords <= count + 5000, "{} of {count} margins are at odds", tally.discords);
    // Constant friction without damping grazes exactly, and is open.
    assert!(1000 * tally.open.len() as u64 <= count + 1000, "{}", tally.open.join("\n"));
    tally
}

#[test]
fn every_engine_says_the_same_of_every_law() {
    let tally = survey(720);
    for fates in ["sticks", "sticks from above", "spirals inward", "crosses for ever"] {
        assert!(tally.fates.contains_key(&[fates, fates]), "the sample has no orbit that {fates}");
    }
    let engines = ["witness", "flow", "critical damping", "symmetric", "backbone", "validated"];
    for engine in engines {
        assert!(
            tally.decided.get(engine).is_some_and(|decided| *decided > 20),
            "{engine}: {:?}",
            tally.decided
        );
    }
}

#[test]
#[ignore = "minutes of two processors: cargo test --test mathematics agreement:: -- --ignored --nocapture"]
fn every_engine_says_the_same_at_a_hundred_thousand_points() {
    survey(100_000);
}

/// Formulas with steps narrow beside the belt speed, so that the orbit is followed by arcs, at tolerances far
/// below that of maps.
#[test]
fn margins_below_the_error_of_maps_have_a_verdict() {
    for number in [770, 1769, 2926, 3417, 3904, 4314] {
        let case = Case::any_law(number);
        let verdict = decide(std::slice::from_ref(&case.column), &[case.c], TOLERANCE)[0];
        assert!(verdict.is_decision(), "{case:?}");
    }
}

/// On fast belts the audit compares two engines: orbits that cross the belt line are followed by arcs in a map
/// and in (x1, x2) by the witness, at other places and with other digits.
#[test]
fn an_audit_of_fast_belts_compares_two_engines() {
    let nodes = vec![
        vec![1.0],
        vec![0.0],
        vec![0.0],
        vec![0.1, 0.2],
        vec![20.0, 30.0, 60.0],
        (0..12).map(|i| 0.002 * f64::from(i)).collect(),
    ];
    let grid = Grid::new(Law::Stribeck, nodes).unwrap();
    let plan = Plan::builder(grid.clone())
        .methods([Method::Simulation])
        .tolerance(TOLERANCE)
        .audit_cells(grid.cells())
        .tile_shape(grid.shape())
        .build()
        .unwrap();
    let audit = run(&plan, &Each(|_| {}), &Control::default()).unwrap().account.audit;
    assert_eq!((audit.checked, audit.agreed), (grid.cells() as u64, grid.cells() as u64), "{audit:?}");
    let mut crossing = 0;
    for i in 0..grid.cells() {
        let point = grid.point(&[0, 0, 0, i / 36, i / 12 % 3, i % 12]);
        let oscillator = Oscillator::new(&Law::Stribeck, &point);
        let answers = [flow(&oscillator, TOLERANCE), witness::flow(&oscillator, TOLERANCE)];
        if let [Fate::CrossesForever, fate] = answers.map(|answer| answer.fate) {
            assert_eq!(fate, Fate::CrossesForever, "{point:?}");
            assert_ne!(answers[0].rhs, answers[1].rhs, "{point:?}");
            crossing += 1;
        }
    }
    assert!(crossing > 10, "{crossing}");
}

/// A grid with every limit of the law and with fast belts, computed by every engine: each cell has the same
/// verdict, and no cell fails or is left out.
#[test]
fn every_engine_labels_every_cell_alike() {
    let nodes = vec![
        vec![1e-3, 0.03, 0.4, 1.0],
        vec![0.0, 0.35, 0.9, 1.0],
        vec![0.0, 0.2, 1.0],
        vec![0.0, 0.5, 3.0, 10.0],
        vec![0.1, 1.0, 4.0, 10.0],
        (0..24).map(|i| 0.13 * f64::from(i)).collect(),
    ];
    let grid = Grid::new(Law::Stribeck, nodes).unwrap();
    let by_engine = [How::Between, How::Alone, How::Direct].map(|how| verdicts(&grid, how).0);
    assert!(by_engine.iter().all(|verdicts| verdicts.len() == grid.cells()));
    let mut counts = BTreeMap::new();
    for cell in 0..grid.cells() {
        let verdicts = by_engine.each_ref().map(|verdicts| verdicts[cell]);
        *counts.entry(verdicts.map(Verdict::code)).or_insert(0) += 1;
        let point = grid.point(&unravel(cell, &grid.shape()));
        let &[alpha, beta, gamma] = point.law.as_slice() else { panic!("a Stribeck point") };
        // Without weakening, strengthening and damping every orbit is a circle, and the one from the exit
        // point grazes exactly.
        let grazes = gamma * (1.0 - alpha) == 0.0 && beta == 0.0 && point.damping == 0.0;
        let expected =
            if grazes { [Verdict::Undecided].as_slice() } else { &[Verdict::Present, Verdict::Absent] };
        let legal: Vec<[Verdict; 3]> = expected.iter().map(|verdict| [*verdict; 3]).collect();
        assert!(legal.contains(&verdicts), "{point:?}: {verdicts:?}");
    }
    println!("verdicts between columns, of columns alone, direct: {counts:?}");
    assert_eq!(counts.len(), 3, "present, absent, undecided: {counts:?}");
}

/// Verdicts near the boundary are right: at c* (1 +- 1e-9) the margin is far below the tolerance of maps.
#[test]
fn every_engine_is_right_next_to_the_boundary() {
    let mut random = Random(77);
    let mut tried = 0;
    while tried < 200 {
        let sample = Sample {
            epsilon: random.log(0.02, 1.0),
            alpha: 0.95 * random.unit(),
            beta: 0.5 * random.unit(),
            gamma: random.log(0.3, 10.0),
            belt_speed: random.log(0.2, 2.0),
            damping: 0.0,
        };
        let column = sample.column();
        let critical = critical_damping(&column, 1e-15).unwrap();
        // pi eps c* 1e-9 is the margin: it must be above the resolution of the direct engine, a few 1e-13.
        if sample.epsilon * critical.c < 1e-3 {
            continue;
        }
        tried += 1;
        assert!(critical.error < 1e-11 * critical.c, "{sample:?} {critical:?}");
        let cs = [critical.c * (1.0 - 1e-9), critical.c * (1.0 + 1e-9)];
        let verdicts = decide(std::slice::from_ref(&column), &cs, TOLERANCE);
        assert_eq!(verdicts, [Verdict::Present, Verdict::Absent], "{sample:?}");
        for fate in [flow, witness::decisive_flow] {
            let verdicts =
                cs.map(|c| Verdict::from(&fate(&Oscillator::in_column(&column, c), TOLERANCE).fate));
            assert_eq!(verdicts, [Verdict::Present, Verdict::Absent], "{sample:?}");
        }
    }
}
