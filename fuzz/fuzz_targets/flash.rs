//! The model store on a flash with any content: it returns an image or reports that there is none, in bounded time, and
//! returns what was stored.
//!
//! The input has the number of stored updates, then changes of the flash: position, length, bytes.
#![no_main]


use std::sync::LazyLock;

use fos_testkit::flash::{Flash, PAGE, PAGES};
use fos_core::image::{Info, encode};
use fos_core::{Image, Term, y};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::store::ModelStore;
use fos_testkit::models::{OwnedModel, plain};
use libfuzzer_sys::fuzz_target;

type Store = ModelStore<Blocking<Flash>, 1024>;

/// Updates of a device.
static IMAGES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let image = |number: u32| {
        let term = Term::try_new(f64::from(number) * 0.01, &[y(1)]).expect("a term");
        let model = OwnedModel::autoregressive(plain(), vec![term]).convert::<f32>();
        let mut buffer = [0; 512];
        model.borrow(|model| encode(model, &Info::default(), &mut buffer).expect("room").to_vec())
    };
    (0..32).map(image).collect()
});

/// Flash of a device after each of its updates: its first pages fill up.
static STORED: LazyLock<Vec<Flash>> = LazyLock::new(|| {
    let mut flashes = vec![Flash::new()];
    for image in &IMAGES[1..] {
        let mut store = store(flashes[flashes.len() - 1].clone());
        poll_once(store.store(image)).expect("done at once").expect("a sound flash");
        flashes.push(store.release().0);
    }
    flashes
});

fn store(flash: Flash) -> Store {
    ModelStore::new(Blocking(flash), 0..(PAGES * PAGE) as u32).unwrap_or_else(|_| panic!("a range"))
}

fuzz_target!(|bytes: &[u8]| {
    let Some((&updates, mut changes)) = bytes.split_first() else { return };
    let mut flash = STORED[usize::from(updates) % STORED.len()].clone();
    while let Some(([low, high, length], rest)) = changes.split_first_chunk() {
        let place = usize::from(u16::from_le_bytes([*low, *high])) % flash.bytes.len();
        let (change, rest) = rest.split_at(usize::from(*length).min(rest.len()));
        flash.bytes.iter_mut().skip(place).zip(change).for_each(|(byte, new)| *byte = *new);
        changes = rest;
    }
    let operations = flash.operations;
    let mut store = store(flash);
    let is_image = |image: Option<&[u8]>| image.is_none_or(|image| Image::parse(image).is_ok());
    assert!(poll_once(store.load()).expect("done at once").is_ok_and(is_image), "it gives what is no image");
    assert!(
        poll_once(store.load_previous()).expect("done at once").is_ok_and(is_image),
        "it gives what is no image"
    );
    let next = &IMAGES[0];
    if poll_once(store.store(next)).expect("done at once").is_ok() {
        let held = poll_once(store.load()).expect("done at once");
        assert_eq!(held, Ok(Some(&next[..])), "it forgets what it has stored");
    }
    // Operations to erase and write three slots.
    assert!(store.release().0.operations - operations <= 1000, "it writes without end");
});
