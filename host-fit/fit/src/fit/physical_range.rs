//! Range of the sum p of the physical terms: its range in the fitted rows, widened for each part of it.

use fos_core::{Channel, Range};

use crate::model::{FittedTerm, NamedInput};

/// Allowance for the rounding of p in f32, as a share of the sum of its terms' magnitudes: 2⁻²³ each for a product, a
/// sum and the limits themselves, with at most ten terms.
const ROUNDING: f64 = 1.0 / (1 << 18) as f64;

/// Number of points tried in the range of an input that occurs as a power; for others the two ends suffice.
const PLACES: u32 = 8;

/// Largest number of combinations tried; beyond it, no cancellation is assumed.
const MAX_COMBINATIONS: u32 = 1 << 16;

/// Terms of p that belong together: one term of a fit, or one added effect.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// Terms, without delayed factors.
    pub terms: &'a [FittedTerm],
    /// Range to which the part is limited by a guard of its own.
    pub within: Range<f64>,
}

/// Returns the range of p that an axis stores, over `rows` of the columns of `inputs`; scaled.
///
/// It is the range of p. If a part by itself may exceed it by more than the one width that a predictor allows
/// ([`fos_core::AxisParameters::physical_limits`]), the range is widened as far as that part needs: an effect alone is
/// limited only by the ranges of its inputs. A part that is wider than the sum is cancelled by others, and may exceed
/// by as many widths of the sum as of its own: the sum was observed, not its parts.
pub fn physical_range(
    inputs: &[NamedInput],
    columns: &[Vec<f64>],
    rows: impl Iterator<Item = usize> + Clone,
    parts: &[Part<'_>],
) -> Range<f64> {
    if parts.iter().all(|part| part.terms.is_empty()) {
        return Range::new(0.0, 0.0);
    }
    let at = |row: usize| move |input: usize| columns[input][row];
    let sum = seen(rows.clone().map(|row| parts.iter().map(|part| value(part.terms, at(row))).sum()));
    let Some(sum) = sum else { return Range::unlimited() };
    let width = sum.high - sum.low;
    let (mut below, mut above) = (width, width);
    for part in parts {
        let Some(alone) = seen(rows.clone().map(|row| value(part.terms, at(row)))) else { continue };
        let Some(reach) = reach(part.terms, inputs) else { continue };
        let own = alone.high - alone.low;
        let share = if own > width { width / own } else { 1.0 };
        below = below.max(share * (alone.low - reach.low.max(part.within.low)));
        above = above.max(share * (reach.high.min(part.within.high) - alone.high));
    }
    let (more_below, more_above) = widening(below - width, above - width);
    let magnitude: f64 = parts.iter().flat_map(|part| part.terms).map(|term| magnitude(term, inputs)).sum();
    let rounding = ROUNDING * magnitude;
    Range::new(sum.low - more_below - rounding, sum.high + more_above + rounding)
}

/// Returns the widening of a range on either side so that, with one of its widths added, it covers at least these
/// distances.
fn widening(below: f64, above: f64) -> (f64, f64) {
    let (low, high) = ((2.0 * below - above) / 3.0, (2.0 * above - below) / 3.0);
    if low < 0.0 {
        return (0.0, above / 2.0);
    }
    if high < 0.0 { (below / 2.0, 0.0) } else { (low, high) }
}

/// Range of the finite values; `None` if there are none.
fn seen(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let finite = values.filter(|value| value.is_finite()).map(|value| Range::new(value, value));
    finite.reduce(|all, one| Range::new(all.low.min(one.low), all.high.max(one.high)))
}

/// Value of the sum of `terms` with the inputs from `at`.
fn value(terms: &[FittedTerm], at: impl Fn(usize) -> f64) -> f64 {
    let product = |term: &FittedTerm| inputs_of(term).fold(term.coefficient, |product, i| product * at(i));
    terms.iter().map(product).sum()
}

fn inputs_of(term: &FittedTerm) -> impl Iterator<Item = usize> + '_ {
    term.factors.iter().filter_map(|factor| match factor.channel {
        Channel::Input(input) => Some(usize::from(input)),
        Channel::Output => None,
    })
}

/// Range of `terms` with their inputs anywhere within their limits.
fn reach(terms: &[FittedTerm], inputs: &[NamedInput]) -> Option<Range<f64>> {
    let mut used: Vec<usize> = terms.iter().flat_map(inputs_of).collect();
    used.sort_unstable();
    used.dedup();
    let is_power =
        |input: usize| terms.iter().any(|term| inputs_of(term).filter(|other| *other == input).count() > 1);
    let places: Vec<u32> = used.iter().map(|input| if is_power(*input) { PLACES } else { 1 }).collect();
    let combinations = places.iter().try_fold(1_u32, |all, places| all.checked_mul(places + 1));
    let Some(combinations) = combinations.filter(|combinations| *combinations <= MAX_COMBINATIONS) else {
        let magnitude: f64 = terms.iter().map(|term| magnitude(term, inputs)).sum();
        return Some(Range::new(-magnitude, magnitude));
    };
    seen((0..combinations).map(|combination| {
        value(terms, |input| {
            let mut left = combination;
            for (other, places) in used.iter().zip(&places) {
                let place = left % (places + 1);
                left /= places + 1;
                if *other == input {
                    let limits = inputs[input].input.limits();
                    return limits.low + (limits.high - limits.low) * f64::from(place) / f64::from(*places);
                }
            }
            f64::NAN
        })
    }))
}

/// Largest magnitude of a term.
fn magnitude(term: &FittedTerm, inputs: &[NamedInput]) -> f64 {
    inputs_of(term).fold(term.coefficient.abs(), |product, input| {
        let limits = inputs[input].input.limits();
        product * limits.low.abs().max(limits.high.abs())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_core::{Input, Source, Transform, u};

    /// An input as logged, of the range `low` … `high`.
    fn input(low: f64, high: f64) -> NamedInput {
        let range = Range::new(low, high);
        let (source, transform) = (Source::Quantity(0), Transform::Identity);
        let input = Input { source, transform, centre: 0.0, scale: 1.0, source_range: range, range };
        NamedInput { name: "temp_c".to_owned(), input }
    }

    fn term(coefficient: f64, inputs: &[u8]) -> Vec<FittedTerm> {
        let factors = inputs.iter().map(|input| u(*input, 0)).collect();
        vec![FittedTerm { coefficient, standard_error: None, factors }]
    }

    /// Stored range, and the resulting limits of p.
    fn of(inputs: &[NamedInput], columns: &[Vec<f64>], parts: &[&[FittedTerm]]) -> [Range<f64>; 2] {
        let parts: Vec<Part<'_>> =
            parts.iter().map(|terms| Part { terms, within: Range::unlimited() }).collect();
        let stored = physical_range(inputs, columns, 0..columns[0].len(), &parts);
        let width = stored.high - stored.low;
        [stored, Range::new(stored.low - width, stored.high + width)]
    }

    fn assert_near(found: Range<f64>, low: f64, high: f64) {
        assert!(
            (found.low - low).abs() < 1e-3 && (found.high - high).abs() < 1e-3,
            "{found:?}, {low}, {high}"
        );
    }

    fn ramp() -> Vec<f64> {
        (0..=100).map(|n| f64::from(n) / 100.0).collect()
    }

    #[test]
    fn range_of_p_holds_within_fitted_inputs() {
        let (up, down) = (ramp(), ramp().into_iter().map(|value| 1.0 - value).collect());
        let inputs = [input(0.0, 1.0), input(0.0, 1.0)];
        let [stored, _] = of(&inputs, &[up, down], &[&term(3.0, &[0]), &term(1.0, &[1])]);
        assert_near(stored, 1.0, 3.0);
    }

    #[test]
    fn cancelling_terms_may_exceed_by_one_width() {
        let noise = |n: usize| 0.001 * f64::from((n * 7 % 10) as u32);
        let other: Vec<f64> = ramp().iter().enumerate().map(|(n, value)| value + noise(n)).collect();
        let inputs = [input(0.0, 1.0), input(0.0, 1.009)];
        let [stored, limits] = of(&inputs, &[ramp(), other], &[&term(1.3, &[0]), &term(-1.3, &[1])]);
        assert_near(stored, -1.3 * 0.009, 0.0);
        assert_near(limits, -2.6 * 0.009, 1.3 * 0.009);
    }

    #[test]
    fn single_effect_is_limited_by_its_inputs() {
        // one width outside the fitted range, and its square
        for (terms, reach) in [(term(2.0, &[0]), 2.0 * 2.15), (term(2.0, &[0, 0]), 2.0 * 2.15 * 2.15)] {
            let [_, limits] = of(&[input(-1.0, 2.0)], &[ramp()], &[&terms]);
            assert!(limits.high >= reach && limits.high < reach + 1.0, "{limits:?}, {reach}");
            assert!(limits.low <= -1.15 * 2.0 || terms[0].factors.len() == 2, "{limits:?}");
        }
        // fitted from one end to the middle: the decay continues to 0
        let seen: Vec<f64> = ramp().iter().map(|value| 1.0 - 0.1 * value).collect();
        let [_, limits] = of(&[input(0.0, 1.0)], &[seen], &[&term(5.0, &[0])]);
        assert!(limits.low <= -0.25 && limits.high >= 5.25, "{limits:?}");
    }

    #[test]
    fn uncancelled_part_keeps_its_own_range() {
        // a decay that was hardly excited, beside a quantity with ten times the range
        let decay: Vec<f64> = ramp().iter().map(|value| 1.0 - 0.01 * value).collect();
        let other: Vec<f64> = ramp().iter().map(|value| (40.0 * value).sin()).collect();
        let inputs = [input(0.0, 1.0), input(-1.0, 1.0)];
        let [_, limits] = of(&inputs, &[decay, other], &[&term(9.0, &[0]), &term(0.45, &[1])]);
        assert!(limits.low <= -0.45, "{limits:?}");
        // the width that the predictor allows is that of both sides
        assert!(limits.high < 15.0, "{limits:?}");
    }

    #[test]
    fn many_inputs_use_the_worst_case() {
        let inputs: Vec<NamedInput> = (0..32).map(|_| input(0.0, 1.0)).collect();
        let terms: Vec<FittedTerm> = (0..32).flat_map(|input| term(1.0, &[input])).collect();
        let [_, limits] = of(&inputs, &vec![ramp(); 32], &[&terms]);
        assert!(limits.high >= 32.0 * 1.05 && limits.high < 140.0, "{limits:?}");
    }

    #[test]
    fn bounds_of_a_part_are_respected() {
        let within = Range::new(-0.5, 1.5);
        let terms = term(1.0, &[0]);
        let parts = [Part { terms: &terms, within }];
        let stored = physical_range(&[input(-100.0, 100.0)], &[ramp()], 0..101, &parts);
        assert_near(stored, 0.0, 1.0);
    }

    #[test]
    fn constant_range_allows_for_rounding() {
        let terms: Vec<FittedTerm> = [term(0.1, &[0]), term(1e4, &[1]), term(-1e4, &[1])].concat();
        let columns = [vec![1.0; 3], vec![0.3; 3]];
        let [stored, _] = of(&[input(1.0, 1.0), input(0.3, 0.3)], &columns, &[&terms]);
        let sum = 0.1_f32 + 1e4 * 0.3 - 1e4 * 0.3;
        assert!(stored.low < f64::from(sum) - 1e-3 && stored.high > f64::from(sum) + 1e-3, "{stored:?}");
    }

    #[test]
    fn range_is_zero_without_terms_and_unlimited_without_rows() {
        assert_eq!(of(&[], &[vec![]], &[])[0], Range::new(0.0, 0.0));
        assert_eq!(of(&[input(0.0, 1.0)], &[vec![]], &[&term(1.0, &[0])])[0], Range::unlimited());
    }
}
