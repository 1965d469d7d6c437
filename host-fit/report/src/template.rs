//! Common parts of the templates of reports: environment, format of numbers and figures.

use minijinja::syntax::SyntaxConfig;
use minijinja::{AutoEscape, Environment, Error, Value, context, escape_formatter};

use fos_data::visible::visible_lines;
use fos_diagnose::detect::rms_reduction;
use fos_figures::units::three;
use fos_figures::{Figure, svg};

/// Failure to render a report.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] fos_figures::FigureError),
    /// The template is invalid or fails.
    #[error("the report cannot be rendered: {0}")]
    Template(#[from] Error),
}

/// Returns the environment for HTML, which escapes everything but markup.
pub(super) fn of_pages() -> Result<Environment<'static>, Error> {
    let mut environment = environment(AutoEscape::Html)?;
    environment.set_formatter(|out, state, value| match value.as_str() {
        Some(text) if !value.is_safe() => escape_formatter(out, state, &visible_lines(text).into()),
        _ => escape_formatter(out, state, value),
    });
    Ok(environment)
}

/// Returns a figure for a template: picture and title.
pub(super) fn drawn(figure: &Figure) -> Result<Value, RenderError> {
    let picture = svg(figure)?;
    Ok(context! { title => figure.title.as_str(), svg => Value::from_safe_string(picture) })
}

/// Style sheet of every page.
pub(super) fn style() -> Value {
    Value::from_safe_string(include_str!("report.css").to_owned())
}

pub(super) fn environment(escape: AutoEscape) -> Result<Environment<'static>, Error> {
    let mut environment = Environment::new();
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.set_auto_escape_callback(move |_| escape.clone());
    environment.add_filter("number", |value: Option<f64>| value.map_or_else(|| "–".to_owned(), shown));
    environment.add_filter("root", |value: Option<f64>| {
        value.map_or_else(|| "–".to_owned(), |value| shown(value.max(0.0).sqrt()))
    });
    environment.add_filter("percent", percent);
    environment.add_filter("rms_percent", |value: Option<f64>| percent(value.map(rms_reduction)));
    environment.add_filter("hundredths", |shares: Vec<f64>| {
        shares.iter().map(|share| format!("{:.0}", 100.0 * share)).collect::<Vec<_>>().join(" : ")
    });
    environment.add_filter("parameter", parameter);
    environment.add_filter("seconds", |value: f64| format!("{value:.1} s"));
    Ok(environment)
}

/// Name of an effect's parameter in words, with its unit: `time constant, s` for `tau_s`.
fn parameter(name: &str) -> String {
    let (name, unit) = match name.rsplit_once('_') {
        Some((name, "s")) => (name, ", s"),
        Some((name, "k")) => (name, ", K"),
        Some((name, "hz")) => (name, ", Hz"),
        Some((name, "v")) => (name, ", V"),
        _ => (name, ""),
    };
    let words = match name {
        "tau" => "time constant",
        "freq" => "frequency",
        "dwell" => "mean dwell time",
        "mult" => "step, multiple of the usual one",
        "frac" => "share of the samples",
        name => name,
    };
    format!("{}{unit}", words.replace('_', " "))
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "–".to_owned(), |share| format!("{:.1} %", 100.0 * share).replace('-', "−"))
}

fn shown(value: f64) -> String {
    three(value).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::parameter;

    #[test]
    fn names_of_parameters_are_words_with_their_unit() {
        let names = ["tau_s", "half_width_k", "onset_s", "freq_hz", "frac"].map(parameter);
        let expected =
            ["time constant, s", "half width, K", "onset, s", "frequency, Hz", "share of the samples"];
        assert_eq!(names, expected);
    }
}
