//! Detection of a stuck sensor.

use super::FifoFrame;

/// Consecutive samples with the same six codes from which a sensor counts as stuck, 0.1 s. The noise of each axis of all
/// parts exceeds one code, so two samples agree in all six by chance less than once in 10⁵, twenty never.
const STUCK_AFTER: u8 = 20;

/// Counts consecutive samples with the same codes.
#[derive(Debug)]
pub(super) struct Repeats {
    codes: Option<([i16; 3], [i16; 3])>,
    /// Consecutive earlier samples with the same codes.
    before: u8,
}

impl Repeats {
    pub(super) const fn new() -> Self {
        Self { codes: None, before: 0 }
    }

    /// Counts a frame; returns true if the sensor is stuck.
    pub(super) fn update(&mut self, frame: &FifoFrame) -> bool {
        let codes = Some((frame.accel, frame.gyro));
        self.before = if codes == self.codes { self.before.saturating_add(1) } else { 0 };
        self.codes = codes;
        self.before.saturating_add(1) >= STUCK_AFTER
    }

    /// True if the latest codes differ from the previous ones.
    pub(super) fn is_none(&self) -> bool {
        self.before == 0
    }
}
