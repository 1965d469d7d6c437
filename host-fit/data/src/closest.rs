//! Suggests the name nearest to one that was not found, for messages.

/// Everyday names of channels, each with its column.
const OTHER_WORDS: [(&str, &str); 10] = [
    ("temperature", "temp_c"),
    ("temp", "temp_c"),
    ("celsius", "temp_c"),
    ("supply", "supply_v"),
    ("voltage", "supply_v"),
    ("vbat", "supply_v"),
    ("load", "load_pct"),
    ("cpu", "load_pct"),
    ("time", "t_s"),
    ("timestamp", "t_s"),
];

/// Column with the everyday name `wanted`, if it is among `names`; otherwise the name that differs from `wanted` in the
/// fewest letters (Levenshtein 1966), unless more than half would differ.
pub fn closest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = wanted.to_lowercase();
    let edits = |name: &str| strsim::levenshtein(&lower, &name.to_lowercase());
    let names: Vec<&str> = names.into_iter().collect();
    let other = OTHER_WORDS.iter().find(|(word, _)| *word == lower);
    if let Some(column) = other.and_then(|(_, column)| names.iter().find(|name| *name == column)) {
        return Some(column);
    }
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
        assert_eq!(closest("Temperature", ["gx_rads", "temp_c"]), Some("temp_c"));
        assert_eq!(closest("temperature", ["gx_rads"]), None);
    }
}
