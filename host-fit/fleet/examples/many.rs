//! Cost of a population with a given number of units: memory of the gathered rows, time, peak memory.
//!
//!     cargo run --release -p fos-fleet --example many -- 100000

#[path = "../tests/fleet/drawn/mod.rs"]
mod drawn;

use std::time::Instant;

use fos_diagnose::effects::Library;
use fos_fleet::{Fleet, Gathered, PROGRAM};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let units: usize = std::env::args().nth(1).ok_or("usage: many UNITS")?.parse()?;
    let mut gathered = Gathered::default();
    let before = resident_mb("VmRSS:");
    for unit in 0..units {
        gathered.add(drawn::row(unit))?;
    }
    let held = resident_mb("VmRSS:") - before;
    let begun = Instant::now();
    let fleet = Fleet::of_gathered(&gathered, &Library::built_in(), PROGRAM)?;
    let seconds = begun.elapsed().as_secs_f64();
    println!(
        "{units} units in lots of {}: {held:.0} MB held, {:.0} bytes each; population in {seconds:.1} s on {} cores; {:.0} MB at most",
        drawn::A_LOT,
        held * 1e6 / units as f64,
        std::thread::available_parallelism()?,
        resident_mb("VmHWM:"),
    );
    let gx = fleet.parts[0]
        .axes
        .iter()
        .find(|axis| axis.column == "gx_rads")
        .and_then(|axis| axis.population.as_ref());
    let scatter = &gx.ok_or("no population")?.scatter[0];
    println!(
        "bias of gx, mrad/s: between units {:.4} ({:.4} to {:.4}), between lots {:.4} ({:.4} to {:.4}); drawn with 4 and 2; {} units odd",
        1e3 * scatter.units,
        1e3 * scatter.units_interval[0],
        1e3 * scatter.units_interval[1],
        1e3 * scatter.lots,
        1e3 * scatter.lots_interval[0],
        1e3 * scatter.lots_interval[1],
        fleet.parts[0].odd.len(),
    );
    Ok(())
}

/// A line of `/proc/self/status`, MB; 0 on other systems than Linux.
fn resident_mb(what: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(what));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).map_or(0.0, |kb| kb * 1024e-6)
}
