//! Identifies this build, because stored results are reused only if the same program computed them.

/// Version of the program, and size and modification time of its file.
pub(crate) fn this_build() -> String {
    let file = std::env::current_exe().and_then(std::fs::metadata);
    let file = file.map(|about| format!("{} {:?}", about.len(), about.modified().ok()));
    format!("{} {}", env!("CARGO_PKG_VERSION"), file.unwrap_or_default())
}
