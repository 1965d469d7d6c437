//! One flight in third-party formats, written from their documentation, independently of the readers under test.

mod bag;
mod dataflash;
mod flight;
mod mcap;
mod ros;
mod text;
mod ulog;
mod wearable;
mod zip;

pub use bag::{Chunks, bag, bag_of};
pub use dataflash::{dataflash, dataflash_of, dataflash_of_2014};
pub use flight::{Flight, Publisher};
pub use mcap::{mcap, mcap_of};
pub use text::{TEXTS, Text};
pub use ulog::{Rate, ulog, ulog_of};
pub use wearable::{Axivity, axivity, geneactiv};
pub use zip::zip;

/// The log format and the binary ones, with variants of some.
pub const BINARIES: &[Text] = &[
    ("log", "flight.csv", |flight| flight.csv().into_bytes()),
    ("ulog", "flight.ulg", |flight| ulog(flight, Rate::Full)),
    ("ulog", "decimated.ulg", |flight| ulog(flight, Rate::Decimated)),
    ("ulog", "batches.ulg", |flight| ulog(flight, Rate::Fifo)),
    ("dataflash", "flight.bin", |flight| dataflash(flight, &[], false)),
    ("dataflash", "every_sample.bin", |flight| dataflash(flight, &[], true)),
    ("mcap", "flight.mcap", mcap),
    ("bag", "flight.bag", |flight| bag(flight, Chunks::Some)),
    ("geneactiv", "flight_geneactiv.bin", geneactiv),
    ("axivity", "ax6.cwa", |flight| axivity(flight, Axivity::WithGyro)),
    ("axivity", "packed.cwa", |flight| axivity(flight, Axivity::Packed)),
];

/// Files of every format: short name expected from recognition, name of a file, and the function that writes it.
pub fn files() -> impl Iterator<Item = &'static Text> {
    BINARIES.iter().chain(TEXTS)
}
