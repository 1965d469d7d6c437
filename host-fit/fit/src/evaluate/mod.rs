//! Errors of a model on data: one-step, free run, slow and broadband errors, heading and position without aiding, Allan
//! deviation, compared with plain rivals and the noise floor. A model is evaluated by running fos-core on it.

mod coasts;
mod errors;
mod origins;
mod rivals;
mod strapdown;
mod strapdown_errors;
mod stretches;
mod trace;
mod unaided;

pub use errors::{AllanValue, CoastError, ModelErrors, SLOW_BLOCK_S};
pub use origins::HORIZONS_S;
pub use rivals::{MODEL, Rival, before_and_after, rival};
pub use strapdown::StrapdownEnd;
pub use strapdown_errors::strapdown_errors;
pub use stretches::{Stretch, worst_stretches};
pub use trace::{AxisTrace, Coasted, Trace, trace, trace_in_f32, trace_of};
pub use unaided::{FEWEST_WINDOWS, RmsInterval, UNAIDED_S, UnaidedError};
