//! A certificate as a page and as Markdown. Nothing is computed here.

use fos_calibrate::MG_MPS2;
use minijinja::value::Serde;
use minijinja::{Value, context};

use super::content::Certificate;
use super::picture::Picture;
use super::shown::exclusion;
use crate::report::{RenderError, markdown_environment, page_environment, style};

fn content(certificate: &Certificate) -> Value {
    let rests: Vec<Value> = certificate
        .rests()
        .iter()
        .enumerate()
        .map(|(index, one)| {
            context! {
                number => index + 1,
                start => format!("{:.1}", one.rest.start_s),
                duration => format!("{:.1}", one.rest.duration_s),
                up => one.up.map(|part| format!("{part:+.2}").replace('-', "−")).join(" "),
                residual => format!("{:+.2}", one.residual_mps2 / MG_MPS2).replace('-', "−"),
                excluded => one.rest.excluded.as_ref().map(exclusion),
            }
        })
        .collect();
    context! {
        tool => certificate.tool.as_str(),
        conditions => certificate.conditions(),
        parameters => Serde(certificate.parameters()),
        rests,
        picture => Serde(Picture::of(certificate.rests())),
        remarks => certificate.remarks(),
        style => style(),
    }
}

/// One file that needs nothing else.
///
/// # Errors
///
/// None that a certificate can cause.
pub fn html(certificate: &Certificate) -> Result<String, RenderError> {
    let environment = page_environment()?;
    let template = environment.template_from_str(include_str!("certificate.html"))?;
    Ok(template.render(content(certificate))?)
}

/// The same as text.
///
/// # Errors
///
/// None that a certificate can cause.
pub fn markdown(certificate: &Certificate) -> Result<String, RenderError> {
    let environment = markdown_environment()?;
    let template = environment.template_from_str(include_str!("certificate.md"))?;
    Ok(template.render(content(certificate))?)
}

/// The JSON form.
///
/// # Errors
///
/// None that a certificate can cause.
pub fn json(certificate: &Certificate) -> Result<Vec<u8>, serde_json::Error> {
    serde_json::to_vec_pretty(certificate)
}

/// The form that a file name asks for: `.md`, `.json`, else HTML.
///
/// # Errors
///
/// It cannot be rendered.
pub fn of_form(certificate: &Certificate, extension: Option<&str>) -> Result<Vec<u8>, RenderError> {
    Ok(match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("md") => markdown(certificate)?.into_bytes(),
        Some("json") => json(certificate).map_err(|error| {
            minijinja::Error::new(minijinja::ErrorKind::BadSerialization, error.to_string())
        })?,
        _ => html(certificate)?.into_bytes(),
    })
}
