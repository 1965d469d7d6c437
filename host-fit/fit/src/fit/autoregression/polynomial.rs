//! Recursions over orders, and their inner product.

use nalgebra::ComplexField;

/// Steps up by one order: the polynomial of order k from that of order k − 1 and γ_k (eq. 9c, 9d), with the signs of
/// the prediction.
pub(crate) fn step_up<T: ComplexField>(coefficients: &mut Vec<T>, reflection: T) {
    let lower = coefficients.clone();
    for (a, mirrored) in coefficients.iter_mut().zip(lower.into_iter().rev()) {
        *a += reflection.clone() * mirrored.conjugate();
    }
    coefficients.push(-reflection);
}

/// Σ a(n)·b(n)*, in independent partial sums so that no addition waits for the previous one.
pub(super) fn inner_product<T: ComplexField>(a: &[T], b: &[T]) -> T {
    const LANES: usize = 8;
    let mut sums: [T; LANES] = core::array::from_fn(|_| T::zero());
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x.clone() * y.clone().conjugate());
    let rest = rest.fold(T::zero(), |sum, product| sum + product);
    for (x, y) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += x[lane].clone() * y[lane].clone().conjugate();
        }
    }
    sums.into_iter().fold(rest, |sum, lane| sum + lane)
}
