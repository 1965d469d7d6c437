//! Reads a model from an image. Everything is checked before anything is returned.

use serde::Deserialize;

use super::{
    AxisHead, CALIBRATED, CALIBRATION_LENGTH, HEADER_LENGTH, Head, ImageError, Info, MAGIC, VERSION, checksum,
};
use crate::evaluator::ModelHeader;
use crate::{
    AxisParameters, Calibration, Evaluator, Factor, FittedOn, Input, MAX_DEGREE, Predictor, Quantity, Scalar,
    StillnessLimits, Term, TriadCalibration,
};

/// A model image whose checksum and form have been checked. It borrows the bytes and copies nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Image<'a> {
    pub(super) head: Head,
    /// The calibration; empty if there is none.
    calibration: &'a [u8],
    /// The body after these: quantities, inputs, axes.
    pub(super) records: Records<'a>,
    pub(super) information: &'a [u8],
}

/// One axis of an image.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisImage<'a> {
    /// Scaling, limits and innovation statistics.
    pub parameters: AxisParameters<f32>,
    /// p: terms over inputs only.
    pub physical: Terms<'a>,
    /// r̂ without its constant.
    pub stochastic: Terms<'a>,
}

/// The terms of a part, read one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms<'a> {
    records: Records<'a>,
    left: u8,
}

impl<'a> Image<'a> {
    /// Reads an image.
    ///
    /// # Errors
    ///
    /// The first fault found; each kind has its own error. The capacities of the device are checked by
    /// [`predictor`](Self::predictor).
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ImageError> {
        let (header, rest) = bytes
            .split_at_checked(HEADER_LENGTH)
            .ok_or(ImageError::Truncated { needed: HEADER_LENGTH, found: bytes.len() })?;
        let mut header = Records(header);
        if header.bytes::<4>()? != MAGIC {
            return Err(ImageError::Magic);
        }
        let version = u16::from_le_bytes(header.bytes()?);
        if version != VERSION {
            return Err(ImageError::UnknownVersion(version));
        }
        let flags = u16::from_le_bytes(header.bytes()?);
        if flags & !CALIBRATED != 0 {
            return Err(ImageError::UnknownFlags(flags));
        }
        let body = header.length()?;
        let needed = HEADER_LENGTH.saturating_add(body).saturating_add(header.length()?);
        if bytes.len() < needed {
            return Err(ImageError::Truncated { needed, found: bytes.len() });
        }
        if bytes.len() > needed {
            return Err(ImageError::TrailingBytes { count: bytes.len() - needed });
        }
        let (stored, computed) = (u32::from_le_bytes(header.bytes()?), checksum(bytes));
        if stored != computed {
            return Err(ImageError::Checksum { stored, computed });
        }
        let (body, information) = rest.split_at_checked(body).ok_or(ImageError::Malformed)?;
        let mut records = Records(body);
        let head = records.take()?;
        let length = if flags & CALIBRATED != 0 { CALIBRATION_LENGTH } else { 0 };
        let (calibration, rest) = records.0.split_at_checked(length).ok_or(ImageError::Malformed)?;
        records.0 = rest;
        let image = Self { head, calibration, records, information };
        image.check_form()?;
        Ok(image)
    }

    /// Reads every record once, so that the iterators returned later cannot fail.
    #[inline(never)]
    fn check_form(&self) -> Result<(), ImageError> {
        let mut records = self.records;
        for _ in 0..self.head.n_quantities {
            records.take::<Quantity>()?;
        }
        for _ in 0..self.head.n_inputs {
            records.take::<Input<f32>>()?;
        }
        for axis in 0..usize::from(self.head.n_axes) {
            let head: AxisHead = records.take()?;
            for term in 0..usize::from(head.n_physical) + usize::from(head.n_stochastic) {
                records.term()?.ok_or(ImageError::Term { axis, term })?;
            }
        }
        records.end()?;
        let mut information = Records(self.information);
        information.take::<Info<'_>>()?;
        information.end()
    }

    /// Sample period T, s.
    pub fn period_s(&self) -> f64 {
        self.head.period_s
    }

    /// Processing of the measured values before the fit.
    pub fn fitted_on(&self) -> FittedOn {
        self.head.fitted_on
    }

    /// Limits below which the device counts as still; `None` if the data did not determine them.
    pub fn stillness(&self) -> Option<StillnessLimits<f32>> {
        self.head.stillness
    }

    /// Calibration of the triads, for the corrected values.
    // without serde, which would take half a kilobyte of flash, and with a stack frame of its own
    #[inline(never)]
    pub fn calibration(&self) -> Option<Calibration<f32>> {
        if self.calibration.is_empty() {
            return None;
        }
        let mut records = Records(self.calibration);
        let mut number = || records.bytes().map_or(f32::NAN, f32::from_le_bytes);
        let mut three = || [number(), number(), number()];
        let mut triad = || TriadCalibration { matrix: [three(), three(), three()], bias: three() };
        Some(Calibration { accel: triad(), gyro: triad() })
    }

    #[inline(never)]
    fn check_calibration(&self) -> Result<(), ImageError> {
        self.calibration().map_or(Ok(()), |calibration| Ok(calibration.check()?))
    }

    /// Names of the sensor, its quantities and effects, and the provenance of the model.
    pub fn info(&self) -> Info<'a> {
        Records(self.information).take().unwrap_or_default()
    }

    /// Logged quantities of a sample, in their order.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> + 'a {
        let mut records = self.records;
        (0..self.head.n_quantities).map_while(move |_| records.take().ok())
    }

    /// Inputs, in the order of the model.
    pub fn inputs(&self) -> impl Iterator<Item = Input<f32>> + 'a {
        let mut records = self.records;
        for _ in 0..self.head.n_quantities {
            let _ = records.take::<Quantity>();
        }
        (0..self.head.n_inputs).map_while(move |_| records.take().ok())
    }

    /// Axes, in the order of the model.
    pub fn axes(&self) -> impl Iterator<Item = AxisImage<'a>> + 'a {
        let mut records = self.records;
        for _ in 0..self.head.n_quantities {
            let _ = records.take::<Quantity>();
        }
        for _ in 0..self.head.n_inputs {
            let _ = records.take::<Input<f32>>();
        }
        (0..self.head.n_axes).map_while(move |_| records.axis())
    }

    /// A predictor for the model, in f32 as on the device, or in f64.
    ///
    /// # Errors
    ///
    /// The first fault of the model, or the first capacity that it exceeds.
    pub fn predictor<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
    ) -> Result<Predictor<R, AXES, INPUTS, TERMS, HISTORY>, ImageError>
    where
        R: Scalar,
    {
        let mut predictor = Predictor::empty();
        self.load(&mut predictor)?;
        Ok(predictor)
    }

    /// Loads the model into a predictor in place; it starts as at power-on.
    ///
    /// # Errors
    ///
    /// Those of [`predictor`](Self::predictor); `predictor` is then without a model.
    pub fn load<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        predictor: &mut Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    ) -> Result<(), ImageError>
    where
        R: Scalar,
    {
        self.load_evaluator(predictor.begin())
    }

    /// Loads the model into an evaluator in place; it starts as at power-on.
    ///
    /// # Errors
    ///
    /// Those of [`predictor`](Self::predictor); `evaluator` is then without a model.
    pub fn load_evaluator<
        R,
        const AXES: usize,
        const INPUTS: usize,
        const TERMS: usize,
        const HISTORY: usize,
    >(
        &self,
        evaluator: &mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    ) -> Result<(), ImageError>
    where
        R: Scalar,
    {
        let loaded = self.fill(evaluator);
        if loaded.is_err() {
            evaluator.clear();
        }
        loaded
    }

    // a separate function, so that its stack frame and that of the parsing do not add up
    #[inline(never)]
    fn fill<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        evaluator: &mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    ) -> Result<(), ImageError>
    where
        R: Scalar,
    {
        evaluator.begin(ModelHeader {
            period_s: self.head.period_s,
            n_quantities: usize::from(self.head.n_quantities),
            n_inputs: usize::from(self.head.n_inputs),
            n_axes: usize::from(self.head.n_axes),
        })?;
        if let Some(limits) = &self.head.stillness {
            limits.check()?;
        }
        self.check_calibration()?;
        for input in self.inputs() {
            evaluator.add_input(&input.convert())?;
        }
        for axis in self.axes() {
            let convert = |term: Term<f32>| term.convert();
            evaluator.add_axis(
                &axis.parameters.convert(),
                axis.physical.map(convert),
                axis.stochastic.map(convert),
            )?;
        }
        Ok(())
    }
}

impl Iterator for Terms<'_> {
    type Item = Term<f32>;

    fn next(&mut self) -> Option<Term<f32>> {
        self.left = self.left.checked_sub(1)?;
        self.records.term().ok().flatten()
    }
}

/// Formats the numbers of quantities, inputs and axes, not the model.
#[cfg(feature = "defmt")]
impl defmt::Format for Image<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        let Head { period_s, fitted_on, n_quantities, n_inputs, n_axes, .. } = self.head;
        defmt::write!(
            f,
            "Image {{ period_s: {=f64}, fitted_on: {}, quantities: {=u8}, inputs: {=u8}, axes: {=u8} }}",
            period_s,
            fitted_on,
            n_quantities,
            n_inputs,
            n_axes
        );
    }
}

/// Formats the number of remaining terms.
#[cfg(feature = "defmt")]
impl defmt::Format for Terms<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u8} terms", self.left);
    }
}

/// Bytes that have not been read yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Records<'a>(&'a [u8]);

impl<'a> Records<'a> {
    pub(super) fn take<T: Deserialize<'a>>(&mut self) -> Result<T, ImageError> {
        let (record, rest) = postcard::take_from_bytes(self.0).map_err(|_| ImageError::Malformed)?;
        self.0 = rest;
        Ok(record)
    }

    /// Reads a term; `None` if its factors are invalid.
    pub(super) fn term(&mut self) -> Result<Option<Term<f32>>, ImageError> {
        let coefficient = self.take()?;
        let degree = usize::from(self.take::<u8>()?);
        let mut factors = [crate::y(0); MAX_DEGREE];
        let Some(factors) = factors.get_mut(..degree) else { return Ok(None) };
        for factor in factors.iter_mut() {
            *factor = self.take::<Factor>()?;
        }
        Ok(Term::try_new(coefficient, factors))
    }

    /// Reads an axis whose form has been checked.
    #[inline(never)]
    fn axis(&mut self) -> Option<AxisImage<'a>> {
        let head: AxisHead = self.take().ok()?;
        let (physical, stochastic) = (self.terms(head.n_physical), self.terms(head.n_stochastic));
        Some(AxisImage { parameters: head.parameters, physical, stochastic })
    }

    #[inline(never)]
    fn terms(&mut self, count: u8) -> Terms<'a> {
        let terms = Terms { records: *self, left: count };
        for _ in 0..count {
            let _ = self.term();
        }
        terms
    }

    /// Number of bytes that have not been read.
    pub(super) fn left(&self) -> usize {
        self.0.len()
    }

    fn end(&self) -> Result<(), ImageError> {
        if self.0.is_empty() { Ok(()) } else { Err(ImageError::TrailingBytes { count: self.0.len() }) }
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], ImageError> {
        let (bytes, rest) = self.0.split_first_chunk::<N>().ok_or(ImageError::Malformed)?;
        self.0 = rest;
        Ok(*bytes)
    }

    fn length(&mut self) -> Result<usize, ImageError> {
        usize::try_from(u32::from_le_bytes(self.bytes()?)).map_err(|_| ImageError::Malformed)
    }
}
