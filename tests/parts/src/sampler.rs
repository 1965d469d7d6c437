//! Everything of a part besides its registers: time, codes, FIFO and faults.

use crate::codes::{Codes, Sample};
use crate::faults::Faults;
use crate::fifo::Fifo;

/// Time, codes, FIFO and faults of a part.
#[derive(Debug)]
pub(crate) struct Sampler {
    /// Time by the part's clock, ns since power-on.
    pub(crate) now_ns: u64,
    /// Time of the last reset by the part's clock.
    pub(crate) reset_ns: u64,
    pub(crate) fifo: Fifo,
    pub(crate) faults: Faults,
    codes: Codes,
    /// Length of a tick of the source, ns.
    tick_ns: u64,
    /// Code of the thermometer if the codes are generated.
    room: i16,
    /// Tick at which the codes stand still.
    held: Option<u64>,
}

impl Sampler {
    pub(crate) fn new(codes: Codes, tick_ns: u64, room: i16) -> Self {
        Self {
            now_ns: 0,
            reset_ns: 0,
            fifo: Fifo::default(),
            faults: Faults::default(),
            codes,
            tick_ns,
            room,
            held: None,
        }
    }

    /// Time since the last reset, ns.
    pub(crate) fn since_reset_ns(&self) -> u64 {
        self.now_ns - self.reset_ns
    }

    /// Number of the present tick of the source.
    pub(crate) fn tick(&self) -> u64 {
        self.now_ns / self.tick_ns
    }

    /// Codes at the present tick; the temperature is the latest that a thermometer with this period has measured.
    pub(crate) fn sample(&mut self, thermometer_ns: u64) -> Sample {
        let tick = self.tick();
        let tick = match self.held {
            Some(held) if self.faults.frozen => held,
            _ => tick,
        };
        self.held = Some(tick);
        Sample { temperature: self.temperature(thermometer_ns), ..self.codes.at(tick, self.room) }
    }

    /// Latest code of a thermometer with this period.
    pub(crate) fn temperature(&self, thermometer_ns: u64) -> i16 {
        let since = self.since_reset_ns();
        let measured_ns = self.reset_ns + (since - since % thermometer_ns);
        self.codes.at(measured_ns / self.tick_ns, self.room).temperature
    }

    /// Returns true if an event with this period falls between the previous sample, `sample_ns` ago, and now.
    pub(crate) fn is_due(&self, period_ns: u64, sample_ns: u64) -> bool {
        let now = self.since_reset_ns();
        now / period_ns != now.saturating_sub(sample_ns) / period_ns
    }
}
