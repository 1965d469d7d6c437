//! What a model is a sum of: terms, each a coefficient times a product of delayed samples.

/// Which of a sample's values a [`Factor`] delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// The axis' own remainder r = y − p, the model's output fed back (paper eq. 14: y).
    Output,
    /// Input `u_i` (paper eq. 14: x).
    Input(u8),
}

/// One delayed sample: r(n − lag) or u_i(n − lag), paper eq. 14.
///
/// An output needs `lag ≥ 1`: the present is what is predicted. An input may have lag 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Factor {
    /// What is delayed.
    pub channel: Channel,
    /// By how many samples.
    pub lag: u16,
}

/// The factor r(n − lag).
pub const fn y(lag: u16) -> Factor {
    Factor { channel: Channel::Output, lag }
}

/// The factor u_input(n − lag).
pub const fn u(input: u8, lag: u16) -> Factor {
    Factor { channel: Channel::Input(input), lag }
}
