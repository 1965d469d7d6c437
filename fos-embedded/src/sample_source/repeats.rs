//! Is the sensor stuck?

use super::FifoFrame;

/// All six codes the same for so many samples in a row, 0.1 s: the noise of each axis of both parts is more than a
/// code, so that two in a row agree in all six by chance less than once in 10⁵, twenty in a row never.
const STUCK_AFTER: u8 = 20;

/// How often the same codes have come in a row.
#[derive(Debug)]
pub(super) struct Repeats {
    codes: Option<([i16; 3], [i16; 3])>,
    /// Samples in a row before this one with the same codes.
    before: u8,
}

impl Repeats {
    pub(super) const fn new() -> Self {
        Self { codes: None, before: 0 }
    }

    /// Whether the sensor is stuck, this frame included.
    pub(super) fn update(&mut self, frame: &FifoFrame) -> bool {
        let codes = Some((frame.accel, frame.gyro));
        self.before = if codes == self.codes { self.before.saturating_add(1) } else { 0 };
        self.codes = codes;
        self.before.saturating_add(1) >= STUCK_AFTER
    }

    /// The codes are others than just before.
    pub(super) fn is_none(&self) -> bool {
        self.before == 0
    }
}
