//! `slipmap explore`: its answers about points, pictures and curves, and what is exported.

mod machines;
mod server;

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use crate::command::Scratch;

/// A running server; it ends with the test.
pub struct Server {
    process: Child,
    port: u16,
    /// The path of its page, with the secret.
    path: String,
}

impl Server {
    pub fn start(scratch: &Scratch, arguments: &[&str]) -> Self {
        let all: Vec<&str> =
            ["explore", "--no-browser", "--port", "0"].into_iter().chain(arguments.iter().copied()).collect();
        let mut process = scratch.command(&all).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let (port, path) = address.trim().strip_prefix("http://127.0.0.1:").unwrap().split_once('/').unwrap();
        assert!(path.len() == 33 && path.ends_with('/'), "{address}");
        Self { process, port: port.parse().unwrap(), path: format!("/{path}") }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
    }

    /// Status, head and body of the answer to a raw request.
    fn send(&self, request: &[u8]) -> (u16, String, Vec<u8>) {
        let mut stream = self.connect();
        // A server that refuses a request may close the connection before it has read everything.
        let _ = stream.write_all(request);
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").unwrap_or(all.len());
        let head = String::from_utf8_lossy(&all[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0);
        (status, head, all.get(end + 4..).unwrap_or_default().to_vec())
    }

    /// The answer to a request for a path of its host.
    fn get(&self, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
        let host = format!("Host: 127.0.0.1:{}\r\n", self.port);
        let host = if headers.contains("Host:") { "" } else { &host };
        self.send(format!("GET {path} HTTP/1.1\r\n{host}{headers}Connection: close\r\n\r\n").as_bytes())
    }

    /// A request that posts `body`.
    fn request(&self, path: &str, body: &[u8]) -> Vec<u8> {
        let mut request = format!(
            "POST {}{path} HTTP/1.1\r\nHost: localhost:{}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            self.path,
            self.port,
            body.len()
        )
        .into_bytes();
        request.extend(body);
        request
    }

    fn post(&self, path: &str, body: &[u8]) -> (u16, Vec<u8>) {
        let (status, _, body) = self.send(&self.request(path, body));
        (status, body)
    }

    fn ask(&self, path: &str, body: &Value) -> (u16, Value) {
        let (status, answer) = self.post(path, body.to_string().as_bytes());
        (status, serde_json::from_slice(&answer).unwrap_or_default())
    }

    /// The answer in JSON to a request that is not refused.
    pub fn answer(&self, path: &str, body: &Value) -> Value {
        let (status, answer) = self.ask(path, body);
        assert_eq!(status, 200, "{answer}");
        answer
    }

    /// The head and the cells of a picture.
    fn picture(&self, asked: &Value) -> (Value, Vec<u8>) {
        let (status, mut bytes) = self.post("plane", asked.to_string().as_bytes());
        assert_eq!(status, 200, "{asked} {}", String::from_utf8_lossy(&bytes));
        let end = bytes.iter().position(|&byte| byte == b'\n').unwrap();
        let cells = bytes.split_off(end + 1);
        (serde_json::from_slice(&bytes).unwrap(), cells)
    }

    /// What its page begins with.
    fn begin(&self) -> Value {
        let page = String::from_utf8(self.get(&self.path, "").2).unwrap();
        let (_, begin) = page.split_once("id=\"begin\">").unwrap();
        serde_json::from_str(begin.split_once("</script>").unwrap().0).unwrap()
    }

    /// Bytes of memory that the process holds.
    #[cfg(target_os = "linux")]
    fn memory(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
        1024 * line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn place() -> Value {
    let at = json!({ "epsilon": 0.1, "alpha": 0.3, "beta": 0.1, "gamma": 2.0, "V": 1.0, "c": 0.5 });
    json!({ "law": { "name": "stribeck" }, "at": at })
}

fn plane() -> Value {
    let mut plane = place();
    plane["x"] = json!({ "axis": "gamma", "from": 0.0, "to": 8.0, "points": 16 });
    plane["y"] = json!({ "axis": "c", "from": 0.0, "to": 4.0, "points": 8 });
    plane["show"] = "regime".into();
    plane
}

#[test]
fn a_point_is_answered_as_by_probe() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let answer = server.answer("point", &place());
    let probe = scratch.run(&[&crate::command::PROBE[..], &["--json"]].concat()).ends_with(0);
    let probe: Value = serde_json::from_str(&probe.out).unwrap();
    assert_eq!(answer, probe);
    for figure in ["orbit", "friction", "backbone"] {
        let mut asked = place();
        asked["figure"] = figure.into();
        let drawn = server.answer("figure", &asked);
        roxmltree::Document::parse(drawn["svg"].as_str().unwrap()).unwrap();
    }
}

#[test]
fn pictures_hold_the_cells_of_the_map() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let (head, cells) = server.picture(&plane());
    assert_eq!((head["width"].as_u64(), head["height"].as_u64(), cells.len()), (Some(16), Some(8), 128));
    // The same cells as a map: their middles are the nodes.
    assert_map_is_the_picture(&server, &scratch, &plane());
    let map = slipmap::store::MapFile::open(&scratch.path().join("plane.h5")).unwrap();
    let ends = map.grid().axes().iter().map(|axis| [axis.values[0], *axis.values.last().unwrap()]);
    assert_eq!(ends.skip(3).collect::<Vec<_>>(), [[0.25, 7.75], [1.0; 2], [0.25, 3.75]]);
    assert!(cells.iter().any(|&code| code != cells[0]));
    // With the axes exchanged the picture is transposed.
    let mut turned = plane();
    (turned["x"], turned["y"]) = (plane()["y"].clone(), plane()["x"].clone());
    let (_, other) = server.picture(&turned);
    assert!((0..128).all(|i| cells[i] == other[8 * (i % 16) + i / 16]));
}

#[test]
fn pictures_show_numbers_and_comparisons() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    // Bytes of a cell.
    for (show, size) in [
        ("critical_c_simulation", 4),
        ("cycle_period", 4),
        ("difference:perturbation:simulation", 1),
        ("decider", 1),
        ("verdict_symmetric", 1),
    ] {
        let mut asked = plane();
        asked["show"] = show.into();
        assert_eq!(server.picture(&asked).1.len(), 128 * size, "{show}");
    }
    // The method that is named first in a comparison is the first in the codes.
    let compared = |pair: &str| {
        let mut asked = plane();
        asked["at"]["epsilon"] = 0.5.into();
        asked["show"] = format!("difference:{pair}").into();
        server.picture(&asked).1
    };
    let (one, other) = (compared("perturbation:simulation"), compared("simulation:perturbation"));
    assert!(one.contains(&2) && !one.contains(&3));
    assert!(one.iter().zip(&other).all(|(a, b)| [(0, 0), (1, 1), (2, 3), (4, 4)].contains(&(*a, *b))));
}

#[test]
fn curves_come_with_their_errors() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let found = server.answer("curves", &plane());
    let names: Vec<&str> =
        found["curves"].as_array().unwrap().iter().filter_map(|curve| curve["name"].as_str()).collect();
    assert!(names.contains(&"hopf") && names.contains(&"grazing_sliding"), "{names:?}");
    for curve in found["curves"].as_array().unwrap() {
        let [points, errors] = ["points", "errors"].map(|of| curve[of].as_array().unwrap());
        assert_eq!(points.len(), errors.len());
        assert!(errors.iter().all(|error| (0.0..1e-3).contains(&error.as_f64().unwrap())), "{errors:?}");
    }
}

#[test]
fn a_configuration_or_a_map_is_where_the_page_begins() {
    let scratch = Scratch::new();
    scratch.file(
        "small.toml",
        "[friction]\nlaw = \"lorentzian\"\n[grid]\nepsilon = 1.0\nmu = 0.5\nvs = [0.2, 0.5]\n\
         eta = 0.0\nV = 1.0\nc = { from = 0.0, to = 1.0, points = 5 }\n[output]\npath = \"small.h5\"\n",
    );
    scratch.run(&["run", "small.toml", "--quiet"]).ends_with(0);
    for file in ["small.toml", "small.h5"] {
        let server = Server::start(&scratch, &[file]);
        let start = server.begin()["start"].clone();
        assert_eq!(start["law"]["name"], "lorentzian");
        assert_eq!(
            start["axes"][2],
            json!({ "name": "vs", "from": 0.2, "to": 0.5, "value": 0.2, "nodes": 2, "log": false })
        );
    }
    scratch.run(&["explore", "--no-browser", "none.toml"]).refuses(&["none.toml"]);
    scratch.run(&["explore", "--no-browser", "small.txt"]).refuses(&["small.txt"]);
}

/// Runs the exported configuration and commands.
fn follow_the_export(server: &Server, scratch: &Scratch, asked: &Value) {
    let texts = server.answer("texts", asked);
    scratch.file("plane.toml", texts["toml"].as_str().unwrap());
    if let Some(table) = texts["table"].as_str() {
        scratch.file("friction.csv", table);
    }
    for command in texts["commands"].as_str().unwrap().lines() {
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        scratch.run(&[&words[..], &["--overwrite"]].concat()).ends_with(0);
    }
}

/// The cells of the exported map are those of the picture.
fn assert_map_is_the_picture(server: &Server, scratch: &Scratch, asked: &Value) {
    follow_the_export(server, scratch, asked);
    let (_, cells) = server.picture(asked);
    let file = hdf5::File::open(scratch.path().join("plane.h5")).unwrap();
    let stored = file.dataset("regime").unwrap().read_raw::<i8>().unwrap();
    let (columns, rows) =
        (asked["x"]["points"].as_u64().unwrap() as usize, asked["y"]["points"].as_u64().unwrap() as usize);
    assert_eq!(stored.len(), columns * rows);
    for (place, code) in stored.into_iter().enumerate() {
        assert_eq!(cells[place % rows * columns + place / rows].cast_signed(), code, "{place}");
    }
}

#[test]
fn the_commands_of_a_plane_make_its_map_and_figures() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let texts = server.answer("texts", &plane());
    // The exported command of the point is the one in the README.
    let command = texts["command"].as_str().unwrap();
    assert_eq!(command, format!("slipmap {}", crate::command::PROBE.join(" ")));
    for show in
        ["regime", "decider", "difference:perturbation:simulation", "cycle_period", "critical_c_simulation"]
    {
        let mut asked = plane();
        (asked["show"], asked["curves"]) = (show.into(), true.into());
        follow_the_export(&server, &scratch, &asked);
    }
    // Formulas and tables too.
    for law in [
        json!({ "name": "expression", "phi": "mu + (1 - mu)*exp(-u)" }),
        json!({ "name": "table", "table": "0,1\n1,0.7\n2,0.6\n9,0.5\n", "file": "../measured.csv" }),
    ] {
        let mut asked = plane();
        asked["law"] = law;
        asked["at"] = json!({ "epsilon": 1.0, "mu": 0.5, "V": 1.0, "c": 0.1 });
        asked["x"]["axis"] = "V".into();
        asked["x"]["to"] = 2.0.into();
        assert_map_is_the_picture(&server, &scratch, &asked);
    }
}

/// No formula ends the program for the other tabs.
#[test]
fn formulas_that_cancel_are_refused_and_the_server_goes_on() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    for phi in [
        "0.5+0.5*exp(-u)+(u+1e5)^3-u^3-1e5^3",
        "(1e16+1)-1e16+0.5+0.5*exp(-u)",
        "0.5+0.5*exp(-u)+sin(1e20+u)-sin(1e20+u)",
    ] {
        let mut asked = json!({
            "law": { "name": "expression", "phi": phi },
            "at": { "epsilon": 1.0, "V": 1.0, "c": 0.05 }
        });
        for path in ["point", "glance", "figure"] {
            asked["figure"] = "backbone".into();
            let (status, answer) = server.ask(path, &asked);
            assert!(
                status == 422 && answer.to_string().contains("up to rounding"),
                "{phi}: {status} {answer}"
            );
        }
        asked["x"] = json!({ "axis": "V", "from": 0.5, "to": 1.5, "points": 4 });
        asked["y"] = json!({ "axis": "c", "from": 0.0, "to": 1.0, "points": 4 });
        asked["show"] = "regime".into();
        let (status, _) = server.post("plane", asked.to_string().as_bytes());
        assert!(status == 200 || status == 422, "{phi}: {status}");
    }
    assert_eq!(server.ask("point", &place()).0, 200);
}
