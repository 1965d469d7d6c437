//! The logs of a question without what is no measurement, and what anybody would see in them.

use fos_data::column::Column;
use std::borrow::Cow;

use super::question::{DiagnoseError, Question};
use fos_data::recording::{Oddity, Recording};
use fos_data::stillness;

/// The logs of a question, cleaned.
#[derive(Debug)]
pub(super) struct Cleaned<'a> {
    column: String,
    field: Log<'a>,
    quiet: Option<Log<'a>>,
}

/// A log as it is and without the spikes of the column to explain.
#[derive(Debug)]
struct Log<'a> {
    whole: &'a Recording,
    still: Vec<bool>,
    without: Cow<'a, Recording>,
}

impl<'a> Cleaned<'a> {
    /// Of a question.
    ///
    /// # Errors
    ///
    /// The column to explain is missing, or its value is always the same.
    pub(super) fn of(question: &Question<'a>) -> Result<Self, DiagnoseError> {
        let column = question.field.axis(question.target)?.name.clone();
        let field = Log::of(question.field, &column)?;
        let quiet = question.quiet.map(|quiet| Log::of(quiet, &column)).transpose()?;
        Ok(Self { column, field, quiet })
    }

    /// The question, asked of them.
    pub(super) fn question<'q>(&'q self, question: &Question<'q>) -> Question<'q> {
        let quiet = self.quiet.as_ref().map(|quiet| &*quiet.without);
        Question { field: &self.field.without, quiet, ..*question }
    }

    /// What is odd about the logs that bears on the column to explain.
    pub(super) fn cautions(&self) -> Vec<String> {
        let mut cautions = self.field.cautions(&self.column);
        let of_quiet = self.quiet.iter().flat_map(|quiet| quiet.cautions(&self.column));
        cautions.extend(of_quiet.map(|caution| format!("quiet log: {caution}")));
        cautions
    }
}

impl<'a> Log<'a> {
    fn of(whole: &'a Recording, column: &str) -> Result<Self, DiagnoseError> {
        let values = &whole.channel(column)?.values;
        let mut known = values.iter().filter(|value| !value.is_nan());
        if let Some(value) = known.next().filter(|first| known.all(|value| value == *first)) {
            return Err(DiagnoseError::Stuck { column: column.to_owned(), value: *value });
        }
        let still = stillness::find(whole).still;
        let (without, _) = whole.without_spikes(column, 0..whole.n_rows(), &still);
        Ok(Self { whole, still, without })
    }

    fn cautions(&self, column: &str) -> Vec<String> {
        let bears = |oddity: &Oddity| match oddity {
            Oddity::Stuck { column: other, .. }
            | Oddity::Spikes { column: other, .. }
            | Oddity::TurnsAtRest { column: other, .. }
            | Oddity::NoiseDiffers { column: other, .. } => other == column,
            Oddity::Same { columns } => columns.iter().any(|other| other == column),
            Oddity::NotGravity { .. } => Column::named(column).is_specific_force(),
            Oddity::RatesDiffer { .. } => true,
        };
        let odd = self.whole.oddities(&self.still);
        odd.iter().filter(|oddity| bears(oddity)).map(ToString::to_string).collect()
    }
}
