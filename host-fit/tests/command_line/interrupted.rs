//! A recording interrupted in the middle of a stream: the samples received so far are recoverable.
#![cfg(unix)]

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::session::{done, fails};
use fos_core::Validity;
use fos_data::recording::{LoadOptions, load};
use fos_embedded::telemetry::{Frame, SampleFrame, StartFrame, VERSION, encode};

/// Number of samples sent before the end.
const SAMPLES: u32 = 1500;

/// A stream of [`SAMPLES`] samples, and the begin of one more.
fn telemetry() -> Vec<u8> {
    let mut buffer = [0; 128];
    let start = StartFrame { version: VERSION, period_s: 0.005, axes: "gx_rads", quantities: "temp_c" };
    let mut stream = encode(&Frame::Start(start), &mut buffer).expect("fits").to_vec();
    for tick in 0..=SAMPLES {
        let sample = SampleFrame {
            tick,
            still: true,
            measured: &[tick as f32][..],
            quantities: &[21.5],
            innovations: &[0.1],
            validity: &[Validity::VALID][..],
        };
        let frame: Frame<&str, _, _> = Frame::Sample(sample);
        stream.extend(encode(&frame, &mut buffer).expect("fits").iter());
    }
    stream.truncate(stream.len() - 7);
    stream
}

fn record(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_fos"))
        .current_dir(folder)
        .args([&["record"], arguments].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts")
}

fn fifo(folder: &Path) {
    let made = Command::new("mkfifo").arg(folder.join("port")).status().expect("mkfifo");
    assert!(made.success());
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    assert!(sent.expect("kill").success());
}

/// Waits until a condition holds, or for at most `longest`.
fn wait_until(holds: impl Fn() -> bool, longest: Duration) {
    let began = Instant::now();
    while !holds() && began.elapsed() < longest {
        sleep(Duration::from_millis(5));
    }
}

/// Lets `recorder` read the stream from a FIFO and sends it a signal while the stream is open; returns its exit code.
fn interrupted(folder: &Path, mut recorder: Child, signal: &str) -> Option<i32> {
    let stream = telemetry();
    // opens when the recorder has opened it too
    let mut port = File::options().write(true).open(folder.join("port")).expect("a FIFO");
    for piece in stream.chunks(97) {
        port.write_all(piece).expect("read");
    }
    let kept = folder.join("log.csv.telemetry");
    let holds_all = || fs::metadata(&kept).is_ok_and(|kept| kept.len() == stream.len() as u64);
    wait_until(holds_all, Duration::from_secs(3));
    send(&recorder, signal);
    let began = Instant::now();
    let ended = loop {
        match recorder.try_wait().expect("asked") {
            Some(status) => break status,
            None => assert!(began.elapsed() < Duration::from_secs(60), "{signal}: it still runs"),
        }
        sleep(Duration::from_millis(5));
    };
    drop(port);
    ended.code()
}

/// Returns true if these tests, and their child processes, were started so that they outlive their terminal.
fn is_hangup_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.is_some_and(|mask| mask.trim().ends_with(['1', '3', '5', '7', '9', 'b', 'd', 'f']))
}

/// Number of samples that a user recovers: from the log, else from the stored telemetry.
fn recovered(folder: &Path) -> u32 {
    let log = folder.join("log.csv");
    if !log.exists() && folder.join("log.csv.telemetry").exists() {
        done(folder, &["record", "log.csv.telemetry", "-o", "log.csv"]);
    }
    load(&log, &LoadOptions::default()).map_or(0, |log| log.n_rows() as u32)
}

#[test]
fn interrupted_recording_keeps_received_samples() {
    let mut table = Vec::new();
    for (signal, code, kept) in
        [("KILL", None, true), ("TERM", Some(0), false), ("HUP", Some(0), false), ("INT", Some(0), false)]
    {
        if signal == "HUP" && is_hangup_ignored() {
            println!("skipped: HUP, as these tests were started with nohup");
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        fifo(folder);
        let ended = interrupted(folder, record(folder, &["port", "-o", "log.csv"]), signal);
        assert_eq!(ended, code, "{signal}");
        assert_eq!(
            folder.join("log.csv.telemetry").exists(),
            kept,
            "{signal}: kept until the log is written"
        );
        let samples = recovered(folder);
        assert_eq!(samples, SAMPLES, "{signal}");
        table.push(format!("{signal} {samples}"));
    }

    // negative control: without the stored telemetry the samples are lost
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fifo(folder);
    interrupted(folder, record(folder, &["port", "-o", "log.csv"]), "KILL");
    fs::remove_file(folder.join("log.csv.telemetry")).expect("it was there");
    let taken_away = recovered(folder);
    // and so they are with a recorder that writes at the end
    let at_the_end = Command::new("sh")
        .args(["-c", "all=$(od -An -v -tx1 port); echo \"$all\" > log.csv.telemetry"])
        .current_dir(folder)
        .spawn()
        .expect("a shell");
    interrupted(folder, at_the_end, "KILL");
    let at_the_end = recovered(folder);
    assert_eq!((taken_away, at_the_end), (0, 0), "the loss is noticed");
    println!(
        "attack: interrupted | {SAMPLES} samples arrive through a FIFO before `record` receives a signal; recovered: {} | negative control: after KILL, {taken_away} of {SAMPLES} are recovered without the stored bytes, and {at_the_end} from a recorder that writes at the end; both losses are detected",
        table.join(", ")
    );
}

#[cfg(target_os = "linux")]
#[test]
fn recording_under_nohup_survives_its_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fifo(folder);
    let script = format!("trap '' HUP; exec {} record port -o log.csv", env!("CARGO_BIN_EXE_fos"));
    let recorder = Command::new("sh").args(["-c", &script]).current_dir(folder).spawn().expect("a shell");
    wait_until(|| folder.join("log.csv.telemetry").exists(), Duration::from_secs(20));
    send(&recorder, "HUP");
    interrupted(folder, recorder, "INT");
    assert_eq!(recovered(folder), SAMPLES);
}

/// Checks the loss at power failure, by the system calls.
#[test]
fn syncs_received_data_every_second() {
    if Command::new("strace").arg("-V").output().is_err() {
        println!("skipped: no strace");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut traced = Command::new("strace")
        .args(["-f", "-y", "-o", "trace", "-e", "trace=fdatasync,fsync", env!("CARGO_BIN_EXE_fos")])
        .args(["record", "-", "-o", "log.csv"])
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    let mut port = traced.stdin.take().expect("piped");
    let began = Instant::now();
    for piece in telemetry().chunks(97) {
        port.write_all(piece).expect("read");
        sleep(Duration::from_millis(5));
    }
    let seconds = began.elapsed().as_secs_f64();
    drop(port);
    assert!(traced.wait().expect("it ends").success());
    let trace = fs::read_to_string(folder.join("trace")).expect("traced");
    let synced =
        trace.lines().filter(|call| call.contains("datasync(") && call.contains(".telemetry")).count();
    assert!(seconds > 2.0 && synced as f64 >= 0.5 * seconds - 1.0, "{synced} times in {seconds} s:\n{trace}");
}

#[test]
fn a_recording_ends_with_its_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    // used to wait forever if a stream ends inside a frame
    fs::write(folder.join("cut.stream"), telemetry()).expect("written");
    let message = done(folder, &["record", "cut.stream", "-o", "log.csv"]);
    assert!(message.contains("1500 samples, 0 lost") && message.contains("1 damaged"), "{message}");
    fs::write(folder.join("other.stream"), "no telemetry\n".repeat(300)).expect("written");
    let message = fails(folder, 1, &["record", "other.stream", "-o", "other.csv"]);
    assert!(message.contains("no sample in 3900 bytes") && message.contains("help: "), "{message}");
    // a stream that never ends
    let message = fails(folder, 1, &["record", "/dev/zero", "-o", "other.csv"]);
    assert!(
        message.contains("no frame of telemetry in the first") && message.contains("help: "),
        "{message}"
    );
    let left: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with("other.csv"))
        .collect();
    assert_eq!(left, [""; 0], "nothing is kept of nothing");
}

#[test]
fn waiting_for_a_fifo_is_reported_and_interruptible() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fifo(folder);
    let message = fails(folder, 1, &["record", "port", "-o", "log.csv", "--seconds", "1.5"]);
    assert!(message.contains("port: a FIFO without a writer; waiting for one"), "{message}");
    assert!(message.contains("port: nothing came") && message.contains("help: "), "{message}");
    let mut waiting = record(folder, &["port", "-o", "log.csv"]);
    let mut printed = String::new();
    BufReader::new(waiting.stderr.take().expect("piped")).read_line(&mut printed).expect("complete");
    send(&waiting, "INT");
    let ended = waiting.wait().expect("it ends");
    assert_eq!(ended.code(), Some(1), "it ends, and says that there is no log");
    assert!(!folder.join("log.csv").exists());
}

#[test]
fn reports_and_keeps_leftovers_of_another_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("log.csv.telemetry"), telemetry()).expect("written");
    fifo(folder);
    let recorder = record(folder, &["port", "-o", "log.csv"]);
    let port = File::options().write(true).open(folder.join("port"));
    port.expect("a FIFO").write_all(&telemetry()).expect("read");
    let ended = recorder.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success() && message.contains("`fos record log.csv.telemetry -o LOG`"), "{message}");
    assert_eq!(fs::read(folder.join("log.csv.telemetry")).expect("kept"), telemetry());
    assert!(!folder.join("log.csv.2.telemetry").exists());
    // a log does not replace its own source, and its name is checked before an hour is recorded
    let message = fails(folder, 1, &["record", "log.csv", "-o", "log.csv"]);
    assert!(message.contains("and would be lost") && message.contains("help: "), "{message}");
    assert!(fails(folder, 1, &["record", "port", "-o", "log.txt"]).contains("log.txt: cannot tell"));
}
