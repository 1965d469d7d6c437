//! Terms of an effect: products of inputs, filled in for an axis.

use fos_data::column::{Column, GYROS};
use std::fmt;
use std::sync::Arc;

use fos_fit::fit::InputSpec;

#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// Factors of the product.
    pub inputs: Vec<InputSpec>,
}

impl Product {
    /// Parses inputs joined by `*`.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(Self { inputs: text.split('*').map(|input| input.trim().parse()).collect::<Result<_, _>>()? })
    }

    /// Evaluates the product row by row from the values of its inputs.
    pub(super) fn over<E>(
        &self,
        input: impl Fn(&InputSpec) -> Result<Arc<Vec<f64>>, E>,
    ) -> Result<Arc<Vec<f64>>, E> {
        combined(self.inputs.iter().map(input), |a, b| a * b)
    }

    /// Returns the columns that the product needs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().filter_map(|input| input.column.as_deref())
    }
}

/// A sum of products that share one coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Regressor {
    pub products: Vec<Product>,
}

impl Regressor {
    /// Parses products joined by `+`.
    pub fn parse(text: &str) -> Result<Self, String> {
        Ok(Self { products: text.split('+').map(Product::parse).collect::<Result<_, _>>()? })
    }

    /// Returns the columns that the regressor needs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.products.iter().flat_map(Product::columns)
    }

    /// Returns the inputs of all products, in order.
    pub fn inputs(&self) -> impl Iterator<Item = &InputSpec> {
        self.products.iter().flat_map(|product| &product.inputs)
    }

    /// Returns the inputs that occur as a power. A sum of powers, such as a squared vector length, is not a curve of
    /// any single input and gives none.
    pub fn powers(&self) -> impl Iterator<Item = &InputSpec> {
        let is_power = |product: &Product, input: &InputSpec| {
            product.inputs.iter().filter(|other| *other == input).count() > 1
        };
        let single = self.products.first().filter(|_| self.products.len() == 1);
        single
            .into_iter()
            .flat_map(move |product| product.inputs.iter().filter(move |input| is_power(product, input)))
    }

    /// Evaluates the regressor with each input, given as text, replaced by `value`.
    pub fn at(&self, value: impl Fn(&str) -> f64) -> f64 {
        let product =
            |product: &Product| product.inputs.iter().map(|input| value(&input.to_string())).product::<f64>();
        self.products.iter().map(product).sum()
    }

    /// Evaluates the regressor row by row from the values of its inputs.
    pub(super) fn over<E>(
        &self,
        input: impl Fn(&InputSpec) -> Result<Arc<Vec<f64>>, E>,
    ) -> Result<Arc<Vec<f64>>, E> {
        combined(self.products.iter().map(|product| product.over(&input)), |a, b| a + b)
    }
}

/// Combines columns value by value; a single column is returned unchanged.
fn combined<E>(
    columns: impl Iterator<Item = Result<Arc<Vec<f64>>, E>>,
    combine: impl Fn(f64, f64) -> f64,
) -> Result<Arc<Vec<f64>>, E> {
    let mut columns = columns;
    let Some(first) = columns.next() else { return Ok(Arc::default()) };
    columns.try_fold(first?, |all, next| {
        Ok(Arc::new(all.iter().zip(next?.iter()).map(|(a, b)| combine(*a, *b)).collect()))
    })
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

/// Fills the placeholders in the text of a term: `{target}`, `{next}`, `{after}` are the target's column and the next
/// two of its triad in cyclic order; `{gyro}`, `{gyro_next}`, `{gyro_after}` are the gyro columns of the same axes. The
/// name of the parameter stands for its value, `{5 tau_s}` for five times its value.
pub(super) fn filled(text: &str, target: &str, parameter: Option<(&str, f64)>) -> Result<String, String> {
    let mut filled = text.replace("{target}", target);
    if let Some((name, value)) = parameter {
        filled = with_multiples(&filled.replace(&format!("{{{name}}}"), &value.to_string()), name, value);
    }
    if filled.contains('{') {
        let Some((triad, place)) = Column::named(target).place() else {
            return Err(format!("{text:?} asks for the axes of a triad, and {target:?} is none"));
        };
        for (suffix, step) in [("", 0), ("_next", 1), ("_after", 2)] {
            let turned = (place + step) % 3;
            filled = filled.replace(&format!("{{gyro{suffix}}}"), GYROS[turned]);
            let plain = suffix.trim_start_matches('_');
            filled = filled.replace(&format!("{{{plain}}}"), triad.columns()[turned]);
        }
    }
    match filled.find('{') {
        None => Ok(filled),
        Some(at) => Err(format!(
            "{text:?}: no placeholder {}; there are {{target}}, {{next}}, {{after}}, {{gyro}}, {{gyro_next}}, {{gyro_after}} and the parameter, alone or as {{5 tau_s}}",
            &filled[at..]
        )),
    }
}

/// Replaces every `{NUMBER name}` by that multiple of the value; all other text stays.
fn with_multiples(text: &str, name: &str, value: f64) -> String {
    let mut filled = String::new();
    let mut rest = text;
    // terminates: each iteration shortens the rest by at least an opening brace
    while let Some((before, inside)) = rest.split_once('{') {
        filled.push_str(before);
        let multiple = inside.split_once('}').and_then(|(placeholder, after)| {
            let factor: f64 = placeholder.strip_suffix(name)?.trim().parse().ok()?;
            Some((factor * value, after))
        });
        rest = match multiple {
            Some((value, after)) => {
                filled.push_str(&value.to_string());
                after
            }
            None => {
                filled.push('{');
                inside
            }
        };
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_in_multiples_of_the_parameter() {
        let fill = |text| filled(text, "gx_rads", Some(("onset_s", 2.5)));
        let text = "clock:decay({onset_s}) + clock:decay({4 onset_s}) * {target}";
        assert_eq!(fill(text).unwrap(), "clock:decay(2.5) + clock:decay(10) * gx_rads");
        assert!(fill("clock:decay({four onset_s})").unwrap_err().contains("{four onset_s}"));
    }

    #[test]
    fn placeholders_name_the_axes_of_the_target() {
        let fill = |text, target| filled(text, target, Some(("tau_s", 60.5)));
        assert_eq!(fill("ref_{next} * ref_{after}", "gy_rads").unwrap(), "ref_gz_rads * ref_gx_rads");
        assert_eq!(fill("ref_{gyro_next}:rate(0.05)", "az_mps2").unwrap(), "ref_gx_rads:rate(0.05)");
        assert_eq!(fill("temp_c:lowpass({tau_s})", "other").unwrap(), "temp_c:lowpass(60.5)");
        assert_eq!(fill("temp_c:lowpass({2 tau_s})", "other").unwrap(), "temp_c:lowpass(121)");
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
