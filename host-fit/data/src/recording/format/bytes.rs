//! Recognises files that are no container by their first bytes.

use std::io::BufRead;
use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::{csv_file, other_format};
use super::names::Format;
use super::opened::{Extent, Opened};
use super::{axivity, choice, geneactiv, gnss_logger};
use crate::file::FileError;

/// Number of bytes read to recognise a file.
const BEGIN_BYTES: u64 = 1 << 18;

/// Problem and remedy for a bag of ROS 2 other than MCAP.
pub(super) const BAG_IN_SQLITE: (&str, &str) = (
    "it is a ROS 2 bag in SQLite",
    "convert it to MCAP: `ros2 bag convert`, or `rosbags-convert --src BAG --dst NEW --dst-storage mcap`",
);

/// Reads data that are no container; `is_packed` if they come from a container whose damage shows while reading.
pub(super) fn unpacked(
    path: &Path,
    mut input: impl BufRead,
    options: &LoadOptions,
    extent: Extent,
    is_packed: bool,
) -> Result<Opened, RecordingError> {
    let begin = input.fill_buf().map_err(FileError::reading(path))?;
    let is_bag = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("db3"));
    let in_sqlite = (is_bag && begin.starts_with(b"SQLite")).then_some(BAG_IN_SQLITE);
    if let Some((is, help)) = in_sqlite.or_else(|| other_format::known(begin)) {
        return Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help });
    }
    let signed = of_signature(begin)
        .or_else(|| gnss_logger::is(begin).then_some(Format::GnssLogger))
        .or_else(|| geneactiv::is(begin).then_some(Format::GeneActiv));
    if let (Some(given), Some(found)) = (options.format, signed)
        && given != found
    {
        return Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: format!("it begins like {found}, but the stated format is {given}"),
            help: "leave the format out, so that it is found by the content",
        });
    }
    if let (Some(given @ (Format::GeneActiv | Format::Axivity)), None, false) =
        (options.format, signed, begin.is_empty())
    {
        return Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: format!("it does not begin as {given} does"),
            help: "leave the format out, so that it is found by the content",
        });
    }
    let format = options.format.filter(|format| format.has_bytes_of_its_own());
    match format.or(signed) {
        Some(Format::Ulog) => {
            #[cfg(feature = "ulog")]
            return super::ulog::read(path, input, options);
            #[cfg(not(feature = "ulog"))]
            return Err(RecordingError::not_built_in(path, "ulog"));
        }
        Some(Format::Dataflash) => {
            #[cfg(feature = "dataflash")]
            return super::dataflash::read(path, input, options);
            #[cfg(not(feature = "dataflash"))]
            return Err(RecordingError::not_built_in(path, "dataflash"));
        }
        Some(Format::Mcap) => {
            #[cfg(feature = "mcap")]
            return super::mcap_file::read(path, input, options);
            #[cfg(not(feature = "mcap"))]
            return Err(RecordingError::not_built_in(path, "mcap"));
        }
        Some(Format::Bag) => {
            #[cfg(feature = "bag")]
            return super::bag::read(path, input, options);
            #[cfg(not(feature = "bag"))]
            return Err(RecordingError::not_built_in(path, "bag"));
        }
        Some(Format::GnssLogger) => {
            choice::refuse_topic(path, options, "a log of GnssLogger, with one accelerometer and one gyro")?;
            return gnss_logger::read(path, input, options.strict);
        }
        Some(Format::GeneActiv) => {
            choice::refuse_topic(path, options, "a log of a GENEActiv, with one accelerometer")?;
            return geneactiv::read(path, input, options);
        }
        Some(Format::Axivity) => {
            choice::refuse_topic(path, options, "a log of an Axivity device, with one accelerometer")?;
            return axivity::read(path, input, options);
        }
        _ => {}
    }
    let longest = if extent == Extent::Whole { u64::MAX } else { BEGIN_BYTES };
    let (map, strict) = (&options.columns, options.strict);
    let table = csv_file::read(path, input.take(longest), map, strict, is_packed)?;
    choice::refuse_topic(path, options, &choice::describe_table(&table))?;
    Ok(Opened::Table(Box::new(table)))
}

impl Format {
    /// Returns true for a binary format.
    fn has_bytes_of_its_own(self) -> bool {
        matches!(
            self,
            Self::Ulog
                | Self::Dataflash
                | Self::Mcap
                | Self::Bag
                | Self::GnssLogger
                | Self::GeneActiv
                | Self::Axivity
        )
    }
}

/// Format by the signature at the begin of a file.
fn of_signature(begin: &[u8]) -> Option<Format> {
    const SIGNATURES: [(&[u8], Format); 5] = [
        (b"ULog\x01\x12\x35", Format::Ulog),
        // a message that describes messages
        (b"\xa3\x95\x80", Format::Dataflash),
        (b"\x89MCAP0\r\n", Format::Mcap),
        (b"#ROSBAG V", Format::Bag),
        (axivity::SIGNATURE, Format::Axivity),
    ];
    let known = SIGNATURES.iter().find(|(signature, _)| begin.starts_with(signature));
    known.map(|(_, format)| *format)
}
