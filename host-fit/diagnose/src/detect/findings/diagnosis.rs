//! Composition of a diagnosis from findings and leads.

use super::Composer;
use super::doubt::{beyond_typical, doubt};
use super::verdict::{faults, sentence, verdict};
use crate::detect::answer::{Diagnosis, Finding, NoiseReport, Verdict};
use crate::detect::lines;
use crate::detect::open::{Lead, LeadKind};
use crate::detect::question::DiagnoseError;
use crate::detect::shape::Level;
use crate::effects::{Band, Detector};
use fos_data::column::Column;

/// Largest number of steps, including those in the model, that count as shocks; more are jumps to and fro.
const MAX_STEPS: usize = 2;

/// Least duty cycle of interference that affects the verdict.
const LEAST_DUTY: f64 = 0.01;

impl Composer<'_> {
    pub(in crate::detect) fn diagnosis(self) -> Result<Diagnosis, DiagnoseError> {
        let mut findings = self.line_findings()?;
        // what hides slow effects also raises the noise
        if self.results.lacks.is_none() {
            findings.extend(self.noise_finding()?);
        }
        findings.extend(self.telegraph_finding()?);
        findings.extend(self.level_finding()?);
        let score = |finding: &Finding| finding.score.unwrap_or(f64::NEG_INFINITY);
        let slow = self.slow_findings_with_doubts()?;
        // slow effects keep their order among the others: each ranks as high as the highest of those that follow it
        let rank = |at: usize| slow[at..].iter().map(score).fold(f64::NEG_INFINITY, f64::max);
        let ranks: Vec<f64> = (0..slow.len()).map(rank).collect();
        let mut ranked: Vec<(f64, Finding)> = ranks.into_iter().zip(slow).collect();
        ranked.extend(findings.into_iter().map(|finding| (score(&finding), finding)));
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let mut findings: Vec<Finding> = ranked.into_iter().map(|(_, finding)| finding).collect();
        // a fault of the data explains no drift, so it comes after the effects
        findings.extend(self.fault_findings()?);

        let mut leads = self.results.left.leads.clone();
        leads.extend(self.results.left.jumps.clone());
        // an effect of the library describes a level that follows the temperature
        let level = self.results.left.level.as_ref().filter(|level| level.temperature_slope().is_none());
        leads.extend(level.map(Level::lead));
        if self.results.left.instead {
            let library = self.prepared.library();
            findings.retain(|finding| {
                let effect = library.get(&finding.effect);
                finding.band != Band::Stochastic
                    && (finding.band != Band::Slow
                        || effect.is_ok_and(|effect| !effect.follows_clock_alone()))
            });
        }
        let is_step = |id: &str| {
            let effect = self.prepared.library().get(id);
            effect.is_ok_and(|effect| effect.search == Detector::Step)
        };
        let step_findings = findings.iter().filter(|finding| is_step(&finding.effect));
        let gains: Vec<f64> = step_findings.filter_map(|finding| finding.gain).collect();
        let steps = gains.len();
        let given = self.prepared.effects_in_model().iter().filter(|given| is_step(&given.effect)).count();
        if steps > 0 && steps + given > MAX_STEPS {
            let follows = format!("{steps} jumps of the bias");
            leads.push(Lead::new(LeadKind::Jumps, follows, Band::Slow, gains.iter().sum()));
            findings.retain(|finding| !is_step(&finding.effect));
        }
        for line in self.results.lines.iter().filter(|line| line.duty < lines::STEADY) {
            let share = match line.duty {
                duty if duty < LEAST_DUTY => "less than 1 %".to_owned(),
                duty => format!("{:.0} %", 100.0 * duty),
            };
            let follows = format!(
                "interference near {:.2} Hz that is there for {share} of the time",
                line.frequency_hz
            );
            let lead = Lead::new(LeadKind::Intermittent, follows, Band::Wide, line.score);
            leads.push(Lead { decides: line.duty >= LEAST_DUTY, ..lead });
        }
        findings.sort_by_key(|finding| (finding.band == Band::Data, finding.doubt.is_some()));
        let all_findings = findings.clone();
        leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        let verdict = verdict(&mut findings, &leads, !self.results.tested.is_empty());
        let rejected = self.rejected(&findings, &all_findings, &leads);
        let mut cautions = beyond_typical(&findings, self.prepared.library(), &self.prepared.column);
        if !self.prepared.has_reference() {
            cautions
                .push("no reference log: the noise was estimated from this log, so slow drift of the sensor may be mistaken for an effect, and a spectral line of the sensor for interference; record 10 min at rest with the same device and pass it as `reference`".to_owned());
        }
        cautions.extend(self.prepared.cautions());
        Ok(Diagnosis {
            target: self.prepared.column.clone(),
            unit: Column::named(&self.prepared.column).unit().label().to_owned(),
            verdict,
            sentence: match (verdict, &self.results.lacks) {
                (Verdict::NotEnoughData, Some(lacks)) => {
                    format!("Not enough data to test any slow effect: {lacks}.{}", faults(&findings))
                }
                _ => sentence(verdict, &findings, &leads),
            },
            findings,
            leads,
            rejected,
            tested: self.results.tested,
            untested: self.results.untested,
            noise: NoiseReport {
                levels: self.results.slow.fitted.levels,
                learnt_from: self.prepared.learnt_from().to_owned(),
                block_s: self.prepared.reduced.blocks.length_s,
                blocks: self.prepared.reduced.blocks.len(),
            },
            cautions,
            notes: self.prepared.duty_cycle().into_iter().collect(),
            moved: self.prepared.motion(),
            shared_signal: None,
        })
    }

    /// Returns the slow effects ordered by what they reduce, those that are not conclusive last. Predicted reductions
    /// depend on the order and doubts on the reductions, so each new order is predicted again.
    fn slow_findings_with_doubts(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let blocks = &self.prepared.reduced.blocks;
        let span_s = blocks.blocks.last().map_or(0.0, |last| (last.index + 1) as f64 * blocks.length_s);
        let mut order = self.by_reduction();
        for _ in 0..order.len() {
            let mut findings = self.slow_findings(&order)?;
            doubt(&mut findings, self.prepared.library(), &self.prepared.column, span_s);
            if findings.is_sorted_by_key(|finding| finding.doubt.is_some()) {
                return Ok(findings);
            }
            let (doubtful, conclusive): (Vec<_>, Vec<_>) =
                order.into_iter().zip(&findings).partition(|(_, finding)| finding.doubt.is_some());
            order = conclusive.into_iter().chain(doubtful).map(|(found, _)| found).collect();
        }
        let mut findings = self.slow_findings(&order)?;
        doubt(&mut findings, self.prepared.library(), &self.prepared.column, span_s);
        Ok(findings)
    }
}
