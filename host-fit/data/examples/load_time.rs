//! Loading time and peak memory of the logs of one flight in several formats, compared with CSV.
//!
//! `cargo run --release -p fos-data --example load_time -- FOLDER HZ [MINUTES]` writes a flight in several formats into
//! a folder (an hour at 200 Hz: 1.2 GB), loads each five times, alternately and in separate processes, and prints the
//! medians.

use std::path::Path;
use std::process::Command;
use std::time::Instant;
use std::{env, fs};

use fos_data::recording::{LoadOptions, load};
use fos_testkit::foreign::{Chunks, Flight, Rate, bag, dataflash, mcap, ulog};

const TIMES: usize = 5;
const FILES: [&str; 5] = ["a.csv", "a.ulg", "a.bin", "a.mcap", "a.bag"];

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["load", path] => load_once(Path::new(path)),
        [folder, rate_hz] => compare(Path::new(folder), rate_hz, "60"),
        [folder, rate_hz, minutes] => compare(Path::new(folder), rate_hz, minutes),
        _ => panic!("FOLDER HZ [MINUTES]"),
    }
}

fn compare(folder: &Path, rate_hz: &str, minutes: &str) {
    let (rate_hz, minutes): (u64, u64) = (rate_hz.parse().unwrap(), minutes.parse().unwrap());
    fs::create_dir_all(folder).unwrap();
    {
        let flight = Flight::new((rate_hz * minutes * 60) as usize, 1_000_000 / rate_hz, 1);
        for name in FILES {
            let bytes = match name {
                "a.csv" => flight.csv().into_bytes(),
                "a.ulg" => ulog(&flight, Rate::Full),
                "a.bin" => dataflash(&flight, &[], false),
                "a.mcap" => mcap(&flight),
                _ => bag(&flight, Chunks::Some),
            };
            fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let mut runs: Vec<Vec<[f64; 3]>> = vec![Vec::new(); FILES.len()];
    for _ in 0..TIMES {
        for (name, runs) in FILES.iter().zip(&mut runs) {
            let output = Command::new(env::current_exe().unwrap())
                .arg("load")
                .arg(folder.join(name))
                .output()
                .unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap()).collect();
            runs.push(numbers.try_into().expect("three numbers"));
        }
    }
    let median = |runs: &[[f64; 3]], which: usize| {
        let mut values: Vec<f64> = runs.iter().map(|run| run[which]).collect();
        values.sort_by(f64::total_cmp);
        values[TIMES / 2]
    };
    let csv_s = median(&runs[0], 0);
    println!("file, MB, s, times CSV, peak MB, columns MB, peak over columns");
    for (name, runs) in FILES.iter().zip(&runs) {
        let file = fs::metadata(folder.join(name)).unwrap().len() as f64;
        let (seconds, peak, columns) = (median(runs, 0), median(runs, 1), median(runs, 2));
        println!(
            "{name}, {:.0}, {seconds:.2}, {:.2}, {:.0}, {:.0}, {:.2}",
            file / 1e6,
            seconds / csv_s,
            peak / 1e6,
            columns / 1e6,
            peak / columns
        );
    }
}

/// Prints seconds, peak memory in bytes, and bytes of the columns.
fn load_once(path: &Path) {
    let begun = Instant::now();
    let recording = load(path, &LoadOptions::default()).unwrap();
    let seconds = begun.elapsed().as_secs_f64();
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let kib: f64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
    let columns = (recording.channels().len() + 1) * recording.n_rows() * size_of::<f64>();
    println!("{seconds} {} {columns}", kib * 1024.0);
}
