//! What a diagnosis offers to add: the physics in plain language, what it costs, what speaks for it.

use fos_data::column::Column;
use serde::Serialize;

use super::evidence::Evidence;
use crate::figures::Figure;
use crate::figures::compare::Subject;
use fos_data::recording::Recording;
use fos_diagnose::detect::{Diagnosis, Finding};
use fos_diagnose::effects::{Band, Effect, Library};
use fos_diagnose::refine::{RefineError, Refiner};
use fos_diagnose::study::Refinement;
use fos_fit::cost::Cost;

/// An effect that was found, to be added or not.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Offer {
    /// As in the library, as `thermal_lag`.
    pub effect: String,
    /// Whether something of it can be taken off sample by sample.
    pub can_be_added: bool,
    /// What to do instead.
    pub why_not: Option<String>,
    /// The physics.
    pub card: Card,
    /// What the model would cost more on the device.
    pub cost: Option<Cost>,
    /// What speaks for it.
    pub evidence: Option<Figure>,
}

/// An effect in plain language: texts of the library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Card {
    /// As in the library, as `thermal_lag`.
    pub id: String,
    /// Name, as in a sentence.
    pub name: String,
    /// In block means, in single samples, in the data themselves, or as noise.
    pub band: Band,
    /// What happens in the sensor.
    pub mechanism: String,
    /// The error it makes.
    pub equation: String,
    /// How large it is on phone-class parts.
    pub typical_size: String,
    /// Where that comes from.
    pub source: String,
    /// Which experiment shows it.
    pub experiment: String,
    /// What in a plot gives it away.
    pub gives_away: String,
    /// What it costs on the device, in words.
    pub device: String,
}

impl Card {
    /// Of an effect.
    pub fn of(effect: &Effect) -> Self {
        Self {
            id: effect.id.clone(),
            name: effect.name.clone(),
            band: effect.band,
            mechanism: effect.mechanism.clone(),
            equation: effect.equation.clone(),
            typical_size: effect.typical_size.clone(),
            source: effect.source.clone(),
            experiment: effect.experiment.clone(),
            gives_away: effect.gives_away.clone(),
            device: effect.device.clone(),
        }
    }
}

/// One offer for each finding of a diagnosis of `refinement`, in their order. `field` is the log of the diagnosis.
///
/// # Errors
///
/// A column is missing.
pub fn offers(
    refiner: &Refiner<'_>,
    refinement: &Refinement,
    diagnosis: &Diagnosis,
    library: &Library,
    field: &Recording,
) -> Result<Vec<Offer>, RefineError> {
    let column = Column::named(&refinement.column);
    let subject = Subject { channel: column.label(), unit: column.unit().label() };
    let offer = |finding: &Finding| {
        let effect = library.get(&finding.effect)?;
        let added = refiner.can_add_finding(&refinement.column, effect, finding);
        let price = if added.is_ok() { refiner.price(refinement, finding)? } else { None };
        let evidence = Evidence::of(refiner, refinement, diagnosis, finding, field)?;
        Ok(Offer {
            effect: finding.effect.clone(),
            can_be_added: added.is_ok() && !finding.correction.is_empty() && finding.doubt.is_none(),
            why_not: match added {
                Err(RefineError::NothingToTakeOff(_, instead)) => Some(instead.to_owned()),
                Err(other) => Some(other.to_string()),
                Ok(()) if finding.correction.is_empty() => Some("it cannot be corrected".to_owned()),
                Ok(()) => finding
                    .doubt
                    .as_ref()
                    .map(|doubt| format!("it is not conclusive: {doubt}. To decide: {}", effect.experiment)),
            },
            card: Card::of(effect),
            cost: price,
            evidence: evidence.map(|found| found.drawn(subject, &effect.name)),
        })
    };
    diagnosis.findings.iter().map(offer).collect()
}
