//! Statistics of a calibration: rates with exact intervals, and medians, each with its goal.

use serde::Serialize;
use statrs::distribution::{Beta, ContinuousCDF};

use super::outcome::{Alarm, FoundIn, Outcome};
use fos_data::column::AXES;
use fos_diagnose::detect::Verdict;
use fos_simulate::{Effect, Kind, Level};

/// A statistic of the cases, with its goal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistic {
    /// Description of the statistic.
    pub name: String,
    /// Value; absent without cases.
    pub value: Option<f64>,
    /// 95 % interval (Clopper and Pearson 1934 for a rate), if available.
    pub interval: Option<[f64; 2]>,
    /// Number of cases.
    pub cases: usize,
    /// Required and desired value.
    pub goal: Goal,
}

/// Required and desired value of a statistic, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// Lower limits.
    AtLeast(f64, f64),
    /// Upper limits.
    AtMost(f64, f64),
    /// Upper limits in seconds. Never a reason for failure, because a busy machine is not a defect.
    Seconds(f64, f64),
    /// Ranges.
    Within([f64; 2], [f64; 2]),
}

impl Statistic {
    /// The value meets the requirement.
    pub fn holds(&self) -> bool {
        self.value.is_none_or(|value| match self.goal {
            Goal::AtLeast(must, _) => value >= must,
            Goal::AtMost(must, _) | Goal::Seconds(must, _) => value <= must,
            Goal::Within([low, high], _) => (low..=high).contains(&value),
        })
    }

    /// The requirement may be met: it lies within the interval of the value.
    pub fn may_hold(&self) -> bool {
        let [low, high] = self.interval.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        self.holds()
            || match self.goal {
                Goal::AtLeast(must, _) => high >= must,
                Goal::AtMost(must, _) => low <= must,
                Goal::Seconds(..) => true,
                Goal::Within([from, to], _) => high >= from && low <= to,
            }
    }
}

/// Rate with its exact interval.
fn rate(name: &str, goal: Goal, hits: impl IntoIterator<Item = bool>) -> Statistic {
    let (mut hit, mut cases) = (0, 0);
    for is_hit in hits {
        cases += 1;
        hit += usize::from(is_hit);
    }
    let value = (cases > 0).then(|| hit as f64 / cases as f64);
    Statistic { name: name.to_owned(), value, interval: value.map(|_| interval(hit, cases)), cases, goal }
}

/// 95 % interval of a rate (Clopper and Pearson).
fn interval(hit: usize, cases: usize) -> [f64; 2] {
    let (x, n) = (hit as f64, cases as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
    let low = if hit == 0 { 0.0 } else { quantile(x, n - x + 1.0, 0.025) };
    let high = if hit == cases { 1.0 } else { quantile(x + 1.0, n - x, 0.975) };
    [low, high]
}

/// Quantile of values, with the 95 % interval from order statistics.
fn quantile(name: &str, goal: Goal, share: f64, values: impl IntoIterator<Item = f64>) -> Statistic {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    let n = values.len();
    let at = |place: f64| values.get((place.max(0.0) as usize).min(n.saturating_sub(1))).copied();
    let (middle, half) = (share * (n as f64 - 1.0), 1.96 * (n as f64 * share * (1.0 - share)).sqrt());
    let interval = at(middle - half).zip(at((middle + half).ceil())).map(|(low, high)| [low, high]);
    Statistic { name: name.to_owned(), value: at(middle.round()), interval, cases: n, goal }
}

/// Smallest size of a slow single effect, after its best rival, that counts as detectable.
const DECIDABLE: f64 = 5.0;

/// All statistics.
pub fn figures(outcomes: &[Outcome]) -> Vec<Statistic> {
    let singles: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| {
            matches!(o.kind, Kind::Single(_)) && o.planted[0].left.is_none_or(|left| left >= DECIDABLE)
        })
        .collect();
    let first = |o: &Outcome| o.found.first().is_some_and(|found| found.effect == o.planted[0].effect);
    let at_level = |wanted: Level| {
        let singles = singles.iter().filter(|o| o.kind == Kind::Single(wanted));
        singles.map(|o| first(o)).collect::<Vec<bool>>()
    };
    let nothing = || outcomes.iter().filter(|o| o.kind == Kind::Nothing);
    let outside = || outcomes.iter().filter(|o| o.kind == Kind::Outside);
    let pairs = || outcomes.iter().filter(|o| o.kind == Kind::Pair);
    let parameters = |name: &str| -> Vec<(f64, f64)> {
        let of = |o: &&Outcome| {
            let (truth_name, truth) = o.planted[0].parameter.clone()?;
            let (found_name, found) = o.found.first()?.parameter.clone()?;
            let right = is_reproducible(&o.planted[0].effect)
                && o.found[0].effect == o.planted[0].effect
                && found_name == truth_name
                && truth_name == name;
            right.then_some((truth, found))
        };
        singles.iter().filter_map(of).collect()
    };
    // Only effects with a parameter: a wandering line has no frequency, and further noise only an order of magnitude of its memory.
    let (taus, frequencies) = (parameters("tau_s"), parameters("freq_hz"));
    let within = taus
        .iter()
        .map(|(truth, found)| (found / truth - 1.0).abs() <= 0.3)
        .chain(frequencies.iter().map(|(truth, found)| (found - truth).abs() <= 0.02));
    let errors = taus.iter().map(|(truth, found)| (found / truth - 1.0).abs());
    let shares = |o: &Outcome| Some(o.measured_reduction.unwrap_or(0.0) / o.achievable_reduction?);
    let shared: Vec<f64> = outcomes
        .iter()
        .filter(|o| {
            matches!(o.kind, Kind::Single(_) | Kind::Pair)
                && o.planted.iter().all(|p| is_reproducible(&p.effect))
        })
        .filter(|o| o.verdict == Verdict::Missing)
        .filter_map(shares)
        .collect();
    let seconds = outcomes.iter().map(|o| o.seconds);
    let mut figures = vec![
        rate("single effect named first, all", Goal::AtLeast(0.88, 0.95), singles.iter().map(|o| first(o))),
        rate("  weak (10–16)", Goal::AtLeast(0.80, 0.90), at_level(Level::Weak)),
        rate("  medium (22–45)", Goal::AtLeast(0.90, 0.96), at_level(Level::Medium)),
        rate("  strong (80–300)", Goal::AtLeast(0.97, 0.995), at_level(Level::Strong)),
        rate(
            "single effect among the first three",
            Goal::AtLeast(0.95, 0.98),
            singles.iter().map(|o| named(&o.found, &o.planted[0].effect, 3)),
        ),
        rate(
            "wrong name claimed with verdict missing",
            Goal::AtMost(0.04, 0.01),
            singles.iter().map(|o| o.verdict == Verdict::Missing && !first(o)),
        ),
        rate(
            "false alarm with nothing missing",
            Goal::AtMost(0.02, 0.007),
            nothing().map(|o| o.verdict.is_alarm()),
        ),
        rate(
            "outside the library: unexplained",
            Goal::AtLeast(0.75, 0.90),
            outside().map(|o| o.verdict == Verdict::Unexplained),
        ),
        rate(
            "outside the library: wrong name claimed",
            Goal::AtMost(0.05, 0.02),
            outside().map(|o| o.verdict == Verdict::Missing),
        ),
        rate(
            "inseparable pair declared, with the experiment",
            Goal::AtLeast(0.92, 1.0),
            outcomes.iter().filter_map(|o| match o.kind {
                Kind::Inseparable(a, b) => Some(declared(&o.found, a, b)),
                _ => None,
            }),
        ),
        rate(
            "two effects, both in the first three",
            Goal::AtLeast(0.90, 0.98),
            pairs().map(|o| o.planted.iter().all(|planted| named(&o.found, &planted.effect, 3))),
        ),
        rate("parameter: τ within 30 %, frequency within 0.02 Hz", Goal::AtLeast(0.90, 0.95), within),
        quantile("  median error of τ", Goal::AtMost(0.04, 0.015), 0.5, errors),
        quantile(
            "share of the achievable reduction on eval: median",
            Goal::AtLeast(0.98, 0.998),
            0.5,
            shared.iter().copied(),
        ),
        quantile("  10th percentile", Goal::AtLeast(0.93, 0.985), 0.1, shared.iter().copied()),
        rate(
            "corrections that make eval worse by over 2 %",
            Goal::AtMost(0.01, 0.0),
            outcomes.iter().map(|o| o.measured_reduction.is_some_and(|fall| fall < -0.02)),
        ),
        rate(
            "predicted reduction's 90 % interval holds",
            Goal::Within([0.80, 0.97], [0.87, 0.93]),
            predictions(singles.iter().copied()),
        ),
        quantile("time for one case, s: median", Goal::Seconds(5.0, 1.0), 0.5, seconds.clone()),
        quantile("  longest", Goal::Seconds(5.0, 1.0), 1.0, seconds),
    ];
    figures.extend(of_every_axis(outcomes));
    figures
}

/// Statistics compared between worlds: the same cases with disturbed logs.
pub fn in_world(outcomes: &[Outcome]) -> Vec<Statistic> {
    let of = |wanted: fn(&Kind) -> bool| outcomes.iter().filter(move |o| wanted(&o.kind));
    let is_clear = |kind: &Kind| matches!(kind, Kind::Single(Level::Medium | Level::Strong));
    let first = |o: &Outcome| o.found.first().is_some_and(|found| found.effect == o.planted[0].effect);
    let worse_by =
        |share: f64| outcomes.iter().map(move |o| o.measured_reduction.is_some_and(|gone| gone < -share));
    let mut figures = vec![
        rate(
            "single effect, medium or strong, named first",
            Goal::AtLeast(0.92, 0.96),
            of(is_clear).map(first),
        ),
        rate(
            "nothing missing: silent",
            Goal::AtLeast(0.97, 0.99),
            of(|kind| *kind == Kind::Nothing).map(|o| o.verdict == Verdict::NothingMissing),
        ),
        rate(
            "wrong name claimed",
            Goal::AtMost(0.02, 0.01),
            of(|kind| matches!(kind, Kind::Single(_))).map(|o| o.verdict == Verdict::Missing && !first(o)),
        ),
        rate(
            "outside the library: unexplained",
            Goal::AtLeast(0.75, 0.90),
            of(|kind| *kind == Kind::Outside).map(|o| o.verdict == Verdict::Unexplained),
        ),
        rate(
            "predicted reduction's 90 % interval holds",
            Goal::Within([0.80, 0.97], [0.85, 0.95]),
            predictions(outcomes.iter().filter(|o| matches!(o.kind, Kind::Single(_)))),
        ),
        rate("made worse by over 2 %", Goal::AtMost(0.005, 0.0), worse_by(0.02)),
        rate("made worse by over 50 %", Goal::AtMost(0.0, 0.0), worse_by(0.5)),
    ];
    figures.extend(of_every_axis(outcomes));
    figures
}

/// Statistics of logs without a missing effect in which every axis was diagnosed; empty without such logs.
fn of_every_axis(outcomes: &[Outcome]) -> Vec<Statistic> {
    let asked: Vec<&Vec<Alarm>> = outcomes.iter().filter_map(|o| o.alarms.as_ref()).collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let is_named = |alarm: &Alarm| alarm.verdict == Verdict::Missing;
    let named = |alarms: &Vec<Alarm>| alarms.iter().filter(|alarm| is_named(alarm)).count();
    let of_axes = asked.iter().flat_map(|alarms| (0..AXES.len()).map(|axis| axis < named(alarms)));
    vec![
        rate(
            "nothing missing in any axis: an alarm",
            Goal::AtMost(0.02, 0.01),
            asked.iter().map(|alarms| !alarms.is_empty()),
        ),
        rate("  axes in which an effect is named", Goal::AtMost(0.002, 0.001), of_axes),
    ]
}

/// For each case with only the true effect found: the measured reduction lies within the interval of the prediction.
fn predictions<'a>(singles: impl IntoIterator<Item = &'a Outcome>) -> Vec<bool> {
    let holds = |o: &Outcome| {
        let found = o.found.first().filter(|found| found.effect == o.planted[0].effect)?;
        let measured = o.measured_reduction?;
        let counts = o.found.len() == 1 && found.effect != "bias_step" && found.expected.0 > 0.0;
        counts.then(|| (found.expected.1[0]..=found.expected.1[1]).contains(&measured))
    };
    singles.into_iter().filter_map(holds).collect()
}

/// The effect recurs in the next log. A shock, the phase of a wandering line and further noise do not.
fn is_reproducible(effect: &str) -> bool {
    const CHANCE: [&str; 6] = [
        "bias_step",
        "drifting_line",
        "gauss_markov",
        "rate_random_walk",
        "random_telegraph",
        "noise_temperature",
    ];
    !CHANCE.contains(&effect)
}

fn named(found: &[FoundIn], effect: &str, among: usize) -> bool {
    found.iter().take(among).any(|found| found.effect == effect)
}

/// The first finding is one of the two effects, lists the other as indistinguishable, and suggests an experiment.
fn declared(found: &[FoundIn], a: Effect, b: Effect) -> bool {
    let (a, b) = (a.to_string(), b.to_string());
    found.first().is_some_and(|first| {
        let other = if first.effect == a { &b } else { &a };
        (first.effect == a || first.effect == b) && first.confounded_with.contains(other) && first.separated
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_match_clopper_and_pearson() {
        // Clopper and Pearson 1934: 0 of 10, 3 of 10, 10 of 10.
        for (hit, [low, high]) in [(0, [0.0, 0.3085]), (3, [0.0667, 0.6525]), (10, [0.6915, 1.0])] {
            let found = interval(hit, 10);
            assert!((found[0] - low).abs() < 1e-4 && (found[1] - high).abs() < 1e-4, "{hit}: {found:?}");
        }
    }

    #[test]
    fn missed_goal_is_inconclusive_with_few_cases() {
        let goal = Goal::AtLeast(0.9, 0.95);
        let missed = rate("few", goal, [true, true, true, false]);
        assert!(!missed.holds() && missed.may_hold());
        let missed = rate("many", goal, (0..400).map(|i| i % 4 != 0));
        assert!(!missed.holds() && !missed.may_hold());
        assert!(rate("none", goal, []).holds());
    }
}
