//! Terms of a physical part in the units of the log, as in a data sheet: `0.0123 ± 0.0004 (°/s)/K of temp_c`. The stored coefficients are
//! of scaled inputs and axes and not readable.

use fos_core::{Channel, Factor, Source, Transform};

use fos_data::column::Column;
use fos_figures::units::{ErrorUnit, Units, three};
use fos_fit::model::{FittedAxis, FittedTerm, NamedInput, UnitModel};

/// Terms of the physical part of an axis.
pub fn physical_terms(model: &UnitModel, axis: &FittedAxis, units: Units) -> Vec<String> {
    axis.physical.iter().map(|term| line(model, axis, term, units)).collect()
}

fn line(model: &UnitModel, axis: &FittedAxis, term: &FittedTerm, units: Units) -> String {
    let parts: Vec<Part> = term.factors.iter().filter_map(|factor| Part::of(model, *factor)).collect();
    let per_scaled = axis.parameters.scale / parts.iter().map(|part| part.scale).product::<f64>();
    let (value, error) =
        (term.coefficient * per_scaled, term.standard_error.map(|error| error * per_scaled.abs()));
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    // °/s and mg, as in data sheets.
    let shown = ErrorUnit::of(&axis.column, f64::INFINITY, units);
    let unit = ratio(shown.label, &parts);
    let mut text = shown.show(value);
    if let Some(error) = error {
        text += &format!(" ± {}", shown.show(error));
    }
    if !unit.is_empty() {
        text += &format!(" {unit}");
    }
    text += &format!(" of {}", names.join(" · "));
    // A product is stated with the centres of its inputs: about others, it would change the slope of each.
    if let [_, _, ..] = parts[..] {
        let about: Vec<String> = parts.iter().filter_map(Part::about).collect();
        if !about.is_empty() {
            text += &format!(", about {}", about.join(", "));
        }
    }
    text
}

/// `(rad/s)/°C`, `mg/(°C·V)`; only the numerator if the inputs have no unit, such as a sine.
fn ratio(numerator: &str, parts: &[Part]) -> String {
    let below: Vec<&str> =
        parts.iter().map(|part| part.unit.as_str()).filter(|unit| !unit.is_empty()).collect();
    let numerator = if numerator.contains('/') && !below.is_empty() {
        format!("({numerator})")
    } else {
        numerator.to_owned()
    };
    let grouped = |unit: &str| match unit.contains('/') && !unit.starts_with('(') {
        true => format!("({unit})"),
        false => unit.to_owned(),
    };
    match &below[..] {
        [] => numerator,
        [one] => format!("{numerator}/{}", grouped(one)),
        several => {
            let several: Vec<String> = several.iter().map(|unit| grouped(unit)).collect();
            format!("{numerator}/({})", several.join("·"))
        }
    }
}

/// An input of a term.
struct Part {
    /// Text of the input, as `temp_c:lowpass(60)`.
    name: String,
    /// Unit after the transform; empty for a plain number.
    unit: String,
    /// Size of one scaled input in that unit.
    scale: f64,
    /// Centre of the quantity, with its unit; none if it has no effect.
    centre: Option<(String, f64, &'static str)>,
}

impl Part {
    fn of(model: &UnitModel, factor: Factor) -> Option<Self> {
        let Channel::Input(index) = factor.channel else { return None };
        let NamedInput { name, input } = model.inputs.get(usize::from(index))?;
        let quantity = match input.source {
            Source::Quantity(index) => model.quantities.get(usize::from(index)),
            _ => None,
        };
        let label = quantity.map_or("", |logged| Column::named(&logged.column).unit().label());
        // A column whose name does not state a unit still has one.
        let own = match label {
            "" if quantity.is_some() => "unit",
            "°C" => "K",
            label => label,
        };
        let (unit, scale) = match input.transform {
            Transform::Identity
            | Transform::LowPass { .. }
            | Transform::Backlash { .. }
            | Transform::Absolute => (own.to_owned(), input.scale),
            Transform::Rate { .. } => (format!("{own}/s"), input.scale),
            Transform::Variance { .. } => {
                let square = if own.contains('/') { format!("({own})²") } else { format!("{own}²") };
                (square, input.scale * input.scale)
            }
            Transform::Time => ("s".to_owned(), input.scale),
            Transform::Decay { .. } | Transform::Sine { .. } | Transform::Cosine { .. } => {
                (String::new(), 1.0)
            }
        };
        let name = match factor.lag {
            0 => name.clone(),
            lag => format!("{name} {lag} samples before"),
        };
        // The others are differences, or centred on zero.
        let is_level = matches!(input.transform, Transform::Identity | Transform::LowPass { .. });
        let centre = quantity.filter(|_| is_level).map(|logged| (logged.column.clone(), input.centre, label));
        Some(Self { name, unit, scale, centre })
    }

    fn about(&self) -> Option<String> {
        let (column, centre, label) = self.centre.as_ref()?;
        Some(format!("{column} = {} {label}", three(*centre)).trim_end().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_core::{FittedOn, InnovationStatistics, Input, Quantity, Range, u};
    use fos_fit::model::LoggedQuantity;

    /// Model of one axis with the scale 0.002; inputs with the scales 2.5 and 0.05 about 25 and 3.3.
    fn model(column: &str, logged: [&str; 2], transform: Transform<f64>) -> UnitModel {
        let range = Range::new(-3.0, 3.0);
        let input = |index: u8, transform, (centre, scale)| NamedInput {
            name: if index == 0 { "first".to_owned() } else { "second".to_owned() },
            input: Input {
                source: Source::Quantity(index),
                transform,
                centre,
                scale,
                source_range: range,
                range,
            },
        };
        let innovation = InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 };
        let parameters = fos_core::AxisParameters {
            axis: Column::named(column).axis(),
            reference: 0.0,
            offset: 0.0,
            scale: 0.002,
            constant: 0.0,
            range,
            physical_range: Range::unlimited(),
            full_scale: 0.0,
            stuck_after_repeats: 20,
            gap_limit_samples: 10,
            coast_limit_s: 1.0,
            innovation,
        };
        let term = |factors: &[Factor]| FittedTerm {
            coefficient: -0.5,
            standard_error: Some(0.25),
            factors: factors.to_vec(),
        };
        UnitModel {
            period_s: 0.01,
            fitted_on: FittedOn::Raw,
            stillness: None,
            calibration: None,
            quantities: logged
                .map(|name| LoggedQuantity { column: name.to_owned(), quantity: Quantity::Other })
                .to_vec(),
            inputs: vec![input(0, transform, (25.0, 2.5)), input(1, Transform::Identity, (3.3, 0.05))],
            axes: vec![FittedAxis {
                column: column.to_owned(),
                parameters,
                physical: vec![term(&[u(0, 0)]), term(&[u(0, 0), u(1, 0)])],
                stochastic: vec![],
                plain: None,
            }],
        }
    }

    fn lines(column: &str, logged: [&str; 2], transform: Transform<f64>) -> Vec<String> {
        let model = model(column, logged, transform);
        physical_terms(&model, &model.axes[0], Units::Field)
    }

    #[test]
    fn terms_have_the_units_of_the_log() {
        let of = |column, logged: [&str; 2], transform| lines(column, logged, transform)[0].clone();
        let tau_s = 10.0;
        for (column, logged, transform, says) in [
            ("gx_rads", "temp_c", Transform::Identity, "-0.0229 ± 0.0115 (°/s)/K of first"),
            ("ax_mps2", "supply_v", Transform::Identity, "-0.0408 ± 0.0204 mg/V of first"),
            ("gx_rads", "ax_mps2", Transform::LowPass { tau_s }, "-0.0229 ± 0.0115 (°/s)/(m/s²) of first"),
            ("gx_rads", "temp_c", Transform::Rate { tau_s }, "(°/s)/(K/s) of first"),
            // The scale of the input squared.
            (
                "gx_rads",
                "ax_mps2",
                Transform::Variance { tau_s },
                "-0.00917 ± 0.00458 (°/s)/(m/s²)² of first",
            ),
            ("gx_rads", "charge_a", Transform::Identity, "(°/s)/unit of first"),
            // A plain number, for any scale of the input.
            ("gx_rads", "temp_c", Transform::Decay { tau_s }, "-0.0573 ± 0.0286 °/s of first"),
            ("gx_rads", "temp_c", Transform::Time, "(°/s)/s of first"),
            ("wind", "temp_c", Transform::Identity, "-0.000400 ± 0.000200 /K of first"),
        ] {
            let text = of(column, [logged, "supply_v"], transform);
            assert!(text.contains(says), "{text}\n{says}");
        }
    }

    #[test]
    fn product_states_both_units_and_centres() {
        let text = &lines("gx_rads", ["temp_c", "supply_v"], Transform::Identity)[1];
        let says = "-0.458 ± 0.229 (°/s)/(K·V) of first · second";
        assert!(text.starts_with(says), "{text}");
        assert!(text.ends_with(", about temp_c = 25.0 °C, supply_v = 3.30 V"), "{text}");
    }
}
