//! Reads the records of an image, each with the code that docs/MODEL_FORMAT.md states for it.
//!
//! The host writes them with serde. Its visitors would take 3 KB more of a device's flash than these readers.

use super::{Head, Info};
use crate::{
    Axis, AxisParameters, Calibration, Channel, Factor, FittedOn, InnovationStatistics, Input, MAX_DEGREE,
    Quantity, Range, Source, StillnessLimits, Term, Transform, TriadCalibration,
};

/// Bytes that have not been read yet; `None` once they violated the format. Every value is then arbitrary, and a reader of
/// many records asks once, at their end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Records<'a>(pub(super) Option<&'a [u8]>);

/// A value with a stored form.
pub(super) trait Record {
    fn read(records: &mut Records<'_>) -> Self;
}

impl<'a> Records<'a> {
    pub(super) fn take<T: Record>(&mut self) -> T {
        T::read(self)
    }

    /// Reads a term; `None` if its factors are invalid.
    pub(super) fn term(&mut self) -> Option<Term<f32>> {
        let coefficient = self.take();
        let degree = usize::from(self.take::<u8>());
        let mut factors = [crate::y(0); MAX_DEGREE];
        let factors = factors.get_mut(..degree)?;
        for factor in factors.iter_mut() {
            *factor = self.take();
        }
        Term::try_new(coefficient, factors)
    }

    /// Reads the information. Text other than UTF-8 is empty; [`check_info`](Self::check_info) finds it.
    pub(super) fn info(&mut self) -> Info<'a> {
        let mut text = || core::str::from_utf8(self.text()).unwrap_or_default();
        Info { sensor: text(), quantities: text(), effects: text(), provenance: text() }
    }

    /// Reads the information and checks its text.
    pub(super) fn check_info(&mut self) {
        for _ in 0..4 {
            if !is_utf8(self.text()) {
                self.violated(());
            }
        }
    }

    /// Passes over `count` records.
    pub(super) fn skip<T: Record>(&mut self, count: u8) {
        for _ in 0..count {
            let _: T = self.take();
        }
    }

    /// Number of bytes that have not been read; `None` after a violation of the format.
    pub(super) fn left(&self) -> Option<usize> {
        self.0.map(<[u8]>::len)
    }

    pub(super) fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let split = self.0.and_then(<[u8]>::split_first_chunk::<N>);
        self.0 = split.map(|(_, rest)| rest);
        split.map_or([0; N], |(bytes, _)| *bytes)
    }

    fn text(&mut self) -> &'a [u8] {
        let length = self.varint(u32::BITS) as usize;
        let split = self.0.and_then(|bytes| bytes.split_at_checked(length));
        self.0 = split.map(|(_, rest)| rest);
        split.map_or(&[], |(text, _)| text)
    }

    /// Reads a number of at most `bits` bits, seven in a byte.
    #[inline(never)]
    fn varint(&mut self, bits: u32) -> u32 {
        let (mut number, mut shift) = (0, 0);
        while shift < bits {
            let byte: u8 = self.take();
            let digit = u32::from(byte & 0x7f);
            if digit.unbounded_shr(bits - shift) != 0 {
                break;
            }
            number |= digit << shift;
            if byte & 0x80 == 0 {
                return number;
            }
            shift += 7;
        }
        self.violated(0)
    }

    /// Discriminant of an enum.
    fn variant(&mut self) -> u32 {
        self.varint(u32::BITS)
    }

    /// Notes a violation of the format; returns `value`.
    fn violated<T>(&mut self, value: T) -> T {
        self.0 = None;
        value
    }
}

/// True for UTF-8. The check of the standard library is faster, and takes half a kilobyte more flash.
fn is_utf8(text: &[u8]) -> bool {
    let mut bytes = text.iter();
    while let Some(&first) = bytes.next() {
        let (following, smallest) = match first {
            0..0x80 => continue,
            0xc0..0xe0 => (1, 0x80),
            0xe0..0xf0 => (2, 0x800),
            0xf0..0xf8 => (3, 0x1_0000),
            _ => return false,
        };
        let mut code = u32::from(first) & (0x3f >> following);
        for _ in 0..following {
            let Some(&byte @ 0x80..0xc0) = bytes.next() else { return false };
            code = (code << 6) | u32::from(byte & 0x3f);
        }
        if code < smallest || char::from_u32(code).is_none() {
            return false;
        }
    }
    true
}

impl Record for u8 {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        let [byte] = records.bytes();
        byte
    }
}

impl Record for u16 {
    fn read(records: &mut Records<'_>) -> Self {
        records.varint(Self::BITS) as Self
    }
}

impl Record for f32 {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        Self::from_le_bytes(records.bytes())
    }
}

impl Record for f64 {
    fn read(records: &mut Records<'_>) -> Self {
        Self::from_le_bytes(records.bytes())
    }
}

impl<T: Record, const N: usize> Record for [T; N] {
    fn read(records: &mut Records<'_>) -> Self {
        core::array::from_fn(|_| records.take())
    }
}

impl<T: Record> Record for Option<T> {
    fn read(records: &mut Records<'_>) -> Self {
        match records.take::<u8>() {
            0 => None,
            1 => Some(records.take()),
            _ => records.violated(None),
        }
    }
}

impl Record for Head {
    fn read(records: &mut Records<'_>) -> Self {
        Self {
            period_s: records.take(),
            fitted_on: records.take(),
            stillness: records.take(),
            n_quantities: records.take(),
            n_inputs: records.take(),
            n_axes: records.take(),
        }
    }
}

impl Record for FittedOn {
    fn read(records: &mut Records<'_>) -> Self {
        match records.variant() {
            0 => Self::Raw,
            1 => Self::FactoryCorrected,
            _ => records.violated(Self::Raw),
        }
    }
}

impl Record for StillnessLimits<f32> {
    fn read(records: &mut Records<'_>) -> Self {
        Self {
            window: records.take(),
            accel_variance: records.take(),
            gyro_variance: records.take(),
            gyro_at_rest: records.take(),
            gyro_deviation: records.take(),
        }
    }
}

impl Record for Calibration<f32> {
    fn read(records: &mut Records<'_>) -> Self {
        Self { accel: records.take(), gyro: records.take() }
    }
}

impl Record for TriadCalibration<f32> {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        let mut triad = Self::IDENTITY;
        for element in triad.matrix.as_flattened_mut().iter_mut().chain(&mut triad.bias) {
            *element = records.take();
        }
        triad
    }
}

impl Record for Quantity {
    // not inlined, as the axis, the range and the input: each is read in several places
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        match records.variant() {
            0 => Self::Temperature,
            1 => Self::Supply,
            2 => Self::Load,
            3 => Self::MagneticX,
            4 => Self::MagneticY,
            5 => Self::MagneticZ,
            6 => Self::Measured(records.take()),
            7 => Self::Reference(records.take()),
            8 => Self::Other,
            _ => records.violated(Self::Other),
        }
    }
}

impl Record for Axis {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        match records.variant() {
            0 => Self::Ax,
            1 => Self::Ay,
            2 => Self::Az,
            3 => Self::Gx,
            4 => Self::Gy,
            5 => Self::Gz,
            6 => Self::Other,
            _ => records.violated(Self::Other),
        }
    }
}

impl Record for Range<f32> {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        Self { low: records.take(), high: records.take() }
    }
}

impl Record for Input<f32> {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        Self {
            source: records.take(),
            transform: records.take(),
            centre: records.take(),
            scale: records.take(),
            source_range: records.take(),
            range: records.take(),
        }
    }
}

impl Record for Source {
    fn read(records: &mut Records<'_>) -> Self {
        match records.variant() {
            0 => Self::Clock,
            1 => Self::Quantity(records.take()),
            2 => Self::Remainder(records.take()),
            _ => records.violated(Self::Clock),
        }
    }
}

impl Record for Transform<f32> {
    fn read(records: &mut Records<'_>) -> Self {
        let variant = records.variant();
        let parameter = if matches!(variant, 0 | 5 | 7) { 0.0 } else { records.take() };
        match variant {
            0 => Self::Identity,
            1 => Self::LowPass { tau_s: parameter },
            2 => Self::Rate { tau_s: parameter },
            3 => Self::Variance { tau_s: parameter },
            4 => Self::Backlash { half_width: parameter },
            5 => Self::Absolute,
            6 => Self::Decay { tau_s: parameter },
            7 => Self::Time,
            8 => Self::Sine { frequency_hz: parameter },
            9 => Self::Cosine { frequency_hz: parameter },
            _ => records.violated(Self::Identity),
        }
    }
}

impl Record for AxisParameters<f32> {
    #[inline(never)]
    fn read(records: &mut Records<'_>) -> Self {
        Self {
            axis: records.take(),
            reference: records.take(),
            offset: records.take(),
            scale: records.take(),
            constant: records.take(),
            range: records.take(),
            physical_range: records.take(),
            full_scale: records.take(),
            stuck_after_repeats: records.take(),
            gap_limit_samples: records.take(),
            coast_limit_s: records.take(),
            innovation: InnovationStatistics {
                mean: records.take(),
                variance: records.take(),
                lag_1_correlation: records.take(),
            },
        }
    }
}

impl Record for Factor {
    fn read(records: &mut Records<'_>) -> Self {
        Self { channel: records.take(), lag: records.take() }
    }
}

impl Record for Channel {
    fn read(records: &mut Records<'_>) -> Self {
        match records.variant() {
            0 => Self::Output,
            1 => Self::Input(records.take()),
            _ => records.violated(Self::Output),
        }
    }
}

#[cfg(test)]
mod tests {
    use core::fmt::Debug;
    use std::format;

    use proptest::prelude::*;
    use serde::Deserialize;

    use super::*;

    /// Reads `bytes` as `T` with postcard and as a record: the same value and rest, or both refuse.
    fn agrees<'a, T: Record + Deserialize<'a> + Debug>(bytes: &'a [u8]) -> Result<(), TestCaseError> {
        let mut records = Records(Some(bytes));
        let found: T = records.take();
        let found = records.0.map(|rest| format!("{found:?} {rest:?}"));
        let expected = postcard::take_from_bytes::<T>(bytes).ok();
        prop_assert_eq!(found, expected.map(|(value, rest)| format!("{value:?} {rest:?}")));
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        // small numbers are the discriminants; 0x80 and more go on in the next byte
        #[test]
        fn every_record_is_read_as_postcard_reads_it(
            bytes in prop::collection::vec(prop_oneof![0_u8..10, 0x80_u8..0x84, any::<u8>()], 0..120),
        ) {
            agrees::<Head>(&bytes)?;
            agrees::<Calibration<f32>>(&bytes)?;
            agrees::<Quantity>(&bytes)?;
            agrees::<Input<f32>>(&bytes)?;
            agrees::<AxisParameters<f32>>(&bytes)?;
            agrees::<Factor>(&bytes)?;
            agrees::<u16>(&bytes)?;
        }

        #[test]
        fn text_is_read_as_postcard_reads_it(
            bytes in prop::collection::vec(prop_oneof![0_u8..5, Just(b'a'), Just(0xc3), Just(0xa4)], 0..20),
        ) {
            let mut records = Records(Some(&bytes));
            let mut checked = records;
            checked.check_info();
            let info = records.info();
            let expected = postcard::take_from_bytes::<Info<'_>>(&bytes).ok();
            prop_assert_eq!(checked.0.map(|rest| (info, rest)), expected);
        }
    }

    #[test]
    fn finds_all_text_other_than_utf_8() {
        // all second bytes, and those at the ends of a range in the third and fourth place
        let ends = [0x00, 0x7f, 0x80, 0xbf, 0xc0, 0xff];
        for first in 0..=u8::MAX {
            for second in 0..=u8::MAX {
                for third in ends {
                    for fourth in ends {
                        let bytes = [first, second, third, fourth];
                        for length in 0..=bytes.len() {
                            let text = &bytes[..length];
                            assert_eq!(is_utf8(text), core::str::from_utf8(text).is_ok(), "{text:x?}");
                        }
                    }
                }
            }
        }
    }
}
