//! Does what is taken out of the accelerometers lead away from gravity?
//!
//! At rest three accelerometers show gravity, whatever the pose, but for their biases. A model that makes of |a| = g
//! something else was fitted to something else: to two poses, whose difference it takes for an error, or to another
//! part. Nothing in its own statistics shows that: it fits.

use fos_core::{GRAVITY_MPS2, Scalar, Validity};

use super::output::Output;

const SQUARE: f32 = GRAVITY_MPS2 * GRAVITY_MPS2;

/// How much further from g² than the square of what was measured the square of what is left may be: 2·g times 0.05 g.
///
/// A sound model may lead away from gravity by what it takes off: where two errors of an axis cancel, one that is not
/// corrected (a scale, the bias in this pose) and one that is, the measured value is the better one by chance. What a
/// model takes off is a deviation from a mean, and a bias deviates from its mean by less than 0.05 g: 50 K at 1 mg/K,
/// the worst coefficient of a data sheet. Twice this makes two poses for `fos fit`, so that a model fitted to
/// what it lets pass is not flagged. Noise is in both squares and means over [`SAMPLES`] are compared.
const TOLERANCE: f32 = 0.1 * SQUARE;

/// One sample in so many is looked at: a sum of squares costs as much as two terms.
const EVERY: u32 = 8;

/// So many make a verdict, 2.5 s at 200 Hz: vibration averages out.
const SAMPLES: u8 = 64;

/// |a|² − g², (m/s²)²
// once in the code: it is many calls where floats are soft
#[inline(never)]
fn excess(force: &[f32; 3]) -> f32 {
    let [x, y, z] = *force;
    x * x + y * y + z * z - SQUARE
}

/// Whether at rest the corrected specific force is further from gravity than the measured one by more than a sound
/// model can lead it; by one sample, of which a single one may be noise. m/s².
pub fn leads_away(measured: &[f32; 3], corrected: &[f32; 3]) -> bool {
    is_away(excess(measured), excess(corrected), TOLERANCE)
}

#[inline]
fn is_away(measured: f32, corrected: f32, tolerance: f32) -> bool {
    corrected.abs() > measured.abs() + tolerance
}

/// Looks at the samples of a rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gravity {
    measured: f32,
    corrected: f32,
    /// Samples to come until the next verdict.
    left: u8,
    away: bool,
}

impl Gravity {
    pub(super) const NEW: Self = Self { measured: 0.0, corrected: 0.0, left: SAMPLES, away: false };

    /// A sample, of which every [`EVERY`]th at rest counts. The verdict stays until the next.
    #[inline(always)]
    pub(super) fn look_at<R: Scalar<Stored = f32>>(&mut self, output: &mut Output<R>) {
        if !output.still {
            // no mean over two rests
            self.left = SAMPLES;
        } else if output.tick.is_multiple_of(EVERY) {
            self.add(output);
        }
        if self.away {
            Self::flag(output);
        }
    }

    #[cold]
    fn flag<R>(output: &mut Output<R>) {
        for correction in output.corrections.iter_mut().take(3) {
            correction.validity |= Validity::AWAY_FROM_GRAVITY;
        }
    }

    #[inline(never)]
    fn add<R: Scalar<Stored = f32>>(&mut self, output: &Output<R>) {
        if self.left == SAMPLES {
            (self.measured, self.corrected) = (0.0, 0.0);
        }
        let [x, y, z, ..] = output.measured;
        self.measured += excess(&[x, y, z].map(R::stored));
        self.corrected += excess(&output.accel());
        self.left -= 1;
        if self.left == 0 {
            self.left = SAMPLES;
            self.away = is_away(self.measured, self.corrected, f32::from(SAMPLES) * TOLERANCE);
        }
    }
}
