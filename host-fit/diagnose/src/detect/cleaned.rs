//! Logs of a question without outliers and disturbances, and the warnings about them.

use fos_data::column::Column;
use fos_data::disturbance::{self, Disturbance};
use std::borrow::Cow;

use super::dead_zone::{self, Searched};
use super::prepared::STAIRS;
use super::question::{DiagnoseError, Question};
use fos_data::case::DataSheet;
use fos_data::recording::{LogWarning, Recording};
use fos_data::text::rounded;

/// Relative difference of sampling rates beyond which two logs may be of different devices.
const OTHER_RATE: f64 = 0.1;

/// Cleaned logs of a question.
#[derive(Debug)]
pub(super) struct Cleaned<'a> {
    column: String,
    log: Log<'a>,
    reference: Option<Log<'a>>,
    evaluation: Option<Cow<'a, Recording>>,
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
    pub(super) fn of(question: &Question<'a>) -> Result<Self, DiagnoseError> {
        let column = question.log.axis(question.target)?.name.clone();
        let mut others = question.reference.into_iter().chain(question.evaluation);
        others.try_for_each(|other| question.log.refuse_other_sensor(other))?;
        let is_coarse = has_coarse_steps(question);
        let log = Log::of(question.log, &column, is_coarse)?;
        let reference = question.reference.map(|reference| Log::of(reference, &column, false)).transpose()?;
        [Some(question.log), question.reference, question.evaluation]
            .into_iter()
            .flatten()
            .try_for_each(disturbance::check)?;
        let evaluation = question.evaluation.map(|evaluation| disturbance::marked(evaluation).0);
        Ok(Self { column, log, reference, evaluation })
    }

    /// Returns the question with the cleaned logs.
    pub(super) fn question<'q>(&'q self, question: &Question<'q>) -> Question<'q> {
        let reference = self.reference.as_ref().map(|reference| &*reference.without);
        Question { log: &self.log.without, reference, evaluation: self.evaluation.as_deref(), ..*question }
    }

    /// Returns the detected motion in the log to explain.
    pub(super) fn disturbances(&self) -> &[Disturbance] {
        &self.log.disturbances
    }

    /// Returns the result of the search for a dead zone in the column to explain.
    pub(super) fn zone(&self) -> Searched {
        self.log.zone
    }

    /// Returns the warnings about the logs that concern the column to explain.
    pub(super) fn cautions(&self) -> Vec<String> {
        let mut cautions = self.log.cautions(&self.column);
        let reference_cautions = self.reference.iter().flat_map(|reference| reference.cautions(&self.column));
        cautions.extend(reference_cautions.map(|caution| format!("reference log: {caution}")));
        let others = [
            ("reference log", self.reference.as_ref().map(|reference| reference.whole)),
            ("evaluation log", self.evaluation.as_deref()),
        ];
        let here = self.log.whole.rate.true_hz;
        for (name, other) in others {
            let there = other.map_or(here, |other| other.rate.true_hz);
            if (there / here - 1.0).abs() > OTHER_RATE {
                let [there, here] = [there, here].map(|rate| rounded(rate, 3));
                cautions.push(format!(
                    "the {name} runs at {there} Hz and the log to explain at {here} Hz; record both with the same device and settings"
                ));
            }
        }
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
        let concerns_column = |warning: &LogWarning| match warning {
            LogWarning::NotGravity { .. } | LogWarning::LevelAfterPause(_) => {
                Column::named(column).is_specific_force()
            }
            _ => true,
        };
        let odd = self.whole.warnings_about(&[column], &self.still);
        odd.iter().filter(|warning| concerns_column(warning)).map(ToString::to_string).collect()
    }
}

/// Returns true if the known step of the axis is so coarse that the noise of the data sheet may not show: the axis may
/// then repeat one value at rest.
fn has_coarse_steps(question: &Question<'_>) -> bool {
    // noise densities of data sheets are one-sided
    let noise = |sheet: DataSheet| sheet.noise_density / (2.0 * question.log.rate.period_s).sqrt();
    question.lsb.zip(question.sheet).is_some_and(|(lsb, sheet)| lsb > STAIRS * noise(sheet))
}
