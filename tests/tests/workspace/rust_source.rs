//! A model as Rust source compiles, equals the model of its image to the last bit, and has a test vector that detects a
//! difference.

use std::process::Command;

use crate::exported_model::model;
use fos_core::{Axis, Image, Model, Predictor, Sample};
use fos_embedded::hub::HubError;
use fos_embedded::test_vector::{CheckError, TestVector};
use fos_export::{image, rust_source};

#[allow(unreachable_pub, reason = "exported to be used from anywhere in a firmware")]
mod exported {
    include!("../../golden/model.rs");
}

#[test]
fn the_source_is_the_golden_one() {
    let source = rust_source(&model(), "host-fit, a model for tests");
    let golden = include_str!("../../golden/model.rs");
    if source != golden {
        let path = std::env::temp_dir().join("model.rs");
        std::fs::write(&path, &source).expect("the temporary folder is writable");
        panic!("the exported source has changed; if that is meant, copy {} to tests/golden", path.display());
    }
}

#[test]
fn source_and_image_are_the_same_model_to_the_last_bit() {
    type Device = Predictor<f32, 2, 16, 32, 64>;
    let bytes = image(&model(), "", "").expect("exported");
    let mut stored: Device = Image::parse(&bytes).expect("its own image").predictor().expect("fits");
    let mut compiled = Device::new(exported::MODEL.model()).expect("fits");
    for n in 0..5000_u32 {
        let noise = f32::from((n.wrapping_mul(40_503) >> 7) as u8) * 1e-5;
        let az = 9.85 - noise;
        let sample =
            Sample { measured: &[0.012 + noise, az], quantities: &[24.0 + 0.001 * n as f32, 3.28, az] };
        let (a, b) = match n % 1000 {
            0..800 => (stored.track(&sample).to_vec(), compiled.track(&sample).to_vec()),
            _ => (stored.coast(&sample).to_vec(), compiled.coast(&sample).to_vec()),
        };
        assert_eq!(a, b, "{n}");
    }
}

/// Result of `check` for a model other than the exported one.
fn check(model: &Model<'_, f32>, vector: &TestVector<'_>) -> Result<(), usize> {
    let mut hub = exported::ModelHub::new(vector.scales);
    hub.load_model(model).expect("as large as the exported one");
    vector.run(&mut hub)
}

#[test]
fn a_coefficient_changed_in_its_last_bit_is_noticed() {
    let mut unnoticed = Vec::new();
    for (axis, exact) in exported::MODEL.model().axes.iter().enumerate() {
        for (term, _) in exact.physical.iter().chain(exact.stochastic).enumerate() {
            let (mut physical, mut stochastic) = (exact.physical.to_vec(), exact.stochastic.to_vec());
            let changed = physical.iter_mut().chain(&mut stochastic).nth(term).expect("this term");
            *changed = changed.with_coefficient(changed.coefficient.next_up());
            let mut axes = exported::MODEL.model().axes.to_vec();
            (axes[axis].physical, axes[axis].stochastic) = (&physical, &stochastic);
            let model = Model { axes: &axes, ..*exported::MODEL.model() };
            if check(&model, &exported::TEST_VECTOR).is_ok() {
                unnoticed.push((axis, term));
            }
        }
    }
    // a term of 1e-7 among others of 1: its last bit is rounded away for any samples, as the comment states
    println!("not noticed: {unnoticed:?}");
    assert!(unnoticed.len() <= 4, "{unnoticed:?}");
    assert!(!unnoticed.contains(&(0, 0)) && !unnoticed.contains(&(1, 0)), "{unnoticed:?}");
}

#[test]
fn a_changed_or_missing_expectation_is_a_deviation() {
    let vector = exported::TEST_VECTOR;
    let mut expected = vector.expected.to_vec();
    let row = 40;
    expected[row * vector.channels.len() + 1].validity ^= 1 << 9;
    assert_eq!(check(exported::MODEL.model(), &TestVector { expected: &expected, ..vector }), Err(row));
    let short = &vector.expected[..vector.expected.len() - 1];
    let last = vector.samples.len() - 1;
    assert_eq!(check(exported::MODEL.model(), &TestVector { expected: short, ..vector }), Err(last));
}

#[test]
fn a_model_for_another_sensor_does_not_pass_the_check() {
    let vector = exported::TEST_VECTOR;
    let mut hub = exported::ModelHub::new(vector.scales);
    let faster = Model { period_s: 0.5 * exported::MODEL.model().period_s, ..*exported::MODEL.model() };
    let refused = hub.load_model(&faster).map_err(CheckError::from);
    assert!(matches!(refused, Err(CheckError::Load(HubError::Period { .. }))), "{refused:?}");
    assert_eq!(vector.run(&mut hub), Err(0), "without a model");
}

#[test]
fn hub_reports_excess_noise() {
    let vector = exported::TEST_VECTOR;
    let mut hub = exported::ModelHub::new(vector.scales);
    assert_eq!(hub.deviation_ratio(Axis::Gx), None, "without a model");
    hub.load_checked(&exported::MODEL).expect("the exported one");
    let ratio = |hub: &exported::ModelHub, axis| hub.deviation_ratio(axis).map(f64::from);
    // the monitor's variance starts at that of the fit; micromath is off by 6 %
    let as_fitted = ratio(&hub, Axis::Gx).expect("modelled");
    assert!((as_fitted - 1.0).abs() < 0.061, "{as_fitted}");
    assert_eq!(vector.run(&mut hub), Ok(()));
    // remainders drawn evenly from their range vary more than the noise of the fit
    let grown = ratio(&hub, Axis::Gx).expect("modelled");
    assert!(grown > as_fitted && grown < 3.0, "{grown}");
    assert_eq!(hub.deviation_ratio(Axis::Ay), None, "no model of this axis");
}

/// Compiles `source` against fos-core, built like this test; returns the message of the compiler if it fails.
fn compile(source: &str) -> Option<Result<(), String>> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("model.rs");
    std::fs::write(&file, source).expect("writable");
    let libraries = std::env::current_exe().ok()?.parent()?.to_owned();
    let mut candidates: Vec<_> = std::fs::read_dir(&libraries)
        .ok()?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("libfos_core-") && name.ends_with(".rlib")
        })
        .collect();
    // there may be libraries of other builds; that of this test is the latest
    candidates.sort_by_key(|path| std::cmp::Reverse(path.metadata().and_then(|file| file.modified()).ok()));
    let library = candidates.first()?;
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata", "--out-dir"])
        .arg(folder.path())
        .arg("-L")
        .arg(format!("dependency={}", libraries.display()))
        .arg("--extern")
        .arg(format!("fos_core={}", library.display()))
        .arg(&file)
        .output()
        .ok()?;
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    Some(if output.status.success() { Ok(()) } else { Err(stderr) })
}

#[test]
fn source_with_an_output_at_lag_zero_does_not_compile() {
    let source = include_str!("../../golden/model.rs");
    let (model, _) = source.split_once("// From here on").expect("the part that needs fos-core only");
    match compile(model) {
        Some(Ok(())) => {}
        Some(Err(stderr)) => {
            println!("skipped: the unchanged source does not compile outside of cargo: {stderr}");
            return;
        }
        None => {
            println!("skipped: no rustc, or no library of fos-core beside this test");
            return;
        }
    }
    let wrong = model.replacen("&[y(1)]", "&[y(0)]", 1);
    assert_ne!(wrong, model);
    let stderr = compile(&wrong).expect("compiled a moment ago").expect_err("an output at lag 0");
    assert!(stderr.contains("no output at lag 0"), "{stderr}");
}
