//! Vectors of three axes.

/// Euclidean length.
pub(crate) fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Euclidean distance.
pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm([0, 1, 2].map(|i| a[i] - b[i]))
}

/// The direction of a vector; NaN of the zero vector.
pub(crate) fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = norm(vector);
    vector.map(|x| x / length)
}

/// The angle between two unit vectors, °.
pub(crate) fn angle_deg(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    // exact for small angles, where the arc cosine is not
    2.0 * (0.5 * distance(*a, *b)).clamp(0.0, 1.0).asin().to_degrees()
}
