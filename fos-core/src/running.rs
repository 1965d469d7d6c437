//! Coefficients and state of a transform.

use crate::exponential::exp_m1;
use crate::real::scalar;
use crate::turn::sin_cos_of_cycles;
use crate::{Scalar, Transform};

/// A first-order low-pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LowPass<R: Scalar> {
    gain: R::Gain,
    slow: R::Slow,
}

impl<R: Scalar> LowPass<R> {
    fn new(tau_s: R::Stored, period_s: f64) -> Self {
        Self { gain: R::gain(-exp_m1(-period_s / tau_s.to_f64())), slow: R::ZERO.at_rest() }
    }

    fn start_at(&mut self, value: R) {
        self.slow = value.at_rest();
    }

    fn value(&self) -> R {
        R::now(self.slow)
    }

    #[inline]
    fn update(&mut self, x: R) -> R {
        x.approached_by(&mut self.slow, self.gain);
        self.value()
    }

    /// State of the low-pass.
    #[cfg(feature = "coasts")]
    pub(crate) fn slow(&self) -> R::Slow {
        self.slow
    }

    /// Updates one state per lane.
    #[cfg(feature = "coasts")]
    #[inline(always)]
    pub(crate) fn update_lanes<const LANES: usize>(
        &self,
        slow: &mut [R::Slow; LANES],
        x: &[R; LANES],
    ) -> [R; LANES] {
        let mut values = *x;
        for lane in 0..LANES {
            x[lane].approached_by(&mut slow[lane], self.gain);
            values[lane] = R::now(slow[lane]);
        }
        values
    }

    /// Equivalent of `ticks` updates with the same `x`, in closed form.
    fn skip(&mut self, x: R, ticks: u32) {
        let (x, value) = (x.stored(), self.value().stored());
        self.start_at(R::of(value + (x - value) * self.closed(ticks)));
    }

    fn gain(&self) -> R::Stored {
        scalar(R::gain_to_f64(self.gain))
    }

    /// Share of the distance to a constant x that n updates close: 1 − (1 − g)ⁿ, built up from
    /// h(a + b) = h(a) + h(b) − h(a)·h(b) in at most 32 doublings. Computing 1 − g would lose digits of a small gain: with
    /// τ = 1000 s at 200 Hz and f32, 0.5 % of the time constant.
    fn closed(&self, ticks: u32) -> R::Stored {
        let (mut closed, mut doubled, mut left) = (R::Stored::ZERO, self.gain(), ticks);
        while left > 0 {
            if left & 1 == 1 {
                closed = closed + doubled - closed * doubled;
            }
            doubled = doubled + doubled - doubled * doubled;
            left >>= 1;
        }
        closed
    }
}

/// A transform with its coefficients and state.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Running<R: Scalar> {
    Identity,
    LowPass(LowPass<R>),
    Rate {
        low_pass: LowPass<R>,
        per_tau: R::Gain,
    },
    Variance {
        mean: LowPass<R>,
        variance: LowPass<R>,
    },
    Backlash {
        half_width: R,
        play: R,
    },
    Absolute,
    /// A low-pass from 1 towards 0, for its precision.
    Decay(LowPass<R>),
    Time {
        period: R::Gain,
        origin: R,
        ticks: u32,
    },
    Oscillator {
        rotation: Complex<R>,
        phasor: Complex<R>,
        wants_sine: bool,
    },
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Complex<R> {
    re: R,
    im: R,
}

impl<R: Scalar> Complex<R> {
    const ONE: Self = Self { re: R::ONE, im: R::ZERO };

    #[inline]
    fn times(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl<R: Scalar> Running<R> {
    /// The transform at power-on. `scale` and `centre` belong to the input (x = (logged − centre)/scale).
    pub(crate) fn new(
        transform: &Transform<R::Stored>,
        period_s: f64,
        centre: R::Stored,
        scale: R::Stored,
    ) -> Self {
        let (centre, scale) = (centre.to_f64(), scale.to_f64());
        match *transform {
            Transform::Identity => Self::Identity,
            Transform::LowPass { tau_s } => Self::LowPass(LowPass::new(tau_s, period_s)),
            Transform::Rate { tau_s } => {
                Self::Rate { low_pass: LowPass::new(tau_s, period_s), per_tau: R::gain(1.0 / tau_s.to_f64()) }
            }
            Transform::Variance { tau_s } => Self::Variance {
                mean: LowPass::new(tau_s, period_s),
                variance: LowPass::new(tau_s, period_s),
            },
            Transform::Backlash { half_width } => {
                Self::Backlash { half_width: R::from_f64(half_width.to_f64() / scale), play: R::ZERO }
            }
            Transform::Absolute => Self::Absolute,
            Transform::Decay { tau_s } => {
                let mut low_pass = LowPass::new(tau_s, period_s);
                low_pass.start_at(R::ONE);
                Self::Decay(low_pass)
            }
            Transform::Time => Self::Time {
                period: R::gain(period_s / scale),
                origin: R::from_f64(centre / scale),
                ticks: 0,
            },
            Transform::Sine { frequency_hz } => Self::oscillator(frequency_hz, period_s, true),
            Transform::Cosine { frequency_hz } => Self::oscillator(frequency_hz, period_s, false),
        }
    }

    fn oscillator(frequency_hz: R::Stored, period_s: f64, wants_sine: bool) -> Self {
        let (sin, cos) = sin_cos_of_cycles(frequency_hz.to_f64() * period_s);
        let rotation = Complex { re: R::from_f64(cos), im: R::from_f64(sin) };
        Self::Oscillator { rotation, phasor: Complex::ONE, wants_sine }
    }

    /// Starts a transform with memory in the steady state of a constant `x`.
    pub(crate) fn start_at(&mut self, x: R) {
        match self {
            Self::LowPass(low_pass) | Self::Rate { low_pass, .. } => low_pass.start_at(x),
            Self::Variance { mean, variance } => {
                mean.start_at(x);
                variance.start_at(R::ZERO);
            }
            Self::Backlash { play, .. } => *play = x,
            _ => {}
        }
    }

    /// Returns to the state at power-on.
    pub(crate) fn reset(&mut self) {
        match self {
            Self::Decay(low_pass) => low_pass.start_at(R::ONE),
            Self::Time { ticks, .. } => *ticks = 0,
            Self::Oscillator { phasor, .. } => *phasor = Complex::ONE,
            _ => self.start_at(R::ZERO),
        }
    }

    /// Computes u(n) from x(n).
    #[inline]
    pub(crate) fn update(&mut self, x: R) -> R {
        match self {
            Self::Identity => x,
            Self::LowPass(low_pass) => low_pass.update(x),
            Self::Rate { low_pass, per_tau } => (x - low_pass.update(x)).times(*per_tau),
            Self::Variance { mean, variance } => {
                let deviation = x - mean.update(x);
                variance.update(deviation * deviation)
            }
            Self::Backlash { half_width, play } => {
                *play = play.limit(x - *half_width, x + *half_width);
                *play - x
            }
            Self::Absolute => x.abs(),
            Self::Decay(low_pass) => {
                let now = low_pass.value();
                low_pass.update(R::ZERO);
                now
            }
            Self::Time { period, origin, ticks } => {
                let now = R::count(*ticks, *period) - *origin;
                *ticks = ticks.saturating_add(1);
                now
            }
            Self::Oscillator { rotation, phasor, wants_sine } => {
                let now = *phasor;
                *phasor = normalised(now.times(*rotation));
                if *wants_sine { now.im } else { now.re }
            }
        }
    }

    /// Advances over `ticks` missing samples with x constant: equivalent to `ticks` updates, in bounded time.
    pub(crate) fn skip(&mut self, x: R, ticks: u32) {
        match self {
            Self::Identity | Self::Absolute | Self::Backlash { .. } => {}
            Self::LowPass(low_pass) | Self::Rate { low_pass, .. } => low_pass.skip(x, ticks),
            Self::Variance { mean, variance } => {
                // deviations decay as d·qᵏ, q = 1 − g: v(n) = qⁿ·(v + d²·q·(1 − qⁿ))
                let (deviation, closed) = ((x - mean.value()).stored(), mean.closed(ticks));
                let fed = deviation * deviation * (R::Stored::ONE - mean.gain()) * closed;
                let left = (variance.value().stored() + fed) * (R::Stored::ONE - closed);
                variance.start_at(R::of(left));
                mean.skip(x, ticks);
            }
            Self::Decay(low_pass) => low_pass.skip(R::ZERO, ticks),
            Self::Time { ticks: clock, .. } => *clock = clock.saturating_add(ticks),
            Self::Oscillator { rotation, phasor, .. } => {
                let mut square = *rotation;
                let mut left = ticks;
                while left > 0 {
                    if left & 1 == 1 {
                        *phasor = normalised(phasor.times(square));
                    }
                    square = normalised(square.times(square));
                    left >>= 1;
                }
            }
        }
    }
}

/// Pulls a phasor back to the unit circle: z·(3 − |z|²)/2, one Newton step for z/|z|, without a division.
#[inline]
fn normalised<R: Scalar>(z: Complex<R>) -> Complex<R> {
    let half = R::from_f64(0.5);
    let gain = R::ONE + half * (R::ONE - (z.re * z.re + z.im * z.im));
    Complex { re: z.re * gain, im: z.im * gain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Real;

    const PERIOD_S: f64 = 0.005;

    fn running<R: Real>(transform: Transform<R>) -> Running<R> {
        Running::new(&transform, PERIOD_S, R::ZERO, R::ONE)
    }

    #[test]
    fn low_pass_has_its_time_constant() {
        let mut low_pass = running(Transform::LowPass { tau_s: 2.0_f64 });
        low_pass.start_at(0.0);
        let after_tau = (0..400).map(|_| low_pass.update(1.0)).last().unwrap();
        assert!((after_tau - (1.0 - (-1.0_f64).exp())).abs() < 1e-12, "{after_tau}");
    }

    #[test]
    fn long_low_pass_has_no_dead_band_in_f32() {
        let (mut single, mut double) = (
            running(Transform::LowPass { tau_s: 1000.0_f32 }),
            running(Transform::LowPass { tau_s: 1000.0_f64 }),
        );
        single.start_at(1.0);
        double.start_at(1.0);
        let (mut a, mut b) = (0.0, 0.0);
        for _ in 0..2_000_000 {
            (a, b) = (single.update(1.004), double.update(1.004));
        }
        // the gain's own rounding (6e-8 of it) and one unit in the last place; a plain sum would still be at 1.0
        assert!((f64::from(a) - b).abs() < 2.0 * f64::from(f32::EPSILON), "{a} {b}");
    }

    #[test]
    fn rate_is_the_slope_of_a_ramp() {
        let mut rate = running(Transform::Rate { tau_s: 1.0_f64 });
        rate.start_at(0.0);
        let slope = (1..4000).map(|n| rate.update(0.3 * n as f64 * PERIOD_S)).last().unwrap();
        // s lags by τ − T/2 + O(T²): the filtered rate is exact to T/2τ
        assert!((slope - 0.3).abs() < 0.3 * PERIOD_S, "{slope}");
    }

    #[test]
    fn variance_of_a_sine_is_one_half() {
        let mut variance = running(Transform::Variance { tau_s: 5.0_f64 });
        variance.start_at(0.0);
        let value = (0..40_000).map(|n| variance.update((n as f64 * 0.7).sin())).last().unwrap();
        assert!((value - 0.5).abs() < 0.005, "{value}");
    }

    #[test]
    fn backlash_follows_only_beyond_its_half_width() {
        let mut play = running(Transform::Backlash { half_width: 0.5_f64 });
        play.start_at(0.0);
        assert_eq!(play.update(0.4), -0.4);
        assert_eq!(play.update(2.0), -0.5);
        assert_eq!(play.update(1.4), 1.5 - 1.4);
        assert_eq!(play.update(0.0), 0.5);
    }

    #[test]
    fn oscillator_keeps_amplitude_and_phase_for_an_hour() {
        let mut sine = running(Transform::Sine { frequency_hz: 16.37_f32 });
        let mut worst = 0.0_f64;
        for n in 0..720_000_u32 {
            let truth = libm::sin(core::f64::consts::TAU * f64::from(16.37_f32) * f64::from(n) * PERIOD_S);
            worst = worst.max((f64::from(sine.update(0.0)) - truth).abs());
        }
        // the rotation is rounded to f32: up to 6e-8 rad a sample, 0.043 rad in 720,000
        assert!(worst < 0.043, "{worst}");
    }

    #[test]
    fn skip_equals_updates_with_a_constant_value() {
        let transforms = [
            Transform::Identity,
            Transform::LowPass { tau_s: 0.8_f64 },
            Transform::Rate { tau_s: 0.8 },
            Transform::Variance { tau_s: 0.8 },
            Transform::Backlash { half_width: 0.1 },
            Transform::Absolute,
            Transform::Decay { tau_s: 3.0 },
            Transform::Time,
            Transform::Sine { frequency_hz: 3.3 },
            Transform::Cosine { frequency_hz: 3.3 },
        ];
        for transform in transforms {
            let mut stepped = running(transform);
            stepped.start_at(1.0);
            for n in 0..50 {
                stepped.update(1.0 + 0.1 * (n as f64).sin());
            }
            // backlash does not change with a constant value
            stepped.update(1.5);
            let mut skipped = stepped;
            (0..777).for_each(|_| {
                stepped.update(1.5);
            });
            skipped.skip(1.5, 777);
            let (a, b) = (stepped.update(2.0), skipped.update(2.0));
            assert!((a - b).abs() < 1e-9, "{transform:?}: {a} {b}");
        }
    }

    #[test]
    fn slow_transform_keeps_its_time_constant_in_f32() {
        // rounding the factor per sample, 1 − 5e-6, to f32 would lose 0.5 % of the time constant
        for stepwise in [true, false] {
            let mut decay = running(Transform::Decay { tau_s: 1000.0_f32 });
            let mut low_pass = running(Transform::LowPass { tau_s: 1000.0_f32 });
            low_pass.start_at(1.0);
            if stepwise {
                for _ in 0..200_000 {
                    decay.update(0.0);
                    low_pass.update(0.0);
                }
            } else {
                decay.skip(0.0, 200_000);
                low_pass.skip(0.0, 200_000);
            }
            let truth = libm::exp(-1.0);
            let (a, b) = (f64::from(decay.update(0.0)), f64::from(low_pass.update(0.0)));
            // 18 doublings of half a unit in the last place, and the gain's own rounding
            assert!((a - truth).abs() < 1e-6 && (b - truth).abs() < 3e-6, "{stepwise}: {a} {b} {truth}");
        }
    }
}
