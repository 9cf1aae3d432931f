//! The damping at which orbits close, for every law and amplitude: its error holds against the flow in (x2,
//! x2') and the direct engine, for strong weakening too; regimes counted on a coarse backbone are those of
//! cycles that are located.

use crate::sample::slip_cycles;
use slipmap::column::backbone::{Backbone, TurningPoint};
use slipmap::column::critical_damping;
use slipmap::column::{Regime, regime, slip_cycle_count};
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::{Column, Law, Table};
use slipmap::orbits::arc::{SlipTurn, turn};
use slipmap::orbits::{Piece, Work, flow};
use slipmap::witness;

use crate::sample::{Random, Sampling, at_one, formula, returns};

/// Columns of every law but Stribeck's, `strong` times as weakening as usual.
fn columns(count: usize, strong: f64) -> Vec<Column> {
    let mut random = Random(80);
    let text = "1 - a*u*exp(-u/s) + h*sin(w*u) + d*u";
    let wavy = formula(text);
    let data: Vec<(f64, f64)> = (0..60)
        .map(|i| 0.15 * f64::from(i))
        .map(|u| (u, 1.0 - 0.4 * strong.min(2.0) * (1.0 - (-u).exp()) + 0.02 * u))
        .collect();
    let measured = Law::Table(Table::new("sampled", &data, 1.0).unwrap());
    let folding = formula("1 - s*(u - a*sin(k*u)/k)");
    let laws = [Law::Exponential, Law::Lorentzian, wavy, measured, folding];
    (0..count)
        .map(|i| {
            let law = &laws[i % laws.len()];
            let mut between = |lo: f64, hi: f64| random.between(lo, hi);
            let parameters = match law {
                Law::Expression(_) if i % laws.len() == 4 => {
                    vec![between(0.01, 0.2) * strong, between(1.0, 2.0), between(4.0, 10.0)]
                }
                // a, s, h, w, d in the order of the text.
                Law::Expression(_) => vec![
                    between(0.0, 1.5) * strong,
                    between(0.5, 1.5),
                    between(0.0, 0.2) * strong,
                    between(0.0, 8.0),
                    between(-0.1, 0.0),
                ],
                Law::Table(_) => vec![],
                _ => vec![between(0.0, 0.9), between(0.2, 2.0) / strong, between(0.0, 0.1)],
            };
            let belt_speed = between(0.1, 2.0);
            law.column(&law.point(1.0, &parameters, belt_speed, 0.0).unwrap())
        })
        .collect()
}

fn size(column: &Column) -> f64 {
    let speeds = (0..=32).map(|i| f64::from(i) / 16.0 * column.belt_speed);
    speeds.map(|u| column.curve.weakening(u).abs()).fold(0.0, f64::max)
}

/// Beyond c* the orbit crawls along a slow manifold, and next to it the margin jumps.
#[test]
fn a_slow_belt_with_strong_weakening_has_a_critical_damping() {
    let law = Law::Exponential;
    let parameters = [0.11942666779210852, 0.003180111210762882, 0.3716811919414624];
    let column = law.column(&law.point(1.0, &parameters, 0.004350037351403274, 0.0).unwrap());
    let found = critical_damping(&column, 1e-9).unwrap();
    // Reference value by an independent integrator, at two tolerances.
    assert!((found.c - 70.146402).abs() < 1e-6 && found.error < 1e-6, "{found:?}");
    let fates = [-2.0, 2.0].map(|errors| {
        let oscillator = Oscillator::in_column(&column, found.c + errors * found.error);
        witness::flow(&oscillator, 1e-13).fate
    });
    assert!(matches!(fates, [Fate::Sticks(_), Fate::SpiralsInward]), "{found:?} {fates:?}");
}

#[test]
fn the_direct_verdict_changes_at_the_critical_damping() {
    let (mut solved, mut decided, mut asked) = (0, 0, 0);
    for strong in [1.0, 3.0] {
        for column in columns(60, strong) {
            for tolerance in [1e-6, 1e-10] {
                let Ok(found) = critical_damping(&column, tolerance) else { continue };
                if found.c < 0.0 {
                    continue;
                }
                solved += 1;
                let allowed = (4.0 * tolerance).max(2e-8) * size(&column);
                assert!(found.error <= allowed, "{column:?} {found:?}");
                // The margin moves by about pi V times a change of the damping.
                let step = found.error + 1e-11 * size(&column);
                for (c, back) in [(found.c - step, true), (found.c + step, false)] {
                    let answer = witness::flow(&Oscillator::in_column(&column, c), 1e-13);
                    let says = returns(&answer.fate);
                    assert!(says.is_none_or(|says| says == back), "{column:?} {found:?} {answer:?}");
                    asked += 1;
                    decided += usize::from(says.is_some());
                }
            }
        }
    }
    // Strong nodes have no answer; next to the boundary the direct engine is undecided.
    assert!(solved >= 180 && 10 * decided >= 6 * asked, "{solved}: {decided} of {asked}");
}

#[test]
fn cycles_are_counted_as_they_are_located() {
    let mut counts = [0; 4];
    for column in columns(80, 1.0) {
        let even = column.curve.even_weakening_range(column.belt_speed);
        for i in 1..6 {
            let viscous = even.lo + (even.hi - even.lo) * f64::from(i) / 6.0;
            let curve = column.curve.clone();
            let oscillator = Oscillator { curve, viscous, belt_speed: column.belt_speed };
            let Some(counted) = slip_cycle_count(&oscillator, &flow(&oscillator, 1e-9)) else { continue };
            if let Ok(located) = slip_cycles(&oscillator, 1e-9) {
                assert_eq!(counted, located.len(), "{oscillator:?}");
                counts[counted.min(3)] += 1;
            }
        }
    }
    assert!(counts[0] > 20 && counts[1] > 20 && counts[2] + counts[3] > 5, "{counts:?}");
}

/// The number of slip cycles by a backbone whose ends are known.
fn cycles_between(ends: [TurningPoint; 2], backbone: &Backbone, viscous: f64) -> Option<usize> {
    let [stable, returns] = [ends[0].viscous < viscous, viscous < ends[1].viscous];
    backbone.cycles(viscous, stable, returns).map(|cycles| cycles.len())
}

fn ends(backbone: &Backbone) -> [TurningPoint; 2] {
    let points = backbone.turning_points();
    [points[0], points[points.len() - 1]]
}

/// Asserts that every coarse backbone that decides the count at a damping counts the same cycles as the fine
/// one. Returns the numbers of such counts: of all backbones, and of the coarsest.
fn coarse_counts(column: &Column, fine: &Backbone, dampings: &[f64]) -> [u32; 2] {
    let work = Work::of(Piece::FineBackbone, &column.curve);
    let mut coarse = Some(Backbone::coarsest(&column.curve, column.belt_speed, 1e-5, &work).unwrap());
    let (mut level, mut counts) = (0, [0; 2]);
    while let Some(backbone) = coarse {
        for &viscous in dampings.iter().filter(|viscous| backbone.is_reliable_at(**viscous)) {
            let count = |backbone| cycles_between(ends(fine), backbone, viscous);
            if let Some(counted) = count(fine) {
                assert_eq!(count(&backbone), Some(counted), "{column:?} {viscous}: {backbone:?}");
                counts[0] += 1;
                counts[1] += u32::from(level == 0);
            }
        }
        coarse = backbone.refined(&column.curve, 1e-5, &work).unwrap();
        level += 1;
    }
    counts
}

/// Coarse and fine counts agree on rough laws too, and next to the critical damping.
#[test]
fn coarse_backbones_count_as_the_fine_one() {
    let mut random = Random(81);
    let mut counts = [0; 2];
    for column in columns(75, 1.0) {
        let fine = Backbone::of(&column, 1e-10).unwrap();
        let grazing = fine.viscous(column.belt_speed);
        let even = column.curve.even_weakening_range(column.belt_speed);
        let mut dampings: Vec<f64> = (0..20).map(|_| even.lo + (even.hi - even.lo) * random.unit()).collect();
        dampings.extend((0..10).map(|_| grazing + 1e-3 * (even.hi - even.lo) * (random.unit() - 0.5)));
        let of_column = coarse_counts(&column, &fine, &dampings);
        counts.iter_mut().zip(of_column).for_each(|(sum, count)| *sum += count);
    }
    assert!(counts[1] > 300 && counts[0] > 600, "{counts:?}");
}

/// A table of `rows` of mu + (1 - mu) exp(-u/vs) and a wave, and a constant beyond u = 10, on a belt.
fn wavy_table(
    rows: u32,
    [mu, vs, rise]: [f64; 3],
    [size, waves, phase]: [f64; 3],
    belt_speed: f64,
) -> Column {
    let phi = |u: f64| {
        let wave = size * ((waves * u + phase).sin() - phase.sin());
        mu + (1.0 - mu) * (-u / vs).exp() + rise * u / 3.0 + wave
    };
    let places = (0..rows).map(|i| 10.0 / f64::from(rows) * f64::from(i));
    let mut data: Vec<(f64, f64)> = places.map(|u| (u, phi(u))).collect();
    data.push((14.0, data[data.len() - 1].1));
    let law = Law::Table(Table::new("wavy", &data, 1.0).unwrap());
    law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap())
}

/// Tables whose backbone is hard to see on few nodes, each with a damping and the number of its cycles.
#[test]
fn cycles_that_few_nodes_hide_are_counted() {
    // A dip between r = 0.06 and 0.23, where a polynomial by values and slopes there has none; its first cycle
    // attracts.
    let dip = wavy_table(
        27,
        [0.253_590_857_451_886_8, 1.761_167_405_660_870_4, 0.033_238_371_030_369_4],
        [0.024_384_494_620_662_583, 3.620_230_074_535_384, 5.141_918_960_136_492_5],
        1.576_587_870_601_906,
    );
    // So flat between two nodes that coarse backbones show one cycle where there are three.
    let flat = wavy_table(
        30,
        [0.328_155_368_236_351_5, 1.549_054_591_320_887_7, 0.0],
        [0.133_961_177_007_682_2, 1.237_284_430_417_761_7, 3.742_781_442_792_216],
        0.721_234_341_333_153_1,
    );
    // A corner next to the belt speed: C turns at an amplitude below that of every node.
    let corner = wavy_table(
        28,
        [0.513_458_006_809_270_3, 2.062_287_976_462_274_6, 0.059_803_019_248_228_85],
        [0.029_961_481_232_045_215, 1.305_431_656_259_072_4, 3.325_997_277_526_252_7],
        0.718_416_576_807_954_6,
    );
    // Two turns between two nodes, which the slopes there show and the polynomial does not.
    let turns = wavy_table(
        29,
        [0.458_407_758_451_794_3, 1.158_114_111_842_981, 0.088_071_917_314_429_48],
        [0.004_122_073_010_030_446_5, 1.482_962_775_631_811, 0.815_085_944_690_193_5],
        2.431_995_102_065_819_5,
    );
    let cases = [
        (dip, 0.168_526_192_580_366_77, 2),
        (flat, 0.286_459_945_308_767_56, 3),
        (corner, 0.160_879_969_563_859_1, 2),
        (turns, 0.030_372_754_243_075_152, 3),
    ];
    let coarse = cases.map(|(column, viscous, cycles)| {
        let fine = Backbone::of(&column, 1e-10).unwrap();
        assert_eq!(cycles_between(ends(&fine), &fine, viscous), Some(cycles), "{column:?}");
        coarse_counts(&column, &fine, &[viscous])[0]
    });
    assert!(coarse[0] > 0, "{coarse:?}");
}

/// Next to the critical damping of tables without waves the slopes at few nodes settle the number of cycles.
#[test]
fn slopes_settle_counts_next_to_the_critical_damping() {
    let mut settled = [0; 2];
    for number in 0..50 {
        let belt_speed = 0.3 + 0.03 * f64::from(number);
        let column = wavy_table(40, [0.5, 2.0, 0.0], [0.0, 1.0, 0.0], belt_speed);
        let fine = Backbone::of(&column, 1e-10).unwrap();
        let work = Work::of(Piece::FineBackbone, &column.curve);
        let coarsest = Backbone::coarsest(&column.curve, belt_speed, 1e-5, &work).unwrap();
        let Some(finer) = coarsest.refined(&column.curve, 1e-5, &work).unwrap() else { continue };
        for (settled, backbone) in settled.iter_mut().zip([coarsest, finer]) {
            let viscous = ends(&backbone)[1].viscous + 0.5 * backbone.error;
            if backbone.is_reliable_at(viscous) {
                *settled += 1;
                let counts =
                    [&backbone, &fine].map(|backbone| cycles_between(ends(&fine), backbone, viscous));
                assert_eq!(counts[0], counts[1], "{belt_speed}");
            }
        }
    }
    assert!(settled.iter().all(|settled| *settled > 45), "{settled:?}");
}

/// A dip of friction of 1/26 of the belt speed changes C(r) between the first nodes of a backbone, which do
/// not resolve it: three cycles, where one was counted.
#[test]
fn cycles_at_a_narrow_dip_are_counted() {
    let law = formula("1-a*u/(u+b)+d*exp(-((u-p)/w)^2)-d*exp(-(p/w)^2)");
    let parameters = [
        0.8028961796423718,
        1.4075835981671745,
        -0.0020856426832017213,
        0.2837982264060425,
        0.015677402555442616,
    ];
    let oscillator = at_one(&law, &parameters, 0.4104212212654299, 0.34211090458474824);
    let answer = flow(&oscillator, 1e-9);
    assert_eq!(slip_cycle_count(&oscillator, &answer), Some(3));
    assert_eq!(regime(&oscillator, &answer), Regime::EquilibriumPureSlipAndStickSlip);
    // Orbits between the cycles, by an engine that does not use the backbone.
    for (radius, shrinks) in [(0.03, true), (0.08, false), (0.13, true), (0.2, false)] {
        let SlipTurn::Returns { radius: next, .. } = turn(&oscillator, radius, 1e-12).unwrap() else {
            panic!("{radius}")
        };
        assert_eq!(next < radius, shrinks, "{radius} {next}");
    }
}
