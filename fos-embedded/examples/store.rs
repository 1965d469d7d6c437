//! Model images in flash: updates, the rollback, and recovery after one slot was lost.
//!
//! ```text
//! cargo run -p fos-embedded --example store
//! ```

use core::convert::Infallible;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Info, InnovationStatistics, Model, Range, Term, y,
};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::store::ModelStore;

const PAGE: u32 = 4096;

/// A flash; on a board that of the HAL. An asynchronous flash needs no `Blocking`; its operations are awaited.
struct Flash(Vec<u8>);

impl ErrorType for Flash {
    type Error = Infallible;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (held, byte) in self.0[offset as usize..].iter_mut().zip(bytes) {
            *held &= byte;
        }
        Ok(())
    }
}

/// An image as received over the air, here of a model with one term.
fn image(coefficient: f32) -> Vec<u8> {
    let parameters = AxisParameters {
        axis: Axis::Gz,
        reference: 0.0,
        offset: 0.01,
        scale: 0.002,
        constant: 0.0,
        range: Range::new(-4.0, 4.0),
        physical_range: Range::new(0.0, 0.0),
        full_scale: 8.7,
        stuck_after_repeats: 50,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.2, lag_1_correlation: 0.0 },
    };
    let stochastic = [Term::new(coefficient, &[y(1)])];
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[],
        inputs: &[],
        axes: &[AxisModel { parameters, physical: &[], stochastic: &stochastic }],
    };
    encode(&model, &Info::default(), &mut [0; 512]).expect("it fits").to_vec()
}

fn main() {
    // two slots of two pages each; images of up to 2 KiB
    let mut store: ModelStore<_, 2056> =
        ModelStore::new(Blocking(Flash(vec![0xff; 4 * PAGE as usize])), 0..4 * PAGE).expect("whole pages");
    assert_eq!(poll_once(store.load()), Some(Ok(None)), "new from the factory");

    let (first, second) = (image(0.5), image(0.6));
    poll_once(store.store(&first)).expect("done at once").expect("stored");
    poll_once(store.store(&second)).expect("done at once").expect("stored");
    assert_eq!(poll_once(store.load()), Some(Ok(Some(&second[..]))), "the newest is what a hub loads");
    assert_eq!(poll_once(store.load_previous()), Some(Ok(Some(&first[..]))), "and the way back is there");

    // an invalid image is rejected before anything is written
    let half = &second[..second.len() / 2];
    assert!(poll_once(store.store(half)).expect("done at once").is_err());
    assert_eq!(poll_once(store.load()), Some(Ok(Some(&second[..]))));

    // flash that lost its charge, or an interrupted write: the other slot is still valid
    let mut flash = store.release().0;
    flash.0[2 * PAGE as usize..].fill(0x55);
    let mut store: ModelStore<_, 2056> = ModelStore::new(Blocking(flash), 0..4 * PAGE).expect("whole pages");
    assert_eq!(poll_once(store.load()), Some(Ok(Some(&first[..]))));
    println!("two images of {} bytes, one slot lost: the image before is loaded", first.len());
}
