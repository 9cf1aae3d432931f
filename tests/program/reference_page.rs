//! Checks that the reference of configuration keys names every key of the parser, and that its examples are
//! legal.

use std::collections::BTreeSet;

use slipmap::config::Job;

fn page() -> String {
    std::fs::read_to_string(format!("{}/docs/configuration.md", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// The keys of the tables below each heading `## `[section]``.
fn documented() -> Vec<(String, Vec<String>)> {
    let page = page();
    let sections = page.split("\n## ").skip(1).filter_map(|part| {
        let (heading, rest) = part.split_once('\n')?;
        let name = match heading.trim() {
            "Top level" => String::new(),
            heading => heading.strip_prefix("`[")?.strip_suffix("]`")?.to_owned(),
        };
        // The first table is that of the keys.
        let rows = rest.lines().skip_while(|line| !line.starts_with("| key")).skip(2);
        let cells = rows.take_while(|line| line.starts_with('|')).filter_map(|line| line.split('|').nth(1));
        let keys =
            cells.flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>());
        Some((name, keys.collect()))
    });
    sections.collect()
}

/// The keys of a section that the parser lists when it refuses an unknown key; "" is the top level.
fn keys_of(section: &str, law: &str) -> Vec<String> {
    let friction = format!("[friction]\nlaw = \"{law}\"\n");
    let text = match section {
        "" => "wrong = 1\n".to_owned(),
        "friction" => format!("{friction}wrong = 1\n"),
        section => format!("{friction}[{section}]\nwrong = 1\n"),
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("job.toml");
    std::fs::write(&file, text).unwrap();
    let error = Job::load(&file, &[]).unwrap_err().to_string();
    match error.split_once("valid are: ") {
        Some((_, keys)) => keys.split(", ").map(str::to_owned).collect(),
        None => vec![error.rsplit('`').nth(1).unwrap_or_else(|| panic!("{error}")).to_owned()],
    }
}

#[test]
fn every_key_is_documented_and_no_other() {
    let documented = documented();
    let sections: Vec<String> = keys_of("", "stribeck").into_iter().filter(|key| key != "title").collect();
    assert!(sections.len() > 9, "{sections:?}");
    for section in sections.iter().map(String::as_str).chain([""]) {
        let mut wanted: BTreeSet<String> = keys_of(section, "stribeck").into_iter().collect();
        match section {
            // The axes of all built-in laws.
            "grid" => wanted.extend(
                ["exponential", "lorentzian", "coulomb"].iter().flat_map(|law| keys_of(section, law)),
            ),
            // The quantities of all built-in laws.
            "machine" => wanted.extend(keys_of(section, "exponential")),
            // A section is not a key.
            "" => wanted.retain(|key| !sections.contains(key)),
            _ => {}
        }
        let named = documented.iter().find(|(name, _)| name == section);
        let named = named.unwrap_or_else(|| panic!("[{section}]")).1.iter().cloned().collect();
        assert_eq!(wanted, named, "[{section}]");
    }
}

#[test]
fn every_example_is_legal() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("measured.csv"), "0,1\n0.5,0.8\n1,0.7\n2,0.65\n4,0.65\n").unwrap();
    let grid =
        "[grid]\nepsilon = 0.1\nalpha = [0.3, 0.5]\nbeta = 0\ngamma = [1, 2]\nV = 1.0\nc = [0.5, 1.0]\n";
    let page = page();
    let examples: Vec<&str> =
        page.split("```toml\n").skip(1).filter_map(|part| part.split("```").next()).collect();
    assert!(examples.len() >= 5);
    for example in examples {
        let own = example.contains("[grid]") || example.contains("[machine]");
        let text = if own { example.to_owned() } else { format!("{example}{grid}") };
        let file = folder.path().join("job.toml");
        std::fs::write(&file, &text).unwrap();
        if let Err(error) = Job::load(&file, &[]) {
            panic!("{error}\n{text}");
        }
    }
}
