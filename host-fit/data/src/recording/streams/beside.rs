//! Resampling of one stream at the timestamps of the lead, by the evaluator's own aligner as on the device.

use fos_core::align::{Aligner, Joined};

/// Non-decreasing timestamps of a stream and of the lead.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    pub(super) lead_ns: &'a [i64],
    pub(super) stamps_ns: &'a [i64],
    /// `None` if there is only one timestamp.
    pub(super) period_ns: Option<i64>,
}

impl Beside<'_> {
    /// Visits the timestamps of the lead. Before each, `push` feeds the aligner the samples selected by `is_due` (by
    /// index and timestamp of the lead); `row` gets the output. Rows with equal timestamps get the same output.
    pub(super) fn rows<const FOLLOWERS: usize, const SLOW: usize, const DEPTH: usize>(
        self,
        mut aligner: Aligner<f64, FOLLOWERS, SLOW, DEPTH>,
        is_due: impl Fn(usize, i64) -> bool,
        mut push: impl FnMut(&mut Aligner<f64, FOLLOWERS, SLOW, DEPTH>, usize),
        mut row: impl FnMut(Option<&Joined<f64, FOLLOWERS, SLOW>>),
    ) {
        let mut next = 0;
        let mut joined = None;
        for &stamp in self.lead_ns {
            while next < self.stamps_ns.len() && is_due(next, stamp) {
                push(&mut aligner, next);
                next += 1;
            }
            if aligner.push_lead(stamp, [0.0; 3]).is_ok() {
                joined = aligner.flush();
            }
            row(joined.as_ref());
        }
    }
}
