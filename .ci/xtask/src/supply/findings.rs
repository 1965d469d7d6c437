//! Results of the supply checks.

/// Sentences for the page, problems, and controls that were refused as they must be.
#[derive(Default)]
pub(crate) struct Findings {
    pub(crate) report: Vec<String>,
    pub(crate) problems: Vec<String>,
    pub(crate) controls: Vec<&'static str>,
}
