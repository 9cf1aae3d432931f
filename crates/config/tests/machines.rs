//! Machines as people write them.

#![allow(clippy::unwrap_used)] // a test

use std::fs;

use slipmap_config::{ConfigError, MachineJob, load_machine};
use slipmap_machine::risk::Spread;
use tempfile::TempDir;

fn load(text: &str, set: &[(&str, &str)]) -> Result<MachineJob, ConfigError> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("machine.toml");
    fs::write(&file, text).unwrap();
    let set: Vec<(String, String)> =
        set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    load_machine(&file, &set)
}

/// A machine of the law `exponential`, but for lines in place of others.
fn pad(instead: &str) -> String {
    let usual = "mass = 2.0\nstiffness = 5e5\ndamping = 100.0\nnormal_force = 1000.0\nstatic_friction = 0.4\n\
                 kinetic_friction = 0.25\nstribeck_velocity = 0.05\nbelt_speed = 0.1\n";
    let key = |line: &str| line.split(' ').next().unwrap_or_default().to_owned();
    let is_kept = |line: &&str| !instead.lines().any(|other| key(other) == key(line));
    let kept: Vec<&str> = usual.lines().filter(is_kept).chain(instead.lines()).collect();
    format!("[friction]\nlaw = \"exponential\"\n[machine]\n{}\n", kept.join("\n"))
}

fn near(one: f64, other: f64) -> bool {
    // A product of few factors rounds.
    (one / other - 1.0).abs() < 8.0 * f64::EPSILON
}

#[test]
fn percents_of_a_spread_are_of_the_value() {
    let spread = |line: &str, set: &[(&str, &str)]| {
        let job = load(&pad(line), set).unwrap_or_else(|error| panic!("{error}"));
        let (name, spread) = job.uncertain[0];
        let value = job.machine.quantities().into_iter().find(|(known, _)| *known == name).unwrap().1;
        (value, spread)
    };
    let normal = |line: &str, set: &[(&str, &str)], value: f64, wanted: f64| {
        let (found, spread) = spread(line, set);
        let Spread::Normal { sd } = spread else { panic!("{line}") };
        assert!(near(found, value) && near(sd, wanted), "{line}: {found} {sd}");
    };
    normal("normal_force = \"1.2 kN +- 10 %\"", &[], 1200.0, 120.0);
    normal("normal_force = { value = \"1.2 kN\", sd = \"10 %\" }", &[], 1200.0, 120.0);
    normal("normal_force = \"1.2 ± 0.1 kN\"", &[], 1200.0, 100.0);
    normal("mass = \"2 +- 5 %\"", &[], 2.0, 0.1);
    normal("static_friction = \"40 % +- 5 %\"", &[], 0.4, 0.02);
    // Kept around a new value.
    normal("normal_force = \"1.2 kN +- 10 %\"", &[("normal_force", "2 kN")], 2000.0, 200.0);
    normal("normal_force = \"1.2 kN +- 10 %\"", &[("normal_force", "2 kN +- 1 %")], 2000.0, 20.0);
    for (line, value, [low, high]) in [
        ("mass = { value = 2.0, min = \"90 %\", max = \"120 %\" }", 2.0, [1.8, 2.4]),
        ("mass = { value = 2.0, min = \"-10 %\", max = \"+20 %\" }", 2.0, [1.8, 2.4]),
        ("mass = { value = 2.0, min = 1.8, max = 2.4 }", 2.0, [1.8, 2.4]),
        ("mass = { min = 1.8, max = 2.4 }", 2.1, [1.8, 2.4]),
    ] {
        let (found, spread) = spread(line, &[]);
        let Spread::Uniform { min, max } = spread else { panic!("{line}") };
        assert!(near(found, value) && near(min, low) && near(max, high), "{line}: {found} {min} {max}");
    }
    let (_, spread) = spread("belt_speed = { from = 0.1, to = 0.4, points = 4, sd = \"10 %\" }", &[]);
    assert_eq!(spread, Spread::Relative { sd: 0.1 });
    assert!(near(spread.sd(0.4), 0.04));
    for (line, words) in [
        ("mass = \"2 kg +- -1 %\"", "at least 0"),
        ("mass = { value = 2.0, min = \"101 %\", max = \"120 %\" }", "from min to max"),
    ] {
        let error = load(&pad(line), &[]).unwrap_err();
        assert!(error.problem.contains(words), "{line}: {error}");
    }
}

/// 3.5 kN m at rest and 2.5 kN m in slip are 0.7 and 0.5 of 5 kN m.
#[test]
fn torques_need_no_normal_force() {
    let rotation = "motion = \"rotation\"\nmass = 500.0\nstiffness = 800.0\nstribeck_velocity = 1.0\nbelt_speed = \"60 rpm\"\n";
    let torques =
        pad(&format!("{rotation}static_friction = \"3.5 kN m +- 10 %\"\nkinetic_friction = \"2.5 kN m\""));
    let torques = torques.replace("normal_force = 1000.0\n", "");
    let job = load(&torques, &[]).unwrap_or_else(|error| panic!("{error}"));
    let with_force =
        pad(&format!("{rotation}normal_force = 5e3\nstatic_friction = 0.7\nkinetic_friction = 0.5"));
    let same = load(&with_force, &[]).unwrap().machine;
    let [one, other] = [&job.machine, &same].map(|machine| machine.model().unwrap());
    assert!(near(one.si.force, other.si.force) && near(one.point.damping, other.point.damping));
    assert_eq!(one.law, other.law);
    assert_eq!(job.machine.unit("static_friction"), "N m");
    assert_eq!(job.uncertain[0].1.sd(3500.0), 350.0);
    // As it is written, and read again.
    let again = load(&job.to_toml().unwrap(), &[]).unwrap();
    assert_eq!(again.machine, job.machine);
    let both = torques.replace("[machine]", "[machine]\nnormal_force = 1.0");
    assert!(load(&both, &[]).unwrap_err().problem.contains("a force already"));
    let mixed = pad("static_friction = \"400 N\"").replace("normal_force = 1000.0\n", "");
    assert_eq!(load(&mixed, &[]).unwrap().machine.normal_force, 1.0, "0.25 N in slip");
}

#[test]
fn formulas_have_parameters_with_units_and_a_rest_at_the_peak() {
    let formula = |phi: &str, lines: &str| {
        let text =
            pad(lines).replace("law = \"exponential\"", &format!("law = \"expression\"\nphi = \"{phi}\""));
        let is_kept =
            |line: &&str| !["static_f", "kinetic_", "stribeck"].iter().any(|it| line.starts_with(it));
        text.lines().filter(is_kept).collect::<Vec<_>>().join("\n")
    };
    let job = load(&formula("0.3 + 0.1*exp(-u/vs)", "vs = \"50 mm/s +- 10 %\""), &[]).unwrap();
    assert!(job.machine.quantities().contains(&("vs", 0.05)) && near(job.uncertain[0].1.sd(0.05), 0.005));
    let error = load(&formula("0.3 + 0.1*exp(-u/0.05)", "eps = 0.1"), &[]).unwrap_err();
    assert!(error.remedy.contains("`eps` is reserved"), "{error}");
    let error = load(&formula("0.3 + eps*exp(-u/0.05)", ""), &[]).unwrap_err();
    assert!(error.problem.contains("eps is reserved"), "{error}");
    // Beyond the peak the law is what it was.
    let peak = formula("tanh(1e4*u)*(0.3 + 0.1*exp(-u/0.05))", "")
        .replace("[machine]", "rest = \"peak\"\n[machine]");
    let plain = load(&formula("0.3 + 0.1*exp(-u/0.05)", ""), &[]).unwrap().machine;
    let at_peak = load(&peak, &[]).unwrap_or_else(|error| panic!("{error}")).machine;
    let steady = |machine: &slipmap_machine::Machine| {
        let model = machine.model().unwrap();
        model.column().curve.phi(model.point.belt_speed) * model.si.force
    };
    assert!((steady(&plain) / steady(&at_peak) - 1.0).abs() < 1e-9);
    assert!((at_peak.friction.at_rest() / plain.friction.at_rest() - 1.0).abs() < 0.01);
}

/// A disc of 0.14 m at 60 rpm moves a pad at 2 pi 0.14 m/s.
#[test]
fn discs_have_rotary_speeds() {
    let job = load(&pad("radius = 0.14\nbelt_speed = \"60 rpm +- 10 %\""), &[]).unwrap();
    let speed = std::f64::consts::TAU * 0.14;
    assert!(near(job.machine.belt_speed, speed) && near(job.uncertain[0].1.sd(speed), 0.1 * speed));
    assert!(job.machine.quantities().iter().all(|(name, _)| *name != "radius"));
    let again = load(&job.to_toml().unwrap(), &[("belt_speed", "30 rpm")]).unwrap();
    assert!(near(again.machine.belt_speed, 0.5 * speed) && again.machine.given.disc() == Some(0.14));
    let error = load(&pad("belt_speed = \"60 rpm\""), &[]).unwrap_err();
    assert!(error.remedy.contains("with radius"), "{error}");
    let error = load(&pad("radius = [0.1, 0.2]\nbelt_speed = \"60 rpm\""), &[]).unwrap_err();
    assert!(error.problem.contains("one number"), "{error}");
    // What rotates, at its arm.
    let turned = load(&pad("motion = \"rotation\"\nradius = 0.1\nbelt_speed = \"0.5 m/s\""), &[]).unwrap();
    assert!(near(turned.machine.belt_speed, 5.0) && near(turned.machine.normal_force, 100.0));
}
