//! Coefficients of the powers of one input, about its mean in the log. About zero, which may lie far outside the values of
//! the log, their intervals say little about the curve.

use nalgebra::{DMatrix, DVector};

use crate::effects::Regressor;

/// Returns the input whose powers 1, 2, … `regressors` are, if they are at least two.
pub(super) fn input_of(regressors: &[Regressor]) -> Option<&Regressor> {
    let (input, _) = regressors.split_first().filter(|(_, others)| !others.is_empty())?;
    let is_power = |(place, regressor): (usize, &Regressor)| {
        regressor.to_string() == vec![input.to_string(); place + 1].join(" * ")
    };
    regressors.iter().enumerate().all(is_power).then_some(input)
}

/// Name of a power of `input` about `mean`: `temp_c − 12.3`, `(temp_c − 12.3)²`.
pub(super) fn name(input: &Regressor, mean: &str, power: usize) -> String {
    let (sign, mean) = mean.strip_prefix('-').map_or(('−', mean), |mean| ('+', mean));
    match power {
        1 => format!("{input} {sign} {mean}"),
        2 => format!("({input} {sign} {mean})²"),
        3 => format!("({input} {sign} {mean})³"),
        power => format!("({input} {sign} {mean})^{power}"),
    }
}

/// Converts the coefficients of the powers 1, 2, … about zero, with their covariance, to coefficients about `mean` with
/// their standard errors: Σ cₖ·uᵏ = d₀ + Σ dⱼ·(u − mean)ʲ with dⱼ = Σₖ (k over j)·meanᵏ⁻ʲ·cₖ.
pub(super) fn about(mean: f64, coefficients: &[f64], covariance: &DMatrix<f64>) -> Vec<(f64, f64)> {
    let n = coefficients.len();
    let shift =
        DMatrix::from_fn(
            n,
            n,
            |j, k| {
                if k < j { 0.0 } else { binomial(k + 1, j + 1) * mean.powi((k - j) as i32) }
            },
        );
    let moved = &shift * DVector::from_column_slice(coefficients);
    let covariance = &shift * covariance * shift.transpose();
    (0..n).map(|place| (moved[place], covariance[(place, place)].max(0.0).sqrt())).collect()
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |product, i| product * (n - k + i) as f64 / i as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_about_its_mean_has_the_same_values_and_variances() {
        let (mean, c) = (12.5, [0.3, -0.02, 4e-4]);
        let root = DMatrix::from_row_slice(3, 3, &[0.2, 0.0, 0.0, -0.03, 0.01, 0.0, 1e-3, -4e-4, 1e-4]);
        let covariance = &root * root.transpose();
        let d = about(mean, &c, &covariance);
        let difference = |u: f64| {
            let zero: f64 =
                c.iter().enumerate().map(|(k, c)| c * (u.powi(k as i32 + 1) - mean.powi(k as i32 + 1))).sum();
            let moved: f64 = d.iter().enumerate().map(|(j, (d, _))| d * (u - mean).powi(j as i32 + 1)).sum();
            zero - moved
        };
        // rounding of terms up to 4
        assert!([-3.0, 12.5, 40.0].into_iter().all(|u| difference(u).abs() < 1e-13));
        // the slope at the mean: c₁ + 2·c₂·mean + 3·c₃·mean²
        let gradient = DVector::from_column_slice(&[1.0, 2.0 * mean, 3.0 * mean * mean]);
        let variance = (gradient.transpose() * &covariance * &gradient)[(0, 0)];
        assert!((d[0].1 - variance.sqrt()).abs() < 1e-12 * d[0].1);
    }

    #[test]
    fn powers_are_recognised_and_named() {
        let regressors = |texts: &[&str]| -> Vec<Regressor> {
            texts.iter().map(|text| Regressor::parse(text).expect("a regressor")).collect()
        };
        let powers = regressors(&["temp_c", "temp_c * temp_c"]);
        let input = input_of(&powers).expect("powers");
        assert_eq!(name(input, "12.3", 2), "(temp_c − 12.3)²");
        assert_eq!(name(input, "-4.50", 1), "temp_c + 4.50");
        assert!(input_of(&powers[..1]).is_none());
        assert!(input_of(&regressors(&["temp_c", "temp_c * supply_v"])).is_none());
        assert!(input_of(&regressors(&["ax_mps2", "ay_mps2"])).is_none());
    }
}
