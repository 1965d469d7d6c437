//! Logs of a question without outliers and disturbances, and the warnings about them.

use fos_data::column::Column;
use fos_data::disturbance::{self, Disturbance};
use std::borrow::Cow;

use super::dead_zone::{self, Searched};
use super::prepared::STAIRS;
use super::question::{DiagnoseError, Question};
use fos_data::case::DataSheet;
use fos_data::recording::{LogWarning, Recording};

/// Cleaned logs of a question.
#[derive(Debug)]
pub(super) struct Cleaned<'a> {
    column: String,
    field: Log<'a>,
    quiet: Option<Log<'a>>,
    judged: Option<Cow<'a, Recording>>,
}

/// A log as read, and without the outliers of the column to explain.
#[derive(Debug)]
struct Log<'a> {
    whole: &'a Recording,
    still: Vec<bool>,
    without: Cow<'a, Recording>,
    disturbances: Vec<Disturbance>,
    zone: Searched,
}

impl<'a> Cleaned<'a> {
    /// Cleans the logs of a question.
    ///
    /// # Errors
    ///
    /// The column to explain is missing or stuck, or a log is never at rest.
    pub(super) fn of(question: &Question<'a>) -> Result<Self, DiagnoseError> {
        let column = question.field.axis(question.target)?.name.clone();
        let is_coarse = has_coarse_steps(question);
        let field = Log::of(question.field, &column, is_coarse)?;
        let quiet = question.quiet.map(|quiet| Log::of(quiet, &column, false)).transpose()?;
        [Some(question.field), question.quiet, question.judged]
            .into_iter()
            .flatten()
            .try_for_each(disturbance::check)?;
        let judged = question.judged.map(|judged| disturbance::marked(judged).0);
        Ok(Self { column, field, quiet, judged })
    }

    /// Returns the question with the cleaned logs.
    pub(super) fn question<'q>(&'q self, question: &Question<'q>) -> Question<'q> {
        let quiet = self.quiet.as_ref().map(|quiet| &*quiet.without);
        Question { field: &self.field.without, quiet, judged: self.judged.as_deref(), ..*question }
    }

    /// Returns the detected motion in the log to explain.
    pub(super) fn disturbances(&self) -> &[Disturbance] {
        &self.field.disturbances
    }

    /// Returns the result of the search for a dead zone in the column to explain.
    pub(super) fn zone(&self) -> Searched {
        self.field.zone
    }

    /// Returns the warnings about the logs that concern the column to explain.
    pub(super) fn cautions(&self) -> Vec<String> {
        let mut cautions = self.field.cautions(&self.column);
        let reference_cautions = self.quiet.iter().flat_map(|quiet| quiet.cautions(&self.column));
        cautions.extend(reference_cautions.map(|caution| format!("reference log: {caution}")));
        cautions
    }
}

impl<'a> Log<'a> {
    fn of(whole: &'a Recording, column: &str, is_coarse: bool) -> Result<Self, DiagnoseError> {
        let (at_rest, disturbances) = disturbance::marked(whole);
        // an outlier is not motion, although a motion detector may report it
        let still = at_rest.still.clone().unwrap_or_else(|| vec![true; whole.n_rows()]);
        let zone = match Column::named(column).is_angular_rate() {
            true => dead_zone::search(&whole.channel(column)?.values),
            false => Searched::None,
        };
        // inside a dead zone a gyro repeats one value, which is not a stuck sensor
        if matches!(zone, Searched::Found(_)) {
            return Ok(Self { whole, still, without: at_rest, disturbances, zone });
        }
        if let Some((value, [seconds, all_s])) = whole.stuck_axis(column, &still)
            && !(is_coarse && seconds == all_s)
        {
            return Err(DiagnoseError::Stuck { column: column.to_owned(), value, seconds, all_s });
        }
        let without = match at_rest {
            Cow::Borrowed(whole) => whole.without_outliers(column, 0..whole.n_rows(), &still).0,
            Cow::Owned(marked) => {
                Cow::Owned(marked.without_outliers(column, 0..whole.n_rows(), &still).0.into_owned())
            }
        };
        Ok(Self { whole, still, without, disturbances, zone })
    }

    fn cautions(&self, column: &str) -> Vec<String> {
        let concerns_column = |oddity: &LogWarning| match oddity {
            LogWarning::NotGravity { .. } | LogWarning::LevelAfterPause(_) => {
                Column::named(column).is_specific_force()
            }
            _ => true,
        };
        let odd = self.whole.oddities_about(&[column], &self.still);
        odd.iter().filter(|oddity| concerns_column(oddity)).map(ToString::to_string).collect()
    }
}

/// Returns true if the known step of the axis is so coarse that the noise of the data sheet may not show: the axis may
/// then repeat one value at rest.
fn has_coarse_steps(question: &Question<'_>) -> bool {
    // noise densities of data sheets are one-sided
    let noise = |sheet: DataSheet| sheet.noise_density / (2.0 * question.field.rate.period_s).sqrt();
    question.lsb.zip(question.sheet).is_some_and(|(lsb, sheet)| lsb > STAIRS * noise(sheet))
}
