//! The model as Rust source: statics in flash, checked at compile time.

use std::fmt::{self, Display, Formatter, Write};

use fos_core::{AxisModel, Channel, Factor, Input, Model, Term};
use fos_embedded::test_vector::Expected;

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
        writeln!(f, "pub static TEST_VECTOR: TestVector<'static> = TestVector {{")?;
        writeln!(f, "    scales: {:?},", vector.scales)?;
        writeln!(f, "    channels: &{:?},", vector.channels)?;
        writeln!(f, "    given: &{:?},", vector.given)?;
        writeln!(f, "    samples: &SAMPLES,")?;
        writeln!(f, "    given_bits: &GIVEN,")?;
        writeln!(f, "    expected: &EXPECTED,")?;
        writeln!(f, "}};\n")?;

        writeln!(f, "static SAMPLES: [TestSample; {}] = [", vector.samples.len())?;
        for sample in vector.samples {
            writeln!(f, "    {sample:?},")?;
        }
        writeln!(f, "];\n")?;
        writeln!(f, "static GIVEN: [u32; {}] = [", vector.given_bits.len())?;
        for row in vector.given_bits.chunks(vector.given.len().max(1)) {
            writeln!(f, "    {},", list(row.iter().map(|bits| format!("{bits:#010x}"))))?;
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
            writeln!(f, "    {},", list(row.iter().map(axis)))?;
        }
        writeln!(f, "];")
    }
}

struct Items<'a>(&'a Model<'a, f32>);

impl Display for Items<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let model = self.0;
        // Some models do not use all of them. `Debug` prints the variants of `Axis` and `FittedOn` without their type.
        writeln!(f, "#[allow(unused_imports)]")?;
        writeln!(f, "use fos_core::{{")?;
        writeln!(f, "    Axis::{{self, Ax, Ay, Az, Gx, Gy, Gz, Other}},")?;
        writeln!(f, "    AxisModel, AxisParameters, Calibration, CheckedModel,")?;
        writeln!(f, "    FittedOn::{{self, FactoryCorrected, Raw}},")?;
        writeln!(
            f,
            "    InnovationStatistics, Input, Model, Quantity, Range, Source, StillnessLimits, Term, Transform,"
        )?;
        writeln!(f, "    TriadCalibration, u, y,")?;
        writeln!(f, "}};\n")?;
        writeln!(f, "static INPUTS: [Input<f32>; {}] = [", model.inputs.len())?;
        for input in model.inputs {
            let Input { source, transform, centre, scale, source_range, range } = input;
            writeln!(
                f,
                "    Input {{ source: Source::{source:?}, transform: Transform::{transform:?}, centre: {centre:?}, \
                 scale: {scale:?}, source_range: {source_range:?}, range: {range:?} }},"
            )?;
        }
        writeln!(f, "];\n")?;
        for (index, axis) in model.axes.iter().enumerate() {
            write_terms(f, "PHYSICAL", index, axis.physical)?;
            write_terms(f, "STOCHASTIC", index, axis.stochastic)?;
        }
        writeln!(f, "static AXES: [AxisModel<'static, f32>; {}] = [", model.axes.len())?;
        for (index, AxisModel { parameters, .. }) in model.axes.iter().enumerate() {
            writeln!(f, "    AxisModel {{")?;
            writeln!(f, "        parameters: {parameters:?},")?;
            writeln!(f, "        physical: &PHYSICAL_{index},")?;
            writeln!(f, "        stochastic: &STOCHASTIC_{index},")?;
            writeln!(f, "    }},")?;
        }
        writeln!(f, "];\n")?;
        writeln!(
            f,
            "/// The fitted model: inputs, terms and scaling of {} axes. The compiler checks it.",
            model.axes.len()
        )?;
        writeln!(f, "pub static MODEL: CheckedModel<'static> = CheckedModel::new(Model {{")?;
        writeln!(f, "    period_s: {:?},", model.period_s)?;
        writeln!(f, "    fitted_on: {:?},", model.fitted_on)?;
        writeln!(f, "    stillness: {:?},", model.stillness)?;
        writeln!(f, "    calibration: {:?},", model.calibration)?;
        let quantities = model.quantities.iter().map(|quantity| format!("Quantity::{quantity:?}"));
        writeln!(f, "    quantities: &[{}],", list(quantities))?;
        writeln!(f, "    inputs: &INPUTS,")?;
        writeln!(f, "    axes: &AXES,")?;
        writeln!(f, "}});")
    }
}

fn write_terms(f: &mut Formatter<'_>, part: &str, axis: usize, terms: &[Term<f32>]) -> fmt::Result {
    writeln!(f, "static {part}_{axis}: [Term<f32>; {}] = [", terms.len())?;
    for term in terms {
        let factors = list(term.factors().iter().map(factor));
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

/// Items separated by commas.
pub(crate) fn list(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(", ")
}
