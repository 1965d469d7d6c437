//! `table`: the paper's tables and figures, on any log.

use std::path::PathBuf;

use clap::Args;
use comfy_table::presets;

use super::arguments::{OutputFolder, Reading, axes, describe};
use super::numbers::{count, within};
use super::output::{Failure, number, print_json, print_line, progress, table};
use super::units::{ErrorUnit, Printed, Units, UnitsOption, three};
use crate::paper::{Cell, Comparison, Curves, Entry, PaperError, Settings, compare, figures};
use fos_data::stillness;
use fos_data::text::counted;
use fos_figures::plots;
use fos_fit::fit::Search;
use fos_fit::signal::wavelet::Denoising;

/// Reproduce the paper's tables and figures on a log
///
/// Errors are RMS in °/s, °/h or mg; with --units si they are the mean squares of the paper.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos simulate hour.parquet --band-limited --minutes 60 && fos table hour.parquet --axis ay,gy"
)]
pub(super) struct Table {
    /// The log, in any format that `fos formats` lists
    log: PathBuf,
    /// gx, a column, several with commas, or all
    #[arg(long, default_value = "all")]
    axis: String,
    /// Seconds at rest to train on, from the start
    #[arg(long, value_name = "SECONDS", default_value_t = 180.0, value_parser = within(0.001..=1e9))]
    train: f64,
    /// Seconds after those to choose a model on; the following ones are predicted
    #[arg(long, value_name = "SECONDS", default_value_t = 180.0, value_parser = within(0.001..=1e9))]
    evaluate: f64,
    /// Model orders 1 … this
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=50))]
    max_order: u16,
    /// Cross-product degrees 1 … this
    #[arg(long, default_value_t = 3, value_parser = count(1..=3))]
    degree: usize,
    /// De-noising before the autoregressions: WAVELET:LEVELS:KIND, as db4:4:soft, db4:3:approximation
    #[arg(long, default_value_t = Denoising::of_the_paper(), value_name = "WAVELET:LEVELS:KIND")]
    denoise: Denoising,
    /// How fos searches: greedy (the paper's) or exchange (terms are swapped until nothing improves)
    #[arg(long, default_value = "greedy")]
    search: Search,
    /// Number of fits whose median is the printed time
    #[arg(long, default_value_t = 5, value_parser = count(1..=1000))]
    repeats: usize,
    /// Draw autocorrelation, samples and error against order into this folder, as SVG and PNG
    #[arg(long, value_name = "FOLDER")]
    figures: Option<OutputFolder>,
    /// Print the tables as Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    #[command(flatten)]
    shown: UnitsOption,
    #[command(flatten)]
    reading: Reading,
    /// Print every method at every order as JSON
    #[arg(long)]
    json: bool,
}

impl Table {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let settings = Settings {
            train_s: self.train,
            evaluate_s: self.evaluate,
            max_order: self.max_order,
            max_degree: self.degree,
            denoising: self.denoise,
            repeats: self.repeats,
            search: self.search,
        };
        let recording = self.reading.read(&self.log)?;
        let stillness = stillness::find(&recording);
        if !self.json {
            print_line!("{}", describe(&recording, &stillness, Printed::default()));
        }
        let mut comparisons = Vec::new();
        for axis in axes(&recording, &self.axis)? {
            let entries = 8 + self.degree;
            let bar = progress((entries * usize::from(self.max_order)) as u64, &axis);
            let series = recording.error_series(&axis)?;
            let (comparison, split) =
                compare(&recording, &stillness, &series, &settings, |_| bar.inc(1)).map_err(helpful)?;
            bar.finish_and_clear();
            if let Some(folder) = &self.figures {
                let curves = Curves::of(&comparison, &recording, &series.values, &split);
                let figures = figures(&comparison, &curves);
                plots::write(folder, &comparison.column, &figures)?;
            }
            if !self.json {
                print(&comparison, &settings, self.markdown, self.shown.units);
            }
            comparisons.push(comparison);
        }
        if self.json {
            return print_json(&serde_json::json!({ "settings": settings, "axes": comparisons }));
        }
        if let Some(folder) = &self.figures {
            print_line!("\nfigures written to {}", folder.display());
        }
        Ok(())
    }
}

/// Adds advice for the command line.
fn helpful(error: PaperError) -> Failure {
    match error {
        PaperError::Split(short) => {
            format!("{short}\nhelp: a longer log, or shorter --train and --evaluate").into()
        }
        PaperError::Constant(_) => error.into(),
    }
}

fn print(comparison: &Comparison, settings: &Settings, markdown: bool, units: Units) {
    let [train, evaluate, predict] = comparison.samples;
    let error = ErrorShown::of(comparison, units);
    print_line!(
        "\n{}: {train} samples to train, {evaluate} to evaluate, {predict} to predict; {} in {}",
        comparison.column,
        error.name(),
        error.unit_of(comparison)
    );
    print_line!(
        "  de-noised by {}: the remaining band is 0 to {} Hz",
        settings.denoising,
        number(comparison.band_hz)
    );
    for order in [1, settings.max_order] {
        print_line!("\n  model order (largest output lag) {order}");
        let mut lines = table(&[
            "  method".to_owned(),
            "terms".to_owned(),
            format!("{} as in the paper", error.name()),
            "position, m".to_owned(),
            format!("{} same target", error.name()),
            "position, m".to_owned(),
            "time, ms".to_owned(),
        ]);
        for cell in comparison.cells.iter().filter(|cell| cell.order == order) {
            lines.add_row(line(cell, error));
        }
        if markdown {
            lines.load_style(presets::ASCII_MARKDOWN);
            print_line!();
        }
        print_line!("{lines}");
        for cell in comparison.cells.iter().filter(|cell| cell.order == order) {
            if let Err(reason) = &cell.result {
                print_line!("  {}: {reason}", cell.entry);
            }
        }
    }
    print_line!("\n  predicting the mean: {}", error.show(comparison.variance));
    if let Some((floor, (low, high))) = comparison.noise_floor {
        print_line!(
            "  noise floor of linear predictors: {} (95 %: {} … {}); * marks values below it: another target, or a nonlinear predictor",
            error.show(floor),
            error.show(low),
            error.show(high)
        );
    }
    if let Some(Cell { entry: Entry::Fos(degree), order, result: Ok(evaluated) }) =
        comparison.chosen.map(|index| &comparison.cells[index])
    {
        print_line!(
            "  chosen by the least error on the evaluation part: fos, L = {order}, CP {degree}, {}, {} on the same target {}",
            counted(evaluated.terms, "term"),
            error.name(),
            error.show(evaluated.mse_same_target)
        );
    }
}

/// Form in which the mean squares of a comparison are shown.
#[derive(Debug, Clone, Copy)]
enum ErrorShown {
    /// Roots, in a unit of the field.
    Rms(ErrorUnit),
    /// Mean squares, as in the paper.
    MeanSquare,
}

impl ErrorShown {
    fn of(comparison: &Comparison, units: Units) -> Self {
        match units {
            Units::Si => Self::MeanSquare,
            Units::Field => Self::Rms(ErrorUnit::of(&comparison.column, comparison.variance.sqrt(), units)),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rms(_) => "RMS",
            Self::MeanSquare => "MSE",
        }
    }

    fn unit_of(self, comparison: &Comparison) -> String {
        match self {
            Self::Rms(unit) => unit.label.to_owned(),
            Self::MeanSquare => format!("({})²", comparison.unit),
        }
    }

    fn show(self, mean_square: f64) -> String {
        match self {
            Self::Rms(unit) => unit.root(Some(mean_square)),
            Self::MeanSquare => number(mean_square),
        }
    }
}

fn line(cell: &Cell, error: ErrorShown) -> Vec<String> {
    let name = format!("  {}", cell.entry);
    match &cell.result {
        Err(_) => vec![name, "–".into(), "–".into(), "–".into(), "–".into(), "–".into(), "–".into()],
        Ok(evaluated) => {
            let marked = |mse, below| format!("{}{}", error.show(mse), if below { "*" } else { " " });
            let metres = |position: Option<f64>| position.map_or_else(|| "–".to_owned(), three);
            vec![
                name,
                evaluated.terms.to_string(),
                marked(evaluated.mse_as_fitted, evaluated.as_fitted_below_floor),
                metres(evaluated.position_error_as_fitted_m),
                marked(evaluated.mse_same_target, evaluated.same_target_below_floor),
                metres(evaluated.position_error_same_target_m),
                three(evaluated.time_s * 1e3),
            ]
        }
    }
}
