//! Sequential reader of the messages of a ULog file, and a limit on the layout of its formats.

use std::collections::HashMap;
use std::io::{self, BufRead, Read};

/// Bytes before the first message.
const HEADER: u64 = 16;

/// Length and kind of a message.
const FRAME: u64 = 3;

/// Reader of the header, then message by message.
pub(super) struct Messages<R> {
    input: R,
    message: Vec<u8>,
    at: u64,
    is_cut: bool,
}

impl<R: BufRead> Messages<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, message: Vec::new(), at: 0, is_cut: false }
    }

    /// Number of bytes read so far.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Returns true if the file ended within a message.
    pub(super) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Next message with its frame; `None` at the end.
    pub(super) fn next(&mut self) -> io::Result<Option<&[u8]>> {
        self.message.clear();
        if self.at == 0 {
            return Ok(self.take(HEADER)?.then_some(&self.message));
        }
        if !self.take(FRAME)? {
            return Ok(None);
        }
        let length = u16::from_le_bytes([self.message[0], self.message[1]]);
        Ok(self.take(u64::from(length))?.then_some(&self.message))
    }

    fn take(&mut self, bytes: u64) -> io::Result<bool> {
        let read = self.input.by_ref().take(bytes).read_to_end(&mut self.message)? as u64;
        self.at += read;
        self.is_cut |= read < bytes && !self.message.is_empty();
        Ok(read == bytes)
    }
}

/// Maximum nesting of formats; PX4's are nested at most twice.
const MAX_DEPTH: usize = 16;

/// Maximum memory of all laid out formats and subscriptions, bytes; those of PX4 take a few million.
const MAX_BYTES: usize = 1 << 26;

/// Approximate memory of a field without its name, bytes, and number of copies of its name.
const FIELD_BYTES: usize = 200;
const NAME_COPIES: usize = 3;

/// Formats by name. The library lays out all of them when the data begin, and one for every subscription: nested fields,
/// each with its full name. A few lines of nested arrays could exhaust time, memory and stack.
#[derive(Default)]
pub(super) struct Formats {
    /// Type, array length, and length of the name of each field.
    formats: HashMap<String, Vec<(String, usize, usize)>>,
    /// Memory of all subscriptions, bytes.
    subscribed: usize,
}

impl Formats {
    /// Examines a message before the library does; `in_data` once the library has laid out the formats.
    pub(super) fn look_at(&mut self, message: &[u8], in_data: bool) -> Result<(), String> {
        let refused = || "its formats are too deep or too large".to_owned();
        let Some((frame, payload)) = message.split_at_checked(FRAME as usize) else { return Ok(()) };
        match frame[2] {
            b'F' if !in_data => self.add(&String::from_utf8_lossy(payload)),
            // messages that may begin the data
            b'A' | b'L' | b'O' | b'R' | b'S' if !in_data => {
                let mut sum = 0;
                for name in self.formats.keys() {
                    sum += self
                        .bytes(name, 0, 0)
                        .filter(|bytes| sum + bytes <= MAX_BYTES)
                        .ok_or_else(refused)?;
                }
            }
            _ => {}
        }
        if frame[2] == b'A' {
            let name = String::from_utf8_lossy(payload.get(3..).unwrap_or_default());
            self.subscribed += self.bytes(&name, 0, 0).ok_or_else(refused)?;
            if self.subscribed > MAX_BYTES {
                return Err(refused());
            }
        }
        Ok(())
    }

    /// Parses `name:type field;type[3] field;`.
    fn add(&mut self, format: &str) {
        let Some((name, fields)) = format.split_once(':') else { return };
        let fields = fields.split(';').filter_map(|field| field.split_once(' ')).map(|(kind, name)| {
            let (kind, count) = kind.split_once('[').unwrap_or((kind, "1"));
            // the library rejects anything that is no number
            let count = count.trim_end_matches(']').parse().unwrap_or(0_i16);
            (kind.to_owned(), usize::try_from(count).unwrap_or(0), name.len())
        });
        self.formats.insert(name.to_owned(), fields.collect());
    }

    /// Memory of a type as a field with a name of this length, bytes; `None` if it is too deep or too large.
    fn bytes(&self, kind: &str, name: usize, deep: usize) -> Option<usize> {
        // at least as much for an empty type: it takes time
        let mut sum = FIELD_BYTES + NAME_COPIES * name;
        let fields = self.formats.get(kind).map_or(&[][..], Vec::as_slice);
        for (kind, count, length) in fields.iter().filter(|(_, count, _)| *count > 0) {
            if deep == MAX_DEPTH {
                return None;
            }
            sum += count * self.bytes(kind, name + length + ".[0]".len(), deep + 1)?;
            if sum > MAX_BYTES {
                return None;
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(kind: u8, payload: &str) -> Vec<u8> {
        let mut message = (payload.len() as u16).to_le_bytes().to_vec();
        message.push(kind);
        message.extend(payload.as_bytes());
        message
    }

    fn laid_out(formats: &[String], subscriptions: usize) -> bool {
        let mut seen = Formats::default();
        for format in formats {
            seen.look_at(&message(b'F', format), false).unwrap();
        }
        (0..subscriptions).all(|_| seen.look_at(&message(b'A', "\0\0\0a"), false).is_ok())
    }

    #[test]
    fn lays_out_valid_formats_and_rejects_endless_ones() {
        let text =
            |formats: &[&str]| -> Vec<String> { formats.iter().map(|text| (*text).to_owned()).collect() };
        let fifo = "a:uint64_t timestamp;float dt;int16_t[32] x;int16_t[32] y;int16_t[32] z;";
        assert!(laid_out(&text(&[fifo, "b:a[8] inner;"]), 300));
        // a few bytes each
        assert!(!laid_out(&text(&["a:b[32767] x;", "b:c[32767] x;", "c:d[32767] x;", "d:"]), 1));
        assert!(!laid_out(&text(&["a:a x;"]), 1));
        let large = "a:uint8_t[30000] x;";
        assert!(laid_out(&text(&[large]), 1) && !laid_out(&text(&[large]), 100));
        let chain: Vec<String> = (0..10_000).map(|n| format!("{n}:{} x;", n + 1)).collect();
        assert!(!laid_out(&chain, 1));
        let tree: Vec<String> = (0..40).map(|n| format!("{n}:{0} x;{0} y;", n + 1)).collect();
        assert!(!laid_out(&tree, 1));
        let long = format!("a:b[9000] {};", "x".repeat(60_000));
        assert!(!laid_out(&[long], 1));
    }

    #[test]
    fn reads_messages_and_detects_truncation() {
        let file = [vec![7; 16], message(b'I', "one"), message(b'B', "")].concat();
        for (length, whole, is_cut) in
            [(file.len(), 3, false), (file.len() - 1, 2, true), (16, 1, false), (9, 0, true)]
        {
            let mut messages = Messages::new(&file[..length]);
            let mut found = 0;
            while messages.next().unwrap().is_some() {
                found += 1;
            }
            assert_eq!((found, messages.is_cut(), messages.at()), (whole, is_cut, length as u64));
        }
    }
}
