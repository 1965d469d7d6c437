//! A report as a page, and as Markdown. Nothing is computed here.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Error, ErrorKind, Value, context, escape_formatter};

use super::{Report, markdown_text};
use crate::figures::{Figure, svg};
use fos_data::text::number;
use fos_data::visible::visible_lines;

/// Why a report cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] crate::figures::FigureError),
    /// The template.
    #[error("the report cannot be rendered: {0}")]
    Template(#[from] Error),
}

/// One file that needs nothing else: styles and figures are in it.
///
/// # Errors
///
/// A figure cannot be drawn.
pub fn html(report: &Report) -> Result<String, RenderError> {
    // every figure is drawn before it is rendered: (picture, title)
    let drawn = |figure: &Figure| -> Result<Value, RenderError> {
        let picture = svg(figure)?;
        Ok(context! { title => figure.title.as_str(), svg => Value::from_safe_string(picture) })
    };
    let mut axes = Vec::new();
    for axis in &report.axes {
        let figures = axis.figures.iter().map(drawn).collect::<Result<Vec<_>, _>>()?;
        let evidence = axis.section.offers.iter().map(|offer| offer.evidence.as_ref().map(drawn).transpose());
        let evidence = evidence.collect::<Result<Vec<_>, _>>()?;
        let staircase = axis.section.staircase.as_ref().map(drawn).transpose()?;
        axes.push(context! { section => Serde(&axis.section), figures, evidence, staircase });
    }
    let mut environment = environment(AutoEscape::Html)?;
    environment.set_formatter(|out, state, value| match value.as_str() {
        Some(text) if !value.is_safe() => escape_formatter(out, state, &visible_lines(text).into()),
        _ => escape_formatter(out, state, value),
    });
    let template = environment.template_from_str(include_str!("report.html"))?;
    let style = Value::from_safe_string(include_str!("report.css").to_owned());
    Ok(template.render(context! { report => Serde(report), axes, style })?)
}

/// The same numbers as text; figures are those of `host-fit compare --figures`.
///
/// # Errors
///
/// None that a report can cause.
pub fn markdown(report: &Report) -> Result<String, RenderError> {
    let mut environment = environment(AutoEscape::Custom("markdown".into()))?;
    environment.set_formatter(|out, _, value| match value.as_str() {
        Some(text) if !value.is_safe() => {
            write!(out, "{}", markdown_text::escaped(text)).map_err(|_| ErrorKind::WriteFailure.into())
        }
        _ => write!(out, "{value}").map_err(|_| ErrorKind::WriteFailure.into()),
    });
    environment.add_filter("code", |text: &str| Value::from_safe_string(markdown_text::code(text)));
    environment
        .add_filter("shell", |lines: Vec<String>| Value::from_safe_string(markdown_text::shell(&lines)));
    let template = environment.template_from_str(include_str!("report.md"))?;
    Ok(template.render(context! { report => Serde(report) })?)
}

fn environment(escape: AutoEscape) -> Result<Environment<'static>, Error> {
    let mut environment = Environment::new();
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.set_auto_escape_callback(move |_| escape.clone());
    environment.add_filter("number", |value: Option<f64>| value.map_or_else(|| "–".to_owned(), shown));
    environment.add_filter("root", |value: Option<f64>| {
        value.map_or_else(|| "–".to_owned(), |value| shown(value.max(0.0).sqrt()))
    });
    environment.add_filter("percent", |value: Option<f64>| {
        value.map_or_else(|| "–".to_owned(), |share| format!("{:.1} %", 100.0 * share).replace('-', "−"))
    });
    environment.add_filter("seconds", |value: f64| format!("{value:.1} s"));
    Ok(environment)
}

fn shown(value: f64) -> String {
    number(value).replace('-', "−")
}
