//! Contents of the frame of a sample.

use fos_core::{Scalar, Validity};
use heapless::Vec;

use super::SampleFrame;
use crate::hub::{AXES, Output};

/// Output of a hub for one sample, with at most `LOGGED` logged quantities: the contents of its frame, to be sent at once
/// or buffered.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Snapshot<const LOGGED: usize> {
    tick: u32,
    still: bool,
    measured: [f32; AXES],
    innovations: [f32; AXES],
    validity: [Validity; AXES],
    logged: Vec<f32, LOGGED>,
}

impl<const LOGGED: usize> Snapshot<LOGGED> {
    /// Copies an output; `logged` is [`Hub::logged`](crate::hub::Hub::logged), of which the first `LOGGED` values are used.
    pub fn new<R: Scalar<Stored = f32>>(output: &Output<R>, logged: &[f32]) -> Self {
        let logged = logged.get(..logged.len().min(LOGGED)).unwrap_or(&[]);
        Self {
            tick: output.tick,
            still: output.still,
            measured: output.measured.map(R::stored),
            innovations: output.innovation(),
            validity: output.validity(),
            logged: Vec::from_slice(logged).unwrap_or_default(),
        }
    }

    /// Frame of the sample.
    pub fn frame(&self) -> SampleFrame<&[f32], &[Validity]> {
        SampleFrame {
            tick: self.tick,
            still: self.still,
            measured: &self.measured,
            quantities: &self.logged,
            innovations: &self.innovations,
            validity: &self.validity,
        }
    }
}
