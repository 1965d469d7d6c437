//! Samples that exercise a model, and the bits that a hub computes from them: one vector for every form of source.

mod host_hub;
mod room;
mod samples;
mod scales;
mod schedule;
mod wander;

use fos_embedded::hub::HubError;
use fos_embedded::raw::Scales;
use fos_embedded::test_log::HubLogRecord;
use fos_embedded::test_vector::{Expected, TestSample, TestVector};

use fos_fit::model::{FittedTerm, UnitModel};
pub(super) use host_hub::loaded;
use samples::{Generator, HOW};

pub use room::Room;

/// A [`TestVector`] that owns its data.
#[derive(Debug, Clone)]
pub struct OwnedTestVector {
    scales: Scales,
    channels: Vec<u8>,
    given: Vec<u8>,
    samples: Vec<TestSample>,
    given_bits: Vec<u32>,
    expected: Vec<Expected>,
}

/// A term with a coefficient whose change the test vector may not detect.
#[derive(Debug, Clone, PartialEq)]
pub struct Unnoticed {
    /// Index of the axis in the model.
    pub axis: usize,
    /// Index of the term, physical part first.
    pub term: usize,
    /// Relative change of the coefficient that is detected; half of it is not.
    pub noticed_from: f64,
}

/// Makes the test vector of `model`, with the results of fos-embedded's hub in f32.
///
/// # Errors
///
/// The hub refuses the model because an axis or quantity is not measured by a six-axis sensor.
pub fn test_vector(model: &UnitModel) -> Result<OwnedTestVector, HubError> {
    let mut generator = Generator::new(model)?;
    let (scales, channels, given) = (generator.scales(), generator.channels(), generator.given());
    let mut hub = loaded(model, scales)?;
    let mut vector =
        OwnedTestVector { scales, channels, given, samples: vec![], given_bits: vec![], expected: vec![] };
    for kind in generator.schedule() {
        let (sample, given) = generator.sample(kind);
        let record =
            HubLogRecord { raw: sample.raw(), motion: Some(sample.motion), clock_us: 0, given: &given };
        let output = record.step(&mut hub);
        vector.expected.extend(vector.channels.iter().filter_map(|channel| Expected::of(output, *channel)));
        vector.given_bits.extend(given.iter().map(|value| value.to_bits()));
        vector.samples.push(sample);
    }
    Ok(vector)
}

impl OwnedTestVector {
    /// Borrowed form for fos-embedded.
    pub fn vector(&self) -> TestVector<'_> {
        TestVector {
            scales: self.scales,
            channels: &self.channels,
            given: &self.given,
            samples: &self.samples,
            given_bits: &self.given_bits,
            expected: &self.expected,
        }
    }

    /// `model` gives the same bits.
    pub fn is_met_by(&self, model: &UnitModel) -> bool {
        loaded(model, self.scales).is_ok_and(|mut hub| self.vector().run(&mut hub).is_ok())
    }

    /// Terms of `model`, which made the vector, for which a change of the last bit of the coefficient is not detected, because f32
    /// rounds it away.
    pub fn unnoticed(&self, model: &UnitModel) -> Vec<Unnoticed> {
        let mut unnoticed = Vec::new();
        for (axis, fitted) in model.axes.iter().enumerate() {
            for (term, fitted) in fitted.physical.iter().chain(&fitted.stochastic).enumerate() {
                let exact = fitted.coefficient as f32;
                let noticed_from = |power: &u32| {
                    let mut changed = model.clone();
                    let now = f32::from_bits(exact.to_bits() + (1 << power));
                    if let Some(changed) = term_mut(&mut changed, axis, term) {
                        changed.coefficient = f64::from(now);
                    }
                    !self.is_met_by(&changed)
                };
                // 1, 2, 4, … units in the last place; 2^23 of them double a coefficient.
                match (0..=23).find(noticed_from) {
                    Some(0) => {}
                    Some(power) => unnoticed.push(Unnoticed { axis, term, noticed_from: ulps(exact, power) }),
                    None => unnoticed.push(Unnoticed { axis, term, noticed_from: f64::INFINITY }),
                }
            }
        }
        unnoticed
    }
}

/// Relative size of 2^power units in the last place of `exact`.
fn ulps(exact: f32, power: u32) -> f64 {
    (f64::from(f32::from_bits(exact.to_bits() + (1 << power))) / f64::from(exact) - 1.0).abs()
}

/// Content, origin and limits of the vector, for the comment in the source.
pub(super) fn comment(vector: &OwnedTestVector, model: &UnitModel) -> String {
    let mut comment = format!(
        "Test vector: {} samples, and the bits that a hub made of them on the host, in f32.\n{HOW}\n",
        vector.samples.len()
    );
    let unnoticed = vector.unnoticed(model);
    let noticed = model.n_terms() - unnoticed.len();
    comment.push_str(&format!(
        "A change of the last bit of a coefficient is noticed in {noticed} of {} terms",
        model.n_terms()
    ));
    for Unnoticed { axis, term, noticed_from } in unnoticed {
        let axis = &model.axes[axis].column;
        comment.push_str(&format!(
            ";\nin {axis}, term {} (physical part first) from {noticed_from:.0e} of it",
            term + 1
        ));
    }
    comment.push_str(".\n");
    comment
}

fn term_mut(model: &mut UnitModel, axis: usize, term: usize) -> Option<&mut FittedTerm> {
    let axis = model.axes.get_mut(axis)?;
    axis.physical.iter_mut().chain(&mut axis.stochastic).nth(term)
}
