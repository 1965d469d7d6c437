//! `calibrate-imu`: bias, sensitivity and cross-axis from hand-turned orientations or a turntable.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use super::arguments::{OutputFile, Reading, only_ends_in, read_all};
use super::calibration_summary::{print_hand, print_turntable};
use super::numbers::within;
use super::output::{
    Failure, Written, print_json, print_line, print_warning, print_written, spinner, warning_in_words,
};
use super::units::Printed;
use fos_calibrate::export::{ArduPilot, ImuTk, Kalibr, Px4};
use fos_calibrate::{Calibration, Gravity, Imu, Options, Scale, calibrate, calibrate_on_turntable};
use fos_core::TriadCalibration;
use fos_data::column::Triad;
use fos_data::file::{check_output, folder_of, name_of, write_atomically};
use fos_data::recording::{LogWarning, Recording, SensorProvenance, Source};
use fos_data::unit::{MG_MPS2, STANDARD_GRAVITY_MPS2};
use fos_diagnose::study::Study;
use fos_fit::calibration::UnitCalibration;
use fos_report::certificate::{Certificate, Outcome, Stated, of_form};

/// Calibrate bias, sensitivity and cross-axis from hand-turned orientations
///
/// Lay the device down in 12 orientations or more, 3 s each: every face down once, then askew on edges and corners. Take the
/// hand away while it lies, and turn it in 1 s or more. Gravity is the reference: nothing else is needed. Each number has a
/// 95 % interval; orientations that would narrow it are suggested. A log in counts (columns ax_cnt … gz_cnt) needs no scale.
///
/// On a turntable, --rate-table calibrates the gyro by the stated rate instead.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos calibrate-imu turned.csv --latitude 45.4 --height 12 --accuracy 2mg -o certificate.html\n         \
    fos calibrate-imu table.csv --rate-table 33.3333rpm,45rpm"
)]
pub(super) struct CalibrateImu {
    /// The logs of one device, in any format that `fos formats` lists
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Latitude of the place, °: gravity differs by 0.5 % between equator and pole
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = within(-90.0..=90.0))]
    latitude: Option<f64>,
    /// Height of the place above sea level, m
    #[arg(long, value_name = "METRES", default_value_t = 0.0, requires = "latitude", allow_negative_numbers = true, value_parser = within(-1000.0..=20_000.0))]
    height: f64,
    /// Accuracy that is needed at 1 g, as 2mg or 0.02mps2: prints whether the intervals reach it, and the orientations missing
    #[arg(long, value_name = "SIZE")]
    accuracy: Option<Accuracy>,
    /// Calibrate the gyro on a turntable at these rates, as 33.3333rpm, 90dps or 1.5rad/s; several with commas
    #[arg(long, value_name = "RATE", value_delimiter = ',')]
    rate_table: Vec<TableRate>,
    /// The certificate to write: .html, .md or .json
    #[arg(short, long, value_name = "FILE")]
    output: Option<OutputFile>,
    /// Store the calibration in this study: a model exported from it also calibrates the corrected values
    #[arg(long, value_name = "STUDY", conflicts_with = "rate_table")]
    study: Option<PathBuf>,
    /// Name or number of the device, for the certificate
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// The part, for the certificate
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// Date of the log, for the certificate
    #[arg(long, value_name = "DATE")]
    date: Option<String>,
    /// Write parameters CAL_ACC0_*, CAL_GYRO0_* for PX4
    #[arg(long, value_name = "FILE")]
    px4: Option<OutputFile>,
    /// Write parameters INS_ACC*, INS_GYR* for ArduPilot
    #[arg(long, value_name = "FILE")]
    ardupilot: Option<OutputFile>,
    /// Number of the sensor in these parameters, from 0; by default that of the log, or 0
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u8).range(0..=4))]
    instance: Option<u8>,
    /// Write intrinsics (M, A, C) for Kalibr and OpenVINS
    #[arg(long, value_name = "FILE")]
    kalibr: Option<OutputFile>,
    /// Write the accelerometer's T, K, b for imu_tk
    #[arg(long, value_name = "FILE")]
    imu_tk_acc: Option<OutputFile>,
    /// Write the gyro's T, K, b for imu_tk
    #[arg(long, value_name = "FILE")]
    imu_tk_gyro: Option<OutputFile>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    printed: Printed,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

/// Accuracy of the acceleration, m/s².
#[derive(Debug, Clone, Copy)]
struct Accuracy(f64);

impl FromStr for Accuracy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let size = with_unit(
            text,
            &[("mg", MG_MPS2), ("mps2", 1.0), ("m/s2", 1.0), ("m/s²", 1.0), ("g", STANDARD_GRAVITY_MPS2)],
        )?;
        if (1e-6..=10.0).contains(&size) {
            Ok(Self(size))
        } else {
            Err("it must lie from 0.0001mg to 1g".to_owned())
        }
    }
}

/// A rate of a turntable, rad/s.
#[derive(Debug, Clone, Copy)]
struct TableRate(f64);

impl FromStr for TableRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let degree = 1_f64.to_radians();
        let rate = with_unit(
            text,
            &[("rpm", 6.0 * degree), ("dps", degree), ("deg/s", degree), ("°/s", degree), ("rad/s", 1.0)],
        )?;
        let rate = rate.abs();
        if (1e-3..=1e3).contains(&rate) {
            Ok(Self(rate))
        } else {
            Err("it must lie from 0.06dps to 9500rpm".to_owned())
        }
    }
}

/// Parses a number with one of these units after it; their sizes define the unit of the result.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let known = || units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let text = text.trim();
    let (number, size) = units
        .iter()
        .find_map(|(name, size)| Some((text.strip_suffix(name)?, size)))
        .ok_or_else(|| format!("{text:?} has no unit; known are {}", known()))?;
    let number: f64 = number.trim().parse().map_err(|_| format!("{number:?} is no number"))?;
    Ok(number * size)
}

/// Paths of the first two sources that have the same content.
fn same_content(sources: &[Source]) -> Option<[&str; 2]> {
    sources.iter().enumerate().find_map(|(index, second)| {
        let first = sources[..index].iter().find(|first| *first == second)?;
        Some([first.path.as_str(), second.path.as_str()])
    })
}

impl CalibrateImu {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let has_exports = [&self.px4, &self.ardupilot, &self.kalibr, &self.imu_tk_acc, &self.imu_tk_gyro]
            .iter()
            .any(|file| file.is_some());
        if has_exports && !self.rate_table.is_empty() {
            return Err("a turntable alone gives no accelerometer: nothing to export\nhelp: leave --rate-table out, or give -o for a certificate".into());
        }
        if let Some(path) = &self.output {
            only_ends_in(path, "--output", &["html", "md", "json"])?;
        }
        let recording = read_all(&self.logs, &self.reading.options()?)?;
        if let Some([first, second]) = same_content(&recording.sources) {
            return Err(format!(
                "{second} has the same content as {first}: a log given twice would halve the intervals without new information\nhelp: give each log once"
            )
            .into());
        }
        let imu = Imu::of(&recording)?;
        let spinner = spinner("calibrating");
        let result = if self.rate_table.is_empty() {
            let gravity =
                self.latitude.map_or_else(Gravity::assumed, |latitude| Gravity::at(latitude, self.height));
            let options = Options { gravity, accuracy_mps2: self.accuracy.map(|Accuracy(size)| size) };
            Outcome::Hand(Box::new(calibrate(&imu, &options)?))
        } else {
            let rates: Vec<f64> = self.rate_table.iter().map(|TableRate(rate)| *rate).collect();
            Outcome::Turntable(Box::new(calibrate_on_turntable(&imu, &rates)?))
        };
        spinner.finish_and_clear();
        self.warn(&recording);
        let stated = Stated { device: self.device.clone(), part: self.part.clone(), date: self.date.clone() };
        let certificate = Certificate::of(stated, &recording, result);
        let study = self.study.as_deref().map(Study::read_to_change).transpose()?;
        let study = match (study, &certificate.result) {
            (Some((mut study, file)), Outcome::Hand(found)) => {
                study.calibrate(unit_calibration(found, &recording)?, &recording)?;
                Some((study, file))
            }
            _ => None,
        };
        let mut written = self.write(&certificate, &recording)?;
        if let Some((mut study, file)) = study {
            study.write(&file)?;
            let path = file.path().display().to_string();
            written.push(Written { path, what: "study with the calibration".to_owned() });
        }
        if self.json {
            return print_json(&certificate);
        }
        print_line!(
            "{}: {} rows in {:.1} s, {:.2} Hz",
            recording.paths(),
            recording.n_rows(),
            recording.duration_s(),
            recording.rate.true_hz
        );
        match &certificate.result {
            Outcome::Hand(found) => print_hand(found, self.printed),
            Outcome::Turntable(found) => print_turntable(found, self.printed),
        }
        print_written(&written, false)
    }

    /// Warns about values that are corrected already, and about assumptions of the reader.
    fn warn(&self, recording: &Recording) {
        let by = [Triad::Accelerometers, Triad::Gyros].map(|triad| recording.provenance(triad));
        if let Some(by) = by.iter().find_map(SensorProvenance::corrected_by) {
            print_warning(&format!(
                "the values were corrected by {by} before they were logged: this calibration comes on top of that one\n\
                 help: log raw values to replace it"
            ));
        }
        let options = Reading::augment_args(clap::Command::new("options"));
        let still = vec![false; recording.n_rows()];
        for warning in recording.warnings(&still) {
            if matches!(warning, LogWarning::AssumedMap(_) | LogWarning::Clock(_)) {
                print_warning(&warning_in_words(&warning, options.get_arguments()));
            }
        }
    }

    /// Writes the requested files, after all of them are known to be possible.
    fn write(&self, certificate: &Certificate, recording: &Recording) -> Result<Vec<Written>, Failure> {
        let mut files: Vec<(&OutputFile, Vec<u8>, &str)> = Vec::new();
        if let Some(path) = &self.output {
            let extension = path.extension().and_then(|extension| extension.to_str());
            files.push((path, of_form(certificate, extension)?, "certificate"));
        }
        if let Outcome::Hand(found) = &certificate.result {
            self.exports(found, recording, &mut files)?;
        }
        for (path, ..) in &files {
            let folder = folder_of(path.as_ref());
            if !folder.is_dir() {
                return Err(format!(
                    "{}: the folder {} does not exist; no file was written\nhelp: mkdir -p {1}",
                    path.display(),
                    folder.display()
                )
                .into());
            }
            check_output(path.as_ref())?;
        }
        let mut written = Vec::new();
        for (path, content, what) in files {
            write_atomically(path, &content)?;
            written.push(Written { path: path.display().to_string(), what: what.to_owned() });
        }
        Ok(written)
    }

    fn exports<'a>(
        &'a self,
        found: &Calibration,
        recording: &Recording,
        files: &mut Vec<(&'a OutputFile, Vec<u8>, &'a str)>,
    ) -> Result<(), Failure> {
        let log = name_of(&recording.paths());
        let by = [Triad::Accelerometers, Triad::Gyros].map(|triad| recording.provenance(triad));
        let instance = self.instance.or(by[0].instance).unwrap_or(0);
        let ids = by.each_ref().map(|sensor| sensor.device_id.unwrap_or(0));
        if let Some(path) = &self.px4 {
            files.push((path, Px4::of(found)?.file(&log, instance, ids).into_bytes(), "parameters for PX4"));
        }
        if let Some(path) = &self.ardupilot {
            let text = ArduPilot::of(found)?.file(&log, instance);
            files.push((path, text.into_bytes(), "parameters for ArduPilot"));
        }
        if let Some(path) = &self.kalibr {
            files.push((path, Kalibr::of(found).file(&log).into_bytes(), "intrinsics for Kalibr"));
        }
        let imu_tk = ImuTk::of(found);
        if let Some(path) = &self.imu_tk_acc {
            files.push((path, imu_tk.accelerometer.file().into_bytes(), "accelerometer for imu_tk"));
        }
        if let Some(path) = &self.imu_tk_gyro {
            let gyro = imu_tk.gyro.as_ref().ok_or_else(|| {
                let reason = found.gyro.as_ref().and_then(|gyro| gyro.refused.clone());
                format!("no gyro to write: {}", reason.unwrap_or_else(|| "the log has none".to_owned()))
            })?;
            files.push((path, gyro.file().into_bytes(), "gyro for imu_tk"));
        }
        Ok(())
    }
}

/// The calibration as part of a model.
fn unit_calibration(found: &Calibration, recording: &Recording) -> Result<UnitCalibration, Failure> {
    let accelerometer = &found.accelerometer;
    let (Scale::Si, [Some(after), Some(before)]) = (accelerometer.scale, accelerometer.rms_mps2) else {
        return Err("the log is in counts, and the model of a study in m/s² and rad/s\nhelp: convert the log with the scale of the data sheet (--map ax_mps2=ax_cnt:*SCALE:mps2)".into());
    };
    let model = &accelerometer.model;
    let (matrix, bias) = model.correction(model.reference_c);
    let gyro = found.gyro.as_ref().and_then(|gyro| {
        Some(TriadCalibration { matrix: gyro.matrix.filter(|_| gyro.scale == Scale::Si)?, bias: gyro.bias })
    });
    Ok(UnitCalibration {
        sources: recording.sources.clone(),
        rests: accelerometer.used().count(),
        gravity_residual_mps2: [before, after],
        temperature_c: accelerometer.temperature_c.map(|_| model.reference_c),
        accel: TriadCalibration { matrix, bias },
        gyro,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_same_content_under_two_names() {
        let source = |path: &str, sha256: &str| Source { sha256: sha256.to_owned(), ..Source::made_by(path) };
        let sources = [source("a.csv", "01"), source("b.csv", "02"), source("copy.csv", "01")];
        assert_eq!(same_content(&sources), Some(["a.csv", "copy.csv"]));
        assert_eq!(same_content(&sources[..2]), None);
    }

    #[test]
    fn sizes_and_rates_need_a_unit() {
        let close = |one: f64, other: f64| (one - other).abs() < 1e-9 * other;
        assert!("2mg".parse::<Accuracy>().is_ok_and(|size| close(size.0, 2.0 * 9.806_65e-3)));
        assert!(
            "33.3333rpm".parse::<TableRate>().is_ok_and(|rate| close(rate.0, 33.3333 * 6_f64.to_radians()))
        );
        assert!("-90 dps".parse::<TableRate>().is_ok_and(|rate| close(rate.0, 90_f64.to_radians())));
        for wrong in ["2", "mg", "nanmg", "-1mg", "infmg"] {
            assert!(wrong.parse::<Accuracy>().is_err(), "{wrong}");
        }
        assert!("0rpm".parse::<TableRate>().is_err() && "1e9rpm".parse::<TableRate>().is_err());
    }
}
