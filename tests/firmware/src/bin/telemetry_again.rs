//! Replays the measurements of a telemetry stream in a hub on the host, and compares innovations and validity bit by
//! bit.
//!
//! ```text
//! telemetry_again IMAGE TELEMETRY FULL-SCALE-ACCEL FULL-SCALE-GYRO PERIOD-S
//! ```
//!
//! For telemetry of a hub that had the model from its first sample on and whose values have the factory's correction: a
//! phone's. Full scales are in m/s² and rad/s. Prints the number of samples; fails at the first that differs.

use std::error::Error;
use std::fs;

use fos_core::FittedOn;
use fos_embedded::hub::CHub;
use fos_embedded::raw::{Faults, Scales, SiSample};
use fos_embedded::telemetry::{Frame, SampleFrame, decode};

type Sent = SampleFrame<Vec<f32>, Vec<u16>>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, image, telemetry, accel, gyro, period] = &arguments[..] else {
        println!("usage: telemetry_again IMAGE TELEMETRY FULL-SCALE-ACCEL FULL-SCALE-GYRO PERIOD-S");
        std::process::exit(2);
    };
    let scales =
        Scales::of_full_scale(accel.parse()?, gyro.parse()?, period.parse()?, FittedOn::FactoryCorrected);
    let mut hub = CHub::new(scales);
    hub.load(&fs::read(image)?)?;
    let (mut last, mut samples) = (None, 0_u32);
    for frame in fs::read(telemetry)?.split_mut(|byte| *byte == 0).filter(|frame| !frame.is_empty()) {
        let Frame::Sample(sent) = decode::<Frame<&str, Vec<f32>, Vec<u16>>>(frame)? else { continue };
        let own = again(&mut hub, &sent, last)?;
        last = Some(sent.tick);
        samples += 1;
        if own != bits(sent.still, &sent.innovations, &sent.validity) {
            return Err(
                format!("tick {}: sent {sent:?}, the hub here makes {:?}", sent.tick, hub.output()).into()
            );
        }
    }
    if samples == 0 {
        return Err("there is no sample".into());
    }
    println!("samples {samples}");
    Ok(())
}

/// Response of the hub to a measurement.
fn again(hub: &mut CHub, sent: &Sent, last: Option<u32>) -> Result<Vec<u8>, Box<dyn Error>> {
    let [ax, ay, az, gx, gy, gz] = sent.measured[..] else { return Err("not six axes".into()) };
    let skipped = match last {
        Some(last) => sent.tick.wrapping_sub(last).wrapping_sub(1),
        None => sent.tick,
    };
    let temperature_c = sent.quantities.first().copied().unwrap_or(f32::NAN);
    let faults = if skipped > 0 { Faults::GAP } else { Faults::empty() };
    let sample = SiSample { skipped, accel: [ax, ay, az], gyro: [gx, gy, gz], temperature_c, faults };
    let output = hub.update_si(&sample);
    Ok(bits(output.still, &output.innovation(), &output.validity().map(|validity| validity.bits())))
}

fn bits(still: bool, innovations: &[f32], validity: &[u16]) -> Vec<u8> {
    let mut bits = vec![u8::from(still)];
    // NaN has many forms: only its presence counts
    bits.extend(innovations.iter().flat_map(|value| {
        if value.is_nan() { f32::NAN.to_bits().to_le_bytes() } else { value.to_le_bytes() }
    }));
    bits.extend(validity.iter().flat_map(|each| each.to_le_bytes()));
    bits
}
