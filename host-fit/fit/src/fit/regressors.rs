//! Remainder and inputs of an axis as the device computes them: by running fos-core rather than a copy of its
//! transforms.

use std::ops::Range;

use fos_core::{ModelError, Predictor};

use crate::model::{AXES, INPUTS, SmallPredictor};
use crate::playback::Playback;
use crate::single_axis::SingleAxisModel;
use fos_data::recording::runs;

/// Remainder and inputs over some rows, scaled; NaN if the remainder is unknown.
#[derive(Debug, Clone)]
pub struct Regressors {
    /// Remainder r(n) = y(n) − p(n), one value per row.
    pub remainder: Vec<f64>,
    /// Inputs u_i(n), one column per input.
    pub inputs: Vec<Vec<f64>>,
    /// Gap-free stretches of rows with a known remainder.
    pub stretches: Vec<Range<usize>>,
}

impl Regressors {
    /// Runs `model`, which is without a stochastic part, over the first `n_rows` rows.
    pub fn of(model: &SingleAxisModel, playback: &Playback<'_>, n_rows: usize) -> Result<Self, ModelError> {
        match model.with(SmallPredictor::<f64>::new) {
            Ok(small) => Ok(Self::by(small, model, playback, n_rows)),
            Err(_) => Ok(Self::by(model.predictor()?, model, playback, n_rows)),
        }
    }

    fn by<const TERMS: usize, const HISTORY: usize>(
        mut predictor: Predictor<f64, AXES, INPUTS, TERMS, HISTORY>,
        model: &SingleAxisModel,
        playback: &Playback<'_>,
        n_rows: usize,
    ) -> Self {
        let scale = model.axis().parameters.scale;
        let mut remainder = Vec::with_capacity(n_rows);
        let mut inputs = vec![Vec::with_capacity(n_rows); model.inputs.len()];
        let mut feed = playback.feed();
        for row in 0..n_rows {
            // without a stochastic part the innovation is the remainder; it is unknown until the inputs are known
            let innovation =
                feed.step(&mut predictor, row)[0].innovation.filter(|_| playback.knows_inputs(row));
            remainder.push(innovation.map_or(f64::NAN, |innovation| innovation / scale));
            for (index, column) in inputs.iter_mut().enumerate() {
                column.push(predictor.input(index).unwrap_or(f64::NAN));
            }
        }
        let known = |stretch| runs(stretch, |row| remainder[row].is_finite());
        let stretches = playback.still_stretches(0..n_rows).into_iter().flat_map(known).collect();
        Self { remainder, inputs, stretches }
    }

    /// Returns all columns, the remainder first.
    pub fn columns(&self) -> Vec<&[f64]> {
        std::iter::once(&self.remainder).chain(&self.inputs).map(Vec::as_slice).collect()
    }

    /// Returns the known values of a column.
    pub fn known<'s>(&'s self, column: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        self.stretches.iter().flat_map(|stretch| column[stretch.clone()].iter().copied())
    }

    /// Returns the known remainder, stretch by stretch.
    pub fn known_remainder(&self) -> Vec<&[f64]> {
        self.stretches.iter().map(|stretch| &self.remainder[stretch.clone()]).collect()
    }
}
