//! The name nearest to one that was not found, for messages.

/// The name among `names` that differs from `wanted` in the fewest letters, unless more than half would differ.
pub fn closest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    names
        .into_iter()
        .map(|name| (edits(&wanted.to_lowercase(), &name.to_lowercase()), name))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, name)| 2 * edits <= wanted.chars().count().max(name.chars().count()))
        .map(|(_, name)| name)
}

/// Letters to insert, remove or replace to turn `a` into `b` (Levenshtein 1966).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_of_a_textbook_pair() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
    }

    #[test]
    fn the_closest_name_ignores_case_and_nothing_alike_is_none() {
        assert_eq!(closest("gx_rad", ["ax_mps2", "GX_RADS", "temp_c"]), Some("GX_RADS"));
        assert_eq!(closest("gx_rads", ["voltage", "q"]), None);
    }
}
