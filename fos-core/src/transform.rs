//! Causal transforms in constant memory, which turn a logged quantity into an input.

use serde::{Deserialize, Serialize};

/// A causal transform in constant memory. `x` is the logged quantity, centred and scaled; T the sample period.
///
/// Time constants are in seconds and frequencies in hertz; they become coefficients when the model is built.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Transform<R> {
    /// u = x.
    Identity,
    /// Low-pass: s ← s + (1 − e^(−T/τ))·(x − s), u = s. Starts at the first x; a low-pass of
    /// a remainder starts at 0.
    LowPass {
        /// Time constant τ, s.
        tau_s: R,
    },
    /// Filtered rate: u = (x − s)/τ, per second, s the low-pass of x.
    Rate {
        /// Time constant τ, s.
        tau_s: R,
    },
    /// Windowed variance: the low-pass of (x − s)², s the low-pass of x, both with τ. In units of x².
    Variance {
        /// Time constant τ of the exponential window, s.
        tau_s: R,
    },
    /// Backlash: u = b − x with the play b ← limit(b, x − r, x + r), the lag of a worn gear behind x.
    Backlash {
        /// Half width r of the play, in units of the logged quantity.
        half_width: R,
    },
    /// Absolute value: u = |x|.
    Absolute,
    /// Decaying exponential since power-on: u = e^(−t/τ).
    Decay {
        /// Time constant τ, s.
        tau_s: R,
    },
    /// Time since power-on: u = (t − centre)/scale, t in seconds.
    Time,
    /// Line: u = sin 2πft since power-on.
    Sine {
        /// Frequency f, Hz.
        frequency_hz: R,
    },
    /// Line: u = cos 2πft since power-on.
    Cosine {
        /// Frequency f, Hz.
        frequency_hz: R,
    },
}

impl<R> Transform<R> {
    /// True if the transform depends on time alone and takes no logged quantity.
    pub const fn is_clock(&self) -> bool {
        matches!(self, Self::Decay { .. } | Self::Time | Self::Sine { .. } | Self::Cosine { .. })
    }
}
