//! Tests of the server with requests of a browser on its own page, and of foreign pages.

use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode};
use axum::response::Response;
use serde_json::{Value, json};
use tower::ServiceExt;

use super::api::Hubs;
use super::folders::Folders;
use super::guard::{Names, OWN_HEADER};
use super::server::{Server, router};
use super::task::LogFiles;
use super::workspace::Workspace;
use fos_data::recording::{LoadOptions, write_columns};
use fos_diagnose::effects::Library;
use fos_export::Refusal;
use fos_simulate::{Simulation, simulate};

const PORT: u16 = 4180;

/// Workbench in a folder of its own.
struct Bench {
    folder: tempfile::TempDir,
    workspace: Arc<Workspace>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let readable = folder.path().join("logs");
        std::fs::create_dir_all(&readable).unwrap();
        let folders = Folders::new(&[readable], &folder.path().join("own")).unwrap();
        Self { folder, workspace: Arc::new(Workspace::new(folders, Library::built_in()).unwrap()) }
    }

    /// The same folders served by another server, as after a restart.
    fn restarted(self) -> Self {
        let readable = self.logs();
        let folders = Folders::new(&[readable], &self.folder.path().join("own")).unwrap();
        Self {
            folder: self.folder,
            workspace: Arc::new(Workspace::new(folders, Library::built_in()).unwrap()),
        }
    }

    fn stored(&self, id: u64) -> std::path::PathBuf {
        self.folder.path().join(format!("own/studies/{id}.json"))
    }

    fn logs(&self) -> std::path::PathBuf {
        self.folder.path().join("logs")
    }

    async fn ask(&self, request: Request<Body>) -> Response {
        let names = Names::of(IpAddr::V4(Ipv4Addr::LOCALHOST), PORT);
        router(Arc::clone(&self.workspace), names, Duration::from_secs(30)).oneshot(request).await.unwrap()
    }

    async fn get(&self, path: &str) -> (StatusCode, Value) {
        read(self.ask(page("GET", path).body(Body::empty()).unwrap()).await).await
    }

    async fn post(&self, path: &str, body: Value) -> (StatusCode, Value) {
        let request = page("POST", path).header("content-type", "application/json");
        read(self.ask(request.body(Body::from(body.to_string())).unwrap()).await).await
    }

    /// Waits, as a page does, until a study rests, and returns its state. A study must not rest between two tasks, or
    /// the results that tests need are missing.
    async fn settled(&self, id: u64) -> Value {
        let began = Instant::now();
        loop {
            let (_, state) = self.get(&format!("/api/studies/{id}")).await;
            if state["job"].is_null() {
                return state;
            }
            assert!(began.elapsed() < Duration::from_secs(300), "still working: {}", state["job"]);
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }
}

/// Request as the workbench's own page sends it.
fn page(method: &str, path: &str) -> axum::http::request::Builder {
    Request::builder()
        .method(method)
        .uri(path)
        .header("host", format!("127.0.0.1:{PORT}"))
        .header("sec-fetch-site", "same-origin")
        .header(OWN_HEADER, "1")
}

async fn read(response: Response) -> (StatusCode, Value) {
    let status = response.status();
    let bytes = to_bytes(response.into_body(), usize::MAX).await.unwrap();
    (status, serde_json::from_slice(&bytes).unwrap_or(Value::Null))
}

/// Short log of a simulated device.
fn write_log(path: &Path, minutes: f64) {
    let log = simulate(&Simulation { duration_s: 60.0 * minutes, ..Simulation::default() });
    let mut columns: Vec<(&str, &[f64])> =
        log.columns.iter().map(|(name, values)| (name.as_ref(), values.as_slice())).collect();
    // it changes, so that it is tested and drawn like every other channel
    let hostile: Vec<f64> = (0..columns[0].1.len()).map(|row| (row as f64 / 5000.0).sin()).collect();
    columns.push((HOSTILE, &hostile));
    write_columns(path, &columns).unwrap();
}

/// Name of a log or a column that would run as a script in a page that does not escape it.
const HOSTILE: &str = "<img src=x onerror=alert(1)>";

#[tokio::test]
async fn rejects_requests_of_foreign_pages() {
    let bench = Bench::new();
    let own = format!("127.0.0.1:{PORT}");
    let foreign: [&[(&str, &str)]; 8] = [
        // a foreign name that leads to this machine
        &[("host", "evil.example"), (OWN_HEADER, "1")],
        &[("host", "evil.example:4180"), ("origin", "http://evil.example:4180"), (OWN_HEADER, "1")],
        // another port of this machine
        &[("host", "127.0.0.1:80"), (OWN_HEADER, "1")],
        &[("host", &own), ("origin", "http://evil.example"), (OWN_HEADER, "1")],
        &[("host", &own), ("origin", "null"), (OWN_HEADER, "1")],
        &[("host", &own), ("sec-fetch-site", "cross-site"), (OWN_HEADER, "1")],
        // opened as a page of its own by a link from elsewhere, or from another port
        &[("host", &own), ("sec-fetch-site", "same-site"), ("sec-fetch-mode", "navigate"), (OWN_HEADER, "1")],
        &[
            ("host", &own),
            ("sec-fetch-site", "cross-site"),
            ("sec-fetch-mode", "navigate"),
            (OWN_HEADER, "1"),
        ],
    ];
    for headers in foreign {
        for (method, path) in [("GET", "/api/studies"), ("GET", "/api/logs"), ("POST", "/api/studies")] {
            let request = headers
                .iter()
                .fold(Request::builder().method(method).uri(path), |request, (name, value)| {
                    request.header(*name, *value)
                })
                .header("content-type", "application/json");
            let response = bench.ask(request.body(Body::from(r#"{"example": true}"#)).unwrap()).await;
            assert_eq!(response.status(), StatusCode::FORBIDDEN, "{method} {path} {headers:?}");
            assert!(response.headers().get("access-control-allow-origin").is_none());
        }
    }
    assert_eq!(bench.get("/api/studies").await, (StatusCode::OK, json!([])), "nothing was opened");
}

#[tokio::test]
async fn changing_requests_need_a_header_that_forms_cannot_send() {
    let bench = Bench::new();
    for (method, path) in
        [("POST", "/api/studies"), ("DELETE", "/api/studies/1"), ("POST", "/api/uploads?name=a.csv")]
    {
        let request = Request::builder().method(method).uri(path).header("host", format!("localhost:{PORT}"));
        let request = request.header("content-type", "application/json").body(Body::from("{}")).unwrap();
        assert_eq!(bench.ask(request).await.status(), StatusCode::FORBIDDEN, "{method} {path}");
    }
}

#[tokio::test]
async fn content_policy_allows_own_files_only() {
    let bench = Bench::new();
    let response = bench.ask(page("GET", "/").body(Body::empty()).unwrap()).await;
    assert_eq!(response.status(), StatusCode::OK);
    let policy = response.headers()["content-security-policy"].to_str().unwrap();
    assert!(policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"));
    assert_eq!(response.headers()["x-content-type-options"], "nosniff");
    for path in ["/../Cargo.toml", "/%2e%2e/%2e%2e/mod.rs", "/../../../../etc/passwd", "/none.js"] {
        let response = bench.ask(page("GET", path).body(Body::empty()).unwrap()).await;
        assert_eq!(response.status(), StatusCode::NOT_FOUND, "{path}");
    }
}

#[tokio::test]
async fn reads_logs_in_permitted_folders_only() {
    let bench = Bench::new();
    let outside = bench.folder.path().join("outside.csv");
    std::fs::write(&outside, "t_s,gx_rads\n0,1\n1,2\n").unwrap();
    let outside = outside.display().to_string();
    for path in [outside.as_str(), "/etc/passwd", "../../etc/passwd"] {
        for (at, body) in [
            ("/api/studies", json!({ "log": path })),
            ("/api/studies", json!({ "log": "logs/a.csv", "reference": path })),
            ("/api/preview", json!({ "path": path })),
        ] {
            let (status, answer) = bench.post(at, body).await;
            assert_eq!(status, StatusCode::FORBIDDEN, "{at} {path}");
            assert!(answer["error"].as_str().unwrap().contains("help:"), "{answer}");
        }
    }
}

#[tokio::test]
async fn rejects_oversized_requests_and_stores_uploads_in_their_folder() {
    let bench = Bench::new();
    let (status, _) = bench.post("/api/studies", json!({ "log": "x".repeat(100_000) })).await;
    assert_eq!(status, StatusCode::PAYLOAD_TOO_LARGE);
    let large = "t_s,gx_rads\n".to_owned() + &"0.005,1e-3\n".repeat(50_000);
    let request = page("POST", "/api/uploads?name=..%2F..%2Funit.csv").body(Body::from(large.clone()));
    let (status, answer) = read(bench.ask(request.unwrap()).await).await;
    assert_eq!(status, StatusCode::OK);
    let path = answer["path"].as_str().unwrap();
    assert_eq!(std::fs::read_to_string(path).unwrap(), large);
    assert!(Path::new(path).starts_with(bench.folder.path().join("own")));
}

#[tokio::test]
async fn concurrent_uploads_of_one_name_are_both_stored() {
    let bench = Bench::new();
    let upload = |pieces: tokio::sync::mpsc::Receiver<Result<String, std::io::Error>>| {
        let body = Body::from_stream(tokio_stream::wrappers::ReceiverStream::new(pieces));
        bench.ask(page("POST", "/api/uploads?name=unit.csv").body(body).unwrap())
    };
    let (first, first_pieces) = tokio::sync::mpsc::channel(4);
    let (second, second_pieces) = tokio::sync::mpsc::channel(4);
    let send = async {
        // each has begun before the other ends
        for part in ["1", "2", "3"] {
            first.send(Ok(format!("first {part}\n"))).await.unwrap();
            second.send(Ok(format!("second {part}\n"))).await.unwrap();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        drop((first, second));
    };
    let (first, second, ()) = tokio::join!(upload(first_pieces), upload(second_pieces), send);
    let mut paths = Vec::new();
    for (response, name) in [(first, "first"), (second, "second")] {
        let (status, answer) = read(response).await;
        assert_eq!(status, StatusCode::OK, "{answer}");
        let path = answer["path"].as_str().unwrap().to_owned();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{name} 1\n{name} 2\n{name} 3\n"));
        paths.push(path);
    }
    assert_ne!(paths[0], paths[1]);
    assert_eq!(std::fs::read_dir(Path::new(&paths[0]).parent().unwrap()).unwrap().count(), 2);
}

/// Regression: a browser that disconnected in the middle of a request kept its connection for ever.
#[tokio::test]
async fn stalled_requests_time_out() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    let folder = tempfile::tempdir().unwrap();
    let folders = Folders::new(&[], folder.path()).unwrap();
    let server =
        Server::bind(IpAddr::V4(Ipv4Addr::LOCALHOST), 0, folders, Library::built_in()).await.unwrap();
    let address = server.address();
    let running = tokio::spawn(server.run_with(Duration::from_millis(300), std::future::pending()));
    let head = format!("POST /api/uploads?name=a.csv HTTP/1.1\r\nhost: {address}\r\n{OWN_HEADER}: 1\r\n");
    for (begun, says) in [
        (String::new(), ""),
        (head.clone(), ""),
        (format!("{head}content-length: 100\r\n\r\nt_s,gx_rads\n"), "did not arrive whole"),
    ] {
        let mut connection = tokio::net::TcpStream::connect(address).await.unwrap();
        connection.write_all(begun.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        let closed = tokio::time::timeout(Duration::from_secs(20), connection.read_to_end(&mut answer)).await;
        assert!(closed.is_ok(), "still open after {begun:?}");
        let answer = String::from_utf8_lossy(&answer);
        assert!(answer.contains(says), "{begun:?}: {answer}");
    }
    // one that does is answered meanwhile, and after
    let mut connection = tokio::net::TcpStream::connect(address).await.unwrap();
    let whole = format!("GET / HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\r\n");
    connection.write_all(whole.as_bytes()).await.unwrap();
    let mut answer = String::new();
    connection.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    running.abort();
}

#[tokio::test]
async fn rejects_a_broken_log_and_keeps_other_studies() {
    let bench = Bench::new();
    let broken = bench.logs().join("broken.csv");
    std::fs::write(&broken, "t_s,gx_rads\n0,1\n0.005,oops\n0.010,2\n0.015,3\n").unwrap();
    let (status, answer) = bench.post("/api/preview", json!({ "path": broken.display().to_string() })).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    let message = answer["error"].as_str().unwrap();
    assert!(message.contains("broken.csv") && message.contains("3:2"), "file, line and cell: {message}");
    let (_, opened) = bench.post("/api/studies", json!({ "log": broken.display().to_string() })).await;
    let state = bench.settled(opened["id"].as_u64().unwrap()).await;
    assert_eq!(state["logs"], Value::Null);
    assert!(state["error"].as_str().unwrap().contains("broken.csv"), "{}", state["error"]);
    let (status, _) = bench.get("/api/studies/77").await;
    assert_eq!(status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn lists_previews_and_reads_logs_of_foreign_formats() {
    use fos_testkit::foreign::{Chunks, Flight, Rate, TEXTS, bag, dataflash, mcap, ulog};

    let bench = Bench::new();
    let flight = Flight::new(3000, 5000, 7);
    let text = |wanted: &str| TEXTS.iter().find(|(_, name, _)| *name == wanted).unwrap().2(&flight);
    let files = [
        ("LOG.BIN", dataflash(&flight, &[], true), "read as ArduPilot DataFlash"),
        ("a.mcap", mcap(&flight), "read as MCAP"),
        ("a.bag", bag(&flight, Chunks::Some), "read as ROS 1 bag"),
        ("android.zip", text("android.zip"), "read as Sensor Logger"),
        ("gnss_log.txt", text("gnss_log.txt"), "read as GnssLogger"),
        ("st.tsv", text("st.tsv"), "read as ST Unicleo"),
        ("flight.ulg", ulog(&flight, Rate::Decimated), "read as PX4 ULog: sensor_combined"),
    ];
    for (name, bytes, says) in files {
        std::fs::write(bench.logs().join(name), &bytes).unwrap();
        let (_, listed) = bench.get("/api/logs").await;
        assert!(listed.to_string().contains(name), "{listed}");
        // dropped on the page
        let request = page("POST", &format!("/api/uploads?name={name}")).body(Body::from(bytes));
        let (status, answer) = read(bench.ask(request.unwrap()).await).await;
        assert_eq!(status, StatusCode::OK, "{answer}");
        let path = answer["path"].as_str().unwrap();
        let (status, preview) = bench.post("/api/preview", json!({ "path": path })).await;
        assert_eq!(status, StatusCode::OK, "{preview}");
        let columns = preview["columns"].as_array().unwrap();
        for channel in ["t_s", "ax_mps2", "gz_rads"] {
            let found = columns.iter().find(|column| column["target"] == channel);
            // nothing is left to be chosen
            let found = found.unwrap_or_else(|| panic!("{name}: no {channel} in {preview}"));
            assert_eq!((&found["sure"], &found["spec"]), (&json!(true), &Value::Null), "{name}: {found}");
        }
        let (_, opened) = bench.post("/api/studies", json!({ "log": path })).await;
        let state = bench.settled(opened["id"].as_u64().unwrap()).await;
        assert_eq!(state["error"], Value::Null, "{name}: {}", state["error"]);
        let remarks = state["logs"]["log"]["quality"].to_string();
        assert!(remarks.contains(says), "{name}: {remarks}");
        if name == "flight.ulg" {
            assert!(
                remarks.contains("rows are the samples of") && remarks.contains("interpolated"),
                "{remarks}"
            );
        }
    }
}

#[tokio::test]
async fn turned_log_has_a_certificate() {
    let bench = Bench::new();
    std::fs::write(bench.logs().join("turned.csv"), fos_testkit::turned::turned_log()).unwrap();
    let (_, opened) = bench.post("/api/studies", json!({ "log": bench.logs().join("turned.csv") })).await;
    let id = opened["id"].as_u64().unwrap();
    let state = bench.settled(id).await;
    assert_eq!(state["is_turned"], json!(true), "{state}");
    let response =
        bench.ask(page("GET", &format!("/api/studies/{id}/certificate")).body(Body::empty()).unwrap()).await;
    assert_eq!(response.status(), StatusCode::OK);
    let bytes = to_bytes(response.into_body(), 1 << 20).await.unwrap();
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    assert!(text.contains("Calibration certificate") && text.contains("Orientations"), "{text}");
}

#[test]
fn lists_files_that_may_be_logs() {
    let page = include_str!("../page/openpanel.js");
    let accepted = format!("accept: \"{}\"", fos_data::recording::LOG_ENDINGS.join(","));
    assert!(page.contains(&accepted), "{accepted}");
}

#[tokio::test]
async fn reads_fits_compares_diagnoses_and_exports_a_log() {
    let bench = Bench::new();
    let log = bench.logs().join(format!("{HOSTILE}.csv"));
    write_log(&log, 2.0);
    let (status, opened) = bench.post("/api/studies", json!({ "log": log.display().to_string() })).await;
    assert_eq!(status, StatusCode::OK);
    let id = opened["id"].as_u64().unwrap();
    let state = bench.settled(id).await;
    assert_eq!(state["error"], Value::Null, "{}", state["error"]);
    assert_eq!(state["axis"], "gx_rads");
    assert!(state["axes"].as_array().unwrap().iter().all(|axis| axis["model"]["terms"].as_u64() > Some(0)));
    let gyro = state["axes"].as_array().unwrap().iter().find(|axis| axis["column"] == "gx_rads").unwrap();
    assert!(gyro["comparison"]["errors"].as_array().unwrap().len() > 1);
    assert!(gyro["diagnosis"]["verdict"].is_string());
    // the other axes in the background, and the study is as the worst of them
    let outcomes = state["axes"].as_array().unwrap().iter().map(|axis| &axis["standing"]["outcome"]);
    assert!(outcomes.clone().all(Value::is_string), "{outcomes:?}");
    assert!(outcomes.clone().any(|outcome| *outcome == state["outcome"]), "{}", state["outcome"]);
    assert_eq!(gyro["units"]["noise"][0]["field"]["label"], "°/√h");
    let at = |what: &str| format!("/api/studies/{id}/{what}");
    let (status, series) = bench.get(&at("series?axis=gx_rads&view=coast&from=0&to=120&width=500")).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(series["time_s"].as_array().unwrap().len(), 500);
    assert!(series["left"]["low"].as_array().unwrap().iter().any(Value::is_number));
    assert_eq!(series["beside"][0]["column"], "temp_c", "under the same time axis");
    assert_eq!(series["beside"][0]["values"]["low"].as_array().unwrap().len(), 500);
    let (status, noise) = bench.get(&at("noise?axis=gx_rads&units=field")).await;
    assert_eq!(status, StatusCode::OK, "{noise}");
    assert!(noise.to_string().contains("°/√h"), "N, B and K in field units");
    let (status, strapdown) = bench.get(&at("strapdown")).await;
    assert_eq!(status, StatusCode::OK, "{strapdown}");
    for of_model in [0, 1] {
        let after_10_s = &strapdown[1][of_model];
        assert!(after_10_s["heading_rad"].is_object() && after_10_s["position_m"].is_object(), "{strapdown}");
    }
    let drawn = page("POST", "/api/draw").header("content-type", "application/json");
    let response = bench.ask(drawn.body(Body::from(noise.to_string())).unwrap()).await;
    assert_eq!(
        (response.status(), &response.headers()["content-type"]),
        (StatusCode::OK, &"image/svg+xml".parse().unwrap())
    );
    for stretch in ["", "&from=60&to=90"] {
        let (status, figures) = bench.get(&at(&format!("figures?axis=gx_rads{stretch}"))).await;
        assert_eq!(status, StatusCode::OK, "{figures}");
        let names: Vec<&str> =
            figures.as_array().unwrap().iter().map(|figure| figure["name"].as_str().unwrap()).collect();
        for name in ["residual", "spectrum", "autocorrelation", "allan", "against:temp_c"] {
            assert!(names.contains(&name), "{name} of {stretch:?}: {names:?}");
        }
    }
    for format in ["image", "rust", "c", "study", "report.html", "report.md"] {
        let response =
            bench.ask(page("GET", &at(&format!("export/{format}"))).body(Body::empty()).unwrap()).await;
        if response.status() != StatusCode::OK {
            panic!("{format}: {:?}", read(response).await);
        }
        assert!(response.headers()["content-disposition"].to_str().unwrap().starts_with("attachment"));
        let content = to_bytes(response.into_body(), usize::MAX).await.unwrap();
        let text = String::from_utf8_lossy(&content);
        assert!(!content.is_empty());
        if format.starts_with("report") {
            assert!(text.contains("alert(1)"), "the log's name is in {format}");
            assert!(text.contains("Six axes without aiding"), "{format}");
        }
        if format == "report.md" {
            let (before, rest) = text.split_once("```sh").unwrap();
            let (_, after) = rest.split_once("```").unwrap();
            // every other piece between backticks is code, where nothing is a tag
            let prose =
                [before, after].iter().flat_map(|part| part.split('`').step_by(2)).collect::<String>();
            assert_eq!(prose.matches('<').count(), prose.matches("\\<").count(), "{prose}");
        }
        if format == "report.html" {
            assert!(!text.contains("<img"), "and stays text");
            assert!(text.contains("default-src 'none'; style-src 'unsafe-inline'"));
            for loads in ["src=\"", "@import", "url(", "<link", "<script"] {
                assert!(!text.contains(loads), "{loads} would load something");
            }
        }
    }
    assert_eq!(
        bench.get(&at("hubs")).await,
        (StatusCode::OK, json!({ "refusal": null })),
        "all hubs take it"
    );
    let file = bench.workspace.study(id).unwrap().file().unwrap();
    let mut large = file.model;
    let term = large.axes[0].stochastic[0].clone();
    large.axes[0].stochastic.extend(vec![term; 128]);
    let said = Hubs::of(&large).refusal.expect("too large for fos.h");
    assert_eq!(said, Refusal::of(&large).unwrap().to_string(), "as `export` says it");
    let (status, replay) = bench.get(&at("replay")).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(replay["summary"]["axes"].as_array().unwrap().len(), 6);
    let (_, commands) = (status, &state["commands"]);
    assert!(commands[0].as_str().unwrap().starts_with("fos fit "), "{commands}");
}

/// Times of the knocks on the device, s: one among the fitted rows, one among the evaluated rows.
const KNOCKS_S: [f64; 2] = [30.0, 105.0];

/// A log of three axes, two minutes at rest, with knocks.
fn write_knocked_log(path: &Path) {
    let log = simulate(&Simulation { duration_s: 120.0, motion: false, ..Simulation::default() });
    let mut columns = log.columns;
    columns.retain(|(name, _)| ["t_s", "ax_mps2", "gx_rads", "gy_rads"].contains(&name.as_str()));
    let times = columns[0].1.clone();
    for (name, values) in columns.iter_mut().filter(|(name, _)| name.starts_with(['a', 'g'])) {
        let size = if name.starts_with('a') { 2.0 } else { 0.1 };
        for (time, value) in times.iter().zip(values) {
            let since =
                KNOCKS_S.map(|knock| time - knock).into_iter().find(|since| (0.0..0.3).contains(since));
            *value += since.map_or(0.0, |since| size * (300.0 * since).sin());
        }
    }
    let columns: Vec<(&str, &[f64])> =
        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    write_columns(path, &columns).unwrap();
}

/// Text for detected motion in figures and reports.
const MOVED: &str = "excluded: detected motion";

#[tokio::test]
async fn detected_motion_is_reported_and_can_be_kept_or_excluded() {
    let bench = Bench::new();
    let log = bench.logs().join("knocked.parquet");
    write_knocked_log(&log);
    let (_, opened) = bench.post("/api/studies", json!({ "log": log.display().to_string() })).await;
    let id = opened["id"].as_u64().unwrap();
    let at = |what: &str| format!("/api/studies/{id}/{what}");
    let report = async || {
        let response = bench.ask(page("GET", &at("export/report.html")).body(Body::empty()).unwrap()).await;
        let content = to_bytes(response.into_body(), usize::MAX).await.unwrap();
        String::from_utf8(content.to_vec()).unwrap()
    };
    bench.settled(id).await;
    let (status, _) = bench.post(&at("axis"), json!({ "axis": "gy_rads" })).await;
    assert_eq!(status, StatusCode::OK);
    let left = bench.settled(id).await;
    assert_eq!(left["error"], Value::Null, "{}", left["error"]);
    let ranges = left["logs"]["log"]["moved"]["ranges"].as_array().unwrap();
    assert_eq!(ranges.len(), KNOCKS_S.len(), "{ranges:?}");
    for (range, knock) in ranges.iter().zip(KNOCKS_S) {
        let (from, to) = (range["from"].as_f64().unwrap(), range["to"].as_f64().unwrap());
        assert!(from <= knock && to >= knock + 0.3 && to - from < 3.0, "{range}");
        assert!(range["says"].as_str().unwrap().starts_with("knock at "), "{range}");
    }
    assert_eq!(left["keeps_moved"], false);
    assert!(report().await.contains(MOVED), "a figure of the report says so");

    let (status, answer) = bench.post(&at("moved"), json!({ "keep": true })).await;
    assert_eq!(status, StatusCode::OK, "{answer}");
    let kept = bench.settled(id).await;
    assert_eq!((&kept["keeps_moved"], &kept["error"]), (&json!(true), &Value::Null));
    assert_eq!(kept["logs"]["log"]["moved"]["ranges"], json!([]));
    assert_eq!(kept["axis"], "gy_rads", "the axis that was looked at");
    assert!(!report().await.contains(MOVED));
    let axis = |state: &Value| {
        let axes = state["axes"].as_array().unwrap();
        axes.iter().find(|axis| axis["column"] == "gy_rads").unwrap().clone()
    };
    assert!(axis(&kept)["diagnosis"].is_object());
    assert_ne!(axis(&kept)["model"], axis(&left)["model"], "fitted to the knock too");
    let commands = kept["commands"].as_array().unwrap();
    let reads = commands.iter().filter(|line| line.as_str().unwrap().contains(".parquet"));
    assert!(reads.clone().count() >= 4);
    assert!(reads.clone().all(|line| line.as_str().unwrap().contains(" --keep-moved")), "{commands:?}");
    let (_, file) =
        read(bench.ask(page("GET", &at("export/study")).body(Body::empty()).unwrap()).await).await;
    assert_eq!(file["data"]["keep_moved"], true, "what is exported is read again in the same way");

    let (status, _) = bench.post(&at("moved"), json!({ "keep": false })).await;
    assert_eq!(status, StatusCode::OK);
    let again = bench.settled(id).await;
    assert_eq!(again["logs"], left["logs"]);
    assert_eq!(axis(&again), axis(&left), "all is as it was, to the last digit");
    assert!(!again["commands"].to_string().contains("--keep-moved"), "{}", again["commands"]);
    let (status, _) = bench.post(&at("moved"), json!({})).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "which way?");
    let (status, _) = bench.post("/api/studies/77/moved", json!({ "keep": true })).await;
    assert_eq!(status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn cancelled_job_keeps_earlier_results() {
    let bench = Bench::new();
    let log = bench.logs().join("unit.csv");
    write_log(&log, 2.0);
    let (_, opened) = bench.post("/api/studies", json!({ "log": log.display().to_string() })).await;
    let id = opened["id"].as_u64().unwrap();
    let began = Instant::now();
    loop {
        let (_, state) = bench.get(&format!("/api/studies/{id}")).await;
        if state["logs"].is_object() {
            break;
        }
        assert!(began.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    bench.post(&format!("/api/studies/{id}/cancel"), json!({})).await;
    let state = bench.settled(id).await;
    assert!(state["logs"].is_object(), "what was read is still there");
    assert!(state["error"].as_str().unwrap().contains("stopped"), "{}", state["error"]);
    assert!(state["axes"].as_array().unwrap().iter().any(|axis| axis["model"].is_null()));
    // opening an axis resumes where it stopped
    bench.post(&format!("/api/studies/{id}/axis"), json!({ "axis": "gx_rads" })).await;
    let state = bench.settled(id).await;
    assert_eq!(state["error"], Value::Null, "{}", state["error"]);
    let axes = state["axes"].as_array().unwrap();
    assert!(axes.iter().find(|axis| axis["column"] == "gx_rads").unwrap()["diagnosis"].is_object());
    assert!(axes.iter().all(|axis| axis["model"].is_object()), "and so do the others, in the background");
}

#[tokio::test]
async fn reads_populations_from_permitted_folders_with_their_rows() {
    let bench = Bench::new();
    let asked = fos_fleet::Asked { regressors: Vec::new(), diagnosed: false, read: Default::default() };
    let fleet = json!(fos_fleet::Fleet::of(&[], &asked, &Library::built_in(), "a test"));
    let within = bench.logs().join("population.json");
    let (elsewhere, path) = (bench.folder.path().join("population.json"), within.display().to_string());
    for place in [&within, &elsewhere] {
        std::fs::write(place, fleet.to_string()).unwrap();
        std::fs::write(fos_fleet::rows_beside(place), "").unwrap();
    }
    let (status, listed) = bench.get("/api/populations").await;
    assert_eq!((status, listed.as_array().map(Vec::len)), (StatusCode::OK, Some(1)), "{listed}");
    let (status, page) = bench.get(&format!("/api/population?path={path}")).await;
    assert_eq!((status, &page["units"]), (StatusCode::OK, &json!([])), "{page}");
    let (status, _) = bench.get(&format!("/api/population/unit?path={path}&part=&unit=none")).await;
    assert_eq!(status, StatusCode::NOT_FOUND);
    let (status, _) = bench.get(&format!("/api/population?path={}", elsewhere.display())).await;
    assert_eq!(status, StatusCode::FORBIDDEN);
    // rows to which a link leads out of the folder
    #[cfg(unix)]
    {
        std::fs::remove_file(fos_fleet::rows_beside(&within)).unwrap();
        std::os::unix::fs::symlink(fos_fleet::rows_beside(&elsewhere), fos_fleet::rows_beside(&within))
            .unwrap();
        let (status, said) = bench.get(&format!("/api/population?path={path}")).await;
        assert_eq!(status, StatusCode::FORBIDDEN, "{said}");
    }
}

/// State without its revision and the values that depend on the clock.
fn without_revision(mut state: Value) -> Value {
    state["revision"] = Value::Null;
    state
}

#[tokio::test]
async fn studies_survive_a_server_restart() {
    let bench = Bench::new();
    let log = bench.logs().join("device.csv");
    write_log(&log, 1.0);
    let asked = json!({ "log": log.display().to_string(), "columns": ["!temp_c"] });
    let (status, opened) = bench.post("/api/studies", asked).await;
    assert_eq!(status, StatusCode::OK, "{opened}");
    let id = opened["id"].as_u64().unwrap();
    let before = bench.settled(id).await;
    assert_eq!(before["error"], Value::Null, "{}", before["error"]);
    let at = format!("/api/studies/{id}/export/study");
    let (_, exported) = read(bench.ask(page("GET", &at).body(Body::empty()).unwrap()).await).await;

    let bench = bench.restarted();
    let (_, listed) = bench.get("/api/studies").await;
    assert_eq!((&listed[0]["id"], &listed[0]["name"]), (&json!(id), &json!("device.csv")));
    assert_eq!(listed[0]["working"], false, "its logs are read once it is shown");
    let after = bench.settled(id).await;
    assert_eq!(after["files"]["read"]["columns"], json!(["!temp_c"]));
    assert_eq!(without_revision(after), without_revision(before), "to the last digit");
    let (_, again) = read(bench.ask(page("GET", &at).body(Body::empty()).unwrap()).await).await;
    assert_eq!(again, exported);

    let (status, answer) =
        read(bench.ask(page("DELETE", &format!("/api/studies/{id}")).body(Body::empty()).unwrap()).await)
            .await;
    assert_eq!(status, StatusCode::OK, "{answer}");
    assert!(!bench.stored(id).exists(), "a closed study does not come back");
    assert_eq!(bench.restarted().get("/api/studies").await.1, json!([]));
}

#[tokio::test]
async fn unusable_stored_study_shows_the_reason() {
    let bench = Bench::new();
    let log = bench.logs().join("device.csv");
    write_log(&log, 1.0);
    let (_, opened) = bench.post("/api/studies", json!({ "log": log.display().to_string() })).await;
    let id = opened["id"].as_u64().unwrap();
    bench.settled(id).await;
    let whole = std::fs::read_to_string(bench.stored(id)).unwrap();
    let mut elsewhere: Value = serde_json::from_str(&whole).unwrap();
    for refinement in elsewhere["refinements"].as_array_mut().unwrap() {
        refinement["logs"]["log"]["path"] = json!("/etc/passwd");
    }
    let unusable = [
        (2, whole[..whole.len() / 2].to_owned(), "not a study"),
        (3, "\u{0}".repeat(100), "not a study"),
        (4, elsewhere.to_string(), "may be read"),
    ];
    for (id, content, _) in &unusable {
        std::fs::write(bench.stored(*id), content).unwrap();
    }
    std::fs::write(bench.stored(5).with_extension("txt"), "not a study").unwrap();

    let bench = bench.restarted();
    for (id, _, reason) in unusable {
        let (status, state) = bench.get(&format!("/api/studies/{id}")).await;
        assert_eq!((status, &state["job"]), (StatusCode::OK, &Value::Null), "{state}");
        let error = state["error"].as_str().unwrap();
        assert!(error.contains(reason) && error.contains("\nhelp: "), "{error}");
    }
    assert_eq!(bench.get("/api/studies/5").await.0, StatusCode::NOT_FOUND);
    assert_eq!(bench.settled(id).await["error"], Value::Null, "the whole one opens");
    let (_, opened) = bench.post("/api/studies", json!({ "log": log.display().to_string() })).await;
    assert_eq!(opened["id"], 5, "no file is overwritten");

    // another log in the place of the one that the study names
    write_log(&log, 1.5);
    let bench = bench.restarted();
    let error = bench.settled(id).await["error"].as_str().unwrap().to_owned();
    assert!(error.contains("device.csv: changed since the study was stored\nhelp: "), "{error}");
}

#[tokio::test]
async fn opening_the_same_log_again_resumes_its_study() {
    let bench = Bench::new();
    let log = bench.logs().join("device.csv");
    write_log(&log, 1.0);
    let field = log.display().to_string();
    let (_, opened) = bench.post("/api/studies", json!({ "log": field })).await;
    bench.settled(opened["id"].as_u64().unwrap()).await;
    let bench = bench.restarted();
    let files = |keep_moved| LogFiles {
        log: field.clone(),
        reference: None,
        evaluation: None,
        read: LoadOptions { keep_moved, ..LoadOptions::default() },
    };
    assert_eq!(bench.workspace.open_or_resume(files(true)), Ok(2), "read in another way");
    assert_eq!(bench.workspace.open_or_resume(files(false)), Ok(3));
    let (_, listed) = bench.get("/api/studies").await;
    let ids: Vec<&Value> = listed.as_array().unwrap().iter().map(|study| &study["id"]).collect();
    assert_eq!(ids, [2, 3], "the study moved to the end of the list");
    assert!(bench.stored(3).exists() && !bench.stored(1).exists());
}

#[tokio::test]
async fn column_corrections_apply_after_reading() {
    let bench = Bench::new();
    let log = bench.logs().join("counts.csv");
    let rows: String = (0..24_000)
        .map(|row| {
            format!("{},{},{}\n", 0.005 * f64::from(row), 32_786 + (row * row) % 7, 32_768 + (row * 31) % 11)
        })
        .collect();
    std::fs::write(&log, format!("t_s,ax_mps2,gx_rads\n{rows}")).unwrap();
    let path = log.display().to_string();
    let (_, opened) = bench.post("/api/studies", json!({ "log": path })).await;
    let id = opened["id"].as_u64().unwrap();
    let counts = bench.settled(id).await;
    assert_eq!(counts["files"]["read"]["columns"], json!([]));
    let columns = ["ax_mps2=ax_mps2:-32768/2048:g", "gx_rads=gx_rads:-32768*0.061:mdps"];
    let (status, preview) = bench.post("/api/preview", json!({ "path": path, "columns": columns })).await;
    assert_eq!(status, StatusCode::OK, "{preview}");
    let (status, answer) =
        bench.post(&format!("/api/studies/{id}/logs"), json!({ "log": path, "columns": columns })).await;
    assert_eq!((status, &answer["id"]), (StatusCode::OK, &json!(id)), "{answer}");
    let corrected = bench.settled(id).await;
    assert_eq!(corrected["error"], Value::Null, "{}", corrected["error"]);
    assert_eq!(corrected["files"]["read"]["columns"], json!(columns));
    assert!(corrected["commands"].to_string().contains("-32768/2048:g"), "{}", corrected["commands"]);
    let slow = |state: &Value| {
        let axes = state["axes"].as_array().unwrap();
        axes.iter().find(|axis| axis["column"] == "gx_rads").unwrap()["slow_error"][0].as_f64().unwrap()
    };
    let ratio = slow(&corrected) / slow(&counts);
    let mdps = 0.061e-3 * std::f64::consts::PI / 180.0;
    assert!((ratio / mdps - 1.0).abs() < 1e-6, "{ratio}");

    let wrong = json!({ "log": path, "columns": ["gx_rads=none"] });
    let (status, _) = bench.post(&format!("/api/studies/{id}/logs"), wrong).await;
    assert_eq!(status, StatusCode::OK);
    let kept = bench.settled(id).await;
    assert!(kept["error"].as_str().unwrap().contains("none"), "{}", kept["error"]);
    assert_eq!(slow(&kept), slow(&corrected), "the present study stays");
    let (status, _) = bench.post(&format!("/api/studies/{id}/logs"), json!({ "log": "/etc/passwd" })).await;
    assert_eq!(status, StatusCode::FORBIDDEN);
}
