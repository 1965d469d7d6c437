//! The C interface gives the output of the hub bit for bit under every fault, so both share a column of the table.

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use fos_embedded::c_api::*;
use fos_embedded::hub::Hub;

use super::correctors::{POLL, raw};
use super::faults::{FAULTS, Strikes, clean};
use super::places::image;
use super::{FROM, SEED, TICKS};
use crate::models::{SCALES, TestHub};

#[test]
fn output_in_c_equals_the_hub_under_every_fault() {
    let clean = clean(TICKS, SEED);
    let (image, mut samples) = (image(), 0);
    for fault in &FAULTS {
        let scales = fos_scales {
            accel_mps2: SCALES.accel_mps2,
            gyro_rads: SCALES.gyro_rads,
            temperature_k: SCALES.temperature_k,
            temperature_zero_c: SCALES.temperature_zero_c,
            period_s: SCALES.period_s,
            values: FOS_VALUES_RAW,
        };
        let mut memory = vec![0_u64; FOS_HUB_BYTES / 8];
        let mut in_c = null_mut();
        // SAFETY: memory and image have the stated lengths
        unsafe {
            let status = fos_hub_init(memory.as_mut_ptr().cast(), FOS_HUB_BYTES, &scales, &mut in_c);
            assert_eq!(status, fos_status::Ok);
            assert_eq!(fos_hub_load(in_c, image.as_ptr(), image.len()), fos_status::Ok);
        }
        let mut hub: TestHub = Hub::new(SCALES);
        hub.load(&image).expect("a model");
        for tick in fault.into(&clean, FROM, Strikes::All) {
            let (raw, supply) = (raw(&tick), tick.supply);
            let sample = fos_raw_sample {
                skipped: raw.skipped,
                accel: raw.accel,
                gyro: raw.gyro,
                temperature: raw.temperature.unwrap_or(0),
                faults: raw.faults.bits(),
                has_temperature: u8::from(raw.temperature.is_some()),
            };
            if tick.reset {
                hub.load(&image).expect("as before");
                // SAFETY: as above
                let status = unsafe { fos_hub_load(in_c, image.as_ptr(), image.len()) };
                assert_eq!(status, fos_status::Ok);
            }
            let mut output = MaybeUninit::<fos_output>::uninit();
            hub.give(fos_core::Quantity::Supply, supply);
            let expected = *hub.update(&raw);
            // SAFETY: a hub, and places of the right types
            let output = unsafe {
                assert_eq!(fos_hub_give(in_c, FOS_QUANTITY_SUPPLY_V, supply), fos_status::Ok);
                assert_eq!(fos_hub_update(in_c, &sample, output.as_mut_ptr()), fos_status::Ok);
                output.assume_init()
            };
            if tick.index % POLL == POLL - 1 {
                hub.clock(tick.clock_us);
                // SAFETY: a hub
                assert_eq!(unsafe { fos_hub_clock(in_c, tick.clock_us) }, fos_status::Ok);
            }
            let bits = |values: [f32; 6]| values.map(f32::to_bits);
            let place = (fault.name, tick.index);
            assert_eq!(bits(output.measured), bits(expected.measured), "{place:?}");
            assert_eq!(output.temperature_c.to_bits(), expected.temperature_c.to_bits(), "{place:?}");
            assert_eq!(bits(output.corrected), bits(expected.corrected()), "{place:?}");
            assert_eq!(bits(output.innovation), bits(expected.innovation()), "{place:?}");
            assert_eq!(output.validity, expected.validity().map(|validity| validity.bits()), "{place:?}");
            assert_eq!((output.tick, output.faults), (expected.tick, expected.faults.bits()), "{place:?}");
            assert_eq!((output.still, output.drift), (u8::from(expected.still), u8::from(expected.drift)));
            samples += 1;
        }
    }
    println!("C interface: {} faults, {samples} samples, identical to the hub bit for bit", FAULTS.len());
}
