//! Inputs evaluated over a recording by fos-core, and from which row on they are known.

use std::collections::BTreeMap;
use std::sync::Arc;

use fos_core::Transformer;

use super::terms::{Product, Regressor};
use crate::memo::Memo;
use fos_data::recording::{Boundary, Recording, RecordingError, back_filled};
use fos_fit::fit::InputSpec;
use fos_fit::noise::Blocks;

/// A column that begins later than after this share of the rows is not known well enough: what it did before would have
/// to be guessed, and leaving so many rows out would cost every other effect its evidence.
const LATEST: f64 = 0.1;

/// Evaluates inputs over a recording, one value per row, as fos-core does on the device.
#[derive(Debug)]
pub struct Inputs<'a> {
    recording: &'a Recording,
    /// Inputs without a parameter, which are asked for again and again.
    kept: Memo<String, Arc<[f64]>>,
    /// What transforms begin with: columns as a device has them, NaN before their first value.
    held: Memo<String, Arc<[f64]>>,
}

impl<'a> Inputs<'a> {
    pub fn new(recording: &'a Recording) -> Self {
        Self { recording, kept: Memo::default(), held: Memo::default() }
    }

    /// The log that the inputs are computed from.
    pub fn recording(&self) -> &'a Recording {
        self.recording
    }

    /// What the recording does not have of a column, in words; none if it can be followed.
    pub fn lacks(&self, column: &str) -> Option<String> {
        let Ok(channel) = self.recording.channel(column) else { return Some(column.to_owned()) };
        let first = channel.values.iter().position(|value| !value.is_nan());
        match first {
            None => Some(format!("{column} (every cell is empty)")),
            Some(row) if row as f64 > LATEST * self.recording.n_rows() as f64 => {
                let time_s = self.recording.time_s[row] - self.recording.time_s[0];
                Some(format!("{column} (empty for the first {time_s:.1} s)"))
            }
            Some(_) => None,
        }
    }

    /// Whether everything that `columns` need is known, one flag per row: a column is not before its first value since
    /// the unit was switched on.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub fn known_rows<'c>(
        &self,
        columns: impl Iterator<Item = &'c str>,
    ) -> Result<Vec<bool>, RecordingError> {
        let mut known = vec![true; self.recording.n_rows()];
        for column in columns {
            let held = self.recording.held(self.recording.channel(column)?);
            known.iter_mut().zip(&held).for_each(|(known, value)| *known &= !value.is_nan());
        }
        Ok(known)
    }

    /// What the recording has of a regressor: the sum of those of its products whose columns can all be followed, if
    /// any can.
    pub fn logged(&self, regressor: &Regressor) -> Option<Regressor> {
        let is_logged = |product: &&Product| product.columns().all(|column| self.lacks(column).is_none());
        let products: Vec<Product> = regressor.products.iter().filter(is_logged).cloned().collect();
        (!products.is_empty()).then_some(Regressor { products })
    }

    /// A regressor over all rows.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub fn regressor(&self, regressor: &Regressor) -> Result<Arc<[f64]>, RecordingError> {
        regressor.over(|spec| self.input(spec))
    }

    /// The means over blocks of a regressor.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub fn block_means(&self, regressor: &Regressor, blocks: &Blocks) -> Result<Vec<f64>, RecordingError> {
        if let [Product { inputs }] = &regressor.products[..]
            && let [spec] = &inputs[..]
            && is_parametrised(&spec.to_string())
        {
            let held = self.held(spec.column.as_deref())?;
            // of what is known throughout nothing has to be filled in afterwards, and no column of it is needed
            if !held.iter().any(|value| value.is_nan()) {
                let mut averaging = blocks.averaging();
                self.transformed(spec, &held, |value| averaging.push(value));
                return Ok(averaging.means);
            }
        }
        Ok(blocks.means(&self.regressor(regressor)?))
    }

    /// A regressor over all rows, its inputs kept inside these limits.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub fn regressor_within(
        &self,
        regressor: &Regressor,
        limits: &BTreeMap<String, [f64; 2]>,
    ) -> Result<Arc<[f64]>, RecordingError> {
        regressor.over(|spec| {
            let values = self.input(spec)?;
            Ok(match limits.get(&spec.to_string()) {
                Some([low, high]) => values.iter().map(|value| value.clamp(*low, *high)).collect(),
                None => values,
            })
        })
    }

    /// An input over all rows. A missing value is held; before the first the input is taken to have stood as it starts
    /// ([`known_rows`](Self::known_rows) says where that is).
    ///
    /// # Errors
    ///
    /// The column is missing, or all its cells are empty.
    pub fn input(&self, spec: &InputSpec) -> Result<Arc<[f64]>, RecordingError> {
        let name = spec.to_string();
        if let Some(known) = self.kept.get(&name) {
            return Ok(known);
        }
        let values: Arc<[f64]> = self.evaluate(spec)?.into();
        Ok(if is_parametrised(&name) { values } else { self.kept.keep(name, values) })
    }

    /// A column as a device has it. No column is the clock, whose transforms need nothing to begin with.
    fn held(&self, column: Option<&str>) -> Result<Arc<[f64]>, RecordingError> {
        let name = column.unwrap_or_default();
        if let Some(known) = self.held.get(name) {
            return Ok(known);
        }
        let held = match column {
            Some(column) => {
                let channel = self.recording.channel(column)?;
                let held = self.recording.held(channel);
                // a low-pass of stairs is nearer to the temperature than they are, and no lag of the sensor
                match self.recording.coarse_step(channel) {
                    Some(step) => self.recording.between_steps(&held, step),
                    None => held,
                }
            }
            None => vec![0.0; self.recording.n_rows()],
        };
        if held.iter().all(|value| value.is_nan()) {
            return Err(RecordingError::NoValues {
                path: self.recording.paths(),
                name: name.to_owned(),
                rows: held.len(),
            });
        }
        Ok(self.held.keep(name.to_owned(), held.into()))
    }

    fn evaluate(&self, spec: &InputSpec) -> Result<Vec<f64>, RecordingError> {
        let held = self.held(spec.column.as_deref())?;
        let mut values = Vec::with_capacity(held.len());
        self.transformed(spec, &held, |value| values.push(value));
        back_filled(&mut values);
        Ok(values)
    }

    /// A held column transformed, row by row; NaN where it is.
    fn transformed(&self, spec: &InputSpec, held: &[f64], mut take: impl FnMut(f64)) {
        let period_s = self.recording.rate.period_s;
        let mut transformer = Transformer::new(&spec.transform, period_s);
        for segment in &self.recording.segments {
            match segment.boundary {
                Boundary::Start => {}
                Boundary::Recording => transformer = Transformer::new(&spec.transform, period_s),
                _ => transformer.skip(u32::try_from(segment.missing_before).unwrap_or(u32::MAX)),
            }
            for x in &held[segment.rows.clone()] {
                let u = transformer.update(*x);
                // what a transform gives before it knows anything is no value
                take(if x.is_nan() { f64::NAN } else { u });
            }
        }
    }
}

/// Whether an input has a parameter: there are too many of those to keep.
fn is_parametrised(name: &str) -> bool {
    name.contains('(')
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};

    const NAN: f64 = f64::NAN;

    fn recording(temp_c: Vec<f64>) -> Recording {
        let columns = vec![("temp_c".to_owned(), temp_c)];
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    fn spec(text: &str) -> InputSpec {
        text.parse().unwrap()
    }

    /// A lag and a play began at 0 °C where the first cell was empty: the log of a slow channel merged into a fast one.
    #[test]
    fn an_empty_first_cell_starts_no_transform_at_zero() {
        let full = recording((0..100).map(|row| 25.0 + 0.1 * f64::from(row)).collect());
        for text in [
            "temp_c",
            "temp_c:lowpass(0.2)",
            "temp_c:backlash(0.5)",
            "temp_c:rate(0.1)",
            "temp_c:variance(0.1)",
        ] {
            for lead in [1, 5] {
                let mut values = full.channel("temp_c").unwrap().values.to_vec();
                values[..lead].fill(NAN);
                let cut = recording(values[lead..].to_vec());
                let late = recording(values);
                let (late, cut) = (Inputs::new(&late), Inputs::new(&cut));
                let (late, cut) = (late.input(&spec(text)).unwrap(), cut.input(&spec(text)).unwrap());
                // as if the log began with the first value, and before it as it starts
                assert_eq!(late[lead..], cut[..], "{text}");
                assert!(late[..lead].iter().all(|value| *value == cut[0]), "{text}");
            }
        }
    }

    #[test]
    fn what_is_not_known_is_said() {
        let mut values = vec![25.0; 100];
        values[..10].fill(NAN);
        let late = recording(values.clone());
        let inputs = Inputs::new(&late);
        assert_eq!(inputs.lacks("temp_c"), None);
        let known = inputs.known_rows(["temp_c"].into_iter()).unwrap();
        assert_eq!(known.iter().position(|known| *known), Some(10));
        assert_eq!(inputs.lacks("supply_v").as_deref(), Some("supply_v"));
        values[10] = NAN;
        let later = recording(values);
        assert_eq!(
            Inputs::new(&later).lacks("temp_c").as_deref(),
            Some("temp_c (empty for the first 0.1 s)")
        );
        let empty = recording(vec![NAN; 100]);
        let inputs = Inputs::new(&empty);
        assert_eq!(inputs.lacks("temp_c").as_deref(), Some("temp_c (every cell is empty)"));
        assert!(inputs.input(&spec("temp_c:lowpass(1)")).unwrap_err().to_string().contains("temp_c"));
    }
}
