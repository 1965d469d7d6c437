//! The store through C functions on a simulated flash: sectors of every size, power loss at every byte of a write and at
//! every erase.

use core::ffi::c_void;
use core::ptr::null_mut;

use crate::models::numbered;
use fos_embedded::c_api::*;

/// Start address of the flash; a multiple of every tested sector size.
const BASE: u32 = 0x0008_0000;

/// NOR flash as described in the header: a write clears bits, once after every erase of a sector.
#[derive(Clone)]
struct Flash {
    bytes: Vec<u8>,
    sector: u32,
    /// Words written since the last erase.
    written: Vec<bool>,
    /// Bytes to write or sectors to erase until the power fails.
    power: Option<usize>,
    /// Bytes written and sectors erased so far.
    steps: usize,
    /// Number of words written twice.
    twice: usize,
}

impl Flash {
    fn new(sector: u32, pages: u32) -> Self {
        let bytes = (pages * sector.max(4096)) as usize;
        Self {
            bytes: vec![0xff; bytes],
            sector,
            written: vec![false; bytes / 8],
            power: None,
            steps: 0,
            twice: 0,
        }
    }

    fn step(&mut self) -> bool {
        match &mut self.power {
            Some(0) => return false,
            Some(left) => *left -= 1,
            None => {}
        }
        self.steps += 1;
        true
    }

    fn describe(&mut self) -> fos_flash {
        fos_flash {
            context: (&raw mut *self).cast(),
            read: Some(read),
            write: Some(write),
            erase: Some(erase),
            address: BASE,
            capacity: self.bytes.len() as u32,
            erase_size: self.sector,
        }
    }

    fn place(&self, address: u32, length: usize, unit: u32) -> usize {
        let place = address.checked_sub(BASE).expect("in the range") as usize;
        assert!(address.is_multiple_of(unit) && length.is_multiple_of(unit as usize) && length > 0);
        assert!(place + length <= self.bytes.len());
        place
    }
}

unsafe extern "C" fn read(context: *mut c_void, address: u32, bytes: *mut u8, length: usize) -> i32 {
    // SAFETY: the context of `describe`
    let flash = unsafe { &mut *context.cast::<Flash>() };
    let place = flash.place(address, length, 8);
    if flash.power == Some(0) {
        return -1;
    }
    // SAFETY: guaranteed by the header
    unsafe { core::slice::from_raw_parts_mut(bytes, length) }
        .copy_from_slice(&flash.bytes[place..place + length]);
    0
}

unsafe extern "C" fn write(context: *mut c_void, address: u32, bytes: *const u8, length: usize) -> i32 {
    // SAFETY: the context of `describe`
    let flash = unsafe { &mut *context.cast::<Flash>() };
    let place = flash.place(address, length, 8);
    // SAFETY: guaranteed by the header
    let bytes = unsafe { core::slice::from_raw_parts(bytes, length) };
    for (n, byte) in bytes.iter().enumerate() {
        if !flash.step() {
            return 7;
        }
        if n % 8 == 0 {
            let word = (place + n) / 8;
            flash.twice += usize::from(core::mem::replace(&mut flash.written[word], true));
        }
        flash.bytes[place + n] &= byte;
    }
    0
}

unsafe extern "C" fn erase(context: *mut c_void, address: u32, length: u32) -> i32 {
    // SAFETY: the context of `describe`
    let flash = unsafe { &mut *context.cast::<Flash>() };
    assert_eq!(length, flash.sector.max(4096));
    let place = flash.place(address, length as usize, flash.sector);
    for sector in (place..place + length as usize).step_by(flash.sector as usize) {
        if !flash.step() {
            return 7;
        }
        let end = sector + flash.sector as usize;
        flash.bytes[sector..end].fill(0xff);
        flash.written[sector / 8..end / 8].fill(false);
    }
    0
}

/// A store over a flash that outlives it.
struct Held {
    store: *mut fos_store,
    _memory: Vec<u64>,
}

fn made(flash: &mut Flash) -> Held {
    let mut memory = vec![u64::MAX; FOS_STORE_BYTES / 8];
    let (mut store, described) = (null_mut(), flash.describe());
    // SAFETY: the memory has the stated length, the functions are those above
    let status =
        unsafe { fos_store_init(memory.as_mut_ptr().cast(), FOS_STORE_BYTES, &described, &mut store) };
    assert_eq!(status, fos_status::Ok);
    Held { store, _memory: memory }
}

fn save(held: &Held, image: &[u8]) -> fos_status {
    // SAFETY: a store, and an image of the stated length
    unsafe { fos_store_save(held.store, image.as_ptr(), image.len()) }
}

type Load = unsafe extern "C" fn(*mut fos_store, *mut u8, usize, *mut usize) -> fos_status;

fn loaded(held: &Held, load: Load) -> Result<Vec<u8>, fos_status> {
    let (mut buffer, mut used) = ([0; FOS_STORE_IMAGE_BYTES], 0);
    // SAFETY: a store, and a buffer of the stated length
    match unsafe { load(held.store, buffer.as_mut_ptr(), buffer.len(), &mut used) } {
        fos_status::Ok => Ok(buffer[..used].to_vec()),
        status => {
            assert_eq!(used, 0);
            Err(status)
        }
    }
}

#[test]
fn loads_the_newest_and_the_previous_image() {
    for sector in [8, 512, 2048, 4096, 8192, 65_536] {
        let mut flash = Flash::new(sector, 4);
        let held = made(&mut flash);
        assert_eq!(loaded(&held, fos_store_load), Err(fos_status::NoModel));
        for number in 0..60 {
            assert_eq!(save(&held, &numbered(number, 300)), fos_status::Ok);
            assert_eq!(loaded(&held, fos_store_load), Ok(numbered(number, 300)), "update {number}");
            let before = number.checked_sub(1).map(|number| numbered(number, 300)).ok_or(fos_status::NoModel);
            assert_eq!(loaded(&held, fos_store_load_previous), before, "update {number}");
        }
        drop(held);
        assert_eq!(flash.twice, 0, "a word is written once");
        // also after a restart
        let again = made(&mut flash);
        assert_eq!(loaded(&again, fos_store_load), Ok(numbered(59, 300)));
    }
}

#[test]
fn longest_image_has_the_documented_length() {
    let long = |length: usize| {
        // a length of the information of 128 or more takes one more byte
        let image = numbered(1, length - numbered(1, 200).len() + 200);
        assert_eq!(image.len(), length);
        image
    };
    // with two pages per slot, half a page
    for (sector, pages, longest) in
        [(4096, 4, 2027), (512, 5, 2027), (8192, 4, 2027), (4096, 6, FOS_STORE_IMAGE_BYTES)]
    {
        let mut flash = Flash::new(sector, pages);
        let held = made(&mut flash);
        for number in 0..40 {
            let length = longest - [0, 1, 2, 1000, 3][number % 5];
            assert_eq!(save(&held, &long(length)), fos_status::Ok, "{sector}, {pages}, {number}");
            assert_eq!(loaded(&held, fos_store_load), Ok(long(length)));
            assert_eq!(save(&held, &long(longest + 1)), fos_status::NoRoom);
        }
    }
}

#[test]
fn power_loss_at_any_byte_leaves_the_old_or_new_image() {
    for (sector, pages, information) in
        [(4096, 4, 250), (512, 4, 250), (8192, 4, 250), (4096, 6, 250), (4096, 4, 1800), (4096, 6, 3800)]
    {
        let (mut cuts, mut old, mut new) = (0, 0, 0);
        let mut flash = Flash::new(sector, pages);
        // over several page changes, so that erases are among the steps
        for number in 0..45 {
            let (before, after) = (numbered(number, information), numbered(number + 1, information));
            assert_eq!(save(&made(&mut flash), &before), fos_status::Ok);
            let mut whole = flash.clone();
            assert_eq!(save(&made(&mut whole), &after), fos_status::Ok);
            let steps = whole.steps - flash.steps;
            // every byte of some updates, and some bytes of the others
            let stride = if information == 250 && number % 15 == 0 { 1 } else { 29 * information / 250 };
            for at in (0..steps).filter(|at| at % stride == 0 || at + 1 == steps) {
                let mut cut = Flash { power: Some(at), ..flash.clone() };
                assert_eq!(save(&made(&mut cut), &after), fos_status::Flash);
                cut.power = None;
                // the power is back
                let held = made(&mut cut);
                let found = loaded(&held, fos_store_load).expect("an image");
                assert!(found == before || found == after, "cut after {at} of {steps}");
                old += usize::from(found == before);
                new += usize::from(found == after);
                cuts += 1;
                // and later updates work
                assert_eq!(save(&held, &numbered(999, information)), fos_status::Ok);
                assert_eq!(loaded(&held, fos_store_load), Ok(numbered(999, information)));
            }
        }
        println!(
            "{pages} pages, sectors of {sector}: {cuts} cuts, {old} times the image before, {new} times the new one"
        );
        assert!(old > 0 && new > 0);
    }
}

#[test]
fn rejected_images_are_not_written() {
    let mut flash = Flash::new(4096, 4);
    let held = made(&mut flash);
    let good = numbered(1, 10);
    let mut damaged = good.clone();
    damaged[30] ^= 1;
    assert_eq!(save(&held, &damaged), fos_status::Damaged);
    assert_eq!(save(&held, &good[..good.len() - 1]), fos_status::Truncated);
    assert_eq!(save(&held, b"a picture"), fos_status::Truncated);
    drop(held);
    assert_eq!(flash.steps, 0);
}
