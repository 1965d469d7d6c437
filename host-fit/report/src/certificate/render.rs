//! A certificate as a page and as Markdown. Nothing is computed here.

use fos_data::unit::MG_MPS2;
use minijinja::value::Serde;
use minijinja::{Value, context};

use super::content::{Certificate, Outcome};
use super::sphere::Sphere;
use crate::RenderError;
use crate::render::markdown_environment;
use crate::template::drawn;
use crate::template::{of_pages, style};
use fos_figures::rests::residual_of_each_rest;

fn content(certificate: &Certificate) -> Result<Value, RenderError> {
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
                excluded => one.rest.excluded.as_ref().map(ToString::to_string),
            }
        })
        .collect();
    let by_hand = match &certificate.result {
        Outcome::Hand(found) => Some(&found.accelerometer),
        Outcome::Turntable(_) => None,
    };
    Ok(context! {
        sphere => Serde(by_hand.map(|found| Sphere::of(&found.rests, &found.next))),
        next => by_hand.map(|found| found.next.instruction.as_str()),
        tool => certificate.tool.as_str(),
        conditions => certificate.conditions(),
        parameters => Serde(certificate.parameters()),
        rests,
        residuals => residual_of_each_rest(certificate.rests()).as_ref().map(drawn).transpose()?,
        remarks => certificate.remarks(),
        style => style(),
    })
}

/// A self-contained HTML file.
pub fn html(certificate: &Certificate) -> Result<String, RenderError> {
    let environment = of_pages()?;
    let template = environment.template_from_str(include_str!("certificate.html"))?;
    Ok(template.render(content(certificate)?)?)
}

/// A Markdown file.
pub fn markdown(certificate: &Certificate) -> Result<String, RenderError> {
    let environment = markdown_environment()?;
    let template = environment.template_from_str(include_str!("certificate.md"))?;
    Ok(template.render(content(certificate)?)?)
}

/// A JSON file.
pub fn json(certificate: &Certificate) -> Result<Vec<u8>, serde_json::Error> {
    serde_json::to_vec_pretty(certificate)
}

/// Renders the format of a file extension: `.md`, `.json`, otherwise HTML.
pub fn of_form(certificate: &Certificate, extension: Option<&str>) -> Result<Vec<u8>, RenderError> {
    Ok(match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("md") => markdown(certificate)?.into_bytes(),
        Some("json") => json(certificate).map_err(|error| {
            minijinja::Error::new(minijinja::ErrorKind::BadSerialization, error.to_string())
        })?,
        _ => html(certificate)?.into_bytes(),
    })
}
