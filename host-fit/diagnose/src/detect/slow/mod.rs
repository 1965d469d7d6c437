//! Which slow effects are missing: forward selection among hypotheses by penalised likelihood, the noise levels fitted
//! anew under each, noise itself among them; then exchanges, and what the log cannot tell apart.
//!
//! | file | subject |
//! |---|---|
//! | `result` | what was found |
//! | `model` | a model under construction, fitted; what its parameters cost |
//! | `parameter`, `terms` | an effect's parameter between the values of its grid; which of its regressors are worth their price |
//! | `noise` | noise beyond the baseline's |
//! | `candidates` | every effect on top of a model |
//! | `reversal` | steps and warm-ups where the temperature explains them |
//! | `estimate` | the coefficients of an effect, and how well they are known |
//! | `alternatives` | what may be true instead of a finding |
//! | `describe` | what was accepted: gains, errors of parameters, rivals |
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
