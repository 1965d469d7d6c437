//! Lines: narrow bands of the spectrum of a whole log that hold more than the noise around them.
//!
//! The log's noise is smooth in frequency; over its local median, ordinates of the periodogram are unit exponentials. A
//! band of w ordinates with mean m has log-likelihood ratio w·(m − 1 − ln m) against noise; bands of doubling width
//! find a line that keeps its phase (w = 1) and one that wanders with the same test.
//!
//! | file | subject |
//! |---|---|
//! | `series` | an error without its slow part on the grid of ticks; its transform at one frequency |
//! | `line` | a line that was found; how much of the time it is there |
//! | `periodogram` | power over the noise around it; the best band |
//! | `sine` | the sine of a line that keeps its phase |
//! | `find` | lines one after the other; whether another axis has them too |

mod find;
mod line;
mod periodogram;
mod series;
mod sine;

#[cfg(test)]
mod tests;

pub(super) use find::{of, shared};
pub(super) use line::{Line, STEADY};
