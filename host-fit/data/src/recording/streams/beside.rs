//! A stream beside the one that leads: what the evaluator's own aligner, as on the device, gives at every stamp of the lead.

use fos_core::align::{Aligner, Joined};

/// Stamps that do not go back, beside those of the lead, which do not either.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    pub(super) lead_ns: &'a [i64],
    pub(super) stamps_ns: &'a [i64],
    /// None where there is one stamp only.
    pub(super) period_ns: Option<i64>,
}

impl Beside<'_> {
    /// Goes through the stamps of the lead. Before each, `push` has the aligner take the samples that `is_due` says of, by
    /// their place and the stamp of the lead; `row` gets what it gives then. Rows of one stamp get the same.
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
