//! The commands of docs/coming-from.md, run in its order on logs made for them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::session::done;

/// Endings of the logs that the page names, whatever their format.
const LOGS: [&str; 5] = ["bag", "csv", "ulg", "bin", "mcap"];

/// The words of every command in blocks of shell.
fn commands(page: &str) -> Vec<Vec<String>> {
    let blocks = page.split("```sh\n").skip(1).map(|block| block.split("```").next().expect("an end"));
    let lines = blocks.flat_map(str::lines).flat_map(|line| line.split(" && "));
    lines.map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

/// At rest for 20 minutes, cold to warm and back; the logs at rest at one temperature.
fn write_log(path: &Path, seed: u32, swing: f64) {
    let mut state = seed;
    let mut noise = || {
        (0..4).fold(-2.0, |sum, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum + f64::from(state >> 8) / f64::from(1 << 24)
        })
    };
    let mut text = String::from("t_s,ax_mps2,ay_mps2,az_mps2,gx_rads,gy_rads,gz_rads,temp_c,still\n");
    for n in 0..24_000 {
        let celsius = 30.0 - swing * (f64::from(n) / 2500.0).cos();
        let warm = celsius - 30.0;
        let axes = [0.1 + 2e-3 * warm, -0.2, 9.8, 0.01 + 2e-4 * warm, -0.01, 0.0];
        let axes: Vec<String> = axes
            .iter()
            .enumerate()
            .map(|(axis, value)| (value + if axis < 3 { 0.01 } else { 0.001 } * noise()).to_string())
            .collect();
        text += &format!("{},{},{celsius},1\n", f64::from(n) / 20.0, axes.join(","));
    }
    std::fs::write(path, text).expect("written");
}

#[test]
fn every_command_of_the_page_does_what_it_says() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/coming-from.md");
    let page = std::fs::read_to_string(page).expect("there");
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let commands = commands(&page);
    assert!(commands.len() >= 12, "{commands:?}");
    // logs are written as tables here, under the same names: what opens other formats has tests of its own
    let mut logs: BTreeMap<String, String> = BTreeMap::new();
    for (at, command) in commands.iter().enumerate() {
        assert_eq!(command[0], "fos");
        let named: Vec<String> = command[1..]
            .iter()
            .enumerate()
            .map(|(place, word)| {
                let is_written = command[place].starts_with("--") && command[place] != "--evaluate-on";
                let Some((stem, ending)) = word.rsplit_once('.').filter(|_| !is_written) else {
                    return word.clone();
                };
                if !LOGS.contains(&ending) {
                    return word.clone();
                }
                let log = format!("{stem}.{ending}.csv");
                if logs.insert(word.clone(), log.clone()).is_none() {
                    write_log(&folder.join(&log), at as u32, if stem == "rest" { 0.0 } else { 15.0 });
                }
                log
            })
            .collect();
        let mut words: Vec<&str> = named.iter().map(String::as_str).collect();
        // which IMU it is of stands in a log of the autopilot, and in no table
        if words.iter().any(|word| ["--px4", "--ardupilot"].contains(word)) {
            words.extend(["--instance", "0"]);
        }
        done(folder, &words);
    }
    for file in ["allan.csv", "allan.svg", "imu.yaml", "orb.yaml", "vins.yaml", "unit.params", "unit.parm"] {
        assert!(folder.join(file).metadata().is_ok_and(|file| file.len() > 300), "{file}");
    }
}
