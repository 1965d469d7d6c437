//! Test vectors: known samples with the bits that a hub must compute from them, to verify an exported model on the device.
//!
//! `fos export` writes one with every model exported as source. Bits are compared, not values: on every machine with
//! IEEE 754 arithmetic the same source gives the same bits, so a difference comes from the model, the compiler or memory.

use core::fmt;

use crate::hub::{AXES, Hub, HubError, Motion, Output};
use crate::raw::{Faults, RawSample, Scales};

/// Samples and the expected output of a hub from its first tick on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TestVector<'a> {
    /// Scales to create the hub with. They need not be those of the real sensor.
    pub scales: Scales,
    /// Compared axes: 0, 1, 2 accelerometer x, y, z; 3, 4, 5 gyro x, y, z.
    pub channels: &'a [u8],
    /// Indices in the model of the quantities that the application gives.
    pub given: &'a [u8],
    /// Samples in order, for a hub that was just loaded.
    pub samples: &'a [TestSample],
    /// Bits of the quantities given before each sample: `samples × given`, row = sample.
    pub given_bits: &'a [u32],
    /// Expected output: `samples × channels`, row = sample.
    pub expected: &'a [Expected],
}

/// A sample of a [`TestVector`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TestSample {
    /// Motion state set by the application; the detector is not used.
    pub motion: Motion,
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Codes of accelerometer x, y, z, gyro x, y, z.
    pub codes: [i16; AXES],
    /// Code of the thermometer; `None` if invalid.
    pub temperature: Option<i16>,
}

/// Expected output of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Expected {
    /// Corrected value, m/s² or rad/s, as bits of f32.
    pub corrected: u32,
    /// Innovation as bits of f32; 0x7FC00000 (NaN) if there is none.
    pub innovation: u32,
    /// Bits of the validity: [`Validity::bits`](fos_core::Validity::bits).
    pub validity: u16,
}

/// Fault of a model, or of the machine it runs on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CheckError {
    /// The hub rejects the model.
    Load(HubError),
    /// Index, from 0, of the first sample with a different output.
    Deviates(usize),
}

impl TestVector<'_> {
    /// Runs the samples through `hub`, which must be created with the vector's scales and just loaded with its model. The
    /// hub keeps the state after the last sample.
    ///
    /// # Errors
    ///
    /// Index of the first sample with a bit that is not as expected.
    pub fn run<const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        hub: &mut Hub<INPUTS, TERMS, HISTORY>,
    ) -> Result<(), usize> {
        let mut expected = self.expected.iter();
        let mut given_bits = self.given_bits.iter();
        for (n, sample) in self.samples.iter().enumerate() {
            for (nth, bits) in (0..self.given.len()).zip(&mut given_bits) {
                hub.give_application(nth, f32::from_bits(*bits));
            }
            hub.set_motion(Some(sample.motion));
            let output = hub.update(&sample.raw());
            for channel in self.channels {
                // a missing expectation counts as a difference
                if expected.next() != Expected::of(output, *channel).as_ref() {
                    return Err(n);
                }
            }
        }
        Ok(())
    }
}

impl TestSample {
    /// The sample in the form of a sensor.
    pub fn raw(&self) -> RawSample {
        let [ax, ay, az, gx, gy, gz] = self.codes;
        RawSample {
            skipped: self.skipped,
            accel: [ax, ay, az],
            gyro: [gx, gy, gz],
            temperature: self.temperature,
            faults: Faults::empty(),
        }
    }
}

impl Expected {
    /// Values of one channel of an output; `None` if there is no such channel.
    pub fn of(output: &Output, channel: u8) -> Option<Self> {
        let axis = output.corrections.get(usize::from(channel))?;
        Some(Self {
            corrected: output.corrected().get(usize::from(channel))?.to_bits(),
            innovation: axis.innovation.unwrap_or(f32::NAN).to_bits(),
            validity: axis.validity.bits(),
        })
    }
}

impl From<HubError> for CheckError {
    fn from(error: HubError) -> Self {
        Self::Load(error)
    }
}

impl fmt::Display for CheckError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Load(error) => write!(f, "{error}"),
            Self::Deviates(sample) => write!(f, "sample {sample} of the test vector comes to something else"),
        }
    }
}

impl core::error::Error for CheckError {}
