//! The name nearest to one that was not found, for messages.

/// The name among `names` that differs from `wanted` in the fewest letters (Levenshtein 1966), unless more than half
/// would differ.
pub fn closest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let edits = |name: &str| strsim::levenshtein(&wanted.to_lowercase(), &name.to_lowercase());
    names
        .into_iter()
        .map(|name| (edits(name), name))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, name)| 2 * edits <= wanted.chars().count().max(name.chars().count()))
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_name_ignores_case_and_nothing_alike_is_none() {
        assert_eq!(closest("gx_rad", ["ax_mps2", "GX_RADS", "temp_c"]), Some("GX_RADS"));
        assert_eq!(closest("gx_rads", ["voltage", "q"]), None);
    }
}
