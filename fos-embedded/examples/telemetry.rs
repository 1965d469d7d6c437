//! Telemetry of a hub over a serial line: every sample, or only the seconds around an alarm.
//!
//! ```text
//! cargo run -p fos-embedded --example telemetry > stream && fos record stream -o log.parquet
//! ```

use std::io::Write as _;

use embedded_io::{ErrorKind, ErrorType, Write};
use fos_core::{FittedOn, Info};
use fos_embedded::hub::Hub;
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_embedded::telemetry::{
    AlarmRecorder, HUB_AXES, Recorder, Snapshot, StartFrame, TelemetryError, VERSION,
};

/// The line, here standard output; on a board a UART or USB of its HAL.
struct Line;

impl ErrorType for Line {
    type Error = ErrorKind;
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        std::io::stdout().write(bytes).map_err(|_| ErrorKind::Other)
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        std::io::stdout().flush().map_err(|_| ErrorKind::Other)
    }
}

fn main() -> Result<(), TelemetryError<ErrorKind>> {
    let scales = Scales {
        accel_mps2: 0.001_197,
        gyro_rads: 0.000_305,
        temperature_k: 1.0 / 256.0,
        temperature_zero_c: 25.0,
        period_s: 0.005,
        values: FittedOn::Raw,
    };
    // without a model, as for recording a first log
    let mut hub: Hub<0, 0, 2> = Hub::new(scales);
    // columns of the logged quantities other than the axes; `Info` is that of the image, if there is one
    let columns = hub.columns::<64>(&Info::default()).expect("`temp_c` fits");
    let start = StartFrame { version: VERSION, period_s: 0.005, axes: HUB_AXES, quantities: &columns };

    // frames of up to 320 bytes; `fos record` on the host turns them into a log
    let mut recorder: Recorder<_, 320> = Recorder::new(Line);
    for n in 0..1000 {
        let output = *hub.update(&raw(n));
        recorder.sample(&start, Snapshot::<1>::new(&output, &hub.logged()).frame())?;
    }

    // 1 s before an alarm and 2 s after it, for a line or battery with too little capacity for every sample
    let mut alarmed: AlarmRecorder<_, 320, 1, 200> = AlarmRecorder::new(recorder, 400);
    for n in 1000..3000 {
        let output = *hub.update(&raw(n));
        alarmed.sample(&start, &output, &hub.logged())?;
        if output.faults.contains(Faults::OVERRUN) {
            alarmed.trigger();
        }
    }
    Ok(())
}

/// A sensor at rest whose FIFO overruns once.
fn raw(n: u16) -> RawSample {
    let noise = (n % 7) as i16 - 3;
    RawSample {
        accel: [noise, -noise, 8193 + noise],
        gyro: [2 * noise, 65, -noise],
        temperature: Some(128),
        faults: if n == 2000 { Faults::OVERRUN } else { Faults::empty() },
        ..RawSample::default()
    }
}
