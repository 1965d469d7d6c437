//! Reads a model from an image. Everything is checked before anything is returned.

use super::records::Records;
use super::{CALIBRATED, HEADER_LENGTH, Head, ImageError, Info, MAGIC, VERSION, checksum};
use crate::check::check_header;
use crate::evaluator::ModelHeader;
use crate::{
    AxisParameters, Calibration, Evaluator, FittedOn, Input, ModelError, Predictor, Quantity, Scalar,
    StillnessLimits, Term,
};

/// A model image whose checksum and form have been checked. It borrows the bytes and copies nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Image<'a> {
    pub(super) head: Head,
    /// The body from the calibration on, if there is one.
    calibration: Option<Records<'a>>,
    /// The body from the quantities on: quantities, inputs, axes.
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
    #[inline(never)]
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ImageError> {
        let (header, rest) = bytes
            .split_at_checked(HEADER_LENGTH)
            .ok_or(ImageError::Truncated { needed: HEADER_LENGTH, found: bytes.len() })?;
        let mut header = Records(Some(header));
        if header.bytes() != MAGIC {
            return Err(ImageError::Magic);
        }
        let version = u16::from_le_bytes(header.bytes());
        if version != VERSION {
            return Err(ImageError::UnknownVersion(version));
        }
        let flags = u16::from_le_bytes(header.bytes());
        if flags & !CALIBRATED != 0 {
            return Err(ImageError::UnknownFlags(flags));
        }
        let mut length = || u32::from_le_bytes(header.bytes()) as usize;
        let body = length();
        let needed = HEADER_LENGTH.saturating_add(body).saturating_add(length());
        if bytes.len() < needed {
            return Err(ImageError::Truncated { needed, found: bytes.len() });
        }
        if bytes.len() > needed {
            return Err(ImageError::TrailingBytes { count: bytes.len() - needed });
        }
        let (stored, computed) = (u32::from_le_bytes(header.bytes()), checksum(bytes));
        if stored != computed {
            return Err(ImageError::Checksum { stored, computed });
        }
        let (body, information) = rest.split_at_checked(body).ok_or(ImageError::Malformed)?;
        let mut records = Records(Some(body));
        let head = records.take();
        let calibration = (flags & CALIBRATED != 0).then_some(records);
        if calibration.is_some() {
            let _: Calibration<f32> = records.take();
        }
        let image = Self { head, calibration, records, information };
        image.check_form()?;
        Ok(image)
    }

    /// Reads every record once, so that the iterators returned later cannot fail.
    #[inline(never)]
    fn check_form(&self) -> Result<(), ImageError> {
        let mut records = self.records;
        records.skip::<Quantity>(self.head.n_quantities);
        records.skip::<Input<f32>>(self.head.n_inputs);
        for axis in 0..usize::from(self.head.n_axes) {
            records.skip::<AxisParameters<f32>>(1);
            let [n_physical, n_stochastic]: [u8; 2] = records.take();
            for term in 0..usize::from(n_physical) + usize::from(n_stochastic) {
                if records.term().is_none() && records.left().is_some() {
                    return Err(ImageError::Term { axis, term });
                }
            }
        }
        end(records)?;
        let mut information = Records(Some(self.information));
        information.check_info();
        end(information)
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
    pub fn calibration(&self) -> Option<Calibration<f32>> {
        self.calibration.map(|mut records| records.take())
    }

    // a separate function, for its stack frame
    #[inline(never)]
    fn check_calibration(&self) -> Result<(), ModelError> {
        self.calibration().map_or(Ok(()), |calibration| calibration.check())
    }

    /// Names of the sensor, its quantities and effects, and the provenance of the model.
    pub fn info(&self) -> Info<'a> {
        Records(Some(self.information)).info()
    }

    /// Logged quantities of a sample, in their order.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> + 'a {
        let mut records = self.records;
        (0..self.head.n_quantities).map(move |_| records.take())
    }

    /// Inputs, in the order of the model.
    pub fn inputs(&self) -> impl Iterator<Item = Input<f32>> + 'a {
        let mut records = self.records;
        records.skip::<Quantity>(self.head.n_quantities);
        (0..self.head.n_inputs).map(move |_| records.take())
    }

    /// Axes, in the order of the model.
    pub fn axes(&self) -> impl Iterator<Item = AxisImage<'a>> + 'a {
        let mut records = self.axis_records();
        (0..self.head.n_axes).map(move |_| axis(&mut records))
    }

    /// The body from the axes on.
    #[inline(never)]
    pub(super) fn axis_records(&self) -> Records<'a> {
        let mut records = self.records;
        records.skip::<Quantity>(self.head.n_quantities);
        records.skip::<Input<f32>>(self.head.n_inputs);
        records
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

    /// Loads the model into an evaluator or predictor in place; it starts as at power-on.
    ///
    /// # Errors
    ///
    /// Those of [`predictor`](Self::predictor); `evaluator` is then without a model.
    pub fn load<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        evaluator: &mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    ) -> Result<(), ImageError>
    where
        R: Scalar,
    {
        let loaded = self.fill(evaluator);
        evaluator.settle(loaded).map_err(ImageError::Model)
    }

    // a separate function, so that its stack frame and that of the parsing do not add up
    #[inline(never)]
    fn fill<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
        &self,
        evaluator: &mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    ) -> Result<(), ModelError>
    where
        R: Scalar,
    {
        check_header(self.head.period_s, usize::from(self.head.n_axes))?;
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
        let mut records = self.records;
        records.skip::<Quantity>(self.head.n_quantities);
        for _ in 0..self.head.n_inputs {
            let input: Input<f32> = records.take();
            evaluator.add_input::<true>(&input, &input.convert())?;
        }
        for _ in 0..self.head.n_axes {
            let axis = axis(&mut records);
            let convert = |term: Term<f32>| term.convert();
            evaluator.add_axis::<true>(
                &axis.parameters,
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
        self.records.term()
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

/// Reads an axis whose form has been checked.
#[inline(never)]
fn axis<'a>(records: &mut Records<'a>) -> AxisImage<'a> {
    let parameters = records.take();
    let [physical, stochastic] = records.take::<[u8; 2]>().map(|left| {
        let terms = Terms { records: *records, left };
        for _ in 0..left {
            let _ = records.term();
        }
        terms
    });
    AxisImage { parameters, physical, stochastic }
}

/// Checks that the records have the form of an image and end here.
fn end(records: Records<'_>) -> Result<(), ImageError> {
    match records.left() {
        Some(0) => Ok(()),
        Some(count) => Err(ImageError::TrailingBytes { count }),
        None => Err(ImageError::Malformed),
    }
}
