//! What the checks of the supply have to say.

/// What is found: sentences for the page, what is wrong, and what was refused to show that it can be.
#[derive(Default)]
pub(crate) struct Findings {
    pub(crate) report: Vec<String>,
    pub(crate) problems: Vec<String>,
    pub(crate) controls: Vec<&'static str>,
}
