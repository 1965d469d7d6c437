//! The model as Rust source: statics that sit in flash, and that do not compile when a term is wrong.

use std::fmt::{self, Display, Formatter, Write};

use fos_core::{
    AxisModel, AxisParameters, Channel, Factor, Input, Model, Range, Source, StillnessLimits, Term, Transform,
};

use crate::model::UnitModel;

/// Rust source with one public item, `pub static MODEL: Model<'static, f32>`. `provenance` goes into its comment.
pub fn rust_source(model: &UnitModel, provenance: &str) -> String {
    let mut source = String::new();
    for line in provenance.lines() {
        let _ = writeln!(source, "// {line}");
    }
    model.with::<f32, _>(|model| {
        let _ = write!(source, "{}", Items(model));
    });
    source
}

struct Items<'a>(&'a Model<'a, f32>);

impl Display for Items<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let model = self.0;
        // not every model needs all of them
        writeln!(f, "#[allow(unused_imports)]")?;
        writeln!(f, "use fos_core::{{")?;
        writeln!(
            f,
            "    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Input, Model, Quantity,"
        )?;
        writeln!(f, "    Range, Source, StillnessLimits, Term, Transform, u, y,")?;
        writeln!(f, "}};\n")?;
        writeln!(f, "static INPUTS: [Input<f32>; {}] = [", model.inputs.len())?;
        for input in model.inputs {
            writeln!(f, "    {},", InputItem(input))?;
        }
        writeln!(f, "];\n")?;
        for (index, axis) in model.axes.iter().enumerate() {
            write_terms(f, "PHYSICAL", index, axis.physical)?;
            write_terms(f, "STOCHASTIC", index, axis.stochastic)?;
        }
        writeln!(f, "static AXES: [AxisModel<'static, f32>; {}] = [", model.axes.len())?;
        for (index, axis) in model.axes.iter().enumerate() {
            write_axis(f, index, axis)?;
        }
        writeln!(f, "];\n")?;
        writeln!(f, "/// The fitted model: inputs, terms and scaling of {} axes.", model.axes.len())?;
        writeln!(f, "pub static MODEL: Model<'static, f32> = Model {{")?;
        writeln!(f, "    period_s: {:?},", model.period_s)?;
        writeln!(f, "    fitted_on: FittedOn::{:?},", model.fitted_on)?;
        match &model.stillness {
            Some(limits) => writeln!(f, "    stillness: Some({}),", Stillness(limits))?,
            None => writeln!(f, "    stillness: None,")?,
        }
        writeln!(
            f,
            "    quantities: &[{}],",
            List(model.quantities.iter().map(|q| format!("Quantity::{q:?}")))
        )?;
        writeln!(f, "    inputs: &INPUTS,")?;
        writeln!(f, "    axes: &AXES,")?;
        writeln!(f, "}};")
    }
}

fn write_terms(f: &mut Formatter<'_>, part: &str, axis: usize, terms: &[Term<f32>]) -> fmt::Result {
    writeln!(f, "static {part}_{axis}: [Term<f32>; {}] = [", terms.len())?;
    for term in terms {
        let factors = List(term.factors().iter().map(factor));
        writeln!(f, "    Term::new({:?}, &[{factors}]),", term.coefficient)?;
    }
    writeln!(f, "];\n")
}

fn factor(factor: &Factor) -> String {
    match factor.channel {
        Channel::Output => format!("y({})", factor.lag),
        Channel::Input(input) => format!("u({input}, {})", factor.lag),
    }
}

fn write_axis(f: &mut Formatter<'_>, index: usize, axis: &AxisModel<'_, f32>) -> fmt::Result {
    let AxisParameters {
        axis: name,
        reference,
        offset,
        scale,
        constant,
        range,
        full_scale,
        stuck_after,
        gap_limit,
        coast_limit_s,
        innovation,
    } = axis.parameters;
    writeln!(f, "    AxisModel {{")?;
    writeln!(f, "        parameters: AxisParameters {{")?;
    writeln!(f, "            axis: Axis::{name:?},")?;
    writeln!(f, "            reference: {reference:?},")?;
    writeln!(f, "            offset: {offset:?},")?;
    writeln!(f, "            scale: {scale:?},")?;
    writeln!(f, "            constant: {constant:?},")?;
    writeln!(f, "            range: {},", RangeItem(&range))?;
    writeln!(f, "            full_scale: {full_scale:?},")?;
    writeln!(f, "            stuck_after: {stuck_after},")?;
    writeln!(f, "            gap_limit: {gap_limit},")?;
    writeln!(f, "            coast_limit_s: {coast_limit_s:?},")?;
    writeln!(f, "            innovation: InnovationStatistics {{")?;
    writeln!(f, "                mean: {:?},", innovation.mean)?;
    writeln!(f, "                variance: {:?},", innovation.variance)?;
    writeln!(f, "                lag_1_correlation: {:?},", innovation.lag_1_correlation)?;
    writeln!(f, "            }},")?;
    writeln!(f, "        }},")?;
    writeln!(f, "        physical: &PHYSICAL_{index},")?;
    writeln!(f, "        stochastic: &STOCHASTIC_{index},")?;
    writeln!(f, "    }},")
}

struct RangeItem<'a>(&'a Range<f32>);

impl Display for RangeItem<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "Range::new({:?}, {:?})", self.0.low, self.0.high)
    }
}

struct Stillness<'a>(&'a StillnessLimits<f32>);

impl Display for Stillness<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let StillnessLimits { window, accel_variance, gyro_variance, gyro_at_rest, gyro_deviation } = self.0;
        write!(
            f,
            "StillnessLimits {{ window: {window}, accel_variance: {accel_variance:?}, gyro_variance: \
             {gyro_variance:?}, gyro_at_rest: {gyro_at_rest:?}, gyro_deviation: {gyro_deviation:?} }}"
        )
    }
}

struct InputItem<'a>(&'a Input<f32>);

impl Display for InputItem<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Input { source, transform, centre, scale, source_range, range } = self.0;
        let source = match source {
            Source::Clock => "Source::Clock".to_owned(),
            Source::Quantity(index) => format!("Source::Quantity({index})"),
            Source::Remainder(axis) => format!("Source::Remainder({axis})"),
        };
        let transform = match transform {
            Transform::Identity => "Identity".to_owned(),
            Transform::LowPass { tau_s } => format!("LowPass {{ tau_s: {tau_s:?} }}"),
            Transform::Rate { tau_s } => format!("Rate {{ tau_s: {tau_s:?} }}"),
            Transform::Variance { tau_s } => format!("Variance {{ tau_s: {tau_s:?} }}"),
            Transform::Backlash { half_width } => format!("Backlash {{ half_width: {half_width:?} }}"),
            Transform::Absolute => "Absolute".to_owned(),
            Transform::Decay { tau_s } => format!("Decay {{ tau_s: {tau_s:?} }}"),
            Transform::Time => "Time".to_owned(),
            Transform::Sine { frequency_hz } => format!("Sine {{ frequency_hz: {frequency_hz:?} }}"),
            Transform::Cosine { frequency_hz } => format!("Cosine {{ frequency_hz: {frequency_hz:?} }}"),
        };
        write!(
            f,
            "Input {{ source: {source}, transform: Transform::{transform}, centre: {centre:?}, scale: {scale:?}, \
             source_range: {}, range: {} }}",
            RangeItem(source_range),
            RangeItem(range)
        )
    }
}

/// Things separated by commas.
struct List<I>(I);

impl<T: Display, I: Iterator<Item = T> + Clone> Display for List<I> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (index, item) in self.0.clone().enumerate() {
            let separator = if index == 0 { "" } else { ", " };
            write!(f, "{separator}{item}")?;
        }
        Ok(())
    }
}
