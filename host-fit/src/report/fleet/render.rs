//! A population as a page. Nothing is computed here.

use minijinja::context;
use minijinja::value::Serde;

use super::FleetReport;
use crate::report::template::{RenderError, drawn, of_pages, style};

/// Renders the report as one file that contains its styles and figures.
///
/// # Errors
///
/// A figure cannot be drawn.
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
    let environment = of_pages()?;
    let template = environment.template_from_str(include_str!("fleet.html"))?;
    Ok(template.render(context! { report => Serde(report), parts, style => style() })?)
}
