//! Reasons to distrust the numbers of a comparison.

use fos_fit::evaluate::{ModelErrors, before_and_after};
use fos_fit::signal::noise_floor::NoiseFloor;

use crate::dependence::Dependence;

/// Caution about an axis that lies in another orientation than in the fit.
const OTHER_ORIENTATION: &str = "the device also rests in another orientation than in the fit, where the true value of an accelerometer is unknown: there the error is about its own mean, and on the device the model is not corrected by measurements";

/// Returns the reasons to distrust the numbers of an axis.
pub(crate) fn cautions(
    floor: Option<&NoiseFloor>,
    has_turned: bool,
    dependence: Option<&Dependence>,
    errors: &[ModelErrors],
) -> Vec<String> {
    let floor = floor.into_iter().flat_map(|floor| floor.cautions.iter().map(ToString::to_string));
    let turned = has_turned.then(|| OTHER_ORIENTATION.to_owned());
    let own_noise = dependence.is_some_and(|dependence| !dependence.learnt).then(|| {
        "the noise was estimated from these rows, as the log that was fitted is not at hand".to_owned()
    });
    floor.chain(turned).chain(own_noise).chain(worse_than_mean(errors)).collect()
}

/// Increase of the mean square of the slow error from which on a model counts as worse: 5 % of the RMS. Differences below
/// it are within the scatter of logs of some minutes.
const WORSE: f64 = 1.1;

/// Returns a caution for a model that is worse in a free run than the constant mean.
pub fn worse_than_mean<'e>(errors: impl IntoIterator<Item = &'e ModelErrors> + Clone) -> Option<String> {
    let [before, after] =
        before_and_after(errors).map(|errors| errors.and_then(|errors| errors.slow_error_coast));
    (after? > WORSE * before?).then(|| {
        "in a free run the model is worse than a constant mean: fit a log that is longer at rest and varies as the evaluated one does, or use fewer terms"
            .to_owned()
    })
}
