//! The model store on a simulated NOR flash, with power loss at every single operation.

use crate::models::numbered;
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::store::{ModelStore, StoreError};
use fos_testkit::flash::{Fault, Flash, PAGE, PAGES};

type Store = ModelStore<Blocking<Flash>, 1024>;

fn store(flash: Flash) -> Store {
    ModelStore::new(Blocking(flash), 0..(PAGES * PAGE) as u32).unwrap_or_else(|_| panic!("a range"))
}

fn load(store: &mut Store) -> Option<Vec<u8>> {
    poll_once(store.load()).expect("done at once").expect("a flash").map(<[u8]>::to_vec)
}

fn previous(store: &mut Store) -> Option<Vec<u8>> {
    poll_once(store.load_previous()).expect("done at once").expect("a flash").map(<[u8]>::to_vec)
}

fn put(store: &mut Store, image: &[u8]) -> Result<(), StoreError<Fault>> {
    poll_once(store.store(image)).expect("done at once")
}

/// A distinct model for every number.
fn model(number: u32) -> Vec<u8> {
    numbered(number, 0)
}

#[test]
fn loads_the_newest_and_the_previous_image() {
    let mut device = store(Flash::new());
    assert_eq!(load(&mut device), None);
    for number in 0..200 {
        put(&mut device, &model(number)).expect("stored");
        assert_eq!(load(&mut device), Some(model(number)), "update {number}");
        let before = number.checked_sub(1).map(model);
        assert_eq!(previous(&mut device), before, "update {number}");
    }
    // also after a restart
    let mut again = store(device.release().0);
    assert_eq!(load(&mut again), Some(model(199)));
}

#[test]
fn takes_over_flash_with_foreign_contents() {
    let random = |place: usize| (place as u64).wrapping_mul(6_364_136_223_846_793_005).to_be_bytes()[0];
    for before in [|_| 0, |place| (place % 251) as u8, random] {
        let mut flash = Flash::new();
        for (place, byte) in flash.bytes.iter_mut().enumerate() {
            *byte = before(place);
        }
        let mut device = store(flash);
        assert_eq!(load(&mut device), None);
        for number in 0..30 {
            assert_eq!(put(&mut device, &model(number)), Ok(()));
            assert_eq!(load(&mut device), Some(model(number)));
            assert_eq!(previous(&mut device), number.checked_sub(1).map(model));
        }
    }
    // the image in use survives the loss of the other slot
    let mut device = store(Flash::new());
    put(&mut device, &model(1)).expect("stored");
    let mut flash = device.release().0;
    flash.bytes[PAGES / 2 * PAGE..].fill(0x55);
    let mut cuts = Cuts::default();
    cuts.cut_everywhere(&flash, Some(&model(1)), &model(2));
    cuts.print("a slot beyond repair");
}

/// Valid images after power losses.
#[derive(Debug, Default)]
struct Cuts {
    updates: usize,
    longest: usize,
    old: usize,
    new: usize,
}

impl Cuts {
    /// Cuts the power at each operation of storing `new`, on copies of `flash`, which holds `old`.
    fn cut_everywhere(&mut self, flash: &Flash, old: Option<&[u8]>, new: &[u8]) {
        let mut whole = store(flash.clone());
        put(&mut whole, new).expect("stored");
        let operations = whole.release().0.operations - flash.operations;
        assert!(operations > 0);
        // before the operation, in its middle, directly after it
        for (at, halves) in (1..=operations).flat_map(|at| [(at, 0), (at, 1), (at, 2)]) {
            let mut device = store(Flash { power: Some((at, halves)), ..flash.clone() });
            let stored = put(&mut device, new);
            // the power is back
            let mut device = store(Flash { power: None, ..device.release().0 });
            let found = load(&mut device);
            match found.as_deref() {
                found if found == Some(new) => self.new += 1,
                found if found == old => self.old += 1,
                found => panic!("cut {halves}/2 through {at} of {operations}: {found:?}"),
            }
            if stored.is_ok() {
                assert_eq!(found.as_deref(), Some(new), "what was said to be stored is");
            }
            // and later updates work
            put(&mut device, &model(999)).expect("stored after a cut");
            assert_eq!(load(&mut device), Some(model(999)));
        }
        self.updates += 1;
        self.longest = self.longest.max(operations);
    }

    fn print(&self, what: &str) {
        println!(
            "{what}: power cut before, in and after each of {} operations ({} at most in one store): {} times the image before, {} times the new one",
            (self.old + self.new) / 3,
            self.longest,
            self.old,
            self.new
        );
    }
}

#[test]
fn power_loss_leaves_the_old_or_new_image() {
    let mut first = Cuts::default();
    first.cut_everywhere(&Flash::new(), None, &model(1));
    first.print("first store");
    let mut device = store(Flash::new());
    let mut cuts = Cuts::default();
    // over several changes of all pages, so that erases are among the operations
    for number in 0..150 {
        let old = model(number);
        put(&mut device, &old).expect("stored");
        let flash = device.release().0;
        cuts.cut_everywhere(&flash, Some(&old), &model(number + 1));
        device = store(flash);
    }
    assert!(cuts.longest > 3, "a page was turned");
    cuts.print("150 updates");
}

#[test]
fn worn_page_loses_no_image() {
    let mut device = store(Flash::new());
    put(&mut device, &model(1)).expect("stored");
    let mut flash = device.release().0;
    // bits that stay cleared throughout a page of the second slot
    flash.worn = (0..PAGE / 64).map(|place| (4 * PAGE + 64 * place + 13, 0x24)).collect();
    flash.wear();
    let (mut stored, mut refused, mut newest) = (0, 0, model(1));
    let mut cuts = Cuts::default();
    for number in 2..150 {
        cuts.cut_everywhere(&flash, Some(&newest), &model(number));
        let mut device = store(flash);
        match put(&mut device, &model(number)) {
            Ok(()) => (stored, newest) = (stored + 1, model(number)),
            Err(StoreError::VerifyFailed) => refused += 1,
            Err(error) => panic!("{error:?}"),
        }
        assert_eq!(load(&mut device), Some(newest.clone()), "update {number}");
        flash = device.release().0;
    }
    cuts.print("148 updates with a worn page");
    println!("a worn page: {stored} of 148 updates kept, {refused} refused, none lost");
    assert!(stored > 0);
}

#[test]
fn rejects_invalid_images_without_a_change() {
    let mut device = store(Flash::new());
    put(&mut device, &model(5)).expect("stored");
    let mut broken = model(6);
    broken[20] ^= 1;
    assert!(matches!(put(&mut device, &broken), Err(StoreError::Image(_))));
    assert!(matches!(put(&mut device, b"no image"), Err(StoreError::Image(_))));
    assert_eq!(load(&mut device), Some(model(5)));
    let mut small: ModelStore<_, 32> =
        ModelStore::new(Blocking(Flash::new()), 0..(4 * PAGE) as u32).unwrap_or_else(|_| panic!("a range"));
    assert!(matches!(poll_once(small.store(&model(1))), Some(Err(StoreError::TooLong(_)))));
    let odd = ModelStore::<_, 1024>::new(Blocking(Flash::new()), 0..3 * PAGE as u32);
    assert!(matches!(odd.err(), Some(StoreError::Range)), "three pages are too few");
}
