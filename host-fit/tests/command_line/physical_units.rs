//! Output of `fit --physical` for a log with known coefficients, in the units of the log.

use crate::session::done;
use fos_core::{Transform, Transformer};

const RATE_HZ: f64 = 50.0;
const ROWS: usize = 30_000;

/// White noise between −1 and 1, without a pattern that the search could find.
fn noise(row: usize, of: u64) -> f64 {
    let mut x = (row as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ of.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// Coefficient and standard error of the term that ends with `of`.
fn coefficient(printed: &str, of: &str) -> (f64, f64) {
    let (before, _) = printed.split_once(of).unwrap_or_else(|| panic!("no {of}:\n{printed}"));
    let line = before.rsplit(['\n', ';', ':']).next().expect("a term");
    let (value, error) = line.trim().split_once(" ± ").unwrap_or_else(|| panic!("{line}"));
    (value.parse().expect("a number"), error.trim().parse().expect("a number"))
}

#[test]
fn prints_the_true_coefficients() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut rate = Transformer::new(&Transform::Rate { tau_s: 5.0 }, 1.0 / RATE_HZ);
    let mut log = String::from("t_s,gx_rads,gy_rads,ax_mps2,temp_c,supply_v,still\n");
    for row in 0..ROWS {
        let t_s = row as f64 / RATE_HZ;
        let temp_c = 25.0 + 6.0 * (t_s / 70.0).sin() + 2.0 * (t_s / 23.0).cos();
        let supply_v = 3.3 + 0.1 * (t_s / 41.0).sin();
        let warming = rate.update(temp_c);
        let gx = 0.01 + 2e-4 * (temp_c - 25.0) - 3e-3 * supply_v + 5e-4 * noise(row, 1);
        let gy = -0.02 + 0.04 * warming + 5e-4 * noise(row, 2);
        let ax = 0.1 + 4e-3 * (temp_c - 25.0) + 0.05 * supply_v + 0.01 * noise(row, 3);
        log += &format!("{t_s},{gx},{gy},{ax},{temp_c},{supply_v},1\n");
    }
    std::fs::write(folder.join("log.csv"), log).expect("written");

    let both = [
        "fit",
        "log.csv",
        "--axis",
        "gx,ax",
        "--physical",
        "temp_c",
        "--physical",
        "supply_v",
        "--units",
        "si",
        "-o",
        "unit.json",
    ];
    let printed = done(folder, &both);
    let fit = [
        "fit",
        "log.csv",
        "--axis",
        "gy",
        "--physical",
        "temp_c:rate(5)",
        "--units",
        "si",
        "-o",
        "unit.json",
    ];
    let warming = done(folder, &fit);
    for (printed, of, known) in [
        (&printed, "(rad/s)/K of temp_c", 2e-4),
        (&printed, "(rad/s)/V of supply_v", -3e-3),
        (&printed, "(m/s²)/K of temp_c", 4e-3),
        (&printed, "(m/s²)/V of supply_v", 0.05),
        (&warming, "(rad/s)/(K/s) of temp_c:rate(5)", 0.04),
    ] {
        let (found, error) = coefficient(printed, of);
        assert!((found - known).abs() < 4.0 * error, "{of}: {found} ± {error}, made with {known}");
        assert!(error < 0.1 * known.abs(), "{of}: ± {error}");
    }
}
