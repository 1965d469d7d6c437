//! Candidates of an axis, and the check that the rows suffice for their number.

use fos_core::u;

use super::axis_error::AxisError;
use super::options::{FitMethod, FitOptions};
use crate::candidates::{Candidates, CandidatesError, MAX_CANDIDATES};

/// Least number of rows per candidate: below it a coefficient is mostly noise.
const ROWS_PER_CANDIDATE: usize = 5;

/// Returns the pool (eq. 14): products of output lags and of the lags of offered inputs, up to the cross-product
/// degree, and the long memory. `n_inputs` counts the inputs of the physical part, the offered ones and the long
/// memory.
pub(super) fn pool(n_inputs: usize, options: &FitOptions) -> Result<Candidates, CandidatesError> {
    let mut pool = Candidates::builder().output(1..=options.max_lag, options.degree);
    let inputs = options.physical.len()..options.physical.len() + options.inputs.len();
    if !inputs.is_empty() {
        pool = pool.cross_products(options.degree);
    }
    for index in inputs.clone() {
        pool = pool.input(index as u8, 0..=options.input_lags, options.degree);
    }
    for index in inputs.end..n_inputs {
        pool = pool.monomial(&[u(index as u8, 0)]);
    }
    pool.build()
}

/// Checks that the rows and the memory suffice, without making the candidates.
pub(super) fn check(
    column: &str,
    rows: usize,
    n_inputs: usize,
    options: &FitOptions,
) -> Result<(), AxisError> {
    let column = column.to_owned();
    let candidates = size(n_inputs, options);
    let needed = candidates.saturating_add(1).saturating_mul(ROWS_PER_CANDIDATE);
    let fits = || suggestion(rows, n_inputs, options);
    if rows < needed {
        Err(AxisError::TooShort { column, rows, needed, candidates, fits: fits() })
    } else if options.method == FitMethod::Fos && candidates > MAX_CANDIDATES {
        Err(AxisError::TooMany { column, candidates, fits: fits() })
    } else {
        Ok(())
    }
}

/// Number of candidates: C(F + CP, CP) − 1 products of up to CP of F factors, and the long memory; for an
/// autoregression, its lags.
fn size(n_inputs: usize, options: &FitOptions) -> usize {
    let lags = usize::from(options.max_lag);
    if options.method != FitMethod::Fos {
        return lags;
    }
    let factors = lags + options.inputs.len() * (usize::from(options.input_lags) + 1);
    let products = (1..=options.degree as u128)
        .try_fold(1_u128, |chosen, k| Some(chosen.checked_mul(factors as u128 + k)? / k))
        .unwrap_or(u128::MAX);
    let memory = n_inputs - options.physical.len() - options.inputs.len();
    usize::try_from(products - 1).unwrap_or(usize::MAX).saturating_add(memory)
}

/// Returns the largest order for this number of rows, at each degree, as options; empty if there is none.
fn suggestion(rows: usize, n_inputs: usize, options: &FitOptions) -> String {
    let most = (rows / ROWS_PER_CANDIDATE).saturating_sub(1);
    let of = |max_lag, degree| FitOptions { max_lag, degree, ..options.clone() };
    let largest = |most: usize, degree: usize| {
        let fits = |max_lag: &u16| size(n_inputs, &of(*max_lag, degree)) <= most;
        (1..=options.max_lag).take_while(fits).last()
    };
    match options.method {
        FitMethod::Linear(_) => {
            largest(most, 1).map_or_else(String::new, |max_lag| format!("`max_lag` {max_lag}"))
        }
        FitMethod::Fos => {
            let at = |degree| {
                let max_lag = largest(most.min(MAX_CANDIDATES), degree)?;
                Some(format!("`max_lag` {max_lag} `degree` {degree}"))
            };
            (1..=options.degree).rev().filter_map(at).collect::<Vec<_>>().join(" or ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::autoregression;

    fn options(max_lag: u16, degree: usize, inputs: usize) -> FitOptions {
        let inputs = vec!["temp_c".parse().unwrap(); inputs];
        let physical = vec!["supply_v".parse().unwrap()];
        FitOptions { max_lag, degree, inputs, input_lags: 2, physical, ..FitOptions::default() }
    }

    #[test]
    fn size_matches_the_built_pool() {
        for (max_lag, degree, inputs) in
            [(1, 1, 0), (10, 1, 0), (10, 2, 0), (7, 3, 0), (10, 1, 1), (5, 2, 1), (4, 2, 2), (3, 3, 2)]
        {
            for memory in [0, 4] {
                let options = options(max_lag, degree, inputs);
                let n_inputs = 1 + inputs + memory;
                let made = pool(n_inputs, &options).unwrap().len();
                assert_eq!(size(n_inputs, &options), made, "{max_lag} {degree} {inputs} {memory}");
            }
        }
    }

    /// Regression: 3000 lags took half a minute and gigabytes for 4.5 million candidates before they were rejected for
    /// lack of rows.
    #[test]
    fn rejects_too_many_candidates_with_suggestion() {
        let refused = |rows, options: &FitOptions| {
            let n_inputs = 1 + options.inputs.len() + 4;
            check("gx_rads", rows, n_inputs, options).unwrap_err().to_string()
        };
        let text = refused(29_990, &options(3000, 2, 0));
        assert!(text.contains("29990 rows at rest") && text.contains("4504504 candidates"), "{text}");
        assert!(text.ends_with("or `max_lag` 107 `degree` 2 or `max_lag` 3000 `degree` 1"), "{text}");
        // the suggestion suffices, and one more does not
        assert!(check("gx_rads", 29_990, 5, &options(107, 2, 0)).is_ok());
        assert!(check("gx_rads", 29_990, 5, &options(108, 2, 0)).is_err());

        // enough rows, but not enough memory; and a number beyond counting
        let text = refused(100_000_000, &options(200, 2, 0));
        assert!(text.contains("20304 candidates") && text.contains("`max_lag` 108 `degree` 2"), "{text}");
        assert!(refused(1000, &options(u16::MAX, 3, 0)).contains("`max_lag` 8 `degree` 3"));
        // nothing fits
        assert!(refused(20, &options(10, 2, 0)).ends_with("a longer log, a larger `train`"));
        let linear = FitMethod::Linear(autoregression::Method::Burg);
        let text = refused(1000, &FitOptions { method: linear, ..options(300, 2, 0) });
        assert!(text.ends_with("or `max_lag` 199"), "{text}");
    }
}
