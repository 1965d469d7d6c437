//! Orientations in words, and the set of those that a hand can make: on faces, edges and corners.

use serde::Serialize;

use crate::vector::{angle_deg, unit};

/// An orientation: the direction that points up, in the frame of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Orientation {
    /// Unit vector; the specific force at rest is gravity times this.
    pub up: [f64; 3],
}

/// Orientations closer than this count as one, °: by hand a device cannot be turned to a degree.
pub(crate) const SAME_DEG: f64 = 5.0;

impl Orientation {
    /// The orientation in words: "y pointing up"; "on an edge, z and −x 45° up".
    pub fn describe(&self) -> String {
        const NAMES: [&str; 3] = ["x", "y", "z"];
        let largest = self.up.iter().fold(0.0_f64, |largest, part| largest.max(part.abs()));
        let mut parts: Vec<String> = Vec::new();
        let named = self.up.iter().zip(NAMES).filter(|(part, _)| part.abs() > 0.4 * largest);
        for (part, name) in named.clone() {
            parts.push(if *part < 0.0 { format!("−{name}") } else { name.to_owned() });
        }
        match (&parts[..], named.clone().next()) {
            ([_], Some((part, name))) if *part < 0.0 => format!("{name} pointing down"),
            ([one], _) => format!("{one} pointing up"),
            ([one, two], _) => format!("the device on an edge, {one} and {two} each 45° up"),
            (all, _) => format!("the device on a corner, {} each 35° up", all.join(", ")),
        }
    }
}

/// The 6 faces, 12 edges and 8 corners of a box, in this order.
pub(crate) fn candidates() -> Vec<Orientation> {
    let mut all = Vec::new();
    for parts in 1..=3 {
        for x in [0.0, 1.0, -1.0] {
            for y in [0.0, 1.0, -1.0] {
                for z in [0.0, 1.0, -1.0_f64] {
                    let up = [x, y, z];
                    if up.iter().filter(|part| **part != 0.0).count() == parts {
                        all.push(Orientation { up: unit(up) });
                    }
                }
            }
        }
    }
    all
}

/// Number of orientations that differ: each is further than [`SAME_DEG`] from those counted before it.
pub(crate) fn count_distinct(directions: &[[f64; 3]]) -> usize {
    let mut distinct: Vec<&[f64; 3]> = Vec::new();
    for direction in directions {
        if distinct.iter().all(|other| angle_deg(direction, other) > SAME_DEG) {
            distinct.push(direction);
        }
    }
    distinct.len()
}

/// The candidates furthest from all orientations so far, one after the other; faces first among equals.
pub(crate) fn furthest(directions: &[[f64; 3]], count: usize) -> Vec<Orientation> {
    let mut seen = directions.to_vec();
    let mut chosen = Vec::new();
    for _ in 0..count {
        let distance = |candidate: &Orientation| {
            seen.iter().map(|one| angle_deg(one, &candidate.up)).fold(180.0, f64::min)
        };
        let mut best: Option<(f64, Orientation)> = None;
        for candidate in candidates() {
            let far = distance(&candidate);
            if best.is_none_or(|(furthest, _)| far > furthest + 10.0) {
                best = Some((far, candidate));
            }
        }
        let Some((_, orientation)) = best else { break };
        seen.push(orientation.up);
        chosen.push(orientation);
    }
    chosen
}

/// Most orientations in a sentence.
const MOST_IN_WORDS: usize = 4;

/// Orientations in a sentence: "one dwell with y pointing up, one dwell with …".
pub(crate) fn in_words(orientations: &[Orientation]) -> String {
    let some = orientations.iter().take(MOST_IN_WORDS);
    let mut listed: Vec<String> = some.map(|one| format!("one dwell with {}", one.describe())).collect();
    if orientations.len() > MOST_IN_WORDS {
        listed.push("and others on edges and corners".to_owned());
    }
    listed.join(", ")
}

/// Faces that no direction comes near to: within 45°.
pub(crate) fn unseen(directions: &[[f64; 3]]) -> Vec<Orientation> {
    let is_seen = |face: &Orientation| directions.iter().any(|one| angle_deg(one, &face.up) < 45.0);
    candidates().into_iter().take(6).filter(|face| !is_seen(face)).collect()
}

/// Largest angle between two of the directions, °.
pub(crate) fn spread_deg(directions: &[[f64; 3]]) -> f64 {
    let mut largest = 0.0_f64;
    // the pair furthest apart of many is found among those furthest from the first, to within the aim of 20°
    let some: Vec<&[f64; 3]> = directions.iter().step_by(directions.len().div_ceil(400).max(1)).collect();
    for (index, one) in some.iter().enumerate() {
        for other in &some[index + 1..] {
            largest = largest.max(angle_deg(one, other));
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientations_are_described_by_the_axes_that_point_up() {
        let words = |up: [f64; 3]| Orientation { up: unit(up) }.describe();
        assert_eq!(words([0.05, 1.0, -0.1]), "y pointing up");
        assert_eq!(words([0.0, 0.0, -1.0]), "z pointing down");
        assert_eq!(words([-1.0, 0.0, 1.0]), "the device on an edge, −x and z each 45° up");
        assert_eq!(words([1.0, 1.0, -1.0]), "the device on a corner, x, y, −z each 35° up");
        assert_eq!(candidates().len(), 26);
    }

    #[test]
    fn unseen_faces_come_first() {
        let seen: Vec<[f64; 3]> = candidates()[..6].iter().map(|c| c.up).filter(|up| up[1] < 0.5).collect();
        let next = furthest(&seen, 2);
        assert_eq!(next[0].describe(), "y pointing up");
        assert_eq!(count_distinct(&[[1.0, 0.0, 0.0], unit([1.0, 0.05, 0.0]), [0.0, 1.0, 0.0]]), 2);
    }
}
