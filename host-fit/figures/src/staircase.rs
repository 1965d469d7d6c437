//! Figure of the remaining error after each added effect, predicted and measured.

use super::{Axis, Figure, Ink, Panel, Series, Shape};
use fos_data::column::Column;
use fos_data::text::capitalised;
use fos_diagnose::effects::Band;
use fos_diagnose::study::{Left, Refinement};

/// Half of the length of a tread. Treads touch, so that the risers are vertical.
const TREAD: f64 = 0.5;

/// Line with a level for each step.
fn treads(values: impl Iterator<Item = f64>) -> Shape {
    let treads =
        values.enumerate().map(|(at, value)| [(at as f64 - TREAD, value), (at as f64 + TREAD, value)]);
    Shape::Line(treads.flatten().collect())
}

/// Remaining error after each step: RMS of the 1-s means, RMS of the samples, RMS while coasting over each horizon. Steps are named below
/// the axis.
pub fn staircase(refinement: &Refinement) -> Figure {
    let column = Column::named(&refinement.column);
    let unit = column.unit().label();
    let steps = &refinement.steps;
    let x =
        || Axis { names: steps.iter().map(|step| step.errors.model.clone()).collect(), ..Axis::linear("") };
    let panel = |title: &str, label: &str, variance: fn(&Left) -> f64, wide: bool| {
        let stairs = treads(steps.iter().map(|step| variance(&step.left).sqrt()));
        let predicted = steps.windows(2).zip(1..).filter_map(|(pair, at)| {
            let finding = &pair[1].added.as_ref()?.finding;
            let is_drawn = finding.predicted_reduction > 0.0 && wide == (finding.band == Band::Wide);
            let before = variance(&pair[0].left).sqrt();
            let left = |drop: f64| before * (1.0 - drop).max(0.0).sqrt();
            let [low, high] = finding.predicted_reduction_interval;
            let bar = (f64::from(at), left(finding.predicted_reduction), left(high), left(low));
            // A series for each step, without a line between them.
            is_drawn.then(|| Series::new("predicted, 90 %", Ink::Predicted, Shape::Bars(vec![bar])))
        });
        let measured = Series::new("measured", Ink::Residual, stairs);
        Panel::new(x(), Axis::log(label), [measured].into_iter().chain(predicted)).titled(title)
    };
    let horizons = steps.first().into_iter().flat_map(|step| &step.errors.coast).map(|coast| coast.horizon_s);
    let coast = horizons.enumerate().map(|(method, horizon_s)| {
        let errors = steps.iter().map(|step| {
            let coast = step.errors.coast.iter().find(|coast| coast.horizon_s == horizon_s);
            coast.map_or(f64::NAN, |coast| coast.mse.sqrt())
        });
        Series::new(format!("after {horizon_s} s"), Ink::Method(method), treads(errors))
    });
    let coast = Panel::new(x(), Axis::log(format!("RMS ({unit})")), coast).titled("free run");
    Figure {
        title: format!(
            "{}: error after every step, on data that were not fitted",
            capitalised(column.label())
        ),
        panels: vec![
            panel("slow error", &format!("RMS of 1-s means ({unit})"), |left| left.slow, false),
            panel("broadband error", &format!("RMS of samples ({unit})"), |left| left.wide, true),
            coast,
        ],
    }
}
