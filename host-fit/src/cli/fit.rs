//! `fit`: fits a log and writes a study.

use std::path::PathBuf;

use clap::Args;
use fos_core::GRAVITY_MPS2;

use super::arguments::{OutputFile, Reading, axes, describe, read_all, usable};
use super::comparison_summary::{LEGEND, Row, table_of};
use super::error_table::{error_table, error_unit};
use super::numbers::{IN_UNIT, count, within};
use super::output::{Failure, grouped, number, print_hint, print_json, print_line, progress, table};
use super::units::{Printed, three};
use fos_data::file::compare_and_swap::FileVersion;
use fos_data::text::counted;
use fos_diagnose::cautions::worse_than_mean;
use fos_diagnose::compare::study_of;
use fos_diagnose::study::Study;
use fos_fit::candidates::MAX_LAG;
use fos_fit::fit::{
    AxisReport, FitMethod, FitOptions, InputSpec, LeftOut, Search, Stop, Train, fit_axes, rest,
};
use fos_fit::signal::wavelet::Denoising;
use fos_report::physical_terms::physical_terms;

/// Fit a model of the error of one or more axes
#[derive(Debug, Args)]
#[command(after_help = "Example: fos fit reference.csv.gz --axis all -o unit.json")]
pub(super) struct Fit {
    /// The log, in any format that `fos formats` lists. Several logs of one device are fitted together; one that begins
    /// where another ends continues it
    #[arg(required = true)]
    log: Vec<PathBuf>,
    /// gx, a column, several with commas, or all
    #[arg(long, default_value = "all")]
    axis: String,
    /// The study to write
    #[arg(short, long, default_value = "study.json")]
    output: OutputFile,
    /// How the stochastic part is found: fos, or all lags by yule-walker, covariance, modified-covariance, burg
    #[arg(long, default_value = "fos")]
    method: FitMethod,
    /// De-noise the training data first, for methods other than fos: WAVELET:LEVELS:KIND, as db4:4:soft,
    /// db4:3:approximation
    #[arg(long, value_name = "WAVELET:LEVELS:KIND")]
    denoise: Option<Denoising>,
    /// How fos searches: exchange (terms are swapped until nothing improves) or greedy (the paper's)
    #[arg(long, default_value = "exchange")]
    search: Search,
    /// L: output lags 1 … L are candidates; the order of the other methods
    #[arg(long, default_value_t = FitOptions::default().max_lag, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_LAG)))]
    max_lag: u16,
    /// Cross-product degree (CP): 1, 2 or 3
    #[arg(long, default_value_t = FitOptions::default().degree, value_parser = count(1..=3))]
    degree: usize,
    /// Time constants of the low-passes of the output that are candidates, s; "none" for none
    #[arg(long, default_value = "0.1,1,10,100")]
    memory: String,
    /// Offer an input to the search: temp_c, temp_c:lowpass(60), clock:decay(200). May be repeated
    #[arg(long, value_name = "INPUT")]
    input: Vec<InputSpec>,
    /// K: lags 0 … K of these inputs are candidates, and their products with output lags up to CP
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=i64::from(MAX_LAG)))]
    input_lags: u16,
    /// Put an input into the physical part, which also holds in motion. May be repeated
    #[arg(long, value_name = "INPUT")]
    physical: Vec<InputSpec>,
    /// Largest number of terms of an axis
    #[arg(long, default_value_t = FitOptions::default().max_terms, value_parser = count(0..=10_000))]
    max_terms: usize,
    /// Stop rule: multiplicity (allows for the number of candidates), korenberg, never
    #[arg(long, default_value = "multiplicity")]
    stop: Stop,
    /// Part of the log to train on, from its start: a share (50%) or a time (180s)
    #[arg(long, default_value = "50%")]
    train: Train,
    /// Subtract this from the error instead of its mean, in SI units
    #[arg(long, allow_negative_numbers = true, value_parser = within(-IN_UNIT..=IN_UNIT))]
    offset: Option<f64>,
    /// Scale by this instead of the standard deviation, in SI units
    #[arg(long, value_parser = within(1.0 / IN_UNIT..=IN_UNIT))]
    scale: Option<f64>,
    /// Measured values of this magnitude count as saturated, in SI units; 0 for none
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0..=IN_UNIT))]
    full_scale: f64,
    /// The values of the log are after a factory's or driver's correction
    #[arg(long)]
    factory_corrected: bool,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    printed: Printed,
    /// Print the study as JSON
    #[arg(long)]
    json: bool,
}

impl Fit {
    fn options(&self) -> Result<FitOptions, Failure> {
        let memory_s = match self.memory.as_str() {
            "none" => Vec::new(),
            list => list
                .split(',')
                .map(|tau| match tau.trim().parse::<f64>() {
                    Ok(tau) if tau > 0.0 && tau.is_finite() => Ok(tau),
                    _ => Err(format!("--memory: {tau:?} is not a positive time in seconds")),
                })
                .collect::<Result<_, _>>()?,
        };
        if self.denoise.is_some() && self.method == FitMethod::Fos {
            return Err("--denoise goes with --method yule-walker, covariance, modified-covariance or burg: fos is fitted to the data as measured".into());
        }
        Ok(FitOptions {
            method: self.method,
            denoising: self.denoise,
            search: self.search,
            max_lag: self.max_lag,
            degree: self.degree,
            memory_s,
            inputs: self.input.clone(),
            input_lags: self.input_lags,
            physical: self.physical.clone(),
            max_terms: self.max_terms,
            stop: self.stop,
            train: self.train,
            offset: self.offset,
            scale: self.scale,
            full_scale: self.full_scale,
            fitted_on: match self.factory_corrected {
                true => fos_core::FittedOn::FactoryCorrected,
                false => fos_core::FittedOn::Raw,
            },
        })
    }

    pub(super) fn run(&self) -> Result<(), Failure> {
        let options = self.options()?;
        let file = FileVersion::now(&self.output)?;
        let read = self.reading.options()?;
        let recording = read_all(&self.log, &read)?;
        let stillness = rest(&recording, options.train);
        if !self.json {
            print_line!("{}", describe(&recording, &stillness, self.printed));
        }
        let axes = axes(&recording, &self.axis)?;
        let bar = progress(axes.len() as u64, "fitting");
        let fits = fit_axes(&recording, &stillness, &axes, &options, &|| bar.inc(1));
        bar.finish_and_clear();
        let fits = usable(&self.axis, fits)?;
        let mut study = study_of(&recording, &stillness, fits, options, read, &mut |_| {})?;
        study.write(&file)?;
        if self.json {
            return print_json(&study);
        }
        print_study(&study, self.printed);
        print_line!("\nstudy written to {}", self.output.display());
        print_hint(self.printed);
        Ok(())
    }
}

/// A row for each axis; with `--details` the model of every axis and all its errors.
fn print_study(study: &Study, printed: Printed) {
    print_line!(
        "  at rest {:.1} % of the rows, known {}; trained on the first {} rows",
        100.0 * study.data.still_share,
        study.data.still_known_by.describe(),
        study.data.trained_rows
    );
    let errors = |axis: usize| study.steps.iter().map(move |step| &step.errors[axis]);
    let rows = study.axes.iter().enumerate().map(|(axis, report)| Row {
        column: &report.column,
        errors: errors(axis).collect(),
        remark: terms(study, &report.column),
    });
    let rows: Vec<Row<'_>> = rows.collect();
    let is_alone = study.axes.len() == 1;
    if !printed.details {
        print_line!("\n{}\n{LEGEND}, on rows that were not fitted", table_of(&rows, "terms", printed.units));
    }
    for report in &study.axes {
        if printed.details || is_alone {
            print_selection(report, printed);
        }
        if let Some(axis) = study.model.axes.iter().find(|axis| axis.column == report.column) {
            let terms = physical_terms(&study.model, axis, printed.units);
            if !terms.is_empty() {
                print_line!("  physical part of {}: {}", report.column, terms.join("; "));
            }
        }
    }
    let cautions = study.axes.iter().zip(&rows).flat_map(|(report, row)| {
        let all = cautions(report).into_iter().chain(worse_than_mean(row.errors.iter().copied()));
        all.map(|caution| (report.column.as_str(), caution))
    });
    for caution in grouped(cautions, study.axes.len()) {
        print_line!("  caution: {caution}");
    }
    if !printed.details {
        return;
    }
    for Row { column, errors, .. } in &rows {
        print_line!("\n{column}: errors on the rows that were not fitted");
        print_line!("{}", error_table(errors, error_unit(column, errors, printed.units)));
    }
}

/// The number of terms in the model of an axis.
fn terms(study: &Study, column: &str) -> String {
    let axis = study.model.axes.iter().find(|axis| axis.column == column);
    axis.map_or(0, |axis| axis.stochastic.len() + axis.physical.len()).to_string()
}

fn cautions(report: &AxisReport) -> Vec<String> {
    let outliers = (report.spikes > 0).then(|| format!("{} excluded", counted(report.spikes, "outlier")));
    let left_out = report.left_out.iter().map(|LeftOut { input, coefficient, standard_error }| {
        format!(
            "{input} is excluded from the physical part: its scaled coefficient, {} with a standard error of {}, is not significant on these rows",
            three(*coefficient),
            three(*standard_error)
        )
    });
    outliers.into_iter().chain(left_out).collect()
}

fn print_selection(report: &AxisReport, printed: Printed) {
    print_line!(
        "\n{}: {}, {} over {} rows; {}; condition number {}",
        report.column,
        report.method,
        counted(report.candidates, "candidate"),
        report.rows,
        report.stopped,
        three(report.condition_number)
    );
    if !report.steps.is_empty() {
        let mut steps = table(&["  term", "MSE reduction", "ERR", "MSE after"]);
        for step in &report.steps {
            steps.add_row(vec![
                format!("  {}", step.monomial),
                number(step.mse_reduction),
                number(step.error_reduction_ratio),
                number(step.mse),
            ]);
        }
        print_line!("{steps}");
    }
    for (number_of, pose) in (1..).zip(&report.poses) {
        let force: Vec<String> = pose.force.iter().map(|force| number(*force)).collect();
        let size = pose.force.iter().map(|force| force * force).sum::<f64>().sqrt();
        let away = match pose.force.len() {
            3 => format!(", |a| − g {} m/s²", number(size - f64::from(GRAVITY_MPS2))),
            _ => String::new(),
        };
        print_line!(
            "  orientation {number_of}, with a separate constant: from {:.1} s on, {} m/s²{away}",
            pose.from_s,
            force.join(", ")
        );
    }
    if printed.details && !report.ties.is_empty() {
        print_line!("  equally good on these data (n·ln of the MSE ratio):");
        for tie in &report.ties {
            print_line!("    {} for {}: {:.2}", tie.enters.join(", "), tie.leaves.join(", "), tie.deviance);
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args as _, Command, FromArgMatches as _};

    use super::*;
    use fos_report::command_lines::fit_options;

    /// The command of a report dropped them, and fitted another model.
    #[test]
    fn options_of_a_fit_are_parsed_back() {
        let settings = FitOptions {
            search: Search::Greedy,
            max_lag: 3,
            degree: 1,
            memory_s: vec![0.5, 20.0],
            inputs: vec!["temp_c:lowpass(60)".parse().expect("an input")],
            input_lags: 1,
            physical: vec!["temp_c".parse().expect("an input")],
            max_terms: 7,
            stop: Stop::Never,
            train: Train::Share(0.99),
            offset: Some(-1e-3),
            scale: Some(0.2),
            full_scale: 34.9,
            fitted_on: fos_core::FittedOn::FactoryCorrected,
            ..FitOptions::default()
        };
        let burg = FitOptions {
            method: "burg".parse().expect("a method"),
            denoising: Some("db4:3:approximation".parse().expect("a kind")),
            memory_s: Vec::new(),
            train: Train::Seconds(180.0),
            ..FitOptions::default()
        };
        for settings in [settings, burg, FitOptions::default()] {
            let line = format!("fit log.csv{}", fit_options(&settings));
            let words = line.split(' ').map(|word| word.trim_matches('\''));
            let matches =
                Fit::augment_args(Command::new("fit")).try_get_matches_from(words).expect("options");
            let parsed = Fit::from_arg_matches(&matches).expect("valid").options().expect("options");
            assert_eq!(parsed, settings, "{line}");
        }
    }
}
