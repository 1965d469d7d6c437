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
    let error = |x: &[f64]| Series {
        label: "error".into(),
        ink: Ink::Residual,
        shape: Shape::Points(pairs(x, &found.error)),
    };
    let explained = |shape| Series { label: effect.to_owned(), ink: Ink::Predicted, shape };
    let y = || Axis::linear(format!("{} ({})", capitalised(subject.channel), subject.unit));
    let ranges = largest_s.map(|[from, to]| ShadedRange { from, to, ..ShadedRange::default() });
    let mut panels = vec![Panel {
        title: format!("means over {:.1} s, other findings subtracted", found.block_s),
        x: Axis::linear("Time (s)"),
        y: y(),
        series: vec![error(&found.time_s), explained(Shape::Line(pairs(&found.time_s, &found.effect)))],
        shading: vec![Shading {
            label: "largest here".into(),
            tone: Tone::Apart,
            ranges: ranges.into_iter().collect(),
        }],
    }];
    if let Some(against) = &found.against {
        panels.push(Panel {
            title: format!("the same against {}", against.column),
            x: Axis::linear(named_with_unit(&against.column)),
            y: y(),
            series: vec![
                error(&against.values),
                explained(Shape::Points(pairs(&against.values, &found.effect))),
            ],
            ..Panel::default()
        });
    }
    Figure { title: format!("{}: {effect}", capitalised(subject.channel)), panels }
}

fn pairs(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

/// The spectrum about a line.
fn line_figure(subject: Subject, effect: &str, line: &LineEvidence) -> Figure {
    let &LineEvidence { line_hz, ref frequency_hz, ref density } = line;
    let panel = Panel {
        title: format!("the line at {line_hz:.3} Hz"),
        x: Axis::linear("Frequency (Hz)"),
        y: Axis::log(format!("Power spectral density ({})", super::compare::per_hertz(subject.unit))),
        series: vec![Series {
            label: "measured".into(),
            ink: Ink::Measured,
            shape: Shape::Line(pairs(frequency_hz, density)),
        }],
        shading: vec![Shading {
            label: "the line".into(),
            tone: Tone::Apart,
            ranges: vec![ShadedRange {
                from: line_hz * 0.995,
                to: line_hz * 1.005,
                ..ShadedRange::default()
            }],
        }],
    };
    Figure { title: format!("{}: {effect}", capitalised(subject.channel)), panels: vec![panel] }
}
