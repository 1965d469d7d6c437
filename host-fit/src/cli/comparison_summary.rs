//! Six axes at a glance: what `compare` begins with where a model has several.

use comfy_table::{CellAlignment, Table};

use super::output::{optional, table};
use fos_diagnose::compare::{AxisComparison, Comparison, MODEL};
use fos_fit::evaluate::{ModelErrors, Rival};

/// What the numbers of [`summary`] are.
pub(super) const LEGEND: &str = "  error: root of the variance of 1-s means, coasting for at most 60 s; before: of the constant mean, left: of the model\n  \
     removed: share of that variance; below 0 there is more of it than before";

/// One line an axis: the error before and after, the share that the model removed, and what the rest depends on.
pub(super) fn summary(comparison: &Comparison) -> Table {
    let mut rows = table(&["  axis", "error before", "error left", "unit", "removed", "what is left"]);
    for column in rows.column_iter_mut().skip(5) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for axis in &comparison.axes {
        let slow = |model: &str| {
            let errors = axis.errors.iter().find(|errors| errors.model == model);
            errors.and_then(|errors: &ModelErrors| errors.slow_error_coast)
        };
        let (before, left) = (slow(Rival::Mean.name()), slow(MODEL));
        let removed =
            before.zip(left).filter(|(before, _)| *before > 0.0).map(|(before, left)| 1.0 - left / before);
        rows.add_row(vec![
            format!("  {}", axis.column),
            optional(before.map(f64::sqrt)),
            optional(left.map(f64::sqrt)),
            axis.unit.clone(),
            removed.map_or_else(|| "–".to_owned(), |share| format!("{:.1} %", 100.0 * share)),
            rest(axis),
        ]);
    }
    rows
}

/// In the words of the details.
fn rest(axis: &AxisComparison) -> String {
    let Some(dependence) = &axis.dependence else { return "not known".to_owned() };
    let clear = dependence.channels.iter().filter(|channel| channel.is_clear());
    match &clear.map(|channel| channel.channel.as_str()).collect::<Vec<_>>()[..] {
        [] => "depends on nothing that is logged".to_owned(),
        channels => format!("depends on {}", channels.join(", ")),
    }
}
