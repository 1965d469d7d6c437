//! What the library does not know: an open search over what is logged, once the library has said what it can. Its
//! results are leads and not findings.

use fos_data::column::{AXES, Column};
use fos_data::interrupt::in_parallel;
use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::hypothesis::MAX_PLACES;
use crate::effects::Band;

use fos_data::recording::Recording;
use fos_fit::noise::Blocks;
use fos_fit::noise::{Gls, dot};
use fos_fit::noise::{LevelPrior, Regression};
use fos_fit::signal::centred;

/// Least score of a lead.
const ACCEPT: f64 = 12.0;

/// Knots of free curves, from coarse to fine; places of a threshold; places of a dip.
const KNOTS: [usize; 3] = [7, 15, 31];
const THRESHOLDS: usize = 100;
const PLACES: usize = 16;

/// A remainder of less than this share of the variance of what is left is noticed by nobody.
const NOTICED: f64 = 0.01;

/// Leads whose noise levels are fitted.
const FITTED: usize = 2;

/// What kind of remainder a lead is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum LeadKind {
    /// It follows what is logged, or a course of its own.
    #[default]
    Course,
    /// Block means too far out now and then; they say nothing against what follows something that is logged.
    Jumps,
    /// A noise level that changes.
    Level,
    /// A line that comes and goes.
    Intermittent,
    /// An effect that the log to be judged refutes.
    Refuted,
}

/// Something that what is left follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Lead {
    /// What kind of remainder it is.
    #[serde(default)]
    pub kind: LeadKind,
    /// What it follows, in words.
    pub follows: String,
    /// By how much −2 ln L falls with it.
    pub gain: f64,
    /// The gain after the price of its coefficients and of everything that was tried.
    pub score: f64,
    /// Its share of the variance of the block means of what is left.
    pub share: f64,
    /// In block means or in the samples: what shows in the samples alone says nothing against a slow effect.
    #[serde(default = "slow")]
    pub band: Band,
    /// Whether it alone makes an answer: not what is hardly ever there, or so small that nobody would notice.
    #[serde(default = "yes")]
    pub decides: bool,
}

fn yes() -> bool {
    true
}

fn slow() -> Band {
    Band::Slow
}

/// A curve that was tried.
struct Curve {
    follows: String,
    columns: Vec<Vec<f64>>,
}

/// Block means of a logged quantity about their mean, over their standard deviation.
struct Quantity {
    name: String,
    unit: &'static str,
    mean: f64,
    deviation: f64,
    values: Vec<f64>,
}

/// What is left of a log after the library, and what it was explained with.
pub(super) struct Left<'a> {
    pub(super) recording: &'a Recording,
    pub(super) blocks: &'a Blocks,
    pub(super) target: &'a str,
    pub(super) y: &'a [f64],
    /// All regressors of the model so far.
    pub(super) regressors: &'a [&'a [f64]],
    pub(super) fitted: &'a fos_fit::noise::Fitted,
    pub(super) prior: &'a LevelPrior,
    /// The axis measures shaking, whose beats are no error.
    pub(super) shaken: bool,
}

impl Left<'_> {
    /// Everything that passes, best first.
    pub(super) fn leads(&self) -> Vec<Lead> {
        let gls = &self.fitted.gls;
        let curves = self.curves();
        let price = |k: usize| k as f64 * (self.blocks.len() as f64).ln() + 2.0 * (curves.len() as f64).ln();
        let ranked = in_parallel(&curves, |curve| {
            let columns: Vec<&[f64]> = curve.columns.iter().map(Vec::as_slice).collect();
            let (gain, k) = gls.gain(&columns);
            (gain - price(k), k, curve)
        });
        let mut ranked: Vec<(f64, usize, &Curve)> = ranked.into_iter().filter(|(_, k, _)| *k > 0).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut leads: Vec<Lead> = ranked
            .into_iter()
            .take(FITTED)
            .filter(|(score, ..)| *score > ACCEPT / 2.0)
            .map(|(_, k, curve)| {
                let mut regressors = self.regressors.to_vec();
                regressors.extend(curve.columns.iter().map(Vec::as_slice));
                let regression =
                    Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: self.prior };
                let fitted = match self.fitted.levels.gauss_markov {
                    Some(process) => regression.fit_gauss_markov(
                        fos_fit::noise::NoiseLevels { gauss_markov: None, ..self.fitted.levels },
                        process,
                    ),
                    None => regression.fit(self.fitted.levels),
                };
                let gain = self.fitted.deviance - fitted.deviance;
                let share = self.share(&fitted.gls, &regressors);
                let follows = curve.follows.clone();
                Lead {
                    kind: LeadKind::Course,
                    follows,
                    gain,
                    score: gain - price(k),
                    share,
                    band: Band::Slow,
                    decides: share >= NOTICED,
                }
            })
            .filter(|lead| lead.score >= ACCEPT)
            .collect();
        leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        leads
    }

    /// Variance of block means that the regressors beyond the model's explain, over what the model leaves.
    fn share(&self, gls: &Gls, regressors: &[&[f64]]) -> f64 {
        let left = |gls: &Gls, regressors: &[&[f64]]| -> Vec<f64> {
            let coefficients = gls.coefficients();
            let left: Vec<f64> = (0..self.y.len())
                .map(|i| {
                    self.y[i]
                        - coefficients.iter().zip(regressors).map(|(c, column)| c * column[i]).sum::<f64>()
                })
                .collect();
            self.blocks.about_levels(&left, 0..left.len())
        };
        let before = fos_fit::signal::variance(&[&left(&self.fitted.gls, self.regressors)]);
        let after = fos_fit::signal::variance(&[&left(gls, regressors)]);
        (1.0 - after / before).max(0.0)
    }

    /// Free curves of every logged quantity, thresholds and dips, products of two, slow oscillations.
    fn curves(&self) -> Vec<Curve> {
        let quantities = self.quantities();
        let mut curves = Vec::new();
        for Quantity { name, unit, mean, deviation, values } in &quantities {
            let real = |value: f64| format!("{:.4} {unit}", mean + deviation * value);
            let sorted = sorted(values);
            let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
            for n_knots in KNOTS {
                let (low, high) = (at(0.0), at(1.0));
                let knots: Vec<f64> =
                    (0..n_knots).map(|i| low + (high - low) * i as f64 / (n_knots - 1) as f64).collect();
                curves.push(Curve { follows: format!("a curve of {name}"), columns: hats(values, &knots) });
            }
            for place in 1..THRESHOLDS {
                let threshold = at(place as f64 / THRESHOLDS as f64);
                let column = values.iter().map(|v| f64::from(u8::from(*v > threshold))).collect();
                curves.push(Curve {
                    follows: format!("whether {name} is above {}", real(threshold)),
                    columns: vec![centred(column)],
                });
            }
            let (low, high) = (at(0.0), at(1.0));
            for place in 1..PLACES {
                let centre = low + (high - low) * place as f64 / PLACES as f64;
                let width = (high - low) / PLACES as f64;
                let column = values.iter().map(|v| (-0.5 * ((v - centre) / width).powi(2)).exp()).collect();
                curves.push(Curve {
                    follows: format!("whether {name} is near {}", real(centre)),
                    columns: vec![centred(column)],
                });
            }
        }
        for (i, one) in quantities.iter().enumerate() {
            for other in &quantities[i + 1..] {
                let product = centred(one.values.iter().zip(&other.values).map(|(a, b)| a * b).collect());
                let follows = format!("the product of {} and {}", one.name, other.name);
                curves.push(Curve { follows, columns: vec![product] });
            }
        }
        if self.shaken {
            return curves;
        }
        let span = self.blocks.blocks.last().map_or(0, |last| last.index + 1) as f64;
        // twice as fine as the resolution, so that none falls between two
        for step in 6..self.blocks.len().min(MAX_PLACES) {
            let per_block = step as f64 / (2.0 * span);
            if per_block > 0.33 {
                break;
            }
            let angle = |block: usize| TAU * per_block * self.blocks.blocks[block].index as f64;
            curves.push(Curve {
                follows: format!("an oscillation with a period of {:.1} s", self.blocks.length_s / per_block),
                columns: vec![
                    (0..self.blocks.len()).map(|i| angle(i).sin()).collect(),
                    (0..self.blocks.len()).map(|i| angle(i).cos()).collect(),
                ],
            });
        }
        curves
    }

    /// Every logged quantity that is no cousin of the target and that changes.
    fn quantities(&self) -> Vec<Quantity> {
        let triad_of = |name: &str| Column::named(name).place().map(|(triad, _)| triad);
        let triad = triad_of(self.target);
        let is_cousin = |name: &str| triad.is_some() && triad_of(name) == triad || name == self.target;
        let channels = self.recording.channels().iter();
        let channels =
            channels.filter(|channel| !is_cousin(&channel.name) && !channel.column().is_of_model());
        channels
            .filter_map(|channel| {
                let held = self.recording.held_from_first(channel);
                let means = self.blocks.means(&held);
                let mean = fos_fit::signal::mean(&[&means]);
                let means = centred(means);
                let deviation = (dot(&means, &means) / means.len() as f64).sqrt();
                if deviation < least_motion(&channel.name) {
                    return None;
                }
                if channel.column().place().is_some() && is_of_few(&means, deviation) {
                    return None;
                }
                let size = held.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
                (deviation > 1e-9 * size).then(|| Quantity {
                    name: channel.name.clone(),
                    unit: Column::named(&channel.name).unit().label(),
                    mean,
                    deviation,
                    values: means.iter().map(|value| value / deviation).collect(),
                })
            })
            .collect()
    }
}

/// Block means of a device at rest scatter by less, in the unit of the axis: 1 °/s, and the gravity of 1°. What an axis
/// shows then is its own error, and another axis that drifts with it does not follow it.
pub(super) fn least_motion(name: &str) -> f64 {
    let column = Column::named(name);
    if !AXES.contains(&name) {
        0.0
    } else if column.is_angular_rate() {
        0.017
    } else {
        0.17
    }
}

/// Fourth moment of a channel that lies at one of two values for a twentieth of the time.
const FEW: f64 = 19.0;

/// Whether a few of the values are all that it changes by: a unit that was moved now and then shows it in every inertial
/// channel, and none of them is what another follows.
fn is_of_few(means: &[f64], deviation: f64) -> bool {
    means.iter().map(|mean| (mean / deviation).powi(4)).sum::<f64>() > FEW * means.len() as f64
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

/// Functions that are 1 at one knot, 0 at the others, straight between: what they span is every broken line. The first
/// is left out, the constant has its place.
fn hats(values: &[f64], knots: &[f64]) -> Vec<Vec<f64>> {
    (1..knots.len())
        .map(|at| {
            let hat = |value: &f64| {
                let rising = (value - knots[at - 1]) / (knots[at] - knots[at - 1]).max(f64::MIN_POSITIVE);
                let falling = match knots.get(at + 1) {
                    Some(next) => (next - value) / (next - knots[at]).max(f64::MIN_POSITIVE),
                    None => 1.0,
                };
                rising.min(falling).clamp(0.0, 1.0)
            };
            centred(values.iter().map(hat).collect())
        })
        .collect()
}
