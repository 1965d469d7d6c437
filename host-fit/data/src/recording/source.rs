//! Source of a recording: the file and a checksum of its bytes.

use std::fs;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::format::ReadAs;
use crate::file::folder_of;
use crate::text::hexadecimal;

/// File that a recording was read from.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Source {
    /// Path as given; for data that never were a file, a description of their origin.
    pub path: String,
    /// Size of the file, bytes (0: not a file).
    pub bytes: u64,
    /// SHA-256 of the file as stored (compressed, if it is), hexadecimal (empty: not a file).
    pub sha256: String,
    /// Path relative to the folder of the study that names it; `None` without a study, or with an older one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_study: Option<String>,
    /// Format and assumptions of the reader; `None` for the log format.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub read_as: Option<ReadAs>,
    /// Absolute path at which this process found it; `None` if it was not read now, or is no file.
    #[serde(skip)]
    pub found: Option<PathBuf>,
}

/// Equal content is the same source, wherever it is stored; data that never were a file are compared by name.
impl PartialEq for Source {
    fn eq(&self, other: &Source) -> bool {
        self.sha256 == other.sha256 && (!self.sha256.is_empty() || self.path == other.path)
    }
}

impl Eq for Source {}

impl Source {
    /// Source of data that were not read from a file.
    pub fn made_by(what: impl Into<String>) -> Source {
        Source {
            path: what.into(),
            bytes: 0,
            sha256: String::new(),
            from_study: None,
            read_as: None,
            found: None,
        }
    }

    /// Source of a file with this digest.
    pub(super) fn of(path: &Path, bytes: u64, digest: &[u8]) -> Source {
        let sha256 = hexadecimal(digest);
        let found = found(path);
        Source { path: path.display().to_string(), bytes, sha256, from_study: None, read_as: None, found }
    }
}

/// Checksum over all bytes read of one or several files.
pub(super) struct Digest {
    /// `None` for a preview, which needs no identity.
    hash: Option<Sha256>,
    bytes: u64,
}

impl Digest {
    pub(super) fn new() -> Digest {
        Digest { hash: Some(Sha256::new()), bytes: 0 }
    }

    pub(super) fn none() -> Digest {
        Digest { hash: None, bytes: 0 }
    }

    /// Includes the name of one of several files, which is not part of their bytes.
    pub(super) fn take_name(&mut self, name: &str) {
        if let Some(hash) = &mut self.hash {
            hash.update(name.as_bytes());
            hash.update([0]);
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        if let Some(hash) = &mut self.hash {
            hash.update(bytes);
            self.bytes += bytes.len() as u64;
        }
    }

    pub(super) fn finish(self, path: &Path) -> Source {
        match self.hash {
            Some(hash) => Source::of(path, self.bytes, &hash.finalize()),
            None => Source::made_by(path.display().to_string()),
        }
    }
}

/// Reader that hashes the bytes passed through, so that the checksum covers exactly the data read.
pub(super) struct Hashing<'a, R> {
    inner: R,
    digest: &'a mut Digest,
}

impl<'a, R: Read> Hashing<'a, R> {
    pub(super) fn new(inner: R, digest: &'a mut Digest) -> Hashing<'a, R> {
        Hashing { inner, digest }
    }

    /// Reads to the end if a checksum is computed: a decoder may stop before.
    pub(super) fn read_rest(&mut self) -> io::Result<()> {
        if self.digest.hash.is_some() {
            io::copy(self, &mut io::sink())?;
        }
        Ok(())
    }
}

impl<R: Read> Read for Hashing<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.digest.take(&buffer[..n]);
        Ok(n)
    }
}

impl<R: BufRead> BufRead for Hashing<'_, R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        // consumed bytes are still in the buffer
        if let Ok(bytes) = self.inner.fill_buf() {
            self.digest.take(&bytes[..n.min(bytes.len())]);
        }
        self.inner.consume(n);
    }
}

/// Absolute path of a file or folder, with links in its parent folder resolved.
fn found(path: &Path) -> Option<PathBuf> {
    let name = path.file_name().filter(|_| path.is_file() || path.is_dir())?;
    fs::canonicalize(folder_of(path)).ok().map(|folder| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1
        let mut digest = Digest::new();
        let mut reader = Hashing::new(&b"abc"[..], &mut digest);
        reader.read_exact(&mut [0]).unwrap();
        assert_eq!(reader.fill_buf().unwrap(), b"bc");
        reader.consume(1);
        reader.read_rest().unwrap();
        let source = digest.finish(Path::new("x"));
        assert_eq!(source.bytes, 3);
        assert_eq!(source.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn preview_stops_before_the_end() {
        let mut digest = Digest::none();
        let mut reader = Hashing::new(&b"abc"[..], &mut digest);
        reader.read_exact(&mut [0]).unwrap();
        reader.read_rest().unwrap();
        assert_eq!(reader.fill_buf().unwrap(), b"bc");
        let source = digest.finish(Path::new("x"));
        assert_eq!((source.path.as_str(), source.bytes, source.sha256.as_str()), ("x", 0, ""));
    }
}
