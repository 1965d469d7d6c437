//! Logged quantities other than the axes: setting them, and their columns in a log.

use fos_core::{Info, Quantity, Scalar};
use heapless::{String, Vec};

use super::Hub;
use super::quantity_source::QuantitySource;

/// Largest number of logged quantities: temperature, and those of a hub with 32 `INPUTS`, the most that there can be.
pub const MAX_LOGGED: usize = 33;

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>
    Hub<INPUTS, TERMS, HISTORY, R>
{
    /// Sets a logged quantity from now on, in its unit: supply voltage, processor load, magnetic field, a reference. The
    /// quantities that the sensor measures are set by the hub. Until a quantity is set, the axes that use it are flagged.
    ///
    /// Returns true if the model uses it.
    pub fn give(&mut self, quantity: Quantity, value: f32) -> bool {
        let mut used = false;
        for (source, slot) in self.sources.iter().zip(&mut self.quantities) {
            if *source == QuantitySource::Application(quantity) {
                *slot = R::of(value);
                used = true;
            }
        }
        used
    }

    /// Same as [`give`](Self::give), by the index among the model's quantities that the application gives; for quantities
    /// that have only a name. Returns false if there is no such index.
    pub fn give_application(&mut self, index: usize, value: f32) -> bool {
        let given = self.sources.iter().zip(&mut self.quantities);
        match given.filter(|(source, _)| source.is_application()).nth(index) {
            Some((_, slot)) => {
                *slot = R::of(value);
                true
            }
            None => false,
        }
    }

    /// Temperature in °C, then the quantities given by the application, in the model's order and units.
    pub fn logged(&self) -> Vec<f32, MAX_LOGGED> {
        const { assert!(INPUTS < MAX_LOGGED, "every quantity must have room, as it has a column") };
        let given = self.sources.iter().zip(&self.quantities).filter(|(source, _)| source.is_application());
        let mut logged = Vec::new();
        for value in core::iter::once(self.output.temperature_c).chain(given.map(|(_, value)| *value)) {
            let _ = logged.push(value.stored());
        }
        logged
    }

    /// Names of the columns of [`logged`](Self::logged) in the log format, one per line; `info` is that of the image.
    /// `None` if they exceed `N` bytes.
    pub fn columns<const N: usize>(&self, info: &Info<'_>) -> Option<String<N>> {
        columns(&self.sources, info)
    }
}

// not inlined: one copy for the hubs of every scalar
#[inline(never)]
fn columns<const N: usize>(sources: &[QuantitySource], info: &Info<'_>) -> Option<String<N>> {
    let mut columns = String::new();
    columns.push_str("temp_c").ok()?;
    let mut names = info.quantities.lines();
    for source in sources {
        let name = names.next().and_then(|line| line.split_whitespace().next());
        if source.is_application() {
            columns.push('\n').ok()?;
            columns.push_str(name.unwrap_or("unnamed")).ok()?;
        }
    }
    Some(columns)
}
