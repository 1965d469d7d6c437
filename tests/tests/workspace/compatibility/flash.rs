//! A small NOR flash in memory, for the store of models.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::store::ModelStore;

pub(crate) const PAGE: usize = 1024;
pub(crate) const BYTES: usize = 4 * PAGE;

pub(crate) struct Flash(pub(crate) Vec<u8>);

impl ErrorType for Flash {
    type Error = core::convert::Infallible;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let offset = offset as usize;
        self.0[offset..offset + bytes.len()].iter_mut().zip(bytes).for_each(|(old, new)| *old &= new);
        Ok(())
    }
}

pub(crate) type Store = ModelStore<Blocking<Flash>, 1024>;

pub(crate) fn store(flash: Flash) -> Store {
    let range = 0..flash.0.len() as u32;
    ModelStore::new(Blocking(flash), range).unwrap_or_else(|_| panic!("a range"))
}

/// Newest image and the previous one.
pub(crate) fn images(store: &mut Store) -> Result<[Option<Vec<u8>>; 2], String> {
    let newest = poll_once(store.load()).expect("done at once").map_err(|error| format!("{error:?}"))?;
    let newest = newest.map(<[u8]>::to_vec);
    let previous =
        poll_once(store.load_previous()).expect("done at once").map_err(|error| format!("{error:?}"))?;
    Ok([newest, previous.map(<[u8]>::to_vec)])
}
