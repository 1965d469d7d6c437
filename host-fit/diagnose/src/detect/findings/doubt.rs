//! Reasons why a slow finding is not conclusive.

use crate::detect::answer::{Finding, Size};
use crate::effects::{Band, Detector, Effect, Library, SizeUnit};
use crate::rms::rms_reduction;
use fos_data::text::rounded;

/// Factor within which a parameter counts as at a limit of the search.
const AT_LIMIT: f64 = 1.02;

/// Factor beyond the search range from which on the upper end of an interval counts as unbounded.
const NO_END: f64 = 3.0;

/// Multiple of the largest typical size from which on an effect may be another one.
const FAR_BEYOND: f64 = 20.0;

/// Ratio of the leverage to the largest in the fitted log: six times as far.
const FAR_OUT: f64 = 36.0;

/// Sets the reason on every slow finding that is not conclusive; one that its inputs gave remains where there is no
/// other. `target` is the column that was explained, over `span_s`.
pub(super) fn doubt(findings: &mut [Finding], library: &Library, target: &str, span_s: f64) {
    // share of the slow error that the findings before one leave
    let mut left = 1.0;
    for finding in findings.iter_mut() {
        let Ok(effect) = library.get(&finding.effect) else { continue };
        let inputs = finding.doubt.take();
        let explains_little = left * finding.predicted_reduction < EXPLAINS_MOST;
        if effect.band == Band::Slow {
            left *= 1.0 - finding.predicted_reduction;
        }
        finding.doubt = match (effect.band, effect.search) {
            (Band::Slow, Detector::Terms) => parameter(finding, effect)
                .or_else(|| longer_than_the_log(finding, effect, span_s))
                .or_else(|| reduction_includes_zero(finding))
                .or_else(|| size(finding, effect, target).filter(|_| explains_little)),
            (Band::Slow, Detector::Step) => reduction_includes_zero(finding),
            _ => None,
        }
        .or(inputs);
    }
}

/// Returns the reason if the evaluation log goes beyond the range of the coefficients.
pub(super) fn beyond_fitted_range(beyond: f64) -> Option<String> {
    (beyond > FAR_OUT).then(|| {
        format!(
            "the evaluation log goes {:.0} times further than this one in a combination of its inputs, where its coefficients are unknown",
            beyond.sqrt()
        )
    })
}

/// Returns the reason if an effect that follows nothing logged shows where the device was moved: what settles after a
/// motion is no warm-up, and what it turned is no step.
pub(super) fn shows_at_motion([from_s, to_s]: [f64; 2], share: f64) -> Option<String> {
    (share > 0.5).then(|| {
        format!("it shows most from {from_s:.1} s to {to_s:.1} s, among detected motion: something may have settled there")
    })
}

/// Returns the reason if a parameter is at its limit, or its upper end is unbounded.
fn parameter(finding: &Finding, effect: &Effect) -> Option<String> {
    let parameter = effect.parameter.as_ref()?;
    let value = *finding.params.get(&parameter.name)?;
    let (name, unit) = (&parameter.name, &parameter.unit);
    let at_low = value <= parameter.low * AT_LIMIT && !parameter.open_below;
    if at_low || value >= parameter.high / AT_LIMIT {
        return Some(format!("its {name} of {} {unit} is a limit of the search", rounded(value, 3)));
    }
    let [_, high] = finding.params_interval.get(name)?;
    (high.is_nan() || *high > NO_END * parameter.high).then(|| {
        format!("the log does not bound its {name}: it may be as large as {} {unit}", rounded(*high, 3))
    })
}

/// Returns the reason if a time constant exceeds half of the log: over the log such a low-pass is an integral of its
/// input, for any time constant.
fn longer_than_the_log(finding: &Finding, effect: &Effect, span_s: f64) -> Option<String> {
    let parameter = effect.parameter.as_ref().filter(|parameter| parameter.unit == "s")?;
    let (name, value) = (&parameter.name, *finding.params.get(&parameter.name)?);
    (value > 0.5 * span_s).then(|| {
        format!("its {name} of {value:.0} s is more than half of the log, which lasts {span_s:.0} s")
    })
}

/// Relative half width of a 95 % interval up to which a coefficient counts as known.
const UNKNOWN: f64 = 0.5;

/// Returns the reason if a log does not identify an estimated effect, missing or not: its parameter is unbounded, or
/// the uncertainty of its coefficients exceeds both the typical size and half of their value.
pub(crate) fn not_identifiable(finding: &Finding, effect: &Effect, target: &str) -> Option<String> {
    if effect.band != Band::Slow {
        return None;
    }
    let is_searched = effect.search == Detector::Terms;
    let unbounded = effect.parameter.as_ref().filter(|parameter| {
        is_searched
            && finding.params.contains_key(&parameter.name)
            && !finding.params_interval.contains_key(&parameter.name)
    });
    if let Some(parameter) = unbounded {
        return Some(format!("the log does not bound its {}", parameter.name));
    }
    if let Some(why) = parameter(finding, effect).filter(|_| is_searched) {
        return Some(why);
    }
    let typical = typical_sizes(effect, target);
    let half = |size: &Size| 0.5 * (size.interval[1] - size.interval[0]);
    // no single coefficient of a curve or a step has a typical size, and a course in time alone fits any drift: the score
    // decides
    if typical.is_empty() || effect.search == Detector::Step || effect.follows_clock_alone() {
        let score = finding.score.unwrap_or(0.0);
        return (score <= 0.0)
            .then(|| format!("the log fits as well without it (score {score:.1}, 0 is the least)"));
    }
    finding.sizes.iter().find_map(|size| {
        let (unit, typical) = typical.iter().find(|(unit, _)| unit.to_string() == size.unit)?;
        let half = half(size);
        let is_known = half <= *typical || half <= UNKNOWN * size.value.abs();
        (!is_known).then(|| {
            let (half, typical, unit) = (rounded(half, 3), rounded(*typical, 3), unit.spelled());
            format!(
                "the log determines its size only to ±{half} {unit}; typical sizes are up to {typical} {unit}"
            )
        })
    })
}

/// Returns unit and largest typical value of the terms of an effect that have them.
fn typical_sizes(effect: &Effect, target: &str) -> Vec<(SizeUnit, f64)> {
    let known = |term| Some((effect.unit(term, target)?, effect.typical(term, target)?));
    (0..effect.terms.len()).filter_map(known).collect()
}

/// Share of the variance from which on an effect is accepted at an implausible size.
const EXPLAINS_MOST: f64 = 0.5;

/// Describes implausible sizes, even at the near ends of their intervals.
pub(super) fn beyond_typical(findings: &[Finding], library: &Library, target: &str) -> Vec<String> {
    findings.iter().filter_map(|finding| size(finding, library.get(&finding.effect).ok()?, target)).collect()
}

fn size(finding: &Finding, effect: &Effect, target: &str) -> Option<String> {
    let typical = typical_sizes(effect, target);
    finding.sizes.iter().find_map(|size| {
        let (unit, typical) = typical.iter().find(|(unit, _)| unit.to_string() == size.unit)?;
        let [low, high] = size.interval;
        let least = if low * high > 0.0 { low.abs().min(high.abs()) } else { 0.0 };
        let times = size.value.abs() / typical;
        (least > FAR_BEYOND * typical).then(|| {
            format!(
                "{} of {} {} is {times:.0} times the largest typical size: another effect may be the cause, or a column in another unit",
                finding.name,
                rounded(size.value, 3),
                unit.spelled()
            )
        })
    })
}

/// Score from which on an effect exists whatever it reduces: odds of e³⁰ after every penalty. Lower scores occur in long
/// logs whose slow noise differs from the model of it.
const CERTAIN: f64 = 60.0;

/// Returns the reason if the predicted reduction includes 0. The noise of the evaluation log widens its interval, which
/// leaves an effect with a high score in no doubt.
fn reduction_includes_zero(finding: &Finding) -> Option<String> {
    if finding.score.is_some_and(|score| score >= CERTAIN) {
        return None;
    }
    let [low, high] = finding.predicted_reduction_interval;
    (low <= 0.0).then(|| {
        format!(
            "its predicted reduction of the RMS, {:.1} … {:.1} %, includes 0",
            100.0 * rms_reduction(low),
            100.0 * rms_reduction(high)
        )
    })
}
