//! Certificates as files: their paths, the files that they replace, and the messages.

use std::fs;

use crate::command::{Run, Says, Scratch};
use serde_json::Value;

const JOB: &str = "\
[grid]
epsilon = 0.05
alpha = [0.1, 0.15]
beta = 0.1
gamma = 1.0
V = [0.5, 0.55]
c = [0.0, 0.5, 1.0]
[methods]
run = [\"validated\"]
[validated]
boxes = 1
proof = \"proof.json\"
[output]
path = \"map.h5\"
fields = [\"verdict\"]
";

/// The text of a certificate as another program may write it: keys in another order, spaces, integers with
/// decimal points.
pub(crate) fn written_again(text: &str) -> String {
    fn other(value: Value) -> Value {
        match value {
            Value::Object(map) => map
                .into_iter()
                .rev()
                .map(|(key, value)| (key, other(value)))
                .collect::<serde_json::Map<_, _>>()
                .into(),
            Value::Array(values) => values.into_iter().map(other).collect(),
            Value::Number(number) => number.as_f64().unwrap().into(),
            simple => simple,
        }
    }
    serde_json::to_string_pretty(&other(serde_json::from_str(text).unwrap())).unwrap()
}

fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("job.toml", JOB);
    scratch.file("other.toml", JOB.replace("map.h5", "other.h5").replace("[0.5, 0.55]", "[0.5, 0.56]"));
    scratch
}

fn run(scratch: &Scratch, arguments: &[&str]) -> Run {
    scratch.run(&[&["run"], arguments].concat())
}

#[test]
fn proofs_in_the_way_of_files_are_refused_at_once() {
    let scratch = scratch();
    fs::create_dir(scratch.path().join("folder")).unwrap();
    scratch.file("notes.txt", "mine");
    for (place, problem) in [
        ("map.h5", "what output.path names is written there"),
        ("./map.h5", "what output.path names is written there"),
        ("folder/../map.h5", "what output.path names is written there"),
        ("job.toml", "this is what is read"),
        ("folder", "this is a folder"),
        ("notes.txt/proof.json", "cannot"),
        ("/proc/proof.json", "cannot write into the folder /proc"),
    ] {
        let set = format!("validated.proof={place:?}");
        for more in [&[][..], &["--overwrite"], &["--resume"], &["--dry-run"]] {
            run(&scratch, &[&["job.toml", "--set", &set], more].concat()).refuses(&[problem]);
        }
    }
    assert_eq!(scratch.names(), ["folder", "job.toml", "notes.txt", "other.toml"]);
    assert_eq!(scratch.read("notes.txt"), "mine");
}

#[test]
fn proofs_are_replaced_by_overwrite_and_by_resume() {
    let scratch = scratch();
    run(&scratch, &["job.toml"]).ends_with(0);
    let first = scratch.read("proof.json");
    run(&scratch, &["other.toml"]).refuses(&["proof.json exists already"]);
    assert_eq!(scratch.read("proof.json"), first);
    // The run was stopped between proof and map.
    fs::remove_file(scratch.path().join("map.h5")).unwrap();
    run(&scratch, &["job.toml", "--resume"]).ends_with(0);
    assert_eq!(scratch.read("proof.json"), first);
    // Overwriting is announced, by dry runs as well.
    let dry = run(&scratch, &["other.toml", "--overwrite", "--dry-run"]).ends_with(0);
    dry.out.says(&["replaces", "proof.json ("]);
    let loud = run(&scratch, &["other.toml", "--overwrite"]).ends_with(0);
    loud.err.says(&["note: proof.json (", "will be replaced"]);
    scratch.run("check --proof proof.json").ends_with(0);
    assert!(scratch.read("proof.json") != first);
}

#[test]
fn the_proof_of_a_point_is_kept_and_verified() {
    let scratch = Scratch::new();
    scratch.file("table.csv", "u,phi\n0,1\n0.5,0.8\n1,0.7\n2,0.65\n3,0.64\n6,0.66\n");
    let stribeck = ["--epsilon=0.1", "--alpha=0.3", "--beta=0.1", "--gamma=2", "--V=1", "--c=0.5"];
    let formula =
        ["--phi=mu + (1 - mu)*exp(-u/vs)", "--set=mu=0.5", "--set=vs=1", "--epsilon=1", "--V=0.6", "--c=0.1"];
    let table = ["--table=table.csv", "--epsilon=1", "--V=0.7", "--c=0.05"];
    for (name, point) in [("a.json", &stribeck[..]), ("b.json", &formula), ("c.json", &table)] {
        scratch.run(&[&["probe"], point, &["--proof", name]].concat()).ends_with(0);
        let check = scratch.run(&["check", "--proof", name]).ends_with(0);
        check.out.says(&["1 proof", "present; critical c from", "sound"]);
        // Nothing is replaced without --overwrite.
        scratch.run(&[&["probe"], point, &["--proof", name]].concat()).refuses(&["exists already"]);
        if name == "a.json" {
            scratch.run(&[&["probe"], point, &["--proof", name, "--overwrite"]].concat()).ends_with(0);
        }
        let text = scratch.read(name);
        scratch.file("again.json", written_again(&text));
        scratch.run("check --proof again.json").ends_with(0);
        let mut wrong: Value = serde_json::from_str(&text).unwrap();
        let absent = &mut wrong["parts"][0]["proof"]["curves"][0];
        let edge = absent["c"].as_f64().unwrap();
        absent["c"] = (0.999 * edge).into();
        scratch.file("wrong.json", wrong.to_string());
        let run = scratch.run("check --proof wrong.json").ends_with(1);
        run.out.says(&["curve 1 is no proof: orbits are not proved to cross piece"]);
        wrong["parts"][0]["proof"]["curves"][0]["c"] = edge.into();
        wrong["parts"][0]["absent"] = 1.0.into();
        scratch.file("wrong.json", wrong.to_string());
        let run = scratch.run("check --proof wrong.json").ends_with(1);
        run.out.says(&["the share absent is proved to be at least 0 only"]);
        scratch.file("wrong.json", text.replace("\"written_by\"", "\"written\""));
        scratch.run("check --proof wrong.json").refuses(&["is not a proof"]);
    }
}

const FORMULA: &str = "\
[friction]
law = \"expression\"
phi = \"mu + (1 - mu)*exp(-u)\"
[grid]
epsilon = 1.0
mu = [0.5, 0.6]
V = [1.0, 1.1]
c = [0.0, 0.2, 0.4]
";

/// Proofs over boxes, behind either of these.
const PROVED: &str = "[methods]\nrun = [\"validated\"]\n[validated]\nboxes = 8\nproof = \"proof.json\"\n\
                      [output]\npath = \"map.h5\"\n";

/// A machine of which belt speed and damping vary.
const MACHINE: &str = "\
[friction]
law = \"exponential\"
[machine]
mass = 2.0
stiffness = 505000.0
normal_force = 1000.0
static_friction = 0.4
kinetic_friction = 0.26
stribeck_velocity = 0.1
belt_speed = [0.2, 0.21]
damping = [0.0, 300.0, 600.0]
";

#[test]
fn boxes_of_every_law_are_proved_and_checked() {
    for (job, axes) in [
        (FORMULA, "epsilon 1, mu 0.5 to 0.6, V 1 to 1.1, c 0 to 0.4: present in "),
        (MACHINE, "epsilon 1, mu "),
    ] {
        let scratch = Scratch::new();
        scratch.file("job.toml", format!("{job}{PROVED}"));
        let printed = run(&scratch, &["job.toml", "--json"]).json();
        let share = |name: &str| printed["proved"][name].as_f64().unwrap();
        let (present, absent, undecided) = (share("present"), share("absent"), share("undecided_at_most"));
        assert!(present > 0.1 && absent > 0.1 && undecided < 0.2, "{printed}");
        assert!((present + absent + undecided - 1.0).abs() < 1e-9, "{printed}");
        let checked = scratch.run("check --proof proof.json");
        assert!(checked.code == 0 && checked.out.contains(axes), "{}{}", checked.out, checked.err);
        // A larger claim, in the text.
        let text = fs::read_to_string(scratch.path().join("proof.json")).unwrap();
        let mut proof: Value = serde_json::from_str(&text).unwrap();
        proof["parts"][0]["present"] = (present + 1e-3).into();
        scratch.file("forged.json", proof.to_string());
        let forged = scratch.run("check --proof forged.json");
        assert!(forged.code == 1 && forged.out.contains("the share present"), "{}{}", forged.out, forged.err);
        // Written by another run: not replaced.
        run(&scratch, &["job.toml", "--set", "output.path=\"other.h5\"", "--set", "validated.boxes=3"])
            .refuses(&["proof.json"]);
    }
}

/// Of measured data, and without boxes, every column of the map is proved.
#[test]
fn columns_of_a_map_are_proved_and_their_certificates_checked() {
    let scratch = Scratch::new();
    scratch.file("friction.csv", "0,0.4\n0.02,0.37\n0.05,0.34\n0.1,0.31\n0.2,0.285\n0.4,0.27\n0.8,0.262\n");
    let machine = "[friction]\nlaw = \"table\"\nfile = \"friction.csv\"\n[machine]\nmass = 2.0\nstiffness = 505000.0\n\
                   normal_force = 1000.0\nbelt_speed = [0.1, 0.2]\ndamping = [0.0, 300.0, 600.0]\n";
    for (job, sets) in [(machine.to_owned(), &[][..]), (FORMULA.to_owned(), &["--set", "validated.boxes=0"])]
    {
        scratch.file("job.toml", format!("{job}{PROVED}"));
        run(&scratch, &[&["job.toml", "--overwrite"], sets].concat()).ends_with(0);
        let checked = scratch.json("check --proof proof.json");
        let parts = checked["parts"].as_array().unwrap();
        assert!(parts.len() >= 2 && checked["sound"] == true, "{checked}");
        let decided =
            |part: &Value| part["undecided"].as_f64().unwrap() < 1e-5 && part["critical_c"][0].is_f64();
        assert!(parts.iter().all(decided), "{checked}");
        let mut forged: Value = serde_json::from_str(&scratch.read("proof.json")).unwrap();
        forged["parts"][1]["c"][1] = 1e9.into();
        scratch.file("forged.json", forged.to_string());
        let forged = scratch.run("check --proof forged.json").ends_with(1);
        forged.out.says(&["part 2: the share present is proved to be at least"]);
    }
}

/// Friction that is 1 at rest in double precision only, or formulas with bounds without end.
const CANCEL: [&str; 4] = [
    "0.5+0.5*exp(-u)-0.9*((1e16+1)-1e16)",
    "0.5+0.5*exp(-u)+(u+1e5)^3-u^3-1e5^3",
    "(1e16+1)-1e16+0.5+0.5*exp(-u)",
    "0.5+0.5*exp(-u)+sin(1e20+u)-sin(1e20+u)",
];

#[test]
fn formulas_that_cancel_are_no_friction_laws_anywhere() {
    let scratch = Scratch::new();
    let probe = |phi: &str| {
        scratch.run(&format!("probe --law expression --phi {phi} --epsilon 1 --V 1 --c 0.05 --proof c.json"))
    };
    for phi in CANCEL {
        probe(phi).refuses(&["--phi: phi(0) is 1 only up to rounding", "terms cancel"]);
        let job = format!(
            "[friction]\nlaw = \"expression\"\nphi = \"{phi}\"\n[grid]\nepsilon = 1\nV = 1\nc = [0.05, 0.1]\n\
             [output]\npath = \"map.h5\"\n"
        );
        scratch.file("job.toml", job);
        run(&scratch, &["job.toml"]).refuses(&["job.toml:3:", "phi(0) is 1 only up to rounding"]);
    }
    assert_eq!(scratch.names(), ["job.toml"]);
    // A forger writes them into a valid certificate.
    let honest = "0.5+0.5*exp(-u)";
    probe(honest).ends_with(0);
    scratch.run("check --proof c.json").ends_with(0);
    let valid = scratch.read("c.json");
    let lists = |text: String| format!("{{\"format\":\"slipmap proof 3\",\"statement\":\"\",{text}}}");
    let empty = "[],".repeat(3_000_000);
    for (forged, code) in CANCEL
        .map(|phi| (valid.replace(&format!("\\n{honest}"), &format!("\\n{phi}")), 1))
        .into_iter()
        .chain([
            (
                valid.replace(
                    "\"law_definition\":\"1",
                    &format!("\"law_definition\":\"{}1", "small eps\\n".repeat(30_000)),
                ),
                1,
            ),
            (valid.replace("\"c\":[", &format!("\"c\":[{}", "0,".repeat(3_000_000))), 2),
            (lists(format!("\"parts\":[{{\"domain\":[{empty}[]]}}]")), 2),
            (lists(format!("\"axes\":[{empty}[]]")), 2),
            (lists(format!("\"axes\":{}{}", "[".repeat(100_000), "]".repeat(100_000))), 2),
        ])
    {
        assert_ne!(forged, valid);
        scratch.file("c.json", &forged);
        let start: String = forged.chars().take(60).collect();
        let checked = crate::hostile::bounded(&scratch, &["check", "--proof", "c.json"]);
        assert_eq!(checked.code, code, "{start}: {checked:?}");
        assert!(checked.err.len() + checked.out.len() < 4000, "{start}");
    }
}
