//! The samples of a hub on a line.

use embedded_io::Write;
use fos_core::{Fixed, Image, Info};
use fos_embedded::hub::Hub;
use fos_embedded::telemetry::{HUB_AXES, Recorder, Snapshot, StartFrame, VERSION};
use heapless::String;

/// Room for 16 inputs, 128 terms, 256 values of history; in fixed point, since the chip has no FPU.
pub type PicoHub = Hub<16, 128, 256, Fixed>;

/// Telemetry of a hub over a stream.
pub struct Telemetry<W> {
    recorder: Recorder<W, 384>,
    /// Names of the logged quantities other than the axes.
    columns: String<256>,
}

impl<W: Write> Telemetry<W> {
    /// Creates the telemetry of a hub without a model.
    pub fn new(stream: W, hub: &PicoHub) -> Self {
        Self::described(stream, hub, &Info::default())
    }

    /// Loads a model into the hub and describes the samples from here on. A hub that refuses the model runs without one.
    pub fn load(self, hub: &mut PicoHub, image: &[u8]) -> Self {
        let loaded = hub.load(image).ok().and_then(|()| Image::parse(image).ok());
        Self::described(self.recorder.release(), hub, &loaded.map_or(Info::default(), |image| image.info()))
    }

    // a new recorder begins with a start frame
    fn described(stream: W, hub: &PicoHub, info: &Info<'_>) -> Self {
        Self { recorder: Recorder::new(stream), columns: hub.columns(info).unwrap_or_default() }
    }

    /// Sends the latest sample of the hub. The next frame ends one that was cut.
    pub fn sample(&mut self, hub: &PicoHub) {
        let period_s = hub.scales().period_s as f32;
        let start = StartFrame { version: VERSION, period_s, axes: HUB_AXES, quantities: &self.columns };
        let _ = self.recorder.sample(&start, Snapshot::<16>::new(hub.output(), &hub.logged()).frame());
    }
}
