//! Messages of a DataFlash log: two bytes of header, the type, and a payload described by an FMT message.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use super::super::super::error::RecordingError;
use crate::file::FileError;
use crate::interrupt;

const BEGIN: [u8; 2] = [0xa3, 0x95];

/// Type of messages that describe messages.
const FMT: u8 = 128;

/// Payload of such a message, bytes: type, length, name, format, labels.
const FMT_PAYLOAD: usize = 86;

/// Bytes counted in the length of a message in addition to the payload: header and type.
const FRAME: usize = 3;

/// Layout of the fields of a message.
#[derive(Debug)]
pub(super) struct Reader {
    name: String,
    payload: usize,
    /// Letter of the type and offset of each field, by label.
    fields: HashMap<String, (u8, usize)>,
}

/// Sequential reader of the messages of a log.
pub(super) struct Messages<'a, R> {
    path: &'a Path,
    input: R,
    readers: Vec<Option<Reader>>,
    payload: Vec<u8>,
    lost: u64,
    is_cut: bool,
}

impl<'a, R: BufRead> Messages<'a, R> {
    pub(super) fn new(path: &'a Path, input: R) -> Self {
        let mut readers = Vec::new();
        readers.resize_with(256, || None);
        Self { path, input, readers, payload: Vec::new(), lost: 0, is_cut: false }
    }

    /// Number of bytes outside of messages; those of a truncated end do not count.
    pub(super) fn bytes_lost(&self) -> u64 {
        self.lost
    }

    /// Returns true if the log ended within a message.
    pub(super) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Next message; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<(&Reader, &[u8])>, RecordingError> {
        loop {
            interrupt::check();
            let Some(kind) = self.begin()? else { return Ok(None) };
            let payload = match &self.readers[usize::from(kind)] {
                _ if kind == FMT => FMT_PAYLOAD,
                Some(reader) => reader.payload,
                None => {
                    self.lost += FRAME as u64;
                    continue;
                }
            };
            self.payload.resize(payload, 0);
            if !self.fill()? {
                self.is_cut = true;
                return Ok(None);
            }
            if kind == FMT {
                match Reader::of(&self.payload) {
                    Some((kind, reader)) => self.readers[usize::from(kind)] = Some(reader),
                    None => self.lost += (FRAME + FMT_PAYLOAD) as u64,
                }
                continue;
            }
            if self.readers[usize::from(kind)].is_some() {
                break Ok(self.readers[usize::from(kind)].as_ref().map(|reader| (reader, &self.payload[..])));
            }
        }
    }

    /// Skips bytes outside of messages and the two header bytes; returns the type, `None` at the end.
    fn begin(&mut self) -> Result<Option<u8>, RecordingError> {
        let mut before = 0;
        let mut passed = 0_u64;
        loop {
            let Some(byte) = self.byte()? else { return Ok(None) };
            passed += 1;
            if [before, byte] == BEGIN {
                self.lost += passed - 2;
                return self.byte();
            }
            before = byte;
            if passed.is_multiple_of(1 << 20) {
                interrupt::check();
            }
        }
    }

    fn byte(&mut self) -> Result<Option<u8>, RecordingError> {
        let bytes = self.input.fill_buf().map_err(FileError::reading(self.path))?;
        let byte = bytes.first().copied();
        if byte.is_some() {
            self.input.consume(1);
        }
        Ok(byte)
    }

    /// Fills the payload; returns false if the file ends before.
    fn fill(&mut self) -> Result<bool, RecordingError> {
        let mut filled = 0;
        while filled < self.payload.len() {
            let bytes = self.input.fill_buf().map_err(FileError::reading(self.path))?;
            let n = bytes.len().min(self.payload.len() - filled);
            if n == 0 {
                return Ok(false);
            }
            self.payload[filled..filled + n].copy_from_slice(&bytes[..n]);
            self.input.consume(n);
            filled += n;
        }
        Ok(true)
    }
}

/// Size of a field by the letter of its type, bytes; `None` if it is unknown.
fn size(letter: u8) -> Option<usize> {
    Some(match letter {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'f' | b'n' | b'e' | b'E' | b'L' => 4,
        b'd' | b'q' | b'Q' => 8,
        b'N' => 16,
        b'Z' | b'a' => 64,
        _ => return None,
    })
}

fn text_of(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

impl Reader {
    /// Type that an FMT message describes, and its layout; `None` if it is invalid.
    fn of(payload: &[u8]) -> Option<(u8, Self)> {
        let (kind, length) = (*payload.first()?, usize::from(*payload.get(1)?));
        let name = text_of(payload.get(2..6)?);
        let format = text_of(payload.get(6..22)?);
        let labels = text_of(payload.get(22..FMT_PAYLOAD)?);
        let room = length.checked_sub(FRAME)?;
        let mut fields = HashMap::new();
        let mut at = 0;
        for (letter, label) in format.bytes().zip(labels.split(',')) {
            let end = at + size(letter)?;
            if end > room {
                return None;
            }
            fields.insert(label.trim().to_owned(), (letter, at));
            at = end;
        }
        Some((kind, Self { name, payload: room, fields }))
    }

    /// Name of the message in the log.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Returns true if the message has a field of this label.
    pub(super) fn has(&self, label: &str) -> bool {
        self.fields.contains_key(label)
    }

    fn bytes<'a>(&self, label: &str, payload: &'a [u8]) -> Option<(u8, &'a [u8])> {
        let (letter, at) = *self.fields.get(label)?;
        Some((letter, payload.get(at..at + size(letter)?)?))
    }

    /// Value of a numeric field, in the unit implied by its type.
    pub(super) fn number(&self, label: &str, payload: &[u8]) -> Option<f64> {
        let (letter, bytes) = self.bytes(label, payload)?;
        let wide = |bytes: &[u8]| -> Option<[u8; 8]> { bytes.try_into().ok() };
        let four = |bytes: &[u8]| -> Option<[u8; 4]> { bytes.try_into().ok() };
        let two = |bytes: &[u8]| -> Option<[u8; 2]> { bytes.try_into().ok() };
        Some(match letter {
            b'b' => f64::from(bytes[0] as i8),
            b'B' | b'M' => f64::from(bytes[0]),
            b'h' => f64::from(i16::from_le_bytes(two(bytes)?)),
            b'H' => f64::from(u16::from_le_bytes(two(bytes)?)),
            b'c' => f64::from(i16::from_le_bytes(two(bytes)?)) / 100.0,
            b'C' => f64::from(u16::from_le_bytes(two(bytes)?)) / 100.0,
            b'i' | b'L' => f64::from(i32::from_le_bytes(four(bytes)?)),
            b'I' => f64::from(u32::from_le_bytes(four(bytes)?)),
            b'e' => f64::from(i32::from_le_bytes(four(bytes)?)) / 100.0,
            b'E' => f64::from(u32::from_le_bytes(four(bytes)?)) / 100.0,
            b'f' => f64::from(f32::from_le_bytes(four(bytes)?)),
            b'd' => f64::from_le_bytes(wide(bytes)?),
            b'q' => i64::from_le_bytes(wide(bytes)?) as f64,
            b'Q' => u64::from_le_bytes(wide(bytes)?) as f64,
            _ => return None,
        })
    }

    pub(super) fn text(&self, label: &str, payload: &[u8]) -> Option<String> {
        let (letter, bytes) = self.bytes(label, payload)?;
        b"nNZ".contains(&letter).then(|| text_of(bytes))
    }

    /// Time of a message, ns: that of its sample, else that of its writing, in µs or, up to 2014, in ms.
    pub(super) fn stamp_ns(&self, payload: &[u8]) -> Option<i64> {
        const CLOCKS: [(&str, i64); 3] = [("SampleUS", 1000), ("TimeUS", 1000), ("TimeMS", 1_000_000)];
        CLOCKS.into_iter().find_map(|(label, ns)| {
            let (letter, bytes) = self.bytes(label, payload)?;
            let ticks = match letter {
                b'Q' | b'q' => i64::from_le_bytes(bytes.try_into().ok()?),
                b'I' => i64::from(u32::from_le_bytes(bytes.try_into().ok()?)),
                _ => return None,
            };
            ticks.checked_mul(ns)
        })
    }
}
