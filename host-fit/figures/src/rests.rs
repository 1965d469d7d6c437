//! Residual of each rest of a calibration by hand.

use fos_calibrate::RestResidual;
use fos_data::unit::MG_MPS2;

use super::{Axis, Figure, Ink, Panel, Series, Shape};

/// Width of the 95 % range of a normal distribution, in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Corrected |a| − g of every rest that the calibration uses, with the range in which 95 % are expected. Excluded rests may lie far
/// outside and would compress the picture. None without rests.
pub fn residual_of_each_rest(rests: &[RestResidual]) -> Option<Figure> {
    let used = || rests.iter().filter(|one| one.rest.excluded.is_none());
    used().next()?;
    let expected = used().map(|one| {
        let half = NORMAL_95 * one.deviation_mps2 / MG_MPS2;
        let ends = [one.rest.start_s, one.rest.start_s + one.rest.duration_s];
        let band = ends.map(|time_s| (time_s, -half, half)).to_vec();
        Series::new("expected (95 %)", Ink::Bound, Shape::Band(band))
    });
    let residual =
        used().map(|one| (one.rest.start_s + 0.5 * one.rest.duration_s, one.residual_mps2 / MG_MPS2));
    let residual = Series::new("residual", Ink::Residual, Shape::Points(residual.collect()));
    let y = Axis::linear("Corrected |a| − g (mg)");
    let panel = Panel::new(Axis::linear("Time (s)"), y, expected.chain([residual]));
    Some(Figure { title: "Residual of each rest".into(), panels: vec![panel] })
}
