//! `fleet FOLDER`: the population of the devices in a folder.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{OutputFile, Reading, library};
use crate::cli::output::{Failure, print_json, print_line, print_warning, progress, table};
use crate::cli::units::{Units, UnitsOption, percent, three};
use crate::program::this_build;
use fos_data::column::Column;
use fos_data::file::write_atomically;
use fos_data::text::counted;
use fos_diagnose::effects::SizeUnit;
use fos_figures::units::three_beside;
use fos_fleet::{
    Asked, AxisSummary, FALSE_ODD, PROGRAM, PartSummary, check_regressors, rows, rows_beside, units_in,
};
use fos_report::fleet::unit_in_words;

/// The devices, and the files to write.
#[derive(Debug, Args)]
pub(super) struct Make {
    /// The folder: a log for each device, in a folder for each lot; or a case folder for each; or a table units.csv: unit,part,lot,log
    #[arg(required = true)] // unless there is a subcommand
    folder: Option<PathBuf>,
    /// The populations to write; the rows of the devices are stored next to it, under the same name with .rows appended
    #[arg(short, long, default_value = "population.json")]
    output: OutputFile,
    /// A regressor beside the bias at 25 °C, as in effect files: "temp_c * temp_c", "temp_c:lowpass(60)". May be repeated
    #[arg(long = "regressor", value_name = "REGRESSOR", default_value = "temp_c")]
    regressors: Vec<String>,
    /// Diagnose every axis of every device too, for the effects of the part. Takes some seconds each
    #[arg(long)]
    diagnose: bool,
    /// Effects of your own to diagnose, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    #[command(flatten)]
    shown: UnitsOption,
    #[command(flatten)]
    reading: Reading,
    /// Print the populations as JSON
    #[arg(long)]
    json: bool,
}

impl Make {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        check_regressors(&self.regressors)?;
        let units = units_in(self.folder.as_deref().ok_or("no folder")?)?;
        let asked = Asked {
            regressors: self.regressors.clone(),
            diagnosed: self.diagnose,
            read: self.reading.options()?,
        };
        let kept_in = rows_beside(&self.output);
        let bar = progress(units.len() as u64, "reading the devices");
        let found = rows(&units, &asked, &library, PROGRAM, &this_build(), &kept_in, |done| {
            bar.set_position(done as u64)
        })?;
        bar.finish_and_clear();
        let fleet = fos_fleet::Fleet::of(&found, &asked, &library, PROGRAM);
        if fleet.parts.iter().all(|part| part.axes.is_empty()) {
            let first = fleet.failed.first().and_then(|failed| Some((&failed.unit, failed.reasons.first()?)));
            let (unit, reason) = first.ok_or("the fleet has no device")?;
            return Err(format!("none of {} devices can be used; {unit}: {reason}", fleet.units).into());
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
            print_part(part, self.shown.units);
        }
        print_line!("{}, {} with incomplete data", counted(fleet.units, "device"), fleet.failed.len());
        print_line!("written to {}", self.output.display());
        Ok(())
    }
}

fn print_part(part: &PartSummary, units: Units) {
    if !part.part.is_empty() {
        print_line!("{}", part.part);
    }
    let mut of_axes = table(&[
        "axis",
        "coefficient",
        "unit",
        "devices",
        "mean",
        "between devices",
        "between lots",
        "lots alike",
        "error of a log",
    ]);
    for axis in &part.axes {
        add_rows(&mut of_axes, axis, units);
    }
    print_line!("{of_axes}");
    print_line!(
        "mean and standard deviations with their 90 % intervals; lots alike: p-value of the F test for equal lots"
    );
    for axis in part.axes.iter().filter(|axis| !axis.effects.is_empty()) {
        let mut shares =
            table(&["axis", "effect", "devices that have it", "mean reduction, variance explained"]);
        for share in &axis.effects {
            let [with, asked] = share.units;
            shares.add_row(vec![
                axis.column.clone(),
                share.effect.clone(),
                format!("{with} of {asked}"),
                percent(share.mean_reduction),
            ]);
        }
        print_line!("\n{shares}");
    }
    if let Some(sentence) = part.not_conclusive() {
        print_line!("\nOdd devices: {}", sentence.replacen('N', "n", 1));
    }
    if part.odd.is_empty() {
        if part.units_needed.is_none() {
            print_line!("\nno odd devices");
        }
        print_line!("");
        return;
    }
    print_line!(
        "\nodd devices (on average at most {:.0} % of these are false positives):",
        100.0 * FALSE_ODD
    );
    let mut odd = table(&["device", "lot", "axis", "coefficient", "standard deviations", "p"]);
    for unit in &part.odd {
        odd.add_row(vec![
            unit.unit.clone(),
            unit.lot.clone().unwrap_or_default(),
            unit.column.clone(),
            unit.distance.most.clone(),
            three(unit.distance.by),
            format!("{:.1e}", unit.p_value),
        ]);
    }
    print_line!("{odd}\n");
}

fn add_rows(of_axes: &mut comfy_table::Table, axis: &AxisSummary, units: Units) {
    let Some(population) = &axis.population else {
        let reason = axis.without.clone().unwrap_or_default();
        print_warning(&format!("{}: {reason}", axis.column));
        return;
    };
    let unit = SizeUnit::of_axis(Column::named(&axis.column));
    for (place, (name, scatter)) in population.names.iter().zip(&population.scatter).enumerate() {
        let (one, unit_name) = match units {
            Units::Field => (unit.si, unit.spelled()),
            Units::Si => (1.0, unit.in_si()),
        };
        let [lowest, highest] = population.mean_interval(place);
        let scale = (highest - lowest).max(scatter.units).max(scatter.measurement) / one;
        let shown = |value: f64| three_beside(value / one, scale);
        let [low, high] = scatter.units_interval.map(shown);
        let [mean_low, mean_high] = population.mean_interval(place).map(shown);
        let between_lots = match scatter.lots_alike {
            Some(_) => shown(scatter.lots),
            None => "–".to_owned(),
        };
        of_axes.add_row(vec![
            axis.column.clone(),
            name.clone(),
            unit_in_words(&unit_name, name),
            population.units.to_string(),
            format!("{} ({mean_low} to {mean_high})", shown(population.mean[place])),
            format!("{} ({low} to {high})", shown(scatter.units)),
            between_lots,
            scatter.lots_alike.map_or_else(|| "–".to_owned(), |p| format!("{p:.3}")),
            shown(scatter.measurement),
        ]);
    }
}
