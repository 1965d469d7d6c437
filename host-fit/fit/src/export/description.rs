//! Description of a model image in words, for review before use.

use fos_data::column::Column;
use std::fmt::{self, Display, Formatter};

use fos_core::{AxisParameters, Channel, FittedOn, Image, Range, Source, Term};

use super::model_of::column_of;
use crate::fit::input_text;

use fos_data::text::number;
use fos_data::visible::visible;

/// Describes the provenance of the model in `image`, its inputs, and the terms of every axis, with units.
pub fn description(image: &Image<'_>) -> String {
    Description(image).to_string()
}

struct Description<'a>(&'a Image<'a>);

impl Display for Description<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let image = self.0;
        let info = image.info();
        writeln!(
            f,
            "sensor       {}",
            if info.sensor.is_empty() { "not named".into() } else { visible(info.sensor) }
        )?;
        writeln!(f, "sample rate  {:.4} Hz", 1.0 / image.period_s())?;
        let fitted_on = match image.fitted_on() {
            FittedOn::Raw => "raw",
            FittedOn::FactoryCorrected => "factory-corrected",
        };
        writeln!(f, "fitted on    {fitted_on} values")?;
        writeln!(f, "provenance   {}", info.provenance.replace('\n', "\n             "))?;
        if !info.effects.is_empty() {
            writeln!(f, "effects      {}", info.effects.replace('\n', ", "))?;
        }
        if let Some(limits) = image.stillness() {
            writeln!(
                f,
                "still        window {} samples, accelerometers below {} m/s², gyros below {} rad/s",
                limits.window,
                number(f64::from(limits.accel_variance).sqrt()),
                number(f64::from(limits.gyro_variance).sqrt())
            )?;
        }
        for (name, index) in info.quantities.lines().zip(0..) {
            writeln!(f, "quantity {index}   {name}")?;
        }
        for (input, index) in image.inputs().zip(0..) {
            let source = match input.source {
                Source::Quantity(quantity) => {
                    info.quantities.lines().nth(quantity.into()).unwrap_or("unnamed")
                }
                Source::Remainder(_) => "r",
                Source::Clock => "clock",
            };
            writeln!(
                f,
                "input u{index}     {}, centre {}, scale {}, limited to {} … {}",
                input_text(source, input.transform),
                number(input.centre.into()),
                number(input.scale.into()),
                number(input.range.low.into()),
                number(input.range.high.into())
            )?;
        }
        for axis in image.axes() {
            write_parameters(f, &axis.parameters)?;
            let Range { low, high } = axis.parameters.physical_range;
            match axis.parameters.physical_range == Range::unlimited() {
                true => writeln!(f, "  p =")?,
                false => writeln!(f, "  p, limited to {} … {} =", number(low.into()), number(high.into()))?,
            }
            for term in axis.physical {
                writeln!(f, "    {}", term_text(&term))?;
            }
            writeln!(f, "  r̂ = {:+.6e}", axis.parameters.constant)?;
            for term in axis.stochastic {
                writeln!(f, "    {}", term_text(&term))?;
            }
        }
        Ok(())
    }
}

fn write_parameters(f: &mut Formatter<'_>, p: &AxisParameters<f32>) -> fmt::Result {
    let column = column_of(p.axis).map(Column::named);
    let unit = column.map_or("", |column| column.unit().label());
    writeln!(
        f,
        "\n{}: reference {} {unit}, offset {} {unit}, scale {} {unit}",
        column.map_or("other axis", Column::label),
        number(p.reference.into()),
        number(p.offset.into()),
        number(p.scale.into())
    )?;
    writeln!(
        f,
        "  remainder fitted from {} to {}, innovation {} {unit} rms, coasts for {} s, restarts after {} missing",
        number(p.range.low.into()),
        number(p.range.high.into()),
        number(f64::from(p.innovation.variance).sqrt() * f64::from(p.scale)),
        p.coast_limit_s,
        p.gap_limit_samples
    )
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
