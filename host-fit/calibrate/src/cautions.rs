//! Reasons to distrust parts of a calibration, in words.

use fos_data::text::{counted, rounded};

use crate::Calibration;
use crate::accelerometer::Accelerometer;
use crate::gyro::{Gyro, TurnExclusion};
use crate::parameter::Determined;
use crate::shown::shown;
use fos_data::unit::MG_MPS2;

/// Largest residual of a device at rest, m/s² (3 mg).
const RESTLESS_MPS2: f64 = 3.0 * MG_MPS2;

/// Fewest orientations with which the residual shows how well the model fits: one more than its unknowns.
const TESTED: usize = 10;

impl Accelerometer {
    /// Returns the reasons to distrust it, a sentence each; numbers in field units (mg, %) or in SI.
    pub fn cautions(&self, field: bool) -> Vec<String> {
        let mut all = Vec::new();
        if self.orientations < TESTED {
            all.push(format!(
                "{} distinct orientations for 9 unknowns: the residual shows how well rests repeat, not how well the model fits",
                self.orientations
            ));
        }
        if let Some(rms) = self.rms_mps2[0].filter(|rms| *rms > RESTLESS_MPS2) {
            let rms = rounded(rms / MG_MPS2, 3);
            all.push(format!("a residual of {rms} mg: the device did not lie still, or it is not linear"));
        }
        if !self.unseen.is_empty() {
            all.push(format!("no rest with {}", self.unseen.join(", nor ")));
        }
        for one in &self.parameters {
            let what = match one.determined {
                Determined::Well => continue,
                Determined::Weakly => "weakly determined by these orientations",
                Determined::NotByThisLog => {
                    "not determined by this log; the interval is that of typical parts"
                }
            };
            all.push(format!("{} ({}) is {what}", one.label, shown(one, field).both()));
        }
        all
    }
}

impl Gyro {
    /// Returns the reasons to distrust it, a sentence each.
    pub fn cautions(&self) -> Vec<String> {
        if self.parameters.is_empty() {
            return vec![format!("the gyro is excluded: {}", self.refused.as_deref().unwrap_or("no rests"))];
        }
        let refused = self
            .refused
            .iter()
            .map(|reason| format!("sensitivity and cross-axis of the gyro were not estimated: {reason}"));
        let order = self
            .axis_order
            .iter()
            .map(|order| format!("the axes of the gyro are not those of the accelerometer: {order}; cross-axis angles are between axes that belong together"));
        let clipped = self.turns.iter().filter(|turn| turn.excluded == Some(TurnExclusion::Clips)).count();
        let clipped = (clipped > 0).then(|| {
            format!("{} faster than the gyro's full scale, excluded: turn slower", counted(clipped, "turn"))
        });
        refused.chain(order).chain(clipped).collect()
    }
}

impl Calibration {
    /// Returns the reasons to distrust the calibration, a sentence each; numbers in field units or in SI.
    pub fn cautions(&self, field: bool) -> Vec<String> {
        let gyro = self.gyro.iter().flat_map(Gyro::cautions);
        self.accelerometer.cautions(field).into_iter().chain(gyro).collect()
    }
}
