//! A log in which one axis has no number is used for the other axes by every command.

use std::fmt::Write as _;
use std::fs;

use fos_testkit::noise::Noise;

use crate::session::{done, fails, stderr_of};

/// Two minutes at rest, with or without values of `gy_rads`.
fn log(seed: u64, with_gy: bool) -> String {
    let mut noise = Noise::new(seed);
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2,gx_rads,gy_rads,gz_rads,temp_c\n".to_owned();
    for row in 0..6000 {
        let time_s = f64::from(row) * 0.02;
        let [ax, ay, az] = [0.1, 0.2, 9.8].map(|level| level + 0.01 * noise.normal());
        let [gx, gy, gz] = [0.001, 0.002, 0.003].map(|level| level + 1e-3 * noise.normal());
        let gy = if with_gy { gy.to_string() } else { String::new() };
        writeln!(text, "{time_s:.2},{ax},{ay},{az},{gx},{gy},{gz},{}", 25.0 + time_s / 60.0).expect("text");
    }
    text
}

#[test]
fn every_command_uses_the_other_axes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("five.csv"), log(1, false)).expect("written");
    fs::write(folder.join("six.csv"), log(2, true)).expect("written");
    let small = ["--max-lag", "2", "--degree", "1", "--max-terms", "2", "--memory", "none"];
    let fit = |log: &str, study: &str| done(folder, &[&["fit", log, "-o", study][..], &small].concat());
    let report = fit("five.csv", "five.json");
    assert!(report.contains("gy_rads: every cell is empty") && report.contains(" gz_rads "), "{report}");
    fit("six.csv", "six.json");
    done(folder, &["compare", "five.json"]);
    done(folder, &["compare", "five.json", "six.csv"]);
    let report = done(folder, &["compare", "six.json", "five.csv"]);
    assert!(report.contains(" gz_rads ") && !report.contains(" gy_rads "), "{report}");
    assert!(stderr_of(folder, &["diagnose", "five.csv"]).contains("excluded: five.csv: gy_rads: every cell"));
    let report = done(folder, &["noise", "five.csv"]);
    assert!(report.contains("gx_rads") && report.contains("gz_rads"), "{report}");
    fs::create_dir(folder.join("units")).expect("a folder");
    for unit in 3..6 {
        fs::write(folder.join(format!("units/{unit}.csv")), log(unit, false)).expect("written");
    }
    done(folder, &["fleet", "units", "-o", "population.json"]);
    done(folder, &["convert", "five.csv", "-o", "converted.csv"]);
    let header = fs::read_to_string(folder.join("converted.csv")).expect("written");
    assert!(!header.lines().next().expect("a header").contains("gy_rads"));
    // if requested, it is refused
    for command in [&["noise", "five.csv", "--axis", "gy"][..], &["fit", "five.csv", "--axis", "gy"]] {
        let report = fails(folder, 1, command);
        assert!(report.contains("gy_rads: every cell of its 6000 rows is empty"), "{report}");
    }
}
