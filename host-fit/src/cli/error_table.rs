//! The errors of several models on one axis, side by side.

use comfy_table::Table;

use super::output::{number, optional, table};
use fos_fit::evaluate::ModelErrors;

/// One column per model, one row per error.
pub(super) fn error_table(models: &[&ModelErrors]) -> Table {
    let mut header = vec!["  error".to_owned()];
    header.extend(models.iter().map(|model| model.model.clone()));
    let mut rows = table(&header);
    let mut add = |name: String, value: &dyn Fn(&ModelErrors) -> String| {
        let mut row = vec![format!("  {name}")];
        row.extend(models.iter().map(|model| value(model)));
        rows.add_row(row);
    };
    add("one-step MSE".into(), &|m| {
        format!("{}{}", number(m.one_step_mse), if m.below_noise_floor { " (below floor!)" } else { "" })
    });
    let horizons: Vec<f64> = models.iter().flat_map(|m| &m.coast).map(|coast| coast.horizon_s).collect();
    for horizon in [1.0, 10.0, 60.0].into_iter().filter(|horizon| horizons.contains(horizon)) {
        let at = |m: &ModelErrors| m.coast.iter().find(|coast| coast.horizon_s == horizon).copied();
        add(format!("coast MSE after {horizon} s"), &|m| optional(at(m).map(|coast| coast.mse)));
        add("  standard error".into(), &|m| optional(at(m).map(|coast| coast.standard_error)));
    }
    add("coast MSE, never anew".into(), &|m| number(m.coast_whole_mse));
    add("slow error, one-step".into(), &|m| optional(m.slow_error_one_step));
    add("slow error, coast".into(), &|m| optional(m.slow_error_coast));
    add("wide error, one-step".into(), &|m| number(m.wide_error_one_step));
    add("wide error, coast".into(), &|m| number(m.wide_error_coast));
    for tau in [1.0, 10.0, 100.0] {
        let at = |m: &ModelErrors| {
            m.allan.iter().find(|point| (point.tau_s / tau - 1.0).abs() < 0.1).map(|point| point.deviation)
        };
        if models.iter().any(|m| at(m).is_some()) {
            add(format!("Allan deviation at {tau} s"), &|m| optional(at(m)));
        }
    }
    if models.iter().any(|m| m.position_error_m.is_some()) {
        add("position error, m (paper)".into(), &|m| optional(m.position_error_m));
    }
    if models.iter().any(|m| m.cautions > 0) {
        add("rows with a caution".into(), &|m| m.cautions.to_string());
    }
    rows
}
