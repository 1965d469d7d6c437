//! Recursions over orders, and their inner product.

/// Steps up by one order: the polynomial of order k from that of order k − 1 and γ_k (eq. 9c, 9d), with the signs of
/// the prediction.
pub(crate) fn step_up(coefficients: &mut Vec<f64>, reflection: f64) {
    let lower = coefficients.clone();
    for (a, mirrored) in coefficients.iter_mut().zip(lower.into_iter().rev()) {
        *a += reflection * mirrored;
    }
    coefficients.push(-reflection);
}

/// Σ a(n)·b(n), in independent partial sums so that no addition waits for the previous one.
pub(super) fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder()).fold(0.0, |sum, (x, y)| sum + x * y);
    for (x, y) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.into_iter().fold(rest, |sum, lane| sum + lane)
}
