//! `compare`: a study, measured against model.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFolder, Reading, describe};
use super::comparison_summary::{LEGEND, summary};
use super::error_table::error_table;
use super::output::{Failure, number, print_json, print_line, print_warning, progress, table};
use fos_diagnose::compare::{AxisComparison, Comparison, Judgement, compare_study, lags_off};
use fos_diagnose::dependence::Dependence;
use fos_fit::evaluate::ModelErrors;

use crate::curves::curves;
use crate::figures::moved;
use crate::plots;
use fos_data::recording::{LoadOptions, Recording};
use fos_diagnose::study::{Study, load_again};

/// Compare the model of a study with measurements and with plain rivals, and show where it fails
#[derive(Debug, Args)]
#[command(after_help = "Example: fos compare unit.json field.parquet --figures figures")]
pub(super) struct Compare {
    /// The study
    study: PathBuf,
    /// The log; by default the study's own, judged on the rows that were not fitted
    log: Option<PathBuf>,
    /// Folder for the figures, SVG and PNG; made if it is not there
    #[arg(long, value_name = "FOLDER")]
    figures: Option<OutputFolder>,
    #[command(flatten)]
    reading: Reading,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let study = Study::read(&self.study)?;
        let read = self.reading.options_or(&study.data.read)?;
        let recording = match &self.log {
            Some(log) => self.reading.read_named(log, &read)?,
            None => self.fitted_log(&study, &read)?,
        };
        let same = study.data.is(&recording);
        if self.log.is_none() && !same {
            return Err(format!(
                "{}: it is read as {} rows, the study has {}\nhelp: give the log to compare with as an argument",
                recording.paths(),
                recording.n_rows(),
                study.data.rows
            )
            .into());
        }
        if let Some(off) = lags_off(&study.model, &recording) {
            print_warning(&format!(
                "the log runs at {:.3} Hz, the model was fitted at {:.3} Hz: its lags are {:.1} % off in time",
                recording.rate.true_hz,
                1.0 / study.model.period_s,
                100.0 * off
            ));
        }
        // where it still is what it was
        let own = if same { None } else { self.fitted_log(&study, &study.data.read).ok() };
        let bar = progress(4, "judging");
        let judged = |model: &str| {
            bar.set_message(&format!("judging: {model}"));
            bar.inc(1);
        };
        let Judgement { comparison, trace, stillness } =
            compare_study(&study, &recording, own.as_ref(), judged)?;
        bar.finish_and_clear();
        if let Some(folder) = &self.figures {
            let curves = curves(&comparison, &trace, &recording);
            plots::write_all(folder, &comparison, &curves, &moved(&recording, &stillness))?;
        }
        if self.json {
            return print_json(&comparison);
        }
        print_line!("{}", describe(&recording, &stillness));
        print_comparison(&comparison);
        if let Some(folder) = &self.figures {
            print_line!("\nfigures written to {}", folder.display());
        }
        Ok(())
    }

    /// The log, or the logs, that the study was fitted to.
    fn fitted_log(&self, study: &Study, read: &LoadOptions) -> Result<Recording, Failure> {
        let logs = study.data.sources.iter().map(|source| load_again(source, &self.study, read));
        Ok(Recording::join(logs.collect::<Result<_, _>>()?)?)
    }
}

/// The errors, the worst stretches and the dependences of every axis.
pub(super) fn print_comparison(comparison: &Comparison) {
    let (begin, end) = comparison.judged_s;
    print_line!("judged from {begin:.2} s to {end:.2} s, on rows at rest that were not fitted");
    if comparison.axes.len() > 1 {
        print_line!("\n{}\n{LEGEND}", summary(comparison));
    }
    for axis in &comparison.axes {
        print_axis(axis);
    }
}

fn print_axis(axis: &AxisComparison) {
    print_line!("\n{}: {} rows; squares in ({})²", axis.column, axis.rows, axis.unit);
    let errors: Vec<&ModelErrors> = axis.errors.iter().collect();
    print_line!("{}", error_table(&errors));
    match axis.noise_floor {
        Some((floor, (low, high))) => {
            print_line!("  noise floor {} (95 %: {} … {})", number(floor), number(low), number(high));
        }
        None => print_line!("  noise floor: not known, too little data"),
    }
    for caution in &axis.floor_cautions {
        print_line!("  caution: {caution}");
    }
    print_line!("  where it fails worst, coasting for at most 60 s:");
    for (index, stretch) in axis.worst.iter().enumerate() {
        print_line!(
            "  {}. {:.1} s – {:.1} s: rms {} {}, {:.1} times the usual, mean {}",
            index + 1,
            stretch.begin_s,
            stretch.end_s,
            number(stretch.rms),
            axis.unit,
            stretch.ratio,
            number(stretch.mean)
        );
        for special in &stretch.special {
            print_line!("     {special}");
        }
        if stretch.special.is_empty() {
            print_line!("     nothing logged is special there");
        }
    }
    match &axis.dependence {
        Some(dependence) => print_dependence(dependence),
        None => {
            print_line!("  what it depends on: not known, too few blocks at rest to tell from drifting noise")
        }
    }
}

/// Channels that are printed though chance explains them.
const SHOWN: usize = 4;

/// Cells that are printed.
const WORST_CELLS: usize = 5;

fn print_dependence(dependence: &Dependence) {
    print_line!(
        "  what is left of the slow error (less offset and physical part) against each channel, {} blocks of {:.1} s:",
        dependence.blocks,
        dependence.block_s
    );
    if !dependence.learnt {
        print_line!(
            "  caution: the noise was learnt from these rows themselves, as the log that was fitted is not at hand"
        );
    }
    let mut rows = table(&["  channel", "score", "p", "p of all", "best lag", "p of lag", ""]);
    let clear = dependence.channels.iter().filter(|channel| channel.is_clear()).count();
    for channel in dependence.channels.iter().take(clear.max(SHOWN)) {
        let lag = &channel.lag;
        rows.add_row([
            format!("  {}", channel.channel),
            format!("{:.1}", channel.curve.score),
            probability(channel.curve.p),
            probability(channel.p_of_all),
            // a delay of nothing means nothing
            if lag.p < 0.05 {
                format!("{} s ({} … {})", lag.best_s, lag.possible_s.0, lag.possible_s.1)
            } else {
                "–".into()
            },
            probability(lag.p),
            if channel.is_clear() { "depends" } else { "" }.into(),
        ]);
    }
    print_line!("{rows}");
    let others = dependence.channels.len().saturating_sub(clear.max(SHOWN));
    if others > 0 {
        print_line!("  and {others} more that it does not depend on");
    }
    let (worst, cells) = (dependence.power.worst(), dependence.power.cells.len());
    if worst.is_empty() {
        print_line!("  by time and frequency: none of {cells} cells has more power than chance explains");
        return;
    }
    print_line!(
        "  by time and frequency: {} of {cells} cells have more power than chance explains",
        worst.len()
    );
    for cell in worst.iter().take(WORST_CELLS) {
        print_line!(
            "     {:.1} s – {:.1} s, {} – {} Hz: {:.1} times the usual, p {}",
            cell.begin_s,
            cell.end_s,
            number(cell.low_hz),
            number(cell.high_hz),
            cell.times,
            probability(cell.p)
        );
    }
}

/// Two digits, as probabilities need.
fn probability(p: f64) -> String {
    if p >= 0.01 { format!("{p:.2}") } else { format!("{p:.0e}") }
}
