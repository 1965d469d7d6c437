//! Findings of faults and noise, which have a name and a size only.

use std::collections::BTreeMap;

use super::Composer;
use crate::detect::answer::{Finding, Size};
use crate::detect::faults::Fault;
use crate::detect::question::DiagnoseError;
use crate::detect::shape::TEMPERATURE;
use crate::detect::slow::ExtraNoise;
use crate::effects::{Detector, Effect, SizeUnit};
use fos_data::column::Column;

/// Quantile of 95 % intervals.
pub(super) const TWO_SIDED_95: f64 = 1.96;

impl Composer<'_> {
    /// Returns the effect with this search method at this value of its parameter.
    pub(super) fn found_as(&self, search: Detector, value: f64) -> Result<&Effect, DiagnoseError> {
        Ok(self.prepared.library().found_as(search, &self.prepared.column, value)?)
    }

    pub(super) fn fault_findings(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let of = |search: Detector, value: f64| -> Result<Finding, DiagnoseError> {
            let effect = self.found_as(search, value)?;
            Ok(Finding { params: param(effect, value), ..bare(effect) })
        };
        self.prepared
            .faults
            .iter()
            .map(|fault| match fault {
                Fault::Saturation { share, .. } => of(Detector::Saturation, *share),
                Fault::Dropped { share } => of(Detector::DroppedSamples, *share),
                Fault::Coarse { multiple, step } if multiple.is_nan() => {
                    let effect = self.found_as(Detector::CoarseSteps, 1.0)?;
                    let unit = SizeUnit::of_axis(Column::named(&self.prepared.column));
                    let sizes = vec![Size::around("step", *step, f64::NAN, unit.si, &unit)];
                    Ok(Finding { sizes, ..bare(effect) })
                }
                Fault::Coarse { multiple, .. } => of(Detector::CoarseSteps, *multiple),
                Fault::DeadZone(zone) => of(
                    Detector::DeadZone,
                    zone.half_width / SizeUnit::of_axis(Column::named(&self.prepared.column)).si,
                ),
            })
            .collect()
    }

    pub(super) fn noise_finding(&self) -> Result<Option<Finding>, DiagnoseError> {
        let slow = &self.results.slow;
        Ok(match slow.noise {
            ExtraNoise::None => None,
            ExtraNoise::Walk => {
                let effect = self.found_as(Detector::RandomWalk, 0.0)?;
                Some(Finding { gain: Some(slow.noise_gain), score: Some(slow.noise_score), ..bare(effect) })
            }
            ExtraNoise::GaussMarkov(process) => {
                let effect = self.found_as(Detector::GaussMarkov, process.tau_s)?;
                let unit = SizeUnit::of_axis(Column::named(&self.prepared.column));
                let size = Size::around("standard deviation", process.deviation, f64::NAN, unit.si, &unit);
                Some(Finding {
                    params: param(effect, process.tau_s),
                    sizes: vec![size],
                    gain: Some(slow.noise_gain),
                    score: Some(slow.noise_score),
                    ..bare(effect)
                })
            }
        })
    }

    /// Returns the finding of a bias that jumps between two levels.
    pub(super) fn telegraph_finding(&self) -> Result<Option<Finding>, DiagnoseError> {
        let Some(telegraph) = &self.results.telegraph else { return Ok(None) };
        let [lower_s, upper_s] = telegraph.dwell_s;
        let effect = self.found_as(Detector::Telegraph, 0.5 * (lower_s + upper_s))?;
        let unit = SizeUnit::of_axis(Column::named(&self.prepared.column));
        let [difference, error] = telegraph.difference.map(|value| value / unit.si);
        let difference =
            Size::around("difference of the two levels", difference, TWO_SIDED_95 * error, 1.0, &unit);
        // relative error of the mean of n exponential dwells: 1/√n
        let dwells = 0.5 * telegraph.transitions as f64;
        let dwell = |of: &str, value: f64| {
            let factor = (TWO_SIDED_95 / dwells.sqrt()).exp();
            let interval = [value / factor, value * factor];
            Size { of: of.to_owned(), value, interval, unit: "s".to_owned() }
        };
        Ok(Some(Finding {
            params: param(effect, 0.5 * (lower_s + upper_s)),
            sizes: vec![
                difference,
                dwell("mean dwell in the lower level", lower_s),
                dwell("mean dwell in the upper level", upper_s),
                Size::around("transitions", telegraph.transitions as f64, f64::NAN, 1.0, "1"),
            ],
            gain: Some(telegraph.gain),
            score: Some(telegraph.score),
            ..bare(effect)
        }))
    }

    /// Returns the finding of a noise level that follows the temperature.
    pub(super) fn level_finding(&self) -> Result<Option<Finding>, DiagnoseError> {
        let Some(level) = &self.results.left.level else { return Ok(None) };
        let Some([slope, error]) = level.temperature_slope() else { return Ok(None) };
        let effect = self.found_as(Detector::NoiseLevel, 0.0)?;
        let half = 100.0 * TWO_SIDED_95 * error;
        let size = Size::around("change of the noise level", 100.0 * slope, half, 1.0, "%/K");
        Ok(Some(Finding {
            sizes: vec![size],
            gain: Some(level.score),
            score: Some(level.score),
            shows_against: Some(TEMPERATURE.to_owned()),
            ..bare(effect)
        }))
    }
}

/// Returns a finding with a name and no numbers.
pub(super) fn bare(effect: &Effect) -> Finding {
    Finding {
        effect: effect.id.clone(),
        name: effect.name.clone(),
        band: effect.band,
        params: BTreeMap::new(),
        params_interval: BTreeMap::new(),
        sizes: Vec::new(),
        gain: None,
        score: None,
        predicted_reduction: 0.0,
        predicted_reduction_interval: [0.0; 2],
        measured_reduction: None,
        doubt: None,
        confounded_with: Vec::new(),
        separate: Vec::new(),
        shows_against: None,
        shows_from_to_s: None,
        correction: Vec::new(),
        limits: BTreeMap::new(),
    }
}

pub(super) fn param(effect: &Effect, value: f64) -> BTreeMap<String, f64> {
    effect.parameter.iter().map(|parameter| (parameter.name.clone(), value)).collect()
}
