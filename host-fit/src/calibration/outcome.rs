//! One simulated case: its truth, the diagnosis, and the effect of the correction on a log not used for the fit.

use serde::{Deserialize, Serialize};

use super::error::CalibrationError;
use fos_data::case::CaseMeta;
use fos_data::column::AXES;
use fos_data::recording::Recording;
use fos_diagnose::case::question_of_logs;
use fos_diagnose::detect::{DiagnoseError, Diagnosis, ErrorInBlocks, Finding, Verdict, correction, diagnose};
use fos_diagnose::effects::Library;
use fos_fit::noise::{Gls, NoiseLevels};
use fos_fit::signal;
use fos_simulate::{AxisNoise, Band, CasePlan, Kind, LogTruth, SimulatedCase, simulate_case};

/// Smallest achievable reduction for which a ratio is computed.
const LEAST_FALL: f64 = 0.02;

/// Outcome of one case.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outcome {
    /// Number in the suite.
    pub case: usize,
    /// Purpose of the case.
    pub kind: Kind,
    /// Setup in words.
    pub setup: String,
    /// Diagnosed axis, such as `gx_rads`.
    pub target: String,
    /// Simulated effects: identifier, parameter, size, and size after the best rival.
    pub planted: Vec<PlantedIn>,
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// Findings, best first.
    pub found: Vec<FoundIn>,
    /// Best leads, below the threshold of a finding.
    pub leads: Vec<String>,
    /// Reduction on the evaluation log by the true regressors, fitted to the log to explain.
    #[serde(rename = "achievable_fall")]
    pub achievable_reduction: Option<f64>,
    /// Reduction on the evaluation log by the correction of the diagnosis.
    #[serde(rename = "realised_fall")]
    pub measured_reduction: Option<f64>,
    /// For a log without a missing effect whose axes were all diagnosed: every axis with a verdict or finding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alarms: Option<Vec<Alarm>>,
    /// Time for the diagnosis, without simulating or reading, s.
    pub seconds: f64,
}

/// A simulated effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantedIn {
    /// Identifier, as `thermal_lag`.
    pub effect: String,
    /// Name and value of the parameter.
    pub parameter: Option<(String, f64)>,
    /// Matched-filter size in the true noise.
    pub size: f64,
    /// Size after the best rival.
    pub left: Option<f64>,
    /// Identifier of that rival, if there is one.
    pub rival: Option<String>,
}

/// A finding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundIn {
    /// Identifier, as `thermal_lag`.
    pub effect: String,
    /// Name and value of the parameter.
    pub parameter: Option<(String, f64)>,
    /// Gain in −2 ln L after all penalties; accepted from 9, lines from 15. None for data faults.
    #[serde(default)]
    pub score: Option<f64>,
    /// Predicted reduction and its 90 % interval.
    pub expected: (f64, [f64; 2]),
    /// Identifiers of effects that are indistinguishable in this log.
    pub confounded_with: Vec<String>,
    /// An experiment is suggested for each rival.
    pub separated: bool,
}

/// A false alarm on an axis without a missing effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// Axis, such as `gx_rads`.
    pub target: String,
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// Identifiers of reported effects, or the channels on which the error depends.
    pub named: Vec<String>,
}

/// Simulates and diagnoses one case; with `every_axis` all axes of a log without a missing effect.
pub fn examine(
    case: usize,
    plan: &CasePlan,
    every_axis: bool,
    library: &Library,
) -> Result<Outcome, CalibrationError> {
    let simulated = simulate_case(plan).map_err(|source| CalibrationError::Plan { case, source })?;
    let failed = |source: DiagnoseError| CalibrationError::Diagnose { case, source: Box::new(source) };
    let [reference, log, evaluation] = simulated.recordings().map_err(|error| failed(error.into()))?;
    let SimulatedCase { meta, truth, .. } = simulated;
    let start = std::time::Instant::now();
    let answer = diagnose(&question_of_logs(&meta, &log, Some(&reference), Some(&evaluation), library))
        .map_err(failed)?;
    let seconds = start.elapsed().as_secs_f64();
    let logs = [&log, &reference, &evaluation];
    let alarms = match every_axis && plan.kind == Kind::Nothing {
        true => Some(alarms(&meta, logs, library).map_err(failed)?),
        false => None,
    };
    let corrected = Corrected { target: &meta.target, log: &log, evaluation: &evaluation };
    let wide = truth.planted.iter().any(|planted| planted.band == Band::Wide);
    let falls =
        corrected.falls(&answer, &truth.log, &truth.evaluation, &truth.noise, wide).map_err(failed)?;
    Ok(Outcome {
        case,
        kind: plan.kind,
        setup: format!("{:?}", plan.setup),
        target: meta.target.clone(),
        planted: truth
            .planted
            .iter()
            .map(|planted| PlantedIn {
                effect: planted.effect.to_string(),
                parameter: planted.params.iter().next().map(|(name, value)| ((*name).to_owned(), *value)),
                size: planted.size,
                left: planted.left_after_best_rival,
                rival: planted.rival.map(|(rival, _)| rival.to_string()),
            })
            .collect(),
        verdict: answer.verdict,
        found: answer
            .findings
            .iter()
            .map(|finding| FoundIn {
                effect: finding.effect.clone(),
                parameter: finding.params.iter().next().map(|(name, value)| (name.clone(), *value)),
                score: finding.score,
                expected: (finding.predicted_reduction, finding.predicted_reduction_interval),
                confounded_with: finding.confounded_with.clone(),
                separated: finding.separate.len() == finding.confounded_with.len(),
            })
            .collect(),
        leads: answer
            .leads
            .iter()
            .take(3)
            .map(|lead| format!("{} ({:.0})", lead.follows, lead.score))
            .collect(),
        achievable_reduction: falls.0,
        measured_reduction: falls.1,
        alarms,
        seconds,
    })
}

/// Diagnoses each axis of a log without a missing effect and returns the false alarms.
fn alarms(
    meta: &CaseMeta,
    [log, reference, evaluation]: [&Recording; 3],
    library: &Library,
) -> Result<Vec<Alarm>, DiagnoseError> {
    let mut alarms = Vec::new();
    for target in AXES {
        let meta = CaseMeta { target: target.to_owned(), ..meta.clone() };
        let answer = diagnose(&question_of_logs(&meta, log, Some(reference), Some(evaluation), library))?;
        if answer.verdict.is_alarm() {
            let found = answer.findings.iter().map(|finding| finding.effect.clone());
            let named = found.chain(answer.leads.iter().take(1).map(|lead| lead.follows.clone()));
            alarms.push(Alarm { target: target.to_owned(), verdict: answer.verdict, named: named.collect() });
        }
    }
    Ok(alarms)
}

/// Logs on which a correction is evaluated.
struct Corrected<'a> {
    target: &'a str,
    log: &'a Recording,
    evaluation: &'a Recording,
}

impl Corrected<'_> {
    /// Achievable and measured reduction of the error on the evaluation log, of 1-s means or of the samples.
    fn falls(
        &self,
        answer: &Diagnosis,
        log_truth: &LogTruth,
        evaluation_truth: &LogTruth,
        noise: &AxisNoise,
        wide: bool,
    ) -> Result<(Option<f64>, Option<f64>), DiagnoseError> {
        let (reduced, rows) =
            (ErrorInBlocks::in_slow_blocks(self.evaluation, self.target)?, 0..self.evaluation.n_rows());
        let variance = |left: &[f64]| match wide {
            true => reduced.wide_variance(left, &rows),
            false => reduced.slow_variance(left, &rows),
        };
        // Motion of the device is not an error.
        let error: Vec<f64> =
            reduced.error.iter().zip(&evaluation_truth.motion).map(|(error, moved)| error - moved).collect();
        let take = |correction: &[f64]| -> f64 {
            let left: Vec<f64> = error.iter().zip(correction).map(|(error, taken)| error - taken).collect();
            1.0 - variance(&left) / variance(&error)
        };
        let claimed: Vec<Finding> =
            answer.findings.iter().filter(|finding| finding.doubt.is_none()).cloned().collect();
        let own = correction(&claimed, self.log, self.evaluation)?;
        let realised = claimed.iter().any(|finding| !finding.correction.is_empty()).then(|| take(&own));
        if log_truth.regressors.is_empty() {
            return Ok((None, realised));
        }
        let best = best_correction(self.log, self.target, log_truth, evaluation_truth, noise, wide)?;
        let achievable = take(&best);
        Ok(((achievable > LEAST_FALL).then_some(achievable), realised))
    }
}

/// Prediction for the evaluation log by the true regressors, fitted to the log to explain with the true noise.
fn best_correction(
    log: &Recording,
    target: &str,
    log_truth: &LogTruth,
    evaluation_truth: &LogTruth,
    noise: &AxisNoise,
    wide: bool,
) -> Result<Vec<f64>, DiagnoseError> {
    let reduced = ErrorInBlocks::of(log, target)?;
    let coefficients: Vec<f64> = if wide {
        // The noise around a line is locally white, so plain least squares is used.
        let known = |values: &[f64]| -> Vec<f64> {
            let known = values.iter().zip(reduced.blocks.known());
            known.filter(|(_, known)| **known).map(|(v, _)| *v).collect()
        };
        let y = known(&reduced.error);
        let mean = signal::mean(&[&y]);
        let columns: Vec<Vec<f64>> = log_truth.regressors.iter().map(|(_, values)| known(values)).collect();
        let gram = nalgebra::DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>()
        });
        let right = nalgebra::DVector::from_fn(columns.len(), |i, _| {
            columns[i].iter().zip(&y).map(|(a, b)| a * (b - mean)).sum::<f64>()
        });
        gram.cholesky()
            .map_or_else(|| vec![0.0; columns.len()], |c| c.solve(&right).iter().copied().collect())
    } else {
        let columns: Vec<Vec<f64>> =
            log_truth.regressors.iter().map(|(_, values)| reduced.blocks.means(values)).collect();
        let one = vec![1.0; reduced.blocks.len()];
        let mut regressors: Vec<&[f64]> = vec![&one];
        regressors.extend(columns.iter().map(Vec::as_slice));
        Gls::new(&reduced.blocks, &true_levels(noise), &reduced.means, &regressors).coefficients()[1..]
            .to_vec()
    };
    let n = evaluation_truth.error.len();
    let mut sum = vec![0.0; n];
    for (coefficient, (_, values)) in coefficients.iter().zip(&evaluation_truth.regressors) {
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += coefficient * value);
    }
    Ok(sum)
}

/// Noise levels of the simulated noise; the bias instability is converted from the variance of a rung of its ladder.
fn true_levels(noise: &AxisNoise) -> NoiseLevels {
    let ratio = match noise.flicker[..] {
        [first, second, ..] => second.tau_s / first.tau_s,
        _ => 3.0,
    };
    let sigma = noise.flicker.first().map_or(0.0, |process| process.sigma);
    NoiseLevels {
        white: (noise.fast_density(0.0, 0.0) * noise.period_s).sqrt(),
        flicker: sigma * (std::f64::consts::PI / ratio.ln()).sqrt(),
        walk: noise.random_walk,
        gauss_markov: None,
    }
}
