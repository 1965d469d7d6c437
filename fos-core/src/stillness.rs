//! Stillness detector: decides between tracking and coasting.

use serde::{Deserialize, Serialize};

use crate::real::is_positive;
use crate::{ModelError, Real, Scalar};

/// Number of consecutive quiet windows after which the device counts as still.
const QUIET_WINDOWS: u8 = 2;

/// Factor on the variance limits beyond which stillness ends; between the limits and this the state stays (hysteresis).
const HYSTERESIS: f64 = 2.0;

/// Distance of a single sample that ends stillness at once, in standard deviations of the limit, which is the sum over
/// three axes. For three equal normal axes that is a sum of squares of 3·7² variances of one axis, which noise at the
/// limit never reaches (chi-squared, 3 degrees of freedom: once in 10³¹). Limits are set several times above the noise,
/// and a tap is far beyond them.
const JUMP: f64 = 7.0;

/// Limits within which a device counts as still. The variances are sums over three axes; the deviation is the length of
/// the vector.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StillnessLimits<R> {
    /// Samples in a window; at least 2.
    pub window: u16,
    /// Largest variance of the specific force within a window, (m/s²)².
    pub accel_variance: R,
    /// Largest variance of the angular rate within a window, (rad/s)².
    pub gyro_variance: R,
    /// Output of the gyros at rest, rad/s: their offsets.
    pub gyro_at_rest: [R; 3],
    /// Largest distance of the mean rate of a window from `gyro_at_rest`, rad/s. A slow steady rotation has no variance;
    /// this limit and the change of gravity between windows distinguish it from a bias.
    pub gyro_deviation: R,
}

impl<R: Real> StillnessLimits<R> {
    pub(crate) fn check(&self) -> Result<(), ModelError> {
        let positive = [self.accel_variance, self.gyro_variance, self.gyro_deviation];
        let valid = self.window >= 2
            && positive.into_iter().all(is_positive)
            && self.gyro_at_rest.into_iter().all(Scalar::is_finite);
        if valid { Ok(()) } else { Err(ModelError::Stillness) }
    }
}

/// Sums of one triad over the current window. Values are taken relative to an origin, so that f32 keeps its digits: the
/// mean of the previous window while the device is still, otherwise the first sample.
#[derive(Debug, Clone, Copy)]
struct Triad<R: Scalar> {
    origin: [R; 3],
    sum: [R::Sum; 3],
    sum_of_squares: R::Sum,
    /// Mean of the last complete window.
    mean: [R; 3],
}

impl<R: Scalar> Triad<R> {
    const EMPTY: Self =
        Self { origin: [R::ZERO; 3], sum: [R::NOTHING; 3], sum_of_squares: R::NOTHING, mean: [R::ZERO; 3] };

    fn begin(&mut self, origin: [R; 3]) {
        (self.origin, self.sum, self.sum_of_squares) = (origin, [R::NOTHING; 3], R::NOTHING);
    }

    /// Deviation of a value from the origin, and the sum of its squares.
    // unrolled: it runs for every sample
    #[inline(always)]
    fn deviation(&self, [x, y, z]: [R; 3]) -> ([R; 3], R::Sum) {
        let [origin_x, origin_y, origin_z] = self.origin;
        let (x, y, z) = (x - origin_x, y - origin_y, z - origin_z);
        ([x, y, z], R::plus(R::plus(x.square(), y.square()), z.square()))
    }

    #[inline(always)]
    fn add(&mut self, ([x, y, z], square): ([R; 3], R::Sum)) {
        let [sum_x, sum_y, sum_z] = self.sum;
        self.sum = [R::plus(sum_x, x.begin()), R::plus(sum_y, y.begin()), R::plus(sum_z, z.begin())];
        self.sum_of_squares = R::plus(self.sum_of_squares, square);
    }

    /// Ends the window. Returns its variance and the squared distance of its mean from that of the previous window.
    fn end(&mut self, per_window: R::Stored) -> (R::Stored, R::Stored) {
        let (mut square_of_mean, mut shift) = (R::Stored::ZERO, R::Stored::ZERO);
        for ((sum, origin), mean) in self.sum.iter().zip(self.origin).zip(self.mean.iter_mut()) {
            let deviation = R::sum_stored(*sum) * per_window;
            square_of_mean = square_of_mean + deviation * deviation;
            let now = origin.stored() + deviation;
            let step = now - mean.stored();
            shift = shift + step * step;
            *mean = R::of(now);
        }
        (R::sum_stored(self.sum_of_squares) * per_window - square_of_mean, shift)
    }
}

/// Decides for every sample whether the device is still: after two consecutive quiet windows, until the first window or
/// sample that is not quiet. Constant memory.
#[derive(Debug, Clone)]
pub struct StillnessDetector<R: Scalar> {
    limits: StillnessLimits<R::Stored>,
    per_window: R::Stored,
    accel: Triad<R>,
    gyro: Triad<R>,
    filled: u16,
    quiet_windows: u8,
    still: bool,
    /// Largest squared distance of a sample from the origin of the window: accelerometers, gyros.
    jump: [R::Sum; 2],
}

impl<R: Scalar> StillnessDetector<R> {
    /// A detector in the moving state.
    ///
    /// # Errors
    ///
    /// [`ModelError::Stillness`] if a limit is not positive or the window has fewer than two samples.
    pub fn new(limits: StillnessLimits<R::Stored>) -> Result<Self, ModelError> {
        limits.check()?;
        Ok(Self {
            limits,
            per_window: R::Stored::ONE / R::Stored::from_u32(u32::from(limits.window)),
            accel: Triad::EMPTY,
            gyro: Triad::EMPTY,
            filled: 0,
            quiet_windows: 0,
            still: false,
            jump: [R::sum_of(R::Stored::MAX); 2],
        })
    }

    /// Processes a sample: specific force in m/s², angular rate in rad/s. Returns true if the device is still.
    ///
    /// A value that is not finite counts as motion and restarts the window.
    pub fn update(&mut self, accel: [R; 3], gyro: [R; 3]) -> bool {
        let ([ax, ay, az], [gx, gy, gz]) = (accel, gyro);
        self.update_six(&[ax, ay, az, gx, gy, gz])
    }

    /// Same as [`update`](Self::update), with specific force x, y, z, then angular rate x, y, z in one array.
    pub fn update_six(&mut self, measured: &[R; 6]) -> bool {
        let [ax, ay, az, gx, gy, gz] = *measured;
        let (accel, gyro) = ([ax, ay, az], [gx, gy, gz]);
        if measured.iter().any(|value| value.is_absent()) {
            return self.disturbed();
        }
        if self.filled == 0 {
            self.begin_window(accel, gyro);
        }
        let (accel, gyro) = (self.accel.deviation(accel), self.gyro.deviation(gyro));
        let [accel_limit, gyro_limit] = self.jump;
        // false for values that are not finite
        if !(accel.1 <= accel_limit && gyro.1 <= gyro_limit) {
            return self.disturbed();
        }
        self.accel.add(accel);
        self.gyro.add(gyro);
        self.filled += 1;
        if self.filled >= self.limits.window {
            self.filled = 0;
            self.end_window();
        }
        self.still
    }

    /// Sets the origin of a window: the mean of the previous one while the device is still, and then a sample too far from
    /// it ends stillness; otherwise the first sample, without such a limit.
    #[inline(never)]
    fn begin_window(&mut self, accel: [R; 3], gyro: [R; 3]) {
        if self.still {
            self.accel.begin(self.accel.mean);
            self.gyro.begin(self.gyro.mean);
            let limit = R::Stored::from_f64(JUMP * JUMP);
            let limits = [self.limits.accel_variance, self.limits.gyro_variance];
            self.jump = limits.map(|variance| R::sum_of(limit * variance));
        } else {
            self.accel.begin(accel);
            self.gyro.begin(gyro);
            self.jump = [R::sum_of(R::Stored::MAX); 2];
        }
    }

    /// Ends stillness and restarts the window, for example after missing samples. Returns false.
    pub fn disturbed(&mut self) -> bool {
        (self.filled, self.quiet_windows, self.still) = (0, 0, false);
        false
    }

    fn end_window(&mut self) {
        let (accel_variance, accel_shift) = self.accel.end(self.per_window);
        let (gyro_variance, gyro_shift) = self.gyro.end(self.per_window);
        let limits = &self.limits;
        let from_rest = distance_squared(self.gyro.mean.map(R::stored), limits.gyro_at_rest);
        let wider = R::Stored::from_f64(if self.still { HYSTERESIS } else { 1.0 });
        let quiet = accel_variance <= wider * limits.accel_variance
            && gyro_variance <= wider * limits.gyro_variance
            && from_rest <= wider * wider * limits.gyro_deviation * limits.gyro_deviation;
        // the means of two quiet windows differ by far less than the noise within them
        let steady = self.quiet_windows == 0
            || (accel_shift <= limits.accel_variance && gyro_shift <= limits.gyro_variance);
        self.quiet_windows = match (quiet, steady) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => self.quiet_windows.saturating_add(1),
        };
        self.still = self.quiet_windows >= QUIET_WINDOWS;
    }
}

#[inline(always)]
fn distance_squared<R: Real>([ax, ay, az]: [R; 3], [bx, by, bz]: [R; 3]) -> R {
    let (x, y, z) = (ax - bx, ay - by, az - bz);
    x * x + y * y + z * z
}

#[cfg(feature = "defmt")]
impl<R: Scalar> defmt::Format for StillnessDetector<R> {
    fn format(&self, f: defmt::Formatter<'_>) {
        let (still, quiet_windows) = (self.still, self.quiet_windows);
        defmt::write!(
            f,
            "StillnessDetector {{ still: {=bool}, quiet_windows: {=u8} }}",
            still,
            quiet_windows
        );
    }
}
