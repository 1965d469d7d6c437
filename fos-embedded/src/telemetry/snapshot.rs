//! What a frame of a sample is written from.

use fos_core::{Scalar, Validity};
use heapless::Vec;

use super::SampleFrame;
use crate::hub::{AXES, Output};

/// What a hub made of a sample and what was logged with it, `LOGGED` quantities at most: all that its frame holds, to be
/// sent at once or kept.
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
    /// `logged` is [`Hub::logged`](crate::hub::Hub::logged); what is more than `LOGGED` of it is left out.
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

    /// The frame of the sample.
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
