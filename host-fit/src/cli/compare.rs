//! `compare`: evaluates a study on a log, against simple rivals.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFolder, Reading, describe};
use super::comparison_summary::{LEGEND, summary};
use super::error_table::{error_table, error_unit};
use super::output::{Failure, grouped, print_hint, print_json, print_line, print_warning, progress, table};
use super::refinement::columns_of;
use super::units::{ErrorUnit, Printed, three};
use fos_diagnose::compare::{AxisComparison, Comparison, Evaluation, compare_study, lags_off};
use fos_diagnose::dependence::Dependence;
use fos_fit::evaluate::{ModelErrors, Stretch};

use fos_data::recording::{LoadOptions, Recording};
use fos_diagnose::study::{Study, load_again};
use fos_figures::curves::curves;
use fos_figures::moved;
use fos_figures::plots;
use fos_report::unaided::{LEGEND as LEGEND_UNAIDED, LEGEND_STRAPDOWN, UnaidedRow};

/// Compare a model with a log and with simple rivals, and show where it fails
#[derive(Debug, Args)]
#[command(after_help = "Example: fos compare unit.json log.parquet --figures figures")]
pub(super) struct Compare {
    /// The study
    study: PathBuf,
    /// The log; by default the study's own, evaluated on the rows that were not fitted
    log: Option<PathBuf>,
    /// gx, a column, or several with commas; all axes of the study if not given
    #[arg(long)]
    axis: Option<String>,
    /// Folder for the figures, SVG and PNG; created if missing
    #[arg(long, value_name = "FOLDER")]
    figures: Option<OutputFolder>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    printed: Printed,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let study = Study::read(&self.study)?;
        let columns = columns_of(&study, self.axis.as_deref())?;
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
        // Only if the log is unchanged.
        let own = if same { None } else { self.fitted_log(&study, &study.data.read).ok() };
        let bar = progress(4, "evaluating");
        let mut evaluation = |model: &str| {
            bar.set_message(&format!("evaluating: {model}"));
            bar.inc(1);
        };
        let Evaluation { comparison, trace, stillness } =
            compare_study(&study, &columns, &recording, own.as_ref(), &mut evaluation)?;
        bar.finish_and_clear();
        if let Some(folder) = &self.figures {
            let curves = curves(&comparison, &trace, &recording);
            plots::write_all(folder, &comparison, &curves, &moved(&recording, &stillness))?;
        }
        if self.json {
            return print_json(&comparison);
        }
        print_line!("{}", describe(&recording, &stillness, self.printed));
        print_comparison(&comparison, self.printed);
        if let Some(folder) = &self.figures {
            print_line!("\nfigures written to {}", folder.display());
        }
        print_hint(self.printed);
        Ok(())
    }

    /// Reads the logs of the study's fit.
    fn fitted_log(&self, study: &Study, read: &LoadOptions) -> Result<Recording, Failure> {
        study.fitted_log(|source| Ok(load_again(source, &self.study, read)?))
    }
}

/// A row for each axis, and the worst stretches; with `--details` all errors and dependences of every axis.
fn print_comparison(comparison: &Comparison, printed: Printed) {
    let (begin, end) = comparison.evaluated_s;
    print_line!("evaluated from {begin:.2} s to {end:.2} s, on rows at rest that were not fitted");
    print_line!("\n{}\n{LEGEND}", summary(comparison, printed.units));
    print_unaided(comparison, printed);
    if printed.details {
        return comparison.axes.iter().for_each(|axis| print_axis(axis, printed));
    }
    let of_axes = |remarks: fn(&AxisComparison) -> Vec<String>| {
        let each = comparison
            .axes
            .iter()
            .flat_map(move |axis| remarks(axis).into_iter().map(|remark| (axis.column.as_str(), remark)));
        grouped(each, comparison.axes.len())
    };
    for caution in of_axes(cautions) {
        print_line!("  caution: {caution}");
    }
    for axis in &comparison.axes {
        let unit = unit_of(axis, printed);
        if let Some(stretch) = axis.worst.first() {
            print_line!("  {} fails worst {}", axis.column, place(stretch, unit));
        }
    }
    if let [axis] = &comparison.axes[..]
        && let Some(dependence) = &axis.dependence
    {
        print_channels(dependence);
    }
}

/// Name of the errors of six axes integrated together.
const STRAPDOWN: &str = "strapdown";

/// A sentence for each time without aiding if there is one axis or with `--details`, otherwise a table.
fn print_unaided(comparison: &Comparison, printed: Printed) {
    let of_axes: Vec<(&str, Vec<UnaidedRow>)> = comparison
        .axes
        .iter()
        .filter(|axis| axis.rows > 0)
        .map(|axis| (axis.column.as_str(), UnaidedRow::all(axis, printed.units)))
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    if of_axes.is_empty() {
        return;
    }
    let together = UnaidedRow::of_strapdown(&comparison.strapdown, printed.units);
    if printed.details || comparison.axes.len() == 1 {
        let together = (!together.is_empty()).then_some((STRAPDOWN, together));
        for (column, rows) in of_axes.iter().chain(&together) {
            print_line!("\n  {column}");
            rows.iter().for_each(|row| print_line!("  {}", row.sentence()));
        }
    } else {
        let windows = of_axes[0].1.iter().map(|row| row.window.clone());
        let header = ["  axis".to_owned(), "without aiding".to_owned()].into_iter().chain(windows);
        let mut rows_of_table = table(&header.collect::<Vec<_>>());
        for (column, rows) in &of_axes {
            let quantity = format!("{}, {}", rows[0].quantity, rows[0].unit);
            let cells = rows.iter().map(UnaidedRow::cell);
            rows_of_table.add_row([format!("  {column}"), quantity].into_iter().chain(cells));
        }
        for rows in together.chunk_by(|one, other| one.quantity == other.quantity) {
            let quantity = format!("{}, {}", rows[0].quantity, rows[0].unit);
            let cells = rows.iter().map(UnaidedRow::cell);
            rows_of_table.add_row([format!("  {STRAPDOWN}"), quantity].into_iter().chain(cells));
        }
        print_line!("\n{rows_of_table}");
    }
    print_line!("  {LEGEND_UNAIDED}");
    if !comparison.strapdown.is_empty() {
        print_line!("  {LEGEND_STRAPDOWN}");
    }
}

/// Time of a stretch, its error, and its distinctive properties.
fn place(stretch: &Stretch, unit: ErrorUnit) -> String {
    let special = stretch.special.iter().map(|special| format!("; {special}"));
    format!(
        "from {:.1} s to {:.1} s: slow error {} {} RMS, {:.1} times the usual{}",
        stretch.begin_s,
        stretch.end_s,
        unit.show(stretch.rms),
        unit.label,
        stretch.ratio,
        special.collect::<String>()
    )
}

fn unit_of(axis: &AxisComparison, printed: Printed) -> ErrorUnit {
    error_unit(&axis.column, &axis.errors.iter().collect::<Vec<_>>(), printed.units)
}

/// Reason why an axis was not evaluated on any row.
const NOT_EVALUATED: &str = "not evaluated: no row at rest in the orientation of the fit, where the true value of an accelerometer is known; fit a log \
                             in this orientation, or log the true values as ref_ columns";

fn cautions(axis: &AxisComparison) -> Vec<String> {
    if axis.rows == 0 { vec![NOT_EVALUATED.to_owned()] } else { axis.cautions.clone() }
}

fn print_axis(axis: &AxisComparison, printed: Printed) {
    let unit = unit_of(axis, printed);
    print_line!("\n{}: {} rows", axis.column, axis.rows);
    if axis.rows == 0 {
        return print_line!("  {NOT_EVALUATED}");
    }
    let errors: Vec<&ModelErrors> = axis.errors.iter().collect();
    print_line!("{}", error_table(&errors, unit));
    match axis.noise_floor {
        Some((floor, (low, high))) => {
            let [floor, low, high] = [floor, low, high].map(|variance| unit.root(Some(variance)));
            print_line!("  noise floor {floor} {} RMS (95 %: {low} … {high})", unit.label);
        }
        None => print_line!("  noise floor: not known, too little data"),
    }
    for caution in cautions(axis) {
        print_line!("  caution: {caution}");
    }
    match axis.worst.is_empty() {
        true => {
            print_line!("  no stretch stands out: the slow error is equally large everywhere, within noise")
        }
        false => print_line!("  where it fails worst, in a free run of at most 60 s:"),
    }
    for (index, stretch) in axis.worst.iter().enumerate() {
        print_line!("  {}. {}", index + 1, place(stretch, unit));
    }
    match &axis.dependence {
        Some(dependence) => {
            print_channels(dependence);
            print_cells(dependence);
        }
        None => print_line!(
            "  dependence on channels: not known, too few blocks at rest to separate it from drifting noise"
        ),
    }
}

/// Number of channels printed even if their dependence is explained by chance.
const SHOWN: usize = 4;

/// Number of printed cells.
const WORST_CELLS: usize = 5;

fn print_channels(dependence: &Dependence) {
    print_line!(
        "  residual of the slow error against each channel, {} blocks of {:.1} s:",
        dependence.blocks,
        dependence.block_s
    );
    let mut rows = table(&["  channel", "score", "p", "p of all", "best lag", "p of lag", ""]);
    let clear = dependence.channels.iter().filter(|channel| channel.is_clear()).count();
    for channel in dependence.channels.iter().take(clear.max(SHOWN)) {
        let lag = &channel.lag;
        rows.add_row([
            format!("  {}", channel.channel),
            format!("{:.1}", channel.curve.score),
            probability(channel.curve.p),
            probability(channel.p_of_all),
            // A delay of zero has no meaning here.
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
}

fn print_cells(dependence: &Dependence) {
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
            three(cell.low_hz),
            three(cell.high_hz),
            cell.times,
            probability(cell.p)
        );
    }
}

/// Probability with two digits.
fn probability(p: f64) -> String {
    if p >= 0.01 { format!("{p:.2}") } else { format!("{p:.0e}") }
}
