//! Steady slip that neither attracts nor repels: `probe`, the machine's page and maps say so, and agree.

use crate::command::{Says, Scratch};

const START: &str =
    "[machine]\nmass = 2.0\nstiffness = 2e5\nnormal_force = 100.0\nbelt_speed = 0.1\ndamping = 0.0\n";

/// Machines without damping: flat friction as a table, as a formula and by coefficients, and friction that
/// falls so near rest that nothing of it is left at the belt speed.
fn machines(scratch: &Scratch) -> Vec<String> {
    scratch.file("flat.csv", "0,0.3\n0.1,0.3\n0.2,0.3\n0.5,0.3\n1,0.3\n");
    let coefficients = |law: &str, kinetic: f64, velocity: f64| {
        let of =
            format!("static_friction = 0.3\nkinetic_friction = {kinetic}\nstribeck_velocity = {velocity}\n");
        format!("{START}{of}[friction]\nlaw = \"{law}\"\n")
    };
    vec![
        format!("{START}[friction]\nlaw = \"table\"\nfile = \"flat.csv\"\n"),
        format!("{START}[friction]\nlaw = \"expression\"\nphi = \"0.3\"\n"),
        coefficients("stribeck", 0.3, 0.05),
        coefficients("exponential", 0.2, 5e-4),
        coefficients("lorentzian", 0.2, 0.05),
    ]
}

#[test]
fn probe_and_machine_agree_without_damping() {
    let scratch = Scratch::new();
    let mut neutral = 0;
    for text in machines(&scratch) {
        scratch.file("m.toml", &text);
        let page = scratch.json("machine m.toml");
        let probe = scratch.json("probe --machine m.toml");
        let label = format!("{text}\n{page}\n{}", probe["equilibrium"]);
        assert_eq!(page["regime"], probe["regime"], "{label}");
        assert_eq!(page["regime"], probe["machine"]["regime"], "{label}");
        let number = |key: &str| page[key].as_f64();
        let kind = probe["equilibrium"]["type"].as_str().unwrap();
        let hopf = number("steady_slip_unstable_below_damping").unwrap();
        assert_eq!(kind.starts_with("centre"), page["regime"] == "neutral", "{label}");
        assert_eq!(kind.starts_with("centre"), hopf == 0.0, "{label}");
        assert_eq!(kind.starts_with("unstable"), hopf > 0.0, "{label}");
        // Units of rounding of the damping's own scale, sqrt(mass stiffness).
        let rounding = f64::EPSILON * (2.0_f64 * 2e5).sqrt();
        for key in
            ["always_stick_slips_below_damping", "may_stick_slip_below_damping", "vibrates_below_damping"]
        {
            assert!(number(key).is_none_or(|limit| limit == 0.0 || limit > rounding), "{key}: {label}");
        }
        let sticks = probe["flow"]["arcs"]["fate"] == "sticks";
        assert_eq!(sticks, number("may_stick_slip_below_damping").is_some(), "{label}");
        assert_eq!(
            number("always_stick_slips_below_damping").is_some(),
            page["regime"] == "stick_slip",
            "{label}"
        );
        if page["regime"] == "neutral" {
            neutral += 1;
            // In words a table and a formula.
            if neutral > 2 {
                continue;
            }
            let words = scratch.run("probe --machine m.toml").ends_with(0).out;
            words.says(&["the equilibrium is neutral", "centre of the linearisation"]);
            assert!(!words.contains("unstable"), "{words}");
            let told = words.matches("the stick-slip cycle attracts").count();
            assert_eq!(told, if sticks { 2 } else { 0 }, "{words}");
            assert!(words.contains("c* = 0 within rounding") || sticks, "{words}");
        }
    }
    assert_eq!(neutral, 4);
}

#[test]
fn the_page_of_flat_friction_says_what_is_known() {
    let scratch = Scratch::new();
    scratch.file("m.toml", &machines(&scratch)[1]);
    let text = scratch.run("machine m.toml --out m.html").ends_with(0).out;
    text.says(&[
        "Small swings about steady slip neither grow nor decay at 0.1 m/s and 0 N s/m.",
        "steady slip neither attracts nor repels within rounding errors",
        "none: any damping makes it attract",
        "not at all: there is none",
    ]);
    assert!(!text.contains("unstable\n") && !text.contains("unknown amount"), "{text}");
}
