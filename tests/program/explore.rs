//! `slipmap explore`: answers and refusals of its server.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use slipmap_numbers::random::Random;

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
    // Numbers, and comparisons of two methods.
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

/// Other users and other pages reach the port, but do not know the secret.
#[test]
fn only_who_knows_the_secret_may_ask() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let (status, head, body) = server.get(&server.path, "");
    assert_eq!(status, 200, "{head}");
    for header in ["x-content-type-options: nosniff", "referrer-policy: no-referrer", "x-frame-options: DENY"]
    {
        assert!(head.contains(header), "no {header} in\n{head}");
    }
    let text = String::from_utf8(body).unwrap();
    assert!(text.contains("default-src 'none'") && text.contains("connect-src 'self'"));
    let other = Server::start(&scratch, &[]);
    assert_ne!(server.path, other.path);
    let asked = place().to_string();
    for path in
        ["/", "/point", "//point", "/../point", "/etc/passwd", &other.path, &format!("{}point", other.path)]
    {
        for method in ["GET", "POST"] {
            let length = asked.len();
            let request = format!(
                "{method} {path} HTTP/1.1\r\nHost: a\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{asked}"
            );
            let (status, head, body) = server.send(request.as_bytes());
            assert!(status == 404 && body.is_empty(), "{path} {head}");
            assert!(!head.to_lowercase().contains("access-control"), "{head}");
        }
    }
    // By any name of the host, and whatever the port: links of the standard port have none.
    assert_eq!(server.get(&server.path, "Host: localhost\r\n").0, 200);
    let within = |path: &str| server.get(&format!("{}{path}", server.path), "").0;
    assert_eq!((within("point"), within("../etc/passwd"), within("etc/passwd")), (405, 405, 405));
}

#[test]
fn bad_requests_are_refused_in_words() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let refused = |path: &str, request: Value, words: &str| {
        let (status, answer) = server.ask(path, &request);
        assert!((400..500).contains(&status), "{status} {answer}");
        assert!(answer["problem"].is_string(), "{answer}");
        assert!(answer.to_string().contains(words), "no `{words}` in {answer}");
    };
    let with = |pointer: &str, value: Value| {
        let mut request = plane();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        request.pointer_mut(parent).unwrap()[key] = value;
        request
    };
    for (pointer, value, words) in [
        ("/x/points", json!(1_000_000_000_u64), "1000000000 cells"),
        ("/x/points", json!(0), "0 cells"),
        ("/x/points", json!(-1), "cannot be read"),
        ("/x/to", json!(-1.0), "must increase"),
        ("/x/to", json!(2e-323), "too close"),
        ("/x/axis", json!("c"), "same axis"),
        ("/x/axis", json!("nothing"), "no axis nothing"),
        ("/at/V", json!(0.0), "V is 0.0"),
        ("/at/V", json!("NaN"), "cannot be read"),
        ("/at/V", Value::Null, "cannot be read"),
        ("/show", json!("verdict_nothing"), "verdict_nothing"),
        ("/show", json!("difference:a:b"), "difference:a:b"),
        ("/law/name", json!("nothing"), "nothing"),
        ("/law/static", json!(0.5), "friction at rest is 1 already"),
        ("/law/rows", json!([[0, 1]]), "has no rows"),
    ] {
        refused("plane", with(pointer, value), words);
    }
    let mut both = with("/x/points", json!(4096));
    both["y"]["points"] = json!(4096);
    refused("plane", both, "too many cells");
    let mut logarithmic = with("/x/log", json!(true));
    logarithmic["x"]["from"] = json!(0.0);
    refused("plane", logarithmic, "logarithmic axis");
    let formula = |phi: String| json!({ "name": "expression", "phi": phi });
    let (status, answer) = server.ask("law", &formula("1 - 0.5*u + ".into()));
    assert_eq!((status, answer["place"].is_array()), (422, true), "{answer}");
    refused("law", formula("(".repeat(4000)), "");
    refused("law", formula(format!("1{}", " + u".repeat(1000))), "operations");
    refused("law", formula("1+".repeat(3000)), "4096 characters");
    refused("law", json!({ "name": "table", "table": "0,1\n1,2\n2,x\n", "file": "a.csv" }), "a.csv:3");
    refused("law", json!({ "name": "table", "table": "" }), "no row has two numbers");
    for (body, status) in [
        (&b"{"[..], 400),
        (b"[]", 400),
        (b"\xff\xfe", 400),
        (b"{\"at\": {\"V\": NaN}}", 400),
        (b"{\"at\": {\"V\": 1e999}}", 400),
    ] {
        assert_eq!(server.post("plane", body).0, status);
    }
    assert_eq!(server.post("plane", "[".repeat(500_000).as_bytes()).0, 400);
    assert_eq!(server.post("plane", &vec![b' '; 2 << 20]).0, 413);
    assert_eq!(server.ask("point", &place()).0, 200);
}

/// Work whose connection is closed stops: else the next picture would wait for both, longer than its time limit.
#[test]
fn work_that_nobody_waits_for_is_stopped() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let mut slow = plane();
    // Half a million orbits one by one: half a minute.
    slow["x"] = json!({ "axis": "gamma", "from": 0.0, "to": 8.0, "points": 1024 });
    slow["y"] = json!({ "axis": "V", "from": 0.0, "to": 4.0, "points": 512 });
    slow["show"] = "cycle_amplitude_x1".into();
    let request = server.request("plane", slow.to_string().as_bytes());
    // As many points, of which each takes seconds.
    let mut steep = place();
    steep["law"] = json!({ "name": "expression", "phi": "1 - 0.001*sin(30000*u)" });
    let of_point = server.request("point", steep.to_string().as_bytes());
    let requests = [&request, &request, &of_point, &of_point, &of_point, &of_point];
    let mut given_up: Vec<TcpStream> = requests.iter().map(|_| server.connect()).collect();
    for (stream, request) in given_up.iter_mut().zip(requests) {
        stream.write_all(request).unwrap();
    }
    std::thread::sleep(Duration::from_millis(300));
    // A small answer waits for none of them.
    assert_eq!(server.ask("law", &json!({ "name": "stribeck" })).0, 200);
    for stream in &mut given_up {
        stream.set_nonblocking(true).unwrap();
        assert!(stream.read(&mut [0]).is_err(), "this was quick");
    }
    drop(given_up);
    // Seconds of work, which do not fit into what two others that reach their time limit leave of its own.
    let mut next = slow;
    next["x"]["points"] = 256.into();
    next["y"]["points"] = 128.into();
    assert_eq!(server.ask("plane", &next).0, 200);
    assert_eq!(server.ask("point", &place()).0, 200);
}

/// Hundreds of requests of every kind, silent connections, and bodies that never end.
#[test]
#[cfg(target_os = "linux")]
fn the_server_outlives_everything() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    assert_eq!(server.ask("point", &place()).0, 200);
    let before = server.memory();
    let idle: Vec<TcpStream> = (0..100).map(|_| server.connect()).collect();
    let mut half_said: Vec<TcpStream> = (0..100).map(|_| server.connect()).collect();
    let request = server.request("plane", b"{        ");
    for stream in &mut half_said {
        stream.write_all(&request[..request.len() - 1]).unwrap();
    }
    let mut random = Random(20);
    let mut next = || random.bits() >> 33;
    for _ in 0..400 {
        let mut asked = plane();
        let values = [
            json!(1e308),
            json!(-1e308),
            json!(5e-324),
            json!(0),
            json!([]),
            json!("x"),
            json!({}),
            Value::Null,
            json!(u64::MAX),
        ];
        let pointers = "/at/epsilon /at/V /at/gamma /at/c /x/from /x/to /x/points /y/log /show /law /law/phi";
        let pointers: Vec<&str> = pointers.split(' ').collect();
        for _ in 0..1 + next() % 2 {
            let (pointer, value) =
                (pointers[next() as usize % pointers.len()], &values[next() as usize % values.len()]);
            if let Some(place) = asked.pointer_mut(pointer) {
                *place = value.clone();
            }
        }
        let text = asked.to_string();
        let cut = if next() % 8 == 0 { text.len() / 2 } else { text.len() };
        let path = ["plane", "law", "glance", "nowhere"][next() as usize % 4];
        let (status, answer) = server.post(path, &text.as_bytes()[..cut]);
        assert!(
            status == 200 || (400..500).contains(&status) || status == 503,
            "{status} {text} {}",
            String::from_utf8_lossy(&answer)
        );
    }
    drop((idle, half_said));
    assert_eq!(server.ask("point", &place()).0, 200);
    let grown = server.memory().saturating_sub(before);
    assert!(grown < 200 << 20, "{} MiB more", grown >> 20);
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_it_in_time() {
    let scratch = Scratch::new();
    let mut server = Server::start(&scratch, &[]);
    let mut slow = plane();
    slow["x"]["points"] = 1024.into();
    slow["y"] = json!({ "axis": "V", "from": 0.0, "to": 4.0, "points": 512 });
    slow["show"] = "cycle_amplitude_x1".into();
    let mut asking = server.connect();
    asking.write_all(&server.request("plane", slow.to_string().as_bytes())).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    Command::new("kill").args(["-INT", &server.process.id().to_string()]).status().unwrap();
    assert_eq!(server.process.wait().unwrap().code(), Some(130));
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

/// Every plane of two quantities has at each cell the answer of `slipmap probe --machine` for that machine.
#[test]
fn any_quantity_of_a_machine_is_an_axis() {
    let scratch = Scratch::new();
    let server = Server::start(&scratch, &[]);
    let formula = json!({ "name": "expression", "phi": "muk + (mus - muk)*exp(-u/vs)" });
    let table: String = (0..16)
        .map(|i| 0.0025 * f64::from(i * i))
        .map(|u| format!("{u},{}\n", 0.25 + 0.15 * (-u / 0.05f64).exp()))
        .collect();
    let table = json!({ "name": "table", "table": table, "file": "mu.csv" });
    let exponential = json!({ "name": "exponential" });
    // One cell of each plane of two by two: the second across, the first up.
    let share = |i: f64| (i + 0.5) / 2.0;
    for (law, x, y) in [
        (&exponential, "mass", "damping"),
        (&exponential, "normal_force", "stiffness"),
        (&exponential, "belt_speed", "kinetic_friction"),
        (&formula, "vs", "damping"),
        (&table, "belt_speed", "mass"),
    ] {
        let mut asked = machine(x, y);
        asked["law"] = law.clone();
        // Room for the curve of the critical damping in the picture.
        if y != "damping" {
            asked["y"]["to"] = (0.5 * asked["y"]["to"].as_f64().unwrap()).into();
        }
        asked["x"]["to"] = (0.5 * asked["x"]["to"].as_f64().unwrap()).into();
        let (head, cells) = server.picture(&asked);
        assert_eq!((head["width"].as_u64(), head["height"].as_u64()), (Some(2), Some(2)), "{x} {y}");
        let found = f32::from_le_bytes(cells[4..8].try_into().unwrap());
        // A request about the machine of that cell alone.
        let mut alone = asked.clone();
        for (side, i) in [("x", 1.0), ("y", 0.0)] {
            let name = asked[side]["axis"].as_str().unwrap();
            alone["at"][name] = (share(i) * asked[side]["to"].as_f64().unwrap()).into();
        }
        let point = server.answer("point", &alone);
        let expected = point["machine"]["critical_damping"].as_f64().unwrap();
        assert!(head["label"].as_str().unwrap().ends_with(", N s/m"), "{head}");
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-6, "{x} {y}: {found} {expected}");
        assert!(point["machine"]["sensitivities"].as_array().unwrap().len() > 2, "{point}");
        // Of each kind of plane one, since curves take their time.
        if ![("mass", "damping"), ("belt_speed", "kinetic_friction")].contains(&(x, y)) {
            continue;
        }
        let curves = server.answer("curves", &asked);
        // Every plane has curves; on the grazing curve the damping is the critical one of that machine.
        let curves = curves["curves"].as_array().unwrap();
        assert!(!curves.is_empty(), "{x} {y}");
        let grazing = curves.iter().find(|curve| curve["name"] == "grazing_sliding");
        assert!(grazing.is_some() || y != "damping", "{x} {y}");
        if let Some(grazing) = grazing {
            let points = grazing["points"].as_array().unwrap();
            let middle = &points[points.len() / 2];
            let mut there = asked.clone();
            (there["at"][x], there["at"][y]) = (middle[0].clone(), middle[1].clone());
            let found = &server.ask("point", &there).1["machine"]["critical_damping"];
            let (found, damping) = (found.as_f64().unwrap(), there["at"]["damping"].as_f64().unwrap());
            assert!((found / damping - 1.0).abs() < 1e-5, "{x} {y}: {found} {damping}");
        }
        // The critical damping over the mass bends near 0; its curve has more points there.
        if x == "mass" && y == "damping" {
            let number = |of: &str| grazing.unwrap()[of].as_array().unwrap().len();
            assert!(number("points") > 36 && number("errors") == number("points"), "{grazing:?}");
            // The errors of the critical dampings, as shares of the picture: far below the width of a line.
            let errors = grazing.unwrap()["errors"].as_array().unwrap();
            let most = errors.iter().filter_map(Value::as_f64).fold(0.0, f64::max);
            assert!(most > 0.0 && most < 1e-4, "{most}");
        }
    }
    // The exported map has the axes of the picture.
    for (law, x, most) in [(&table, "belt_speed", 0.25), (&formula, "mass", 4.0)] {
        let mut asked = machine(x, "damping");
        (asked["law"], asked["show"]) = (law.clone(), "regime".into());
        asked["x"]["to"] = most.into();
        assert_map_is_the_picture(&server, &scratch, &asked);
    }
    let (status, answer) =
        server.ask("law", &json!({ "name": "expression", "phi": "mass*exp(-u)", "motion": "rotation" }));
    assert!(status == 422 && answer["place"] == json!([0, 4]), "{answer}");
    // The start of the page with such a machine, and its dimensionless law.
    scratch.file("mu.toml", "[friction]\nlaw = \"expression\"\nphi = \"0.2 + a*exp(-u/0.1)\"\n[machine]\nmass = 1.0\n\
        stiffness = 100.0\ndamping = { from = 0.0, to = 2.0, points = 3 }\nnormal_force = 10.0\na = 0.2\nbelt_speed = [0.1, 0.3]\n");
    let server = Server::start(&scratch, &["mu.toml"]);
    let start = server.begin()["start"].clone();
    assert_eq!(
        (&start["motion"], &start["law"]["phi"]),
        (&json!("translation"), &json!("0.2 + a*exp(-u/0.1)"))
    );
    assert_eq!((&start["at"]["a"], &start["at"]["stiffness"]), (&json!(0.2), &json!(100.0)));
    let ends: Vec<(&Value, &Value)> =
        start["axes"].as_array().unwrap().iter().map(|axis| (&axis["name"], &axis["to"])).collect();
    assert!(
        ends.contains(&(&json!("belt_speed"), &json!(0.3)))
            && ends.contains(&(&json!("damping"), &json!(2.0)))
    );
    assert_eq!(start["pinned"], false);
    // One belt speed and one damping are a working point; the plane reaches beyond the critical damping.
    let text = scratch.read("mu.toml").replace("{ from = 0.0, to = 2.0, points = 3 }", "0.1");
    scratch.file("one.toml", text.replace("[0.1, 0.3]", "0.05"));
    let one = Server::start(&scratch, &["one.toml"]);
    let at_one = one.begin()["start"].clone();
    let probed = scratch.run(&["probe", "--machine", "one.toml", "--json"]).ends_with(0).out;
    let critical =
        serde_json::from_str::<Value>(&probed).unwrap()["machine"]["critical_damping"].as_f64().unwrap();
    let most = at_one["most_damping"].as_f64().unwrap();
    assert!(
        at_one["pinned"] == true && critical > 0.1 && (most / (1.2 * critical) - 1.0).abs() < 1e-4,
        "{most}"
    );
    assert!(String::from_utf8(one.get(&one.path, "").2).unwrap().contains("id=\"answer\""));
    let place = json!({ "law": start["law"], "motion": "translation", "at": start["at"] });
    let plain = server.answer("dimensionless", &place);
    assert!((plain["at"]["V"].as_f64().unwrap() - 0.1 / 0.4).abs() < 1e-12, "{plain}");
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
