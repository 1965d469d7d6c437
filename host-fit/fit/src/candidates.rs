//! Pool of monomials that a search chooses from (paper eq. 14).
//!
//! A monomial is a product of delayed samples, p(n) = r(n−l₁)…r(n−l_i)·u(n−k₁)…u(n−k_j). The constant
//! p₀(n) = 1 belongs to every model and is therefore not a candidate.

use core::fmt;
use std::ops::RangeInclusive;

use fos_core::{Channel, Factor};
use thiserror::Error;

/// The largest number of factors in a candidate: cross-product degree 3.
///
/// A product of two candidates then has at most six factors, which is what the moments are laid out for.
pub const MAX_DEGREE: usize = 3;

/// The largest lag, in samples: 82 s at 200 Hz.
pub const MAX_LAG: u16 = (1 << 14) - 1;

/// The largest index of an input.
pub const MAX_INPUT: u8 = 125;

/// The largest pool. The averages of the products of 6000 candidates need a gigabyte while they are formed; twice as
/// many need four.
pub const MAX_CANDIDATES: usize = 6000;

/// A product of delayed samples, its factors sorted by channel, then lag. Empty: the constant 1.
pub type Monomial = Vec<Factor>;

/// The candidates of a search, in a fixed order, each once.
///
/// Order: by number of factors, then by the factors compared one after the other, the output before input 0
/// before input 1, small lags before large ones. For lags 1 to 2 and degree 2 that is
/// `y(n-1)`, `y(n-2)`, `y(n-1)²`, `y(n-1)·y(n-2)`, `y(n-2)²`.
///
/// ```
/// use fos_fit::candidates::Candidates;
///
/// let pool = Candidates::builder().output(1..=10, 2).build()?;
/// assert_eq!(pool.len(), 10 + 55);
/// assert_eq!(pool.max_lag(), 10);
/// # Ok::<(), fos_fit::candidates::CandidatesError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidates {
    monomials: Vec<Monomial>,
}

#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CandidatesError {
    #[error("the output at lag 0 is what the model predicts: output lags start at 1")]
    OutputAtLagZero,
    #[error("degree {0} is outside 1 to {MAX_DEGREE}")]
    Degree(usize),
    #[error("the constant is in every model and cannot be a candidate")]
    Constant,
    #[error("the lag range {0} to {1} is empty")]
    EmptyLags(u16, u16),
    #[error("{0} is out of reach: lags go to {MAX_LAG}, inputs to u{MAX_INPUT}")]
    OutOfReach(String),
    #[error(
        "more than {MAX_CANDIDATES} candidates: the averages of their products would not fit into memory"
    )]
    TooMany,
    #[error("the pool is empty: give output lags, input lags or a monomial")]
    Empty,
}

impl Candidates {
    /// Starts an empty pool.
    pub fn builder() -> Builder {
        Builder::default()
    }

    /// The monomials, in the order of the pool.
    pub fn monomials(&self) -> &[Monomial] {
        &self.monomials
    }

    /// Number of candidates, M.
    pub fn len(&self) -> usize {
        self.monomials.len()
    }

    /// Always false: a pool without candidates cannot be built.
    pub fn is_empty(&self) -> bool {
        self.monomials.is_empty()
    }

    /// N₀: the largest lag any candidate needs, in samples.
    pub fn max_lag(&self) -> usize {
        self.factors().map(|f| usize::from(f.lag)).max().unwrap_or(0)
    }

    /// Number of inputs that the signals must have: one more than the largest input index used.
    pub fn inputs(&self) -> usize {
        let index = |f: &Factor| match f.channel {
            Channel::Output => 0,
            Channel::Input(i) => usize::from(i) + 1,
        };
        self.factors().map(index).max().unwrap_or(0)
    }

    /// Every factor of every candidate.
    pub fn factors(&self) -> impl Iterator<Item = &Factor> {
        self.monomials.iter().flatten()
    }

    /// Returns the index of a monomial in the pool.
    pub fn position(&self, monomial: &[Factor]) -> Option<usize> {
        self.monomials.binary_search_by(|m| order(m, monomial)).ok()
    }
}

/// Returns true if a pool can contain this monomial.
pub(crate) fn is_candidate(monomial: &[Factor]) -> bool {
    let output_now = |f: &Factor| f.channel == Channel::Output && f.lag == 0;
    (1..=MAX_DEGREE).contains(&monomial.len()) && !monomial.iter().any(|f| output_now(f) || out_of_reach(f))
}

/// Returns true if a lag or an input is too large for the moments.
fn out_of_reach(factor: &Factor) -> bool {
    factor.lag > MAX_LAG || factor.channel > Channel::Input(MAX_INPUT)
}

/// Order of the pool: by number of factors, then factor by factor.
fn order(a: &[Factor], b: &[Factor]) -> core::cmp::Ordering {
    a.len().cmp(&b.len()).then_with(|| a.cmp(b))
}

/// Delays of one channel and the highest degree of their products.
#[derive(Debug, Clone)]
struct Group {
    channel: Channel,
    lags: RangeInclusive<u16>,
    degree: usize,
}

/// Collects the contents of a pool; see [`Candidates::builder`].
#[derive(Debug, Clone, Default)]
pub struct Builder {
    groups: Vec<Group>,
    cross_degree: Option<usize>,
    explicit: Vec<Monomial>,
}

impl Builder {
    /// Output lags (from 1) and the highest degree of their products: L and CP of the paper.
    pub fn output(mut self, lags: RangeInclusive<u16>, degree: usize) -> Self {
        self.groups.push(Group { channel: Channel::Output, lags, degree });
        self
    }

    /// Lags of input `index` (from 0) and the highest degree of products of this input with itself.
    pub fn input(mut self, index: u8, lags: RangeInclusive<u16>, degree: usize) -> Self {
        self.groups.push(Group { channel: Channel::Input(index), lags, degree });
        self
    }

    /// Also offers products of different channels with up to `degree` factors in all.
    ///
    /// Each channel still enters to at most its own degree: with the output to degree 2, an input to degree 1
    /// and `cross_products(3)`, y·y·u is a candidate and y·u·u is not.
    pub fn cross_products(mut self, degree: usize) -> Self {
        self.cross_degree = Some(degree);
        self
    }

    /// Offers one more monomial, its factors in any order.
    pub fn monomial(mut self, factors: &[Factor]) -> Self {
        let mut monomial = factors.to_vec();
        monomial.sort_unstable();
        self.explicit.push(monomial);
        self
    }

    /// Builds the pool.
    pub fn build(self) -> Result<Candidates, CandidatesError> {
        let degrees = self.groups.iter().map(|g| g.degree).chain(self.cross_degree);
        let explicit_degrees = self.explicit.iter().map(Vec::len);
        if self.explicit.iter().any(Vec::is_empty) {
            return Err(CandidatesError::Constant);
        }
        if let Some(degree) = degrees.chain(explicit_degrees).find(|d| !(1..=MAX_DEGREE).contains(d)) {
            return Err(CandidatesError::Degree(degree));
        }
        if let Some(group) = self.groups.iter().find(|g| g.lags.is_empty()) {
            return Err(CandidatesError::EmptyLags(*group.lags.start(), *group.lags.end()));
        }

        let mut factors: Vec<Factor> = (self.groups.iter())
            .flat_map(|g| g.lags.clone().map(|lag| Factor { channel: g.channel, lag }))
            .collect();
        factors.sort_unstable();
        factors.dedup();
        let explicit = self.explicit.iter().flatten();
        if let Some(factor) = factors.iter().chain(explicit).find(|f| out_of_reach(f)) {
            return Err(CandidatesError::OutOfReach(monomial_text(&[*factor])));
        }
        let mut monomials = self.explicit.clone();
        self.extend(&mut Vec::new(), &factors, &mut monomials);
        if monomials.len() > MAX_CANDIDATES {
            return Err(CandidatesError::TooMany);
        }
        monomials.sort_unstable_by(|a, b| order(a, b));
        monomials.dedup();

        let at_zero = |f: &Factor| f.channel == Channel::Output && f.lag == 0;
        if monomials.iter().flatten().any(at_zero) {
            return Err(CandidatesError::OutputAtLagZero);
        }
        if monomials.is_empty() { Err(CandidatesError::Empty) } else { Ok(Candidates { monomials }) }
    }

    /// Appends every allowed product of `stem` with factors from `factors` on, each once, since its factors are in
    /// ascending order. Stops as soon as there are too many: the products of three of the lags to [`MAX_LAG`] are
    /// 7·10¹¹.
    fn extend(&self, stem: &mut Monomial, factors: &[Factor], found: &mut Vec<Monomial>) {
        for (i, &factor) in factors.iter().enumerate() {
            if found.len() > MAX_CANDIDATES {
                return;
            }
            stem.push(factor);
            if self.allows(stem) {
                found.push(stem.clone());
                self.extend(stem, &factors[i..], found);
            }
            stem.pop();
        }
    }

    /// Returns true if a product is within the requested degrees. Otherwise no extension of it is.
    fn allows(&self, monomial: &[Factor]) -> bool {
        let within_channel = |factor: &Factor| {
            let power = monomial.iter().filter(|f| f.channel == factor.channel).count();
            let reaches = |g: &&Group| g.channel == factor.channel && g.lags.contains(&factor.lag);
            self.groups.iter().filter(reaches).any(|g| power <= g.degree)
        };
        let mixed = monomial.iter().any(|f| f.channel != monomial[0].channel);
        let cross = !mixed || self.cross_degree.is_some_and(|degree| monomial.len() <= degree);
        cross && monomial.iter().all(within_channel)
    }
}

/// Formats a monomial as `y(n-1)·u0(n)`, `y(n-2)²`, `1`.
pub fn monomial_text(monomial: &[Factor]) -> String {
    monomial_text_named(monomial, "y", &[])
}

/// Formats a monomial with names of the channels; an input without a name is `u` and its index.
pub fn monomial_text_named(monomial: &[Factor], output: &str, inputs: &[&str]) -> String {
    MonomialText { monomial, output, inputs }.to_string()
}

struct MonomialText<'a> {
    monomial: &'a [Factor],
    output: &'a str,
    inputs: &'a [&'a str],
}

impl fmt::Display for MonomialText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.monomial.is_empty() {
            return f.write_str("1");
        }
        for (i, power) in self.monomial.chunk_by(|a, b| a == b).enumerate() {
            if i > 0 {
                f.write_str("·")?;
            }
            match power[0].channel {
                Channel::Output => f.write_str(self.output)?,
                Channel::Input(input) => match self.inputs.get(usize::from(input)) {
                    Some(name) => f.write_str(name)?,
                    None => write!(f, "u{input}")?,
                },
            }
            match power[0].lag {
                0 => f.write_str("(n)")?,
                lag => write!(f, "(n-{lag})")?,
            }
            match power.len() {
                1 => {}
                2 => f.write_str("²")?,
                3 => f.write_str("³")?,
                exponent => write!(f, "^{exponent}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use fos_core::{u, y};

    use super::*;

    fn texts(pool: &Candidates) -> Vec<String> {
        pool.monomials().iter().map(|m| monomial_text(m)).collect()
    }

    #[test]
    fn lists_products_in_the_documented_order() {
        let pool =
            Candidates::builder().output(1..=2, 2).input(0, 0..=0, 1).cross_products(2).build().unwrap();
        let expected = [
            "y(n-1)",
            "y(n-2)",
            "u0(n)",
            "y(n-1)²",
            "y(n-1)·y(n-2)",
            "y(n-1)·u0(n)",
            "y(n-2)²",
            "y(n-2)·u0(n)",
        ];
        assert_eq!(texts(&pool), expected);
        for (i, monomial) in pool.monomials().iter().enumerate() {
            assert_eq!(pool.position(monomial), Some(i));
        }
        assert_eq!(pool.position(&[y(3)]), None);
    }

    #[test]
    fn counts_multisets_of_lags() {
        // C(L + D, D) − 1 products of up to D of L lags
        for (lags, degree, count) in [(10, 1, 10), (10, 2, 65), (10, 3, 285), (1, 3, 3)] {
            assert_eq!(Candidates::builder().output(1..=lags, degree).build().unwrap().len(), count);
        }
    }

    #[test]
    fn separates_channels_by_default() {
        let builder = Candidates::builder().output(1..=1, 2).input(1, 0..=0, 1);
        let apart = builder.clone().build().unwrap();
        assert_eq!(texts(&apart), ["y(n-1)", "u1(n)", "y(n-1)²"]);
        assert_eq!(apart.inputs(), 2);
        let crossed = builder.cross_products(3).build().unwrap();
        assert_eq!(texts(&crossed), ["y(n-1)", "u1(n)", "y(n-1)²", "y(n-1)·u1(n)", "y(n-1)²·u1(n)"]);
    }

    #[test]
    fn sorts_and_merges_explicit_monomials() {
        let pool =
            Candidates::builder().monomial(&[u(0, 0), y(3)]).monomial(&[y(3), u(0, 0)]).build().unwrap();
        assert_eq!(pool.monomials(), [vec![y(3), u(0, 0)]]);
        assert_eq!(monomial_text_named(&pool.monomials()[0], "gx", &["temp"]), "gx(n-3)·temp(n)");
        assert_eq!(monomial_text(&[]), "1");
    }

    #[test]
    fn rejects_invalid_pools() {
        let refused = |builder: Builder| builder.build().unwrap_err();
        assert_eq!(refused(Candidates::builder().output(0..=3, 1)), CandidatesError::OutputAtLagZero);
        assert_eq!(
            refused(Candidates::builder().monomial(&[y(0), u(0, 1)])),
            CandidatesError::OutputAtLagZero
        );
        assert_eq!(refused(Candidates::builder().output(1..=3, 4)), CandidatesError::Degree(4));
        assert_eq!(refused(Candidates::builder().output(1..=3, 0)), CandidatesError::Degree(0));
        let out_of_reach = |text: &str| CandidatesError::OutOfReach(text.into());
        assert_eq!(refused(Candidates::builder().monomial(&[y(16_384)])), out_of_reach("y(n-16384)"));
        assert_eq!(refused(Candidates::builder().input(126, 0..=0, 1)), out_of_reach("u126(n)"));
        assert_eq!(refused(Candidates::builder().monomial(&[y(1); 4])), CandidatesError::Degree(4));
        assert_eq!(refused(Candidates::builder().monomial(&[])), CandidatesError::Constant);
        #[allow(clippy::reversed_empty_ranges)]
        let reversed = Candidates::builder().input(0, 3..=2, 1);
        assert_eq!(refused(reversed), CandidatesError::EmptyLags(3, 2));
        assert_eq!(refused(Candidates::builder()), CandidatesError::Empty);
        assert_eq!(refused(Candidates::builder().output(1..=MAX_LAG, 3)), CandidatesError::TooMany);
    }
}
