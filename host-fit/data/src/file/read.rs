//! Functions that open user files; each records the file it opened (`inputs`).

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

use super::error::{COPY, FileError};
use super::inputs::note_read;

/// Reads the whole of `path`.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let mut content = Vec::new();
    let mut file = File::open(path).map_err(FileError::reading(path))?;
    note_read(&file, path).and_then(|()| file.read_to_end(&mut content)).map_err(FileError::reading(path))?;
    Ok(content)
}

/// Opens `path` for reading.
pub fn open(path: &Path) -> Result<File, FileError> {
    let file = File::open(path).map_err(FileError::opening(path))?;
    note_read(&file, path).map_err(FileError::opening(path))?;
    Ok(file)
}

/// Fills a buffer as far as the input reaches; returns the number of bytes.
pub fn read_up_to(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match input.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(more) => filled += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Opens `path` as [`open`] does; the content of a pipe, which is readable only once and in order, is copied to an
/// unnamed file.
pub fn open_to_seek(path: &Path) -> Result<File, FileError> {
    let mut file = open(path)?;
    // a folder is refused by the reader
    if file.stream_position().is_ok() || file.metadata().is_ok_and(|about| about.is_dir()) {
        return Ok(file);
    }
    let copy = tempfile::tempfile().and_then(|mut copy| {
        io::copy(&mut file, &mut copy)?;
        copy.rewind()?;
        Ok(copy)
    });
    copy.map_err(FileError::when(COPY, path))
}

/// Standard input as a file, which it may be.
pub fn standard_input() -> io::Result<File> {
    #[cfg(unix)]
    let input = std::os::fd::AsFd::as_fd(&io::stdin()).try_clone_to_owned()?;
    #[cfg(windows)]
    let input = std::os::windows::io::AsHandle::as_handle(&io::stdin()).try_clone_to_owned()?;
    let file = File::from(input);
    note_read(&file, Path::new("standard input"))?;
    Ok(file)
}
