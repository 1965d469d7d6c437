//! Writes one flight in the formats of others into a folder: what programs elsewhere are to read too.

use std::path::PathBuf;
use std::{env, fs};

use fos_testkit::foreign::{Chunks, Flight, Rate, TEXTS, bag, dataflash, mcap, ulog};

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(env::args().nth(1).expect("the folder to write into"));
    let samples = env::args().nth(2).map_or(4000, |samples| samples.parse().expect("a number of samples"));
    let flight = Flight::new(samples, 5000, 1);
    fs::write(folder.join("flight.csv"), flight.csv())?;
    fs::write(folder.join("flight.ulg"), ulog(&flight, Rate::Full))?;
    fs::write(folder.join("decimated.ulg"), ulog(&flight, Rate::Decimated))?;
    fs::write(folder.join("batches.ulg"), ulog(&flight, Rate::Fifo))?;
    fs::write(folder.join("flight.bin"), dataflash(&flight, &[], false))?;
    fs::write(folder.join("every_sample.bin"), dataflash(&flight, &[], true))?;
    fs::write(folder.join("flight.mcap"), mcap(&flight))?;
    fs::write(folder.join("flight.bag"), bag(&flight, Chunks::Some))?;
    for (_, name, write) in TEXTS {
        fs::write(folder.join(name), write(&flight))?;
    }
    Ok(())
}
