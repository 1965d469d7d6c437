//! Orientations on the sphere, as two discs: the half with z pointing up, seen from above, and the half with z pointing down, seen from
//! below. Equal areas of the sphere are equal areas of the picture (Lambert's azimuthal projection).

use fos_calibrate::{Next, RestResidual};
use serde::Serialize;

const RADIUS: f64 = 110.0;
const MARGIN: f64 = 34.0;

/// One orientation in the picture; pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mark {
    /// From the left.
    pub x: f64,
    /// From the top.
    pub y: f64,
}

/// The picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sphere {
    pub width: f64,
    pub height: f64,
    pub radius: f64,
    /// Middles of the two discs.
    pub discs: [Mark; 2],
    /// Names of the directions at the middle and at the rim.
    pub names: Vec<(Mark, &'static str)>,
    /// Rests that the estimate uses.
    pub used: Vec<Mark>,
    pub excluded: Vec<Mark>,
    /// The orientation that narrows the widest interval most.
    pub next: Mark,
}

const DISCS: [Mark; 2] = [
    Mark { x: MARGIN + RADIUS, y: MARGIN + RADIUS },
    Mark { x: 3.0 * (MARGIN + RADIUS), y: MARGIN + RADIUS },
];

/// The place of a direction that points up.
fn mark([x, y, z]: [f64; 3]) -> Mark {
    let (disc, side) = if z >= 0.0 { (DISCS[0], 1.0) } else { (DISCS[1], -1.0) };
    let across = x.hypot(y);
    let length = RADIUS * (1.0 - z.abs()).max(0.0).sqrt();
    let [right, up] = if across > 0.0 { [side * x, y].map(|part| length * part / across) } else { [0.0; 2] };
    Mark { x: disc.x + right, y: disc.y - up }
}

impl Sphere {
    pub(super) fn of(rests: &[RestResidual], next: &Next) -> Self {
        let marks = |is_used: bool| {
            let of_kind = rests.iter().filter(|one| one.rest.excluded.is_none() == is_used);
            of_kind.map(|one| mark(one.up)).collect()
        };
        let beyond = RADIUS + 14.0;
        let rim = |disc: Mark, side: f64| {
            [(beyond, 0.0, 0), (0.0, -beyond, 1), (-beyond, 0.0, 2), (0.0, beyond, 3)].map(|(x, y, which)| {
                let names = if side > 0.0 { ["x", "y", "−x", "−y"] } else { ["−x", "y", "x", "−y"] };
                (Mark { x: disc.x + x, y: disc.y + y + 4.0 }, names[which])
            })
        };
        let mut names: Vec<(Mark, &'static str)> =
            DISCS.into_iter().zip([1.0, -1.0]).flat_map(|(disc, side)| rim(disc, side)).collect();
        names.extend(
            DISCS
                .into_iter()
                .zip(["z", "−z"])
                .map(|(disc, name)| (Mark { x: disc.x + 12.0, y: disc.y + 16.0 }, name)),
        );
        Self {
            width: 4.0 * (MARGIN + RADIUS),
            height: 2.0 * (MARGIN + RADIUS),
            radius: RADIUS,
            discs: DISCS,
            names,
            used: marks(true),
            excluded: marks(false),
            next: mark(next.orientation.up),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_lie_in_the_middle_and_on_the_rim() {
        let near = |one: Mark, x: f64, y: f64| (one.x - x).abs() < 1e-9 && (one.y - y).abs() < 1e-9;
        let [above, below] = DISCS;
        assert!(
            near(mark([0.0, 0.0, 1.0]), above.x, above.y) && near(mark([0.0, 0.0, -1.0]), below.x, below.y)
        );
        assert!(near(mark([1.0, 0.0, 0.0]), above.x + RADIUS, above.y));
        // a half of the hemisphere's area lies within 60° of its middle
        let sixty = mark([3_f64.sqrt() / 2.0, 0.0, 0.5]);
        assert!(near(sixty, above.x + RADIUS / 2_f64.sqrt(), above.y));
        // seen from below, x is on the left
        assert!(mark([0.5, 0.0, -(0.75_f64.sqrt())]).x < below.x);
    }
}
