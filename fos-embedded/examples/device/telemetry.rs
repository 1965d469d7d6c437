//! The samples of a hub on a line.

use embedded_io::Write;
use fos_core::{Image, Info, Scalar};
use fos_embedded::hub::Hub;
use fos_embedded::telemetry::{HUB_AXES, Recorder, Snapshot, StartFrame, VERSION};
use heapless::String;

/// Room for 16 inputs, 128 terms, 256 values of history. `R` is `f32`, or `Fixed` on a chip without an FPU.
pub(crate) type DeviceHub<R> = Hub<16, 128, 256, R>;

/// Telemetry of a hub over a stream.
pub(crate) struct Telemetry<W> {
    recorder: Recorder<W, 384>,
    /// Names of the logged quantities other than the axes.
    columns: String<256>,
}

impl<W: Write> Telemetry<W> {
    /// Creates the telemetry of a hub without a model.
    pub(crate) fn new<R: Scalar<Stored = f32>>(stream: W, hub: &DeviceHub<R>) -> Self {
        Self { recorder: Recorder::new(stream), columns: columns(hub, &Info::default()) }
    }

    /// Loads a model into the hub and describes the samples from here on. A hub that refuses the model runs without one.
    pub(crate) fn load<R: Scalar<Stored = f32>>(&mut self, hub: &mut DeviceHub<R>, image: &[u8]) {
        let loaded = hub.load(image).ok().and_then(|()| Image::parse(image).ok());
        self.columns = columns(hub, &loaded.map_or(Info::default(), |image| image.info()));
        self.recorder.begin();
    }

    /// Sends the latest sample of the hub. The next frame ends one that was cut.
    pub(crate) fn sample<R: Scalar<Stored = f32>>(&mut self, hub: &DeviceHub<R>) {
        let period_s = hub.scales().period_s as f32;
        let start = StartFrame { version: VERSION, period_s, axes: HUB_AXES, quantities: &self.columns };
        let _ = self.recorder.sample(&start, Snapshot::<16>::new(hub.output(), &hub.logged()).frame());
    }
}

fn columns<R: Scalar<Stored = f32>>(hub: &DeviceHub<R>, info: &Info<'_>) -> String<256> {
    hub.columns(info).unwrap_or_default()
}
