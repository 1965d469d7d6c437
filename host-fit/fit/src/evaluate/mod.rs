//! How well a model does on data: one-step, coast, slow and wide errors, position error, Allan deviation, beside
//! plain rivals and the noise floor. A model is judged by running fos-core on it.

mod coasts;
mod errors;
mod origins;
mod rivals;
mod stretches;
mod trace;

pub use errors::{AllanValue, CoastError, ModelErrors, SLOW_BLOCK_S, position_error_m};
pub use origins::HORIZONS_S;
pub use rivals::{Rival, rival};
pub use stretches::{Stretch, worst_stretches};
pub(crate) use trace::trace_to_horizons;
pub use trace::{AxisTrace, Trace, trace};
