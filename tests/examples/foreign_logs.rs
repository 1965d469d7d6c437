//! Writes one flight in foreign formats into a folder, for checks with foreign programs.

use std::path::PathBuf;
use std::{env, fs};

use fos_testkit::foreign::{Flight, files};

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(env::args().nth(1).expect("the folder to write into"));
    let samples = env::args().nth(2).map_or(4000, |samples| samples.parse().expect("a number of samples"));
    let flight = Flight::new(samples, 5000, 1);
    for (_, name, write) in files() {
        fs::write(folder.join(name), write(&flight))?;
    }
    Ok(())
}
