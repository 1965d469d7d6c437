//! MCAP with messages of ROS 2, read sequentially.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use mcap::parse_record;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::opened::Opened;
use super::ros::{Encoding, Kind, Topics};
use super::{Format, choice};
use crate::catch_panic::catch_panic;
use crate::file::FileError;
use crate::interrupt;

/// Longest record, bytes: a larger length comes from damage. The library allocates it for a record in a compressed chunk
/// before decompression.
const LONGEST: usize = 1 << 27;

/// A log damaged after its first record is read up to the damage.
pub(super) fn read(
    path: &Path,
    mut input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let reading = LinearReaderOptions::default()
        .with_record_length_limit(LONGEST)
        .with_validate_chunk_crcs(true)
        // a log that was not closed has none
        .with_skip_end_magic(true);
    let mut reader = LinearReader::new_with_options(reading);
    let mut read = Read::new(options);
    let mut at = 0_u64;
    let damage = loop {
        interrupt::check();
        let event = match catch_panic(|| reader.next_event().map(|event| step(&mut read, event))) {
            Ok(None) => break None,
            Ok(Some(Ok(request))) => request,
            Ok(Some(Err(problem))) => break Some(problem),
            Err(problem) => break Some(problem),
        };
        let Some(request) = event else { continue };
        let bytes = input.fill_buf().map_err(FileError::reading(path))?;
        let n = bytes.len().min(request);
        reader.insert(n)[..n].copy_from_slice(&bytes[..n]);
        reader.notify_read(n);
        input.consume(n);
        at += n as u64;
    };
    if !read.is_begun
        && let Some(problem) = damage
    {
        return Err(RecordingError::Damaged {
            path: path.to_owned(),
            format: "MCAP file",
            at: Some(at),
            problem,
        });
    }
    if let (Some(encoding), true) = (read.other_encoding, read.channels.is_empty()) {
        let problem = format!("its messages are encoded as {encoding}");
        return Err(choice::no_sensors(path, Format::Mcap, problem, "record with ROS 2, which writes cdr"));
    }
    let damage = damage.map(|problem| format!("the file is damaged or cut short near byte {at} ({problem})"));
    read.topics.finish(path, Format::Mcap, damage, options.strict)
}

/// Content read so far.
struct Read {
    topics: Topics,
    /// Names of types, by schema id.
    schemas: HashMap<u16, String>,
    /// Index of the topic and encoding of its messages, by channel id.
    channels: HashMap<u16, (usize, Encoding)>,
    other_encoding: Option<String>,
    is_begun: bool,
}

impl Read {
    fn new(options: &LoadOptions) -> Self {
        Self {
            topics: Topics::new(options.topic.as_deref()),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            other_encoding: None,
            is_begun: false,
        }
    }

    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                self.is_begun = true;
                let kind = self.schemas.get(&channel.schema_id).and_then(|name| Kind::of(name));
                let Some(kind) = kind.filter(|kind| self.topics.wants(&channel.topic, *kind)) else { return };
                let encoding = match channel.message_encoding.as_str() {
                    "cdr" => Encoding::Cdr,
                    "ros1" => Encoding::Ros1,
                    other => {
                        self.other_encoding = Some(other.to_owned());
                        return;
                    }
                };
                let number = u32::from(channel.id);
                self.channels.insert(channel.id, (self.topics.add(&channel.topic, kind, number), encoding));
            }
            Record::Message { header, data } => {
                if let Some((topic, encoding)) = self.channels.get(&header.channel_id) {
                    self.topics.take(*topic, &data, *encoding);
                }
            }
            _ => {}
        }
    }
}

/// Processes a record, or returns the number of bytes to read next.
fn step(read: &mut Read, event: mcap::McapResult<LinearReadEvent<'_>>) -> Result<Option<usize>, String> {
    match event.map_err(|error| error.to_string())? {
        LinearReadEvent::ReadRequest(request) => Ok(Some(request)),
        LinearReadEvent::Record { data, opcode } => {
            read.take(parse_record(opcode, data).map_err(|error| error.to_string())?);
            Ok(None)
        }
    }
}
