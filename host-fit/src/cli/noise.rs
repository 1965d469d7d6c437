//! `noise`: white noise, bias instability and random walk of a log at rest; the files that other stacks take.

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use serde_json::json;

use super::arguments::{OutputFile, Reading, axes, describe};
use super::output::{Failure, number, print_json, print_line, print_warning, spinner, table};
use super::units::Printed;
use crate::export::{NoiseModel, NoiseUnits, allan_csv, imu_yaml, orb_slam3, vins};
use crate::figures::noise::allan_of_noise;
use crate::figures::write_svg;
use crate::units::{ShownUnit, Units};
use fos_data::file::{name_of, write_atomically};
use fos_data::recording::Recording;
use fos_data::stillness::{self, Stillness};
use fos_fit::noise::{AxisNoise, Level, axis_noise};

/// A temperature that moves by more than this moves what is measured, K.
const STEADY_K: f64 = 2.0;

/// Estimate noise density, bias instability and random walk; write imu.yaml
///
/// Each with the interval that holds it with 90 %. Motion, knocks and samples that are no measurements are left out.
/// What a log is too short to tell is said, with how long one would have to be. N and K are those that Kalibr, OpenVINS
/// and ORB-SLAM3 ask for.
#[derive(Debug, Args)]
#[command(after_help = "Example: fos noise rest.parquet --csv allan.csv --svg allan.svg --imu-yaml imu.yaml")]
pub(super) struct Noise {
    /// The log of a unit lying still, in any format that `fos formats` lists
    log: PathBuf,
    /// gx, a column, several with commas, or all
    #[arg(long, default_value = "all")]
    axis: String,
    /// Write the Allan deviation, N, B and K as a table
    #[arg(long, value_name = "FILE")]
    csv: Option<OutputFile>,
    /// Draw them
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
    reading: Reading,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

impl Noise {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let recording = self.reading.read(&self.log)?;
        let stillness = stillness::find(&recording);
        let columns = axes(&recording, &self.axis)?;
        let spinner = spinner("telling the noise");
        let found: Result<Vec<AxisNoise>, _> =
            columns.par_iter().map(|column| axis_noise(&recording, &stillness, column)).collect();
        spinner.finish_and_clear();
        let found = found?;
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
        warn(&recording, &stillness);
        if self.json {
            let files: Vec<_> = written.iter().map(|(path, _)| path.display().to_string()).collect();
            return print_json(
                &json!({ "rate_hz": recording.rate.true_hz, "axes": found, "written": files }),
            );
        }
        print_line!("{}", describe(&recording, &stillness, Printed::default()));
        print_noise(&found);
        for (path, what) in written {
            print_line!("{}: {what}", path.display());
        }
        Ok(())
    }

    /// The files of other stacks, once all of them are known to be possible.
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

/// What else may pass as noise.
fn warn(recording: &Recording, stillness: &Stillness) {
    let Ok(channel) = recording.channel("temp_c") else { return };
    let at_rest =
        channel.values.iter().zip(&stillness.still).filter(|(value, still)| **still && value.is_finite());
    let (low, high) = at_rest.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (value, _)| {
        (low.min(*value), high.max(*value))
    });
    if high - low > STEADY_K {
        print_warning(&format!(
            "the temperature moves from {low:.1} to {high:.1} °C: what it does to the bias counts as B and K here\nhelp: \
             record at a steady temperature, after a warm-up; or fit the temperature and take the noise of what \
             `fos replay` leaves"
        ));
    }
}

/// N, B and K of every axis, and what the log is too short for.
fn print_noise(axes: &[AxisNoise]) {
    let mut rows = table(&["  axis", "N", "90 %", "B", "90 %", "K", "90 %", "at rest, s"]);
    for axis in axes {
        let mut row = vec![format!("  {}", axis.column)];
        for (level, none) in
            [(axis.levels.white, "–"), (axis.levels.flicker, "–"), (axis.levels.walk, "too short")]
        {
            row.extend(cells(&level, none));
        }
        row.push(format!("{:.0}", axis.seconds));
        rows.add_row(row);
    }
    print_line!("\n{rows}");
    let mut units: Vec<&str> = axes.iter().map(|axis| axis.unit.as_str()).collect();
    units.dedup();
    for unit in units {
        let NoiseUnits { white, flicker, walk } = NoiseUnits::of(unit);
        print_line!("  in {unit}: N in {white}, B in {flicker}, K in {walk}");
    }
    for axis in axes {
        let Some(needed) = axis.walk_needs_s else { continue };
        print_line!(
            "  {}: the log is too short for K: {} at rest show none; it is at most {} (95 %). About {} would show half as much",
            axis.column,
            duration(axis.span_s),
            number(axis.levels.walk.high),
            duration(needed)
        );
    }
    for (axis, step) in axes.iter().filter_map(|axis| Some((axis, axis.step?))) {
        print_line!(
            "  {}: the sensor's step, {}, hides the noise; N is at most {} (95 %). Choose a finer range of the sensor",
            axis.column,
            number(step),
            number(axis.levels.white.high)
        );
    }
    for axis in axes.iter().filter(|axis| axis.levels.flicker.value.is_none() && axis.step.is_none()) {
        print_line!(
            "  {}: no flicker noise shows between N and K; B is at most {} (95 %)",
            axis.column,
            number(axis.levels.flicker.high)
        );
    }
}

fn cells(level: &Level, none: &str) -> [String; 2] {
    match (level.value, level.low) {
        (Some(value), Some(low)) => [number(value), format!("{} … {}", number(low), number(level.high))],
        _ => [none.to_owned(), format!("0 … {}", number(level.high))],
    }
}

/// In the unit that suits it.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
