//! Search for missing slow effects: forward selection among hypotheses by penalised likelihood with the noise levels
//! fitted for each, excess noise among them; then exchanges, and indistinguishable rivals.
//!
//! | file | subject |
//! |---|---|
//! | `result` | findings and excess noise |
//! | `model` | a model under construction, fitted; penalties of its parameters |
//! | `parameter`, `terms` | refinement of an effect's parameter between grid values; selection of its regressors |
//! | `noise` | noise in excess of the reference log |
//! | `candidates` | every effect added to a model |
//! | `reversal` | steps and warm-ups that the temperature explains |
//! | `estimate` | coefficients of an effect and their covariance |
//! | `alternatives` | alternatives to a finding |
//! | `describe` | gains, parameter errors and rivals of the findings |
//! | `selection` | forward selection, and effects estimated together |

mod alternatives;
mod candidates;
mod describe;
mod estimate;
mod model;
mod noise;
mod parameter;
mod result;
mod reversal;
mod selection;
mod terms;

pub(super) use describe::{INSEPARABLE, INSIDE};
pub(super) use estimate::Estimate;
pub(super) use model::{ACCEPT, SlowSearch};
pub(super) use result::{ExtraNoise, Found, SlowResult};
pub(super) use selection::MAX_FOUND;
