//! The server of the page: who may ask it, what it refuses, and that it goes on.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::process::Command;
use std::time::Duration;

use serde_json::{Value, json};
use slipmap_numbers::random::Random;

use super::{Server, place, plane};
use crate::command::Scratch;

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
