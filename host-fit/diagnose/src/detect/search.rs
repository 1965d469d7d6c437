//! Second stage of a diagnosis: the searches for slow effects, for a bias that jumps between two levels, and in the
//! residual. Faults of the data and spectral lines are found in the preparation.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::answer::Untested;
use super::left_over::{LeftOver, left_over};
use super::lines::Line;
use super::power::Power;
use super::prepared::Prepared;
use super::question::DiagnoseError;
use super::slow::SlowResult;
use super::telegraph::{self, Telegraph};
use super::testable::Testable;
use crate::effects::{Detector, Effect};

/// Results of all searches in a prepared log.
pub(super) struct SearchResults {
    pub(super) lines: Vec<Line>,
    pub(super) slow: SlowResult,
    /// Regressors of every model: the constant, the effects that the model already has, and a course of two levels.
    pub(super) given: Vec<Vec<f64>>,
    pub(super) left: LeftOver,
    pub(super) telegraph: Option<Telegraph>,
    /// Identifiers of the slow effects that the log could have shown.
    pub(super) tested: Vec<String>,
    pub(super) untested: Vec<Untested>,
    /// Data that the log lacks for a test of any slow effect.
    pub(super) lacks: Option<String>,
}

impl SearchResults {
    /// Runs the searches in block means, which are free of `lines`.
    pub(super) fn of(prepared: &Prepared<'_>, lines: Vec<Line>) -> Result<Self, DiagnoseError> {
        let mut found = match prepared.lacks()? {
            None => Self::of_slow_effects(prepared, lines)?,
            Some(lacks) => Self::without_test(prepared, lines, lacks)?,
        };
        if prepared.hides_dead_zone() {
            let effects = prepared.library().effects().iter();
            let zones = effects
                .filter(|effect| effect.search == Detector::DeadZone && effect.strikes(&prepared.column));
            let needs = || vec!["slow turns about the axis to both sides".to_owned()];
            found.untested.extend(zones.map(|effect| Untested::of(effect, needs())));
        }
        Ok(found)
    }

    /// Estimates these effects together, whether or not they are missing, and the lines.
    pub(super) fn of_effects(prepared: &Prepared<'_>, wanted: &[Arc<Effect>]) -> Result<Self, DiagnoseError> {
        let slow = prepared.slow_search(&prepared.given, &prepared.testable.effects).estimate(wanted)?;
        Ok(Self::without_open_search(prepared, prepared.lines()?, slow))
    }

    fn without_open_search(prepared: &Prepared<'_>, lines: Vec<Line>, slow: SlowResult) -> Self {
        Self {
            lines,
            slow,
            given: prepared.given.clone(),
            left: LeftOver::default(),
            telegraph: None,
            tested: Vec::new(),
            untested: prepared.testable.untested.clone(),
            lacks: None,
        }
    }

    /// The noise of a log that cannot show a slow effect.
    fn without_test(prepared: &Prepared<'_>, lines: Vec<Line>, lacks: String) -> Result<Self, DiagnoseError> {
        let slow = prepared.slow_search(&prepared.given, &[]).run()?;
        let mut found = Self::without_open_search(prepared, lines, slow);
        let effects = prepared.testable.effects.iter();
        found.untested.extend(effects.map(|effect| Untested::of(effect, vec![lacks.clone()])));
        Ok(Self { lacks: Some(lacks), ..found })
    }

    /// Searches for slow effects until every finding is plausible, and in the residual.
    fn of_slow_effects(prepared: &Prepared<'_>, lines: Vec<Line>) -> Result<Self, DiagnoseError> {
        let mut effects = prepared.testable.effects.clone();
        let mut untested = prepared.testable.untested.clone();
        let attitude_effects = prepared.testable.attitude_effects(&prepared.hypotheses, &prepared.column)?;
        exclude(&mut effects, &mut untested, attitude_effects);
        // terminates: each iteration excludes an effect, or is the last
        let (mut slow, mut left) = loop {
            let (slow, left) = search_beside(prepared, &prepared.given, &effects)?;
            let implausible = Power { prepared, slow: &slow }.implausible()?;
            if implausible.is_empty() {
                break (slow, left);
            }
            exclude(&mut effects, &mut untested, implausible);
        };

        let mut given = prepared.given.clone();
        let mut telegraph = match prepared.shaken {
            true => None,
            false => telegraph::instead(prepared, &slow, &left),
        };
        if let Some(lead) = telegraph.as_ref().and_then(|found| telegraph::decided(found, prepared)) {
            telegraph = None;
            left = LeftOver { leads: vec![lead], instead: true, ..LeftOver::default() };
        }
        if let Some(found) = &telegraph {
            let with_telegraph = [given.as_slice(), std::slice::from_ref(&found.course)].concat();
            let again = search_beside(prepared, &with_telegraph, &effects)?;
            match found.leaves_noise(&again.0) {
                true => (given, (slow, left)) = (with_telegraph, again),
                false => telegraph = None,
            }
        }

        let adds_nothing =
            |effect: &Arc<Effect>| Testable::adds_nothing(effect, prepared.inputs(), &prepared.column);
        untested.extend(slow.silent.iter().map(adds_nothing));
        let was_tried = |effect: &Arc<Effect>| slow.tried.iter().any(|(id, _)| *id == effect.id);
        effects.retain(was_tried);
        let powerless = Power { prepared, slow: &slow }.powerless(&effects)?;
        exclude(&mut effects, &mut untested, powerless);
        let lacks = effects.is_empty().then(|| {
            let needs: BTreeSet<&str> = untested.iter().flat_map(Untested::needs).collect();
            format!("needed: {}", needs.into_iter().collect::<Vec<_>>().join(", "))
        });
        let tested = effects.iter().map(|effect| effect.id.clone()).collect();
        Ok(Self { lines, slow, given, left, telegraph, tested, untested, lacks })
    }
}

/// Searches for slow effects beside the regressors `given`, then in the residual.
fn search_beside(
    prepared: &Prepared<'_>,
    given: &[Vec<f64>],
    effects: &[Arc<Effect>],
) -> Result<(SlowResult, LeftOver), DiagnoseError> {
    let slow = prepared.slow_search(given, effects).run()?;
    let left = left_over(prepared, given, &slow);
    Ok((slow, left))
}

/// Moves effects that the log cannot show from those that are tested to the untested ones.
fn exclude(effects: &mut Vec<Arc<Effect>>, untested: &mut Vec<Untested>, hidden: Vec<Untested>) {
    effects.retain(|effect| hidden.iter().all(|other| other.effect != effect.id));
    untested.extend(hidden);
}
