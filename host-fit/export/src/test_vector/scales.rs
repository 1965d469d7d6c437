//! Scales of a sensor whose codes resolve the ranges that a model was fitted on.

use fos_core::{Axis, Quantity};
use fos_embedded::hub::SIX;
use fos_embedded::raw::Scales;

use super::wander::Wander;
use fos_fit::model::UnitModel;

/// Number of codes in the narrowest fitted range of three axes, unless the size of a code does not allow it.
const CODES_OF_AN_AXIS: f64 = 300.0;

/// Number of codes in the fitted range of temperature, which moves in finer steps.
const CODES_OF_TEMPERATURE: f64 = 3000.0;

/// Largest code of a sample without saturation.
pub(super) const LARGEST_CODE: f64 = 32_000.0;

/// Scales at which the model's ranges span some hundred codes, with two decimal digits.
pub(super) fn scales(model: &UnitModel, quantities: &[Wander]) -> Scales {
    let of_triad = |first: usize, without: f64| {
        let is_in = |axis: &Axis| channel(*axis).is_some_and(|channel| channel / 3 == first / 3);
        let modelled = model.axes.iter().filter(|axis| is_in(&axis.parameters.axis)).map(|axis| {
            let p = &axis.parameters;
            let (low, high) = (p.scale * p.range.low, p.scale * p.range.high);
            let size = (p.reference + p.offset).abs() + 3.0 * low.abs().max(high.abs());
            (high - low, size, p.full_scale)
        });
        let logged = model.quantities.iter().zip(quantities).filter_map(|(logged, range)| {
            let Quantity::Measured(axis) = logged.quantity else { return None };
            let size = range.low.abs().max(range.high.abs()) + range.width();
            is_in(&axis).then_some((range.width(), size, 0.0))
        });
        let (mut narrowest, mut largest, mut full_scale) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for (width, size, limit) in modelled.chain(logged) {
            narrowest = if width > 0.0 { narrowest.min(width) } else { narrowest };
            (largest, full_scale) = (largest.max(size), full_scale.max(limit));
        }
        if narrowest.is_infinite() {
            return without;
        }
        let fine = (narrowest / CODES_OF_AN_AXIS).max(largest / LARGEST_CODE);
        // Codes also reach full scale, if that costs no more than two thirds of the resolution.
        let reaching = full_scale / LARGEST_CODE;
        two_digits(if reaching <= 3.0 * fine { reaching.max(fine) } else { fine })
    };
    let temperature = model.quantities.iter().position(|logged| logged.quantity == Quantity::Temperature);
    let zero_c = 25.0;
    let temperature_k = temperature.map_or(1.0 / 256.0, |index| {
        let range = &quantities[index];
        let size = (range.low - zero_c).abs().max((range.high - zero_c).abs()) + range.width();
        two_digits((range.width() / CODES_OF_TEMPERATURE).max(size / LARGEST_CODE))
    });
    Scales {
        accel_mps2: of_triad(0, 0.0012) as f32,
        gyro_rads: of_triad(3, 0.0003) as f32,
        temperature_k: temperature_k as f32,
        temperature_zero_c: zero_c as f32,
        period_s: model.period_s,
        values: model.fitted_on,
    }
}

/// Rounds up to two significant digits, so that every compiler reads the same f32.
fn two_digits(value: f64) -> f64 {
    format!("{:.1e}", 1.05 * value).parse().unwrap_or(value)
}

/// Index of an axis among the hub's six.
pub(super) fn channel(axis: Axis) -> Option<usize> {
    SIX.iter().position(|six| *six == axis)
}
