//! Bags of ROS 1, version 2.0: records of named fields and data, most of them in chunks that may be compressed.
//!
//! Read sequentially, so that a bag that was not closed, and has no index, is read too.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, BufRead, Read as _};
use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::Format;
use super::opened::Opened;
use super::ros::{Encoding, Kind, Topics};
use crate::file::FileError;
use crate::interrupt;

const SIGNATURE: &[u8] = b"#ROSBAG V2.0\n";

const MESSAGE: u8 = 0x02;
const CHUNK: u8 = 0x05;
const CONNECTION: u8 = 0x07;

/// Longest header of a record, bytes: names of topics and definitions of types.
const LONGEST_HEADER: u32 = 1 << 24;

/// Longest data of a record, bytes: a larger length comes from damage.
const LONGEST: u32 = 1 << 30;

/// Longest decompressed chunk, bytes: a few kilobytes may expand to any length. Writers close chunks beyond a megabyte.
const LONGEST_UNPACKED: u32 = 1 << 27;

pub(super) fn read(
    path: &Path,
    mut input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let mut signature = Vec::new();
    input
        .by_ref()
        .take(SIGNATURE.len() as u64)
        .read_to_end(&mut signature)
        .map_err(FileError::reading(path))?;
    if !signature.starts_with(b"#ROSBAG V") {
        return Err(RecordingError::Damaged {
            path: path.to_owned(),
            format: "ROS 1 bag",
            at: Some(0),
            problem: "it does not begin as one".to_owned(),
        });
    }
    if signature != SIGNATURE {
        return Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: "it is a ROS bag of another version than 2.0".to_owned(),
            help: "convert it by `rosbag migrate`",
        });
    }
    let mut read = Read::new(options);
    let mut at = SIGNATURE.len() as u64;
    let (mut header, mut data) = (Vec::new(), Vec::new());
    let damage = loop {
        interrupt::check();
        match record(&mut input, &mut header, &mut data) {
            Ok(false) => break None,
            Ok(true) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                break Some("it ends within a record".to_owned());
            }
            Err(error) if error.kind() == io::ErrorKind::InvalidData => break Some(error.to_string()),
            Err(error) => return Err(FileError::reading(path)(error).into()),
        }
        if let Err(problem) = read.take(&header, &data) {
            break Some(problem);
        }
        at += (8 + header.len() + data.len()) as u64;
    };
    let damage = damage.map(|problem| format!("the file is damaged or cut short near byte {at} ({problem})"));
    read.topics.finish(path, Format::Bag, damage, options.strict)
}

/// Reads header and data of a record; returns false at the end.
fn record(input: &mut impl BufRead, header: &mut Vec<u8>, data: &mut Vec<u8>) -> io::Result<bool> {
    if input.fill_buf()?.is_empty() {
        return Ok(false);
    }
    for (part, longest) in [(header, LONGEST_HEADER), (data, LONGEST)] {
        let mut length = [0; 4];
        input.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > longest {
            return Err(io::Error::new(io::ErrorKind::InvalidData, format!("a record of {length} bytes")));
        }
        part.clear();
        // grows with the bytes that exist, whatever the length field states
        input.by_ref().take(u64::from(length)).read_to_end(part)?;
        if part.len() < length as usize {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
    }
    Ok(true)
}

/// Fields of a header: a sequence of `length name=value`.
fn fields(mut header: &[u8]) -> HashMap<&[u8], &[u8]> {
    let mut fields = HashMap::new();
    while let Some((length, rest)) = split_length(header) {
        let Some((field, rest)) = rest.split_at_checked(length) else { break };
        if let Some(equals) = field.iter().position(|&byte| byte == b'=') {
            fields.insert(&field[..equals], &field[equals + 1..]);
        }
        header = rest;
    }
    fields
}

fn split_length(bytes: &[u8]) -> Option<(usize, &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    Some((usize::try_from(u32::from_le_bytes(*length)).ok()?, rest))
}

fn number(field: Option<&&[u8]>) -> Option<u32> {
    Some(u32::from_le_bytes((*field?).try_into().ok()?))
}

/// Content read so far.
struct Read {
    topics: Topics,
    /// Indices of topics, by connection id.
    connections: HashMap<u32, usize>,
}

impl Read {
    fn new(options: &LoadOptions) -> Self {
        Self { topics: Topics::new(options.topic.as_deref()), connections: HashMap::new() }
    }

    fn take(&mut self, header: &[u8], data: &[u8]) -> Result<(), String> {
        let fields = fields(header);
        let op = fields.get(&b"op"[..]).and_then(|op| op.first()).copied();
        match op {
            Some(CHUNK) => {
                let size = number(fields.get(&b"size"[..])).ok_or("a chunk without a size")?;
                let compression = fields.get(&b"compression"[..]).copied().unwrap_or(b"none");
                let chunk = unpacked(compression, data, size)?;
                let mut rest = &chunk[..];
                while !rest.is_empty() {
                    let (header, after) = part(rest).ok_or("a chunk that ends within a record")?;
                    let (data, after) = part(after).ok_or("a chunk that ends within a record")?;
                    self.take_inner(header, data);
                    rest = after;
                }
            }
            Some(_) => self.take_inner(header, data),
            None => return Err("a record without a kind".to_owned()),
        }
        Ok(())
    }

    /// Processes a record in a chunk, or in a bag without chunks.
    fn take_inner(&mut self, header: &[u8], data: &[u8]) {
        let record = fields(header);
        let Some(connection) = number(record.get(&b"conn"[..])) else { return };
        match record.get(&b"op"[..]).and_then(|op| op.first()) {
            Some(&CONNECTION) => {
                let described = fields(data);
                let name = described.get(&b"type"[..]).map(|name| String::from_utf8_lossy(name));
                let topic = record.get(&b"topic"[..]).map(|topic| String::from_utf8_lossy(topic));
                let (Some(name), Some(topic)) = (name, topic) else { return };
                if let Some(kind) = Kind::of(&name).filter(|kind| self.topics.wants(&topic, *kind)) {
                    self.connections.insert(connection, self.topics.add(&topic, kind, connection));
                }
            }
            Some(&MESSAGE) => {
                if let Some(topic) = self.connections.get(&connection) {
                    self.topics.take(*topic, data, Encoding::Ros1);
                }
            }
            _ => {}
        }
    }
}

/// Splits off a part that is preceded by its length, and returns the remaining bytes.
fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = split_length(bytes)?;
    rest.split_at_checked(length)
}

fn unpacked<'a>(compression: &[u8], data: &'a [u8], size: u32) -> Result<Cow<'a, [u8]>, String> {
    if size > LONGEST_UNPACKED && compression != b"none" {
        return Err(format!("a chunk of {size} bytes"));
    }
    let mut unpacked = Vec::new();
    let most = u64::from(size);
    let read = match compression {
        b"none" => return Ok(Cow::Borrowed(data)),
        b"bz2" => bzip2::read::BzDecoder::new(data).take(most).read_to_end(&mut unpacked),
        b"lz4" => lz4::Decoder::new(data).and_then(|decoder| decoder.take(most).read_to_end(&mut unpacked)),
        other => return Err(format!("a chunk compressed by {}", String::from_utf8_lossy(other))),
    };
    match read {
        Ok(n) if n as u64 == most => Ok(Cow::Owned(unpacked)),
        Ok(_) => Err("a chunk shorter than it says".to_owned()),
        Err(error) => Err(format!("a chunk that does not unpack: {error}")),
    }
}
