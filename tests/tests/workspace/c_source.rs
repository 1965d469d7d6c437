//! A model as a C header is C99 without a warning, and has the image and the test vector of the other forms.

use std::path::Path;
use std::process::Command;

use crate::exported_model::model;
use fos_embedded::hub::Hub;
use fos_embedded::test_vector::{Expected, TestVector};
use fos_export::{ExportError, c_source, image, test_vector};

/// The header that an exported one includes.
const FOS_H: &str = include_str!("../../../fos-embedded/include/fos.h");

/// A hub that returns the expected outputs of the test vector: it verifies the comparison of the check, and nothing of
/// the library.
const ECHO: &str = "
#include \"unit.h\"
#include <stdio.h>
#include <stdlib.h>
struct fos_hub { int n; int wrong; };
static int given;
fos_status fos_hub_init(void *memory, size_t size, const fos_scales *scales, fos_hub **out) {
    if (size < sizeof(struct fos_hub) || scales->period_s != 0.005) { return FOS_STATUS_NULL; }
    *out = memory;
    (*out)->n = 0;
    return FOS_STATUS_OK;
}
fos_status fos_hub_load(fos_hub *hub, const uint8_t *image, size_t length) {
    (void)hub;
    return length == UNIT_IMAGE_LENGTH && memcmp(image, \"FOSM\", 4) == 0 ? FOS_STATUS_OK : FOS_STATUS_NULL;
}
fos_status fos_hub_give_application(fos_hub *hub, size_t k, float value) {
    (void)hub;
    given += k == 0 && (value != value || (value > 3.0f && value < 3.6f));
    return FOS_STATUS_OK;
}
fos_status fos_hub_set_motion(fos_hub *hub, fos_motion motion) {
    (void)hub;
    (void)motion;
    return FOS_STATUS_OK;
}
fos_status fos_hub_update(fos_hub *hub, const fos_raw_sample *raw, fos_output *output) {
    int i;
    (void)raw;
    memset(output, 0, sizeof *output);
    for (i = 0; i < 2; i++) {
        const uint32_t *expected = unit_expected[hub->n][i];
        memcpy(&output->corrected[unit_axes[i]], &expected[0], 4);
        memcpy(&output->innovation[unit_axes[i]], &expected[1], 4);
        output->validity[unit_axes[i]] = (uint16_t)expected[2];
    }
    if (++hub->n == hub->wrong) {
        uint32_t bits;
        memcpy(&bits, &output->innovation[FOS_AZ], 4);
        bits ^= 1;
        memcpy(&output->innovation[FOS_AZ], &bits, 4);
    }
    return FOS_STATUS_OK;
}
int main(int argc, char **argv) {
    struct fos_hub memory;
    int first, second, third;
    (void)argc;
    memory.wrong = 0;
    first = unit_check(&memory, sizeof memory);
    memory.wrong = atoi(argv[1]);
    second = unit_check(&memory, sizeof memory);
    third = unit_check(&memory, 1);
    printf(\"%d %d %d %d\", first, second, third, given);
    return 0;
}
";

fn header() -> String {
    c_source(&model(), "unit", "a sensor", "made for a test\nwith a backslash \\").expect("exported")
}

/// Runs the C compiler in `folder`; `None`, with the reason printed, if there is none.
fn cc(folder: &Path, arguments: &[&str]) -> Option<(bool, String)> {
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"];
    match Command::new(&compiler).args(strict).args(arguments).current_dir(folder).output() {
        Ok(output) => Some((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())),
        Err(error) => {
            println!("skipped: {}: {error}", compiler.display());
            None
        }
    }
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("unit.h", header().as_str()), ("fos.h", FOS_H), ("echo.c", ECHO)] {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    folder
}

#[test]
fn the_header_is_c99_without_a_warning() {
    let folder = folder();
    let alone = "#include \"unit.h\"\nint main(void) { return unit_check(NULL, 0); }\n";
    std::fs::write(folder.path().join("alone.c"), alone).expect("writable");
    let Some((compiled, printed)) = cc(folder.path(), &["-fsyntax-only", "alone.c"]) else { return };
    assert!(compiled, "{printed}");

    // a library whose hub is too small is detected at compile time
    let small = FOS_H.replace("FOS_MAX_TERMS 128", "FOS_MAX_TERMS 4");
    std::fs::write(folder.path().join("fos.h"), small).expect("writable");
    let (compiled, printed) = cc(folder.path(), &["-fsyntax-only", "alone.c"]).expect("there a moment ago");
    assert!(!compiled && printed.contains("too large for this library's hub"), "{printed}");
}

#[test]
fn the_check_compares_every_bit() {
    let folder = folder();
    let samples = test_vector(&model()).expect("a hub takes it").vector().samples.len();
    let Some((compiled, printed)) = cc(folder.path(), &["echo.c", "-o", "echo"]) else { return };
    assert!(compiled, "{printed}");
    for wrong in [1, 40, samples] {
        let run = Command::new(folder.path().join("echo")).arg(wrong.to_string()).output().expect("runs");
        let printed = String::from_utf8_lossy(&run.stdout).into_owned();
        // as expected; the sample that differs by one bit; too little memory, by its status; the given samples
        assert_eq!(printed, format!("0 {wrong} -1 {}", samples + wrong), "{wrong}");
    }
}

/// Numbers of a table of the header.
fn table(header: &str, start: &str) -> Vec<i64> {
    let (_, rest) = header.split_once(start).unwrap_or_else(|| panic!("no {start}"));
    let (_, rest) = rest.split_once('{').expect("a table");
    let (body, _) = rest.split_once("};").expect("its end");
    let numbers = body.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).filter(|n| !n.is_empty());
    let number = |text: &str| {
        let text = text.trim_end_matches('u');
        match text.strip_prefix("0x") {
            Some(hex) => i64::from_str_radix(hex, 16),
            None => text.parse(),
        }
    };
    numbers.map(|text| number(text).unwrap_or_else(|error| panic!("{text}: {error}"))).collect()
}

#[test]
fn image_reproduces_its_test_vector() {
    let header = header();
    let bytes: Vec<u8> = table(&header, "uint8_t unit_image[]").into_iter().map(|byte| byte as u8).collect();
    let exported = image(&model(), "a sensor", "made for a test\nwith a backslash \\").expect("exported");
    assert_eq!(bytes, exported);

    let vector = test_vector(&model()).expect("a hub takes it");
    let vector = vector.vector();
    let expected: Vec<Expected> = table(&header, "uint32_t unit_expected[")
        .chunks(3)
        .map(|bits| Expected {
            corrected: bits[0] as u32,
            innovation: bits[1] as u32,
            validity: bits[2] as u16,
        })
        .collect();
    let given: Vec<u32> =
        table(&header, "uint32_t unit_given[").into_iter().map(|bits| bits as u32).collect();
    let mut hub: Hub<16, 128, 256> = Hub::new(vector.scales);
    hub.load(&bytes).expect("takes it");
    assert_eq!(TestVector { expected: &expected, given_bits: &given, ..vector }.run(&mut hub), Ok(()));

    let rows: Vec<Vec<i64>> =
        table(&header, "int16_t unit_samples[").chunks(9).map(<[i64]>::to_vec).collect();
    let samples = vector.samples.iter().map(|sample| {
        let still = i64::from(sample.motion == fos_embedded::hub::Motion::Still);
        let temperature = sample.temperature.map_or(-32_768, i64::from);
        let codes = sample.codes.iter().map(|code| i64::from(*code));
        [i64::from(sample.skipped), still].into_iter().chain(codes).chain([temperature]).collect::<Vec<_>>()
    });
    assert_eq!(rows, samples.collect::<Vec<_>>());
}

#[test]
fn header_describes_the_model() {
    let header = header();
    for words in [
        "// provenance   made for a test",
        "//              with a backslash /",
        "temp_linear",
        "// gyro x: reference 0 rad/s, offset 0.01230 rad/s",
        "//     +6.000000e-1 r(n-1)",
        "#define UNIT_IMAGE_LENGTH",
    ] {
        assert!(header.contains(words), "{words:?} is not in\n{header}");
    }
}

#[test]
fn invalid_c_names_are_rejected_or_converted() {
    for name in ["7th", "", "fos"] {
        assert!(matches!(c_source(&model(), name, "", ""), Err(ExportError::Name(_))), "{name}");
    }
    let header = c_source(&model(), "gyro-unit.v2", "", "").expect("exported");
    assert!(header.contains("static inline int gyro_unit_v2_check(void *memory, size_t size)"), "{header}");
}
