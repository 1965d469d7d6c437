//! Hub, model store and telemetry of a device: the part of the firmware that does not depend on the chip.

mod telemetry;

use core::ops::Range;

use embedded_io::Write;
use embedded_storage_async::nor_flash::NorFlash;
use fos_core::Scalar;
use fos_embedded::raw::{RawSample, Scales};
use fos_embedded::store::{ModelStore, StoreError};
use fos_embedded::telemetry::ImageReceiver;
use telemetry::{DeviceHub, Telemetry};

/// Longest model image, bytes: half a page of 4 kB, less what the store writes around it.
const IMAGE_BYTES: usize = 2000;

/// A hub with its models in flash `F`, its telemetry on stream `W`, and updates that arrive byte by byte.
pub(crate) struct Device<R: Scalar<Stored = f32>, F: NorFlash, W> {
    hub: DeviceHub<R>,
    store: ModelStore<F, { IMAGE_BYTES + 8 }>,
    telemetry: Telemetry<W>,
    receiver: ImageReceiver<{ IMAGE_BYTES + 16 }>,
}

impl<R: Scalar<Stored = f32>, F: NorFlash, W: Write> Device<R, F, W> {
    /// Creates a device for a sensor with these scales, without a model. `range` of `flash` holds the model images.
    ///
    /// # Errors
    ///
    /// The range does not consist of whole pages, or has fewer than four.
    pub(crate) fn new(
        scales: Scales,
        flash: F,
        range: Range<u32>,
        stream: W,
    ) -> Result<Self, StoreError<F::Error>> {
        let hub = DeviceHub::new(scales);
        let telemetry = Telemetry::new(stream, &hub);
        Ok(Self { hub, store: ModelStore::new(flash, range)?, telemetry, receiver: ImageReceiver::new() })
    }

    /// Loads the newest image of the store; without one, the hub keeps its model.
    pub(crate) async fn load(&mut self) {
        if let Ok(Some(image)) = self.store.load().await {
            self.telemetry.load(&mut self.hub, image);
        }
    }

    /// Processes a sample.
    pub(crate) fn update(&mut self, raw: &RawSample) {
        let _output = self.hub.update(raw);
    }

    /// Sends the latest sample.
    pub(crate) fn send(&mut self) {
        self.telemetry.sample(&self.hub);
    }

    /// Passes the time of the application's clock, µs, after all samples up to then.
    pub(crate) fn clock(&mut self, now_us: u64) {
        self.hub.clock(now_us);
    }

    /// Takes bytes from the line. A complete image is stored and loaded if the hub runs it; otherwise the previous one is
    /// loaded again.
    pub(crate) async fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let Some(Ok(image)) = self.receiver.push(*byte) else { continue };
            // only an image that the hub runs is stored; after a failure the previous one runs on
            if self.hub.load(image).is_ok() {
                let _ = self.store.store(image).await;
            }
            self.load().await;
        }
    }
}
