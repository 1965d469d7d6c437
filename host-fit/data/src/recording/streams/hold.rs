//! Slow streams, held at the timestamps of the lead.

use fos_core::align::Aligner;

use super::beside::Beside;

pub(super) struct HeldColumns {
    pub(super) columns: Vec<(String, Vec<f64>)>,
    /// Mean age over the rows with a value, s.
    pub(super) mean_age_s: f64,
    /// Number of rows without a value.
    pub(super) rows_missing: u64,
}

/// Columns of a stream at the timestamps of the lead. A stream with a single timestamp is held indefinitely.
pub(super) fn onto(beside: Beside<'_>, columns: Vec<(String, Vec<f64>)>) -> HeldColumns {
    let Beside { lead_ns, stamps_ns, period_ns } = beside;
    let aligner = Aligner::<f64, 0, 1, 2>::new([], [period_ns.unwrap_or(i64::MAX)]);
    let mut out = vec![Vec::with_capacity(lead_ns.len()); columns.len()];
    let (mut missing, mut age_ns) = (0_u64, 0.0);
    let push = |aligner: &mut Aligner<_, 0, 1, 2>, next: usize| {
        // the row index is held, so that a stream may have any columns; a second sample at its timestamp is refused
        if columns.iter().any(|(_, values)| values[next].is_finite()) {
            let _ = aligner.push_slow(0, stamps_ns[next], next as f64);
        }
    };
    beside.rows(
        aligner,
        |next, stamp| stamps_ns[next] <= stamp,
        push,
        |joined| {
            let held = joined.map(|joined| joined.slow[0]);
            let held = held.and_then(|held| Some((held.value as usize, held.age?)));
            for (out, (_, values)) in out.iter_mut().zip(&columns) {
                out.push(held.map_or(f64::NAN, |(row, _)| values[row]));
            }
            match held {
                Some((_, age)) => age_ns += age as f64,
                None => missing += 1,
            }
        },
    );
    let rows = (lead_ns.len() as u64 - missing).max(1) as f64;
    HeldColumns {
        columns: columns.into_iter().map(|(name, _)| name).zip(out).collect(),
        mean_age_s: age_ns / rows * 1e-9,
        rows_missing: missing,
    }
}
