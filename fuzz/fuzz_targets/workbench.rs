//! Any requests to the workbench over the wire, with a study open: each is answered, and never with an error of the
//! program.
//!
//! Requests are separated by zero bytes: method and path, a line feed, the body. One that begins with `!` has its own
//! raw headers up to an empty line; without those of a page of the workbench it must be refused.
#![no_main]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

use fos_fuzz::log;
use fos_diagnose::effects::Library;
use fos_data::recording::write_columns;
use fos_simulate::{Simulation, simulate};
use fos_workbench::{Folders, Server};
use libfuzzer_sys::fuzz_target;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::runtime::Runtime;

/// A workbench that listens for the lifetime of the program.
struct Bench {
    address: SocketAddr,
    log: String,
    _folder: TempDir,
    _runtime: Runtime,
}

static BENCH: LazyLock<Bench> = LazyLock::new(|| {
    let folder = log::folder();
    let logs = folder.path().join("logs");
    std::fs::create_dir(&logs).expect("a folder");
    let path = logs.join("log.parquet");
    // Short and with one axis, because the answers are fuzzed and every input needs a fit.
    let simulated = simulate(&Simulation { duration_s: 20.0, ..Simulation::default() });
    let columns =
        simulated.columns.iter().filter(|(name, _)| ["t_s", "gx_rads", "temp_c"].contains(&name.as_ref()));
    let columns: Vec<(&str, &[f64])> =
        columns.map(|(name, values)| (name.as_ref(), values.as_slice())).collect();
    write_columns(&path, &columns).expect("a log");
    let folders = Folders::new(&[logs], &folder.path().join("own")).expect("folders");
    let runtime = Runtime::new().expect("a runtime");
    let loopback = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let server = runtime.block_on(Server::bind(loopback, 0, folders, Library::built_in())).expect("a port");
    let address = server.address();
    runtime.spawn(server.run(std::future::pending()));
    Bench { address, log: path.display().to_string(), _folder: folder, _runtime: runtime }
});

fuzz_target!(init: log::init(), |bytes: &[u8]| {
    let study = format!("/studies/{}", opened());
    for request in bytes.split(|&byte| byte == 0).take(8) {
        if let Some(foreign) = request.strip_prefix(b"!") {
            from_elsewhere(foreign);
            continue;
        }
        let (head, body) =
            request.split_at(request.iter().position(|&byte| byte == b'\n').unwrap_or(request.len()));
        let body = body.strip_prefix(b"\n").unwrap_or(body);
        let head = String::from_utf8_lossy(head);
        let (method, path) = head.split_once(' ').unwrap_or(("GET", &head));
        // A stream of events never ends.
        if path.contains("events") {
            continue;
        }
        let body = String::from_utf8_lossy(body).replace("LOG", &BENCH.log);
        let (status, answer) = ask(method, &path.replace("/studies/1", &study), body.as_bytes());
        assert_ne!(status, 500, "{head}: {answer}");
        // Every valid request has an answer.
        let is_token = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_alphanumeric());
        let is_plain = |path: &str| path.starts_with('/') && path.bytes().all(|byte| byte.is_ascii_graphic());
        assert!(status != 0 || !(is_token(method) && is_plain(path)), "{head}: no answer");
    }
});

/// A request with any headers: refused, unless they are those of a page of the workbench.
fn from_elsewhere(request: &[u8]) {
    let text = String::from_utf8_lossy(request);
    let (head, body) = text.split_once("\n\n").unwrap_or((&text, ""));
    let mut lines = head.lines();
    let line = lines.next().unwrap_or_default();
    let headers: Vec<&str> = lines.collect();
    let raw = format!(
        "{line} HTTP/1.1\r\nconnection: close\r\ncontent-length: {}\r\n{}\r\n\r\n",
        body.len(),
        headers.join("\r\n")
    );
    // Headers may keep the connection open.
    let (status, answer) = exchange(raw.as_bytes(), body.as_bytes(), Duration::from_secs(2));
    assert_ne!(status, 500, "{head}: {answer}");
    // The port in the host header cannot be guessed from this end.
    let of_here = headers.iter().any(|header| header.contains(&BENCH.address.port().to_string()));
    assert!(of_here || !(200..300).contains(&status), "{head}: {status} {answer}");
}

/// Number and revision of the study opened last.
static OPENED: Mutex<Option<(u64, u64)>> = Mutex::new(None);

/// Number of the only study, at rest: that of the previous input if it is unchanged. The state is then independent of
/// earlier inputs, except for uploaded files.
fn opened() -> u64 {
    let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    let studies = answer("GET", "/api/studies", b"");
    let studies = studies.as_array().expect("a list");
    if let ([only], Some((id, revision))) = (&studies[..], *opened)
        && only["id"] == id
        && revision_of(id) == Some(revision)
    {
        return id;
    }
    for study in studies {
        ask("DELETE", &format!("/api/studies/{}", study["id"]), b"");
    }
    let id = answer("POST", "/api/studies", json!({ "log": BENCH.log }).to_string().as_bytes());
    let id = id["id"].as_u64().unwrap_or_else(|| panic!("not opened: {id}"));
    let revision = loop {
        if let Some(revision) = revision_of(id) {
            break revision;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    *opened = Some((id, revision));
    id
}

/// Revision of a study; none during a computation.
fn revision_of(id: u64) -> Option<u64> {
    let state = answer("GET", &format!("/api/studies/{id}"), b"");
    state["job"].is_null().then(|| state["revision"].as_u64()).flatten()
}

/// Answer to a valid request.
fn answer(method: &str, path: &str, body: &[u8]) -> Value {
    serde_json::from_str(&ask(method, path, body).1).expect("JSON")
}

/// Status and body of the answer; status 0 if the server rejected the bytes and closed the connection.
fn ask(method: &str, path: &str, body: &[u8]) -> (u16, String) {
    let head = format!(
        "{method} {path} HTTP/1.1\r\nhost: {}\r\nx-fos-workbench: 1\r\ncontent-type: application/json\r\nconnection: close\r\ncontent-length: {}\r\n\r\n",
        BENCH.address,
        body.len()
    );
    // A computation may take a while.
    exchange(head.as_bytes(), body, Duration::from_secs(60))
}

/// Sends a raw request and returns the answer received within `limit`.
fn exchange(head: &[u8], body: &[u8], limit: Duration) -> (u16, String) {
    let mut stream = TcpStream::connect(BENCH.address).expect("the server listens");
    stream.set_read_timeout(Some(limit)).expect("a limit");
    // It may close before it has read everything.
    let _ = stream.write_all(head).and_then(|()| stream.write_all(body));
    let mut answer = BufReader::new(stream);
    let mut line = String::new();
    if answer.read_line(&mut line).is_err() || line.is_empty() {
        return (0, line);
    }
    let status = line.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    let mut rest = Vec::new();
    let _ = answer.read_to_end(&mut rest);
    let rest = String::from_utf8_lossy(&rest);
    let body = rest.split_once("\r\n\r\n").map_or("", |(_, body)| body);
    (status, body.to_owned())
}
