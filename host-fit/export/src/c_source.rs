//! The model as a C header: its image, a description of its content, and a check through the C interface, fos.h.

use std::fmt::{self, Display, Formatter};

use fos_core::{FittedOn, Image};
use fos_embedded::hub::{AXES, Motion};
use fos_embedded::raw::Scales;
use fos_embedded::test_vector::{Expected, TestSample};

use super::refusal::room_in_c;
use super::test_vector::{self, OwnedTestVector, Room, test_vector};
use super::{ExportError, Refusal, UnusableImage, description, image};
use fos_data::escaping::c_comment;
use fos_data::visible::visible;
use fos_fit::model::UnitModel;

/// C99 source of a header. All its identifiers begin with `name`, such as the stem of its file; characters that C does not allow become
/// underscores.
///
/// # Errors
///
/// The model has no image, the hub behind fos.h refuses it, or the name is unusable in C.
pub fn c_source(
    model: &UnitModel,
    name: &str,
    sensor: &str,
    provenance: &str,
) -> Result<String, ExportError> {
    let image = image(model, sensor, provenance)?;
    if let Some(refusal) = Refusal::of(model) {
        return Err(ExportError::Refused(refusal));
    }
    let vector = test_vector(model).map_err(|error| ExportError::Refused(Refusal::hub(error, model)))?;
    let name = c_name(name)?;
    let parsed = Image::parse(&image).map_err(UnusableImage)?;
    let words = description(&parsed);
    Ok(Header { name: &name, image: &image, words: &words, model, vector: &vector }.to_string())
}

fn c_name(name: &str) -> Result<String, ExportError> {
    // This header includes fos.h.
    if !name.starts_with(|first: char| first.is_ascii_alphabetic()) || name.eq_ignore_ascii_case("fos") {
        return Err(ExportError::Name(name.to_owned()));
    }
    Ok(name.replace(|c: char| !c.is_ascii_alphanumeric(), "_"))
}

struct Header<'a> {
    name: &'a str,
    image: &'a [u8],
    words: &'a str,
    model: &'a UnitModel,
    vector: &'a OwnedTestVector,
}

impl Display for Header<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let name = self.name;
        let upper = name.to_ascii_uppercase();
        writeln!(f, "// A model of the error of an inertial sensor, for fos_hub_load().")?;
        writeln!(f, "//")?;
        c_comment(f, self.words)?;
        writeln!(f, "\n#ifndef {upper}_H\n#define {upper}_H\n")?;
        writeln!(f, "#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n")?;
        writeln!(f, "#include \"fos.h\"\n")?;
        let Room { inputs, terms, history } = room_in_c(self.model, self.vector.vector().scales);
        writeln!(
            f,
            "#if FOS_MAX_INPUTS < {inputs} || FOS_MAX_TERMS < {terms} || FOS_MAX_HISTORY < {history}"
        )?;
        writeln!(f, "#error \"the model is too large for this library's hub\"")?;
        writeln!(f, "#endif\n")?;
        self.write_image(f)?;
        self.write_tables(f)?;
        self.write_check(f)?;
        writeln!(f, "\n#endif // {upper}_H")
    }
}

impl Header<'_> {
    fn write_image(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, upper) = (self.name, self.name.to_ascii_uppercase());
        writeln!(
            f,
            "// The model image. It may lie anywhere; aligned so that a flash driver can copy it by words."
        )?;
        writeln!(f, "#if defined(__GNUC__)")?;
        writeln!(f, "__attribute__((aligned(4)))")?;
        writeln!(f, "#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L")?;
        writeln!(f, "_Alignas(4)")?;
        writeln!(f, "#endif")?;
        writeln!(f, "static const uint8_t {name}_image[] = {{")?;
        for row in self.image.chunks(16) {
            let bytes: Vec<String> = row.iter().map(|byte| format!("0x{byte:02x},")).collect();
            writeln!(f, "    {}", bytes.join(" "))?;
        }
        writeln!(f, "}};\n")?;
        writeln!(f, "// Bytes of the image.")?;
        writeln!(f, "#define {upper}_IMAGE_LENGTH {}u\n", self.image.len())
    }

    fn write_tables(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, upper) = (self.name, self.name.to_ascii_uppercase());
        let vector = self.vector.vector();
        c_comment(f, &test_vector::comment(self.vector, self.model))?;
        writeln!(f, "#define {upper}_SAMPLES {}\n", vector.samples.len())?;
        writeln!(
            f,
            "// Missing before it; 1 at rest; codes of accelerometer x, y, z, gyro x, y, z; code of the thermometer,"
        )?;
        writeln!(f, "// -32768 where it is not valid.")?;
        writeln!(f, "static const int16_t {name}_samples[{upper}_SAMPLES][9] = {{")?;
        for TestSample { motion, skipped, codes, temperature } in vector.samples {
            let still = i16::from(*motion == Motion::Still);
            let codes = codes.map(|code| code.to_string()).join(", ");
            // i16::MIN is written as -32768, which has a wider type in C and is converted back.
            writeln!(f, "    {{{skipped}, {still}, {codes}, {}}},", temperature.unwrap_or(i16::MIN))?;
        }
        writeln!(f, "}};\n")?;

        if !vector.given.is_empty() {
            let names = vector.given.iter().map(|index| &*self.model.quantities[usize::from(*index)].column);
            let names: Vec<&str> = names.collect();
            c_comment(f, &visible(&format!("Given before it, bits of float: {}.", names.join(", "))))?;
            writeln!(f, "static const uint32_t {name}_given[{upper}_SAMPLES][{}] = {{", vector.given.len())?;
            for row in vector.given_bits.chunks(vector.given.len()) {
                writeln!(f, "    {{{}}},", row.iter().map(hex).collect::<Vec<_>>().join(", "))?;
            }
            writeln!(f, "}};\n")?;
        }

        writeln!(
            f,
            "// What must come of it, for each axis of the model: bits of the corrected value, bits of the"
        )?;
        writeln!(f, "// innovation (0x7fc00000 where there is none), validity.")?;
        let n_axes = vector.channels.len();
        writeln!(f, "static const uint32_t {name}_expected[{upper}_SAMPLES][{n_axes}][3] = {{")?;
        for row in vector.expected.chunks(n_axes.max(1)) {
            let axis = |&Expected { corrected, innovation, validity }: &Expected| {
                format!("{{{}, {}, {validity:#05x}u}}", hex(&corrected), hex(&innovation))
            };
            writeln!(f, "    {{{}}},", row.iter().map(axis).collect::<Vec<_>>().join(", "))?;
        }
        writeln!(f, "}};\n")?;
        let channels = vector.channels.iter().map(|channel| CHANNELS[usize::from(*channel) % AXES]);
        writeln!(f, "// Those axes.")?;
        writeln!(
            f,
            "static const uint8_t {name}_axes[{n_axes}] = {{{}}};\n",
            channels.collect::<Vec<_>>().join(", ")
        )
    }

    fn write_check(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, upper) = (self.name, self.name.to_ascii_uppercase());
        let vector = self.vector.vector();
        let Scales { accel_mps2, gyro_rads, temperature_k, temperature_zero_c, period_s, values } =
            vector.scales;
        let values = match values {
            FittedOn::Raw => "FOS_VALUES_RAW",
            FittedOn::FactoryCorrected => "FOS_VALUES_FACTORY_CORRECTED",
        };
        let (n_given, n_axes) = (vector.given.len(), vector.channels.len());
        write!(
            f,
            "// Runs the test vector through a hub in `memory`, as fos_hub_init() takes it: at start-up, before the model is
// trusted. The memory is free afterwards.
//
// - 0: every bit is as expected.
// - n > 0: the n-th sample, from 1, is the first of which one bit is not.
// - below 0: the hub did not take the memory or the model; the fos_status, negated.
static inline int {name}_check(void *memory, size_t size) {{
    fos_scales scales;
    fos_hub *hub = NULL;
    fos_status status;
    int n;
    size_t i;

    memset(&scales, 0, sizeof scales);
    scales.accel_mps2 = {accel_mps2:?}f;
    scales.gyro_rads = {gyro_rads:?}f;
    scales.temperature_k = {temperature_k:?}f;
    scales.temperature_zero_c = {temperature_zero_c:?}f;
    scales.period_s = {period_s:?};
    scales.values = {values};
    status = fos_hub_init(memory, size, &scales, &hub);
    if (status == FOS_STATUS_OK) {{
        status = fos_hub_load(hub, {name}_image, sizeof {name}_image);
    }}
    if (status != FOS_STATUS_OK) {{
        return -(int)status;
    }}
    for (n = 0; n < {upper}_SAMPLES; n++) {{
        const int16_t *sample = {name}_samples[n];
        fos_raw_sample raw;
        fos_output output;

        memset(&raw, 0, sizeof raw);
        raw.skipped = (uint32_t)sample[0];
        for (i = 0; i < 3; i++) {{
            raw.accel[i] = sample[2 + i];
            raw.gyro[i] = sample[5 + i];
        }}
        raw.temperature = sample[8];
        raw.has_temperature = sample[8] != INT16_MIN;
"
        )?;
        if n_given > 0 {
            write!(
                f,
                "        for (i = 0; i < {n_given}; i++) {{
            float value;
            memcpy(&value, &{name}_given[n][i], sizeof value);
            (void)fos_hub_give_application(hub, i, value);
        }}
"
            )?;
        }
        write!(
            f,
            "        (void)fos_hub_set_motion(hub, sample[1] ? FOS_MOTION_STILL : FOS_MOTION_MOVING);
        (void)fos_hub_update(hub, &raw, &output);
        for (i = 0; i < {n_axes}; i++) {{
            const uint32_t *expected = {name}_expected[n][i];
            const size_t axis = {name}_axes[i];

            if (memcmp(&output.corrected[axis], &expected[0], 4) != 0 ||
                memcmp(&output.innovation[axis], &expected[1], 4) != 0 ||
                output.validity[axis] != expected[2]) {{
                return n + 1;
            }}
        }}
    }}
    return 0;
}}
"
        )
    }
}

/// Names of the hub's axes in fos.h.
const CHANNELS: [&str; AXES] = ["FOS_AX", "FOS_AY", "FOS_AZ", "FOS_GX", "FOS_GY", "FOS_GZ"];

fn hex(bits: &u32) -> String {
    format!("{bits:#010x}u")
}
