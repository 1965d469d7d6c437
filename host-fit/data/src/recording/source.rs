//! Where data came from: the file, and a checksum of its bytes.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::file::folder_of;

/// The file a recording was read from.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Source {
    /// Path as it was given; for data that never were a file, what made them.
    pub path: String,
    /// Size of the file, bytes (0: not a file).
    pub bytes: u64,
    /// SHA-256 of the file as stored (compressed, if it is), hexadecimal (empty: not a file).
    pub sha256: String,
    /// Where it lies as seen from the folder of the study that names it; none where no study does, or an older one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_study: Option<String>,
    /// Where this process found it, from the root on; none if it was not read now, or is no file.
    #[serde(skip)]
    pub found: Option<PathBuf>,
}

/// The same content is the same source, wherever it lies; what never was a file is told apart by its name.
impl PartialEq for Source {
    fn eq(&self, other: &Source) -> bool {
        self.sha256 == other.sha256 && (!self.sha256.is_empty() || self.path == other.path)
    }
}

impl Eq for Source {}

impl Source {
    /// Names data that were not read from a file.
    pub fn made_by(what: impl Into<String>) -> Source {
        Source { path: what.into(), bytes: 0, sha256: String::new(), from_study: None, found: None }
    }
}

/// Passes bytes on and takes their checksum, so that what is hashed is what was read.
pub(super) struct Hashing<R> {
    inner: R,
    hash: Sha256,
    bytes: u64,
}

impl<R: Read> Hashing<R> {
    pub(super) fn new(inner: R) -> Hashing<R> {
        Hashing { inner, hash: Sha256::new(), bytes: 0 }
    }

    /// Reads what is left (a decoder may stop before the end) and names the whole.
    pub(super) fn finish(mut self, path: &Path) -> io::Result<Source> {
        io::copy(&mut self, &mut io::sink())?;
        let mut sha256 = String::new();
        for byte in self.hash.finalize() {
            let _ = write!(sha256, "{byte:02x}"); // writing to a String cannot fail
        }
        let path_as_given = path.display().to_string();
        Ok(Source { path: path_as_given, bytes: self.bytes, sha256, from_study: None, found: found(path) })
    }
}

/// A file from the root on, by the folder that it really lies in.
fn found(path: &Path) -> Option<PathBuf> {
    let name = path.file_name().filter(|_| path.is_file())?;
    fs::canonicalize(folder_of(path)).ok().map(|folder| folder.join(name))
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.hash.update(&buffer[..n]);
        self.bytes += n as u64;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1
        let mut reader = Hashing::new(&b"abc"[..]);
        reader.read_exact(&mut [0]).unwrap();
        let source = reader.finish(Path::new("x")).unwrap();
        assert_eq!(source.bytes, 3);
        assert_eq!(source.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
