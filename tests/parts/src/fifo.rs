//! FIFO memory, and the record of what went into it.

use std::collections::VecDeque;

use crate::codes::Sample;

/// Fate of the codes of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// Still in the FIFO.
    Queued,
    /// Read by the host, all of it.
    Read,
    /// Overwritten, flushed, or lost in a reset, at least in part.
    Lost,
}

/// Codes of a tick that went into the FIFO, as the host can read them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delivered {
    /// Tick of the source.
    pub tick: u64,
    /// Codes at the range in force, and the latest code of the thermometer that the host could read; `i16::MIN` before the first.
    pub codes: Sample,
    /// Queued, read or lost.
    pub fate: Fate,
    /// Items in the FIFO that hold them.
    items: u8,
}

#[derive(Debug)]
struct Item {
    bytes: Vec<u8>,
    /// Row of the record to which it belongs; none for temperatures and frames without data.
    row: Option<usize>,
}

/// A FIFO of items: frames, packets or tagged words.
#[derive(Debug, Default)]
pub(crate) struct Fifo {
    items: VecDeque<Item>,
    /// Bytes of the first item that were read.
    position: usize,
    /// An item was overwritten or refused since the flag was cleared.
    pub(crate) overrun: bool,
    /// Items lost since this was cleared.
    pub(crate) lost: u32,
    delivered: Vec<Delivered>,
}

impl Fifo {
    pub(crate) fn delivered(&self) -> &[Delivered] {
        &self.delivered
    }

    /// Number of items.
    pub(crate) fn len(&self) -> usize {
        self.items.len()
    }

    /// Opens a row of the record for the codes of a tick; the next items belong to it.
    pub(crate) fn record(&mut self, tick: u64, codes: Sample) -> usize {
        self.delivered.push(Delivered { tick, codes, fate: Fate::Queued, items: 0 });
        self.delivered.len() - 1
    }

    /// Adds an item to a FIFO with room for `capacity` of them; in a full one it replaces the oldest, or is lost itself
    /// with `stop`.
    pub(crate) fn push(&mut self, bytes: Vec<u8>, row: Option<usize>, capacity: usize, stop: bool) {
        if let Some(row) = row {
            self.delivered[row].items += 1;
        }
        let full = self.items.len() >= capacity;
        if full {
            self.overrun = true;
            self.lost += 1;
        }
        if full && stop {
            self.lose(row);
            return;
        }
        if full {
            self.drop_oldest();
        }
        self.items.push_back(Item { bytes, row });
    }

    /// Loses all items as if they had been overwritten.
    pub(crate) fn overrun(&mut self) {
        self.overrun = true;
        self.lost += self.items.len() as u32;
        self.clear();
    }

    /// Empties the FIFO.
    pub(crate) fn clear(&mut self) {
        while !self.items.is_empty() {
            self.drop_oldest();
        }
    }

    fn drop_oldest(&mut self) {
        self.position = 0;
        if let Some(item) = self.items.pop_front() {
            self.lose(item.row);
        }
    }

    fn lose(&mut self, row: Option<usize>) {
        if let Some(row) = row {
            self.delivered[row].fate = Fate::Lost;
        }
    }

    /// Takes the oldest item.
    pub(crate) fn pop(&mut self) -> Option<Vec<u8>> {
        self.position = 0;
        let item = self.items.pop_front()?;
        if let Some(row) = item.row {
            let row = &mut self.delivered[row];
            row.items -= 1;
            if row.items == 0 && row.fate == Fate::Queued {
                row.fate = Fate::Read;
            }
        }
        Some(item.bytes)
    }

    /// Reads the next byte of the oldest item, which leaves the FIFO with its last one.
    pub(crate) fn read(&mut self) -> Option<u8> {
        let item = self.items.front()?;
        let byte = item.bytes[self.position];
        self.position += 1;
        if self.position == item.bytes.len() {
            self.pop();
        }
        Some(byte)
    }

    /// Returns to the beginning of an item that was read in part.
    pub(crate) fn rewind(&mut self) {
        self.position = 0;
    }
}
