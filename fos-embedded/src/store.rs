//! Model images in flash: two slots, of which the newest valid one is used.
//!
//! Each slot is a separate range of pages, managed by `sequential-storage`: checksums, wear levelling, repair after a
//! power loss. An update is written to the slot that is not in use and read back; the slot in use is not touched, so it
//! survives power loss and worn pages of the other slot. The previous image remains available for a rollback. A blocking
//! flash needs the adapter [`Blocking`](crate::blocking::Blocking).
//!
//! ```
//! # use embedded_storage_async::nor_flash::NorFlash;
//! # use fos_embedded::store::{ModelStore, StoreError};
//! async fn update<F: NorFlash>(flash: F, image: &[u8]) -> Result<(), StoreError<F::Error>> {
//!     let mut store: ModelStore<_, 2048> = ModelStore::new(flash, 0..4 * F::ERASE_SIZE as u32)?;
//!     store.store(image).await?;
//!     assert_eq!(store.load().await?, Some(image));
//!     Ok(())
//! }
//! ```

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use fos_core::{Image, ImageError};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage, SerializationError, Value};

/// Bytes before the image in a slot: its number, incremented with every update.
const NUMBER: usize = 4;

/// Key of the only item of a slot.
const KEY: u8 = 0;

/// Reason why an image cannot be stored or loaded. After every error the previously valid image is still valid.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError<E> {
    /// The range does not consist of whole pages, or has fewer than four.
    Range,
    /// The bytes are not an image that this version of fos runs.
    Image(ImageError),
    /// The image is too long; holds the limit in bytes, from buffer and flash.
    TooLong(usize),
    /// The image was written but did not read back: worn flash.
    VerifyFailed,
    /// The flash failed, or its contents cannot be repaired.
    Flash(sequential_storage::Error<E>),
}

impl<E> From<sequential_storage::Error<E>> for StoreError<E> {
    fn from(error: sequential_storage::Error<E>) -> Self {
        Self::Flash(error)
    }
}

/// Model images in a range of flash. `BYTES` is the length of the buffer: the longest image plus 8 bytes, rounded up to the
/// word of the flash. An image must fit a page, or half a page if a slot has only two: when the first page is full, its
/// image moves to the second and the new one is written after it.
pub struct ModelStore<F: NorFlash, const BYTES: usize> {
    flash: F,
    slots: [Range<u32>; 2],
    buffer: Buffer<BYTES>,
}

/// Some flash controllers read and write aligned words only.
#[repr(align(4))]
struct Buffer<const BYTES: usize>([u8; BYTES]);

/// Item stored in a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Record<'a> {
    number: [u8; NUMBER],
    image: &'a [u8],
}

impl<'a> Value<'a> for Record<'a> {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let length = NUMBER + self.image.len();
        let places = buffer.get_mut(..length).and_then(|buffer| buffer.split_first_chunk_mut::<NUMBER>());
        let (number, image) = places.ok_or(SerializationError::BufferTooSmall)?;
        *number = self.number;
        image.copy_from_slice(self.image);
        Ok(length)
    }

    fn deserialize_from(buffer: &'a [u8]) -> Result<(Self, usize), SerializationError> {
        let (number, image) =
            buffer.split_first_chunk::<NUMBER>().ok_or(SerializationError::InvalidFormat)?;
        Ok((Self { number: *number, image }, buffer.len()))
    }
}

/// Number and length of the image in a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    slot: usize,
    number: u32,
    length: usize,
}

impl<F: NorFlash, const BYTES: usize> ModelStore<F, BYTES> {
    /// Creates a store in `range` of `flash`, in bytes: at least four whole pages, half of them for each slot.
    ///
    /// # Errors
    ///
    /// [`StoreError::Range`] if the range does not consist of whole pages, or has fewer than four.
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, StoreError<F::Error>> {
        let page = F::ERASE_SIZE as u32;
        let pages = range.end.saturating_sub(range.start) / page;
        let middle = range.start + pages / 2 * page;
        let slots = [range.start..middle, middle..range.end];
        for slot in &slots {
            MapConfig::<F>::try_new(slot.clone()).map_err(|_| StoreError::Range)?;
        }
        Ok(Self { flash, slots, buffer: Buffer([0; BYTES]) })
    }

    /// Stores an image as the newest, in the slot not in use, and reads it back. A slot with foreign contents is erased
    /// first.
    ///
    /// # Errors
    ///
    /// The bytes are not a valid image, the image is too long, or the flash fails. The newest image is then unchanged.
    pub async fn store(&mut self, image: &[u8]) -> Result<(), StoreError<F::Error>> {
        Image::parse(image).map_err(StoreError::Image)?;
        let length = NUMBER + image.len();
        let longest = self.longest();
        if image.len() > longest {
            return Err(StoreError::TooLong(longest));
        }
        let newest = self.newest().await?;
        let number = newest.map_or(0, |held| held.number.wrapping_add(1));
        let slot = newest.map_or(0, |held| 1 - held.slot);
        let record = Record { number: number.to_le_bytes(), image };
        // a worn page may lose the image: repeat until the page is full and the next one is used
        let repeats = F::ERASE_SIZE / length + 2;
        let mut is_erased = false;
        for repeat in 0..=repeats {
            let (mut map, buffer) = self.map(slot)?;
            if repeat == repeats && !is_erased {
                // foreign contents that hide what is written; the slot is not in use
                map.erase_all().await?;
                is_erased = true;
            }
            let read_back: Result<Option<Record<'_>>, _> = match map.store_item(buffer, &KEY, &record).await {
                Ok(()) => map.fetch_item(buffer, &KEY).await,
                Err(error) => Err(error),
            };
            match read_back {
                Ok(read_back) if read_back == Some(record) => {
                    info!("slot {=usize}: image {=u32} of {=usize} bytes stored", slot, number, image.len());
                    return Ok(());
                }
                Ok(_) => warn!("slot {=usize}: an image did not read back", slot),
                Err(error @ sequential_storage::Error::Storage { .. }) => return Err(error.into()),
                // not of the contents: a further erase would only wear the flash
                Err(error) if is_erased => return Err(error.into()),
                // foreign contents
                Err(_) => {
                    warn!("slot {=usize}: erased, beyond repair", slot);
                    map.erase_all().await?;
                    is_erased = true;
                }
            }
        }
        Err(StoreError::VerifyFailed)
    }

    /// Reads the newest valid image; `None` if there is none.
    ///
    /// # Errors
    ///
    /// The flash fails. A slot that is damaged, or whose image this version of fos does not run, is passed over.
    pub async fn load(&mut self) -> Result<Option<&[u8]>, StoreError<F::Error>> {
        let Some(newest) = self.newest().await? else { return Ok(None) };
        self.image_of(newest).await
    }

    /// Reads the image before the newest, if its slot is still valid, for a rollback after a bad update.
    ///
    /// # Errors
    ///
    /// The flash fails.
    pub async fn load_previous(&mut self) -> Result<Option<&[u8]>, StoreError<F::Error>> {
        let Some(newest) = self.newest().await? else { return Ok(None) };
        match self.held(1 - newest.slot).await? {
            Some(previous) => self.image_of(previous).await,
            None => Ok(None),
        }
    }

    /// Returns the flash for another use; the images stay in it.
    pub fn release(self) -> F {
        self.flash
    }

    /// Length of the longest image that the buffer and a slot can hold, bytes.
    fn longest(&self) -> usize {
        let word = F::WRITE_SIZE.max(F::READ_SIZE);
        // a word at the start and one at the end of a page hold its state
        let page = F::ERASE_SIZE.saturating_sub(2 * word);
        let pages = self.slots[0].len() / F::ERASE_SIZE;
        let place = if pages < 3 { page / 2 / word * word } else { page };
        let item = place.saturating_sub(Map::<F>::item_overhead_size() as usize).min(BYTES);
        // the map writes the key first
        item.saturating_sub(NUMBER + 1)
    }

    /// The map of a slot and its work buffer.
    fn map(&mut self, slot: usize) -> Result<Opened<'_, F>, StoreError<F::Error>> {
        let config = MapConfig::try_new(self.slots[slot].clone()).map_err(|_| StoreError::Range)?;
        Ok((Map::new(&mut self.flash, config, Cache::new_uncached()), &mut self.buffer.0))
    }

    async fn newest(&mut self) -> Result<Option<Held>, StoreError<F::Error>> {
        let (first, second) = (self.held(0).await?, self.held(1).await?);
        Ok(match (first, second) {
            // numbers wrap: the newer one is less than 2³¹ ahead
            (Some(first), Some(second)) if first.number.wrapping_sub(second.number) < 1 << 31 => Some(first),
            (_, Some(second)) => Some(second),
            (first, None) => first,
        })
    }

    /// Number and length of the image in a slot; `None` if it has no valid image or is damaged beyond repair.
    async fn held(&mut self, slot: usize) -> Result<Option<Held>, StoreError<F::Error>> {
        let (mut map, buffer) = self.map(slot)?;
        let record: Option<Record<'_>> = match map.fetch_item(buffer, &KEY).await {
            Ok(record) => record,
            Err(error @ sequential_storage::Error::Storage { .. }) => return Err(error.into()),
            Err(_) => {
                warn!("slot {=usize}: passed over, beyond repair", slot);
                None
            }
        };
        Ok(record.and_then(|record| {
            let Record { number, image } = record;
            if let Err(error) = Image::parse(image) {
                warn!("slot {=usize}: passed over, {}", slot, error);
                return None;
            }
            Some(Held { slot, number: u32::from_le_bytes(number), length: image.len() })
        }))
    }

    async fn image_of(&mut self, held: Held) -> Result<Option<&[u8]>, StoreError<F::Error>> {
        let (mut map, buffer) = self.map(held.slot)?;
        let record: Option<Record<'_>> = map.fetch_item(buffer, &KEY).await?;
        Ok(record.and_then(|record| record.image.get(..held.length)))
    }
}

/// Formats the place of the slots, not the images, which are in the flash.
#[cfg(feature = "defmt")]
impl<F: NorFlash, const BYTES: usize> defmt::Format for ModelStore<F, BYTES> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "ModelStore {{ slots: {}, longest: {=usize} }}", self.slots, BYTES);
    }
}

/// The map of a slot and its work buffer.
type Opened<'f, F> = (Map<'f, F>, &'f mut [u8]);

type Map<'f, F> = MapStorage<u8, &'f mut F, Cache<Uncached, Uncached, Uncached, u8>>;
