//! `noise`: white noise, bias instability and random walk of a log at rest, and files for other software.

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use serde_json::json;

use super::arguments::{OutputFile, Reading, axes, describe, only_ends_in, usable};
use super::output::{Failure, print_json, print_line, spinner, table};
use super::units::{Printed, UnitsOption, three};
use fos_data::file::{name_of, write_atomically};
use fos_data::recording::Recording;
use fos_data::stillness;
use fos_export::{NoiseModel, allan_csv, imu_yaml, orb_slam3, vins};
use fos_figures::noise::allan_of_noise;
use fos_figures::units::{ShownUnit, Units};
use fos_figures::write_svg;
use fos_fit::noise::{AxisNoise, Level, axis_noise};

/// Estimate noise density, bias instability and random walk; write imu.yaml
///
/// Each with its 90 % interval, by maximum likelihood. Motion, knocks and outliers are excluded. A drift with the logged
/// temperature is estimated at the same time and is part of neither B nor K. If the log is too short for K, its upper limit
/// is printed, with the length that would show half of it. N and K are those that Kalibr, OpenVINS and ORB-SLAM3 need.
#[derive(Debug, Args)]
#[command(after_help = "Example: fos noise rest.parquet --csv allan.csv --svg allan.svg --imu-yaml imu.yaml")]
pub(super) struct Noise {
    /// The log of a device at rest, in any format that `fos formats` lists
    log: PathBuf,
    /// gx, a column, several with commas, or all
    #[arg(long, default_value = "all")]
    axis: String,
    /// Write the Allan deviation, N, B and K as a table
    #[arg(long, value_name = "FILE")]
    csv: Option<OutputFile>,
    /// Draw them, as SVG
    #[arg(long, value_name = "FILE")]
    svg: Option<OutputFile>,
    /// Write the noise for Kalibr and OpenVINS, which both read this file
    #[arg(long, value_name = "FILE")]
    imu_yaml: Option<OutputFile>,
    /// The topic of the sensor, for that file
    #[arg(long, default_value = "/imu0", requires = "imu_yaml")]
    rostopic: String,
    /// Write the noise for ORB-SLAM3
    #[arg(long, value_name = "FILE")]
    orb_slam3: Option<OutputFile>,
    /// Write the noise for VINS-Mono and VINS-Fusion
    #[arg(long, value_name = "FILE")]
    vins: Option<OutputFile>,
    #[command(flatten)]
    shown: UnitsOption,
    #[command(flatten)]
    reading: Reading,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

impl Noise {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if let Some(path) = &self.svg {
            only_ends_in(path, "--svg", &["svg"])?;
        }
        if let Some(path) = &self.csv {
            only_ends_in(path, "--csv", &["csv"])?;
        }
        let recording = self.reading.read(&self.log)?;
        let stillness = stillness::find(&recording);
        let columns = axes(&recording, &self.axis)?;
        let spinner = spinner("estimating the noise");
        let found: Vec<Result<AxisNoise, _>> =
            columns.par_iter().map(|column| axis_noise(&recording, &stillness, column)).collect();
        spinner.finish_and_clear();
        let found = usable(&self.axis, found)?;
        let log = name_of(&recording.paths());
        let mut written = Vec::new();
        self.write_models(&log, &recording, &found, &mut written)?;
        if let Some(path) = &self.csv {
            write_atomically(path, allan_csv(&found).as_bytes())?;
            written.push((path, "N, B, K and the Allan deviation of every axis"));
        }
        if let Some(path) = &self.svg {
            write_svg(
                &allan_of_noise(&log, &found, |axis| ShownUnit::of_noise(&axis.column, Units::Si)),
                path,
            )?;
            written.push((path, "the same as a figure"));
        }
        if self.json {
            let files: Vec<_> = written.iter().map(|(path, _)| path.display().to_string()).collect();
            return print_json(
                &json!({ "rate_hz": recording.rate.true_hz, "axes": found, "written": files }),
            );
        }
        print_line!("{}", describe(&recording, &stillness, Printed::default()));
        print_noise(&found, self.shown.units);
        for (path, what) in written {
            print_line!("{}: {what}", path.display());
        }
        Ok(())
    }

    /// Files for other software, after all of them are known to be possible.
    fn write_models<'a>(
        &'a self,
        log: &str,
        recording: &Recording,
        found: &[AxisNoise],
        written: &mut Vec<(&'a OutputFile, &'static str)>,
    ) -> Result<(), Failure> {
        if self.imu_yaml.is_none() && self.orb_slam3.is_none() && self.vins.is_none() {
            return Ok(());
        }
        let model = NoiseModel::of(log, recording.rate.true_hz, found)?;
        let files = [
            (&self.imu_yaml, imu_yaml(&model, &self.rostopic), "noise for Kalibr and OpenVINS"),
            (&self.orb_slam3, orb_slam3(&model), "noise for ORB-SLAM3, to be put in its settings"),
            (&self.vins, vins(&model), "noise for VINS, to be put in its configuration"),
        ];
        for (path, text, what) in files {
            if let Some(path) = path {
                write_atomically(path, text.as_bytes())?;
                written.push((path, what));
            }
        }
        Ok(())
    }
}

/// N, B and K of every axis, and the limits of what the log shows.
fn print_noise<'a>(axes: &'a [AxisNoise], units: Units) {
    let of_axis = |axis: &'a AxisNoise| (axis, ShownUnit::of_noise(&axis.column, units));
    let shown: Vec<(&AxisNoise, [ShownUnit; 3])> = axes.iter().map(of_axis).collect();
    // Axes of one unit together, so that a column has one unit.
    for same in shown.chunk_by(|(_, one), (_, other)| one == other) {
        let [white, flicker, walk] = same[0].1.each_ref().map(|unit| &unit.label);
        let header = [
            "  axis".to_owned(),
            format!("N, {white}"),
            "90 %".to_owned(),
            format!("B, {flicker}"),
            "90 %".to_owned(),
            format!("K, {walk}"),
            "90 %".to_owned(),
            "at rest, s".to_owned(),
        ];
        let mut rows = table(&header);
        for (axis, [white, flicker, walk]) in same {
            let mut row = vec![format!("  {}", axis.column)];
            row.extend(cells(&axis.levels.white, white, "–"));
            row.extend(cells(&axis.levels.flicker, flicker, "–"));
            row.extend(cells(&axis.levels.walk, walk, "too short"));
            row.push(format!("{:.0}", axis.seconds));
            rows.add_row(row);
        }
        print_line!("\n{rows}");
    }
    if units == Units::Field {
        print_line!("  --units si prints the units of imu.yaml");
    }
    for (axis, [_, flicker, _]) in &shown {
        let Some(drift) = &axis.thermal_drift else { continue };
        let [low, high] = drift.range_c;
        print_line!(
            "  {}: a drift with temperature ({low:.1} to {high:.1} °C) of {} {} RMS is not part of B and K",
            axis.column,
            three(drift.rms / flicker.divisor),
            flicker.label
        );
    }
    let seconds = ShownUnit { label: "s".to_owned(), divisor: 1.0 };
    for (axis, [white, flicker, _]) in &shown {
        let Some(process) = &axis.levels.gauss_markov else { continue };
        let stated = |level: &Level, unit: &ShownUnit| {
            let [value, interval] = cells(level, unit, "–");
            format!("{value} {} ({interval})", unit.label)
        };
        print_line!(
            "  {}: a Gauss–Markov process describes the bias better than B and K: σ {}, τ {}, beside N {}",
            axis.column,
            stated(&process.deviation, flicker),
            stated(&process.tau_s, &seconds),
            stated(&process.white, white)
        );
    }
    for (axis, [_, _, walk]) in &shown {
        let Some(needed) = axis.walk_needs_s else { continue };
        print_line!(
            "  {}: the log is too short for K: {} at rest show none; it is at most {} {} (95 %). About {} would show half as much",
            axis.column,
            duration(axis.seconds),
            three(axis.levels.walk.high / walk.divisor),
            walk.label,
            duration(needed)
        );
    }
    for (axis, _) in &shown {
        let Some(needed) = axis.levels.walk_within_20_percent_s else { continue };
        print_line!(
            "  {}: {} at rest are expected to give K within ±20 % (90 %)",
            axis.column,
            duration(needed)
        );
    }
    for (axis, [white, flicker, _]) in &shown {
        let Some(step) = axis.step else { continue };
        print_line!(
            "  {}: the sensor's step, {} {}, hides the noise; N is at most {} {} (95 %). Choose a finer range of the sensor",
            axis.column,
            three(step / flicker.divisor),
            flicker.label,
            three(axis.levels.white.high / white.divisor),
            white.label
        );
    }
    for (axis, [_, flicker, _]) in
        shown.iter().filter(|(axis, _)| axis.levels.flicker.value.is_none() && axis.step.is_none())
    {
        print_line!(
            "  {}: no flicker noise shows between N and K; B is at most {} {} (95 %)",
            axis.column,
            three(axis.levels.flicker.high / flicker.divisor),
            flicker.label
        );
    }
}

fn cells(level: &Level, unit: &ShownUnit, none: &str) -> [String; 2] {
    let show = |value: f64| three(value / unit.divisor);
    match (level.value, level.low) {
        (Some(value), Some(low)) => [show(value), format!("{} … {}", show(low), show(level.high))],
        _ => [none.to_owned(), format!("0 … {}", show(level.high))],
    }
}

/// A duration in s, min or h.
pub(super) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
