//! From the findings of a diagnosis to the physical part of a model: the same coefficients, in the form that fos-core
//! takes.

use fos_data::column::Column;
use std::collections::BTreeMap;
use std::ops::Range;

use fos_core::{Factor, Input, Range as Fitted, Source, Transform, u};

use crate::detect::{CorrectionTerm, Finding, step_time};
use crate::effects::{Inputs, Product, Regressor};
use fos_data::recording::{Recording, RecordingError};
use fos_fit::fit::InputSpec;
use fos_fit::model::{FittedTerm, LoggedQuantity, NamedInput, UnitModel, position};

/// A line goes on outside its fitted range as it did inside: an input is limited, and says so, this many widths of the
/// range outside. Inputs that powers are taken of keep the limits of the finding.
const WIDTHS: f64 = 1.0;

/// Adds the effects that were found to the physical part of the only axis of `model`. `field` is the log they were
/// found in. Steps are no terms: they stay in the bias of every later log. The places of the terms, effect by effect.
///
/// # Errors
///
/// A column is missing.
pub(super) fn add(
    model: &mut UnitModel,
    findings: &[Finding],
    field: &Recording,
) -> Result<Vec<Range<usize>>, RecordingError> {
    let mut places = Vec::new();
    let inputs = Inputs::new(field);
    let scale = model.axes[0].parameters.scale;
    for finding in findings {
        let first = model.axes[0].physical.len();
        for CorrectionTerm { regressor, coefficient, standard_error } in &finding.correction {
            if step_time(regressor).is_some() {
                continue;
            }
            // what a diagnosis writes can be read
            let Ok(Regressor { products }) = Regressor::parse(regressor) else { continue };
            for product in &products {
                let factors = factors(
                    model,
                    product,
                    |_| 0.0,
                    &finding.limits,
                    |spec| inputs.input(spec).map(|values| range(&values)),
                )?;
                model.axes[0].physical.push(FittedTerm {
                    coefficient: coefficient / scale,
                    standard_error: Some(standard_error / scale),
                    factors,
                });
            }
        }
        places.push(first..model.axes[0].physical.len());
    }
    Ok(places)
}

/// The factors of a product of inputs in a physical part; inputs that the model does not have are appended, and the quantities that they
/// need. They are in the quantity's unit, so that a coefficient is per kelvin, and what is logged counts from the `centre` of its column on.
///
/// An input keeps to its `limits`, by its text; where there are none it may go one width further than what was `seen` of it. Both count
/// from there on.
///
/// # Errors
///
/// What was seen of an input is not known.
pub fn factors<E>(
    model: &mut UnitModel,
    product: &Product,
    centre: impl Fn(&str) -> f64,
    limits: &BTreeMap<String, [f64; 2]>,
    seen: impl Fn(&InputSpec) -> Result<[f64; 2], E>,
) -> Result<Vec<Factor>, E> {
    product.inputs.iter().map(|spec| Ok(u(place(model, spec, &centre, limits, &seen)?, 0))).collect()
}

/// The place of an input in the model; appended if it is not there.
fn place<E>(
    model: &mut UnitModel,
    spec: &InputSpec,
    centre: impl Fn(&str) -> f64,
    limits: &BTreeMap<String, [f64; 2]>,
    seen: impl Fn(&InputSpec) -> Result<[f64; 2], E>,
) -> Result<u8, E> {
    let (source, source_range) = match &spec.column {
        None => (Source::Clock, Fitted::new(0.0, 0.0)),
        Some(column) => {
            let quantity =
                LoggedQuantity { column: column.clone(), quantity: Column::named(column).quantity() };
            let index = position(&mut model.quantities, quantity);
            let identity = InputSpec { column: Some(column.clone()), transform: Transform::Identity };
            (Source::Quantity(index), widened(seen(&identity)?))
        }
    };
    let name = spec.to_string();
    let range = match (spec.transform, limits.get(&name)) {
        (_, Some([low, high])) => Fitted::new(*low, *high),
        (Transform::Decay { .. }, _) => Fitted::new(0.0, 1.0),
        (Transform::Sine { .. } | Transform::Cosine { .. }, _) => Fitted::new(-1.0, 1.0),
        // a device runs for longer than a log
        (Transform::Time, _) => Fitted::new(0.0, LONGEST_S),
        _ => widened(seen(spec)?),
    };
    let centre = spec.column.as_deref().map_or(0.0, centre);
    let input = Input { source, transform: spec.transform, centre, scale: 1.0, source_range, range };
    let named = NamedInput { name, input };
    Ok(position(&mut model.inputs, named))
}

/// A day: a ramp that was seen for an hour is followed no further.
const LONGEST_S: f64 = 86_400.0;

fn range(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
}

fn widened([low, high]: [f64; 2]) -> Fitted<f64> {
    let margin = WIDTHS * (high - low);
    Fitted::new(low - margin, high + margin)
}
