//! Opens a path: a container is searched, any other file is recognised by its first bytes.

use std::io::{BufReader, Seek};
use std::path::Path;

use super::super::error::RecordingError;
#[cfg(feature = "gzip")]
use super::super::gzip::Members;
use super::super::load_options::LoadOptions;
use super::super::other_format;
#[cfg(feature = "parquet")]
use super::super::parquet_file;
use super::super::source::{Digest, Hashing, Source};
use super::bytes::unpacked;
#[cfg(feature = "parquet")]
use super::choice;
#[cfg(feature = "gzip")]
use super::opened::damage;
use super::opened::{Extent, Opened, READ_BUFFER};
use super::{archive, several};
use crate::file::{self, FileError};

/// Number of rows read to recognise a file.
#[cfg(feature = "parquet")]
const BEGIN_ROWS: usize = 2000;

/// Opens a file, or a folder written by a program.
pub(in super::super) fn open(
    path: &Path,
    options: &LoadOptions,
    extent: Extent,
) -> Result<(Opened, Source), RecordingError> {
    let mut digest = match extent {
        Extent::Whole => Digest::new(),
        Extent::Begin => Digest::none(),
    };
    if path.is_dir() {
        let mut archive = archive::folder(path, digest)?;
        let opened = several::read(path, &mut archive, options, extent)?;
        return Ok((opened, archive.source(path)));
    }
    let failed = || FileError::reading(path);
    let mut file = file::open_to_seek(path)?;
    let mut begin = [0; other_format::BEGIN];
    let n = file::read_up_to(&mut file, &mut begin).map_err(failed())?;
    let begin = &begin[..n];
    file.rewind().map_err(failed())?;
    let mut hashing = Hashing::new(file.try_clone().map_err(failed())?, &mut digest);
    if begin.starts_with(b"PK\x03\x04") {
        // an archive is not read in order, so hash it first; both share one open file
        hashing.read_rest().map_err(failed())?;
        let mut archive = archive::zip(path, file)?;
        let opened = several::read(path, &mut archive, options, extent)?;
        return Ok((opened, digest.finish(path)));
    }
    if begin.starts_with(b"PAR1") {
        #[cfg(not(feature = "parquet"))]
        return Err(RecordingError::not_built_in(path, "parquet"));
        #[cfg(feature = "parquet")]
        {
            let rows = (extent == Extent::Begin).then_some(BEGIN_ROWS);
            // hash first: reading moves the position at which the checksum would continue
            hashing.read_rest().map_err(failed())?;
            let table = parquet_file::read(path, file, &options.columns, rows)?;
            choice::refuse_topic(path, options, &choice::describe_table(&table))?;
            return Ok((Opened::Table(Box::new(table)), digest.finish(path)));
        }
    }
    let input = BufReader::with_capacity(READ_BUFFER, &mut hashing);
    let opened = if begin.starts_with(&[0x1f, 0x8b]) {
        #[cfg(not(feature = "gzip"))]
        return Err(RecordingError::not_built_in(path, "gzip"));
        #[cfg(feature = "gzip")]
        {
            let members = BufReader::with_capacity(READ_BUFFER, Members::new(input));
            unpacked(path, members, options, extent, true).map_err(|error| damage(error, "gzip file"))?
        }
    } else {
        unpacked(path, input, options, extent, false)?
    };
    hashing.read_rest().map_err(failed())?;
    Ok((opened, digest.finish(path)))
}

#[cfg(all(test, feature = "gzip", feature = "parquet", feature = "zip"))]
mod tests {
    use std::io::Write as _;
    use std::path::PathBuf;

    use fos_testkit::foreign::zip;
    use sha2::{Digest as _, Sha256};

    use super::super::super::write_columns;
    use super::*;

    /// The same log in every container, and in none.
    fn logs(folder: &Path) -> Vec<PathBuf> {
        let stamps: Vec<f64> = (0..500).map(|row| f64::from(row) * 0.005).collect();
        let rates: Vec<f64> = (0..500).map(|row| f64::from(row % 7) * 0.001).collect();
        let (csv, parquet) = (folder.join("a.csv"), folder.join("a.parquet"));
        let columns = [("t_s", &stamps[..]), ("gx_rads", &rates)];
        write_columns(&csv, &columns).unwrap();
        write_columns(&parquet, &columns).unwrap();
        let text = std::fs::read(&csv).unwrap();
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(&text).unwrap();
        let within = folder.join("within");
        std::fs::create_dir(&within).unwrap();
        for (path, content) in [
            ("a.csv.gz", gzip.finish().unwrap()),
            ("a.zip", zip(&[("a.csv", &text)])),
            ("within/a.csv", text.clone()),
        ] {
            std::fs::write(folder.join(path), content).unwrap();
        }
        vec![csv, parquet, folder.join("a.csv.gz"), folder.join("a.zip"), within]
    }

    #[test]
    fn preview_computes_no_checksum() {
        let folder = tempfile::tempdir().unwrap();
        for path in logs(folder.path()) {
            let source = |extent| open(&path, &LoadOptions::default(), extent).unwrap().1;
            let begin = source(Extent::Begin);
            assert_eq!((begin.bytes, begin.sha256.as_str()), (0, ""), "{}", path.display());
            assert_eq!(source(Extent::Whole).sha256.len(), 64, "{}", path.display());
        }
    }

    /// The end of a Parquet file used to be hashed twice, so that the digest was wrong.
    #[test]
    fn size_and_checksum_are_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        for path in logs(folder.path()).iter().filter(|path| path.is_file()) {
            let (_, source) = open(path, &LoadOptions::default(), Extent::Whole).unwrap();
            let bytes = std::fs::read(path).unwrap();
            let digest: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!((source.bytes, source.sha256), (bytes.len() as u64, digest), "{}", path.display());
        }
    }

    #[test]
    fn unsupported_compression_states_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let mut bytes = zip(&[("a.csv", b"t_s,gx_rads\n0,1\n1,2\n")]);
        // PKWARE's APPNOTE, 4.4.5: Deflate64, in the header of the file and in the directory
        let directory = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
        (bytes[8], bytes[directory + 10]) = (9, 9);
        let path = folder.path().join("a.zip");
        std::fs::write(&path, bytes).unwrap();
        for extent in [Extent::Begin, Extent::Whole] {
            let message = open(&path, &LoadOptions::default(), extent).map(drop).unwrap_err().to_string();
            assert!(
                message.contains("a.zip/a.csv: it cannot be unpacked: ") && message.contains(": 9"),
                "{message}"
            );
            assert!(message.ends_with("\nhelp: unpack it, and name the log itself"), "{message}");
        }
    }
}
