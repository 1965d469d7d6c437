//! Numbers in files of other programs.

/// Formats a number that every reader takes as real: YAML 1.1 needs a point and a sign in the exponent, ORB-SLAM3 a
/// point.
pub(super) fn real(value: f64) -> String {
    if value > 0.0 && value < 1.0 { format!("{value:.6e}") } else { format!("{value:.6}") }
}
