//! Figures of a comparison: model against measurement, from computed numbers.

use std::ops::Range;

use super::{Axis, Figure, Ink, Panel, Series, ShadedRange, Shading, Shape, Tone, named_with_unit};
use crate::curves::{AgainstChannel, AxisCurves, MEAN_S};
use crate::dependence;
use fos_data::column::Column;
use fos_data::text::capitalised;
use fos_diagnose::compare::AxisComparison;
use fos_fit::signal::allan::AllanPoint;
use fos_fit::signal::autocorrelation::Autocorrelation;
use fos_fit::signal::blocks::Envelope;
use fos_fit::signal::spectrum::Spectrum;

/// Legend text and colour of each curve, in the order of [`AxisCurves`].
const TRACES: [(&str, Ink); 3] =
    [("measured", Ink::Measured), ("predicted", Ink::Predicted), ("residual", Ink::Residual)];

/// Name and unit of the compared quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Subject<'a> {
    /// Measured quantity, as in `gyro x`.
    pub channel: &'a str,
    /// Unit, as in `rad/s`.
    pub unit: &'a str,
}

impl Subject<'_> {
    fn figure(self, what: &str, panels: Vec<Panel>) -> Figure {
        Figure { title: format!("{}: {what}", capitalised(self.channel)), panels }
    }
}

/// One axis of a comparison with its curves.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Errors, worst stretches, dependences.
    pub axis: &'a AxisComparison,
    /// Curves over all evaluated rows, or over a part of them.
    pub curves: &'a AxisCurves,
    /// Detected motion, which is not evaluated.
    pub moved: &'a Shading,
}

impl View<'_> {
    fn subject(&self) -> Subject<'_> {
        Subject { channel: Column::named(&self.axis.column).label(), unit: &self.axis.unit }
    }

    /// All figures in reading order, without those for which the log is too short.
    pub fn all(&self) -> Vec<Figure> {
        let mut figures = vec![self.over_time(), self.residual()];
        figures.extend(self.dependence());
        figures.extend(self.spectrum());
        figures.extend(self.autocorrelation());
        figures.push(self.allan());
        figures
    }

    /// Measurement and prediction over time: all samples as a band in the upper panel, moving means in the lower one, because noise at
    /// the full rate hides the errors of a model.
    pub fn over_time(&self) -> Figure {
        self.subject().figure("measured and predicted", self.traces_over_time(0..2))
    }

    /// Residual over time, with the same shading.
    pub fn residual(&self) -> Figure {
        self.subject().figure("residual", self.traces_over_time(2..3))
    }

    fn traces_over_time(&self, traces: Range<usize>) -> Vec<Panel> {
        let worst_s = self.axis.worst.iter().map(|stretch| (stretch.begin_s, stretch.end_s));
        let envelopes = &self.curves.over_time[traces.clone()];
        over_time(self.subject(), &TRACES[traces], envelopes, shading(self.moved, worst_s))
    }

    /// Autocorrelation of the innovations at lags ≥ 1, with the bounds of 95 % of the values of white noise; none if there are too few.
    pub fn autocorrelation(&self) -> Option<Figure> {
        let found = self.curves.autocorrelation.as_ref()?;
        let panel = autocorrelation(found, self.curves.period_s);
        Some(self.subject().figure("autocorrelation of the residual", vec![panel]))
    }

    /// Power spectral densities of measurement, prediction and residual; none if the log is too short.
    ///
    /// The noise floor is drawn as a level: the spectrum of the residual of the best predictor. A residual below it at some frequencies is
    /// above it at others.
    pub fn spectrum(&self) -> Option<Figure> {
        let (spectra, floor) = self.curves.spectra.as_ref()?;
        let curve = |((label, ink), spectrum): ((&str, Ink), &Spectrum)| {
            let points = spectrum.frequency_hz.iter().copied().zip(spectrum.density.iter().copied());
            // A logarithmic axis has no frequency 0.
            let points = points.filter(|(frequency, _)| *frequency > 0.0).collect();
            Series::new(label, ink, Shape::Line(points))
        };
        let floor =
            floor.map(|density| Series::new("noise floor, spread evenly", Ink::Floor, Shape::Level(density)));
        let panel = Panel::new(
            Axis::log("Frequency (Hz)"),
            Axis::log(format!("Power spectral density ({})", per_hertz(&self.axis.unit))),
            TRACES.into_iter().zip(spectra).map(curve).chain(floor),
        );
        Some(self.subject().figure("spectrum", vec![panel]))
    }

    /// Allan deviations of measurement, prediction and residual, with 95 % intervals.
    pub fn allan(&self) -> Figure {
        let bars = |((label, ink), points): ((&str, Ink), &Vec<AllanPoint>)| {
            let bars = points.iter().map(|point| (point.tau_s, point.deviation, point.low, point.high));
            Series::new(label, ink, Shape::Bars(bars.collect()))
        };
        let panel = Panel::new(
            Axis::log("Averaging time (s)"),
            Axis::log(format!("Allan deviation ({})", self.axis.unit)),
            TRACES.into_iter().zip(&self.curves.deviations).map(bars),
        );
        self.subject().figure("Allan deviation", vec![panel.titled("bars: 95 % confidence")])
    }

    /// Dependence of the residual on every logged column, with the level explained by chance; none if it is unknown.
    pub fn dependence(&self) -> Option<Figure> {
        let panels = dependence::panels(&self.axis.unit, self.axis.dependence.as_ref()?);
        Some(self.subject().figure("residual against every logged channel", panels))
    }

    /// Block means of the residual against those of one channel.
    pub fn against(&self, found: AgainstChannel) -> Figure {
        let AgainstChannel { channel, block_s, usual, apart } = found;
        let mut series = vec![Series::new("residual", Ink::Residual, Shape::Points(usual))];
        if !apart.is_empty() {
            series.push(Series::new("in the stretch", Ink::Predicted, Shape::Points(apart)));
        }
        let panel = Panel::new(
            Axis::linear(named_with_unit(&channel)),
            Axis::linear(format!("Residual ({})", self.axis.unit)),
            series,
        );
        let panel = panel.titled(format!("means over {block_s:.1} s"));
        self.subject().figure(&format!("residual against {channel}"), vec![panel])
    }
}

/// Stems of an autocorrelation without lag 0, between the bounds of white noise.
fn autocorrelation(found: &Autocorrelation, sample_period_s: f64) -> Panel {
    let values = found.values.iter().enumerate().skip(1);
    let stems = values.map(|(lag, value)| (lag as f64 * sample_period_s, *value)).collect();
    let bound = found.white_noise_bound();
    let outside = 100.0 * found.fraction_outside();
    let series = [
        Series::new("±1.96/√N", Ink::Bound, Shape::Level(bound)),
        Series::new("", Ink::Bound, Shape::Level(-bound)),
        Series::new("residual", Ink::Residual, Shape::Stems(stems)),
    ];
    Panel::new(Axis::linear("Lag (s)"), Axis::linear("Autocorrelation (1)"), series)
        .titled(format!("{outside:.0} % of the lags lie outside; white noise: 5 %"))
}

/// All samples, and their moving means. A trace has one envelope for each stretch without gaps.
pub(super) fn over_time(
    subject: Subject,
    traces: &[(&str, Ink)],
    envelopes: &[Vec<Envelope>],
    shading: Vec<Shading>,
) -> Vec<Panel> {
    let drawn = |what: &str, shape: fn(&Envelope) -> Shape| -> Vec<Series> {
        let series = traces.iter().zip(envelopes).flat_map(|((name, ink), envelopes)| {
            envelopes.iter().map(move |one| Series::new(format!("{name}, {what}"), *ink, shape(one)))
        });
        series.collect()
    };
    let bands = drawn("lowest to highest", |envelope| Shape::Band(envelope.band()));
    let means = drawn(&format!("{MEAN_S} s mean"), |envelope| {
        Shape::Line(envelope.time_s.iter().copied().zip(envelope.mean.iter().copied()).collect())
    });
    let panel = |title: &str, series| {
        let y = Axis::linear(format!("{} ({})", capitalised(subject.channel), subject.unit));
        Panel::new(Axis::linear("Time (s)"), y, series).titled(title).shaded(shading.clone())
    };
    vec![panel("Every sample", [bands, means.clone()].concat()), panel("Means", means)]
}

/// Motion, and the stretches with the largest error: first and last second of each, numbered in this order.
pub(super) fn shading(moved: &Shading, worst_s: impl IntoIterator<Item = (f64, f64)>) -> Vec<Shading> {
    let worst = worst_s.into_iter().zip(1..).map(|((from, to), number)| ShadedRange {
        from,
        to,
        mark: number.to_string(),
        says: String::new(),
    });
    let worst = Shading { label: "worst stretches".into(), tone: Tone::Apart, ranges: worst.collect() };
    vec![moved.clone(), worst]
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

    fn residual(envelopes: Vec<Envelope>) -> Figure {
        GYRO.figure("residual", over_time(GYRO, &TRACES[2..], &[envelopes], shading(&NOTHING, [])))
    }

    #[test]
    fn pieces_of_a_recording_share_one_label() {
        let piece = |start: f64| Envelope {
            time_s: vec![start, start + 1.0],
            low: vec![-1.0, -2.0],
            high: vec![1.0, 2.0],
            mean: vec![0.0, 0.5],
        };
        let figure = residual(vec![piece(0.0), piece(10.0)]);
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
            svg(&residual(vec![outline])).unwrap().len()
        };
        // 1000 buckets: 4000 corners of about 10 characters, and the axes.
        assert!(drawn(1_000_000) < 100_000 && drawn(10_000) < 100_000);
    }

    #[test]
    fn worst_parts_are_numbered_in_the_order_given() {
        let ranges = shading(&NOTHING, [(50.0, 60.0), (10.0, 20.0)]).remove(1).ranges;
        assert_eq!((ranges[0].from, ranges[0].mark.as_str()), (50.0, "1"));
        assert_eq!((ranges[1].from, ranges[1].mark.as_str()), (10.0, "2"));
    }

    #[test]
    fn bounds_are_those_of_white_noise_without_lag_zero() {
        let found = Autocorrelation { values: vec![1.0, 0.5, 0.0], samples: 100 };
        let panel = autocorrelation(&found, 0.005);
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
