//! Conversion between the structures and numbers of the C interface and those of Rust.

use fos_core::{Axis, FittedOn, Quantity};

use super::{
    FOS_MOTION_DETECT, FOS_MOTION_MOVING, FOS_MOTION_STILL, FOS_QUANTITY_LOAD_PCT,
    FOS_QUANTITY_MAGNETIC_X_UT, FOS_QUANTITY_MAGNETIC_Y_UT, FOS_QUANTITY_MAGNETIC_Z_UT,
    FOS_QUANTITY_REFERENCE, FOS_QUANTITY_SUPPLY_V, FOS_VALUES_FACTORY_CORRECTED, FOS_VALUES_RAW, fos_motion,
    fos_output, fos_quantity, fos_raw_sample, fos_scales, fos_si_sample, fos_status,
};
use crate::hub::{Motion, Output, SIX};
use crate::raw::{Faults, RawSample, Scales, SiSample};

/// Largest full scale; larger ones are limited to it, because the code -32768 would overflow an f32.
const LARGEST_FULL_SCALE: f32 = 3.4027e38;

impl fos_scales {
    pub(super) fn of_full_scale(
        accel_mps2: f32,
        gyro_rads: f32,
        period_s: f64,
        values: u8,
    ) -> Result<Self, fos_status> {
        if !accel_mps2.is_finite() || !gyro_rads.is_finite() {
            return Err(fos_status::Argument);
        }
        let (accel, gyro) = (accel_mps2.min(LARGEST_FULL_SCALE), gyro_rads.min(LARGEST_FULL_SCALE));
        let of_full_scale = Scales::of_full_scale(accel, gyro, period_s, fitted_on(values)?);
        let Scales { accel_mps2, gyro_rads, temperature_k, temperature_zero_c, .. } = of_full_scale;
        let scales = Self { accel_mps2, gyro_rads, temperature_k, temperature_zero_c, period_s, values };
        // reject here what fos_hub_init() would reject
        scales.to_scales().map(|_| scales)
    }

    pub(super) fn to_scales(self) -> Result<Scales, fos_status> {
        let values = fitted_on(self.values)?;
        // the value of the largest code must be finite
        let largest = |scale: f32| (scale * 32_768.0).is_finite();
        let valid = self.accel_mps2 > 0.0
            && largest(self.accel_mps2)
            && self.gyro_rads > 0.0
            && largest(self.gyro_rads)
            && largest(self.temperature_k)
            && (self.temperature_k.abs() * 32_768.0 + self.temperature_zero_c.abs()).is_finite()
            && self.period_s > 0.0
            && self.period_s.is_finite();
        if !valid {
            return Err(fos_status::Argument);
        }
        Ok(Scales {
            accel_mps2: self.accel_mps2,
            gyro_rads: self.gyro_rads,
            temperature_k: self.temperature_k,
            temperature_zero_c: self.temperature_zero_c,
            period_s: self.period_s,
            values,
        })
    }
}

impl fos_raw_sample {
    pub(super) fn to_sample(self) -> RawSample {
        RawSample {
            skipped: self.skipped,
            accel: self.accel,
            gyro: self.gyro,
            temperature: (self.has_temperature != 0).then_some(self.temperature),
            faults: Faults::from_bits_truncate(self.faults),
        }
    }
}

impl fos_si_sample {
    pub(super) fn to_sample(self) -> SiSample {
        SiSample {
            skipped: self.skipped,
            accel: self.accel,
            gyro: self.gyro,
            temperature_c: self.temperature_c,
            faults: Faults::from_bits_truncate(self.faults),
        }
    }
}

impl From<&SiSample> for fos_si_sample {
    fn from(sample: &SiSample) -> Self {
        let SiSample { skipped, accel, gyro, temperature_c, faults } = *sample;
        Self { skipped, accel, gyro, temperature_c, faults: faults.bits() }
    }
}

impl From<&Output> for fos_output {
    fn from(output: &Output) -> Self {
        Self {
            tick: output.tick,
            measured: output.measured,
            corrected: output.corrected(),
            innovation: output.innovation(),
            temperature_c: output.temperature_c,
            validity: output.validity().map(|validity| validity.bits()),
            faults: output.faults.bits(),
            still: u8::from(output.still),
            drift: u8::from(output.drift),
        }
    }
}

fn fitted_on(values: u8) -> Result<FittedOn, fos_status> {
    match values {
        FOS_VALUES_RAW => Ok(FittedOn::Raw),
        FOS_VALUES_FACTORY_CORRECTED => Ok(FittedOn::FactoryCorrected),
        _ => Err(fos_status::Argument),
    }
}

pub(super) fn motion_of(motion: fos_motion) -> Result<Option<Motion>, fos_status> {
    match motion {
        FOS_MOTION_DETECT => Ok(None),
        FOS_MOTION_MOVING => Ok(Some(Motion::Moving)),
        FOS_MOTION_STILL => Ok(Some(Motion::Still)),
        _ => Err(fos_status::Argument),
    }
}

pub(super) fn axis_of(axis: usize) -> Result<Axis, fos_status> {
    SIX.get(axis).copied().ok_or(fos_status::Argument)
}

pub(super) fn quantity_of(quantity: fos_quantity) -> Result<Quantity, fos_status> {
    match quantity {
        FOS_QUANTITY_SUPPLY_V => Ok(Quantity::Supply),
        FOS_QUANTITY_LOAD_PCT => Ok(Quantity::Load),
        FOS_QUANTITY_MAGNETIC_X_UT => Ok(Quantity::MagneticX),
        FOS_QUANTITY_MAGNETIC_Y_UT => Ok(Quantity::MagneticY),
        FOS_QUANTITY_MAGNETIC_Z_UT => Ok(Quantity::MagneticZ),
        reference @ FOS_QUANTITY_REFERENCE.. => {
            axis_of(usize::from(reference - FOS_QUANTITY_REFERENCE)).map(Quantity::Reference)
        }
        _ => Err(fos_status::Argument),
    }
}
