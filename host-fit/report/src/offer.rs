//! Effects that a diagnosis offers to add: the physics in plain language, cost and evidence.

use serde::Serialize;

use fos_data::recording::Recording;
use fos_diagnose::detect::{Diagnosis, Finding};
use fos_diagnose::effects::Effect;
use fos_diagnose::refine::{RefineError, Refiner, line_evidence};
use fos_diagnose::study::Refinement;
use fos_figures::Figure;
use fos_figures::evidence::evidence;
use fos_fit::cost::Cost;

/// Detected effect, offered for addition to the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Offer {
    /// Identifier in the library, such as `thermal_lag`.
    pub effect: String,
    /// True if the effect can be corrected sample by sample and the finding is conclusive.
    pub can_be_added: bool,
    /// Reason why the effect cannot be added, or the alternative; none if it can.
    pub why_not: Option<String>,
    /// Physics of the effect.
    pub card: Effect,
    /// Additional cost of the model on the device.
    pub cost: Option<Cost>,
    /// Figure of the evidence.
    pub evidence: Option<Figure>,
}

/// Returns one offer for each finding of a diagnosis of `refinement`, in their order. `log` is the log to
/// explain.
pub fn offers(
    refiner: &Refiner<'_>,
    refinement: &Refinement,
    diagnosis: &Diagnosis,
    log: &Recording,
) -> Result<Vec<Offer>, RefineError> {
    let offer = |finding: &Finding| {
        let effect = refiner.library().get(&finding.effect)?;
        let added = refiner.can_add_finding(&refinement.column, effect, finding);
        let price = if added.is_ok() { refiner.price(refinement, finding)? } else { None };
        let found = refiner.evidence(refinement, &diagnosis.findings, finding)?;
        let line = match found {
            Some(_) => None,
            None => line_evidence(log, &refinement.column, finding)?,
        };
        let evidence = evidence(&refinement.column, &effect.name, finding, found.as_ref(), line.as_ref());
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
            card: effect.clone(),
            cost: price,
            evidence,
        })
    };
    diagnosis.findings.iter().map(offer).collect()
}
