//! Upper line of peak memory.

/// Upper line of the peaks, bytes and bytes per row: a fifth above those at 8 h, where fit took 1484 MB, diagnose 939
/// and report 1250.
pub(crate) const BASE: u64 = 40_000_000;
pub(crate) const BYTES_A_ROW: [(&str, u64); 3] = [("fit", 300), ("diagnose", 210), ("report", 250)];

/// Formats bytes as MB.
pub(crate) fn mega(bytes: u64) -> String {
    format!("{:.0}", bytes as f64 / 1e6)
}

/// Limit of a command, bytes.
pub(crate) fn at_most(command: &str, rows: u64) -> u64 {
    let (_, bytes_a_row) = BYTES_A_ROW.into_iter().find(|(name, _)| *name == command).unwrap_or(("", 0));
    BASE + bytes_a_row * rows
}

pub(crate) fn holds(command: &str, peak: u64, rows: u64) -> bool {
    let at_most = at_most(command, rows);
    if peak > at_most {
        eprintln!("{command}: {peak} bytes, more than {at_most}");
    }
    peak <= at_most
}
