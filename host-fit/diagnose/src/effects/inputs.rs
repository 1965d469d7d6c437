//! Inputs of a recording, evaluated by fos-core, and the row from which each is known.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use fos_core::{Transform, Transformer};

use super::terms::{Product, Regressor};
use crate::memo::Memo;
use fos_data::recording::{Boundary, Recording, RecordingError, back_filled};
use fos_fit::fit::InputSpec;
use fos_fit::noise::Blocks;

/// Largest share of the rows, at the start of the log, in which a column may be empty. Beyond it, too much of its past
/// would have to be guessed, and excluding the rows would cost every other effect its evidence.
const MAX_EMPTY_SHARE: f64 = 0.1;

/// Evaluates inputs over a recording, one value per row, as fos-core does on the device.
#[derive(Debug)]
pub struct Inputs<'a> {
    recording: Cow<'a, Recording>,
    /// Cached inputs without a parameter, which are needed repeatedly.
    cached: Memo<String, Arc<Vec<f64>>>,
    /// Cached columns as a device sees them, NaN before their first value: the inputs of the transforms.
    held: Memo<String, Arc<Vec<f64>>>,
}

impl<'a> Inputs<'a> {
    pub fn new(recording: &'a Recording) -> Self {
        Self::of(Cow::Borrowed(recording))
    }

    /// Creates the inputs of a log that is borrowed or owned.
    pub fn of(recording: Cow<'a, Recording>) -> Self {
        Self { recording, cached: Memo::default(), held: Memo::default() }
    }

    /// Returns the log that the inputs are computed from.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Describes why a column cannot be used: it is missing, empty, or begins too late. `None` if it can.
    pub fn lacks(&self, column: &str) -> Option<String> {
        let Ok(channel) = self.recording.channel(column) else { return Some(column.to_owned()) };
        let first = channel.values.iter().position(|value| !value.is_nan());
        match first {
            None => Some(format!("{column} (every cell is empty)")),
            Some(row) if row as f64 > MAX_EMPTY_SHARE * self.recording.n_rows() as f64 => {
                let time_s = self.recording.time_s[row] - self.recording.time_s[0];
                Some(format!("{column} (empty for the first {time_s:.1} s)"))
            }
            Some(_) => None,
        }
    }

    /// Returns one flag per row: true if all `columns` are known there. A column is unknown before its first value
    /// after power-on.
    pub fn known_rows<'c>(
        &self,
        columns: impl Iterator<Item = &'c str>,
    ) -> Result<Vec<bool>, RecordingError> {
        let mut known = vec![true; self.recording.n_rows()];
        for column in columns {
            let held = self.recording.held(self.recording.channel(column)?);
            known.iter_mut().zip(&*held).for_each(|(known, value)| *known &= !value.is_nan());
        }
        Ok(known)
    }

    /// Reduces a regressor to the products whose columns are all usable in this recording; `None` if there are none.
    pub fn logged(&self, regressor: &Regressor) -> Option<Regressor> {
        let is_logged = |product: &&Product| product.columns().all(|column| self.lacks(column).is_none());
        let products: Vec<Product> = regressor.products.iter().filter(is_logged).cloned().collect();
        (!products.is_empty()).then_some(Regressor { products })
    }

    /// Evaluates a regressor over all rows.
    pub fn regressor(&self, regressor: &Regressor) -> Result<Arc<Vec<f64>>, RecordingError> {
        regressor.over(|spec| self.input(spec))
    }

    /// Evaluates the block means of a regressor.
    pub fn block_means(&self, regressor: &Regressor, blocks: &Blocks) -> Result<Vec<f64>, RecordingError> {
        let mut means = vec![0.0; blocks.len()];
        for product in &regressor.products {
            let of_product = self.block_means_of(product, blocks)?;
            means.iter_mut().zip(of_product).for_each(|(sum, mean)| *sum += mean);
        }
        Ok(means)
    }

    fn block_means_of(&self, product: &Product, blocks: &Blocks) -> Result<Vec<f64>, RecordingError> {
        if let [spec] = &product.inputs[..]
            && let Transform::Decay { tau_s } = spec.transform
        {
            return Ok(self.block_means_of_decay(spec, tau_s, blocks));
        }
        if let [spec] = &product.inputs[..]
            && is_parametrised(&spec.to_string())
        {
            let held = self.held(spec.column.as_deref())?;
            // a column without gaps needs no back-filling, so its transform need not be stored
            if !held.iter().any(|value| value.is_nan()) {
                let mut averaging = blocks.averaging();
                self.transformed(spec, &held, |values| averaging.extend(values));
                return Ok(averaging.means);
            }
        }
        Ok(blocks.means(&product.over(|spec| self.input(spec))?))
    }

    /// Block means of e^(−t/τ): a geometric series over each run of used rows, Σ v·qᵏ = v·(1 − qⁿ)/(1 − q), q = e^(−T/τ).
    /// A search for τ needs them hundreds of times.
    fn block_means_of_decay(&self, spec: &InputSpec, tau_s: f64, blocks: &Blocks) -> Vec<f64> {
        let decline = |rows: usize| (-(rows as f64) * self.recording.rate.period_s / tau_s).exp_m1();
        let mut sums = vec![0.0; blocks.len()];
        self.over_segments(spec, |decay, rows| {
            let mut row = rows.start;
            for (block, run) in blocks.used_runs(rows.clone()) {
                decay.skip((run.start - row) as u32);
                row = run.end;
                let first = decay.update(0.0);
                decay.skip(run.len() as u32 - 1);
                sums[block] += first * decline(run.len()) / decline(1);
            }
            decay.skip((rows.end - row) as u32);
        });
        sums.iter().zip(&blocks.blocks).map(|(sum, block)| sum / block.count as f64).collect()
    }

    /// Evaluates a regressor over all rows with its inputs clamped to `limits`.
    pub fn regressor_within(
        &self,
        regressor: &Regressor,
        limits: &BTreeMap<String, [f64; 2]>,
    ) -> Result<Arc<Vec<f64>>, RecordingError> {
        regressor.over(|spec| {
            let values = self.input(spec)?;
            Ok(match limits.get(&spec.to_string()) {
                Some([low, high]) => Arc::new(values.iter().map(|value| value.clamp(*low, *high)).collect()),
                None => values,
            })
        })
    }

    /// Evaluates an input over all rows. A missing value is held. Before the first value the input is constant at its
    /// first value ([`known_rows`](Self::known_rows) marks these rows). A column of empty cells is an error.
    pub fn input(&self, spec: &InputSpec) -> Result<Arc<Vec<f64>>, RecordingError> {
        let name = spec.to_string();
        if let Some(known) = self.cached.get(&name) {
            return Ok(known);
        }
        let values = self.evaluate(spec)?;
        Ok(if is_parametrised(&name) { values } else { self.cached.insert(name, values) })
    }

    /// Returns a column as a device sees it. `None` is the clock, whose transforms need no column.
    fn held(&self, column: Option<&str>) -> Result<Arc<Vec<f64>>, RecordingError> {
        let name = column.unwrap_or_default();
        if let Some(known) = self.held.get(name) {
            return Ok(known);
        }
        let held = match column {
            Some(column) => {
                let channel = self.recording.channel(column)?;
                // interpolation between the steps is closer to the temperature, and adds no lag of the sensor
                match self.recording.coarse_step(channel) {
                    Some(step) => Arc::new(self.recording.between_steps(&self.recording.held(channel), step)),
                    None => self.recording.held(channel),
                }
            }
            None => Arc::new(vec![0.0; self.recording.n_rows()]),
        };
        if held.iter().all(|value| value.is_nan()) {
            return Err(RecordingError::NoValues {
                path: self.recording.paths(),
                name: name.to_owned(),
                rows: held.len(),
            });
        }
        Ok(self.held.insert(name.to_owned(), held))
    }

    fn evaluate(&self, spec: &InputSpec) -> Result<Arc<Vec<f64>>, RecordingError> {
        let held = self.held(spec.column.as_deref())?;
        let is_column = spec.column.is_some() && spec.transform == Transform::Identity;
        if is_column && !held.iter().any(|value| value.is_nan()) {
            return Ok(held);
        }
        let mut values = Vec::with_capacity(held.len());
        self.transformed(spec, &held, |transformed| values.extend_from_slice(transformed));
        back_filled(&mut values);
        Ok(Arc::new(values))
    }

    /// Transforms a held column; NaN stays NaN. `take` gets the rows in order, some at a time.
    fn transformed(&self, spec: &InputSpec, held: &[f64], mut take: impl FnMut(&[f64])) {
        let mut transformed = [0.0; AT_ONCE];
        self.over_segments(spec, |transformer, rows| {
            for rows in held[rows].chunks(AT_ONCE) {
                let transformed = &mut transformed[..rows.len()];
                // a copy, whose state the compiler can keep in registers
                let mut running = *transformer;
                for (u, x) in transformed.iter_mut().zip(rows) {
                    let value = running.update(*x);
                    // the output of a transform before its first input is not a value
                    *u = if x.is_nan() { f64::NAN } else { value };
                }
                *transformer = running;
                take(transformed);
            }
        });
    }

    /// Calls `advance` for the rows of each segment in order, with the transformer at their start; it moves the
    /// transformer to their end.
    fn over_segments(&self, spec: &InputSpec, mut advance: impl FnMut(&mut Transformer<f64>, Range<usize>)) {
        let period_s = self.recording.rate.period_s;
        let mut transformer = Transformer::new(&spec.transform, period_s);
        for segment in &self.recording.segments {
            match segment.boundary {
                Boundary::Start => {}
                Boundary::Recording => transformer = Transformer::new(&spec.transform, period_s),
                _ => transformer.skip(u32::try_from(segment.missing_before).unwrap_or(u32::MAX)),
            }
            advance(&mut transformer, segment.rows.clone());
        }
    }
}

/// Number of rows transformed at a time: their values stay in the nearest memory of the processor.
const AT_ONCE: usize = 1024;

/// Returns true if an input has a parameter: there are too many of those to cache.
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

    /// Lag and backlash started at 0 °C if the first cell was empty, as in a log of a slow channel merged into a fast
    /// one.
    #[test]
    fn empty_first_cells_do_not_start_transforms_at_zero() {
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
                // the same as if the log began with the first value, and constant before it
                assert_eq!(late[lead..], cut[..], "{text}");
                assert!(late[..lead].iter().all(|value| *value == cut[0]), "{text}");
            }
        }
    }

    /// The closed form agrees with the values row by row, over gaps, unused rows and a second recording.
    #[test]
    fn block_means_of_a_decay_are_those_of_its_rows() {
        let part = |first_s: f64| {
            let time_s: Vec<f64> = (0..3000)
                .map(|row| first_s + 0.01 * f64::from(row) + if row > 1234 { 7.3 } else { 0.0 })
                .collect();
            let columns = vec![("temp_c".to_owned(), vec![25.0; 3000]), ("t_s".to_owned(), time_s)];
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
        };
        let log = Recording::join(vec![part(0.0), part(100.0)]).unwrap();
        assert!(log.segments.len() >= 4, "{:?}", log.segments);
        let known =
            (0..log.n_rows()).map(|row| row % 500 > 20 && row % 7 != 3 || (2000..2600).contains(&row));
        let blocks = Blocks::new(&log, 1.5, known.collect());
        let inputs = Inputs::new(&log);
        for tau_s in [0.02, 1.0, 40.0, 5e4] {
            let spec = spec(&format!("clock:decay({tau_s})"));
            let rows = blocks.means(&inputs.input(&spec).unwrap());
            let regressor = Regressor { products: vec![Product { inputs: vec![spec] }] };
            let closed = inputs.block_means(&regressor, &blocks).unwrap();
            for (closed, rows) in closed.iter().zip(&rows) {
                // rounding of a sum of 150 values, and of the recursion
                assert!(
                    (closed - rows).abs() <= 1e-12 * rows.abs() + 1e-15,
                    "τ {tau_s}: {closed} for {rows}"
                );
            }
        }
    }

    #[test]
    fn reports_missing_late_and_empty_columns() {
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
