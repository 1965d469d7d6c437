//! Stretches in which a model fails worst, and the channels that are unusual in them.

use fos_core::GRAVITY_MPS2;
use fos_data::column::Column;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::errors::SLOW_BLOCK_S;
use super::trace::Trace;
use fos_data::recording::{Recording, pieces};
use fos_data::statistics::{MAD_TO_SD, median_of};

/// Largest number of stretches that are reported.
const NAMED: usize = 5;

/// Length of a stretch, s; a twentieth of the evaluated time where that is shorter.
const LENGTH_S: f64 = 10.0;

/// Distance, in robust standard deviations, between the mean or spread of a channel in a stretch and that in the other
/// stretches above which the channel is unusual: by chance, one normally distributed channel in a thousand is.
const SPECIAL: f64 = 3.3;

/// Ratios to the usual scatter of a channel that are too small to report.
const USUAL: Range<f64> = 0.8..1.25;

/// Standard deviations of white noise by which the slow error of a stretch must exceed that of the lower quartile of
/// all stretches to stand out; noise alone does in one stretch of 30,000. The median would hide a drift that is present
/// half of the time.
const BEYOND_NOISE: f64 = 4.0;

/// Standard deviations from the mean of a normal distribution to its lower quartile.
const LOWER_QUARTILE: f64 = 0.674;

/// A stretch of the recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Stretch {
    /// Timestamp of the first row, s.
    pub begin_s: f64,
    /// Timestamp of the last row, s.
    pub end_s: f64,
    /// Slow error: RMS of the 1-s means of the residual in a free run of at most 60 s, in the axis' unit.
    pub rms: f64,
    /// Mean of the residual, in the axis' unit.
    pub mean: f64,
    /// `rms` divided by that of the median stretch.
    pub ratio: f64,
    /// Unusual channels and circumstances of the stretch, most striking first; empty if nothing logged is unusual.
    pub special: Vec<String>,
}

/// Returns the stretches of `axis`, whose channel is `column`, with a slow error that stands out, worst first: at most
/// five, with neighbours in time merged.
pub fn worst_stretches(trace: &Trace, axis: usize, column: &str, recording: &Recording) -> Vec<Stretch> {
    let still_rows: usize = trace.stretches.iter().map(Range::len).sum();
    let length = ((LENGTH_S / trace.period_s) as usize).min(still_rows / 20).max(1);
    let left = |place: &Range<usize>| {
        &trace.axes[axis].coast[place.start - trace.rows.start..place.end - trace.rows.start]
    };
    let mut places = pieces(&trace.stretches, length);
    places.retain(|place| place.len() == length);
    // between close gaps, a place of this length rarely fits between the start of a coast and the next gap
    let coasts = coasts(&trace.stretches, left);
    let fits = |place: &&Range<usize>| {
        let coast = coasts.get(coasts.partition_point(|coast| coast.end < place.end));
        coast.is_some_and(|coast| coast.start <= place.start)
    };
    let rows_that_fit: usize = places.iter().filter(fits).map(Range::len).sum();
    let is_in_bursts = 2 * rows_that_fit < coasts.iter().map(Range::len).sum::<usize>();
    if is_in_bursts {
        let length = length.min(typical(&coasts));
        places = pieces(&coasts, length);
        places.retain(|place| 2 * place.len() >= length);
    }
    let per_mean = ((SLOW_BLOCK_S / trace.period_s).round() as usize).max(1);
    let rms = |rows: &Range<usize>| {
        let squares =
            left(rows).chunks(per_mean).map(|block| block.iter().sum::<f64>().powi(2) / block.len() as f64);
        (squares.sum::<f64>() / rows.len() as f64).sqrt()
    };
    let mut ranked: Vec<(f64, usize)> = places
        .iter()
        .enumerate()
        .map(|(index, place)| (rms(place), index))
        .filter(|(rms, _)| rms.is_finite())
        .collect();
    let median_rms = median(ranked.iter().map(|(rms, _)| *rms));
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let calm_rms = ranked.get(3 * ranked.len() / 4).map_or(f64::NAN, |(rms, _)| *rms);
    let means = places.first().map_or(0, Range::len) as f64 / per_mean as f64;
    let stands_out = |group: &Group| group.rms >= bound(means) * calm_rms;
    let backdrop = Backdrop::new(recording, &places);
    let mut named: Vec<Stretch> = different(&ranked, &places)
        .into_iter()
        .filter(stands_out)
        .map(|Group { places: indices, worst, .. }| {
            let rows = places[indices.start].start..places[indices.end - 1].end;
            let rms = rms(&rows);
            let mut special = backdrop.special(worst, column);
            // every burst begins after a gap
            special.extend(after_a_gap(recording, trace, &places[worst]).filter(|_| !is_in_bursts));
            Stretch {
                begin_s: recording.time_s[rows.start],
                end_s: recording.time_s[rows.end - 1],
                rms,
                mean: left(&rows).iter().sum::<f64>() / rows.len() as f64,
                ratio: rms / median_rms,
                special,
            }
        })
        .collect();
    named.sort_by(|a, b| b.rms.total_cmp(&a.rms));
    named
}

/// Ratio to the lower quartile from which on a stretch of so many means stands out. The RMS of means of white noise
/// follows a χ distribution; its quantiles are those of Wilson and Hilferty (1931).
fn bound(means: f64) -> f64 {
    let variance = 2.0 / (9.0 * means.max(1.0));
    let quantile = |deviations: f64| 1.0 - variance + deviations * variance.sqrt();
    (quantile(BEYOND_NOISE) / quantile(-LOWER_QUARTILE)).powf(1.5)
}

/// Parts of the stretches in which the residual of a coast is known: a coast begins some seconds after its stretch.
fn coasts<'a>(stretches: &[Range<usize>], left: impl Fn(&Range<usize>) -> &'a [f64]) -> Vec<Range<usize>> {
    let coast = |stretch: &Range<usize>| {
        let left = left(stretch);
        let first = left.iter().position(|error| error.is_finite())?;
        let last = left.iter().rposition(|error| error.is_finite())?;
        Some(stretch.start + first..stretch.start + last + 1)
    };
    stretches.iter().filter_map(coast).collect()
}

/// Length of the stretch that contains the middle row if stretches are sorted by length; 1 if there is none.
fn typical(stretches: &[Range<usize>]) -> usize {
    let mut lengths: Vec<usize> = stretches.iter().map(Range::len).collect();
    lengths.sort_unstable();
    let half = lengths.iter().sum::<usize>() / 2;
    let mut rows = 0;
    let middle = lengths.iter().find(|length| {
        rows += **length;
        rows > half
    });
    middle.copied().unwrap_or(1)
}

/// Adjacent places, and the worst of them.
struct Group {
    places: Range<usize>,
    worst: usize,
    rms: f64,
}

/// Fraction of the RMS of a worse place from which on its neighbour is merged into it; a smaller one is its slope.
const BELONGS: f64 = 0.5;

/// Returns the worst places, each merged with its neighbours.
fn different(ranked: &[(f64, usize)], places: &[Range<usize>]) -> Vec<Group> {
    let touches = |one: usize, next: usize| places[one].end == places[next].start;
    let mut groups: Vec<Group> = Vec::new();
    for &(rms, index) in ranked {
        let is_before = |group: &Group| index + 1 == group.places.start && touches(index, index + 1);
        let is_after = |group: &Group| index == group.places.end && touches(index - 1, index);
        let mut beside: Vec<usize> =
            (0..groups.len()).filter(|at| is_before(&groups[*at]) || is_after(&groups[*at])).collect();
        match beside.first() {
            None if groups.len() < NAMED => {
                groups.push(Group { places: index..index + 1, worst: index, rms })
            }
            Some(&into) if rms >= BELONGS * groups[into].rms => {
                // a place between two groups merges them
                let other = beside.pop().filter(|other| *other != into).map(|other| groups.remove(other));
                let joined = &mut groups[into].places;
                for part in std::iter::once(index..index + 1).chain(other.map(|other| other.places)) {
                    *joined = joined.start.min(part.start)..joined.end.max(part.end);
                }
            }
            _ => {}
        }
    }
    groups
}

/// Mean and standard deviation of every channel in every stretch.
struct Backdrop {
    channels: Vec<ChannelBackdrop>,
}

struct ChannelBackdrop {
    name: String,
    means: Vec<f64>,
    deviations: Vec<f64>,
}

impl Backdrop {
    fn new(recording: &Recording, places: &[Range<usize>]) -> Self {
        let channels = recording.channels().iter().map(|channel| {
            let moments = |place: &Range<usize>| {
                let finite: Vec<f64> =
                    channel.values[place.clone()].iter().copied().filter(|value| value.is_finite()).collect();
                if finite.is_empty() {
                    return (f64::NAN, f64::NAN);
                }
                (crate::signal::mean(&[&finite]), crate::signal::variance(&[&finite]).sqrt())
            };
            let (means, deviations) = places.iter().map(moments).unzip();
            ChannelBackdrop { name: channel.name.clone(), means, deviations }
        });
        Self { channels: channels.collect() }
    }

    /// Describes the three channels that are furthest from their usual values in stretch `index`. The failing axis
    /// does not explain itself.
    fn special(&self, index: usize, failing: &str) -> Vec<String> {
        let mut found: Vec<(f64, String)> = Vec::new();
        for channel in self.channels.iter().filter(|channel| channel.name != failing) {
            let label = Column::named(&channel.name).label();
            if let Some((score, usual)) = score(&channel.means, index) {
                found.push((
                    score,
                    format!("{label} is at {}", compared(&channel.name, channel.means[index], usual)),
                ));
            }
            if let Some((score, usual)) = score(&channel.deviations, index) {
                let times = channel.deviations[index] / usual;
                // a significant difference may still be too small to matter
                if !USUAL.contains(&times) {
                    found.push((score, format!("{label} scatters {times:.1} times as much as usual")));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().take(3).map(|(_, text)| text).collect()
    }
}

/// Shows a value of a channel and its usual value in units of data sheets, with two digits of their difference.
fn compared(channel: &str, value: f64, usual: f64) -> String {
    let column = Column::named(channel);
    let (unit, si) = match column {
        _ if column.is_angular_rate() => ("°/s", 1.0_f64.to_radians()),
        _ if column.is_specific_force() => ("mg", 1e-3 * f64::from(GRAVITY_MPS2)),
        _ => (column.unit().label(), 1.0),
    };
    let (value, usual) = (value / si, usual / si);
    let decimals = (1.0 - (value - usual).abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$} {unit}, usually {usual:.decimals$}")
}

/// Describes the gap or motion that a place begins soon after; none if it does not.
fn after_a_gap(recording: &Recording, trace: &Trace, place: &Range<usize>) -> Option<String> {
    let stretch = trace.stretches.iter().find(|stretch| stretch.contains(&place.start))?;
    let since_s = (place.start - stretch.start) as f64 * trace.period_s;
    let time = recording.time_s[stretch.start];
    (stretch.start > trace.rows.start && since_s < LENGTH_S)
        .then(|| format!("begins {since_s:.1} s after a gap or motion that ends at {time:.1} s"))
}

/// Distance of value `index` from the median in robust standard deviations, and that median; none if the distance is
/// usual.
fn score(values: &[f64], index: usize) -> Option<(f64, f64)> {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let centre = median(finite());
    let spread = MAD_TO_SD * median(finite().map(|value| (value - centre).abs()));
    let score = (values[index] - centre).abs() / spread;
    (score.is_finite() && score > SPECIAL).then_some((score, centre))
}

/// Median, or NaN if there are no values: a ratio to it is no score.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    median_of(values).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::super::trace::AxisTrace;
    use super::*;
    use fos_data::recording::{LoadOptions, Source};
    use fos_testkit::noise::white_noise;

    /// Bursts of 5 s, or a row less, every 300 s at 200 Hz; the residuals of coasts are `sizes`, one per burst, from
    /// its second quarter on.
    fn in_bursts(sizes: &[f64]) -> (Recording, Trace) {
        let (mut time, mut coast, mut stretches) = (Vec::new(), Vec::new(), Vec::new());
        for (burst, size) in sizes.iter().enumerate() {
            let rows = 1000 - burst % 2;
            stretches.push(time.len()..time.len() + rows);
            time.extend((0..rows).map(|row| 300.0 * burst as f64 + 0.005 * row as f64));
            coast.extend((0..rows).map(|row| if row < rows / 4 { f64::NAN } else { *size }));
        }
        let values = vec![1.0; time.len()];
        let columns = vec![("t_s".to_owned(), time), ("gx_rads".to_owned(), values)];
        let options = LoadOptions { rate_hz: Some(200.0), ..LoadOptions::default() };
        let recording = Recording::from_columns(Source::made_by("a test"), columns, &options).unwrap();
        let rows = 0..coast.len();
        let axes = vec![AxisTrace { coast, ..AxisTrace::default() }];
        (recording, Trace { rows, period_s: 0.005, stretches, axes, strapdown: None })
    }

    #[test]
    fn values_are_shown_in_units_of_data_sheets_with_two_digits_of_their_difference() {
        assert_eq!(compared("gy_rads", -0.0046, -0.0044), "-0.264 °/s, usually -0.252");
        assert_eq!(compared("ax_mps2", 9.80665, 9.7), "1000 mg, usually 989");
        assert_eq!(compared("temp_c", 35.46, 31.0), "35.5 °C, usually 31.0");
    }

    #[test]
    fn an_axis_does_not_explain_itself() {
        let means = vec![1.0, 1.1, 0.9, 1.0, 5.0];
        let channel = |name: &str| ChannelBackdrop {
            name: name.to_owned(),
            means: means.clone(),
            deviations: vec![1.0; means.len()],
        };
        let backdrop = Backdrop { channels: vec![channel("gx_rads"), channel("temp_c")] };
        assert_eq!(backdrop.special(4, "gx_rads"), ["temp_c is at 5.0 °C, usually 1.0"]);
    }

    /// Regression: no stretch was reported, as no burst holds the 10 s of a stretch and its first quarter has no coast.
    #[test]
    fn the_five_worst_bursts_are_named_each_alone() {
        for bursts in [12, 15, 20, 40] {
            // the worst follow one another, up to the third last
            let sizes: Vec<f64> = (0..bursts).map(|burst| 4_f64.powi((burst + 2) % bursts + 1)).collect();
            let (recording, trace) = in_bursts(&sizes);
            let worst = worst_stretches(&trace, 0, "gx_rads", &recording);
            let burst = |time_s: f64| (time_s / 300.0).floor();
            assert!(worst.iter().all(|stretch| burst(stretch.begin_s) == burst(stretch.end_s)), "{worst:?}");
            let found: Vec<f64> = worst.iter().map(|stretch| burst(stretch.begin_s)).collect();
            let expected: Vec<f64> = (3..8).map(|back| f64::from(bursts - back)).collect();
            assert_eq!(found, expected, "five different ones of {bursts}, the worst first");
            assert_eq!(worst[0].rms, 4_f64.powi(bursts));
            assert!(
                worst.iter().all(|stretch| stretch.special.is_empty()),
                "what every burst has is not special"
            );
        }
    }

    /// White noise for an hour and a drift of a tenth of it in one minute: the samples hide it, the means do not.
    #[test]
    fn noise_has_no_worst_stretch_and_a_slow_drift_under_noise_is_one() {
        let rows = 36_000;
        let time: Vec<f64> = (0..rows).map(|row| 0.1 * f64::from(row)).collect();
        let coast = white_noise(1, time.len());
        let columns = vec![("t_s".to_owned(), time.clone()), ("gx_rads".to_owned(), coast.clone())];
        let recording =
            Recording::from_columns(Source::made_by("a test"), columns, &LoadOptions::default()).unwrap();
        let of = |coast: Vec<f64>| {
            let axes = vec![AxisTrace { coast, ..AxisTrace::default() }];
            Trace {
                rows: 0..time.len(),
                period_s: 0.1,
                stretches: std::iter::once(0..time.len()).collect(),
                axes,
                strapdown: None,
            }
        };
        assert_eq!(worst_stretches(&of(coast.clone()), 0, "gx_rads", &recording), []);
        let drifting =
            |(value, time): (&f64, &f64)| value + if (600.0..660.0).contains(time) { 1.2 } else { 0.0 };
        let found =
            worst_stretches(&of(coast.iter().zip(&time).map(drifting).collect()), 0, "gx_rads", &recording);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].begin_s >= 590.0 && found[0].end_s <= 670.0, "{found:?}");
    }

    #[test]
    fn neighbours_are_one_stretch_and_five_are_named() {
        // two hills, one with a gap in the rows in its middle, and a plain
        let heights = [1.0, 1.1, 8.0, 9.0, 7.0, 2.0, 1.2, 5.0, 6.0, 1.3, 0.9, 1.4, 0.3, 1.5];
        let places: Vec<Range<usize>> = (0..heights.len())
            .map(|i| 10 * i + usize::from(i > 7)..10 * i + 10 + usize::from(i > 7))
            .collect();
        let mut ranked: Vec<(f64, usize)> = heights.iter().copied().zip(0..).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let found: Vec<(Range<usize>, usize)> =
            different(&ranked, &places).into_iter().map(|group| (group.places, group.worst)).collect();
        assert_eq!(found[..3], [(2..5, 3), (8..9, 8), (7..8, 7)]);
        assert_eq!(found.len(), NAMED);
    }

    #[test]
    fn one_between_two_joins_them() {
        let places: Vec<Range<usize>> = (0..5).map(|i| 10 * i..10 * i + 10).collect();
        let ranked = [(9.0, 1), (8.0, 3), (7.0, 2), (0.1, 0), (0.1, 4)];
        let found = different(&ranked, &places);
        assert_eq!((found.len(), found[0].places.clone(), found[0].worst), (1, 1..4, 1));
    }
}
