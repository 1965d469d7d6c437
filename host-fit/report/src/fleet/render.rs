//! A population as a page. Nothing is computed here.

use minijinja::value::Serde;
use minijinja::{Error, Value, context};

use super::FleetReport;
use crate::template::{RenderError, drawn, of_pages, style};
use fos_figures::units::three_beside;

/// Renders the report as one file that contains its styles and figures.
pub fn html(report: &FleetReport) -> Result<String, RenderError> {
    // every figure is drawn before it is rendered, in the order of parts, axes and coefficients
    let mut parts = Vec::new();
    for part in &report.parts {
        let mut axes = Vec::new();
        for axis in &part.axes {
            let figures = axis.coefficients.iter().map(|coefficient| drawn(&coefficient.figure));
            axes.push(context! { of => Serde(axis), figures => figures.collect::<Result<Vec<_>, _>>()? });
        }
        let variance = part.variance.as_ref().map(drawn).transpose()?;
        parts.push(context! { of => Serde(part), axes, variance });
    }
    let mut environment = of_pages()?;
    environment.add_filter("of_coefficient", of_coefficient);
    let template = environment.template_from_str(include_str!("fleet.html"))?;
    Ok(template.render(context! { report => Serde(report), parts, style => style() })?)
}

/// Shows a value of a coefficient; one that is too small to matter beside its uncertainty and scatter is 0.
fn of_coefficient(value: Option<f64>, coefficient: Value) -> Result<String, Error> {
    let number = |name: &str| f64::try_from(coefficient.get_attr(name)?);
    let ends = coefficient.get_attr("mean_interval")?;
    let end = |at: usize| f64::try_from(ends.get_item(&Value::from(at))?);
    let scale = (end(1)? - end(0)?).max(number("between_units")?).max(number("error_of_log")?);
    Ok(value.map_or_else(|| "–".to_owned(), |value| three_beside(value, scale).replace('-', "−")))
}
