//! Checks that the reference of configuration keys names every key of the parser, and that its examples are
//! legal.

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

#[test]
fn every_key_is_documented_and_no_other() {
    let documented = documented();
    for (section, keys) in slipmap::config::keys() {
        let (_, named) =
            documented.iter().find(|(name, _)| *name == section).unwrap_or_else(|| panic!("[{section}]"));
        let mut wanted: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
        let mut named = named.clone();
        wanted.sort();
        named.sort();
        assert_eq!(named, wanted, "[{section}]");
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
    assert!(examples.len() >= 12);
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
