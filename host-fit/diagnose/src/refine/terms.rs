//! Conversion of findings to terms of the physical part of a model, with the same coefficients in the form of fos-core.

use fos_data::column::Column;
use std::collections::BTreeMap;
use std::ops::Range;

use fos_core::{Factor, Input, Range as Fitted, Source, Transform, u};

use crate::detect::{CorrectionTerm, Finding, step_time};
use crate::effects::{Inputs, Product, Regressor};
use fos_data::recording::{Recording, RecordingError};
use fos_fit::fit::InputSpec;
use fos_fit::model::{FittedTerm, InputsMut, LoggedQuantity, NamedInput, position};
use fos_fit::single_axis::SingleAxisModel;

/// Widths of the fitted range by which an input may exceed it before it is limited: a linear term extrapolates well, and
/// a ramp goes on for as long again as the log. Inputs that occur as powers keep the limits of the finding.
const WIDTHS: f64 = 1.0;

/// Adds findings to the physical part of `model`; `fitted` is the log in which they were found. Steps
/// become no terms, since they are part of the bias of every later log. Returns the positions of the terms, effect by
/// effect.
pub(super) fn add(
    model: &mut SingleAxisModel,
    findings: &[Finding],
    fitted: &Recording,
) -> Result<Vec<Range<usize>>, RecordingError> {
    let mut places = Vec::new();
    let logged = Inputs::new(fitted);
    let scale = model.axis().parameters.scale;
    for finding in findings {
        let first = model.axis().physical.len();
        for CorrectionTerm { regressor, coefficient, standard_error } in &finding.correction {
            if step_time(regressor).is_some() {
                continue;
            }
            // every regressor of a diagnosis can be parsed
            let Ok(Regressor { products }) = Regressor::parse(regressor) else { continue };
            for product in &products {
                let factors = factors(
                    model.inputs_mut(),
                    product,
                    |_| 0.0,
                    &finding.limits,
                    |spec| logged.input(spec).map(|values| range(&values)),
                )?;
                model.axis_mut().physical.push(FittedTerm {
                    coefficient: coefficient / scale,
                    standard_error: Some(standard_error / scale),
                    factors,
                });
            }
        }
        places.push(first..model.axis().physical.len());
    }
    Ok(places)
}

/// Returns the factors of a product of inputs in a physical part. Inputs that the model lacks are appended, with the
/// quantities that they need. They are in the unit of the quantity, so that a coefficient is per kelvin, and count from
/// the `centre` of its column.
///
/// An input is limited to its `limits`, by its text; without limits, to one width beyond the range that was `seen` of
/// it. Both count from the centre.
pub fn factors<E>(
    mut model: InputsMut<'_>,
    product: &Product,
    centre: impl Fn(&str) -> f64,
    limits: &BTreeMap<String, [f64; 2]>,
    seen: impl Fn(&InputSpec) -> Result<[f64; 2], E>,
) -> Result<Vec<Factor>, E> {
    product.inputs.iter().map(|spec| Ok(u(place(&mut model, spec, &centre, limits, &seen)?, 0))).collect()
}

/// Returns the index of an input in the model; appends it if absent.
fn place<E>(
    model: &mut InputsMut<'_>,
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
            let index = position(model.quantities, quantity);
            let identity = InputSpec { column: Some(column.clone()), transform: Transform::Identity };
            (Source::Quantity(index), widened(seen(&identity)?))
        }
    };
    let name = spec.to_string();
    let range = match (spec.transform, limits.get(&name)) {
        (_, Some([low, high])) => Fitted::new(*low, *high),
        (Transform::Decay { .. }, _) => Fitted::new(0.0, 1.0),
        (Transform::Sine { .. } | Transform::Cosine { .. }, _) => Fitted::new(-1.0, 1.0),
        (Transform::Time, _) => Fitted::new(0.0, widened(seen(spec)?).high),
        _ => widened(seen(spec)?),
    };
    let centre = spec.column.as_deref().map_or(0.0, centre);
    let input = Input { source, transform: spec.transform, centre, scale: 1.0, source_range, range };
    let named = NamedInput { name, input };
    Ok(position(model.inputs, named))
}

fn range(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
}

fn widened([low, high]: [f64; 2]) -> Fitted<f64> {
    let margin = WIDTHS * (high - low);
    Fitted::new(low - margin, high + margin)
}
