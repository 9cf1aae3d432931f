//! The page: one file with its styles, its scripts, where it begins, and perhaps the program as WebAssembly.

use std::fmt::Write as _;

use serde_json::json;

use super::{Start, catalogue};

/// The page without what is put into it.
const HTML: &str = include_str!("assets/index.html");
const STYLE: &str = include_str!("assets/style.css");
const ICON: &str = include_str!("assets/icon.svg");
const WORKER: &str = include_str!("assets/worker.js");

/// The modules of the page, each after those that it imports from.
const MODULES: [(&str, &str); 14] = [
    ("program", include_str!("assets/program.js")),
    ("elements", include_str!("assets/elements.js")),
    ("state", include_str!("assets/state.js")),
    ("scale", include_str!("assets/scale.js")),
    ("paint", include_str!("assets/paint.js")),
    ("legend", include_str!("assets/legend.js")),
    ("overlay", include_str!("assets/overlay.js")),
    ("glance", include_str!("assets/glance.js")),
    ("plane", include_str!("assets/plane.js")),
    ("controls", include_str!("assets/controls.js")),
    ("point", include_str!("assets/point.js")),
    ("gallery", include_str!("assets/gallery.js")),
    ("leave", include_str!("assets/leave.js")),
    ("main", include_str!("assets/main.js")),
];

/// This crate as WebAssembly, in gzip and base64; empty where it was not there as the program was built.
pub const WASM: &str = include_str!(concat!(env!("OUT_DIR"), "/wasm.txt"));

/// What computes the answers of a page.
#[derive(Clone, Copy, Debug)]
pub enum Engine<'a> {
    /// A server, at this path.
    Server(&'a str),
    /// The page itself: [`WASM`].
    Browser,
}

/// The page that begins with `start`. Its policy forbids the browser to load anything from elsewhere.
#[must_use]
pub fn page(start: &Start, engine: Engine) -> String {
    let (server, connect, wasm) = match engine {
        Engine::Server(path) => (path, "'self'", ""),
        Engine::Browser => ("", "'none'", WASM),
    };
    let begin = json!({ "catalogue": catalogue::catalogue(), "start": start.to_json(), "server": server });
    // No text in it ends the element that it stands in.
    let begin = begin.to_string().replace('<', "\\u003c");
    let icon: String = ICON.bytes().fold(String::new(), |mut icon, byte| {
        let _ = write!(icon, "%{byte:02x}");
        icon
    });
    [
        ("{connect}", connect),
        ("{icon}", &icon),
        ("{style}", STYLE),
        ("{worker}", WORKER),
        ("{begin}", &begin),
        ("{wasm}", wasm),
        ("{script}", &script()),
    ]
    .into_iter()
    .fold(HTML.to_owned(), |page, (place, text)| page.replacen(place, text, 1))
}

/// All modules as one script, each a function that returns what it exports.
fn script() -> String {
    MODULES.iter().fold(String::new(), |mut script, (name, text)| {
        let mut exported = Vec::new();
        let lines: Vec<String> = text.lines().map(|line| plain(line, &mut exported)).collect();
        let (lines, exported) = (lines.join("\n"), exported.join(", "));
        let _ = writeln!(script, "const {name}_js = (() => {{\n{lines}\nreturn {{ {exported} }};\n}})();");
        script
    })
}

/// A line of a module as that of a function; the name that it exports is pushed to `exported`.
fn plain<'a>(line: &'a str, exported: &mut Vec<&'a str>) -> String {
    if let Some((names, of)) = line.strip_prefix("import ").and_then(|rest| rest.split_once(" from ")) {
        let module = of.trim_matches(['"', '.', '/', ';']).trim_end_matches(".js");
        return format!("const {} = {module}_js;", names.replace(" as ", ": "));
    }
    let Some(line) = line.strip_prefix("export ") else { return line.to_owned() };
    let name = line.split([' ', '(']).find(|word| !["async", "function", "class", "const"].contains(word));
    exported.extend(name);
    line.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_become_functions_that_return_what_they_export() {
        let script = script();
        assert!(script.contains("const { Scale } = scale_js;"), "no import is left as it was");
        assert!(script.contains("const { picture: ask, post } = program_js;"));
        for line in script.lines() {
            assert!(!line.starts_with("import ") && !line.starts_with("export "), "{line}");
        }
        let order = |name: &str| script.find(&format!("const {name}_js = ")).unwrap();
        for (name, _) in MODULES {
            if let Some(used) = script.find(&format!(" = {name}_js;")) {
                assert!(order(name) < used, "{name} stands behind what imports from it");
            }
        }
    }

    #[test]
    fn the_page_asks_nothing_of_other_places() {
        let page = page(&Start::default(), Engine::Browser);
        assert!(page.contains("default-src 'none'") && page.contains("connect-src 'none'"));
        for place in ["{connect}", "{icon}", "{style}", "{worker}", "{begin}", "{wasm}", "{script}"] {
            assert!(HTML.contains(place) && !page.contains(place), "{place}");
        }
        for loads in [" src=\"/", "@import", "href=\"http", "src=\"http"] {
            assert!(!page.contains(loads), "{loads}");
        }
    }
}
