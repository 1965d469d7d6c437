//! Figures of a comparison: model against measurement, from computed numbers.

use super::{Axis, Figure, Ink, Panel, Series, ShadedRange, Shading, Shape, Tone, named_with_unit};
use fos_data::text::capitalised;
use fos_fit::signal::allan::AllanPoint;
use fos_fit::signal::autocorrelation::Autocorrelation;
use fos_fit::signal::blocks::Envelope;
use fos_fit::signal::spectrum::Spectrum;

/// Name and unit of the compared quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Subject<'a> {
    /// Measured quantity, as in `gyro x`.
    pub channel: &'a str,
    /// Unit, as in `rad/s`.
    pub unit: &'a str,
}

/// Parts of a recording with a shaded background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetApart<'a> {
    /// Legend text of the stretches with the largest error, as in `worst minutes`.
    pub label: &'a str,
    /// First and last second of each stretch, the worst first; they are numbered in this order.
    pub worst_s: &'a [(f64, f64)],
    /// Detected motion, which is not evaluated.
    pub moved: &'a Shading,
}

/// Measurement and prediction over time: all samples as a band in the upper panel, moving means in the lower one, because noise at the full
/// rate hides the errors of a model.
///
/// One envelope for each stretch without gaps; `mean_label` states the length of the mean, as in `1 s mean`.
pub fn measured_and_predicted(
    subject: Subject,
    measured: &[Envelope],
    predicted: &[Envelope],
    mean_label: &str,
    apart: SetApart,
) -> Figure {
    let traces = [("measured", Ink::Measured, measured), ("predicted", Ink::Predicted, predicted)];
    over_time(subject, "measured and predicted", &traces, mean_label, apart)
}

/// Residual over time, with the same shading.
pub fn residual(subject: Subject, residual: &[Envelope], mean_label: &str, apart: SetApart) -> Figure {
    over_time(subject, "residual", &[("residual", Ink::Residual, residual)], mean_label, apart)
}

/// Autocorrelation of the residual at lags ≥ 1, with the bounds of 95 % of the values of white noise.
pub fn residual_autocorrelation(
    subject: Subject,
    autocorrelation: &Autocorrelation,
    sample_period_s: f64,
) -> Figure {
    let values = autocorrelation.values.iter().enumerate().skip(1);
    let stems = values.map(|(lag, value)| (lag as f64 * sample_period_s, *value)).collect();
    let bound = autocorrelation.white_noise_bound();
    let level = |label: &str, y| Series { label: label.into(), ink: Ink::Bound, shape: Shape::Level(y) };
    let outside = 100.0 * autocorrelation.fraction_outside();
    let panel = Panel {
        title: format!("{outside:.0} % of the lags lie outside; white noise: 5 %"),
        x: Axis::linear("Lag (s)"),
        y: Axis::linear("Autocorrelation (1)"),
        series: vec![
            level("±1.96/√N", bound),
            level("", -bound),
            Series { label: "residual".into(), ink: Ink::Residual, shape: Shape::Stems(stems) },
        ],
        shading: Vec::new(),
    };
    Figure { title: headline(subject, "autocorrelation of the residual"), panels: vec![panel] }
}

/// Power spectral densities of measurement, prediction and residual. Smooth them first (`Spectrum::smoothed`).
///
/// `floor_density` (unit²/Hz, `NoiseFloor::density`) is drawn as a level: the spectrum of the residual of the best predictor. A residual
/// below it at some frequencies is above it at others.
pub fn spectra(
    subject: Subject,
    measured: &Spectrum,
    predicted: &Spectrum,
    residual: &Spectrum,
    floor_density: Option<f64>,
) -> Figure {
    let curve = |label: &str, ink, spectrum: &Spectrum| {
        let points = spectrum.frequency_hz.iter().copied().zip(spectrum.density.iter().copied());
        // A logarithmic axis has no frequency 0.
        let points = points.filter(|(frequency, _)| *frequency > 0.0).collect();
        Series { label: label.into(), ink, shape: Shape::Line(points) }
    };
    let floor = floor_density.map(|density| Series {
        label: "noise floor, spread evenly".into(),
        ink: Ink::Floor,
        shape: Shape::Level(density),
    });
    let curves = [
        curve("measured", Ink::Measured, measured),
        curve("predicted", Ink::Predicted, predicted),
        curve("residual", Ink::Residual, residual),
    ];
    let panel = Panel {
        x: Axis::log("Frequency (Hz)"),
        y: Axis::log(format!("Power spectral density ({})", per_hertz(subject.unit))),
        series: curves.into_iter().chain(floor).collect(),
        ..Panel::default()
    };
    Figure { title: headline(subject, "spectrum"), panels: vec![panel] }
}

/// Allan deviations of measurement, prediction and residual, with 95 % intervals.
pub fn allan(
    subject: Subject,
    measured: &[AllanPoint],
    predicted: &[AllanPoint],
    residual: &[AllanPoint],
) -> Figure {
    let bars = |label: &str, ink, points: &[AllanPoint]| {
        let bars = points.iter().map(|point| (point.tau_s, point.deviation, point.low, point.high)).collect();
        Series { label: label.into(), ink, shape: Shape::Bars(bars) }
    };
    let panel = Panel {
        title: "bars: 95 % confidence".into(),
        x: Axis::log("Averaging time (s)"),
        y: Axis::log(format!("Allan deviation ({})", subject.unit)),
        series: vec![
            bars("measured", Ink::Measured, measured),
            bars("predicted", Ink::Predicted, predicted),
            bars("residual", Ink::Residual, residual),
        ],
        shading: Vec::new(),
    };
    Figure { title: headline(subject, "Allan deviation"), panels: vec![panel] }
}

/// Block means of the residual against those of a channel; `apart` are the blocks of a selected stretch.
pub fn against(
    subject: Subject,
    channel: &str,
    block_s: f64,
    usual: Vec<(f64, f64)>,
    apart: Vec<(f64, f64)>,
) -> Figure {
    let dots = |label: &str, ink, dots| Series { label: label.into(), ink, shape: Shape::Points(dots) };
    let mut series = vec![dots("residual", Ink::Residual, usual)];
    if !apart.is_empty() {
        series.push(dots("in the stretch", Ink::Predicted, apart));
    }
    let panel = Panel {
        title: format!("means over {block_s:.1} s"),
        x: Axis::linear(named_with_unit(channel)),
        y: Axis::linear(format!("Residual ({})", subject.unit)),
        series,
        ..Panel::default()
    };
    Figure { title: headline(subject, &format!("residual against {channel}")), panels: vec![panel] }
}

fn over_time(
    subject: Subject,
    what: &str,
    traces: &[(&str, Ink, &[Envelope])],
    mean_label: &str,
    apart: SetApart,
) -> Figure {
    let bands = traces.iter().flat_map(|(name, ink, envelopes)| {
        envelopes.iter().map(move |envelope| {
            let label = format!("{name}, lowest to highest");
            Series { label, ink: *ink, shape: Shape::Band(envelope.band()) }
        })
    });
    let means: Vec<Series> = traces
        .iter()
        .flat_map(|(name, ink, envelopes)| {
            envelopes.iter().map(move |envelope| {
                let points = envelope.time_s.iter().copied().zip(envelope.mean.iter().copied()).collect();
                Series { label: format!("{name}, {mean_label}"), ink: *ink, shape: Shape::Line(points) }
            })
        })
        .collect();
    let panel = |title: &str, series| Panel {
        title: title.into(),
        x: Axis::linear("Time (s)"),
        y: Axis::linear(format!("{} ({})", capitalised(subject.channel), subject.unit)),
        series,
        shading: shading(apart),
    };
    Figure {
        title: headline(subject, what),
        panels: vec![
            panel("Every sample", bands.chain(means.iter().cloned()).collect()),
            panel("Means", means),
        ],
    }
}

fn shading(apart: SetApart) -> Vec<Shading> {
    let worst = apart.worst_s.iter().zip(1..).map(|((from, to), number)| ShadedRange {
        from: *from,
        to: *to,
        mark: number.to_string(),
        says: String::new(),
    });
    let worst = Shading { label: apart.label.into(), tone: Tone::Apart, ranges: worst.collect() };
    vec![apart.moved.clone(), worst]
}

fn headline(subject: Subject, what: &str) -> String {
    format!("{}: {what}", capitalised(subject.channel))
}

/// `rad/s` → `(rad/s)²/Hz`.
pub(super) fn per_hertz(unit: &str) -> String {
    if unit.contains(['/', ' ', '·']) { format!("({unit})²/Hz") } else { format!("{unit}²/Hz") }
}

#[cfg(test)]
mod tests {
    use super::super::svg;
    use super::*;
    use fos_fit::signal::blocks::envelope;

    const GYRO: Subject = Subject { channel: "gyro x", unit: "rad/s" };
    const NOTHING: Shading = Shading { label: String::new(), tone: Tone::LeftOut, ranges: Vec::new() };
    const NOWHERE: SetApart = SetApart { label: "worst", worst_s: &[], moved: &NOTHING };

    #[test]
    fn pieces_of_a_recording_share_one_label() {
        let piece = |start: f64| Envelope {
            time_s: vec![start, start + 1.0],
            low: vec![-1.0, -2.0],
            high: vec![1.0, 2.0],
            mean: vec![0.0, 0.5],
        };
        let figure = residual(GYRO, &[piece(0.0), piece(10.0)], "1 s mean", NOWHERE);
        let series = &figure.panels[1].series;
        assert_eq!(series.len(), 2);
        assert_eq!(series[0].label, series[1].label);
        assert_eq!(series[1].shape, Shape::Line(vec![(10.0, 0.0), (11.0, 0.5)]));
        assert_eq!(figure.panels[0].series[0].shape, Shape::Band(vec![(0.0, -1.0, 1.0), (1.0, -2.0, 2.0)]));
    }

    #[test]
    fn figure_size_is_independent_of_record_length() {
        let drawn = |samples: usize| {
            let series: Vec<f64> = (0..samples).map(|n| (n as f64 * 0.37).sin() * (n % 101) as f64).collect();
            let outline = envelope(&series, 0.0, 0.005, 1000, 1.0);
            svg(&residual(GYRO, &[outline], "1 s mean", NOWHERE)).unwrap().len()
        };
        // 1000 buckets: 4000 corners of about 10 characters, and the axes.
        assert!(drawn(1_000_000) < 100_000 && drawn(10_000) < 100_000);
    }

    #[test]
    fn worst_parts_are_numbered_in_the_order_given() {
        let apart = SetApart { worst_s: &[(50.0, 60.0), (10.0, 20.0)], ..NOWHERE };
        let mut shading = measured_and_predicted(GYRO, &[], &[], "1 s mean", apart).panels.remove(0).shading;
        let ranges = shading.remove(1).ranges;
        assert_eq!((ranges[0].from, ranges[0].mark.as_str()), (50.0, "1"));
        assert_eq!((ranges[1].from, ranges[1].mark.as_str()), (10.0, "2"));
    }

    #[test]
    fn bounds_are_those_of_white_noise_without_lag_zero() {
        let found = Autocorrelation { values: vec![1.0, 0.5, 0.0], samples: 100 };
        let panel = residual_autocorrelation(GYRO, &found, 0.005).panels.remove(0);
        let Shape::Level(bound) = panel.series[0].shape else { panic!("a level") };
        assert!((bound - 0.196).abs() < 1e-4);
        assert_eq!(panel.series[2].shape, Shape::Stems(vec![(0.005, 0.5), (0.01, 0.0)]));
        assert!(panel.title.starts_with("50 %"));
    }

    #[test]
    fn compound_units_are_squared_in_brackets() {
        assert_eq!(per_hertz("rad/s"), "(rad/s)²/Hz");
        assert_eq!(per_hertz("mg"), "mg²/Hz");
    }
}
