//! Diagnosis in the order faults of the data, spectral lines, slow effects, open search; and the estimation of given
//! effects.

use std::collections::BTreeSet;
use std::sync::Arc;

use fos_data::column::{AXES, Column};
use fos_data::disturbance;

use super::answer::{Diagnosis, Finding, Untested};
use super::cleaned::Cleaned;
use super::dead_zone::Searched;
use super::error_in_blocks::ErrorInBlocks;
use super::faults::Fault;
use super::findings::Assembly;
use super::hypothesis::Hypotheses;
use super::left_over::{LeftOver, left_over};
use super::lines::{self, Line};
use super::power::Power;
use super::prepared::Prepared;
use super::question::{DiagnoseError, Question};
use super::slow::{SlowResult, SlowSearch};
use super::telegraph::{self, Telegraph};
use super::testable::{Testable, lacking};
use crate::effects::{Detector, Effect, Inputs};

/// Diagnoses the missing effects of an axis.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let mut diagnosis = diagnose_cleaned(&logs.question(question), logs.zone())?;
    diagnosis.cautions.extend(logs.cautions());
    diagnosis.notes.extend(question.log.duty_cycle().map(|cycle| cycle.to_string()));
    diagnosis.moved = disturbance::describe_disturbances(question.log, logs.disturbances());
    Ok(diagnosis)
}

fn diagnose_cleaned(question: &Question<'_>, zone: Searched) -> Result<Diagnosis, DiagnoseError> {
    let mut prepared = Prepared::new(question)?;
    if let Searched::Found(zone) = zone {
        prepared.faults.push(Fault::DeadZone(zone));
    }
    let stairs = prepared.hides_slow_effects();
    let lines = match stairs {
        true => Vec::new(),
        false => lines(question, &prepared.column, &prepared.reduced, prepared.shaken)?,
    };
    // in block means a line of a few hertz is an oscillation of minutes
    prepared.reduced.means = lines::means_without(&lines, &prepared.reduced, question.log);
    let Prepared { column, faults, reduced, given, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.log);
    let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, column);
    let hidden = stairs || prepared.is_short();
    let mut untested = prepared.testable.untested.clone();
    let mut effects = Vec::new();
    if !hidden {
        let attitude_effects = prepared.testable.attitude_effects(&hypotheses, &inputs, column)?;
        let tested = prepared.testable.effects.iter().filter(|effect| !is_among(&attitude_effects, effect));
        effects.extend(tested.cloned());
        untested.extend(attitude_effects);
    }
    let pass =
        |given: &[Vec<f64>], effects: &[Arc<Effect>]| -> Result<(SlowResult, LeftOver), DiagnoseError> {
            let slow = SlowSearch { given, ..prepared.search(&hypotheses, effects) }.run()?;
            let left = match hidden {
                true => LeftOver::default(),
                false => left_over(question, column, reduced, given, &slow, (faults.is_empty(), *shaken)),
            };
            Ok((slow, left))
        };
    let (mut slow, mut left) = loop {
        let (slow, left) = pass(given, &effects)?;
        let implausible = Power::of(&prepared, &hypotheses, &slow, &inputs).implausible()?;
        if implausible.is_empty() {
            break (slow, left);
        }
        effects.retain(|effect| !is_among(&implausible, effect));
        untested.extend(implausible);
    };
    let mut given = given.clone();
    let mut telegraph = match hidden || *shaken {
        true => None,
        false => telegraph::instead(&prepared, &slow, &left),
    };
    if let Some(lead) =
        telegraph.as_ref().and_then(|found| telegraph::decided(found, &prepared, question.log))
    {
        telegraph = None;
        left = LeftOver { leads: vec![lead], instead: true, ..LeftOver::default() };
    }
    if let Some(found) = &telegraph {
        let with_telegraph = [given.as_slice(), std::slice::from_ref(&found.course)].concat();
        let again = pass(&with_telegraph, &effects)?;
        match found.leaves_noise(&again.0) {
            true => (given, (slow, left)) = (with_telegraph, again),
            false => telegraph = None,
        }
    }
    let silent = slow.silent.iter().map(|effect| Testable::adds_nothing(effect, &inputs, column));
    untested.extend(silent);
    let mut lacks = None;
    if hidden {
        let needs = match stairs {
            true => "samples that are neither clipped nor in coarse steps nor in a dead zone".to_owned(),
            false => prepared.time_needed(question)?,
        };
        lacks = Some(needs.clone());
        let needs = vec![needs];
        let effects = prepared.testable.effects.iter();
        untested.extend(effects.map(|effect| Untested::of(effect, needs.clone())));
    }
    let was_tried = |effect: &&Arc<Effect>| slow.tried.iter().any(|(id, _)| *id == effect.id);
    let mut tested: Vec<&Arc<Effect>> = effects.iter().filter(was_tried).collect();
    let powerless = Power::of(&prepared, &hypotheses, &slow, &inputs).powerless(&tested)?;
    tested.retain(|effect| !is_among(&powerless, effect));
    if tested.is_empty() && lacks.is_none() {
        let needs: BTreeSet<&str> = untested.iter().chain(&powerless).flat_map(Untested::needs).collect();
        lacks = Some(format!("needed: {}", needs.into_iter().collect::<Vec<_>>().join(", ")));
    }
    untested.extend(powerless);
    if zone == Searched::NotShown {
        let effects = question.library.effects().iter();
        let zones = effects.filter(|effect| effect.search == Detector::DeadZone && effect.strikes(column));
        let needs = || vec!["slow turns about the axis to both sides".to_owned()];
        untested.extend(zones.map(|effect| Untested::of(effect, needs())));
    }
    let tested = tested.iter().map(|effect| effect.id.clone()).collect();
    let log_results = LogResults { left, telegraph: telegraph.as_ref(), tested, untested, lacks };
    assembly((&prepared, &given), question, &lines, &slow, log_results).diagnosis()
}

fn is_among(untested: &[Untested], effect: &Effect) -> bool {
    untested.iter().any(|other| other.effect == effect.id)
}

/// Estimates effects together, whether or not they are missing, in this order: parameters, sizes, and the reduction by
/// each with those before it in the model. Spectral lines are assigned in order of strength.
pub fn estimate(question: &Question<'_>, effects: &[String]) -> Result<Vec<Finding>, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let question = &logs.question(question);
    let prepared = Prepared::new(question)?;
    prepared.long_enough()?;
    let Prepared { column, reduced, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.log);
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
    let assembly = assembly((&prepared, &prepared.given), question, &lines, &slow, LogResults::default());
    let mut findings = assembly.slow_findings(&slow.found.iter().collect::<Vec<_>>())?;
    findings.extend(assembly.line_findings()?);
    effects
        .iter()
        .map(|id| {
            let at = findings.iter().position(|finding| finding.effect == *id);
            let found = at.map(|at| findings.remove(at));
            found.filter(|finding| !finding.correction.is_empty()).ok_or_else(|| {
                let experiment = question.library.get(id).map_or("", |effect| effect.experiment.as_str());
                let reason = format!(
                    "its inputs do not change, or it stays within the noise\nhelp: record a log that shows it: {experiment}"
                );
                not_there(id, &reason)
            })
        })
        .collect()
}

/// Results about the log itself, which an estimate does not have.
#[derive(Default)]
struct LogResults<'t> {
    left: LeftOver,
    telegraph: Option<&'t Telegraph>,
    tested: Vec<String>,
    untested: Vec<Untested>,
    lacks: Option<String>,
}

fn assembly<'s>(
    (prepared, given): (&'s Prepared, &'s [Vec<f64>]),
    question: &'s Question<'s>,
    lines: &'s [Line],
    slow: &'s SlowResult,
    log_results: LogResults<'s>,
) -> Assembly<'s> {
    let Prepared { column, faults, reduced, .. } = prepared;
    let learnt_from = learnt_from(question);
    let LogResults { left, telegraph, tested, untested, lacks } = log_results;
    Assembly {
        question,
        column,
        reduced,
        given,
        faults,
        lines,
        slow,
        left,
        telegraph,
        tested,
        untested,
        lacks,
        learnt_from,
    }
}

fn learnt_from(question: &Question<'_>) -> String {
    match (question.sheet.is_some(), question.reference.is_some()) {
        (true, true) => "the reference log, with the data sheet as prior",
        (false, true) => "the reference log",
        (true, false) => "the data sheet; there is no reference log",
        (false, false) => "the log itself; there is neither a reference log nor a data sheet",
    }
    .to_owned()
}

/// Finds spectral lines that are errors of the sensor. Motion is excluded: on a shaker or near a machine, lines that
/// another axis shows too; anywhere, intermittent or wandering lines that several axes show.
fn lines(
    question: &Question<'_>,
    column: &str,
    reduced: &ErrorInBlocks,
    shaken: bool,
) -> Result<Vec<Line>, DiagnoseError> {
    let mut lines = lines::of(reduced, question.log);
    if shaken {
        lines.retain(|line| line.duty >= lines::STEADY);
    }
    let may_be_motion = |line: &Line| shaken || !line.coherent || line.duty < lines::STEADY;
    for other in AXES.into_iter().filter(|other| *other != column) {
        if !lines.iter().any(may_be_motion) {
            break;
        }
        if question.log.channel(other).is_ok() {
            let same_unit = Column::named(other).unit() == Column::named(column).unit();
            let other = ErrorInBlocks::new(question.log, other, &[])?;
            let mut shared = lines::shared(question.log, &other, &lines, same_unit).into_iter();
            lines.retain(|line| !(shared.next().unwrap_or(false) && may_be_motion(line)));
        }
    }
    Ok(lines)
}
