//! `inspect`: what is in an image.

use std::path::PathBuf;

use clap::Args;
use fos_core::{Channel, Image, Term};
use serde_json::{Value, json};

use super::output::{Failure, number, print_json};
use crate::file;
use crate::model::unit_of;

/// Show what is in a model image
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit inspect unit.fosm")]
pub(super) struct Inspect {
    /// The image
    image: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let bytes = file::read(&self.image)?;
        let image = Image::parse(&bytes).map_err(|error| format!("{}: {error}", self.image.display()))?;
        if self.json { print_json(&as_json(&image)) } else { print(&image, bytes.len()) }
    }
}

fn print(image: &Image<'_>, bytes: usize) -> Result<(), Failure> {
    let info = image.info();
    println!("{bytes} bytes, format version {}, checksum right", fos_core::image::VERSION);
    println!("sensor       {}", if info.sensor.is_empty() { "not named" } else { info.sensor });
    println!("sample rate  {:.4} Hz", 1.0 / image.period_s());
    println!("fitted on    {:?} values", image.fitted_on());
    println!("provenance   {}", info.provenance.replace('\n', "\n             "));
    if let Some(limits) = image.stillness() {
        println!(
            "still        window {} samples, accelerometers below {} m/s², gyros below {} rad/s",
            limits.window,
            number(f64::from(limits.accel_variance).sqrt()),
            number(f64::from(limits.gyro_variance).sqrt())
        );
    }
    for (name, index) in info.quantities.lines().zip(0..) {
        println!("quantity {index}   {name}");
    }
    for (input, index) in image.inputs().zip(0..) {
        println!(
            "input u{index}     {:?} of {:?}, centre {}, scale {}, fitted {} … {}",
            input.transform,
            input.source,
            number(input.centre.into()),
            number(input.scale.into()),
            number(input.range.low.into()),
            number(input.range.high.into())
        );
    }
    for axis in image.axes() {
        let p = axis.parameters;
        let unit = match p.axis {
            fos_core::Axis::Ax | fos_core::Axis::Ay | fos_core::Axis::Az => unit_of("_mps2"),
            fos_core::Axis::Gx | fos_core::Axis::Gy | fos_core::Axis::Gz => unit_of("_rads"),
            fos_core::Axis::Other => "",
        };
        println!(
            "\n{:?}: reference {} {unit}, offset {} {unit}, scale {} {unit}",
            p.axis,
            number(p.reference.into()),
            number(p.offset.into()),
            number(p.scale.into())
        );
        println!(
            "  remainder fitted from {} to {}, innovation {} {unit} rms, coasts for {} s, restarts after {} missing",
            number(p.range.low.into()),
            number(p.range.high.into()),
            number(f64::from(p.innovation.variance).sqrt() * f64::from(p.scale)),
            p.coast_limit_s,
            p.gap_limit
        );
        println!("  p =");
        axis.physical.for_each(|term| println!("    {}", term_text(&term)));
        println!("  r̂ = {:+.6e}", p.constant);
        axis.stochastic.for_each(|term| println!("    {}", term_text(&term)));
    }
    Ok(())
}

fn term_text(term: &Term<f32>) -> String {
    let factors: Vec<String> = term
        .factors()
        .iter()
        .map(|factor| match (factor.channel, factor.lag) {
            (Channel::Output, lag) => format!("r(n-{lag})"),
            (Channel::Input(input), 0) => format!("u{input}(n)"),
            (Channel::Input(input), lag) => format!("u{input}(n-{lag})"),
        })
        .collect();
    format!("{:+.6e} {}", term.coefficient, factors.join("·"))
}

fn as_json(image: &Image<'_>) -> Value {
    let info = image.info();
    let terms = |terms: fos_core::image::Terms<'_>| -> Vec<Value> {
        terms.map(|term| json!({ "coefficient": term.coefficient, "factors": term.factors() })).collect()
    };
    let axes: Vec<Value> = image
        .axes()
        .map(|axis| {
            json!({
                "parameters": axis.parameters,
                "physical": terms(axis.physical),
                "stochastic": terms(axis.stochastic),
            })
        })
        .collect();
    json!({
        "format_version": fos_core::image::VERSION,
        "sensor": info.sensor,
        "quantities": info.quantities.lines().collect::<Vec<_>>(),
        "effects": info.effects.lines().collect::<Vec<_>>(),
        "provenance": info.provenance,
        "period_s": image.period_s(),
        "fitted_on": image.fitted_on(),
        "stillness": image.stillness(),
        "inputs": image.inputs().collect::<Vec<_>>(),
        "axes": axes,
    })
}
