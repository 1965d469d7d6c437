//! Inertial streams other than the lead, interpolated at its timestamps.

use fos_core::align::Aligner;

use super::beside::Beside;
use crate::column::{AXES, Column};

/// Number of columns resampled at a time.
const TRIAD: usize = 3;

/// Minimum depth that suffices: every sample of the lead is emitted at once.
const DEPTH: usize = 4;

/// Returns true if a column is interpolated: an axis, or the true value of one.
pub(in super::super) fn is_followed(name: &str) -> bool {
    let is_axis = |name: &str| AXES.contains(&name);
    is_axis(name) || AXES.iter().any(|axis| Column::named(axis).reference() == name)
}

pub(super) struct Followed {
    pub(super) columns: Vec<(String, Vec<f64>)>,
    /// Mean of (1 − w)² + w², the remaining share of the variance of white noise.
    pub(super) noise_kept: f64,
    /// Number of rows in which a column is missing.
    pub(super) rows_missing: u64,
}

/// Columns of a stream, at the timestamps of the lead.
pub(super) fn onto(beside: Beside<'_>, columns: Vec<(String, Vec<f64>)>) -> Followed {
    let Beside { lead_ns, stamps_ns, period_ns } = beside;
    let mut followed = Followed { columns: Vec::new(), noise_kept: 1.0, rows_missing: 0 };
    let (mut kept, mut rows) = (0.0, 0_u64);
    let mut columns = columns.into_iter().peekable();
    while columns.peek().is_some() {
        let triad: Vec<(String, Vec<f64>)> = columns.by_ref().take(TRIAD).collect();
        let aligner = Aligner::<f64, 1, 0, DEPTH>::new([period_ns.unwrap_or(0)], []);
        let mut out = vec![Vec::with_capacity(lead_ns.len()); triad.len()];
        let value = |column: usize, row: usize| triad.get(column).map_or(0.0, |(_, values)| values[row]);
        let mut missing = 0;
        // up to the first that is not before the lead
        let is_due = |next: usize, stamp| next == 0 || stamps_ns[next - 1] < stamp;
        let push = |aligner: &mut Aligner<_, 1, 0, DEPTH>, next: usize| {
            let values = [value(0, next), value(1, next), value(2, next)];
            // refused if it is a missing sample or a second one at its timestamp
            let _ = aligner.push_follower(0, stamps_ns[next], values);
        };
        beside.rows(aligner, is_due, push, |joined| {
            let found = joined.map(|joined| joined.followers[0]);
            let values = found.map_or([f64::NAN; TRIAD], |found| found.values);
            out.iter_mut().zip(values).for_each(|(out, value)| out.push(value));
            match found.and_then(|found| found.weight) {
                Some(weight) => {
                    let w = f64::from(weight) / f64::from(1 << 24);
                    kept += (1.0 - w) * (1.0 - w) + w * w;
                    rows += 1;
                }
                None => missing += 1,
            }
        });
        followed.rows_missing = followed.rows_missing.max(missing);
        followed.columns.extend(triad.into_iter().map(|(name, _)| name).zip(out));
    }
    if rows > 0 {
        followed.noise_kept = kept / rows as f64;
    }
    followed
}
