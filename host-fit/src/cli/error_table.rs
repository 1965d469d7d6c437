//! Errors of several models on one axis, side by side.

use comfy_table::Table;

use super::output::table;
use super::units::{ErrorUnit, Units};
use fos_fit::evaluate::ModelErrors;

/// Unit in which the errors of these models are shown.
pub(super) fn error_unit(column: &str, models: &[&ModelErrors], units: Units) -> ErrorUnit {
    ErrorUnit::of_models(column, models.iter().copied(), units)
}

/// A column for each model, a row for each RMS error.
pub(super) fn error_table(models: &[&ModelErrors], unit: ErrorUnit) -> Table {
    let mut header = vec![format!("  RMS, {}", unit.label)];
    header.extend(models.iter().map(|model| model.model.clone()));
    let mut rows = table(&header);
    let mut add = |name: String, value: &dyn Fn(&ModelErrors) -> String| {
        let mut row = vec![format!("  {name}")];
        row.extend(models.iter().map(|model| value(model)));
        rows.add_row(row);
    };
    let root = |variance: f64| unit.root(Some(variance));
    add("one-step prediction error".into(), &|m| {
        format!("{}{}", root(m.one_step_mse), if m.below_noise_floor { " (below floor!)" } else { "" })
    });
    let horizons: Vec<f64> = models.iter().flat_map(|m| &m.coast).map(|coast| coast.horizon_s).collect();
    for horizon in [1.0, 10.0, 60.0].into_iter().filter(|horizon| horizons.contains(horizon)) {
        let at = |m: &ModelErrors| m.coast.iter().find(|coast| coast.horizon_s == horizon).copied();
        add(format!("free run, {horizon} s ahead"), &|m| unit.root(at(m).map(|coast| coast.mse)));
        // Standard error of the root: half that of the mean square, divided by the root.
        let error = |m: &ModelErrors| at(m).map(|coast| 0.5 * coast.standard_error / coast.mse.sqrt());
        add("  ± standard error".into(), &|m| {
            error(m).map_or_else(|| "–".to_owned(), |error| unit.show(error))
        });
    }
    add("free run over the whole log".into(), &|m| root(m.coast_whole_mse));
    add("slow error, one step ahead".into(), &|m| unit.root(m.slow_error_one_step));
    add("slow error, free run".into(), &|m| unit.root(m.slow_error_coast));
    add("broadband error, one step ahead".into(), &|m| root(m.wide_error_one_step));
    add("broadband error, free run".into(), &|m| root(m.wide_error_coast));
    for tau in [1.0, 10.0, 100.0] {
        let at = |m: &ModelErrors| {
            m.allan.iter().find(|point| (point.tau_s / tau - 1.0).abs() < 0.1).map(|point| point.deviation)
        };
        if models.iter().any(|m| at(m).is_some()) {
            add(format!("Allan deviation at {tau} s"), &|m| {
                at(m).map_or_else(|| "–".to_owned(), |deviation| unit.show(deviation))
            });
        }
    }
    if models.iter().any(|m| m.cautions > 0) {
        add("rows with a caution".into(), &|m| m.cautions.to_string());
    }
    rows
}
