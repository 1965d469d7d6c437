//! Execution of tasks: from the results so far to a change of them.

use fos_data::column::Column;
use std::path::Path;
use std::sync::Arc;

use super::job::Job;
use super::known::{Change, KnownAxis, Read, Snapshot};
use super::task::{LogFiles, Open, Task};
use fos_calibrate::{Imu, Options, calibrate};
use fos_data::file::{make_folder, name_of};
use fos_data::recording::{LoadOptions, Recording, load};
use fos_diagnose::compare::study_of;
use fos_diagnose::detect::{Diagnosis, with_shared_signal};
use fos_diagnose::effects::Library;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{Refinement, Study};
use fos_fit::fit::{FitOptions, fit_axis, rest};
use fos_report::examine::examine;
use fos_report::{AxisSection, Summaries};
use fos_simulate::{HIDDEN_IN, hidden_effects};

/// Seed of the built-in example: three logs of a simulated device with hidden effects, written as files so that the command lines on the
/// page can be used.
const EXAMPLE_SEED: u64 = 1;

/// Runs a task.
///
/// # Errors
///
/// The reason in words, with its remedy.
pub(super) fn run(
    task: &Task,
    known: &Snapshot,
    library: &Library,
    progress: &dyn Fn(Job),
) -> Result<Change, String> {
    match task {
        Task::Read(open) => read(open, progress),
        Task::Fit(column) => fit(column, known, library),
        Task::Examine(column) => compare(column, known, progress),
        Task::Diagnose(column) => diagnose(column, known, library),
        Task::ShareSignal => share_signal(known),
        Task::Add { column, effect } => add(column, effect, known, library),
        Task::Undo { column, keep } => undo(column, *keep, known),
    }
}

fn in_text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn read(open: &Open, progress: &dyn Fn(Job)) -> Result<Change, String> {
    let stored = match open {
        Open::Stored(study) => Some(Arc::clone(study)),
        _ => None,
    };
    let (logs, first) = match (open, open.files()) {
        (Open::Example(folder), _) => {
            make_folder(folder).map_err(in_text)?;
            let [reference, log, later] = hidden_effects(folder, EXAMPLE_SEED).map_err(in_text)?;
            let (reference, evaluation) = (Some(reference), Some(later));
            let logs = Logs { log, reference, evaluation, read: LoadOptions::default() };
            (logs, Some(HIDDEN_IN.to_owned()))
        }
        (_, None) => return Err("the study names no log".to_owned()),
        (_, Some(LogFiles { log, reference, evaluation, read: options })) => {
            let (log, reference, evaluation, options) = (&log, &reference, &evaluation, &options);
            let wanted = [Some(log), reference.as_ref(), evaluation.as_ref()].into_iter().flatten().count();
            let mut done = 0;
            let mut read = |path: &String| -> Result<Recording, String> {
                progress(Job::step(format!("reading {}", name_of(path)), done, wanted));
                done += 1;
                load(Path::new(path), options).map(Recording::with_monotonic_time).map_err(in_text)
            };
            let logs = Logs {
                log: read(log)?,
                reference: reference.as_ref().map(&mut read).transpose()?,
                evaluation: evaluation.as_ref().map(&mut read).transpose()?,
                read: options.clone(),
            };
            (logs, None)
        }
    };
    if let Some(study) = &stored {
        refuse_other_logs(study, &logs)?;
    }
    let axes = logs.log.axes().map_err(in_text)?;
    // the gyros first: their error integrates twice as fast
    let first = first
        .or_else(|| axes.iter().find(|axis| Column::named(axis).is_angular_rate()).or(axes.first()).cloned());
    let summaries = Summaries::of(&logs);
    let calibration = Imu::of(&logs.log).and_then(|imu| calibrate(&imu, &Options::default())).ok();
    Ok(Change::Read { read: Box::new(Read { logs, summaries, axes, calibration, stored }), first })
}

/// # Errors
///
/// A log is not the one that the study was made of.
fn refuse_other_logs(study: &Study, logs: &Logs) -> Result<(), String> {
    let Some(refinement) = study.refinements.first() else { return Ok(()) };
    let then = &refinement.logs;
    let pairs = [
        (Some(&then.log), Some(&logs.log)),
        (then.reference.as_ref(), logs.reference.as_ref()),
        (then.evaluation.as_ref(), logs.evaluation.as_ref()),
    ];
    let changed = pairs.into_iter().find(|(then, now)| *then != now.and_then(|log| log.sources.first()));
    match changed.and_then(|(then, _)| then) {
        Some(source) => Err(format!(
            "{}: changed since the study was stored\nhelp: put the log back as it was, or read it again under Columns",
            source.path
        )),
        None => Ok(()),
    }
}

fn fit(column: &str, known: &Snapshot, library: &Library) -> Result<Change, String> {
    let read = known.read()?;
    let logs = &read.logs;
    let own = logs.reference.as_ref().unwrap_or(&logs.log);
    let stored = read.stored.as_ref().and_then(|study| Some((study, study.refinement_of(column)?)));
    let study = match stored {
        // the stored model of a refined axis is the refined one
        Some((study, refinement)) if refinement.added().next().is_none() => {
            let mut study = study.only(column).map_err(in_text)?;
            // the same logs, with the paths under which they were found now
            study.data.sources.clone_from(&own.sources);
            study
        }
        _ => {
            let options = FitOptions::default();
            let stillness = rest(own, options.train);
            let fitted = fit_axis(own, &stillness, column, &options).map_err(in_text)?;
            study_of(own, &stillness, vec![fitted], options, logs.read.clone(), &mut |_| {})
                .map_err(in_text)?
        }
    };
    let refiner = logs.refiner(library);
    let named = logs.named(refiner.fitted_rows());
    let refinement = match stored {
        Some((stored, _)) => refiner.resume(stored, column, named.clone()),
        None => refiner.begin(&study, column, named.clone()),
    };
    let refinement = Refinement { logs: named, ..refinement.map_err(in_text)? };
    let section = AxisSection::of(&study, &refinement);
    Ok(change(column, move |axis| {
        (axis.fitted, axis.refinement, axis.section) = (Some(Arc::new(study)), Some(refinement), section);
    }))
}

fn compare(column: &str, known: &Snapshot, progress: &dyn Fn(Job)) -> Result<Change, String> {
    let (study, refinement) = known.fitted(column)?;
    let mut done = 0;
    let mut evaluation = |what: &str| {
        progress(Job::step(format!("comparing {}: {what}", Column::named(column).label()), done, 4));
        done += 1;
    };
    let examination = examine(study, refinement, &known.read()?.logs, &mut evaluation).map_err(in_text)?;
    Ok(change(column, move |axis| {
        axis.section = axis.section.clone().examined(&examination);
        (axis.examination, axis.examined) = (Some(Arc::new(examination)), true);
    }))
}

fn diagnose(column: &str, known: &Snapshot, library: &Library) -> Result<Change, String> {
    let (study, refinement) = known.fitted(column)?;
    let section = AxisSection::of(study, refinement);
    let logs = &known.read()?.logs;
    let found = section.diagnosed(refinement, &logs.refiner(library), &logs.log).map_err(in_text)?;
    Ok(change(column, move |axis| {
        axis.alone = found.diagnosis.clone();
        (axis.section.diagnosis, axis.section.offers) = (found.diagnosis, found.offers);
    }))
}

/// Returns the diagnoses with the slow signal that their axes share, as the command line does for a whole log.
fn share_signal(known: &Snapshot) -> Result<Change, String> {
    let diagnosed: Vec<(&Diagnosis, &KnownAxis)> =
        known.axes.iter().filter_map(|axis| Some((axis.alone.as_ref()?, axis))).collect();
    let answers = diagnosed.iter().map(|(alone, axis)| {
        let mut answer = (*alone).clone();
        // effects in the model explain the axis too
        let added = axis.refinement.iter().flat_map(Refinement::added).map(|added| added.finding.clone());
        answer.findings.extend(added);
        answer
    });
    let mut shared = with_shared_signal(answers.collect(), &known.read()?.logs.log).map_err(in_text)?;
    for (answer, (alone, _)) in shared.iter_mut().zip(&diagnosed) {
        answer.findings.clone_from(&alone.findings);
    }
    Ok(Change::Diagnoses(shared))
}

fn add(column: &str, effect: &str, known: &Snapshot, library: &Library) -> Result<Change, String> {
    let (study, refinement) = known.fitted(column)?;
    let refiner = known.read()?.logs.refiner(library);
    let step = refiner.add(refinement, library.get(effect).map_err(in_text)?).map_err(in_text)?;
    let mut refined = refinement.clone();
    refined.steps.push(step);
    Ok(refined_anew(study, refined))
}

fn undo(column: &str, keep: usize, known: &Snapshot) -> Result<Change, String> {
    let (study, refinement) = known.fitted(column)?;
    let mut kept = refinement.clone();
    // the first step is the state before anything was added
    kept.steps.truncate(keep.saturating_add(1));
    Ok(refined_anew(study, kept))
}

/// Changes the refinement of an axis, and drops the results for the model before.
fn refined_anew(study: &Study, refinement: Refinement) -> Change {
    let section = AxisSection::of(study, &refinement);
    change(&refinement.column.clone(), move |axis| {
        // the figure of the model before stays until the new one is there
        let (comparison, evaluated_s) = (axis.section.comparison.take(), axis.section.evaluated_s);
        let is_refined = refinement.added().next().is_some();
        axis.before = match axis.before.take().filter(|_| is_refined) {
            None if is_refined => axis.examination.clone(),
            before => before,
        };
        (axis.refinement, axis.section) =
            (Some(refinement), AxisSection { comparison, evaluated_s, ..section });
        (axis.examined, axis.alone) = (false, None);
    })
}

fn change(column: &str, edit: impl FnOnce(&mut KnownAxis) + Send + 'static) -> Change {
    Change::Axis { column: column.to_owned(), edit: Box::new(edit) }
}
