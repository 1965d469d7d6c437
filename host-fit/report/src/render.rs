//! Renders a report as HTML and as Markdown. Nothing is computed here.

use std::collections::BTreeMap;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Error, ErrorKind, Value, context};

use super::template::{RenderError, drawn, environment, of_pages, style};
use super::{AxisSection, AxisUnits, Report, markdown_text};
use crate::unaided::{LEGEND, LEGEND_STRAPDOWN, UnaidedRow};
use fos_figures::Figure;
use fos_figures::units::{ShownUnit, Units, three};

/// Renders the report as one file that contains its styles and figures.
pub fn html(report: &Report) -> Result<String, RenderError> {
    // every figure is drawn before it is rendered
    let mut axes = Vec::new();
    for axis in &report.axes {
        let section = &axis.section;
        let unit = AxisUnits::of(section).errors.field;
        let picture = |figure: &Figure| drawn(&figure.clone().in_unit(&section.unit, &unit));
        let figures = axis.figures.iter().map(picture).collect::<Result<Vec<_>, _>>()?;
        let evidence = section.offers.iter().map(|offer| offer.evidence.as_ref().map(picture).transpose());
        let evidence = evidence.collect::<Result<Vec<_>, _>>()?;
        let staircase = section.staircase.as_ref().map(picture).transpose()?;
        axes.push(context! { figures, evidence, staircase, ..numbers(section) });
    }
    let mut environment = of_pages()?;
    add_unit_filters(&mut environment);
    let template = environment.template_from_str(include_str!("report.html"))?;
    Ok(template.render(context! { axes, style => style(), ..whole(report) })?)
}

/// Renders the same numbers as Markdown; the figures are those of `fos compare --figures`.
///
/// # Errors
///
/// The template fails, which no report causes.
pub fn markdown(report: &Report) -> Result<String, RenderError> {
    let mut environment = markdown_environment()?;
    add_unit_filters(&mut environment);
    environment.add_filter("code", |text: &str| Value::from_safe_string(markdown_text::code(text)));
    environment
        .add_filter("shell", |lines: Vec<String>| Value::from_safe_string(markdown_text::shell(&lines)));
    let template = environment.template_from_str(include_str!("report.md"))?;
    let axes: Vec<Value> = report.axes.iter().map(|axis| numbers(&axis.section)).collect();
    Ok(template.render(context! { axes, ..whole(report) })?)
}

/// Report, and the errors of its six axes together, for people.
fn whole(report: &Report) -> Value {
    let strapdown = UnaidedRow::of_strapdown(&report.strapdown, Units::Field);
    context! {
        report => Serde(report),
        strapdown => Serde(&strapdown),
        strapdown_legend => LEGEND_STRAPDOWN,
        unaided_legend => LEGEND,
    }
}

/// Numbers of an axis, with their units for people.
fn numbers(section: &AxisSection) -> Value {
    let AxisUnits { errors, sizes, .. } = AxisUnits::of(section);
    let sizes: BTreeMap<String, ShownUnit> =
        sizes.into_iter().map(|(stored, unit)| (stored, unit.field)).collect();
    let unaided =
        section.comparison.as_ref().map_or_else(Vec::new, |axis| UnaidedRow::all(axis, Units::Field));
    context! {
        section => Serde(section),
        errors_in => Serde(&errors.field),
        sizes_in => Serde(&sizes),
        unaided => Serde(&unaided),
    }
}

/// Adds filters that show a value in SI, or the root of its square, in the unit given as argument, without its label.
fn add_unit_filters(environment: &mut Environment<'_>) {
    let shown = |value: Option<f64>, unit: &Value| -> Result<String, Error> {
        let divisor = f64::try_from(unit.get_attr("divisor")?)?;
        Ok(value.map_or_else(|| "–".to_owned(), |value| three(value / divisor).replace('-', "−")))
    };
    environment.add_filter("in_unit", move |value: Option<f64>, unit: Value| shown(value, &unit));
    environment.add_filter("root_in_unit", move |square: Option<f64>, unit: Value| {
        shown(square.map(|square| square.max(0.0).sqrt()), &unit)
    });
}

/// Returns the environment for Markdown, which escapes text.
pub(super) fn markdown_environment() -> Result<Environment<'static>, Error> {
    let mut environment = environment(AutoEscape::Custom("markdown".into()))?;
    environment.set_formatter(|out, _, value| match value.as_str() {
        Some(text) if !value.is_safe() => {
            write!(out, "{}", markdown_text::escaped(text)).map_err(|_| ErrorKind::WriteFailure.into())
        }
        _ => write!(out, "{value}").map_err(|_| ErrorKind::WriteFailure.into()),
    });
    Ok(environment)
}
