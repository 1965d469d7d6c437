//! File input for the Parquet library.

use std::io::{ErrorKind, Read, Result};

use bytes::Bytes;
use parquet::errors::Result as ParquetResult;
use parquet::file::reader::{ChunkReader, Length};

/// A file whose end is an error: the library ignores it while skipping unknown fields, and a few bytes of a damaged file
/// can make it skip 2³¹ times.
pub(super) struct Ending<R>(pub(super) R);

impl<R: Length> Length for Ending<R> {
    fn len(&self) -> u64 {
        self.0.len()
    }
}

impl<R: ChunkReader> ChunkReader for Ending<R> {
    type T = EndingRead<R::T>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        self.0.get_read(start).map(EndingRead)
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        self.0.get_bytes(start, length)
    }
}

pub(super) struct EndingRead<R>(R);

impl<R: Read> Read for EndingRead<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self.0.read(buffer)? {
            0 if !buffer.is_empty() => Err(ErrorKind::UnexpectedEof.into()),
            read => Ok(read),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_past_the_end_is_an_error() {
        let input = Ending(Bytes::from_static(b"0123456789"));
        let mut read = input.get_read(7).unwrap();
        let mut rest = [0; 3];
        read.read_exact(&mut rest).unwrap();
        assert_eq!((&rest, input.len()), (b"789", 10));
        assert_eq!(read.read(&mut rest).unwrap_err().kind(), ErrorKind::UnexpectedEof);
        assert_eq!(read.read(&mut []).unwrap(), 0);
        assert_eq!(input.get_bytes(1, 2).unwrap().as_ref(), b"12");
    }
}
