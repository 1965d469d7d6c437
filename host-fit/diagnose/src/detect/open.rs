//! Open search for effects outside the library: what the residual follows among the logged columns. Its results are
//! leads, not findings.

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

/// Numbers of knots of free curves, from coarse to fine; number of thresholds; number of positions of a dip.
const KNOTS: [usize; 3] = [7, 15, 31];
const THRESHOLDS: usize = 100;
const PLACES: usize = 16;

/// Least number of periods of an oscillation in the log. Fewer of them may be the legs of a temperature cycle, whose lag or
/// hysteresis would be withheld for the oscillation.
const LEAST_PERIODS: usize = 5;

/// Least share of the residual variance from which on a lead affects the verdict.
const NOTICED: f64 = 0.01;

/// Number of leads whose noise levels are fitted.
const FITTED: usize = 2;

/// Kind of lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum LeadKind {
    /// The residual follows a logged quantity or a course in time.
    #[default]
    Course,
    /// Occasional block means far outside the noise. They do not contradict effects that follow a logged quantity.
    Jumps,
    /// The noise level changes.
    Level,
    /// An intermittent spectral line.
    Intermittent,
    /// An effect that the evaluation log refutes.
    Refuted,
}

/// A quantity that the residual follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Lead {
    /// Kind of lead.
    #[serde(default)]
    pub kind: LeadKind,
    /// Description of the quantity.
    pub follows: String,
    /// Decrease of −2 ln L.
    pub gain: f64,
    /// Gain minus a penalty for its coefficients and for every candidate tried.
    pub score: f64,
    /// Share of the variance of the block means of the residual.
    pub share: f64,
    /// Band of the lead: one in the samples does not contradict a slow effect.
    #[serde(default = "slow")]
    pub band: Band,
    /// True if the lead alone decides the verdict; false if it is rare or negligibly small.
    #[serde(default = "yes")]
    pub decides: bool,
}

impl Lead {
    /// Returns a lead that decides the verdict and whose gain is its score.
    pub(super) fn new(kind: LeadKind, follows: String, band: Band, score: f64) -> Self {
        Self { kind, follows, gain: score, score, share: 0.0, band, decides: true }
    }
}

fn yes() -> bool {
    true
}

fn slow() -> Band {
    Band::Slow
}

/// A curve that is tried.
struct Curve {
    follows: String,
    columns: Vec<Vec<f64>>,
}

/// Block means of a logged quantity, centred and divided by their standard deviation.
struct Quantity {
    name: String,
    unit: &'static str,
    mean: f64,
    deviation: f64,
    values: Vec<f64>,
}

/// The residual after the library, and the model that it belongs to.
pub(super) struct Residual<'a> {
    pub(super) recording: &'a Recording,
    pub(super) blocks: &'a Blocks,
    pub(super) target: &'a str,
    pub(super) y: &'a [f64],
    /// All regressors of the model.
    pub(super) regressors: &'a [&'a [f64]],
    pub(super) fitted: &'a fos_fit::noise::Fitted,
    pub(super) prior: &'a LevelPrior,
    /// True if the axis measures shaking, whose beats are not an error.
    pub(super) shaken: bool,
}

impl Residual<'_> {
    /// Returns all leads that pass, best first.
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
                let (follows, score) = (curve.follows.clone(), gain - price(k));
                let decides = share >= NOTICED;
                Lead { gain, share, decides, ..Lead::new(LeadKind::Course, follows, Band::Slow, score) }
            })
            .filter(|lead| lead.score >= ACCEPT)
            .collect();
        leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        leads
    }

    /// Returns the share of the residual variance of block means that the additional regressors explain.
    fn share(&self, gls: &Gls, regressors: &[&[f64]]) -> f64 {
        let left = |gls: &Gls, regressors: &[&[f64]]| -> Vec<f64> {
            let left = gls.unexplained(self.y, regressors);
            self.blocks.about_levels(&left, 0..left.len())
        };
        let before = fos_fit::signal::variance(&[&left(&self.fitted.gls, self.regressors)]);
        let after = fos_fit::signal::variance(&[&left(gls, regressors)]);
        (1.0 - after / before).max(0.0)
    }

    /// Returns the curves to try: free curves, thresholds and dips of every logged quantity, products of two, slow
    /// oscillations.
    fn curves(&self) -> Vec<Curve> {
        let quantities = quantities(self.recording, self.blocks, self.target);
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
        // twice as fine as the resolution, so that no oscillation falls between two
        for step in 2 * LEAST_PERIODS..self.blocks.len().min(MAX_PLACES) {
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
}

/// Least share of either level of a course that one side of a threshold must hold.
const DECIDES: f64 = 0.93;

/// Describes the threshold of a logged quantity that decides a course of two levels in block means; `None` if none does.
pub(super) fn threshold_of(
    recording: &Recording,
    blocks: &Blocks,
    target: &str,
    course: &[f64],
) -> Option<String> {
    let upper: Vec<bool> = course.iter().map(|value| *value > 0.0).collect();
    let count = |wanted: bool| upper.iter().filter(|state| **state == wanted).count().max(1) as f64;
    let weight = [1.0 / count(false), 1.0 / count(true)];
    let best = quantities(recording, blocks, target).into_iter().filter_map(|quantity| {
        let mut order: Vec<usize> = (0..upper.len()).collect();
        order.sort_by(|a, b| quantity.values[*a].total_cmp(&quantity.values[*b]));
        // shares of the two levels below each threshold
        let mut below = [0.0, 0.0];
        let mut best = (0.0, 0);
        for (place, block) in order.iter().enumerate() {
            below[usize::from(upper[*block])] += weight[usize::from(upper[*block])];
            let held = below[0].min(1.0 - below[1]).max(below[1].min(1.0 - below[0]));
            best = if held > best.0 { (held, place) } else { best };
        }
        let value = quantity.mean + quantity.deviation * quantity.values[*order.get(best.1)?];
        Some((best.0, format!("whether {} is above {value:.4} {}", quantity.name, quantity.unit)))
    });
    let (held, follows) = best.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (held >= DECIDES).then_some(follows)
}

/// Returns every logged quantity that varies and is not of the target's triad.
fn quantities(recording: &Recording, blocks: &Blocks, target: &str) -> Vec<Quantity> {
    let triad_of = |name: &str| Column::named(name).place().map(|(triad, _)| triad);
    let triad = triad_of(target);
    let is_same_triad = |name: &str| triad.is_some() && triad_of(name) == triad || name == target;
    let channels = recording.channels().iter();
    let channels =
        channels.filter(|channel| !is_same_triad(&channel.name) && !channel.column().is_of_model());
    channels
        .filter_map(|channel| {
            let held = recording.held_from_first(channel);
            let means = blocks.means(&held);
            let mean = fos_fit::signal::mean(&[&means]);
            let means = centred(means);
            let deviation = (dot(&means, &means) / means.len() as f64).sqrt();
            if deviation < least_motion(&channel.name) {
                return None;
            }
            if channel.column().place().is_some() && has_few_values(&means, deviation) {
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

/// Upper bound of the scatter of the block means of a device at rest, in the unit of the axis: 1 °/s, and gravity
/// tilted by 1°. Below, an axis shows only its own error, so another axis that drifts alike does not follow it.
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

/// Kurtosis of a channel that is at one of two values for 5 % of the time.
const FEW: f64 = 19.0;

/// Returns true if a channel changes by a few values only. A device that is moved occasionally shows it in every
/// inertial channel, and none of them is the cause of another.
fn has_few_values(means: &[f64], deviation: f64) -> bool {
    means.iter().map(|mean| (mean / deviation).powi(4)).sum::<f64>() > FEW * means.len() as f64
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

/// Hat functions: 1 at one knot, 0 at the others, linear in between, so that they span every piecewise linear function.
/// The first is omitted because of the constant.
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
