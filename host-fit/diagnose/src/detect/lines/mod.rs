//! Lines: narrow bands of the spectrum of a whole log that hold more than the noise around them.
//!
//! The noise of a log is smooth in frequency; divided by its local median, ordinates of the periodogram are unit
//! exponentials. A band of w ordinates with mean m has a log-likelihood ratio of w·(m − 1 − ln m) against noise. Bands
//! of doubling width find coherent lines (w = 1) and wandering ones with the same test.
//!
//! | file | subject |
//! |---|---|
//! | `series` | an error without its slow part on the grid of ticks; its transform at one frequency |
//! | `line` | a detected line; its duty cycle |
//! | `periodogram` | power divided by the local noise; the best band |
//! | `sine` | the sine of a coherent line |
//! | `find` | sequential search for lines; comparison with other axes |

mod find;
mod line;
mod periodogram;
mod series;
mod sine;

#[cfg(test)]
mod tests;

pub(super) use find::{means_without, of};
pub(super) use line::{Line, STEADY};
