//! Diagnosis of a case.

use fos_data::case::{Case, CaseMeta};
use fos_data::recording::Recording;

use crate::detect::Question;
use crate::effects::Library;

/// Returns the question for logs of a case: explain the error in `field` and correct it in `judged`.
pub fn question_of_logs<'a>(
    meta: &'a CaseMeta,
    field: &'a Recording,
    quiet: Option<&'a Recording>,
    judged: Option<&'a Recording>,
    library: &'a Library,
) -> Question<'a> {
    Question {
        quiet,
        judged,
        sheet: meta.data_sheet(),
        full_scale: meta.full_scale(),
        lsb: meta.lsb(),
        ..Question::new(field, &meta.target, library)
    }
}

pub fn question<'a>(case: &'a Case, library: &'a Library) -> Question<'a> {
    question_of_logs(&case.meta, &case.field, case.baseline.as_ref(), case.eval.as_ref(), library)
}
