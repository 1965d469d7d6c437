//! Stillness detector: decides between tracking and coasting.

use serde::{Deserialize, Serialize};

use crate::{ModelError, Scalar};

/// Number of consecutive quiet windows after which the device counts as still.
const QUIET_WINDOWS: u8 = 2;

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

    /// Deviation of a value from the origin, and its squared length.
    #[inline(always)]
    fn deviation(&self, value: [R; 3]) -> ([R; 3], R::Sum) {
        let deviation = difference(value, self.origin);
        (deviation, length_squared(deviation))
    }

    #[inline(always)]
    fn add(&mut self, ([x, y, z], square): ([R; 3], R::Sum)) {
        let [sum_x, sum_y, sum_z] = self.sum;
        // overflow only where the sum of squares saturates
        self.sum = [R::add_value(sum_x, x), R::add_value(sum_y, y), R::add_value(sum_z, z)];
        self.sum_of_squares = R::plus(self.sum_of_squares, square);
    }

    /// Ends the window. Returns its variance and the squared distance of its mean from that of the previous window.
    // not inlined: one copy for both triads
    #[inline(never)]
    fn end(&mut self, per_window: R::Gain) -> (R::Sum, R::Sum) {
        let deviation = self.sum.map(|sum| R::end(R::share(sum, per_window)));
        let ([x, y, z], [dx, dy, dz]) = (self.origin, deviation);
        let mean = [x + dx, y + dy, z + dz];
        let shift = length_squared(difference(mean, self.mean));
        self.mean = mean;
        (R::plus(R::share(self.sum_of_squares, per_window), -length_squared(deviation)), shift)
    }
}

// unrolled, as is the next: they run for every sample
#[inline(always)]
fn difference<R: Scalar>([ax, ay, az]: [R; 3], [bx, by, bz]: [R; 3]) -> [R; 3] {
    [ax - bx, ay - by, az - bz]
}

#[inline(always)]
fn length_squared<R: Scalar>([x, y, z]: [R; 3]) -> R::Sum {
    R::plus(R::plus(x.square(), y.square()), z.square())
}

/// Constants of a detector.
#[derive(Debug, Clone, Copy)]
struct Limits<R: Scalar> {
    window: u16,
    per_window: R::Gain,
    accel_variance: R::Sum,
    gyro_variance: R::Sum,
    gyro_at_rest: [R; 3],
    gyro_deviation_squared: R::Sum,
    /// Squared distances of a sample from the mean of the previous window that end stillness: accelerometers, gyros.
    jump: [R::Sum; 2],
}

impl<R: Scalar> Limits<R> {
    fn new(limits: &StillnessLimits<R::Stored>) -> Self {
        let (accel, gyro, deviation) = (limits.accel_variance, limits.gyro_variance, limits.gyro_deviation);
        let jump = R::Stored::from_f64(JUMP * JUMP);
        // together, so that fixed point has one copy of the conversion
        let sums = [accel, gyro, deviation * deviation, jump * accel, jump * gyro].map(R::sum_of);
        let [accel_variance, gyro_variance, gyro_deviation_squared, jump @ ..] = sums;
        Self {
            window: limits.window,
            per_window: R::gain((R::Built::ONE / R::Built::from_u32(u32::from(limits.window))).to_f64()),
            accel_variance,
            gyro_variance,
            gyro_at_rest: limits.gyro_at_rest.map(R::of),
            gyro_deviation_squared,
            jump,
        }
    }
}

/// Decides for every sample whether the device is still: after two consecutive quiet windows, until the first window or
/// sample that is not quiet. Constant memory.
#[derive(Debug, Clone)]
pub struct StillnessDetector<R: Scalar> {
    limits: Limits<R>,
    accel: Triad<R>,
    gyro: Triad<R>,
    filled: u16,
    quiet_windows: u8,
    still: bool,
}

impl<R: Scalar> StillnessDetector<R> {
    /// A detector in the moving state.
    ///
    /// # Errors
    ///
    /// [`ModelError::Stillness`] if a limit is not positive or the window has fewer than two samples.
    pub fn new(limits: StillnessLimits<R::Stored>) -> Result<Self, ModelError> {
        limits.convert::<f32>().check()?;
        Ok(Self::of_loaded(limits))
    }

    /// A detector in the moving state, with the limits of a loaded model: they were checked with the model and are not
    /// checked again. With limits that [`new`](Self::new) refuses, its decisions have no meaning.
    pub fn of_loaded(limits: StillnessLimits<R::Stored>) -> Self {
        Self {
            limits: Limits::new(&limits),
            accel: Triad::EMPTY,
            gyro: Triad::EMPTY,
            filled: 0,
            quiet_windows: 0,
            still: false,
        }
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
        let [accel_limit, gyro_limit] = if self.still { self.limits.jump } else { [R::LARGEST_SUM; 2] };
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

    /// Sets the origin of a window: the mean of the previous one while the device is still, otherwise the first sample.
    #[inline(never)]
    fn begin_window(&mut self, accel: [R; 3], gyro: [R; 3]) {
        if self.still {
            self.accel.begin(self.accel.mean);
            self.gyro.begin(self.gyro.mean);
        } else {
            self.accel.begin(accel);
            self.gyro.begin(gyro);
        }
    }

    /// Ends stillness and restarts the window, for example after missing samples. Returns false.
    pub fn disturbed(&mut self) -> bool {
        (self.filled, self.quiet_windows, self.still) = (0, 0, false);
        false
    }

    fn end_window(&mut self) {
        let limits = &self.limits;
        let (accel_variance, accel_shift) = self.accel.end(limits.per_window);
        let (gyro_variance, gyro_shift) = self.gyro.end(limits.per_window);
        let from_rest = length_squared(difference(self.gyro.mean, limits.gyro_at_rest));
        // hysteresis: stillness ends beyond twice the variances and the deviation
        let wider = |limit| if self.still { R::plus(limit, limit) } else { limit };
        // a saturated sum has no variance
        let bounded = self.accel.sum_of_squares < R::LARGEST_SUM && self.gyro.sum_of_squares < R::LARGEST_SUM;
        let quiet = bounded
            && accel_variance <= wider(limits.accel_variance)
            && gyro_variance <= wider(limits.gyro_variance)
            && from_rest <= wider(wider(limits.gyro_deviation_squared));
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
