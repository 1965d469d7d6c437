//! What is missing: faults of the data, then lines, then slow effects, then what no library knows; and effects
//! estimated whether they are missing or not.

use std::sync::Arc;

use fos_data::column::{AXES, Column};
use fos_data::disturbance;

use super::answer::{Diagnosis, Finding, Untested};
use super::cleaned::Cleaned;
use super::error_in_blocks::ErrorInBlocks;
use super::findings::Assembly;
use super::hypothesis::Hypotheses;
use super::left_over::{LeftOver, left_over};
use super::lines::{self, Line};
use super::prepared::Prepared;
use super::question::{DiagnoseError, MIN_BLOCKS, Question};
use super::slow::SlowResult;
use super::testable::{Testable, lacking};
use crate::effects::{Band, Detector, Inputs};

/// Says what is missing.
///
/// # Errors
///
/// A column is missing, or the log is too short.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let mut diagnosis = diagnose_cleaned(&logs.question(question))?;
    diagnosis.cautions.extend(logs.cautions());
    diagnosis.moved = disturbance::told(question.field, logs.disturbances());
    Ok(diagnosis)
}

fn diagnose_cleaned(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let prepared = Prepared::new(question)?;
    let Prepared { column, faults, reduced, given, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.field);
    let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, column);
    let stairs = prepared.in_stairs();
    let hidden = stairs || prepared.is_short();
    let effects = if hidden { &[][..] } else { &prepared.testable.effects };
    let lines = if stairs { Vec::new() } else { lines(question, column, reduced, *shaken)? };
    let slow = prepared.search(&hypotheses, effects).run()?;
    let left = match hidden {
        true => LeftOver::default(),
        false => left_over(question, column, reduced, given, &slow, (faults.is_empty(), *shaken)),
    };
    let mut untested = prepared.testable.untested.clone();
    let silent = slow.silent.iter().map(|effect| Testable::adds_nothing(effect, &inputs, column));
    untested.extend(silent);
    if hidden {
        let needs = match stairs {
            true => "samples that are neither clipped nor in coarse steps".to_owned(),
            false => {
                format!("a log of {:.0} s and more at rest", MIN_BLOCKS as f64 * reduced.blocks.length_s)
            }
        };
        let needs = vec![needs];
        let effects = prepared.testable.effects.iter();
        untested.extend(effects.map(|effect| Untested { effect: effect.id.clone(), needs: needs.clone() }));
    }
    assembly(&prepared, question, &lines, &slow, left, untested).diagnosis()
}

/// Estimates effects together whether they are missing or not, in this order: their parameters, sizes, and the fall
/// that each should bring once those before it are in the model. Several lines are taken by their strength.
///
/// # Errors
///
/// A column is missing, the log is too short, or an effect leaves nothing in it.
pub fn estimate(question: &Question<'_>, effects: &[String]) -> Result<Vec<Finding>, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let question = &logs.question(question);
    let prepared = Prepared::new(question)?;
    prepared.long_enough()?;
    let Prepared { column, reduced, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.field);
    let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, column);
    let not_there = |effect: &str, reason: &str| DiagnoseError::NotThere {
        effect: effect.to_owned(),
        reason: reason.to_owned(),
    };
    let mut wanted = Vec::new();
    for id in effects {
        let effect = question.library.get(id)?;
        match lacking(effect, &inputs, column) {
            None => return Err(not_there(id, &format!("it does not strike {column}"))),
            Some(missing) if !missing.is_empty() => {
                return Err(not_there(id, &format!("the log has no {}", missing.join(", "))));
            }
            Some(_) if matches!(effect.search, Detector::Terms | Detector::Step) => {
                wanted.push(Arc::new(effect.clone()));
            }
            Some(_) => {}
        }
    }
    let slow = prepared.search(&hypotheses, &prepared.testable.effects).estimate(&wanted)?;
    let lines = lines(question, column, reduced, *shaken)?;
    let assembly = assembly(&prepared, question, &lines, &slow, LeftOver::default(), Vec::new());
    let mut slow_findings = assembly.slow_findings(slow.found.iter().collect())?.into_iter();
    let mut line_findings = assembly.line_findings()?.into_iter();
    effects
        .iter()
        .map(|id| {
            let found = match question.library.get(id)?.band {
                Band::Wide => line_findings.find(|finding| finding.effect == *id),
                _ => slow_findings.find(|finding| finding.effect == *id),
            };
            found.filter(|finding| !finding.correction.is_empty()).ok_or_else(|| {
                not_there(
                    id,
                    "nothing of it shows: what it follows does not change, or it drowns in the noise",
                )
            })
        })
        .collect()
}

fn assembly<'s>(
    prepared: &'s Prepared,
    question: &'s Question<'s>,
    lines: &'s [Line],
    slow: &'s SlowResult,
    left: LeftOver,
    untested: Vec<Untested>,
) -> Assembly<'s> {
    let Prepared { column, faults, reduced, given, .. } = prepared;
    let learnt_from = learnt_from(question);
    Assembly { question, column, reduced, given, faults, lines, slow, left, untested, learnt_from }
}

fn learnt_from(question: &Question<'_>) -> String {
    match (question.sheet.is_some(), question.quiet.is_some()) {
        (true, true) => "the quiet log, with the data sheet as prior",
        (false, true) => "the quiet log",
        (true, false) => "the data sheet; no quiet log was given",
        (false, false) => "the log itself; neither a quiet log nor a data sheet was given",
    }
    .to_owned()
}

/// Lines that are errors. What moves the unit is none: on a shaker or beside a machine an axis rightly shows the lines
/// that others show too, and what comes and goes, or wanders, on several at once is motion wherever it is.
fn lines(
    question: &Question<'_>,
    column: &str,
    reduced: &ErrorInBlocks,
    shaken: bool,
) -> Result<Vec<Line>, DiagnoseError> {
    let mut lines = lines::of(reduced, question.field);
    if shaken {
        lines.retain(|line| line.duty >= lines::STEADY);
    }
    let is_asked = |line: &Line| shaken || !line.coherent || line.duty < lines::STEADY;
    for other in AXES.into_iter().filter(|other| *other != column) {
        if !lines.iter().any(is_asked) {
            break;
        }
        if question.field.channel(other).is_ok() {
            let is_of_unit = Column::named(other).unit() == Column::named(column).unit();
            let other = ErrorInBlocks::new(question.field, other, &[])?;
            let mut shared = lines::shared(question.field, &other, &lines, is_of_unit).into_iter();
            lines.retain(|line| !(shared.next().unwrap_or(false) && is_asked(line)));
        }
    }
    Ok(lines)
}
