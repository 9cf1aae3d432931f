//! One answer at every door: facts of a point by `probe`, a table of points, a map of one cell, a machine, its page and the
//! explorer.

use serde_json::{Value, json};
use slipmap::column::{Regime, Verdict};
use slipmap::store::{MapFile, Pick};

use crate::command::Scratch;
use crate::explore::Server;

/// A friction law at eps = 1, in the words of each door. As a machine it has the mass, the stiffness, the normal force and the
/// friction at rest 1, so that units of SI are those of the point.
struct Case {
    /// Name of the law, and its formula or the file of its table.
    law: &'static str,
    text: &'static str,
    /// Parameters of its own.
    own: &'static [(&'static str, f64)],
    /// The quantities of a machine that they are.
    quantities: &'static [(&'static str, f64)],
    /// V and c.
    points: &'static [[f64; 2]],
}

/// Where regimes differ, laws of every kind.
const CASES: [Case; 6] = [
    Case {
        law: "exponential",
        text: "",
        own: &[("mu", 0.6), ("vs", 0.05), ("eta", 0.0)],
        quantities: &[("kinetic_friction", 0.6), ("stribeck_velocity", 0.05), ("strengthening", 0.0)],
        points: &[[0.5, 0.1], [0.5, 0.187], [0.5, 0.9], [0.02, 0.5], [3.0, 0.001]],
    },
    Case {
        law: "exponential",
        text: "",
        own: &[("mu", 0.7), ("vs", 0.3), ("eta", 0.2)],
        quantities: &[("kinetic_friction", 0.7), ("stribeck_velocity", 0.3), ("strengthening", 0.2)],
        points: &[[0.4, 0.05], [0.4, 0.3], [1.0, 0.0]],
    },
    Case {
        law: "coulomb",
        text: "",
        own: &[("drop", 0.4), ("eta", 0.0)],
        quantities: &[("kinetic_friction", 0.6), ("strengthening", 0.0)],
        points: &[[0.5, 0.1], [0.5, 0.4], [0.1, 2.0]],
    },
    Case {
        law: "lorentzian",
        text: "",
        own: &[("mu", 0.5), ("vs", 0.2), ("eta", 0.01)],
        quantities: &[("kinetic_friction", 0.5), ("stribeck_velocity", 0.2), ("strengthening", 0.01)],
        points: &[[0.3, 0.5], [0.3, 1.2], [0.6, 0.3]],
    },
    Case {
        law: "expression",
        text: "0.7 + 0.3*exp(-u/0.2) - 0.02*tanh((u-0.9)/0.05) - 0.02*tanh(18)",
        own: &[],
        quantities: &[],
        points: &[[0.5, 0.1], [0.5, 0.4], [0.8, 0.02]],
    },
    Case {
        law: "table",
        text: "falls.csv",
        own: &[],
        quantities: &[],
        points: &[[0.3, 0.1], [0.3, 0.6], [0.6, 0.05]],
    },
];

/// What a door says: the verdict of the simulation, c*, its error and the regime; `None` where it does not tell that fact.
#[derive(Debug)]
struct Facts {
    verdict: Option<String>,
    critical: Option<Option<f64>>,
    error: Option<Option<f64>>,
    regime: String,
}

fn words(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn of_probe(answer: &Value) -> Facts {
    let simulation = &answer["methods"]["simulation"];
    Facts {
        verdict: Some(words(&simulation["verdict"])),
        critical: Some(answer["critical_c"]["value"].as_f64()),
        error: Some(answer["critical_c"]["error"].as_f64()),
        regime: words(&answer["regime"]),
    }
}

impl Case {
    /// The rows of the table.
    fn data() -> String {
        let friction = |u: f64| 0.55 + 0.45 * (-u / 0.25_f64).exp() + 0.02 * u;
        (0..60).map(|i| 0.1 * f64::from(i)).map(|u| format!("{u},{}\n", friction(u))).collect()
    }

    /// The options of `probe` that name the law.
    fn options(&self) -> Vec<&str> {
        match self.law {
            "expression" => vec!["--phi", self.text],
            "table" => vec!["--table", self.text],
            law => vec!["--law", law],
        }
    }

    fn friction(&self) -> String {
        match self.law {
            "expression" => format!("[friction]\nlaw = \"expression\"\nphi = \"{}\"\n", self.text),
            "table" => format!("[friction]\nlaw = \"table\"\nkind = \"rows\"\nfile = \"{}\"\n", self.text),
            law => format!("[friction]\nlaw = \"{law}\"\n"),
        }
    }

    /// What each door says of a point.
    fn facts(
        &self,
        scratch: &Scratch,
        server: &Server,
        [speed, damping]: [f64; 2],
    ) -> Vec<(&'static str, Facts)> {
        let shared = [("epsilon", 1.0)].into_iter().chain(self.own.iter().copied());
        let point: Vec<(&str, f64)> = shared.chain([("V", speed), ("c", damping)]).collect();
        let mut found = Vec::new();

        let given: Vec<String> =
            point.iter().flat_map(|(name, value)| [format!("--{name}"), value.to_string()]).collect();
        let mut line = vec!["probe"];
        line.extend(self.options());
        line.extend(given.iter().map(String::as_str));
        found.push(("probe", of_probe(&scratch.json(&line))));

        let names: Vec<&str> = point.iter().map(|(name, _)| *name).collect();
        let values: Vec<String> = point.iter().map(|(_, value)| value.to_string()).collect();
        scratch.file("in.csv", format!("{}\n{}\n", names.join(","), values.join(",")));
        let mut line = vec!["probe"];
        line.extend(self.options());
        line.extend(["--points", "in.csv", "--out", "out.csv", "--overwrite", "--quiet"]);
        scratch.run(&line).ends_with(0);
        let text = scratch.read("out.csv");
        let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
        let cell = |name: &str| rows[1][rows[0].iter().position(|of| *of == name).unwrap()];
        found.push((
            "points",
            Facts {
                verdict: Some(cell("verdict_simulation").into()),
                critical: Some(cell("critical_c").parse().ok()),
                error: Some(cell("critical_c_error").parse().ok()),
                regime: cell("regime").into(),
            },
        ));

        let axes: String = point.iter().map(|(name, value)| format!("{name} = {value:?}\n")).collect();
        let output = "[output]\npath = \"one.h5\"\nfields = [\"verdict\", \"critical_c\", \"regime\"]\n";
        scratch.file("one.toml", format!("[grid]\n{axes}{}{output}", self.friction()));
        scratch.run("run one.toml --overwrite --quiet").ends_with(0);
        let map = MapFile::open(&scratch.path().join("one.h5")).unwrap();
        let pick = vec![Pick::Node(0); map.grid().axes().len()];
        let code = |name: &str| map.code_slice(name, &pick).unwrap().iter().next().copied().unwrap();
        let columns = vec![Pick::Node(0); map.grid().axes().len() - 1];
        let number = |name: &str| map.real_slice(name, &columns).unwrap().iter().next().copied().unwrap();
        let known = |x: f64| (!x.is_nan()).then_some(x);
        let verdict = Verdict::ALL.into_iter().find(|of| of.code() == code("verdict_simulation")).unwrap();
        let regime = Regime::ALL.into_iter().find(|of| of.code() == code("regime")).unwrap();
        found.push((
            "map",
            Facts {
                verdict: Some(verdict.name().into()),
                critical: Some(known(number(&map.critical("simulation")))),
                error: Some(known(number(&map.critical_error()))),
                regime: regime.name().into(),
            },
        ));

        let quantities: String =
            self.quantities.iter().map(|(name, value)| format!("{name} = {value:?}\n")).collect();
        let rest = if self.own.is_empty() { "" } else { "static_friction = 1.0\n" };
        scratch.file(
            "machine.toml",
            format!(
                "[machine]\nmass = 1.0\nstiffness = 1.0\nnormal_force = 1.0\nbelt_speed = {speed:?}\ndamping = {damping:?}\n\
                 {rest}{quantities}{}",
                self.friction()
            ),
        );
        found.push(("machine", of_probe(&scratch.json("probe --machine machine.toml"))));
        let page = scratch.json("machine machine.toml");
        found.push((
            "page",
            Facts { verdict: None, critical: None, error: None, regime: words(&page["regime"]) },
        ));

        let law = match self.law {
            "expression" => json!({ "name": "expression", "phi": self.text }),
            "table" => json!({ "name": "table", "table": Self::data(), "file": "falls.csv" }),
            law => json!({ "name": law }),
        };
        let at: serde_json::Map<String, Value> =
            point.iter().map(|(name, value)| ((*name).into(), json!(value))).collect();
        found.push(("explorer", of_probe(&server.answer("point", &json!({ "law": law, "at": at })))));
        found
    }
}

#[test]
fn one_point_has_one_answer_at_every_door() {
    let scratch = Scratch::new();
    scratch.file("falls.csv", Case::data());
    let server = Server::start(&scratch, &[]);
    let mut regimes = std::collections::BTreeSet::new();
    for case in &CASES {
        for point in case.points {
            let facts = case.facts(&scratch, &server, *point);
            let (_, first) = &facts[0];
            regimes.insert(first.regime.clone());
            for (door, said) in &facts {
                let label = format!("{} {} {point:?} {door}: {facts:#?}", case.law, case.text);
                assert_eq!(said.regime, first.regime, "{label}");
                assert!(said.verdict.is_none() || said.verdict == first.verdict, "{label}");
                // A map has critical dampings from 0 on.
                let told = |of: Option<f64>| of.filter(|c| *door != "map" || *c >= 0.0);
                let (critical, error) = (told(first.critical.flatten()), first.error.flatten());
                assert!(said.critical.is_none_or(|of| of == critical), "{label}");
                // A table of points has six digits of an error.
                let same = |one: Option<f64>, other: Option<f64>| match (one, other) {
                    (Some(one), Some(other)) => (one - other).abs() <= 1e-5 * other,
                    (one, other) => one == other,
                };
                let error = error.filter(|_| critical.is_some());
                assert!(said.error.is_none_or(|of| same(of, error)), "{label}");
            }
        }
    }
    assert!(regimes.len() >= 3, "{regimes:?}");
}
