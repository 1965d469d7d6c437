//! Writes one flight in foreign formats into a folder, for checks with foreign programs.

use std::path::PathBuf;
use std::{env, fs};

use fos_testkit::foreign::{
    Axivity, Chunks, Flight, Rate, TEXTS, axivity, bag, dataflash, geneactiv, mcap, ulog,
};

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
    fs::write(folder.join("flight_geneactiv.bin"), geneactiv(&flight))?;
    fs::write(folder.join("ax6.cwa"), axivity(&flight, Axivity::WithGyro))?;
    fs::write(folder.join("packed.cwa"), axivity(&flight, Axivity::Packed))?;
    for (_, name, write) in TEXTS {
        fs::write(folder.join(name), write(&flight))?;
    }
    Ok(())
}
