//! Diagnosis of a case.

use fos_data::case::{Case, CaseMeta};
use fos_data::recording::Recording;

use crate::detect::Question;
use crate::effects::Library;

/// Returns the question for logs of a case: explain the error in `log` and correct it in `evaluation`.
pub fn question_of_logs<'a>(
    meta: &'a CaseMeta,
    log: &'a Recording,
    reference: Option<&'a Recording>,
    evaluation: Option<&'a Recording>,
    library: &'a Library,
) -> Question<'a> {
    Question {
        reference,
        evaluation,
        sheet: meta.data_sheet(),
        full_scale: meta.full_scale(),
        lsb: meta.lsb(),
        ..Question::new(log, &meta.target, library)
    }
}

pub fn question<'a>(case: &'a Case, library: &'a Library) -> Question<'a> {
    question_of_logs(&case.meta, &case.log, case.reference.as_ref(), case.evaluation.as_ref(), library)
}
