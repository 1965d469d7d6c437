//! Evidence for an effect as a figure: over time and against the channel that shows it best, or its line in the spectrum.

use super::compare::Subject;
use super::{Axis, Figure, Ink, Panel, Series, ShadedRange, Shading, Shape, Tone, named_with_unit};
use fos_data::column::Column;
use fos_data::text::capitalised;
use fos_diagnose::detect::Finding;
use fos_diagnose::refine::{Evidence, LineEvidence};

/// Draws the evidence for a finding on the axis `column`. `effect` is the name of the effect in a sentence; `found` is its evidence
/// in the slow error, without which its `line` is shown in the spectrum. None if there is neither.
pub fn evidence(
    column: &str,
    effect: &str,
    finding: &Finding,
    found: Option<&Evidence>,
    line: Option<&LineEvidence>,
) -> Option<Figure> {
    let named = Column::named(column);
    let subject = Subject { channel: named.label(), unit: named.unit().label() };
    if let Some(found) = found {
        return Some(slow_evidence(subject, effect, found, finding.shows_from_to_s));
    }
    line.map(|line| line_figure(subject, effect, line))
}

/// The slow error without all other findings, with the contribution of `effect`; shaded where it is largest.
fn slow_evidence(subject: Subject, effect: &str, found: &Evidence, largest_s: Option<[f64; 2]>) -> Figure {
    let error = |x: &[f64]| Series::new("error", Ink::Residual, Shape::Points(pairs(x, &found.error)));
    let explained = |shape| Series::new(effect, Ink::Predicted, shape);
    let y = || Axis::linear(format!("{} ({})", capitalised(subject.channel), subject.unit));
    let ranges = largest_s.map(|[from, to]| ShadedRange { from, to, ..ShadedRange::default() });
    let ranges = ranges.into_iter().collect();
    let series = [error(&found.time_s), explained(Shape::Line(pairs(&found.time_s, &found.effect)))];
    let over_time = Panel::new(Axis::linear("Time (s)"), y(), series)
        .titled(format!("means over {:.1} s, other findings subtracted", found.block_s))
        .shaded([Shading { label: "largest here".into(), tone: Tone::Apart, ranges }]);
    let against = found.against.as_ref().map(|against| {
        let effect = explained(Shape::Points(pairs(&against.values, &found.effect)));
        let x = Axis::linear(named_with_unit(&against.column));
        Panel::new(x, y(), [error(&against.values), effect])
            .titled(format!("the same against {}", against.column))
    });
    let panels = [over_time].into_iter().chain(against).collect();
    Figure { title: format!("{}: {effect}", capitalised(subject.channel)), panels }
}

fn pairs(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

/// The spectrum about a line.
fn line_figure(subject: Subject, effect: &str, line: &LineEvidence) -> Figure {
    let &LineEvidence { line_hz, ref frequency_hz, ref density } = line;
    let y = Axis::log(format!("Power spectral density ({})", super::compare::per_hertz(subject.unit)));
    let measured = Series::new("measured", Ink::Measured, Shape::Line(pairs(frequency_hz, density)));
    let range = ShadedRange { from: line_hz * 0.995, to: line_hz * 1.005, ..ShadedRange::default() };
    let panel = Panel::new(Axis::linear("Frequency (Hz)"), y, [measured])
        .titled(format!("the line at {line_hz:.3} Hz"))
        .shaded([Shading { label: "the line".into(), tone: Tone::Apart, ranges: vec![range] }]);
    Figure { title: format!("{}: {effect}", capitalised(subject.channel)), panels: vec![panel] }
}
