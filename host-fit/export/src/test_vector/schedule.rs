//! Sequence of the conditions that a test vector exercises.

use fos_core::Quantity;

use super::room::longest_lag;
use fos_fit::model::{FittedAxis, UnitModel};

/// Condition exercised by a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// At rest, all inputs within their fitted ranges.
    Still,
    /// At rest, all inputs below (`Below`) or above (`Above`) their fitted ranges.
    Below,
    Above,
    /// At rest, without this quantity of the model.
    Absent(usize),
    /// At rest, all codes at full scale.
    Saturated,
    /// At rest, each axis at the full scale of the model, if codes reach it.
    FullScale,
    /// In motion.
    Moving,
    /// At rest, after this number of missing samples.
    After(u32),
}

/// Kinds of the samples of a vector of `model`, in their order.
pub(super) fn schedule(model: &UnitModel) -> Vec<Kind> {
    let axes = &model.axes;
    let longest_lag = longest_lag(model);
    let gap_limit = |axis: &FittedAxis| u32::from(axis.parameters.gap_limit_samples);
    let longest_gap = axes.iter().map(gap_limit).max().unwrap_or(0);
    let absent = (0..model.quantities.len())
        .filter(|index| !matches!(model.quantities[*index].quantity, Quantity::Measured(_)))
        .flat_map(|index| [Kind::Absent(index), Kind::Still]);

    let mut kinds = vec![Kind::Still; longest_lag + 30];
    kinds.extend([Kind::Below, Kind::Still, Kind::Above, Kind::Still]);
    kinds.extend(absent);
    kinds.extend([Kind::Saturated, Kind::Still, Kind::FullScale, Kind::Still]);
    kinds.extend([Kind::Moving; 8]);
    kinds.extend([Kind::Still, Kind::After(3), Kind::Still]);
    kinds.push(Kind::After(longest_gap + 1000));
    kinds.resize(kinds.len() + longest_lag + 8, Kind::Still);
    kinds
}
