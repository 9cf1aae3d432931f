//! Machines on the page: where it begins, its planes, and what leaves it.

use serde_json::{Value, json};

use super::{Server, assert_map_is_the_picture};
use crate::command::Scratch;

/// A machine whose friction is a force, whatever the normal force.
#[test]
fn a_machine_of_forces_is_where_the_page_begins() {
    let scratch = Scratch::new();
    let machine = "[machine]\nmass = 2.0\nstiffness = 2e5\ndamping = 700.0\nbelt_speed = 0.1\n";
    let formula = "law = \"expression\"\nphi = \"250 + 200*exp(-u/0.05)\"\nquantity = \"force\"";
    scratch.file("force.csv", "slip_speed [m/s],force [N]\n0,450\n0.02,390\n0.05,350\n0.1,320\n0.3,300\n");
    for (name, friction) in [("formula", formula), ("table", "law = \"table\"\nfile = \"force.csv\"")] {
        let file = format!("{name}.toml");
        scratch.file(&file, format!("[friction]\n{friction}\n{machine}"));
        let server = Server::start(&scratch, &[&file]);
        let start = server.begin()["start"].clone();
        let asked = json!({ "law": start["law"], "at": start["at"], "motion": start["motion"] });
        let point = server.answer("point", &asked);
        let told = scratch.json(&format!("probe --machine {file}"));
        let [found, expected] =
            [&point["machine"]["critical_damping"], &told["machine"]["critical_damping"]].map(Value::as_f64);
        assert!((found.unwrap() / expected.unwrap() - 1.0).abs() < 1e-9, "{name}: {point} {told}");
        assert_eq!(point["regime"], told["regime"], "{name}");
    }
}

/// Laws with a friction at rest of their own, tables with errors and with scattered rows, in units, and fits: the page
/// that begins with their file answers as the program does, and what it exports is that machine.
#[test]
fn a_machine_leaves_the_page_as_it_came() {
    let scratch = Scratch::new();
    let machine =
        "[machine]\nmass = \"2 t\"\nstiffness = 5.05e8\ndamping = 60000.0\nbelt_speed = \"150 mm/s\"\n";
    let scattered: String = (1..120)
        .map(|i| {
            format!(
                "{};{:.4}\n",
                10 * i,
                0.25 + 0.15 * (-f64::from(i) / 5.0).exp() + 0.004 * f64::from(i * 7919 % 11 - 5)
            )
        })
        .collect();
    scratch.file("rig.csv", format!("v [mm/s];mu\n0;0.4\n{}", scattered).replace('.', ","));
    scratch.file(
        "errors.csv",
        "u,mu,se\n0,0.4,0.01\n0.02,0.35,0.01\n0.05,0.31,0.01\n0.1,0.27,0.01\n0.5,0.25,0.01\n",
    );
    scratch.file("force.csv", "v [m/s];F [kN]\n0,02;385,5\n0,05;310,1\n0,1;270\n0,5;250\n1;250\n");
    let fit = "[friction.fit]\nmuk = 0.25\nmus = 0.4\nvs = 0.05\ncovariance = [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-6]]\n";
    let formula = "law = \"expression\"\nphi = \"muk + (mus - muk)*exp(-u/vs)\"";
    for (name, friction, of_machine) in [
        (
            "static.toml",
            "law = \"expression\"\nphi = \"0.25 + 0.1*exp(-u/0.05)\"\nstatic = 0.4".to_owned(),
            "normal_force = 1e6",
        ),
        ("table.toml", "law = \"table\"\nfile = \"errors.csv\"\nstatic = 0.45".into(), "normal_force = 1e6"),
        (
            "rig.toml",
            "law = \"table\"\nfile = \"rig.csv\"".into(),
            "normal_force = { value = 1e6, sd = 1e5 }",
        ),
        ("force.toml", "law = \"table\"\nfile = \"force.csv\"".into(), ""),
        ("fitted.toml", format!("{formula}\nstatic = 0.5\n{fit}"), "normal_force = 1e6"),
    ] {
        scratch
            .file(name, format!("title = \"Pad {name}\"\n[friction]\n{friction}\n{machine}{of_machine}\n"));
        let probe = |file: &str| -> Value {
            let found = scratch.run(&[
                "probe",
                "--machine",
                file,
                "--set",
                "damping=60000",
                "--set",
                "belt_speed=0.15",
                "--json",
            ]);
            serde_json::from_str(&found.ends_with(0).out).unwrap()
        };
        let expected = probe(name);
        let server = Server::start(&scratch, &[name]);
        let start = server.begin()["start"].clone();
        let mut asked = json!({
            "law": start["law"], "motion": start["motion"], "units": start["units"], "spread": start["spread"],
            "title": start["title"], "at": {}, "show": "regime",
            "x": { "axis": "belt_speed", "from": 0.1, "to": 0.2, "points": 3 },
            "y": { "axis": "damping", "from": 1e4, "to": 1e5, "points": 4 },
        });
        // As the page does, in SI units.
        for (quantity, value) in start["at"].as_object().unwrap() {
            let size = start["units"][quantity][1].as_f64();
            asked["at"][quantity] =
                size.map_or(value.clone(), |size| (value.as_f64().unwrap() * size).into());
        }
        asked["at"]["belt_speed"] = 0.15.into();
        server.answer("law", &{
            let mut law = start["law"].clone();
            law["motion"] = start["motion"].clone();
            law
        });
        let mut found = server.answer("point", &asked);
        found["machine"].as_object_mut().unwrap().remove("sensitivities");
        assert_eq!(found, expected, "{name}");
        let texts = server.answer("texts", &asked);
        let toml = texts["toml"].as_str().unwrap();
        assert!(
            toml.contains(&format!("title = \"Pad {name}\"")) && toml.contains("mass = \"2.0 t\""),
            "{toml}"
        );
        scratch.file("plane.toml", toml);
        assert_eq!(probe("plane.toml"), expected, "{toml}");
    }
}

/// The request of the page about the brake pad, with its quantities as axes.
fn machine(x: &str, y: &str) -> Value {
    let at = json!({
        "mass": 2.0, "stiffness": 5.05e5, "damping": 180.0, "normal_force": 1000.0, "static_friction": 0.4,
        "kinetic_friction": 0.25, "stribeck_velocity": 0.05, "strengthening": 0.0, "belt_speed": 0.2,
        "muk": 0.25, "mus": 0.4, "vs": 0.05,
    });
    let to = |name: &str| 2.0 * at[name].as_f64().unwrap();
    let side = |name: &str| json!({ "axis": name, "from": 0.0, "to": to(name), "points": 2 });
    json!({
        "law": { "name": "exponential" }, "motion": "translation", "at": at,
        "x": side(x), "y": side(y), "show": "critical_c_simulation",
    })
}

/// A formula and a table of the friction of that pad.
fn laws() -> [Value; 3] {
    let table: String = (0..16)
        .map(|i| 0.0025 * f64::from(i * i))
        .map(|u| format!("{u},{}\n", 0.25 + 0.15 * (-u / 0.05f64).exp()))
        .collect();
    [
        json!({ "name": "exponential" }),
        json!({ "name": "expression", "phi": "muk + (mus - muk)*exp(-u/vs)" }),
        json!({ "name": "table", "table": table, "file": "mu.csv" }),
    ]
}

/// A request about half of a plane of two quantities, with room for the curve of the critical damping.
fn half_plane(law: &Value, x: &str, y: &str) -> Value {
    let mut asked = machine(x, y);
    asked["law"] = law.clone();
    for side in ["x", "y"] {
        if asked[side]["axis"] != "damping" {
            asked[side]["to"] = (0.5 * asked[side]["to"].as_f64().unwrap()).into();
        }
    }
    asked
}

/// The critical damping of the machine of this request.
fn critical_damping(server: &Server, asked: &Value) -> f64 {
    server.answer("point", asked)["machine"]["critical_damping"].as_f64().unwrap()
}

/// A plane of two quantities has at each cell the answer for that machine.
#[test]
fn any_quantity_of_a_machine_is_an_axis() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let [exponential, formula, table] = laws();
    for (law, x, y) in [
        (&exponential, "mass", "damping"),
        (&exponential, "normal_force", "stiffness"),
        (&exponential, "belt_speed", "kinetic_friction"),
        (&formula, "vs", "damping"),
        (&table, "belt_speed", "mass"),
    ] {
        let asked = half_plane(law, x, y);
        let (head, cells) = server.picture(&asked);
        assert_eq!((head["width"].as_u64(), head["height"].as_u64()), (Some(2), Some(2)), "{x} {y}");
        assert!(head["label"].as_str().unwrap().ends_with(", N s/m"), "{head}");
        // One cell of two by two: the second across, the first up.
        let found = f32::from_le_bytes(cells[4..8].try_into().unwrap());
        let mut alone = asked.clone();
        for (side, share) in [("x", 0.75), ("y", 0.25)] {
            let name = asked[side]["axis"].as_str().unwrap();
            alone["at"][name] = (share * asked[side]["to"].as_f64().unwrap()).into();
        }
        let expected = critical_damping(&server, &alone);
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-6, "{x} {y}: {found} {expected}");
    }
}

#[test]
fn a_point_of_a_machine_has_its_sensitivities() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let point = server.answer("point", &machine("mass", "damping"));
    let quantities = point["machine"]["sensitivities"].as_array().unwrap();
    for name in ["mass", "stiffness", "normal_force", "stribeck_velocity"] {
        assert!(quantities.iter().any(|of| of["quantity"] == name), "{name}: {quantities:?}");
    }
}

/// On the grazing curve of a plane the damping is the critical one of that machine.
#[test]
fn curves_of_a_plane_are_critical_dampings() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let [exponential, ..] = laws();
    // Of each kind of plane one, since curves take their time.
    for (x, y) in [("mass", "damping"), ("belt_speed", "kinetic_friction")] {
        let asked = half_plane(&exponential, x, y);
        let curves = server.answer("curves", &asked);
        let curves = curves["curves"].as_array().unwrap();
        assert!(!curves.is_empty(), "{x} {y}");
        let Some(grazing) = curves.iter().find(|curve| curve["name"] == "grazing_sliding") else {
            assert_ne!(y, "damping", "{x}");
            continue;
        };
        let [points, errors] = ["points", "errors"].map(|of| grazing[of].as_array().unwrap());
        let middle = &points[points.len() / 2];
        let mut there = asked.clone();
        (there["at"][x], there["at"][y]) = (middle[0].clone(), middle[1].clone());
        let (found, damping) = (critical_damping(&server, &there), there["at"]["damping"].as_f64().unwrap());
        assert!((found / damping - 1.0).abs() < 1e-5, "{x} {y}: {found} {damping}");
        if x == "mass" {
            // The critical damping bends near 0; its curve has more points there.
            assert!(points.len() > 36 && errors.len() == points.len(), "{grazing:?}");
            // The errors of the critical dampings, as shares of the picture: far below the width of a line.
            let most = errors.iter().filter_map(Value::as_f64).fold(0.0, f64::max);
            assert!(most > 0.0 && most < 1e-4, "{most}");
        }
    }
}

#[test]
fn the_exported_map_of_a_machine_is_the_picture() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let [_, formula, table] = laws();
    for (law, x, most) in [(table, "belt_speed", 0.25), (formula, "mass", 4.0)] {
        let mut asked = machine(x, "damping");
        (asked["law"], asked["show"]) = (law, "regime".into());
        asked["x"]["to"] = most.into();
        assert_map_is_the_picture(&server, &scratch, &asked);
    }
}

#[test]
fn a_formula_that_names_a_quantity_is_refused_at_its_place() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let law = json!({ "name": "expression", "phi": "mass*exp(-u)", "motion": "rotation" });
    let (status, answer) = server.ask("law", &law);
    assert!(status == 422 && answer["place"] == json!([0, 4]), "{answer}");
}

const FORMULA: &str = "[friction]\nlaw = \"expression\"\nphi = \"0.2 + a*exp(-u/0.1)\"\n[machine]\nmass = 1.0\n\
                       stiffness = 100.0\nnormal_force = 10.0\na = 0.2\n";

#[test]
fn the_page_begins_with_the_ranges_of_a_machine() {
    let scratch = Scratch::new();
    let ranges = "damping = { from = 0.0, to = 2.0, points = 3 }\nbelt_speed = [0.1, 0.3]\n";
    scratch.file("mu.toml", format!("{FORMULA}{ranges}"));
    let server = Server::start(&scratch, &["mu.toml"]);
    let start = server.begin()["start"].clone();
    assert_eq!((&start["motion"], &start["pinned"]), (&json!("translation"), &json!(false)));
    assert_eq!(start["law"]["phi"], "0.2 + a*exp(-u/0.1)");
    assert_eq!((&start["at"]["a"], &start["at"]["stiffness"]), (&json!(0.2), &json!(100.0)));
    let axes = start["axes"].as_array().unwrap();
    for (name, to) in [("belt_speed", 0.3), ("damping", 2.0)] {
        assert!(axes.iter().any(|axis| axis["name"] == name && axis["to"] == to), "{axes:?}");
    }
    // Its dimensionless law.
    let plain = server
        .answer("dimensionless", &json!({ "law": start["law"], "motion": "translation", "at": start["at"] }));
    assert!((plain["at"]["V"].as_f64().unwrap() - 0.1 / 0.4).abs() < 1e-12, "{plain}");
}

/// One belt speed and one damping are a working point; the plane reaches beyond the critical damping.
#[test]
fn the_page_begins_with_a_working_point() {
    let scratch = Scratch::new();
    scratch.file("one.toml", format!("{FORMULA}damping = 0.1\nbelt_speed = 0.05\n"));
    let server = Server::start(&scratch, &["one.toml"]);
    let start = server.begin()["start"].clone();
    let probed = scratch.json("probe --machine one.toml");
    let critical = probed["machine"]["critical_damping"].as_f64().unwrap();
    let most = start["most_damping"].as_f64().unwrap();
    assert_eq!(start["pinned"], true);
    assert!(critical > 0.1 && (most / (1.2 * critical) - 1.0).abs() < 1e-4, "{most} {critical}");
    assert!(String::from_utf8(server.get(&server.path, "").2).unwrap().contains("id=\"answer\""));
}
