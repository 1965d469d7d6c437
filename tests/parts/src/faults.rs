//! Faults injected from outside.

/// A fault, with the meaning of its value; 0 ends it. The numbers are those of the C interface and do not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Fault {
    /// Ends every fault that lasts; the value is ignored.
    None = 0,
    /// Number of following transfers that are not answered: I2C addresses are not acknowledged, SPI reads ones.
    Nack = 1,
    /// The data line from the part is stuck high: reads ones, I2C addresses are not acknowledged.
    StuckHigh = 2,
    /// The data line from the part is stuck low: reads zeros, every byte on I2C seems acknowledged, nothing is written.
    StuckLow = 3,
    /// Bytes of FIFO data after which the next burst is cut short, once: the rest reads ones and is not taken from the FIFO.
    Cut = 4,
    /// One bit flips in one of this many bytes read.
    Flip = 5,
    /// Identity of another part.
    Identity = 6,
    /// The codes stand still.
    Frozen = 7,
    /// The thermometer has no valid value.
    NoTemperature = 8,
    /// Nothing goes into the FIFO.
    Silent = 9,
    /// Registers do not hold what is written to them.
    Forgetful = 10,
    /// The part resets itself, as at power-on, once.
    Reset = 11,
    /// The FIFO runs over, once: what it holds is lost, as if overwritten.
    Overrun = 12,
    /// Deviation of the part's clock, ppm.
    Ppm = 13,
    /// Drift of the part's clock, ppm/s, from its present deviation on.
    Drift = 14,
    /// The interrupt pins are stuck: 1 low, 2 high.
    Pin = 15,
    /// Time from now on for which the part answers no transfer, ns.
    Unanswered = 16,
    /// Time for which the part holds SCL low after each byte on I2C, ns.
    Stretch = 17,
}

impl Fault {
    /// The fault with this number in the C interface.
    pub(crate) fn from_number(number: u32) -> Option<Self> {
        use Fault::{
            Cut, Drift, Flip, Forgetful, Frozen, Identity, Nack, NoTemperature, None as Ends, Overrun, Pin,
            Ppm, Reset, Silent, Stretch, StuckHigh, StuckLow, Unanswered,
        };
        let all = [
            Ends,
            Nack,
            StuckHigh,
            StuckLow,
            Cut,
            Flip,
            Identity,
            Frozen,
            NoTemperature,
            Silent,
            Forgetful,
            Reset,
            Overrun,
            Ppm,
            Drift,
            Pin,
            Unanswered,
            Stretch,
        ];
        all.into_iter().find(|fault| *fault as u32 == number)
    }
}

/// Present faults.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    pub(crate) nack: u64,
    pub(crate) stuck_high: bool,
    pub(crate) stuck_low: bool,
    /// FIFO bytes left before the burst is cut.
    pub(crate) cut: Option<u64>,
    pub(crate) flip: u64,
    pub(crate) identity: Option<u8>,
    pub(crate) frozen: bool,
    pub(crate) no_temperature: bool,
    pub(crate) silent: bool,
    pub(crate) forgetful: bool,
    pub(crate) pin: Option<bool>,
    /// Host time until which no transfer is answered, ns.
    pub(crate) unanswered_until_ns: u64,
    pub(crate) stretch_ns: u64,
    /// Bytes read since the start, which choose the flipped bits.
    bytes: u64,
}

impl Faults {
    /// Damages a byte that the part drives.
    pub(crate) fn damage(&mut self, byte: u8) -> u8 {
        self.bytes += 1;
        if self.stuck_low {
            return 0;
        }
        if self.stuck_high {
            return 0xff;
        }
        if self.flip == 0 {
            return byte;
        }
        let mut hash = self.bytes;
        for _ in 0..2 {
            hash = (hash ^ (hash >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
        let flips = (hash >> 8).is_multiple_of(self.flip);
        if flips { byte ^ (1 << (hash >> 61)) } else { byte }
    }
}
