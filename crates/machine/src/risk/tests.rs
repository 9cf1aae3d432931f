//! Tests of probabilities against separate counts and draws.

use super::*;
use crate::{Friction, Model, example, example_of};
use slipmap_column::critical_damping;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Fate;
use slipmap_model::friction::{Expression, Law, Table};
use slipmap_model::point::LawParameters;
use slipmap_orbits::flow;

/// The critical damping in SI units, by a root search for this machine alone.
fn critical(machine: &Machine) -> f64 {
    let model = machine.model().unwrap();
    critical_damping(&model.column(), 1e-10).unwrap().c * model.si.damping
}

fn machine(law: Law) -> Machine {
    example(law).with("strengthening", 0.0).unwrap()
}

#[test]
fn an_uncertain_damping_alone_has_a_known_probability() {
    // Its critical damping is one number d*, so that P = P(d < d*), evenly spread between two values.
    let machine = machine(Law::Exponential);
    let critical = critical(&machine);
    let machine = machine.with("damping", critical).unwrap();
    let (min, max) = (0.9 * critical, 1.3 * critical);
    let uncertain = [("damping", Spread::Uniform { min, max })];
    let found = risk(&machine, &uncertain, Some(20_000), &[0.05], None).unwrap();
    // Four standard errors of a share.
    let error = |p: f64| 4.0 * (p * (1.0 - p) / 20_000.0_f64).sqrt();
    let [low, high] = found.probability.limits;
    assert!((found.probability.value - 0.25).abs() < error(0.25), "{found:?}");
    // The limits are 1.96 standard errors to both sides.
    assert!((0.5 * (high - low) / error(0.25) - 1.96 / 4.0).abs() < 0.02, "{found:?}");
    // The nominal damping is d*; deviations go from -0.1 to 0.3 of it. To exceed d* in all but 5 % of the
    // draws, it has to be d* (1 + 0.1 - 0.05 * 0.4).
    let damping = found.rare_by[0].damping.unwrap();
    let exact = critical * (1.0 + 0.1 - 0.02);
    assert!((damping.value - exact).abs() < 0.4 * critical * error(0.05), "{damping:?} {exact}");
    assert!(damping.limits[0] < damping.value && damping.value < damping.limits[1], "{damping:?}");
    assert!((found.failed, found.draws) == (0, 20_000));
}

/// On a fast belt orbits cross for ever below other dampings: a draw stick-slips between the two, as its own orbit does.
#[test]
fn draws_that_overtake_the_belt_for_ever_do_not_stick_slip() {
    let like = machine(Law::Exponential).with("kinetic_friction", 0.1).unwrap();
    let fast = like.with("stribeck_velocity", 25.0).unwrap().with("belt_speed", 75.0).unwrap();
    let critical = critical(&fast);
    let fast = fast.with("damping", 0.9 * critical).unwrap();
    let uncertain =
        [("damping", Spread::Normal { sd: 0.1 * critical }), ("belt_speed", Spread::Normal { sd: 3.0 })];
    let found = risk(&fast, &uncertain, Some(CHUNK), &[], None).unwrap();
    let mut random = Random(0x5115_ca9e);
    let mut sticks = || {
        let Draw { machine, of_damping, .. } = Draws::of(&fast, &uncertain).draw(&mut random).unwrap();
        let machine = machine.with("damping", fast.damping + of_damping).unwrap();
        let Model { law, point, .. } = machine.model().unwrap();
        matches!(flow(&Oscillator::new(&law, &point), 1e-9).fate, Fate::Sticks(_))
    };
    let count = (0..CHUNK).filter(|_| sticks()).count();
    let by_risk = found.probability.value * CHUNK as f64;
    // The lower damping is found to a thousandth of the critical one, that is a hundredth of its deviation.
    assert!((by_risk - count as f64).abs() < 0.01 * CHUNK as f64, "{by_risk} {count}");
    assert!(count > CHUNK / 10 && count < CHUNK / 2, "{count}");
    // The damping for half of that probability has it.
    let share = found.probability.value;
    let found = risk(&fast, &uncertain, Some(CHUNK), &[0.5 * share], None).unwrap();
    let rare = found.rare_by[0].damping.unwrap().value;
    let above = risk(&fast.with("damping", rare).unwrap(), &uncertain, Some(CHUNK), &[], None).unwrap();
    assert!((above.probability.value - 0.5 * share).abs() < 2.0 / CHUNK as f64, "{rare} {above:?}");
}

#[test]
fn a_rare_damping_next_to_zero_has_its_probability() {
    // Negative dampings are illegal: how many draws that concerns depends on the nominal damping.
    let machine = machine(Law::Exponential);
    let critical = critical(&machine);
    let uncertain = [
        ("damping", Spread::Normal { sd: 0.4 * critical }),
        ("belt_speed", Spread::Uniform { min: 0.1, max: 0.4 }),
    ];
    let found =
        risk(&machine.with("damping", 0.01 * critical).unwrap(), &uncertain, Some(20_000), &[0.3, 0.1], None)
            .unwrap();
    assert!(found.draws < 12_000 && found.draws + found.redrawn == 20_000, "{found:?}");
    for RareBy { probability, damping } in found.rare_by {
        let nominal = machine.with("damping", damping.unwrap().value).unwrap();
        let there = risk(&nominal, &uncertain, Some(20_000), &[], None).unwrap().probability;
        assert!((there.value - probability).abs() < 2e-3, "{probability} {there:?}");
    }
}

/// The draws that are legal depend on the damping, and so does their number in a probability.
#[test]
fn rare_dampings_count_the_draws_made_illegal() {
    let machine = machine(Law::Exponential);
    let critical = critical(&machine);
    let machine = machine.with("damping", critical).unwrap();
    // At a nominal damping d < a dampings are even from 0 to d + a, so that the probability is d* / (d + a).
    let a = 5.0 * critical;
    let uncertain = [("damping", Spread::Uniform { min: critical - a, max: critical + a })];
    let needed = Needed::of(&machine, &uncertain, 5_000).unwrap();
    for probability in [0.17, 0.15, 0.12] {
        let found = needed.quantile(probability).unwrap();
        let exact = critical / probability - a;
        // The limits are 3.9 standard errors apart.
        assert!((found.value - exact).abs() < found.limits[1] - found.limits[0], "{found:?} {exact}");
        for (side, limit) in found.limits.into_iter().enumerate() {
            // The damping there is that of a draw: its rank is rounded down, and that of the upper limit is one more.
            let legal = needed.legal_of(&needed.draws, limit) as f64;
            let off = needed.probability(limit).limits[side] - probability;
            assert!(off.abs() < 3.0 / legal, "{found:?} {off}");
        }
    }
}

/// A machine with several uncertain quantities.
fn uncertain_machine() -> (Machine, Vec<Uncertain>) {
    let uncertain = [
        ("normal_force", Spread::Normal { sd: 12.0 }),
        ("mass", Spread::Uniform { min: 1.6, max: 2.5 }),
        ("belt_speed", Spread::Uniform { min: 0.05, max: 0.4 }),
        ("kinetic_friction", Spread::Normal { sd: 0.05 }),
        ("strengthening", Spread::Uniform { min: 0.0, max: 0.04 }),
    ];
    (example(Law::Stribeck), uncertain.to_vec())
}

/// Two quantities with the covariance of a fit: their sum and difference are independent.
#[test]
fn fitted_quantities_are_drawn_with_their_covariance() {
    let machine = machine(Law::Exponential);
    let machine = machine.with("damping", 1.05 * critical(&machine)).unwrap();
    let [a, b] = [0.02, 0.03];
    let row = |first: f64, second: f64| {
        let mut row = [0.0; MOST_JOINT];
        row[..2].copy_from_slice(&[first, second]);
        Spread::Joint { row }
    };
    let uncertain = [("kinetic_friction", row(a, 0.0)), ("stribeck_velocity", row(-b, 0.02))];
    let found = risk(&machine, &uncertain, Some(4_000), &[], None).unwrap();
    let mut random = Random(3);
    let n = 2_000;
    let sticks = (0..n).filter(|_| {
        let [one, other] = [random.normal(), random.normal()];
        let moved = machine.with("kinetic_friction", 0.3 + a * one).unwrap();
        critical(&moved.with("stribeck_velocity", 0.25 - b * one + 0.02 * other).unwrap()) > machine.damping
    });
    let (share, p) = (sticks.count() as f64 / f64::from(n), found.probability.value);
    let error = (p * (1.0 - p) * (1.0 / 4_000.0 + 1.0 / f64::from(n))).sqrt();
    assert!(p > 0.05 && p < 0.95 && (share - p).abs() < 4.0 * error, "{share} {p}");
}

/// A machine with measured friction, each datum with its standard error, and the data.
fn measured_machine() -> (Machine, Vec<(f64, f64)>, Vec<f64>) {
    let data: Vec<(f64, f64)> =
        [0.0, 0.05, 0.12, 0.25, 0.45, 0.8, 2.0, 4.0].map(|u: f64| (u, 0.3 + 0.1 * (-u / 0.25).exp())).into();
    let errors: Vec<f64> = (0..8).map(|i| 2e-4 * f64::from(1 + i % 3)).collect();
    let table = Table::new("a test", &data, data[0].1).unwrap().with_standard_errors(&errors).unwrap();
    (Machine { friction: Friction::Measured(table), ..example(Law::Stribeck) }, data, errors)
}

#[test]
fn friction_is_as_uncertain_as_other_measurements() {
    let (machine, data, errors) = measured_machine();
    let nominal = critical(&machine);
    let machine = machine.with("damping", 1.01 * nominal).unwrap();
    let mut random = Random(5);
    let n = 300;
    let others: Vec<f64> = (0..n)
        .map(|_| {
            let mut data = data.clone();
            data.iter_mut().zip(&errors).for_each(|((_, mu), error)| *mu += error * random.normal());
            let table = Table::new("another", &data, data[0].1).unwrap();
            critical(&Machine { friction: Friction::Measured(table), ..machine.clone() })
        })
        .collect();
    let spread = (others.iter().map(|other| (other - nominal).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
    let found = risk(&machine, &[], Some(5_000), &[], None).unwrap();
    // Four standard errors of a standard deviation and of a share; the critical damping's second order in
    // the errors of the data is far below them.
    let standard_error = found.standard_error.unwrap();
    assert!(
        (spread / standard_error - 1.0).abs() < 4.0 / f64::from(2 * n).sqrt(),
        "{spread} {standard_error}"
    );
    let share = others.iter().filter(|other| **other > machine.damping).count() as f64 / f64::from(n);
    let p = found.probability.value;
    assert!(
        (share - p).abs() < 4.0 * (p * (1.0 - p) * (1.0 / f64::from(n) + 1.0 / 5_000.0)).sqrt(),
        "{share} {p}"
    );
    assert!(0.05 < p && p < 0.45, "the case is a test: {p}");
}

/// Friction that rises within its standard errors may fall: the probability has no step where the critical
/// damping of the data passes zero.
#[test]
fn friction_that_rises_within_its_errors_may_stick_slip() {
    let speeds = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2];
    let of = |slope: f64| {
        let data = speeds.map(|u| (u, 0.3 + slope * u));
        let table = Table::new("flat", &data, data[0].1).unwrap().with_standard_errors(&[0.01; 6]).unwrap();
        example_of(Friction::Measured(table), [1.8, 4.2e5, 900.0, 0.2, 1.0])
    };
    let found = |slope: f64| risk(&of(slope), &[], Some(4_000), &[], None).unwrap();
    let [rises, falls] = [1e-4, -1e-4].map(|slope| found(slope).probability.value);
    assert!((rises - falls).abs() < 0.02 && (0.4..0.6).contains(&rises), "{rises} {falls}");
    let rising = found(0.005);
    // Of 300 tables with other errors.
    let machine = of(0.005);
    let mut random = Random(8);
    let n = 300;
    let may = (0..n).filter(|_| {
        let data = speeds.map(|u| (u, 0.3 + 0.005 * u + 0.01 * random.normal()));
        let table = Table::new("another", &data, data[0].1).unwrap();
        critical(&Machine { friction: Friction::Measured(table), ..machine.clone() }) > machine.damping
    });
    let share = may.count() as f64 / f64::from(n);
    let p = rising.probability.value;
    assert!((share - p).abs() < 4.0 * (p * (1.0 - p) / f64::from(n)).sqrt(), "{share} {p}");
    assert!(rising.failed == 0 && rising.standard_error.is_some_and(|error| error > 10.0), "{rising:?}");
    // It does not where friction rises by far more than its errors.
    let steep = found(1.0);
    assert!(steep.failed == 0 && steep.probability.value == 0.0, "{steep:?}");
}

#[test]
fn steep_scattered_data_have_a_standard_error_too() {
    // Rows as a rig gives them: near rest friction falls so fast that the orbit is outside the polar form.
    let speeds = [0.0, 0.002, 0.00254, 0.00411, 0.00664, 0.01074, 0.01735, 0.03566, 0.07327, 0.15055, 0.5];
    let friction = [0.3736, 0.3481, 0.3523, 0.3525, 0.3299, 0.3228, 0.3029, 0.2798, 0.2473, 0.2313, 0.2418];
    let data: Vec<(f64, f64)> = speeds.into_iter().zip(friction).collect();
    let table = Table::new("a rig", &data, data[0].1).unwrap().with_standard_errors(&[0.004; 11]).unwrap();
    let machine = example_of(Friction::Measured(table), [1.2, 9e4, 250.0, 0.1, 4.0]);
    let uncertain = [("normal_force", Spread::Normal { sd: 10.0 })];
    let found = risk(&machine, &uncertain, Some(60), &[], None).unwrap();
    assert!(found.failed == 0 && found.standard_error.is_some_and(|error| error > 0.0), "{found:?}");
}

#[test]
fn illegal_draws_and_failed_ones_are_counted_apart() {
    let machine = machine(Law::Exponential);
    let uncertain = [("mass", Spread::Normal { sd: 0.8 * machine.mass })];
    let found = risk(&machine, &uncertain, Some(1000), &[], None).unwrap();
    // A normal number is more than 1.25 standard deviations below its mean in 10.6 % of all draws: of those
    // until 1000 are legal, 118 on average.
    assert!((60..180).contains(&found.redrawn), "{}", found.redrawn);
    assert_eq!((found.draws, found.failed), (1000, 0));
    // So are exponents of a formula below 1: one standard deviation below the mean, 15.9 % of all.
    let formula = Expression::new("0.3 + 0.2*exp(-(u/0.06)^delta)", 0.5).unwrap();
    let friction = Friction::Formula(formula, LawParameters::new(&[1.1]));
    let machine = Machine { friction, ..machine };
    let found = risk(&machine, &[("delta", Spread::Normal { sd: 0.1 })], Some(300), &[], None).unwrap();
    assert!((25..90).contains(&found.redrawn), "{}", found.redrawn);
    assert_eq!((found.draws, found.failed), (300, 0));
}

#[test]
fn limits_hold_whatever_draws_without_an_answer_do() {
    let needed = |failed| Needed {
        draws: (1..=1000)
            .map(|i| NeededDraw {
                unstable_below: 0.0,
                damping: f64::from(i),
                sticks_between: [f64::NEG_INFINITY; 2],
                legal_from: f64::NEG_INFINITY,
            })
            .collect(),
        all_legal_from: f64::NEG_INFINITY,
        failed,
        redrawn: 0,
        error: 0.0,
    };
    let (all, some) = (needed(0).probability(900.0), needed(250).probability(900.0));
    assert!(all.value == 0.1 && all.limits[0] > 0.08 && all.limits[1] < 0.125, "{all:?}");
    // 100 of 1250 at least, 350 at most, and the limits of a share of so many draws.
    assert!(some.value == 0.1 && (0.06..0.08).contains(&some.limits[0]), "{some:?}");
    assert!((0.28..0.31).contains(&some.limits[1]), "{some:?}");
    // All of those without an answer may need more damping than any other.
    assert!(needed(0).quantile(0.1).is_some() && needed(250).quantile(0.1).is_none());
    let half = needed(250).quantile(0.5).unwrap();
    assert!(half.limits[0] < 380.0 && half.limits[1] > 620.0 && half.value == 501.0, "{half:?}");
}

/// Of draws whose orbits leave the data it is unknown whether they stick: the limits hold whatever they do.
#[test]
fn orbits_that_leave_the_data_count_on_neither_side() {
    let data: Vec<(f64, f64)> =
        (0..=40).map(|i| 1.0125 * f64::from(i) / 40.0).map(|u| (u, 0.6 + 0.4 * (-2.0 * u).exp())).collect();
    let friction = Friction::Measured(Table::new("falls", &data, 1.0).unwrap());
    // In units in which all groups are 1 orbits leave the data below c = 0.316, and c* is 0.332.
    let machine = example_of(friction, [1.0, 1.0, 1.0, 0.5, 0.3]);
    let of = |damping: f64, sd: f64| {
        let uncertain = [("damping", Spread::Normal { sd })];
        risk(&machine.with("damping", damping).unwrap(), &uncertain, Some(400), &[], None)
    };
    let most = of(0.325, 0.01).unwrap().probability;
    // Of the normal distribution: 0.24 above c*, 0.57 between, and 0.19 unknown.
    let of_known = 0.57 / 0.81;
    assert!((most.value - of_known).abs() < 0.08, "{most:?}");
    assert!(most.limits[0] < 0.57 && most.limits[1] > 0.57 + 0.19, "{most:?}");
    assert_eq!(of(0.3, 1e-3).unwrap_err(), NoRisk::NoneFollowed);
}

#[test]
fn probabilities_agree_with_a_separate_count() {
    const DRAWN: u32 = 120;
    let (machine, uncertain) = uncertain_machine();
    let draws = Draws::of(&machine, &uncertain);
    let found = risk(&machine, &uncertain, Some(2000), &[0.1], None).unwrap();
    let mut random = Random(7);
    let sticks = (0..DRAWN)
        .filter(|_| {
            let drawn = draws.draw(&mut random).unwrap();
            critical(&drawn.machine) > machine.damping + drawn.of_damping
        })
        .count() as f64
        / f64::from(DRAWN);
    // Four standard errors of the difference of two shares.
    let share = found.probability.value;
    let error = (share * (1.0 - share) * (1.0 / 2000.0 + 1.0 / f64::from(DRAWN))).sqrt();
    assert!(share > 0.05 && share < 0.95, "{found:?}");
    assert!((share - sticks).abs() < 4.0 * error, "{found:?} {sticks}");
    // With that damping the probability is the requested one.
    let rare = machine.with("damping", found.rare_by[0].damping.unwrap().value).unwrap();
    let again = risk(&rare, &uncertain, Some(2000), &[], None).unwrap();
    assert!((again.probability.value - 0.1).abs() < 2e-3, "{again:?}");
}

/// Steady slip of the exponential law is unstable below the damping N (mu_s - mu_k)/v_s exp(-v/v_s): with a normal normal
/// force of 10 % the probability is that of a normal number.
#[test]
fn it_vibrates_by_itself_where_steady_slip_is_unstable() {
    let machine = machine(Law::Exponential);
    let slope = 0.1 / 0.25 * (-machine.belt_speed / 0.25_f64).exp();
    // Half a standard deviation above the nominal limit: 1 - Phi(0.5).
    let machine = Machine { damping: 50.0 * 1.05 * slope, ..machine };
    let draws = 20_000;
    let uncertain = [("normal_force", Spread::Normal { sd: 5.0 })];
    let found = risk(&machine, &uncertain, Some(draws), &[], None).unwrap();
    let exact = 0.308_537_538_725_987;
    let sd = (exact * (1.0 - exact) / draws as f64).sqrt();
    assert!((found.by_itself.value - exact).abs() < 4.0 * sd, "{:?}", found.by_itself);
    assert!(found.by_itself.value < found.probability.value);
    let [low, high] = found.by_itself.limits;
    assert!(low < found.by_itself.value && found.by_itself.value < high);
    // Without time the first draws only.
    let short = risk(&machine, &uncertain, Some(draws), &[], Some(std::time::Duration::ZERO)).unwrap();
    assert_eq!(short.draws, SEARCHED_TOGETHER);
}

/// Where an orbit may leave the data it is followed at several dampings for each draw: that is work, too, and there are fewer draws.
#[test]
fn orbits_that_may_leave_the_data_are_counted_as_work() {
    let usual = |fastest: f64| {
        let row = |i: i32| {
            let u = fastest * (f64::from(i) / 40.0).powi(2);
            (u, 0.3 + 0.15 * (-u / 0.05).exp())
        };
        let data: Vec<(f64, f64)> = (0..=40).map(row).collect();
        let table = Table::new("a pad", &data, data[0].1).unwrap();
        usual_draws(&example_of(Friction::Measured(table), [1.8, 4.2e5, 900.0, 0.1, 10.0]))
    };
    let [near, far] = [0.3, 0.5].map(usual);
    assert!(2 * near < far, "{near} {far}");
}
