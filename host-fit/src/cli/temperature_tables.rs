//! Temperature tables of `export` for autopilots, and the remaining error after each.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::arguments::OutputFile;
use super::output::{Failure, Written, print_line, print_warning, table};
use super::units::{ErrorUnit, Units, UnitsOption};
use fos_data::file::{name_of, write_atomically};
use fos_data::recording::{Recording, load};
use fos_data::stillness::{self, Stillness};
use fos_diagnose::study::{Study, load_again};
use fos_diagnose::thermal::{Correction, LeftByTemperature, left_by_temperature};
use fos_export::{ArduPilot, Autopilot, Px4, StatedSensor, TableSensor};
use fos_fit::thermal::ThermalTable;

/// Tables by temperature.
#[derive(Debug, Args)]
pub(super) struct TableArguments {
    /// The temperature tables for PX4 to write, as parameters that QGroundControl loads
    #[arg(long, value_name = "FILE")]
    px4: Option<OutputFile>,
    /// The device_id of accelerometer and gyro for PX4, which applies a table to no other sensor; by default that of the
    /// log, where a ULog states it
    #[arg(long, value_name = "ACCEL,GYRO", value_delimiter = ',', num_args = 1, requires = "px4")]
    device_id: Vec<u32>,
    /// The number of the IMU on the autopilot, counted from 0; by default that of the log, where it is the autopilot's own
    #[arg(long, value_name = "N")]
    instance: Option<u8>,
    /// The temperature tables for ArduPilot to write, as parameters
    #[arg(long, value_name = "FILE")]
    ardupilot: Option<OutputFile>,
    /// A later log to evaluate these tables on; by default the rows of the study's log that were not fitted
    #[arg(long = "evaluate-on", alias = "judge", value_name = "LOG")]
    evaluate_on: Option<PathBuf>,
    #[command(flatten)]
    shown: UnitsOption,
}

/// Tables to write, with the remaining errors.
#[derive(Debug)]
pub(super) struct Tables {
    log: String,
    range_c: [f64; 2],
    px4: Option<(Px4, TableSensor)>,
    ardupilot: Option<(ArduPilot, TableSensor)>,
    evaluation: String,
    left: Vec<LeftByTemperature>,
    units: Units,
}

/// Remaining errors, for programs.
#[derive(Debug, Serialize)]
pub(super) struct TablesLeft<'a> {
    range_c: [f64; 2],
    evaluation: &'a str,
    /// Corrections of the values in `corrected`, in their order.
    corrected_by: Vec<&'static str>,
    axes: &'a [LeftByTemperature],
}

impl TableArguments {
    pub(super) fn are_given(&self) -> bool {
        self.px4.is_some() || self.ardupilot.is_some()
    }

    /// Refuses options that need a table.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.evaluate_on.is_some() && !self.are_given() {
            return Err(
                "--evaluate-on is for temperature tables\nhelp: give --px4 FILE or --ardupilot FILE with it"
                    .into(),
            );
        }
        if self.instance.is_some() && !self.are_given() {
            return Err(
                "--instance is for temperature tables\nhelp: give --px4 FILE or --ardupilot FILE with it"
                    .into(),
            );
        }
        if self.device_id.len() > 2 {
            return Err("--device-id takes that of the accelerometer and that of the gyro, not more".into());
        }
        Ok(())
    }

    /// Tables from the log of the fit of `study`, which is in `file`, or from the log to explain.
    pub(super) fn fit(&self, study: &Study, file: &Path) -> Result<Option<Tables>, Failure> {
        if !self.are_given() {
            return Ok(None);
        }
        let (recording, fitted_rows, evaluation) = self.logs(study, file)?;
        let sensor = |is_wanted: bool, autopilot| {
            is_wanted.then(|| TableSensor::of(&recording, autopilot, self.stated())).transpose()
        };
        let for_px4 = sensor(self.px4.is_some(), Autopilot::Px4)?;
        let for_ardupilot = sensor(self.ardupilot.is_some(), Autopilot::ArduPilot)?;
        let fitted_rows = if evaluation.is_some() { recording.n_rows() } else { fitted_rows };
        let stillness = stillness::find_apart(&recording, fitted_rows);
        let fitted = ThermalTable::fit(&recording, &stillness, 0..fitted_rows)?;
        let px4 = for_px4.map(|sensor| (Px4::of(&fitted), sensor));
        let ardupilot = for_ardupilot.map(|sensor| (ArduPilot::of(&fitted), sensor));
        let by_px4 = |column: &str, t: f64| px4.as_ref().map_or(0.0, |(table, _)| table.offset(column, t));
        let by_ardupilot =
            |column: &str, t: f64| ardupilot.as_ref().map_or(0.0, |(table, _)| table.offset(column, t));
        let mut corrections: Vec<Correction<'_>> = Vec::new();
        if px4.is_some() {
            corrections.push(&by_px4);
        }
        if ardupilot.is_some() {
            corrections.push(&by_ardupilot);
        }
        let columns: Vec<&str> = fitted.axes.iter().map(|axis| axis.column.as_str()).collect();
        let left = |log: &Recording, stillness: &Stillness, rows| {
            left_by_temperature(&study.model, log, stillness, &rows, &columns, &corrections)
        };
        let log = name_of(&recording.paths());
        let (left, evaluation) = match &evaluation {
            Some(other) => {
                let (led_in, from) = other.led_in_by(&recording);
                let rows = from..led_in.n_rows();
                (left(&led_in, &stillness::find_apart(&led_in, from), rows)?, name_of(&other.paths()))
            }
            None => {
                let rows = fitted_rows..recording.n_rows();
                (left(&recording, &stillness, rows)?, format!("the rows of {log} that were not fitted"))
            }
        };
        let range_c = [fitted.low_c, fitted.high_c];
        Ok(Some(Tables { log, range_c, px4, ardupilot, evaluation, left, units: self.shown.units }))
    }

    /// Statements of the user about the sensor.
    fn stated(&self) -> StatedSensor {
        let device_ids = match self.device_id[..] {
            [both] => [Some(both); 2],
            [accel, gyro] => [Some(accel), Some(gyro)],
            _ => [None; 2],
        };
        StatedSensor { instance: self.instance, device_ids }
    }

    /// The fitted log, its number of fitted rows, and the evaluation log, if it is another.
    fn logs(&self, study: &Study, file: &Path) -> Result<(Recording, usize, Option<Recording>), Failure> {
        let (recording, fitted_rows, evaluation, read) = match study.refinements.first() {
            Some(refinement) => {
                let logs = &refinement.logs;
                let evaluation = logs
                    .evaluation
                    .as_ref()
                    .map(|source| load_again(source, file, &logs.read))
                    .transpose()?;
                (load_again(&logs.log, file, &logs.read)?, logs.fitted_rows, evaluation, &logs.read)
            }
            None => {
                let read = &study.data.read;
                let logs = study.data.sources.iter().map(|source| load_again(source, file, read));
                (Recording::join(logs.collect::<Result<_, _>>()?)?, study.data.trained_rows, None, read)
            }
        };
        let evaluation = match &self.evaluate_on {
            Some(path) => Some(load(path, read)?),
            None => evaluation,
        };
        Ok((recording, fitted_rows, evaluation))
    }

    /// Writes the requested tables.
    pub(super) fn write(&self, tables: &Tables, note: &mut Vec<Written>) -> Result<(), Failure> {
        let Tables { log, range_c: [low, high], .. } = tables;
        let range = format!("{low:.2} to {high:.2} °C");
        let mut write = |path: &OutputFile, text: String, what: String| -> Result<(), Failure> {
            write_atomically(path, text.as_bytes())?;
            note.push(Written { path: path.display().to_string(), what });
            Ok(())
        };
        if let (Some(path), Some((px4, sensor))) = (&self.px4, &tables.px4) {
            let TableSensor { instance, device_ids, lacks_device_id } = *sensor;
            let ids = device_ids.map(Option::unwrap_or_default);
            let what = format!("temperature tables for IMU {instance} of PX4, {range}");
            write(path, px4.file(log, instance, ids), what)?;
            if lacks_device_id {
                print_warning(&format!(
                    "the device_id of the sensors is not known and is 0 in the table (TC_A{instance}_ID, TC_G{instance}_ID): PX4 ignores these tables until it is theirs\n\
                     help: give them with --device-id ACCEL,GYRO; `listener sensor_accel` and `listener sensor_gyro` on the \
                     vehicle show them"
                ));
            }
        }
        if let (Some(path), Some((ardupilot, sensor))) = (&self.ardupilot, &tables.ardupilot) {
            let what = format!("temperature tables for IMU {} of ArduPilot, {range}", sensor.instance);
            write(path, ardupilot.file(log, sensor.instance), what)?;
        }
        Ok(())
    }
}

impl Tables {
    fn names(&self) -> Vec<&'static str> {
        let px4 = self.px4.as_ref().map(|_| "PX4");
        px4.into_iter().chain(self.ardupilot.as_ref().map(|_| "ArduPilot")).collect()
    }

    pub(super) fn as_json(&self) -> TablesLeft<'_> {
        TablesLeft {
            range_c: self.range_c,
            evaluation: &self.evaluation,
            corrected_by: self.names(),
            axes: &self.left,
        }
    }

    /// The remaining error after each correction, side by side.
    pub(super) fn print(&self) {
        print_line!(
            "\nremaining slow error at rest on {}: RMS of 1-s means about their mean",
            self.evaluation
        );
        let mut header = vec!["  axis".to_owned(), "nothing corrected".to_owned()];
        header.extend(self.names().iter().map(|name| format!("{name}'s cubic")));
        header.extend(["the study".to_owned(), "unit".to_owned()]);
        let mut rows = table(&header);
        for axis in &self.left {
            let corrected = axis.corrected.iter().copied();
            let largest = corrected.clone().chain(axis.study).fold(axis.nothing, f64::max);
            let unit = ErrorUnit::of(&axis.column, largest, self.units);
            let mut row = vec![format!("  {}", axis.column), unit.show(axis.nothing)];
            row.extend(corrected.map(|rms| unit.show(rms)));
            let of_study = axis.study.map_or_else(|| "–".to_owned(), |rms| unit.show(rms));
            row.extend([of_study, unit.label.to_owned()]);
            rows.add_row(row);
        }
        print_line!("{rows}");
        print_line!("  the study: its physical part, which holds in motion, as the cubics do");
    }
}
