//! All functions of the C interface, in any order, with valid, NULL, misaligned and impossible arguments. Memory is
//! allocated to the byte, so that the address sanitizer detects any access beyond it.
#![no_main]

use core::ffi::CStr;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use fos_embedded::c_api::*;
use fos_fuzz::{C_SCALES, sealed_image, split};
use libfuzzer_sys::fuzz_target;

/// Numbers read from the input; zeros after its end.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut taken = [0; N];
        let length = N.min(self.0.len());
        taken[..length].copy_from_slice(&self.0[..length]);
        self.0 = &self.0[length..];
        taken
    }

    fn byte(&mut self) -> u8 {
        self.bytes::<1>()[0]
    }

    fn float(&mut self) -> f32 {
        f32::from_le_bytes(self.bytes())
    }

    /// Mostly `good`; otherwise NULL, or for aligned types misaligned by a byte.
    fn pointer<T>(&mut self, good: *mut T) -> *mut T {
        match self.byte() {
            0 => null_mut(),
            1 => good.wrapping_byte_add(1),
            _ => good,
        }
    }

    fn is_there<T>(pointer: *const T) -> bool {
        !pointer.is_null() && pointer.is_aligned()
    }
}

/// Expected status of a call for a pointer; none if it is valid.
fn wrong_with<T>(pointer: *const T) -> Option<fos_status> {
    match pointer {
        _ if pointer.is_null() => Some(fos_status::Null),
        _ if pointer.is_aligned() => None,
        _ => Some(fos_status::Misaligned),
    }
}

/// Invalid pointers are reported, unless another error is, and valid ones are not.
fn hold(status: fos_status, pointers: &[Option<fos_status>], also_wrong: &[fos_status]) {
    let bad: Vec<fos_status> = pointers.iter().copied().flatten().collect();
    if bad.is_empty() {
        assert!(!matches!(status, fos_status::Null | fos_status::Misaligned), "{status:?}");
    } else {
        assert!(bad.contains(&status) || also_wrong.contains(&status), "{status:?}, wrong are {bad:?}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    let (information, rest) = split(bytes);
    let (body, rest) = split(rest);
    let images = [sealed_image(body, information), body.to_vec()];
    let mut numbers = Numbers(rest);
    let mut memory = vec![MaybeUninit::<u64>::uninit(); fos_hub_size().div_ceil(8)];
    let mut scales = C_SCALES;
    let mut hub = null_mut();
    // SAFETY: the memory has the stated size.
    let made = unsafe { fos_hub_init(memory.as_mut_ptr().cast(), 8 * memory.len(), &scales, &mut hub) };
    assert_eq!(made, fos_status::Ok);
    let mut streams_memory = vec![MaybeUninit::<u64>::uninit(); fos_streams_size().div_ceil(8)];
    let periods = fos_stream_periods { gyro_ns: 5_000_000, accel_ns: 10_000_000, temperature_ns: 1_000_000_000 };
    let (size, mut streams) = (8 * streams_memory.len(), null_mut());
    // SAFETY: the memory has the stated size.
    let made = unsafe { fos_streams_init(streams_memory.as_mut_ptr().cast(), size, &periods, &mut streams) };
    assert_eq!(made, fos_status::Ok);
    while !numbers.0.is_empty() {
        // SAFETY: pointers that are neither NULL nor misaligned lead to memory of the stated size; a hub is
        // only used after a successful fos_hub_init, and so are streams.
        unsafe {
            if numbers.0[0] >= 192 {
                numbers.byte();
                call_streams(&mut numbers, hub, streams);
            } else {
                call(&mut numbers, &mut memory, &mut scales, hub, &images);
            }
        }
    }
});

/// # Safety
///
/// `hub` is a hub, `good` are streams.
unsafe fn call_streams(numbers: &mut Numbers<'_>, hub: *mut fos_hub, good: *mut fos_streams) {
    let streams = numbers.pointer(good);
    let stamp_ns = match numbers.byte() {
        0 => i64::from_le_bytes(numbers.bytes()),
        n => i64::from(n) * 1_000_000 + i64::from(u16::from_le_bytes(numbers.bytes())) * 100_000_000,
    };
    let value = Box::new([numbers.float(), numbers.float(), numbers.float()]);
    let place = numbers.pointer(value.as_ptr().cast_mut());
    let hold_taken = |status: fos_status| {
        hold(status, &[wrong_with(streams), wrong_with(place)], &[]);
        assert!(status != fos_status::Ok || value.iter().all(|value| value.is_finite()));
    };
    // SAFETY: promised by the caller.
    unsafe {
        match numbers.byte() % 4 {
            0 => hold_taken(fos_streams_gyro(streams, stamp_ns, place)),
            1 => hold_taken(fos_streams_accel(streams, stamp_ns, place)),
            2 => hold(fos_streams_temperature(streams, stamp_ns, value[0]), &[wrong_with(streams)], &[]),
            _ => {
                let [gyro_ns, accel_ns, temperature_ns] = [numbers.bytes(), numbers.bytes(), numbers.bytes()]
                    .map(|bytes: [u8; 4]| u64::from(u32::from_le_bytes(bytes)));
                let periods = fos_stream_periods { gyro_ns, accel_ns, temperature_ns };
                let status = fos_streams_set_periods(streams, &periods);
                hold(status, &[wrong_with(streams)], &[fos_status::Argument]);
            }
        }
        let (mut sample, mut stamp_ns) = (MaybeUninit::<fos_si_sample>::uninit(), 0);
        let next = if numbers.byte() < 16 { fos_streams_flush } else { fos_streams_next };
        while next(streams, sample.as_mut_ptr(), &mut stamp_ns) == fos_status::Ok {
            let mut si = MaybeUninit::<fos_si_output>::uninit();
            assert_eq!(fos_hub_update_si(hub, sample.as_ptr(), si.as_mut_ptr()), fos_status::Ok);
            let si = si.assume_init();
            for axis in 0..FOS_AXES {
                let output = &si.output;
                assert!(output.corrected[axis].is_finite() || output.validity[axis] != FOS_VALIDITY_VALID);
            }
        }
    }
}

/// # Safety
///
/// `hub` is a hub in `memory`.
unsafe fn call(
    numbers: &mut Numbers<'_>,
    memory: &mut [MaybeUninit<u64>],
    scales: &mut fos_scales,
    good: *mut fos_hub,
    images: &[Vec<u8>; 2],
) {
    let which = numbers.byte() % 16;
    let hub = numbers.pointer(good);
    // SAFETY: promised by the caller.
    unsafe {
        match which {
            0 => {
                let mut made = null_mut();
                let size = if numbers.byte() > 200 { usize::from(numbers.byte()) } else { 8 * memory.len() };
                let place = numbers.pointer(memory.as_mut_ptr()).cast();
                let out = numbers.pointer(&raw mut made);
                let scales = numbers.pointer(scales);
                let status = fos_hub_init(place, size, scales, out);
                let pointers = [wrong_with(place.cast::<u64>()), wrong_with(scales), wrong_with(out)];
                hold(status, &pointers, &[fos_status::NoRoom, fos_status::Argument]);
                assert!(!Numbers::is_there(out) || made.is_null() == (status != fos_status::Ok));
            }
            1 => {
                scales.accel_mps2 = numbers.float();
                scales.gyro_rads = numbers.float();
                scales.temperature_k = numbers.float();
                scales.temperature_zero_c = numbers.float();
                scales.period_s = f64::from_le_bytes(numbers.bytes());
                scales.values = numbers.byte();
            }
            2 => {
                let image = &images[usize::from(numbers.byte() & 1)];
                let length = if numbers.byte() == 0 { usize::MAX } else { image.len() };
                let image = numbers.pointer(image.as_ptr().cast_mut());
                // Bytes cannot be misaligned.
                if image.is_null()
                    || length == usize::MAX
                    || image.cast_const() == images[0].as_ptr()
                    || image.cast_const() == images[1].as_ptr()
                {
                    let status = fos_hub_load(hub, image, length);
                    hold(status, &[wrong_with(hub), wrong_with(image)], &[fos_status::Argument]);
                    assert!(length != usize::MAX || status != fos_status::Ok);
                }
            }
            3..=7 => {
                for _ in 0..=numbers.byte() % 16 {
                    let codes: [u8; 12] = numbers.bytes();
                    let code = |k: usize| i16::from_le_bytes([codes[2 * k], codes[2 * k + 1]]);
                    let sample = fos_raw_sample {
                        skipped: if numbers.byte() == 1 { u32::from_le_bytes(numbers.bytes()) } else { 0 },
                        accel: [code(0), code(1), code(2)],
                        gyro: [code(3), code(4), code(5)],
                        temperature: i16::from_le_bytes(numbers.bytes()),
                        faults: u16::from_le_bytes(numbers.bytes()),
                        has_temperature: numbers.byte(),
                    };
                    let mut output = Box::new(MaybeUninit::<fos_output>::uninit());
                    let place = numbers.pointer(output.as_mut_ptr());
                    let raw = numbers.pointer((&raw const sample).cast_mut());
                    let status = fos_hub_update(hub, raw, place);
                    hold(status, &[wrong_with(hub), wrong_with(raw), wrong_with(place)], &[]);
                    if status == fos_status::Ok {
                        let output = output.assume_init();
                        // A huge scale may give an infinity, which must be flagged.
                        for axis in 0..FOS_AXES {
                            let fine = output.corrected[axis].is_finite()
                                || output.validity[axis] != FOS_VALIDITY_VALID;
                            assert!(fine, "{:?}", output.corrected);
                        }
                    }
                }
            }
            8 => {
                let also_wrong = [fos_status::Argument];
                hold(
                    fos_hub_give(hub, numbers.byte().into(), numbers.float()),
                    &[wrong_with(hub)],
                    &also_wrong,
                );
                let status = fos_hub_give_application(hub, numbers.byte().into(), numbers.float());
                hold(status, &[wrong_with(hub)], &[]);
            }
            9 => {
                let status = fos_hub_set_motion(hub, numbers.byte().into());
                hold(status, &[wrong_with(hub)], &[fos_status::Argument]);
            }
            10 => {
                let status = fos_hub_clock(hub, u64::from_le_bytes(numbers.bytes()));
                assert_eq!(status, wrong_with(hub).unwrap_or(fos_status::Ok));
            }
            11 => {
                let mut rate = Box::new(0.0);
                let place = numbers.pointer(&raw mut *rate);
                let status = fos_hub_rate_hz(hub, place);
                hold(status, &[wrong_with(hub), wrong_with(place)], &[]);
                assert!(status != fos_status::Ok || (rate.is_finite() && *rate >= 0.0));
            }
            12 => {
                let mut drift = Box::new(0);
                let place = if numbers.byte() == 0 { null_mut() } else { &raw mut *drift };
                let axis = usize::from(numbers.byte());
                let status = fos_hub_drift(hub, axis, place);
                hold(status, &[wrong_with(hub), wrong_with(place)], &[fos_status::Argument]);
                assert!(status != fos_status::Ok || axis < FOS_AXES);
            }
            13 => {
                assert_eq!(fos_hub_restart_watch(hub), wrong_with(hub).unwrap_or(fos_status::Ok));
            }
            14 => {
                let mut buffer = vec![0; usize::from(numbers.byte()) * 4];
                let mut used = Box::new(0);
                let place = numbers.pointer(&raw mut *used);
                let start = if numbers.byte() == 0 { null_mut() } else { buffer.as_mut_ptr() };
                let capacity = if numbers.byte() == 0 { usize::MAX } else { buffer.len() };
                // Callers promise the stated number of bytes, unless it is impossible.
                let pointers = [wrong_with(hub), wrong_with(start), wrong_with(place)];
                let status = if numbers.byte() & 1 == 0 {
                    let (image, length) = match numbers.byte() {
                        0 => (null(), 0),
                        1 => (null(), 3),
                        n => (images[usize::from(n & 1)].as_ptr(), images[usize::from(n & 1)].len()),
                    };
                    let status = fos_telemetry_start(hub, image, length, start, capacity, place);
                    // Errors of the image may be reported first.
                    let image_is_there = length == 0 || !image.is_null();
                    let fine = image_is_there && pointers.iter().all(Option::is_none);
                    assert!(fine || status != fos_status::Ok);
                    assert!(!fine || !matches!(status, fos_status::Null | fos_status::Misaligned));
                    status
                } else {
                    let status = fos_telemetry_sample(hub, start, capacity, place);
                    hold(status, &pointers, &[fos_status::Argument]);
                    status
                };
                let written = if status == fos_status::Ok { 1..=buffer.len() } else { 0..=0 };
                assert!(!Numbers::is_there(place) || written.contains(&*used), "{status:?}: {used}");
                assert!(status != fos_status::Ok || buffer[*used - 1] == 0);
            }
            _ => {
                for text in [
                    fos_version(),
                    fos_status_text(i32::from_le_bytes(numbers.bytes())),
                    fos_validity_text(u16::from_le_bytes(numbers.bytes())),
                ] {
                    assert!(CStr::from_ptr(text).to_str().is_ok());
                }
                assert!(fos_api_version() == FOS_API_VERSION && fos_hub_align() <= FOS_HUB_ALIGN);
            }
        }
    }
}
