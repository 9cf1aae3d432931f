//! Writes `slipmap/_results.py`: the classes of answers, from the structs whose JSON `slipmap --json` prints.

// What it does not know ends the build.
#![allow(clippy::expect_used)]

use std::fmt::Write as _;
use std::path::Path;

use syn::{Attribute, Expr, ExprLit, Field, GenericArgument, Item, ItemStruct, Lit, PathArguments, Type};

/// Where the structs are, and which of them are read; all of a file if none is named. A second name is that of the class.
const SOURCES: [(&str, &[(&str, &str)]); 8] = [
    ("numbers/src/range.rs", &[("Range", "Range")]),
    ("orbits/src/lib.rs", &[("Cycle", "Cycle")]),
    ("column/src/slip_cycle.rs", &[("Kick", "Kick")]),
    ("column/src/sensitivity.rs", &[("Estimate", "Estimate")]),
    ("machine/src/lib.rs", &[("Units", "Units")]),
    ("machine/src/risk.rs", &[("Estimate", "WithLimits"), ("RareBy", "RareBy"), ("Risk", "Risk")]),
    ("machine/src/probe/result.rs", &[]),
    ("config/src/measured/fit.rs", &[("FittedLaw", "FittedLaw"), ("Fitted", "Fitted")]),
];

const HEAD: &str = "\"\"\"The classes of answers. Made by build.rs of the structs of the program: do not edit.\"\"\"\n\n\
                    from __future__ import annotations\n\nfrom dataclasses import dataclass, field\n";

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = HEAD.to_owned();
    for (file, classes) in SOURCES {
        let path = root.join("../crates").join(file);
        println!("cargo:rerun-if-changed={}", path.display());
        let source = std::fs::read_to_string(&path).expect("the structs are beside the package");
        for item in structs(&source) {
            let name = item.ident.to_string();
            match classes.iter().find(|(known, _)| *known == name) {
                Some((_, class)) => text.push_str(&class_of(&item, class, classes)),
                None if classes.is_empty() && name != "Complex" => {
                    text.push_str(&class_of(&item, &name, classes))
                }
                None => {}
            }
        }
    }
    let path = root.join("slipmap/_results.py");
    println!("cargo:rerun-if-changed={}", path.display());
    if std::fs::read_to_string(&path).is_ok_and(|written| written == text) {
        return;
    }
    std::fs::write(&path, text).expect("the folder of the package can be written");
}

/// The structs of a file.
fn structs(source: &str) -> impl Iterator<Item = ItemStruct> {
    let file = syn::parse_file(source).expect("the compiler accepts the file");
    file.items.into_iter().filter_map(|item| if let Item::Struct(item) = item { Some(item) } else { None })
}

fn class_of(item: &ItemStruct, class: &str, names: &[(&str, &str)]) -> String {
    let mut text = format!("\n\n@dataclass(frozen=True, kw_only=True)\nclass {class}:\n");
    if let Some(words) = documentation(&item.attrs) {
        let _ = writeln!(text, "    \"\"\"{words}\"\"\"\n");
    }
    item.fields.iter().for_each(|field| text.push_str(&field_of(field, names)));
    text
}

fn field_of(field: &Field, names: &[(&str, &str)]) -> String {
    let (key, optional, skipped) = serialised(&field.attrs);
    if skipped {
        return String::new();
    }
    let own = field.ident.as_ref().expect("fields have names").to_string();
    let words = documentation(&field.attrs);
    // JSON has no NaN: it is null.
    let none = if words.as_ref().is_some_and(|words| words.contains("NaN")) { " | None" } else { "" };
    let key = key.unwrap_or_else(|| own.clone());
    let is_keyword = ["from", "to"].contains(&key.as_str());
    let name = if is_keyword { &own } else { &key };
    let default = match (is_keyword, optional) {
        (true, _) => format!(" = field(metadata={{\"key\": \"{key}\"}})"),
        (false, true) => " = None".to_owned(),
        (false, false) => String::new(),
    };
    let mut text = format!("    {name}: {}{none}{default}\n", python(&field.ty, names));
    if let Some(words) = words {
        let _ = writeln!(text, "    \"\"\"{}\"\"\"", words.replace("NaN", "None"));
    }
    text
}

/// The key of a field in JSON if it is another one, whether it may be absent, and whether it is.
fn serialised(attributes: &[Attribute]) -> (Option<String>, bool, bool) {
    let (mut key, mut optional, mut skipped) = (None, false, false);
    for attribute in attributes.iter().filter(|of| of.path().is_ident("serde")) {
        let read = attribute.parse_nested_meta(|meta| {
            skipped |= meta.path.is_ident("skip");
            optional |= meta.path.is_ident("skip_serializing_if");
            if let Ok(value) = meta.value() {
                let value: syn::LitStr = value.parse()?;
                if meta.path.is_ident("rename") {
                    key = Some(value.value());
                }
            }
            Ok(())
        });
        read.expect("attributes of serde are names and texts");
    }
    (key, optional, skipped)
}

fn documentation(attributes: &[Attribute]) -> Option<String> {
    let lines = attributes.iter().filter(|of| of.path().is_ident("doc")).filter_map(|of| {
        let Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) = &of.meta.require_name_value().ok()?.value else {
            return None;
        };
        Some(text.value().trim().to_owned())
    });
    let words = lines.collect::<Vec<String>>().join("\n    ");
    // A link is the name of what it leads to.
    (!words.is_empty()).then(|| words.replace("[`", "`").replace("`]", "`").replace('\\', "\\\\"))
}

fn python(of: &Type, names: &[(&str, &str)]) -> String {
    match of {
        Type::Reference(of) => python(&of.elem, names),
        Type::Array(of) => format!("tuple[{}, ...]", python(&of.elem, names)),
        Type::Path(path) => {
            let last = path.path.segments.last().expect("a path has a name");
            let first = match &last.arguments {
                PathArguments::AngleBracketed(of) => of.args.iter().find_map(|it| match it {
                    GenericArgument::Type(of) => Some(of),
                    _ => None,
                }),
                _ => None,
            };
            match (last.ident.to_string().as_str(), first) {
                ("f64", _) => "float".into(),
                ("u32" | "u64" | "usize", _) => "int".into(),
                ("bool", _) => "bool".into(),
                ("str" | "String" | "Cow", _) => "str".into(),
                ("Complex", _) => "complex".into(),
                ("Option", Some(of)) => format!("{} | None", python(of, names)),
                // Pairs of a name and a value are a map.
                ("Vec", Some(Type::Tuple(pair))) => format!("dict[str, {}]", python(&pair.elems[1], names)),
                ("Vec", Some(of)) => format!("tuple[{}, ...]", python(of, names)),
                (name, _) => {
                    names.iter().find(|(known, _)| *known == name).map_or(name, |(_, class)| class).into()
                }
            }
        }
        _ => panic!("a type that JSON does not have"),
    }
}
