//! What is logged beside the axes: what the application gives of it, and all of it as columns.

use fos_core::{Info, Quantity, Scalar};
use heapless::{String, Vec};

use super::Hub;
use super::quantity_source::QuantitySource;

/// So many quantities are logged at most, temperature among them.
pub const MAX_LOGGED: usize = 17;

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>
    Hub<INPUTS, TERMS, HISTORY, R>
{
    /// What a logged quantity is from now on, in its unit: supply voltage, processor load, magnetic field, a
    /// reference. Those that the sensor itself measures need not be given. Until it is given, its axes are flagged.
    ///
    /// Returns whether the model uses it.
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

    /// As [`give`](Self::give), for the quantity of this index among those of the model that the application gives:
    /// for one that has only a name.
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

    /// What was logged beside the axes: temperature, then what the application gave, in the model's order.
    pub fn logged(&self) -> Vec<f32, MAX_LOGGED> {
        let given = self.sources.iter().zip(&self.quantities).filter(|(source, _)| source.is_application());
        let mut logged = Vec::new();
        for value in core::iter::once(self.output.temperature_c).chain(given.map(|(_, value)| *value)) {
            let _ = logged.push(value.stored());
        }
        logged
    }

    /// Columns of what is [`logged`](Self::logged), one a line, as the log format has them; `info` is that of the
    /// image. `None` if they do not fit.
    pub fn columns<const N: usize>(&self, info: &Info<'_>) -> Option<String<N>> {
        columns(&self.sources, info)
    }
}

/// One copy for the hubs of every scalar.
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
