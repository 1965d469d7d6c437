//! Gravity check: detects corrections of the accelerometers that lead away from gravity.
//!
//! At rest three accelerometers measure gravity in every orientation, apart from their biases. A model whose corrected
//! vector differs from |a| = g was fitted to other data: to two orientations, whose difference it takes for an error, or to
//! another part. Its own statistics do not show that, because it fits those data.

use fos_core::{GRAVITY_MPS2, Scalar, Validity};

use super::output::Output;

const SQUARE: f32 = GRAVITY_MPS2 * GRAVITY_MPS2;

/// Tolerated excess of | |corrected|² − g² | over | |measured|² − g² |: 2·g times 0.05 g, (m/s²)².
///
/// A correct model may lead away from gravity by as much as it subtracts: if a corrected error and an uncorrected one (a
/// scale factor, the bias in this orientation) cancel, the measured value is better by chance. A model subtracts deviations
/// from a mean, and a bias deviates from its mean by less than 0.05 g: 50 K at 1 mg/K, the worst coefficient of a data
/// sheet. `fos fit` separates orientations at twice this, so that a model fitted to data that it accepts is not flagged.
/// Noise is in both squares; means over [`SAMPLES`] are compared.
const TOLERANCE: f32 = 0.1 * SQUARE;

/// Interval of the checked samples, ticks: a sum of squares costs as much as two terms.
const EVERY: u32 = 8;

/// Number of checked samples per decision, 2.5 s at 200 Hz, so that vibration averages out.
const SAMPLES: u8 = 64;

/// |a|² − g², (m/s²)².
// not inlined: many library calls without an FPU
#[inline(never)]
fn excess<R: Scalar<Stored = f32>>([x, y, z]: &[R; 3]) -> R::Sum {
    let square = R::plus(R::plus(x.square(), y.square()), z.square());
    R::plus(square, R::sum_of(-SQUARE))
}

/// True if, at rest, the corrected specific force is further from gravity than the measured one by more than the tolerance
/// of a correct model; m/s². It compares single samples, which contain noise.
pub fn leads_away(measured: &[f32; 3], corrected: &[f32; 3]) -> bool {
    is_away::<f32>(excess(measured), excess(corrected), TOLERANCE)
}

#[inline]
fn is_away<R: Scalar<Stored = f32>>(measured: R::Sum, corrected: R::Sum, tolerance: f32) -> bool {
    let magnitude = |sum: R::Sum| if sum < R::NOTHING { -sum } else { sum };
    magnitude(corrected) > R::plus(magnitude(measured), R::sum_of(tolerance))
}

/// Sums over the samples of one rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gravity<R: Scalar> {
    measured: R::Sum,
    corrected: R::Sum,
    /// Samples until the next decision.
    left: u8,
    away: bool,
    /// A gap covered the tick of a check: the sample after it is checked instead.
    due: bool,
    /// `away` or `due`, so that a sample costs one test.
    attention: bool,
}

impl<R: Scalar<Stored = f32>> Gravity<R> {
    pub(super) const NEW: Self = Self {
        measured: R::NOTHING,
        corrected: R::NOTHING,
        left: SAMPLES,
        away: false,
        due: false,
        attention: false,
    };

    /// Notes a gap of `skipped` ticks before the sample at `tick`; a source with regular gaps could otherwise miss every
    /// check.
    pub(super) fn skip(&mut self, tick: u32, skipped: u32) {
        if (1..=skipped).contains(&(tick % EVERY)) {
            (self.due, self.attention) = (true, true);
        }
    }

    /// Processes a sample; at rest one per [`EVERY`] ticks counts. The decision holds until the next one.
    #[inline(always)]
    pub(super) fn update(&mut self, output: &mut Output<R>) {
        if !output.still {
            // a mean must not span two rests
            self.left = SAMPLES;
        } else if output.tick.is_multiple_of(EVERY) {
            self.add(output);
        }
        if self.attention {
            self.attend(output);
        }
    }

    #[cold]
    fn attend(&mut self, output: &mut Output<R>) {
        if core::mem::take(&mut self.due) && output.still {
            self.add(output);
        }
        self.attention = self.away;
        if !self.away {
            return;
        }
        for correction in output.corrections.iter_mut().take(3) {
            correction.validity |= Validity::AWAY_FROM_GRAVITY;
        }
    }

    #[inline(never)]
    fn add(&mut self, output: &Output<R>) {
        if self.left == SAMPLES {
            (self.measured, self.corrected) = (R::NOTHING, R::NOTHING);
        }
        // in the frame of the sensor: a calibration leads towards gravity whatever the model does
        let ([x, y, z, ..], [cx, cy, cz, ..]) = (&output.measured, &output.corrections);
        self.measured = R::plus(self.measured, excess(&[*x, *y, *z]));
        self.corrected = R::plus(self.corrected, excess(&[cx.corrected, cy.corrected, cz.corrected]));
        self.left -= 1;
        if self.left == 0 {
            self.left = SAMPLES;
            self.away = is_away::<R>(self.measured, self.corrected, f32::from(SAMPLES) * TOLERANCE);
            self.attention = self.away;
        }
    }
}
