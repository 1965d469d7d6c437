//! Check that an effect does not increase the error of the evaluation log, in its mean or in its RMS.

use std::ops::Range;

use super::error::RefineError;
use super::identifiable::SAME_RMS;
use super::refiner::Refiner;
use crate::detect::{ErrorInBlocks, Finding};
use crate::effects::{Band, Effect};
use fos_data::column::Column;
use fos_data::text::rounded;
use fos_fit::signal;
use fos_fit::single_axis::SingleAxisModel;

/// Number of equal parts of a log whose means scatter like the mean of the whole log: with flicker noise a longer
/// average is hardly more certain.
const PARTS: usize = 8;

/// Standard deviations by which a mean error must increase to count: those of a 95 % interval.
const TWO_SIDED_95: f64 = 1.96;

/// Error of the evaluation log: its mean minus that of the log to explain, if both biases are known, and the RMS about
/// it. If it continues that log, the RMS is about the bias of that log and contains the mean.
struct Errors {
    mean: Option<f64>,
    rms: f64,
    /// Standard deviation of the mean.
    deviation: f64,
}

impl Refiner<'_> {
    /// Rejects the effect at `place` of `findings` if it increases the error of the evaluation log by more than its
    /// uncertainty. All others are subtracted before and after: of two effects that cancel in part, each alone
    /// increases the error. The reference log is not used, since by its purpose it may lack the effect.
    pub(super) fn check_errors(
        &self,
        base: &SingleAxisModel,
        findings: &[Finding],
        place: usize,
        effect: &Effect,
    ) -> Result<(), RefineError> {
        let mut without = findings.to_vec();
        if place < without.len() {
            without.remove(place);
        }
        let (before, after) =
            (self.errors(base, &without, effect.band)?, self.errors(base, findings, effect.band)?);
        let unit = Column::named(&base.axis().column).unit().label();
        let worse = |what: &'static str, values: [f64; 3]| {
            let [before, after, margin] = values.map(|value| rounded(value, 3));
            let growth =
                format!("from {before} to {after} {unit}, more than its uncertainty of {margin} {unit}");
            let (effect, experiment) = (effect.id.clone(), effect.experiment.clone());
            RefineError::MakesWorse { effect, what, growth, experiment }
        };
        if let (Some(was), Some(is)) = (before.mean, after.mean) {
            let margin = TWO_SIDED_95 * before.deviation.min(after.deviation);
            if is.abs() > was.abs() + margin {
                return Err(worse("mean error", [was.abs(), is.abs(), margin]));
            }
        }
        let margin = SAME_RMS * before.rms;
        if after.rms > before.rms + margin {
            return Err(worse("RMS error", [before.rms, after.rms, margin]));
        }
        Ok(())
    }

    /// Returns the errors of the evaluation log after the physical part of `base` and `findings` are subtracted.
    fn errors(
        &self,
        base: &SingleAxisModel,
        findings: &[Finding],
        band: Band,
    ) -> Result<Errors, RefineError> {
        let (column, rows) = (&base.axis().column, self.evaluation_rows());
        let log = self.reduced_without(base, findings, self.log())?;
        let evaluation = self.reduced_without(base, findings, self.evaluation())?;
        let left = self.left_in(column, &log, &evaluation);
        let all = 0..log.1.len();
        let parts = |(reduced, left): &(ErrorInBlocks, Vec<f64>), rows: &Range<usize>| {
            let length = rows.len().div_ceil(PARTS).max(1);
            let ends = |start: usize| (start + length).min(rows.end);
            let starts = rows.clone().step_by(length);
            let means = starts.map(|start| reduced.slow_mean(left, &(start..ends(start))));
            signal::variance(&[&means.filter(|mean| mean.is_finite()).collect::<Vec<f64>>()])
        };
        // the RMS of a log that continues contains it
        let has_mean = self.log().is_bias_known(column) && !self.continues(column);
        Ok(Errors {
            mean: left.bias.filter(|_| has_mean),
            rms: if band == Band::Wide { left.wide.sqrt() } else { left.slow.sqrt() },
            deviation: (parts(&log, &all) + parts(&evaluation, &rows)).sqrt(),
        })
    }
}
