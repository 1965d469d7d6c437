//! Tests over the public interfaces of the workspace; see `tests/`.

/// README's device example compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
