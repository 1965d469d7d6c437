//! A row for each axis of a model: its slow error before and after, and the reduction of the RMS.

use comfy_table::{CellAlignment, Table};

use super::error_table::error_unit;
use super::output::table;
use super::units::{Units, percent};
use fos_diagnose::compare::{AxisComparison, Comparison};
use fos_fit::evaluate::{ModelErrors, before_and_after};

/// The quantities of [`table_of`].
pub(super) const LEGEND: &str =
    "  slow error: RMS of 1-s means in a free run of at most 60 s; before: constant mean, after: model";

/// An axis with the errors of its rivals and its model.
pub(super) struct Row<'a> {
    pub(super) column: &'a str,
    pub(super) errors: Vec<&'a ModelErrors>,
    /// Text of the last cell.
    pub(super) remark: String,
}

/// Makes the table; `remark` is the heading of the last column.
pub(super) fn table_of(axes: &[Row<'_>], remark: &str, units: Units) -> Table {
    let mut rows = table(&["  axis", "slow error before", "after", "unit", "RMS reduction", remark]);
    for column in rows.column_iter_mut().skip(5) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for Row { column, errors, remark } in axes {
        let unit = error_unit(column, errors, units);
        let [before, after] = before_and_after(errors.iter().copied())
            .map(|errors| errors.and_then(|errors| errors.slow_error_coast));
        let reduction = before
            .zip(after)
            .filter(|(before, _)| *before > 0.0)
            .map(|(before, after)| 1.0 - (after / before).sqrt());
        rows.add_row(vec![
            format!("  {column}"),
            unit.root(before),
            unit.root(after),
            unit.label.to_owned(),
            reduction.map_or_else(|| "–".to_owned(), percent),
            remark.clone(),
        ]);
    }
    rows
}

/// Axes of a comparison, with the dependences of their residual.
pub(super) fn summary(comparison: &Comparison, units: Units) -> Table {
    let rows = comparison.axes.iter().map(|axis| Row {
        column: &axis.column,
        errors: axis.errors.iter().collect(),
        remark: residual(axis),
    });
    table_of(&rows.collect::<Vec<_>>(), "residual", units)
}

/// Result of the test of the residual, in the terms of `--details`.
fn residual(axis: &AxisComparison) -> String {
    let Some(dependence) = &axis.dependence else { return "not known".to_owned() };
    let clear = dependence.channels.iter().filter(|channel| channel.is_clear());
    match &clear.map(|channel| channel.channel.as_str()).collect::<Vec<_>>()[..] {
        [] => "depends on nothing that is logged".to_owned(),
        channels => format!("depends on {}", channels.join(", ")),
    }
}
