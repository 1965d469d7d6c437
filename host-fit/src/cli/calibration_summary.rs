//! Prints calibrations.

use fos_calibrate::{Accelerometer, Calibration, Gyro, Parameter, RestResidual, Shown, Turntable, shown};

use super::output::{first, print_hint, print_line, table};
use super::units::{Printed, Units, three};
use fos_data::text::counted;
use fos_data::unit::MG_MPS2;
use fos_report::certificate::gravity;

/// Correlations beyond this are printed with `--details`.
const CORRELATED: f64 = 0.8;

/// Prints a calibration by hand.
pub(super) fn print_hand(found: &Calibration, printed: Printed) {
    print_accelerometer(&found.accelerometer, printed);
    if let Some(gyro) = &found.gyro {
        print_gyro(gyro, printed);
    }
    print_next(&found.accelerometer);
    if printed.details {
        print_rests(&found.accelerometer.rests);
        if let Some(gyro) = &found.gyro {
            print_turns(gyro);
        }
        print_correlations(&found.accelerometer.parameters, &found.accelerometer.correlations);
    }
    print_hint(printed);
}

fn in_units(parameter: &Parameter, printed: Printed) -> Shown {
    shown(parameter, printed.units == Units::Field)
}

/// Parameters with an id that ends in one of these, for x, y and z.
fn of_kind<'a>(parameters: &'a [Parameter], kind: &str) -> Vec<&'a Parameter> {
    parameters.iter().filter(|one| one.id.split('.').nth(1) == Some(kind)).collect()
}

/// A table with a row for each axis and a column for each kind; kinds without parameters are omitted.
fn print_axes(parameters: &[Parameter], kinds: &[(&str, &str)], printed: Printed) {
    let columns: Vec<(&str, Vec<Shown>)> = kinds
        .iter()
        .map(|(kind, name)| {
            (*name, of_kind(parameters, kind).into_iter().map(|one| in_units(one, printed)).collect())
        })
        .filter(|(_, all): &(&str, Vec<Shown>)| all.len() == 3)
        .collect();
    let header = columns.iter().map(|(name, all)| {
        if all[0].unit.is_empty() { (*name).to_owned() } else { format!("{name}, {}", all[0].unit) }
    });
    let mut rows = table(&std::iter::once("  axis".to_owned()).chain(header).collect::<Vec<_>>());
    for (index, axis) in ["x", "y", "z"].iter().enumerate() {
        let cells = columns.iter().map(|(_, all)| all[index].both());
        rows.add_row(std::iter::once(format!("  {axis}")).chain(cells));
    }
    print_line!("{rows}");
}

fn listed(parameters: &[&Parameter], printed: Printed) -> String {
    let name = |one: &Parameter| one.id.rsplit('.').next().unwrap_or_default().to_owned();
    let all = parameters.iter().map(|one| format!("{} {}", name(one), in_units(one, printed).both()));
    let unit = parameters.first().map(|one| in_units(one, printed).unit).unwrap_or_default();
    format!("{} {unit}", all.collect::<Vec<_>>().join(", "))
}

fn print_accelerometer(found: &Accelerometer, printed: Printed) {
    print_line!(
        "\naccelerometer: {} in {} orientations, g {}",
        counted(found.used().count(), "rest"),
        found.orientations,
        gravity(&found.gravity)
    );
    let kinds = [
        ("bias", "bias"),
        ("sensitivity", "sensitivity"),
        ("bias_per_k", "bias slope"),
        ("sensitivity_per_k", "sensitivity slope"),
    ];
    print_axes(&found.parameters, &kinds, printed);
    if !of_kind(&found.parameters, "bias_per_k").is_empty() {
        print_line!("  bias and sensitivity hold at {:.1} °C", found.model.reference_c);
    }
    print_line!("  angles between axes: {}", listed(&of_kind(&found.parameters, "angle"), printed));
    let [after, before] = found.rms_mps2.map(|rms| rms.map(|rms| three(rms / MG_MPS2)));
    let before = before.map_or_else(String::new, |before| format!("{before} → "));
    print_line!("  |a| − g at rest: {before}{} mg RMS", after.unwrap_or_else(|| "–".to_owned()));
    if let Some(share) = found.gravity.unknown_share() {
        print_line!(
            "  g is assumed: all three sensitivities may be off by the same {:.2} %; --latitude and --height remove this",
            100.0 * share
        );
    }
    let excluded = found.rests.iter().filter_map(|one| {
        let reason = one.rest.excluded.as_ref()?;
        Some(format!("  excluded: rest at {:.1} s: {}", one.rest.start_s, reason))
    });
    for line in first(excluded.collect(), printed.at_most(4)) {
        print_line!("{line}");
    }
    print_cautions(found.cautions(printed.units == Units::Field));
}

fn print_cautions(cautions: Vec<String>) {
    cautions.iter().for_each(|caution| print_line!("  caution: {caution}"));
}

fn print_gyro(gyro: &Gyro, printed: Printed) {
    let used = gyro.turns.iter().filter(|turn| turn.excluded.is_none()).count();
    print_line!("\ngyro: {} between rests, in the frame of the accelerometer", counted(used, "turn"));
    if gyro.parameters.is_empty() {
        return print_cautions(gyro.cautions());
    }
    print_axes(
        &gyro.parameters,
        &[("bias", "bias"), ("sensitivity", "sensitivity"), ("bias_per_k", "bias slope")],
        printed,
    );
    if gyro.refused.is_none() {
        print_line!("  cross-axis: {}", listed(&of_kind(&gyro.parameters, "cross"), printed));
        let [after, before] = gyro.rms_deg.map(|rms| rms.map(three));
        let before = before.map_or_else(String::new, |before| format!("{before} → "));
        print_line!(
            "  direction of gravity after a turn: {before}{}° RMS",
            after.unwrap_or_else(|| "–".to_owned())
        );
    }
    let by_g = of_kind(&gyro.parameters, "g_sensitivity");
    if let Some(largest) = by_g.iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs())) {
        let shown = in_units(largest, printed);
        match gyro.is_g_sensitive {
            true => print_line!("  g-sensitivity: up to {} {} ({})", shown.both(), shown.unit, largest.label),
            false => print_line!("  g-sensitivity: none found, below {} {}", shown.half_width, shown.unit),
        }
    }
    print_cautions(gyro.cautions());
}

fn print_next(found: &Accelerometer) {
    let next = &found.next;
    let [now, then] = next.worst_mps2.map(|size| three(size / MG_MPS2));
    print_line!(
        "\nnext: {}, 3 s: the widest interval ({}) narrows from ± {now} to ± {then} mg at 1 g",
        next.instruction,
        next.parameter
    );
    if let Some((accuracy, is_reached)) = found.accuracy {
        let asked = three(accuracy / MG_MPS2);
        match (is_reached, &found.plan) {
            (true, _) => {
                print_line!("accuracy of {asked} mg: reached, all intervals are within ± {now} mg at 1 g")
            }
            (false, Some(plan)) => print_line!(
                "accuracy of {asked} mg: not reached; {} more would do: {}",
                counted(plan.len(), "dwell"),
                plan.join("; ")
            ),
            (false, None) => print_line!(
                "accuracy of {asked} mg: not reached, and 12 more dwells are not enough: the residual of {} mg limits it; check that the device lies firmly and is warm",
                found.rms_mps2[0].map_or_else(|| "–".to_owned(), |rms| three(rms / MG_MPS2))
            ),
        }
    }
}

fn print_rests(rests: &[RestResidual]) {
    print_line!();
    let mut rows = table(&[
        "  rest",
        "start, s",
        "length, s",
        "up x",
        "y",
        "z",
        "residual, mg",
        "expected, mg",
        "excluded",
    ]);
    for (index, one) in rests.iter().enumerate() {
        let mut row = vec![
            format!("  {}", index + 1),
            format!("{:.1}", one.rest.start_s),
            format!("{:.1}", one.rest.duration_s),
        ];
        // A small negative part is 0.00, not -0.00.
        row.extend(one.up.map(|part| format!("{:.2}", (100.0 * part).round() / 100.0 + 0.0)));
        row.push(format!("{:.2}", one.residual_mps2 / MG_MPS2));
        row.push(format!("{:.2}", one.deviation_mps2 / MG_MPS2));
        row.push(one.rest.excluded.as_ref().map(ToString::to_string).unwrap_or_default());
        rows.add_row(row);
    }
    print_line!("{rows}");
}

fn print_turns(gyro: &Gyro) {
    print_line!();
    let mut rows =
        table(&["  from rest", "to", "start, s", "length, s", "angle, °", "residual, °", "excluded"]);
    for turn in &gyro.turns {
        let reason = turn.excluded.map(|reason| match reason {
            fos_calibrate::TurnExclusion::Clips => "clips",
            fos_calibrate::TurnExclusion::TooLong => "too long, or samples missing",
            fos_calibrate::TurnExclusion::Outlier => "outlier",
        });
        rows.add_row(vec![
            format!("  {}", turn.rests[0] + 1),
            (turn.rests[1] + 1).to_string(),
            format!("{:.1}", turn.start_s),
            format!("{:.1}", turn.duration_s),
            format!("{:.0}", turn.angle_deg),
            format!("{:.2}", turn.residual_deg),
            reason.unwrap_or_default().to_owned(),
        ]);
    }
    print_line!("{rows}");
}

fn print_correlations(parameters: &[Parameter], correlations: &[Vec<f64>]) {
    for (i, row) in correlations.iter().enumerate() {
        for (j, value) in row.iter().enumerate().take(i).filter(|(_, value)| value.abs() > CORRELATED) {
            print_line!("correlated: {} and {}, {value:.2}", parameters[j].label, parameters[i].label);
        }
    }
}

/// Prints a calibration on a turntable.
pub(super) fn print_turntable(found: &Turntable, printed: Printed) {
    let used = found.plateaus.iter().filter(|one| !one.excluded).count();
    let bias = if found.rests > 0 {
        format!("bias from {}", counted(found.rests, "rest"))
    } else {
        "bias from the plateaus".to_owned()
    };
    let rates: Vec<String> =
        found.rates_rads.iter().map(|rate| format!("{} °/s", three(rate.to_degrees()))).collect();
    print_line!("\ngyro on a turntable: {} at {}, {bias}", counted(used, "plateau"), rates.join(" and "));
    print_axes(&found.parameters, &[("bias", "bias"), ("sensitivity", "sensitivity")], printed);
    print_line!("  angles between axes: {}", listed(&of_kind(&found.parameters, "angle"), printed));
    let [after, before] = found.rms.map(|rms| rms.map(|rms| three(100.0 * rms)));
    let before = before.map_or_else(String::new, |before| format!("{before} → "));
    print_line!(
        "  |rate| against the stated rate: {before}{} % RMS",
        after.unwrap_or_else(|| "–".to_owned())
    );
    print_line!("  an error of the stated rate is an error of all three sensitivities");
    if printed.details {
        print_line!();
        let mut rows = table(&[
            "  plateau at, s",
            "length, s",
            "rate, °/s",
            "axis x",
            "y",
            "z",
            "residual, %",
            "excluded",
        ]);
        for one in &found.plateaus {
            let mut row = vec![
                format!("  {:.1}", one.start_s),
                format!("{:.1}", one.duration_s),
                three(one.rate_rads.to_degrees()),
            ];
            row.extend(one.axis.map(|part| format!("{:.2}", (100.0 * part).round() / 100.0 + 0.0)));
            row.push(format!("{:.3}", 100.0 * one.residual));
            row.push(if one.excluded { "outlier".to_owned() } else { String::new() });
            rows.add_row(row);
        }
        print_line!("{rows}");
        print_correlations(&found.parameters, &found.correlations);
    }
    print_hint(printed);
}
