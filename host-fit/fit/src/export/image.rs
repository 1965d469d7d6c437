//! Model image, as specified in docs/MODEL_FORMAT.md.

use fos_core::image::encode;
use fos_core::{Channel, Factor, Image, ImageError, Info, ModelError, Quantity, Source, Transform};
use fos_data::column::Column;

use crate::model::{HostPredictor, UnitModel};
use fos_data::visible::visible;

/// Size limit of an image, bytes; a model of 6 axes with 20 terms each takes about 2000.
const LARGEST: usize = 1 << 16;

/// The image of a model cannot be written, or cannot be read back.
#[derive(Debug, thiserror::Error)]
#[error("the model makes no usable image: {error}\nhelp: {help}", error = .0, help = remedy(.0))]
pub struct UnusableImage(pub ImageError);

fn remedy(error: &ImageError) -> &'static str {
    use ModelError::{LagTooDeep, TooManyInputs, TooManyTerms};
    match error {
        ImageError::TooLarge
        | ImageError::Model(TooManyInputs { .. } | TooManyTerms { .. } | LagTooDeep { .. }) => {
            "a model with a smaller `max_terms`, `max_lag`, or with fewer inputs"
        }
        _ => "fit the model again: the stored values do not fit into f32, or were changed by hand",
    }
}

/// Returns the image of `model`, which is read back and run as a check.
///
/// # Errors
///
/// The model has more than 255 of something, or does not fit fos-core after rounding to f32.
pub fn image(model: &UnitModel, sensor: &str, provenance: &str) -> Result<Vec<u8>, UnusableImage> {
    let quantities = model.quantities.iter().map(|logged| {
        format!("{} {}", logged.column, Column::named(&logged.column).unit().label()).trim_end().to_owned()
    });
    let (quantities, effects) = (in_lines(quantities), in_lines(effects(model)));
    let info = Info { sensor, quantities: &quantities, effects: &effects, provenance };
    let mut buffer = vec![0; LARGEST];
    let bytes = model
        .with::<f32, _>(|model| encode(model, &info, &mut buffer).map(<[u8]>::to_vec))
        .map_err(UnusableImage)?;
    let read_back = Image::parse(&bytes).map_err(UnusableImage)?;
    let _: HostPredictor<f32> = read_back.predictor().map_err(UnusableImage)?;
    Ok(bytes)
}

/// Joins names one per line, as in an image; a line break in a name would shift those after it.
fn in_lines(names: impl IntoIterator<Item = String>) -> String {
    names.into_iter().map(|name| visible(&name).into_owned()).collect::<Vec<_>>().join("\n")
}

/// Returns the identifiers of the effects in the physical parts, each once, in the order of the inputs.
fn effects(model: &UnitModel) -> Vec<String> {
    // largest number of times that an input is in a term
    let power = |index: usize| {
        let physical = model.axes.iter().flat_map(|axis| &axis.physical);
        let is_input = |factor: &&Factor| factor.channel == Channel::Input(index as u8);
        physical.map(|term| term.factors.iter().filter(is_input).count()).max().unwrap_or(0)
    };
    let mut effects = Vec::new();
    for (index, named) in model.inputs.iter().enumerate().filter(|(index, _)| power(*index) > 0) {
        let quantity = match named.input.source {
            Source::Quantity(index) => Some(model.quantities[usize::from(index)].quantity),
            _ => None,
        };
        let effect = match effect(quantity, named.input.transform) {
            Some("temp_linear") if power(index) > 1 => "temp_poly".to_owned(),
            Some(effect) => effect.to_owned(),
            None => named.name.clone(),
        };
        if !effects.contains(&effect) {
            effects.push(effect);
        }
    }
    effects
}

/// Returns the effect of a quantity with a transform, if it has a name.
fn effect(quantity: Option<Quantity>, transform: Transform<f64>) -> Option<&'static str> {
    use fos_core::Axis;
    use {Quantity as Q, Transform as T};
    match (quantity, transform) {
        (Some(Q::Temperature), T::Identity) => Some("temp_linear"),
        (Some(Q::Temperature), T::LowPass { .. }) => Some("thermal_lag"),
        (Some(Q::Temperature), T::Rate { .. }) => Some("temp_rate"),
        (Some(Q::Temperature), T::Backlash { .. }) => Some("thermal_hysteresis"),
        (Some(Q::Supply), T::Identity) => Some("supply_sensitivity"),
        (Some(Q::Load), T::LowPass { .. }) => Some("load_heating"),
        (Some(Q::MagneticX | Q::MagneticY | Q::MagneticZ), T::Identity | T::LowPass { .. }) => {
            Some("mag_sensitivity")
        }
        (Some(Q::Measured(Axis::Ax | Axis::Ay | Axis::Az)), T::Identity | T::LowPass { .. }) => {
            Some("g_sensitivity")
        }
        (Some(Q::Measured(Axis::Ax | Axis::Ay | Axis::Az)), T::Variance { .. }) => {
            Some("vibration_rectification")
        }
        (None, T::Decay { .. }) => Some("warmup_exp"),
        (None, T::Time) => Some("bias_ramp"),
        (None, T::Sine { .. } | T::Cosine { .. }) => Some("spectral_line"),
        _ => None,
    }
}
