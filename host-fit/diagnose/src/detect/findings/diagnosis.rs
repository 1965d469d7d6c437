//! Findings and leads put together to an answer.

use super::assembly::Assembly;
use super::verdict::{outweighed, sentence};
use crate::detect::answer::{Diagnosis, Finding, NoiseReport, Rejected, Verdict};
use crate::detect::lines;
use crate::detect::open::Lead;
use crate::detect::question::DiagnoseError;
use crate::detect::shape::Misshape;
use crate::detect::slow::Found;
use crate::effects::{Band, Detector};
use fos_data::column::Column;

/// More steps than this are jumps to and fro and no longer a shock.
const MOST_STEPS: usize = 1;

impl Assembly<'_> {
    /// The answer.
    pub(crate) fn diagnosis(self) -> Result<Diagnosis, DiagnoseError> {
        let mut findings = self.fault_findings()?;
        let mut others = self.line_findings()?;
        let mut order: Vec<&Found> = self.slow.found.iter().collect();
        order.sort_by(|a, b| b.score.total_cmp(&a.score));
        others.extend(self.slow_findings(order)?);
        others.extend(self.noise_finding()?);
        others.sort_by(|a, b| b.score.total_cmp(&a.score));
        findings.extend(others);

        let mut leads = self.left.leads.clone();
        leads.extend(self.left.misshapes.iter().map(lead_of));
        if self.left.instead {
            let library = self.question.library;
            findings.retain(|finding| {
                let effect = library.get(&finding.effect);
                finding.band != Band::Stochastic
                    && (finding.band != Band::Slow
                        || effect.is_ok_and(|effect| !effect.follows_clock_alone()))
            });
        }
        let is_step = |finding: &Finding| {
            let effect = self.question.library.get(&finding.effect);
            effect.is_ok_and(|effect| effect.search == Detector::Step)
        };
        let steps = findings.iter().filter(|finding| is_step(finding)).count();
        if steps > MOST_STEPS {
            let gain = findings.iter().filter(|finding| is_step(finding)).map(|finding| finding.gain).sum();
            leads.push(Lead { follows: format!("{steps} jumps of the bias"), gain, score: gain, share: 0.0 });
            findings.retain(|finding| !is_step(finding));
        }
        for line in self.lines.iter().filter(|line| line.duty < lines::STEADY) {
            let share = match line.duty {
                duty if duty < 0.01 => "less than 1 %".to_owned(),
                duty => format!("{:.0} %", 100.0 * duty),
            };
            let follows = format!(
                "interference near {:.2} Hz that is there for {share} of the time",
                line.frequency_hz
            );
            leads.push(Lead { follows, gain: line.score, score: line.score, share: 0.0 });
        }
        leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        let verdict = match (leads.is_empty(), findings.is_empty()) {
            (false, _) => Verdict::Unexplained,
            (true, false) => Verdict::Missing,
            (true, true) => Verdict::NothingMissing,
        };
        if verdict == Verdict::Unexplained {
            outweighed(&mut findings, &leads);
        }
        let found: Vec<&str> = findings.iter().map(|finding| finding.effect.as_str()).collect();
        let rejected = self
            .slow
            .tried
            .iter()
            .filter(|(id, _)| !found.contains(&id.as_str()))
            .map(|(id, score)| Rejected { effect: id.clone(), score: *score })
            .collect();
        let mut cautions = Vec::new();
        if self.question.quiet.is_none() {
            cautions
                .push("no quiet log: slow wander of the sensor itself may be taken for an effect".to_owned());
        }
        Ok(Diagnosis {
            target: self.column.to_owned(),
            unit: Column::named(self.column).unit().label().to_owned(),
            verdict,
            sentence: sentence(verdict, &findings, &leads),
            findings,
            leads,
            rejected,
            untested: self.untested,
            noise: NoiseReport {
                levels: self.slow.fitted.levels,
                learnt_from: self.learnt_from,
                block_s: self.reduced.blocks.length_s,
                blocks: self.reduced.blocks.len(),
            },
            cautions,
        })
    }
}

fn lead_of(misshape: &Misshape) -> Lead {
    match misshape {
        Misshape::Jumps { kurtosis, gain } => Lead {
            follows: format!("jumps at moments of their own (excess kurtosis {kurtosis:.1} of what is left)"),
            gain: *gain,
            score: *kurtosis,
            share: 0.0,
        },
        Misshape::Level { follows, spread, score } => Lead {
            follows: match follows {
                Some(column) => {
                    format!("a noise level that changes by {:.0} % with {column}", 100.0 * spread)
                }
                None => format!("a noise level that changes by {:.0} % over the log", 100.0 * spread),
            },
            gain: *score,
            score: *score,
            share: 0.0,
        },
    }
}
