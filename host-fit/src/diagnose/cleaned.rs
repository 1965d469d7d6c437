//! The logs of a question without what is no measurement, and what anybody would see in them.

use std::borrow::Cow;

use super::{DiagnoseError, Question};
use crate::recording::{Oddity, Recording};
use crate::rest;

/// The logs of a question, cleaned.
#[derive(Debug)]
pub(super) struct Cleaned<'a> {
    field: Cow<'a, Recording>,
    quiet: Option<Cow<'a, Recording>>,
    /// What is odd about them.
    pub(super) cautions: Vec<String>,
}

impl<'a> Cleaned<'a> {
    /// Of a question.
    ///
    /// # Errors
    ///
    /// The column to explain is missing, or its value is always the same.
    pub(super) fn of(question: &Question<'a>) -> Result<Self, DiagnoseError> {
        let column = question.field.axis(question.target)?.name.clone();
        let (field, mut cautions) = cleaned(question.field, &column)?;
        let (quiet, of_quiet) = question.quiet.map(|quiet| cleaned(quiet, &column)).transpose()?.unzip();
        cautions.extend(of_quiet.into_iter().flatten().map(|caution| format!("quiet log: {caution}")));
        Ok(Self { field, quiet, cautions })
    }

    /// The question, asked of them.
    pub(super) fn question<'q>(&'q self, question: &Question<'q>) -> Question<'q> {
        Question { field: &self.field, quiet: self.quiet.as_deref(), ..*question }
    }
}

/// A log without the spikes of `column`, and what is odd about it that bears on that.
fn cleaned<'a>(log: &'a Recording, column: &str) -> Result<(Cow<'a, Recording>, Vec<String>), DiagnoseError> {
    let values = &log.channel(column)?.values;
    let mut known = values.iter().filter(|value| !value.is_nan());
    if let Some(value) = known.next().filter(|first| known.all(|value| value == *first)) {
        return Err(DiagnoseError::Stuck { column: column.to_owned(), value: *value });
    }
    let rest = rest::find(log);
    // where nothing is at rest all rows count
    let rows = 0..log.n_rows();
    let (without, _) = log.without_spikes(column, rows, &rest.still);
    let bears = |oddity: &Oddity| match oddity {
        Oddity::Stuck { column: other, .. }
        | Oddity::Spikes { column: other, .. }
        | Oddity::TurnsAtRest { column: other, .. }
        | Oddity::NoiseDiffers { column: other, .. } => other == column,
        Oddity::Same { columns } => columns.iter().any(|other| other == column),
        Oddity::NotGravity { .. } => column.ends_with("_mps2"),
        Oddity::RatesDiffer { .. } => true,
    };
    let odd = log.oddities(&rest.still);
    Ok((without, odd.iter().filter(|oddity| bears(oddity)).map(ToString::to_string).collect()))
}
