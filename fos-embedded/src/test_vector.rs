//! Known samples, and the bits that a hub must make of them: does what runs here compute what was exported?
//!
//! `fos export` writes one with every model as source. Bits are compared, not values: the same source on a
//! machine with IEEE 754 arithmetic gives the same bits, so any difference is one of model, compiler or memory.

use core::fmt;

use crate::hub::{AXES, Hub, HubError, Motion, Output};
use crate::raw::{Faults, RawSample, Scales};

/// Samples, and what a hub makes of them from its first tick on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TestVector<'a> {
    /// What the codes mean: the hub is made with them. They need not be those of the real sensor.
    pub scales: Scales,
    /// The axes that are compared: 0, 1, 2 accelerometer x, y, z; 3, 4, 5 gyro x, y, z.
    pub channels: &'a [u8],
    /// The model's quantities that the application gives, by their index in the model.
    pub given: &'a [u8],
    /// The samples, in their order; the hub was just loaded.
    pub samples: &'a [TestSample],
    /// Bits of what is given before each sample: `samples × given`, row = sample.
    pub given_bits: &'a [u32],
    /// What must come out: `samples × channels`, row = sample.
    pub expected: &'a [Expected],
}

/// A sample of a [`TestVector`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TestSample {
    /// As the application says; stillness is not detected.
    pub motion: Motion,
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Codes of accelerometer x, y, z, gyro x, y, z.
    pub codes: [i16; AXES],
    /// Code of the thermometer; none where it is invalid.
    pub temperature: Option<i16>,
}

/// What an axis must come to, as bits of f32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Expected {
    /// Corrected value, m/s² or rad/s.
    pub corrected: u32,
    /// Innovation; 0x7FC00000 (NaN) where there is none.
    pub innovation: u32,
    /// What speaks against trusting it: [`Validity::bits`](fos_core::Validity::bits).
    pub validity: u16,
}

/// What is wrong with a model, or with the machine it runs on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CheckError {
    /// The hub does not take the model.
    Load(HubError),
    /// This sample, from 0, is the first that comes to something else.
    Deviates(usize),
}

impl TestVector<'_> {
    /// Runs the samples through `hub`, made with the vector's scales and just loaded with its model. Afterwards the
    /// hub stands where the samples have brought it.
    ///
    /// # Errors
    ///
    /// Index of the first sample of which one bit is not as expected.
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
                // an expectation that is not there is not met
                if expected.next() != Expected::of(output, *channel).as_ref() {
                    return Err(n);
                }
            }
        }
        Ok(())
    }
}

impl TestSample {
    /// The sample as a sensor gives it.
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
    /// Of an output; none if there is no such channel.
    pub fn of(output: &Output, channel: u8) -> Option<Self> {
        let axis = output.corrections.get(usize::from(channel))?;
        Some(Self {
            corrected: axis.corrected.to_bits(),
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
