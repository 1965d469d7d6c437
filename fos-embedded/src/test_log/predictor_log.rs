//! `FOSR`: a log of values in their units for a predictor.
//!
//! | header | type | |
//! |---|---|---|
//! | magic | 4 bytes | `FOSR` |
//! | version | u16 | 1 |
//! | n_axes | u8 | measured values of a record |
//! | n_quantities | u8 | logged quantities of a record |
//!
//! | record | type | |
//! |---|---|---|
//! | skipped | u32 | ticks without a sample before this one |
//! | motion | u32 | 0 moving, 1 still |
//! | measured | f32 × n_axes | in the unit and order of the model's axes; NaN where there is none |
//! | quantities | f32 × n_quantities | in the unit and order of the model's quantities; NaN where there is none |
//!
//! ```
//! use fos_embedded::hub::Motion;
//! use fos_embedded::test_log::{PredictorLogHeader, PredictorLogRecord};
//!
//! let header = PredictorLogHeader { n_axes: 1, n_quantities: 1 };
//! let record = PredictorLogRecord { skipped: 0, motion: Motion::Still, measured: &[0.012], quantities: &[21.5] };
//! let log: Vec<u8> = header.encode().into_iter().chain(record.encode()).collect();
//!
//! assert_eq!(PredictorLogHeader::decode(&log)?, header);
//! let (mut measured, mut quantities) = ([0.0; 1], [0.0; 1]);
//! let bytes = &log[PredictorLogHeader::LENGTH..];
//! assert_eq!(PredictorLogRecord::decode(bytes, &mut measured, &mut quantities)?, record);
//! # Ok::<(), fos_embedded::test_log::TestLogError>(())
//! ```

use fos_core::{Correction, Predictor, Sample};

use super::fields::{Fields, bytes_of};
use super::predictor_header::RECORD_LENGTH;
use super::{PredictorLogHeader, TestLogError};
use crate::hub::Motion;

/// One sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PredictorLogRecord<'a> {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Motion state of the device.
    pub motion: Motion,
    /// Measured value of every axis, in the model's order and units; NaN if absent.
    pub measured: &'a [f32],
    /// Value of every logged quantity, in the model's order and units; NaN if absent.
    pub quantities: &'a [f32],
}

impl PredictorLogHeader {
    /// Reads the header at the start of `log`.
    ///
    /// # Errors
    ///
    /// The magic or version is wrong, or the header is truncated.
    pub fn decode(log: &[u8]) -> Result<Self, TestLogError> {
        let mut fields = Fields::of_header(log, Self::LENGTH, Self::MAGIC, Self::VERSION)?;
        Ok(Self { n_axes: fields.u8()?, n_quantities: fields.u8()? })
    }

    /// Checks that the log has the axes and quantities that `model` needs.
    ///
    /// # Errors
    ///
    /// [`TestLogError::Mismatch`] if a number differs.
    pub fn check(&self, model: PredictorLogHeader) -> Result<(), TestLogError> {
        if *self == model { Ok(()) } else { Err(TestLogError::Mismatch { log: *self, model }) }
    }
}

impl<'a> PredictorLogRecord<'a> {
    /// Reads the record at the start of `bytes`. Its values are decoded into `measured` and `quantities`, whose lengths are
    /// those of the header.
    ///
    /// # Errors
    ///
    /// The record is truncated, or its motion state is invalid.
    pub fn decode(
        bytes: &[u8],
        measured: &'a mut [f32],
        quantities: &'a mut [f32],
    ) -> Result<Self, TestLogError> {
        let mut fields = Fields::of(bytes, RECORD_LENGTH + 4 * (measured.len() + quantities.len()));
        let skipped = fields.u32()?;
        let motion = match fields.u32()? {
            0 => Motion::Moving,
            1 => Motion::Still,
            _ => return Err(TestLogError::Field("motion")),
        };
        fields.values(measured)?;
        fields.values(quantities)?;
        Ok(Self { skipped, motion, measured, quantities })
    }

    /// Bytes of the record.
    pub fn encode(&self) -> impl Iterator<Item = u8> + '_ {
        let motion: u32 = match self.motion {
            Motion::Moving => 0,
            Motion::Still => 1,
        };
        let head = self.skipped.to_le_bytes().into_iter().chain(motion.to_le_bytes());
        head.chain(bytes_of(self.measured)).chain(bytes_of(self.quantities))
    }

    /// Passes the record to the predictor: skips the missing samples, then tracks or coasts. Returns one correction per axis.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn step<'p, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        predictor: &'p mut Predictor<f32, AXES, INPUTS, TERMS, HISTORY>,
    ) -> &'p [Correction<f32>] {
        if self.skipped > 0 {
            let _ = predictor.skip(self.skipped);
        }
        let sample = Sample { measured: self.measured, quantities: self.quantities };
        match self.motion {
            Motion::Still => predictor.track(&sample),
            Motion::Moving => predictor.coast(&sample),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use fos_core::{
        Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Quantity, Range, Term, y,
    };

    use super::*;

    const HEADER: PredictorLogHeader = PredictorLogHeader { n_axes: 2, n_quantities: 1 };
    const RECORD: PredictorLogRecord<'_> = PredictorLogRecord {
        skipped: 7,
        motion: Motion::Still,
        measured: &[1.5, -0.0],
        quantities: &[-3.25e-7],
    };

    #[test]
    fn decodes_encoded_records_with_trailing_bytes() {
        assert_eq!(PredictorLogHeader::decode(&HEADER.encode()), Ok(HEADER));
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        bytes.extend([0xff; 3]);
        let (mut measured, mut quantities) = ([0.0; 2], [0.0; 1]);
        let decoded = PredictorLogRecord::decode(&bytes, &mut measured, &mut quantities).unwrap();
        assert_eq!(decoded, RECORD);
        assert!(decoded.measured[1].is_sign_negative());
    }

    #[test]
    fn rejects_invalid_headers() {
        let bytes = HEADER.encode();
        for length in 4..PredictorLogHeader::LENGTH {
            let error = TestLogError::Truncated { needed: PredictorLogHeader::LENGTH, found: length };
            assert_eq!(PredictorLogHeader::decode(&bytes[..length]), Err(error));
        }
        let mut wrong = bytes;
        wrong[0] ^= 1;
        assert_eq!(PredictorLogHeader::decode(&wrong), Err(TestLogError::Magic("FOSR")));
        let mut newer = bytes;
        newer[4] = 2;
        assert_eq!(
            PredictorLogHeader::decode(&newer),
            Err(TestLogError::UnknownVersion { found: 2, read: 1 })
        );
    }

    #[test]
    fn rejects_truncated_and_invalid_records() {
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        for length in 0..bytes.len() {
            let error = TestLogError::Truncated { needed: bytes.len(), found: length };
            assert_eq!(
                PredictorLogRecord::decode(&bytes[..length], &mut [0.0; 2], &mut [0.0; 1]),
                Err(error)
            );
        }
        bytes[4] = 2;
        let (mut measured, mut quantities) = ([0.0; 2], [0.0; 1]);
        let wrong = PredictorLogRecord::decode(&bytes, &mut measured, &mut quantities);
        assert_eq!(wrong, Err(TestLogError::Field("motion")));
    }

    #[test]
    fn rejects_a_log_of_another_model() {
        let model = PredictorLogHeader { n_axes: 2, n_quantities: 2 };
        assert_eq!(HEADER.check(HEADER), Ok(()));
        assert_eq!(HEADER.check(model), Err(TestLogError::Mismatch { log: HEADER, model }));
    }

    const TERMS: [Term<f32>; 1] = [Term::new(0.5, &[y(1)])];
    const AXIS: AxisModel<'_, f32> = AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gx,
            reference: 0.0,
            offset: 0.0,
            scale: 1.0,
            constant: 0.0,
            range: Range::new(-4.0, 4.0),
            physical_range: Range::new(0.0, 0.0),
            full_scale: 0.0,
            stuck_after_repeats: 0,
            gap_limit_samples: 3,
            coast_limit_s: 1.0,
            innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
        },
        physical: &[],
        stochastic: &TERMS,
    };
    const MODEL: Model<'_, f32> = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[Quantity::Temperature],
        inputs: &[],
        axes: &[AXIS],
    };

    #[test]
    fn step_skips_then_tracks_or_coasts() {
        let mut replayed = Predictor::<f32, 1, 1, 1, 2>::new(&MODEL).unwrap();
        let mut direct = replayed.clone();
        for (skipped, motion, value) in [
            (0, Motion::Still, 1.0),
            (0, Motion::Still, 0.5),
            (2, Motion::Still, 0.25),
            (0, Motion::Moving, 3.0),
            (9, Motion::Moving, 2.0),
        ] {
            let record = PredictorLogRecord { skipped, motion, measured: &[value], quantities: &[20.0] };
            let sample = Sample { measured: &[value], quantities: &[20.0] };
            let _ = direct.skip(skipped);
            let expected = match motion {
                Motion::Still => direct.track(&sample),
                Motion::Moving => direct.coast(&sample),
            };
            assert_eq!(record.step(&mut replayed), expected);
        }
    }
}
