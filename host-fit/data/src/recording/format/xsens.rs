//! Text of Xsens and Movella: exports of DOT sensors, of MT Manager, and tables of DOT logs with `f_x` and `w_x`.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::provenance::{Provenance, Values};
use super::super::table::{Column, Table};
use super::found::Found;
use super::{Format, header};
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};
use crate::statistics::median_of;

/// Modulus of `SampleTimeFine`, which has 32 bits and wraps every 72 minutes on a DOT.
const MODULUS: f64 = 4_294_967_296.0;

/// Number of ticks between two samples from which a tick is 1 µs, as on a DOT, which samples at 120 Hz or less; an MTi
/// has ticks of 100 µs, samples at 100 Hz or more, and has fewer.
const LONG_STEP: f64 = 5000.0;

/// Columns of an export, if the table is one.
pub(super) fn exported(path: &Path, table: &Table) -> Result<Option<Found>, RecordingError> {
    let of = |name: &str| table.columns.iter().find(|column| header::split(&column.name).0 == name);
    let triad = |name: &str| -> Option<[&Column; 3]> {
        let [x, y, z] = ["x", "y", "z"]
            .map(|axis| of(&format!("{name}_{axis}")).or(of(&format!("{name}_{}", axis.to_uppercase()))));
        Some([x?, y?, z?])
    };
    let (time, stamps, names, rates) = match (of("SampleTimeFine"), of("Time")) {
        (Some(time), _) => {
            let is_long = step(&time.values).is_none_or(|ticks| ticks >= LONG_STEP);
            let (stamps, rates) = if is_long { ("us", "dps") } else { ("*100:us", "rad/s") };
            (time, stamps, ["Acc", "Gyr"], rates)
        }
        (None, Some(time)) if ["phi", "theta", "psi"].iter().all(|name| of(name).is_some()) => {
            (time, "s", ["f", "w"], "dps")
        }
        _ => return Ok(None),
    };
    let [force, rate] = names.map(triad);
    if force.is_none() && rate.is_none() {
        if names[0] == "f" {
            return Ok(None);
        }
        return Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: format!(
                "it is an export of an Xsens or Movella sensor without Acc_X … and Gyr_X …; it holds {}",
                table.names().join(", ")
            ),
            help: "record acceleration and angular velocity: in the app of a DOT the payload \"Rate quantities\" or \"Custom Mode 4\", in MT Manager the output \"Calibrated data\"",
        });
    }
    let mut entries = vec![("t_s", time.name.clone(), stamps.to_owned())];
    let mut units = Vec::new();
    for (triad, targets, default) in
        [(force, ACCELEROMETERS, "m/s2"), (rate, GYROS, rates), (triad("Mag"), MAGNETOMETERS, "")]
    {
        let Some(columns) = triad else { continue };
        for (target, column) in targets.into_iter().zip(columns) {
            let unit = header::unit_of(path, &column.name, target, default)?;
            // a magnetic field without a unit, as these programs write it, is ignored
            if !unit.is_empty() {
                entries.push((target, column.name.clone(), unit.to_owned()));
                units.push(unit);
            }
        }
    }
    units.dedup();
    if let Some(column) = of("Temperature") {
        let unit = header::unit_of(path, &column.name, "temp_c", "degC")?;
        entries.push(("temp_c", column.name.clone(), unit.to_owned()));
    }
    let clock = match stamps {
        "us" => "SampleTimeFine in µs",
        "s" => "Time in s",
        _ => "SampleTimeFine in 100 µs, as of an MTi",
    };
    let assumed = format!("{clock}; {}, with gravity", units.join(" and "));
    let values = Values::Corrected("the factory calibration of the sensor".into());
    let provenance = Provenance::of_both(values, super::super::provenance::Frame::Sensor);
    let counter = (names[0] == "Acc").then(|| (time.name.clone(), MODULUS));
    Ok(Some(Found { format: Format::Xsens, entries, assumed, provenance, gyro_clock: None, counter }))
}

/// Usual step of a counter.
fn step(values: &[f64]) -> Option<f64> {
    median_of(values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0))
}

/// Unwraps a counter. A step back by more than half of `modulus` is a wrap.
pub(super) fn unwrap(ticks: &mut [f64], modulus: f64) {
    let (mut last, mut turns) = (f64::NAN, 0.0);
    for tick in ticks.iter_mut().filter(|tick| tick.is_finite()) {
        if last - *tick > 0.5 * modulus {
            turns += modulus;
        } else if *tick - last > 0.5 * modulus && turns > 0.0 {
            // a late row from before the wrap
            turns -= modulus;
        }
        last = *tick;
        *tick += turns;
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::super::{LoadOptions, Recording, load};
    use super::*;

    fn read(text: &str) -> Result<Recording, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        std::fs::write(&path, text).unwrap();
        load(&path, &LoadOptions::default()).map_err(|error| error.to_string())
    }

    /// An export of a DOT whose clock wraps after 100 rows.
    fn dot(columns: &str, row: impl Fn(u32) -> String) -> String {
        let mut text = format!(
            "sep=,\nDeviceTag:,Xsens DOT\nFirmwareVersion:,2.0.0\n\nPacketCounter,SampleTimeFine,{columns}\n"
        );
        for n in 0..400_u32 {
            let ticks = (u32::MAX - 100 * 16_667).wrapping_add(n * 16_667);
            writeln!(text, "{n},{ticks},{}", row(n)).unwrap();
        }
        text
    }

    #[test]
    fn reads_an_export_of_a_dot_whose_clock_wraps() {
        let text = dot("Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z", |n| format!("0.1,0.2,9.8,{},0,-1", n % 3));
        let log = read(&text).unwrap();
        assert_eq!((log.n_rows(), log.quality.gaps, log.quality.clock_back), (400, 0, 0));
        assert!((log.rate.true_hz - 1e6 / 16_667.0).abs() < 1e-3);
        assert!((log.channel("gz_rads").unwrap().values[7] + 1.0_f64.to_radians()).abs() < 1e-12);
        let read_as = log.sources[0].read_as.as_ref().unwrap();
        assert_eq!(read_as.format, Format::Xsens);
        assert!(read_as.assumed.contains("m/s2 and dps"), "{}", read_as.assumed);
    }

    #[test]
    fn export_with_orientations_only_names_the_data_to_record() {
        let error = read(&dot("Euler_X,Euler_Y,Euler_Z,FreeAcc_X", |_| "1,2,3,0".to_owned())).unwrap_err();
        assert!(error.contains("Euler_X") && error.contains("Rate quantities"), "{error}");
    }

    #[test]
    fn unwraps_a_counter_once_for_each_wrap() {
        let mut ticks = [10.0, 14.0, f64::NAN, 2.0, 15.0, 3.0, 14.0, 1.0];
        unwrap(&mut ticks, 16.0);
        let ticks: Vec<f64> = ticks.into_iter().filter(|tick| !tick.is_nan()).collect();
        assert_eq!(ticks, [10.0, 14.0, 18.0, 15.0, 19.0, 14.0, 17.0]);
    }
}
