//! Frames and batches read from a FIFO.

use heapless::Vec;

/// Most samples per poll: 160 ms at 200 Hz.
pub const MAX_SAMPLES: usize = 32;

/// FIFO contents of one instant; axes x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FifoFrame {
    /// Codes of the accelerometers.
    pub accel: [i16; 3],
    /// Codes of the gyros.
    pub gyro: [i16; 3],
    /// Latest code of the thermometer; `None` if it has no valid value.
    pub temperature: Option<i16>,
    /// Timestamp of the sensor, in counts of its clock; wraps.
    pub stamp: u32,
    /// Number of incomplete frames directly before this one.
    pub damaged: u16,
}

/// Frames read from a FIFO in one poll.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Batch {
    /// Complete frames, oldest first.
    pub frames: Vec<FifoFrame, MAX_SAMPLES>,
    /// The FIFO overran since the previous poll.
    pub overrun: bool,
    /// Number of incomplete frames after the last complete one.
    pub damaged: u16,
    /// Number of frames left in the FIFO.
    pub left: u16,
}

impl Batch {
    /// A batch without frames.
    pub const fn new() -> Self {
        Self { frames: Vec::new(), overrun: false, damaged: 0, left: 0 }
    }

    /// Number of frames that still fit.
    pub fn room(&self) -> usize {
        MAX_SAMPLES.saturating_sub(self.frames.len())
    }

    /// Adds a complete frame; there must be [room](Self::room).
    pub fn push(&mut self, accel: [i16; 3], gyro: [i16; 3], temperature: Option<i16>, stamp: u32) {
        let damaged = core::mem::take(&mut self.damaged);
        let _ = self.frames.push(FifoFrame { accel, gyro, temperature, stamp, damaged });
    }

    /// Counts an incomplete frame.
    pub fn tear(&mut self) {
        self.damaged = self.damaged.saturating_add(1);
    }

    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}
