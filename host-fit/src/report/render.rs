//! A report as a page, and as Markdown. Nothing is computed here.

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Error, ErrorKind, Value, context};

use super::template::{RenderError, drawn, environment, of_pages, style};
use super::{Report, markdown_text};

/// One file that needs nothing else: styles and figures are in it.
///
/// # Errors
///
/// A figure cannot be drawn.
pub fn html(report: &Report) -> Result<String, RenderError> {
    // every figure is drawn before it is rendered
    let mut axes = Vec::new();
    for axis in &report.axes {
        let figures = axis.figures.iter().map(drawn).collect::<Result<Vec<_>, _>>()?;
        let evidence = axis.section.offers.iter().map(|offer| offer.evidence.as_ref().map(drawn).transpose());
        let evidence = evidence.collect::<Result<Vec<_>, _>>()?;
        let staircase = axis.section.staircase.as_ref().map(drawn).transpose()?;
        axes.push(context! { section => Serde(&axis.section), figures, evidence, staircase });
    }
    let environment = of_pages()?;
    let template = environment.template_from_str(include_str!("report.html"))?;
    Ok(template.render(context! { report => Serde(report), axes, style => style() })?)
}

/// The same numbers as text; figures are those of `fos compare --figures`.
///
/// # Errors
///
/// None that a report can cause.
pub fn markdown(report: &Report) -> Result<String, RenderError> {
    let mut environment = markdown_environment()?;
    environment.add_filter("code", |text: &str| Value::from_safe_string(markdown_text::code(text)));
    environment
        .add_filter("shell", |lines: Vec<String>| Value::from_safe_string(markdown_text::shell(&lines)));
    let template = environment.template_from_str(include_str!("report.md"))?;
    Ok(template.render(context! { report => Serde(report) })?)
}

/// For Markdown: text is escaped.
pub(crate) fn markdown_environment() -> Result<Environment<'static>, Error> {
    let mut environment = environment(AutoEscape::Custom("markdown".into()))?;
    environment.set_formatter(|out, _, value| match value.as_str() {
        Some(text) if !value.is_safe() => {
            write!(out, "{}", markdown_text::escaped(text)).map_err(|_| ErrorKind::WriteFailure.into())
        }
        _ => write!(out, "{value}").map_err(|_| ErrorKind::WriteFailure.into()),
    });
    Ok(environment)
}
