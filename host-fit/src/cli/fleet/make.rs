//! `fleet FOLDER`: the population of the units in a folder.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{OutputFile, Reading, library};
use crate::cli::output::{Failure, number, print_json, print_line, print_warning, progress, table};
use crate::program::this_build;
use fos_data::column::Column;
use fos_data::file::write_atomically;
use fos_diagnose::effects::{Regressor, SizeUnit};
use fos_fleet::{
    Asked, AxisSummary, BIAS, EstimateError, FALSE_ODD, PROGRAM, PartSummary, rows, rows_beside, units_in,
};

/// What is looked at, and where what it comes to goes.
#[derive(Debug, Args)]
pub(super) struct Make {
    /// The folder: a log for each unit, in a folder for each lot; or with a table units.csv: unit,part,lot,log
    #[arg(required = true)] // unless there is a subcommand
    folder: Option<PathBuf>,
    /// Where the populations go; the rows of the units are kept beside it, under the same name with .rows behind it
    #[arg(short, long, default_value = "population.json")]
    output: OutputFile,
    /// What the error may depend on, beside a bias at 25 °C, as in the files of effects: "temp_c * temp_c", "temp_c:lowpass(60)". May be
    /// repeated
    #[arg(long = "regressor", value_name = "REGRESSOR", default_value = "temp_c")]
    regressors: Vec<String>,
    /// Diagnose every axis of every unit too: which effects the part has. Takes some seconds each
    #[arg(long)]
    diagnose: bool,
    /// Effects of your own to diagnose, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Print the populations as JSON
    #[arg(long)]
    json: bool,
}

impl Make {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        for regressor in &self.regressors {
            Regressor::parse(regressor)
                .map_err(|reason| EstimateError::Regressor { regressor: regressor.clone(), reason })?;
        }
        let units = units_in(self.folder.as_deref().ok_or("no folder")?)?;
        let asked = Asked {
            regressors: self.regressors.clone(),
            diagnosed: self.diagnose,
            read: self.reading.options()?,
        };
        let kept_in = rows_beside(&self.output);
        let bar = progress(units.len() as u64, "looking at the units");
        let found = rows(&units, &asked, &library, PROGRAM, &this_build(), &kept_in, |done| {
            bar.set_position(done as u64)
        })?;
        bar.finish_and_clear();
        let fleet = fos_fleet::Fleet::of(&found, &asked, &library, PROGRAM);
        if fleet.parts.iter().all(|part| part.axes.is_empty()) {
            let first = fleet.failed.first().and_then(|failed| Some((&failed.unit, failed.reasons.first()?)));
            let (unit, reason) = first.ok_or("the fleet has no unit")?;
            return Err(format!("none of {} units tells anything; {unit}: {reason}", fleet.units).into());
        }
        write_atomically(&self.output, &fleet.to_bytes())?;
        for failed in &fleet.failed {
            for reason in &failed.reasons {
                print_warning(&format!("{}: {reason}", failed.unit));
            }
        }
        for duplicate in &fleet.duplicates {
            print_warning(&duplicate.to_string());
        }
        if self.json {
            return print_json(&fleet);
        }
        for part in &fleet.parts {
            print_part(part);
        }
        print_line!(
            "{} units, {} of them with something that could not be told",
            fleet.units,
            fleet.failed.len()
        );
        print_line!("written to {}", self.output.display());
        Ok(())
    }
}

fn print_part(part: &PartSummary) {
    if !part.part.is_empty() {
        print_line!("{}", part.part);
    }
    let mut of_axes = table(&[
        "axis",
        "coefficient",
        "unit",
        "units",
        "mean",
        "between units",
        "between lots",
        "lots alike",
        "error of a log",
    ]);
    for axis in &part.axes {
        add_rows(&mut of_axes, axis);
    }
    print_line!("{of_axes}");
    print_line!(
        "mean and standard deviations with their 90 % intervals; lots alike: probability that lots that do not differ look so different"
    );
    for axis in part.axes.iter().filter(|axis| !axis.effects.is_empty()) {
        let mut shares = table(&["axis", "effect", "units that have it", "mean fall of the error"]);
        for share in &axis.effects {
            let [with, asked] = share.units;
            shares.add_row(vec![
                axis.column.clone(),
                share.effect.clone(),
                format!("{with} of {asked}"),
                format!("{:.1} %", 100.0 * share.mean_reduction),
            ]);
        }
        print_line!("\n{shares}");
    }
    if let Some(sentence) = part.not_conclusive() {
        print_line!("\nodd units: {sentence}");
    }
    if part.odd.is_empty() {
        if part.units_needed.is_none() {
            print_line!("\nno unit is unlike the others");
        }
        print_line!("");
        return;
    }
    print_line!("\nunits that do not belong (on average at most {:.0} % of these do):", 100.0 * FALSE_ODD);
    let mut odd = table(&["unit", "lot", "axis", "by", "standard deviations", "p"]);
    for unit in &part.odd {
        odd.add_row(vec![
            unit.unit.clone(),
            unit.lot.clone().unwrap_or_default(),
            unit.column.clone(),
            unit.distance.most.clone(),
            number(unit.distance.by),
            format!("{:.1e}", unit.p_value),
        ]);
    }
    print_line!("{odd}\n");
}

fn add_rows(of_axes: &mut comfy_table::Table, axis: &AxisSummary) {
    let Some(population) = &axis.population else {
        let reason = axis.without.clone().unwrap_or_default();
        print_warning(&format!("{}: {reason}", axis.column));
        return;
    };
    let unit = SizeUnit::of_axis(Column::named(&axis.column));
    for (place, (name, scatter)) in population.names.iter().zip(&population.scatter).enumerate() {
        let told = |value: f64| number(value / unit.si);
        let [low, high] = scatter.units_interval.map(told);
        let [mean_low, mean_high] = population.mean_interval(place).map(told);
        let between_lots = match scatter.lots_alike {
            Some(_) => told(scatter.lots),
            None => "–".to_owned(),
        };
        of_axes.add_row(vec![
            axis.column.clone(),
            name.clone(),
            if name == BIAS { unit.to_string() } else { format!("{unit} per {name}") },
            population.units.to_string(),
            format!("{} ({mean_low} to {mean_high})", told(population.mean[place])),
            format!("{} ({low} to {high})", told(scatter.units)),
            between_lots,
            scatter.lots_alike.map_or_else(|| "–".to_owned(), |p| format!("{p:.3}")),
            told(scatter.measurement),
        ]);
    }
}
