//! Converts a recording into the raw samples that a hub reads: `fos_embedded::test_log`.

use fos_core::Image;
use fos_data::column::ACCELEROMETERS;
use fos_data::column::GYROS;
use fos_embedded::hub::{Hub, Motion, is_given};
use fos_embedded::raw::{RawSample, Scales};
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord};

use super::replay::ReplayError;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use fos_fit::export::model_of;
use fos_fit::playback::Playback;
use fos_fit::signal::quantisation::quantisation;

/// A hub that holds every model of the host.
type HostHub = Hub<32, 512, 4096>;

/// Codes used for the largest value if the log does not show the sensor's own steps; those up to 32767 are a margin.
const CODES: f64 = 32_000.0;

/// Size of a temperature code, K; code 0 is 25 °C, as in the LSM6DSV16X.
const TEMPERATURE_K: f64 = 1.0 / 256.0;
const TEMPERATURE_ZERO_C: f64 = 25.0;

/// Samples per read of the application's clock: 50 ms at 200 Hz.
const SAMPLES_A_BATCH: usize = 10;

/// A log of raw codes, and the digest of a hub over it.
#[derive(Debug, Clone)]
pub struct HubLog {
    /// Content of the file: `fos_embedded::test_log`.
    pub bytes: Vec<u8>,
    /// Digest of the outputs of a hub in f32, the same on every machine.
    pub outputs: u64,
}

/// Converts the recording into the samples of a hub, with the scale of their codes, and runs the image `stored` over them. Codes are
/// the steps of the sensor's converter if the log shows them; missing columns are 0, but those of the model are required: `axes` as in
/// [`replay`](crate::replay::replay). A row with an empty cell on an axis is a tick without a sample. If the image has limits of stillness,
/// the hub's own detector decides, otherwise `stillness`.
pub fn hub_log(
    stored: &[u8],
    axes: &[String],
    recording: &Recording,
    stillness: &Stillness,
) -> Result<HubLog, ReplayError> {
    let image = Image::parse(stored)?;
    let model = &model_of(&image, axes)?;
    let playback = Playback::new(recording, model, &stillness.still)?;
    let column = |name: &str| recording.channel(name).map(|channel| channel.values.as_slice()).unwrap_or(&[]);
    let (accel, gyro) = (ACCELEROMETERS.map(column), GYROS.map(column));
    let given = model.quantities.iter().filter(|logged| is_given(logged.quantity));
    let held = |name: &str| recording.channel(name).map(|channel| recording.held(channel));
    let given = given.map(|logged| held(&logged.column)).collect::<Result<Vec<_>, RecordingError>>()?;
    let temperature = held("temp_c").unwrap_or_default();

    let scales = Scales {
        accel_mps2: code(&accel) as f32,
        gyro_rads: code(&gyro) as f32,
        temperature_k: TEMPERATURE_K as f32,
        temperature_zero_c: TEMPERATURE_ZERO_C as f32,
        period_s: recording.rate.period_s,
        values: image.fitted_on(),
    };
    let header = HubLogHeader { scales, n_given: given.len() as u8 };
    let mut bytes = Vec::with_capacity(recording.n_rows() * header.record_length());
    bytes.extend(header.encode());
    let (mut hub, mut digest) = (HostHub::new(scales), HubDigest::default());
    hub.load(stored)?;
    let codes = |columns: [&[f64]; 3], row: usize, scale: f32| {
        columns.map(|column| column.get(row).map_or(0, |value| (value / f64::from(scale)).round() as i16))
    };
    let mut skipped = 0_u32;
    for row in 0..recording.n_rows() {
        skipped = skipped.saturating_add(playback.missing_before(row));
        if accel.iter().chain(&gyro).any(|column| column.get(row).is_some_and(|value| value.is_nan())) {
            skipped = skipped.saturating_add(1);
            continue;
        }
        let celsius = temperature.get(row).copied().filter(|celsius| celsius.is_finite());
        let raw = RawSample {
            skipped: core::mem::take(&mut skipped),
            accel: codes(accel, row, scales.accel_mps2),
            gyro: codes(gyro, row, scales.gyro_rads),
            temperature: celsius
                .map(|celsius| ((celsius - TEMPERATURE_ZERO_C) / TEMPERATURE_K).round() as i16),
            ..RawSample::default()
        };
        let motion = match (image.stillness(), playback.is_still(row)) {
            (Some(_), _) => None,
            (None, true) => Some(Motion::Still),
            (None, false) => Some(Motion::Moving),
        };
        let looks = (row + 1).is_multiple_of(SAMPLES_A_BATCH);
        let clock_us = if looks { (recording.time_s[row] * 1e6).max(0.0) as u64 + 1 } else { 0 };
        let values: Vec<f32> = given.iter().map(|column| column[row] as f32).collect();
        let record = HubLogRecord { raw, motion, clock_us, given: &values };
        digest.update(record.step(&mut hub));
        bytes.extend(record.encode());
    }
    Ok(HubLog { bytes, outputs: digest.outputs() })
}

/// Value of one code: the step of the converter if the columns show it and 16 bits suffice for their range.
fn code(columns: &[&[f64]; 3]) -> f64 {
    let values = || columns.iter().copied().flatten().copied().filter(|value| value.is_finite());
    let largest = values().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let steps = columns.iter().filter_map(|column| quantisation(&[column]).map(|found| found.step));
    let step = steps.fold(f64::INFINITY, f64::min);
    if largest / step <= CODES && step.is_finite() {
        step
    } else if largest > 0.0 {
        largest / CODES
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_equals_converter_step_if_visible() {
        let coarse: Vec<f64> = (0..1000).map(|n| f64::from(n * 7 % 11) * 0.25).collect();
        let none: Vec<f64> = (0..1000).map(|n| f64::from(n).sin()).collect();
        assert!((code(&[&coarse, &coarse, &[]]) - 0.25).abs() < 1e-12);
        let largest = none.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        assert_eq!(code(&[&none, &[], &[]]), largest / CODES);
        assert_eq!(code(&[&[], &[], &[]]), 1.0);
    }
}
