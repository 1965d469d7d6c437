//! Positions of values along an axis, and its ticks. The page does the same in `workbench/page/ticks.js`.

use super::Scale;

/// Maximum number of decades on a logarithmic axis; lower values are drawn at the lower end.
const MOST_DECADES: f64 = 12.0;

/// Range of an axis, in values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) scale: Scale,
}

/// A value with a grid line. Those without a label are subdivisions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: Option<String>,
}

impl Extent {
    /// Range of the values that can be drawn, widened on both sides by a fraction of itself; `None` without such values.
    pub(super) fn of(values: impl Iterator<Item = f64>, scale: Scale, margin: f64) -> Option<Extent> {
        let drawable = values.filter(|value| value.is_finite() && (scale == Scale::Linear || *value > 0.0));
        let (low, high) = drawable.fold(None, |range, value| match range {
            None => Some((value, value)),
            Some((low, high)) => Some((value.min(low), value.max(high))),
        })?;
        let (low, high) = match scale {
            Scale::Linear => widened(low, high, margin, if low == 0.0 { 1.0 } else { 0.05 * low.abs() }),
            Scale::Log => {
                let (low, high) = (low.log10().max(high.log10() - MOST_DECADES), high.log10());
                let (low, high) = widened(low, high, margin, 0.5);
                (10f64.powf(low), 10f64.powf(high))
            }
        };
        Some(Extent { low, high, scale })
    }

    /// Position of a value from 0 at the low end to 1 at the high end; values beyond are put at the ends. `None` for values that cannot
    /// be drawn (not finite, or not positive on a logarithmic axis).
    pub(super) fn position(&self, value: f64) -> Option<f64> {
        let fraction = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value / self.low).log10() / (self.high / self.low).log10(),
        };
        let has_place = value.is_finite() && (self.scale == Scale::Linear || value > 0.0);
        has_place.then(|| fraction.clamp(0.0, 1.0))
    }

    /// Ticks from low to high, about `wanted` of them labelled; those without a label come first.
    pub(super) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => labelled(self.round_values(wanted)),
            Scale::Log => self.decades(wanted),
        }
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn round_values(&self, wanted: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / wanted.max(1) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough).unwrap_or(10.0);
        let step = factor * power;
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last).map(|multiple| multiple as f64 * step).collect()
    }

    fn decades(&self, wanted: usize) -> Vec<Tick> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let decades = (self.high / self.low).log10();
        let labelled_digits: &[i32] = if 3.0 * decades <= wanted as f64 + 2.0 { &[1, 2, 5] } else { &[1] };
        let every = (decades / (wanted + 2) as f64).ceil().max(1.0) as i32;
        // One notation for all labels of an axis.
        let plain = first >= -3 && last <= 4;
        let mut ticks: Vec<Tick> = (first..=last)
            .flat_map(|exponent| (1..=9).map(move |digit| (digit, exponent)))
            .filter(|(digit, _)| every == 1 || *digit == 1)
            .map(|(digit, exponent)| {
                let is_labelled = labelled_digits.contains(&digit) && exponent.rem_euclid(every) == 0;
                let label = is_labelled.then(|| power_of_ten(digit, exponent, plain));
                Tick { value: f64::from(digit) * 10f64.powi(exponent), label }
            })
            .filter(|tick| tick.value >= self.low && tick.value <= self.high)
            .collect();
        ticks.sort_by_key(|tick| tick.label.is_some());
        if ticks.iter().filter(|tick| tick.label.is_some()).count() < 2 {
            return labelled(self.round_values(wanted));
        }
        ticks
    }
}

fn widened(low: f64, high: f64, margin: f64, if_constant: f64) -> (f64, f64) {
    // A range of a few rounding errors is constant to the eye, and its ticks would not differ.
    let is_constant = high - low <= 1e-12 * low.abs().max(high.abs());
    let by = if is_constant { if_constant } else { margin * (high - low) };
    (low - by, high + by)
}

/// Labels evenly spaced values with the digits necessary to distinguish them.
fn labelled(values: Vec<f64>) -> Vec<Tick> {
    let step = values.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
    let largest = values.iter().fold(0f64, |largest, value| largest.max(value.abs()));
    let step_exponent = (step * (1.0 + 1e-9)).log10().floor() as i32;
    let label = |value: f64| {
        if value.abs() < 0.5 * step {
            return "0".to_string();
        }
        if largest < 1e5 && step > 0.99e-3 {
            let decimals = step_exponent.min(0).unsigned_abs() as usize;
            return format!("{value:.decimals$}");
        }
        let exponent = (largest * (1.0 + 1e-9)).log10().floor() as i32;
        let decimals = (exponent - step_exponent).max(0) as usize;
        format!("{:.decimals$}e{exponent}", value / 10f64.powi(exponent))
    };
    let with_minus = |text: String| text.replace('-', "−");
    values.into_iter().map(|value| Tick { value, label: Some(with_minus(label(value))) }).collect()
}

fn power_of_ten(digit: i32, exponent: i32, plain: bool) -> String {
    if plain {
        let decimals = exponent.min(0).unsigned_abs() as usize;
        return format!("{:.decimals$}", f64::from(digit) * 10f64.powi(exponent));
    }
    format!("{digit}e{exponent}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis and its labels. The chart code of the page is tested against the same table (tests/browser/numbers.test.js).
    #[derive(serde::Deserialize)]
    struct Case {
        scale: String,
        low: f64,
        high: f64,
        count: usize,
        values: Vec<f64>,
        labels: Vec<String>,
    }

    #[test]
    fn ticks_match_the_table_of_the_page() {
        let cases: Vec<Case> = serde_json::from_str(include_str!("ticks.json")).unwrap();
        for Case { scale, low, high, count, values, labels } in cases {
            let scale = if scale == "Log" { Scale::Log } else { Scale::Linear };
            let extent = Extent { low, high, scale };
            let named: Vec<(f64, String)> =
                extent.ticks(count).into_iter().filter_map(|tick| Some((tick.value, tick.label?))).collect();
            assert_eq!(
                named.iter().map(|(_, label)| label).collect::<Vec<_>>(),
                labels.iter().collect::<Vec<_>>()
            );
            assert_eq!(values.len(), named.len(), "{extent:?}");
            for (value, (drawn, _)) in values.iter().zip(&named) {
                // Each is within a few rounding errors of its decimal.
                assert!((value - drawn).abs() <= 1e-12 * value.abs(), "{drawn} is not {value}: {extent:?}");
            }
        }
    }

    #[test]
    fn constant_values_get_a_range_around_them() {
        for (value, scale) in
            [(0.0, Scale::Linear), (9.81, Scale::Linear), (-3.0, Scale::Linear), (1e-9, Scale::Log)]
        {
            let extent = Extent::of([value; 3].into_iter(), scale, 0.1).unwrap();
            assert!((extent.position(value).unwrap() - 0.5).abs() < 1e-6);
            assert!(extent.ticks(5).len() >= 2, "{extent:?}");
        }
    }

    #[test]
    fn undrawable_values_have_no_position() {
        let extent = Extent::of([f64::NAN, 1.0, 100.0, -5.0, 0.0].into_iter(), Scale::Log, 0.0).unwrap();
        assert_eq!(
            (extent.position(10.0), extent.position(-5.0), extent.position(f64::NAN)),
            (Some(0.5), None, None)
        );
        assert_eq!(Extent::of([f64::NAN, f64::INFINITY].into_iter(), Scale::Linear, 0.0), None);
    }
}
