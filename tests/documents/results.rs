//! The classes of answers for Python, which are those of the structs whose JSON the program prints.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use schemars::JsonSchema;
use schemars::generate::{SchemaGenerator, SchemaSettings};
use serde_json::{Map, Value};
use slipmap::config::Fitted;
use slipmap::probe::Probe;
use slipmap::risk::Risk;

const HEAD: &str = "\"\"\"The classes of answers, of the structs of the program: tests/documents/results.rs writes them.\"\"\"\n\n\
                    from __future__ import annotations\n\nfrom dataclasses import dataclass, field\n";

/// Keys that Python or its users could not write, and the names of their fields.
const OTHER_NAMES: [(&str, &str); 2] = [("from", "lo"), ("to", "hi")];

#[test]
fn python_has_the_classes_of_the_structs() {
    let mut all = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let answers: [fn(&mut SchemaGenerator); 3] = [with::<Probe>, with::<Risk>, with::<Fitted>];
    answers.iter().for_each(|answer| answer(&mut all));
    let mut text = HEAD.to_owned();
    // A complex number is one of Python's.
    for (name, class) in all.definitions().iter().filter(|(name, _)| *name != "Complex") {
        text.push_str(&class_of(name, class));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/slipmap/_results.py");
    if fs::read_to_string(&path).unwrap_or_default() != text {
        fs::write(&path, text).unwrap();
        panic!(
            "{} was not that of the structs, and is now: read its changes, and commit them",
            path.display()
        );
    }
}

fn with<T: JsonSchema>(to: &mut SchemaGenerator) {
    to.subschema_for::<T>();
}

fn class_of(name: &str, class: &Value) -> String {
    let mut text = format!("\n\n@dataclass(frozen=True, kw_only=True)\nclass {name}:\n");
    if let Some(words) = words_of(class) {
        let _ = writeln!(text, "    \"\"\"{words}\"\"\"\n");
    }
    let required = class["required"].as_array().map_or(&[][..], Vec::as_slice);
    for (key, field) in class["properties"].as_object().unwrap() {
        let other = OTHER_NAMES.iter().find(|(known, _)| known == key);
        let name = other.map_or(key.as_str(), |(_, name)| name);
        let default = match other {
            Some(_) => format!(" = field(metadata={{\"key\": \"{key}\"}})"),
            None if required.iter().any(|it| it == key) => String::new(),
            None => " = None".to_owned(),
        };
        let _ = writeln!(text, "    {name}: {}{default}", type_of(field.as_object().unwrap()));
        if let Some(words) = words_of(field) {
            let _ = writeln!(text, "    \"\"\"{}\"\"\"", words.replace("NaN", "None"));
        }
    }
    text
}

/// What the struct says of itself or of a field. A link is the name of what it leads to.
fn words_of(of: &Value) -> Option<String> {
    let words = of["description"].as_str()?.replace('\n', "\n    ");
    Some(words.replace("[`", "`").replace("`]", "`").replace('\\', "\\\\"))
}

fn type_of(schema: &Map<String, Value>) -> String {
    let inner = |of: &Value| type_of(of.as_object().unwrap());
    if let Some(class) = schema.get("$ref") {
        let name = class.as_str().unwrap().rsplit('/').next().unwrap();
        return if name == "Complex" { "complex".into() } else { name.into() };
    }
    if let Some(several) = schema.get("anyOf") {
        return several.as_array().unwrap().iter().map(inner).collect::<Vec<_>>().join(" | ");
    }
    let one = |name: &Value| match name.as_str().unwrap() {
        "number" => "float".to_owned(),
        "integer" => "int".to_owned(),
        "boolean" => "bool".to_owned(),
        "string" => "str".to_owned(),
        "null" => "None".to_owned(),
        "array" => format!("tuple[{}, ...]", inner(&schema["items"])),
        "object" => format!("dict[str, {}]", inner(&schema["additionalProperties"])),
        other => panic!("Python has no type {other}"),
    };
    match &schema["type"] {
        Value::Array(several) => several.iter().map(one).collect::<Vec<_>>().join(" | "),
        single => one(single),
    }
}
