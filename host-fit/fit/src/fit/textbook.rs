//! Fast orthogonal search as published: the slow twin of [`super::fos`].
//!
//! The candidates p_m(n) are evaluated for every row, and every average of the recursion (equations 1 to 7 there) is a
//! sum over the rows, computed again for every candidate at every step. It follows the published method literally:
//! tests compare the fast search with it, and the benchmark measures the speed-up.

use fos_core::Factor;

use super::fos::COLLINEAR;
use super::stop::StopRule;
use crate::candidates::Candidates;
use crate::moments::{Rows, column};

/// Returns terms in the order chosen, with Q of each: (index in the pool, reduction of the mean square error).
///
/// Stops by the same rules as [`super::fos::search`].
///
/// # Panics
/// If the signals do not fit the pool.
pub fn search(signals: &[&[f64]], rows: &Rows, pool: &Candidates, rule: &StopRule) -> Vec<(usize, f64)> {
    rows.check(signals, pool.factors());
    let value = |monomial: &[Factor], n: usize| -> f64 {
        monomial.iter().map(|f| signals[column(f)][n - usize::from(f.lag)]).product()
    };
    let function = |monomial: &[Factor]| -> Vec<f64> {
        rows.ranges().iter().cloned().flatten().map(|n| value(monomial, n)).collect()
    };
    let average = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
    let target = function(&[fos_core::y(0)]);
    let constant = function(&[]);
    let candidates: Vec<Vec<f64>> = pool.monomials().iter().map(|monomial| function(monomial)).collect();
    let noise = rule.stop.threshold(rows.count(), pool.len());

    let mut chosen = Vec::new();
    let mut p = vec![&constant];
    let mut d = vec![vec![1.0]];
    let mut c = vec![average(&target, &constant)];
    let mut mse = average(&target, &target) - c[0] * c[0];
    // terminates: each iteration adds a term
    while chosen.len() < rule.max_terms {
        let m = p.len();
        let mut best: Option<(usize, f64, Vec<f64>, f64)> = None;
        for (candidate, function) in candidates.iter().enumerate() {
            if chosen.iter().any(|&(taken, _)| taken == candidate) {
                continue;
            }
            // D(m,0) … D(m,m) and C(m)
            let mut row: Vec<f64> = Vec::new();
            for r in 0..m {
                let projected: f64 = (0..r).map(|i| d[r][i] / d[i][i] * row[i]).sum();
                row.push(average(function, p[r]) - projected);
            }
            let mean_square = average(function, function);
            let dmm = mean_square - (0..m).map(|i| row[i] / d[i][i] * row[i]).sum::<f64>();
            let cm = average(&target, function) - (0..m).map(|r| row[r] / d[r][r] * c[r]).sum::<f64>();
            let q = cm * cm / dmm;
            if dmm > COLLINEAR * mean_square && best.as_ref().is_none_or(|(_, most, _, _)| q > *most) {
                row.push(dmm);
                best = Some((candidate, q, row, cm));
            }
        }
        match best {
            Some((candidate, q, row, cm)) if q >= noise * mse => {
                chosen.push((candidate, q));
                p.push(&candidates[candidate]);
                d.push(row);
                c.push(cm);
                mse -= q;
            }
            _ => break,
        }
    }
    chosen
}
