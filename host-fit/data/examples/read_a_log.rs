//! Writes a log from columns in memory and reads it back: `cargo run -p fos-data --example read_a_log [LOG]`.

use fos_data::recording::{LoadOptions, Recording, RecordingError, Source, load, write_columns};
use fos_data::stillness;

fn main() -> Result<(), RecordingError> {
    let path = match std::env::args().nth(1) {
        Some(path) => path.into(),
        None => {
            let path = std::env::temp_dir().join("fos_read_a_log.csv");
            let time: Vec<f64> = (0..1000).map(|n| 0.005 * f64::from(n)).collect();
            let rate: Vec<f64> = time.iter().map(|t| 0.01 + 0.001 * (40.0 * t).sin()).collect();
            write_columns(&path, &[("t_s", &time), ("gx_rads", &rate)])?;
            let columns = vec![("t_s".to_owned(), time), ("gx_rads".to_owned(), rate)];
            let same = Recording::from_columns(Source::made_by("memory"), columns, &LoadOptions::default())?;
            let read = load(&path, &LoadOptions::default())?;
            assert_eq!(read.channel("gx_rads")?.values, same.channel("gx_rads")?.values);
            path
        }
    };
    let log = load(&path, &LoadOptions::default())?;
    println!(
        "{}: {} rows in {} segments at {:.2} Hz",
        log.paths(),
        log.n_rows(),
        log.segments.len(),
        log.rate.true_hz
    );
    for channel in log.channels() {
        println!("  {} {}, {} values missing", channel.name, channel.unit.label(), channel.n_missing());
    }
    println!("  still: {}", stillness::find(&log).known_by.describe());
    Ok(())
}
