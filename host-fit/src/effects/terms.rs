//! The terms of an effect: products of inputs, filled in for an axis, and evaluated over a recording by fos-core.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt;
use std::rc::Rc;

use fos_core::Transformer;

use crate::fit::InputSpec;
use crate::recording::{Boundary, Recording, RecordingError};

/// A product of inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// Its inputs.
    pub inputs: Vec<InputSpec>,
}

impl Product {
    /// From text: inputs joined by `*`.
    ///
    /// # Errors
    ///
    /// An input cannot be read.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(Self { inputs: text.split('*').map(|input| input.trim().parse()).collect::<Result<_, _>>()? })
    }

    /// The columns that it needs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().filter_map(|input| input.column.as_deref())
    }
}

/// A regressor: the sum of products, which share a coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Regressor {
    /// Its products.
    pub products: Vec<Product>,
}

impl Regressor {
    /// From text: products joined by `+`.
    ///
    /// # Errors
    ///
    /// A product cannot be read.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(Self { products: text.split('+').map(Product::parse).collect::<Result<_, _>>()? })
    }

    /// The columns that it needs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.products.iter().flat_map(Product::columns)
    }
}

impl fmt::Display for Regressor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let products: Vec<String> = self.products.iter().map(ToString::to_string).collect();
        f.write_str(&products.join(" + "))
    }
}

impl fmt::Display for Product {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inputs: Vec<String> = self.inputs.iter().map(ToString::to_string).collect();
        f.write_str(&inputs.join(" * "))
    }
}

/// The text of a term with its placeholders filled: `{target}`, `{next}`, `{after}` are the target's column and the next
/// two of its triad in cyclic order; `{gyro}`, `{gyro_next}`, `{gyro_after}` the gyro columns of the same axes; the name of
/// the parameter stands for its value.
pub(super) fn filled(text: &str, target: &str, parameter: Option<(&str, f64)>) -> Result<String, String> {
    let mut filled = text.replace("{target}", target);
    if let Some((name, value)) = parameter {
        filled = filled.replace(&format!("{{{name}}}"), &value.to_string());
    }
    if filled.contains('{') {
        let letters = ['x', 'y', 'z'];
        let place = letters.iter().position(|letter| target.get(1..2) == Some(&letter.to_string()));
        let (Some(place), Some(kind), Some(unit)) = (place, target.get(..1), target.get(2..)) else {
            return Err(format!("{text:?} asks for the axes of a triad, and {target:?} is none"));
        };
        for (suffix, step) in [("", 0), ("_next", 1), ("_after", 2)] {
            let letter = letters[(place + step) % 3];
            filled = filled.replace(&format!("{{gyro{suffix}}}"), &format!("g{letter}_rads"));
            let plain = suffix.trim_start_matches('_');
            filled = filled.replace(&format!("{{{plain}}}"), &format!("{kind}{letter}{unit}"));
        }
    }
    match filled.find('{') {
        None => Ok(filled),
        Some(at) => Err(format!(
            "{text:?}: no placeholder {}; there are {{target}}, {{next}}, {{after}}, {{gyro}}, {{gyro_next}}, {{gyro_after}} and the parameter",
            &filled[at..]
        )),
    }
}

/// Evaluates inputs over a recording, one value per row, as fos-core does on the device.
#[derive(Debug)]
pub struct Inputs<'a> {
    recording: &'a Recording,
    /// The inputs of the log that a model was fitted to, if they differ from these.
    fitted: Option<&'a Inputs<'a>>,
    /// Inputs without a parameter, which are asked for again and again.
    kept: RefCell<HashMap<String, Rc<[f64]>>>,
}

/// By how much of its width the range of an input in the log that a model was fitted to is widened before a value is
/// limited to it: as fos-core does on the device.
const MARGIN: f64 = 0.05;

impl<'a> Inputs<'a> {
    /// Of this recording.
    pub fn new(recording: &'a Recording) -> Self {
        Self { recording, fitted: None, kept: RefCell::default() }
    }

    /// Of this recording, each kept inside its range in the log that a model was fitted to: nothing is known of a cubic
    /// outside.
    pub fn within(recording: &'a Recording, fitted: &'a Inputs<'a>) -> Self {
        Self { recording, fitted: Some(fitted), kept: RefCell::default() }
    }

    /// The recording.
    pub fn recording(&self) -> &'a Recording {
        self.recording
    }

    /// What the recording has of a regressor: the sum of those of its products whose columns are all logged, if any are.
    pub fn logged(&self, regressor: &Regressor) -> Option<Regressor> {
        let is_logged =
            |product: &&Product| product.columns().all(|column| self.recording.channel(column).is_ok());
        let products: Vec<Product> = regressor.products.iter().filter(is_logged).cloned().collect();
        (!products.is_empty()).then_some(Regressor { products })
    }

    /// A regressor over all rows.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub fn regressor(&self, regressor: &Regressor) -> Result<Rc<[f64]>, RecordingError> {
        let mut products = regressor.products.iter();
        let Some(first) = products.next() else { return Ok(Rc::from([])) };
        let mut values = self.product(first)?;
        for product in products {
            let other = self.product(product)?;
            values = values.iter().zip(other.iter()).map(|(a, b)| a + b).collect();
        }
        Ok(values)
    }

    /// A product over all rows.
    ///
    /// # Errors
    ///
    /// A column is missing.
    fn product(&self, product: &Product) -> Result<Rc<[f64]>, RecordingError> {
        let mut inputs = product.inputs.iter();
        let Some(first) = inputs.next() else { return Ok(Rc::from([])) };
        let mut values = self.input(first)?;
        for input in inputs {
            let other = self.input(input)?;
            values = values.iter().zip(other.iter()).map(|(a, b)| a * b).collect();
        }
        Ok(values)
    }

    /// An input over all rows. A missing value is held; what came before the first is not known (NaN).
    ///
    /// # Errors
    ///
    /// The column is missing.
    pub fn input(&self, spec: &InputSpec) -> Result<Rc<[f64]>, RecordingError> {
        let name = spec.to_string();
        if let Some(known) = self.kept.borrow().get(&name) {
            return Ok(known.clone());
        }
        let mut values = self.evaluate(spec)?;
        if let Some(fitted) = self.fitted {
            let known = fitted.input(spec)?;
            let finite = || known.iter().copied().filter(|value| value.is_finite());
            let (low, high) =
                (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
            let margin = MARGIN * (high - low);
            if low <= high {
                values.iter_mut().for_each(|value| *value = value.clamp(low - margin, high + margin));
            }
        }
        let values: Rc<[f64]> = values.into();
        if !name.contains('(') {
            self.kept.borrow_mut().insert(name, values.clone());
        }
        Ok(values)
    }

    fn evaluate(&self, spec: &InputSpec) -> Result<Vec<f64>, RecordingError> {
        let n_rows = self.recording.n_rows();
        let held: Box<dyn Iterator<Item = f64>> = match &spec.column {
            Some(column) => Box::new(self.recording.channel(column)?.held(0..n_rows)),
            None => Box::new(std::iter::repeat_n(0.0, n_rows)),
        };
        if spec.transform == fos_core::Transform::Identity {
            return Ok(held.collect());
        }
        let period_s = self.recording.rate.period_s;
        let mut transformer = Transformer::new(&spec.transform, period_s);
        let mut values = Vec::with_capacity(n_rows);
        let mut held = held;
        for segment in &self.recording.segments {
            match segment.boundary {
                Boundary::Start => {}
                Boundary::Recording => transformer = Transformer::new(&spec.transform, period_s),
                _ => transformer.skip(u32::try_from(segment.missing_before).unwrap_or(u32::MAX)),
            }
            values.extend(held.by_ref().take(segment.rows.len()).map(|x| transformer.update(x)));
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_name_the_axes_of_the_target() {
        let fill = |text, target| filled(text, target, Some(("tau_s", 60.5)));
        assert_eq!(fill("ref_{next} * ref_{after}", "gy_rads").unwrap(), "ref_gz_rads * ref_gx_rads");
        assert_eq!(fill("ref_{gyro_next}:rate(0.05)", "az_mps2").unwrap(), "ref_gx_rads:rate(0.05)");
        assert_eq!(fill("temp_c:lowpass({tau_s})", "other").unwrap(), "temp_c:lowpass(60.5)");
        assert!(fill("ref_{next}", "other").is_err());
        assert!(fill("ref_{nxt}", "gx_rads").unwrap_err().contains("{nxt}"));
    }

    #[test]
    fn a_product_reads_back() {
        let product = Product::parse("ref_gx_rads * temp_c:lowpass(20)").unwrap();
        assert_eq!(product.to_string(), "ref_gx_rads * temp_c:lowpass(20)");
        assert_eq!(product.columns().collect::<Vec<_>>(), ["ref_gx_rads", "temp_c"]);
    }
}
