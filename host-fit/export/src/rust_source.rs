//! The model as Rust source: statics in flash, checked at compile time.

use std::fmt::{self, Display, Formatter, Write};

use fos_core::{
    AxisModel, AxisParameters, Calibration, Channel, Factor, Input, Model, Quantity, Range, Source,
    StillnessLimits, Term, Transform, TriadCalibration,
};
use fos_embedded::raw::Scales;
use fos_embedded::test_vector::{Expected, TestSample};

use super::test_vector::{self, OwnedTestVector, Room, test_vector};
use fos_data::escaping::rust_comment;
use fos_fit::model::UnitModel;

/// Rust source: `MODEL`, which needs fos-core; then `TEST_VECTOR`, `check` and `ModelHub`, which need fos-embedded and are omitted for a
/// model that no hub accepts. `provenance` goes into a comment.
pub fn rust_source(model: &UnitModel, provenance: &str) -> String {
    let mut source = String::new();
    let _ = rust_comment(&mut source, "//", provenance);
    model.with::<f32, _>(|model| {
        let _ = write!(source, "{}", Items(model));
    });
    let _ = match test_vector(model) {
        Ok(vector) => write!(source, "{}", TestItems { model, vector: &vector }),
        Err(error) => {
            source.push('\n');
            rust_comment(&mut source, "//", &format!("There is no test vector: {error}."))
        }
    };
    source
}

/// Items that check the results of a device against those of the export.
struct TestItems<'a> {
    model: &'a UnitModel,
    vector: &'a OwnedTestVector,
}

impl Display for TestItems<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let vector = self.vector.vector();
        let Room { inputs, terms, history } = Room::for_model(self.model);
        writeln!(f, "\n// From here on fos-embedded is needed; leave it out where only fos-core is used.\n")?;
        writeln!(f, "use fos_embedded::hub::{{Hub, Motion::{{Moving, Still}}}};")?;
        writeln!(f, "use fos_embedded::raw::Scales;")?;
        writeln!(f, "use fos_embedded::test_vector::{{CheckError, Expected, TestSample, TestVector}};\n")?;
        writeln!(f, "/// The smallest hub that takes the model: inputs, terms, values of history.")?;
        writeln!(f, "pub type ModelHub = Hub<{inputs}, {terms}, {history}>;\n")?;
        writeln!(
            f,
            "/// Runs the test vector through a hub of its own, on the stack: at start-up, before the model"
        )?;
        writeln!(f, "/// is trusted.")?;
        writeln!(f, "///\n/// # Errors\n///")?;
        writeln!(
            f,
            "/// Index of the first sample of which one bit deviates; or why the hub does not take the model."
        )?;
        writeln!(f, "pub fn check() -> Result<(), CheckError> {{")?;
        writeln!(f, "    let mut hub = ModelHub::new(TEST_VECTOR.scales);")?;
        writeln!(f, "    hub.load_checked(&MODEL)?;")?;
        writeln!(f, "    TEST_VECTOR.run(&mut hub).map_err(CheckError::Deviates)")?;
        writeln!(f, "}}\n")?;
        writeln!(f, "#[cfg(test)]\n#[test]")?;
        writeln!(f, "fn the_model_comes_to_the_bits_of_its_test_vector() {{")?;
        writeln!(f, "    assert_eq!(check(), Ok(()));")?;
        writeln!(f, "}}\n")?;

        rust_comment(f, "///", &test_vector::comment(self.vector, self.model))?;
        let Scales { accel_mps2, gyro_rads, temperature_k, temperature_zero_c, period_s, values } =
            vector.scales;
        writeln!(f, "pub static TEST_VECTOR: TestVector<'static> = TestVector {{")?;
        writeln!(f, "    scales: Scales {{")?;
        writeln!(f, "        accel_mps2: {accel_mps2:?},")?;
        writeln!(f, "        gyro_rads: {gyro_rads:?},")?;
        writeln!(f, "        temperature_k: {temperature_k:?},")?;
        writeln!(f, "        temperature_zero_c: {temperature_zero_c:?},")?;
        writeln!(f, "        period_s: {period_s:?},")?;
        writeln!(f, "        values: FittedOn::{values:?},")?;
        writeln!(f, "    }},")?;
        writeln!(f, "    channels: &{:?},", vector.channels)?;
        writeln!(f, "    given: &{:?},", vector.given)?;
        writeln!(f, "    samples: &SAMPLES,")?;
        writeln!(f, "    given_bits: &GIVEN,")?;
        writeln!(f, "    expected: &EXPECTED,")?;
        writeln!(f, "}};\n")?;

        writeln!(f, "static SAMPLES: [TestSample; {}] = [", vector.samples.len())?;
        for TestSample { motion, skipped, codes, temperature } in vector.samples {
            writeln!(
                f,
                "    TestSample {{ motion: {motion:?}, skipped: {skipped}, codes: {codes:?}, temperature: {temperature:?} }},"
            )?;
        }
        writeln!(f, "];\n")?;
        writeln!(f, "static GIVEN: [u32; {}] = [", vector.given_bits.len())?;
        for row in vector.given_bits.chunks(vector.given.len().max(1)) {
            writeln!(f, "    {},", List(row.iter().map(|bits| format!("{bits:#010x}"))))?;
        }
        writeln!(f, "];\n")?;
        writeln!(f, "const fn bits(corrected: u32, innovation: u32, validity: u16) -> Expected {{")?;
        writeln!(f, "    Expected {{ corrected, innovation, validity }}")?;
        writeln!(f, "}}\n")?;
        writeln!(f, "static EXPECTED: [Expected; {}] = [", vector.expected.len())?;
        for row in vector.expected.chunks(vector.channels.len().max(1)) {
            let axis = |&Expected { corrected, innovation, validity }: &Expected| {
                format!("bits({corrected:#010x}, {innovation:#010x}, {validity:#05x})")
            };
            writeln!(f, "    {},", List(row.iter().map(axis)))?;
        }
        writeln!(f, "];")
    }
}

struct Items<'a>(&'a Model<'a, f32>);

impl Display for Items<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let model = self.0;
        // Some models do not use all of them.
        writeln!(f, "#[allow(unused_imports)]")?;
        writeln!(f, "use fos_core::{{")?;
        writeln!(
            f,
            "    Axis, AxisModel, AxisParameters, Calibration, CheckedModel, FittedOn, InnovationStatistics, Input, Model,"
        )?;
        writeln!(
            f,
            "    Quantity, Range, Source, StillnessLimits, Term, Transform, TriadCalibration, u, y,"
        )?;
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
        writeln!(
            f,
            "/// The fitted model: inputs, terms and scaling of {} axes. The compiler checks it.",
            model.axes.len()
        )?;
        writeln!(f, "pub static MODEL: CheckedModel<'static> = CheckedModel::new(Model {{")?;
        writeln!(f, "    period_s: {:?},", model.period_s)?;
        writeln!(f, "    fitted_on: FittedOn::{:?},", model.fitted_on)?;
        match &model.stillness {
            Some(limits) => writeln!(f, "    stillness: Some({}),", Stillness(limits))?,
            None => writeln!(f, "    stillness: None,")?,
        }
        match &model.calibration {
            Some(calibration) => write_calibration(f, calibration)?,
            None => writeln!(f, "    calibration: None,")?,
        }
        writeln!(f, "    quantities: &[{}],", List(model.quantities.iter().map(quantity)))?;
        writeln!(f, "    inputs: &INPUTS,")?;
        writeln!(f, "    axes: &AXES,")?;
        writeln!(f, "}});")
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

fn write_calibration(f: &mut Formatter<'_>, calibration: &Calibration<f32>) -> fmt::Result {
    writeln!(f, "    calibration: Some(Calibration {{")?;
    for (name, triad) in [("accel", &calibration.accel), ("gyro", &calibration.gyro)] {
        let TriadCalibration { matrix, bias } = triad;
        writeln!(f, "        {name}: TriadCalibration {{ matrix: {matrix:?}, bias: {bias:?} }},")?;
    }
    writeln!(f, "    }}),")
}

fn quantity(quantity: &Quantity) -> String {
    match quantity {
        Quantity::Measured(axis) => format!("Quantity::Measured(Axis::{axis:?})"),
        Quantity::Reference(axis) => format!("Quantity::Reference(Axis::{axis:?})"),
        plain => format!("Quantity::{plain:?}"),
    }
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
        physical_range,
        full_scale,
        stuck_after_repeats,
        gap_limit_samples,
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
    writeln!(f, "            physical_range: {},", RangeItem(&physical_range))?;
    writeln!(f, "            full_scale: {full_scale:?},")?;
    writeln!(f, "            stuck_after_repeats: {stuck_after_repeats},")?;
    writeln!(f, "            gap_limit_samples: {gap_limit_samples},")?;
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

/// Items separated by commas.
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
