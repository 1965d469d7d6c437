//! Hubs that refuse a model, and how to proceed; determined by loading the model into real hubs.

use std::fmt::{self, Display, Formatter};

use fos_embedded::hub::{CHub, Hub, HubError};
use fos_embedded::raw::Scales;

use super::test_vector::{Room, loaded};
use fos_fit::model::UnitModel;

/// Reason why a hub refuses a model with any settings of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// The hub of the C interface is too small; a hub in Rust has the size that the model needs.
    TooLargeForC(Room),
    /// No hub accepts the model: an axis or a quantity is not measured by a six-axis sensor, or the largest hub is too small.
    Hub {
        /// Error of the hub.
        error: HubError,
        /// Column to which the error refers.
        column: String,
    },
}

impl Refusal {
    /// Reason why a hub refuses `model`; none if the hub of the C interface accepts it, as then does a hub in Rust of the same size.
    /// The sensor is assumed to have the model's sample period, and to provide the kind of values it was fitted on.
    pub fn of(model: &UnitModel) -> Option<Self> {
        let scales = Scales {
            accel_mps2: 1.0,
            gyro_rads: 1.0,
            temperature_k: 1.0,
            temperature_zero_c: 0.0,
            period_s: model.period_s,
            values: model.fitted_on,
        };
        if let Err(error) = loaded(model, scales) {
            return Some(Self::hub(error, model));
        }
        // A model accepted by a larger hub is refused by this one only because of its size.
        (!takes(&mut CHub::new(scales), model)).then(|| Self::TooLargeForC(room_in_c(model, scales)))
    }

    pub(super) fn hub(error: HubError, model: &UnitModel) -> Self {
        let column = match error {
            HubError::Axis(index) => model.axes.get(index).map(|axis| axis.column.as_str()),
            HubError::Quantity(index) => model.quantities.get(index).map(|logged| logged.column.as_str()),
            _ => None,
        };
        Self::Hub { error, column: column.unwrap_or("the model").to_owned() }
    }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLargeForC(needs) => {
                let wants = [
                    (needs.inputs, C.inputs, "inputs", "fewer --physical, --input, --memory"),
                    (needs.terms, C.terms, "terms", "a smaller --max-terms"),
                    (
                        needs.history,
                        C.history,
                        "values of history",
                        "a smaller --max-lag, --input-lags, or fewer inputs",
                    ),
                ];
                let lacking = || wants.iter().filter(|(needed, there, ..)| needed > there);
                let lacks: Vec<String> = lacking()
                    .map(|(needed, there, what, _)| format!("{needed} {what} (room for {there})"))
                    .collect();
                let fits: Vec<&str> = lacking().map(|(.., help)| *help).collect();
                write!(
                    f,
                    "the hub of the C interface, fos.h, refuses this model, which needs {}\n\
                     help: fit it with {}, or fewer axes; or load the image in Rust, into a Hub<{}, {}, {}>",
                    lacks.join(" and "),
                    fits.join(" and "),
                    needs.inputs,
                    needs.terms,
                    needs.history
                )
            }
            Self::Hub { error: error @ HubError::Image(_), .. } => {
                write!(
                    f,
                    "no hub takes this model: {error}\nhelp: fit it with a smaller --max-terms, --max-lag, or fewer inputs"
                )
            }
            Self::Hub { error, column } => write!(
                f,
                "no hub takes this model, for {column}: {error}\n\
                 help: fit it to columns that are named as those of a sensor, ax_mps2 … gz_rads (--map); as it is, only a \
                 Predictor of fos-core runs it"
            ),
        }
    }
}

/// Capacities of the hub of the C interface.
const C: Room = room_of(&CHub::new);

const fn room_of<const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
    _: &impl Fn(Scales) -> Hub<INPUTS, TERMS, HISTORY>,
) -> Room {
    Room { inputs: INPUTS, terms: TERMS, history: HISTORY }
}

fn takes<const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
    hub: &mut Hub<INPUTS, TERMS, HISTORY>,
    model: &UnitModel,
) -> bool {
    model.with::<f32, _>(|model| hub.load_model(model)).is_ok()
}

/// Capacities of the hub of the C interface needed by `model`. [`Room::for_model`] is too large if the deepest terms do not use the first
/// inputs, so the history is tested with a hub.
pub(super) fn room_in_c(model: &UnitModel, scales: Scales) -> Room {
    let mut needs = Room::for_model(model);
    if takes(&mut Hub::<32, 512, { C.history }>::new(scales), model) {
        needs.history = needs.history.min(C.history);
    }
    needs
}
