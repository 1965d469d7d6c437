//! What speaks against a slow effect that was found: it is no claim then, and says why.

use crate::detect::answer::{Finding, Size};
use crate::effects::{Band, Detector, Effect, Library, SizeUnit};
use crate::rms::rms_reduction;
use fos_data::text::rounded;

/// A parameter this near to a limit of the search is at it.
const AT_LIMIT: f64 = 1.02;

/// An interval of a parameter that reaches so many times beyond what is searched has no end.
const NO_END: f64 = 3.0;

/// An effect so many times as large as the largest that is typical may be another.
const FAR_BEYOND: f64 = 20.0;

/// Leverage over the largest that was learnt from: six times as far.
const FAR_OUT: f64 = 36.0;

/// Says of those of the slow findings that are no claim why, and puts them behind the others. `target` is the column that
/// was explained, over `span_s`.
pub(super) fn doubt(findings: &mut [Finding], library: &Library, target: &str, span_s: f64) {
    let slow = |findings: &[Finding]| findings.iter().filter(|finding| finding.band == Band::Slow).count();
    for place in 0..findings.len() {
        // what comes after it is still missing in its prediction
        let is_last = slow(&findings[place + 1..]) == 0;
        let finding = &mut findings[place];
        let Ok(effect) = library.get(&finding.effect) else { continue };
        if effect.band == Band::Slow && effect.search == Detector::Terms {
            let far = finding.doubt.take();
            let explains_little = finding.predicted_reduction < MOST;
            finding.doubt = parameter(finding, effect)
                .or_else(|| longer_than_the_log(finding, effect, span_s))
                .or_else(|| helps_nothing(finding).filter(|_| is_last))
                .or_else(|| size(finding, effect, target).filter(|_| explains_little))
                .or(far);
        }
    }
    findings.sort_by_key(|finding| (finding.band == Band::Data, finding.doubt.is_some()));
}

/// The log to be judged goes where the coefficients say nothing.
pub(super) fn far(beyond: f64) -> Option<String> {
    (beyond > FAR_OUT).then(|| {
        format!(
            "the evaluation log goes {:.0} times further than this one in a combination of its inputs, where its coefficients are unknown",
            beyond.sqrt()
        )
    })
}

/// A parameter at its limit, or of which the log does not say how large it may be.
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

/// A time constant of more than half the log: over the log such a low-pass is an integral of its input, whatever its
/// time constant.
fn longer_than_the_log(finding: &Finding, effect: &Effect, span_s: f64) -> Option<String> {
    let parameter = effect.parameter.as_ref().filter(|parameter| parameter.unit == "s")?;
    let (name, value) = (&parameter.name, *finding.params.get(&parameter.name)?);
    (value > 0.5 * span_s).then(|| {
        format!("its {name} of {value:.0} s is more than half of the log, which lasts {span_s:.0} s")
    })
}

/// Half of a 95 % interval, over the value, from which on a coefficient is known to less than a factor of two.
const UNKNOWN: f64 = 0.5;

/// Why a log does not identify an effect that was estimated from it, whether it is missing or not: its parameter has no
/// bound, or its coefficients are known neither to the size that is typical nor to half of their own.
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
    // of a curve or a moment no single coefficient has a typical size: what counts is whether the log supports it
    if typical.is_empty() || effect.search == Detector::Step {
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

/// Unit and largest typical value of the terms of an effect that have them.
fn typical_sizes(effect: &Effect, target: &str) -> Vec<(SizeUnit, f64)> {
    let known = |term| Some((effect.unit(term, target)?, effect.typical(term, target)?));
    (0..effect.terms.len()).filter_map(known).collect()
}

/// An effect of a size that nobody knows is believed if it explains most of the error.
const MOST: f64 = 0.5;

/// Sizes that no data sheet knows, even at the near ends of their intervals, in words.
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
                "{} of {} {} is {times:.0} times the largest typical size: another effect may stand behind it, or a column in another unit",
                finding.name,
                rounded(size.value, 3),
                unit.spelled()
            )
        })
    })
}

/// A fall of the error that may as well be none.
fn helps_nothing(finding: &Finding) -> Option<String> {
    let [low, high] = finding.predicted_reduction_interval;
    (low <= 0.0).then(|| {
        format!(
            "its predicted reduction of the RMS, {:.1} … {:.1} %, includes none",
            100.0 * rms_reduction(low),
            100.0 * rms_reduction(high)
        )
    })
}
