//! Tests over the public interfaces of the workspace; see `tests/`.

/// README's device example compiles.
#[doc = include_str!("../../README.md")]
struct Readme;
