//! Control: a C caller that states one byte too many. Only the address sanitizer can detect it.
#![no_main]

use core::ptr::null_mut;

use fos_embedded::c_api::*;
use fos_fuzz::C_SCALES;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let image = bytes.to_vec().into_boxed_slice();
    let mut memory = vec![0_u64; fos_hub_size().div_ceil(8)];
    let mut hub = null_mut();
    let lie = usize::from(image.starts_with(b"FOSM") && image.len().is_multiple_of(2));
    // SAFETY: the size is as stated except for the deliberate error; the checksum covers the image to its last
    // byte.
    unsafe {
        let _ = fos_hub_init(memory.as_mut_ptr().cast(), 8 * memory.len(), &C_SCALES, &mut hub);
        let _ = fos_hub_load(hub, image.as_ptr(), image.len() + lie);
    }
});
