//! Prints the calibration of a gyro on a turntable.
use fos_calibrate::{Imu, calibrate_on_turntable};
use fos_data::recording::{ColumnMap, LoadOptions, Recording, load};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let columns = ColumnMap::from_specs([
        "gx_rads=column_1:rad/s",
        "gy_rads=column_2:rad/s",
        "gz_rads=column_3:rad/s",
    ])?;
    let options = LoadOptions { rate_hz: Some(100.0), columns, ..LoadOptions::default() };
    let logs = std::env::args().skip(1).map(|path| load(path, &options)).collect::<Result<Vec<_>, _>>()?;
    let recording = Recording::join(logs)?;
    let found = calibrate_on_turntable(&Imu::of(&recording)?, &[3.49066, 4.71239])?;
    for parameter in &found.parameters {
        println!(
            "{} {:.5} ± {:.5} {} {:?}",
            parameter.label, parameter.value, parameter.half_width, parameter.unit, parameter.determined
        );
    }
    println!("{} rests {} plateaus rms {:?}", found.rests, found.plateaus.len(), found.rms);
    for one in &found.plateaus {
        println!(
            "{:.1} {:.1} {:?} {:.4} {:+.5} {}",
            one.start_s,
            one.duration_s,
            one.mean.map(|x| (x * 1000.0).round() / 1000.0),
            one.rate_rads,
            one.residual,
            one.excluded
        );
    }
    Ok(())
}
