//! Figures of a population: distribution of the units, their lots, and the parts of their variance.

use statrs::distribution::{Continuous, Normal};

use super::{Axis, Figure, Ink, Panel, Series, Shape};

/// A unit's estimate of a coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitDot {
    /// Value in the unit of the coefficient.
    pub value: f64,
    /// Index of its lot.
    pub lot: Option<usize>,
    /// The unit does not belong to the population.
    pub is_odd: bool,
}

/// Estimated mean of a lot.
#[derive(Debug, Clone, PartialEq)]
pub struct LotMean {
    /// Name of the lot.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// 90 % interval of the mean.
    pub interval: [f64; 2],
}

/// A coefficient of an axis over the units of a part; all values in one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct OfCoefficient {
    /// Title, as in `gyro x: bias`.
    pub title: String,
    /// Quantity and unit, shown below an axis.
    pub quantity: String,
    /// Estimates in the order of lots and names.
    pub units: Vec<UnitDot>,
    /// Means of the lots in their order; empty if lots are unknown.
    pub lots: Vec<LotMean>,
    /// Mean of the part.
    pub mean: f64,
    /// Standard deviation of units about the mean, lots included.
    pub scatter: f64,
    /// Standard deviation of an estimate about its true value.
    pub error: f64,
}

/// Parts of the variance of estimates.
#[derive(Debug, Clone, PartialEq)]
pub struct OfVariance {
    /// Name, shown below an axis.
    pub name: String,
    /// Shares of lots, units and log errors; they add up to 1.
    pub shares: [f64; 3],
}

/// Largest deviation drawn, in standard deviations of the estimates: with further ones, the others would be indistinguishable.
const FURTHEST: f64 = 12.0;

/// Maximum number of units drawn; larger fleets are thinned out evenly.
const DOTS: usize = 500;

/// Maximum number of bins of a histogram.
const MOST_BINS: f64 = 200.0;

/// Histogram of the estimates with the population, and estimates by lot.
pub fn of_coefficient(of: &OfCoefficient) -> Figure {
    let seen = of.scatter.hypot(of.error);
    let (near, far): (Vec<UnitDot>, Vec<UnitDot>) =
        of.units.iter().partition(|unit| (unit.value - of.mean).abs() <= FURTHEST * seen);
    let beyond = match far.len() {
        0 => String::new(),
        1 => "; 1 device lies beyond".to_owned(),
        n => format!("; {n} devices lie beyond"),
    };
    let lots = if of.lots.is_empty() { in_order(of, &near) } else { by_lot(of, &near) };
    Figure { title: of.title.clone(), panels: vec![distribution(of, &near, seen, &beyond), lots] }
}

fn distribution(of: &OfCoefficient, near: &[UnitDot], seen: f64, beyond: &str) -> Panel {
    let n = near.len() as f64;
    let low = near.iter().map(|unit| unit.value).fold(f64::INFINITY, f64::min);
    let high = near.iter().map(|unit| unit.value).fold(f64::NEG_INFINITY, f64::max);
    // Half of the best width for a normal distribution (Scott 1979), because the curve beside it is smooth.
    let width = (1.75 * seen * n.powf(-1.0 / 3.0)).max((high - low) / MOST_BINS);
    let width = if width.is_normal() { width } else { 1.0 };
    let mut series = Vec::new();
    // (Number of the bin, units of the population, odd units); odd units are stacked on the others.
    let mut bins: Vec<(f64, [f64; 2])> = Vec::new();
    for unit in near {
        let number = ((unit.value - low) / width).floor();
        let place = bins.iter().position(|(other, _)| *other == number).unwrap_or_else(|| {
            bins.push((number, [0.0; 2]));
            bins.len() - 1
        });
        bins[place].1[usize::from(unit.is_odd)] += 1.0;
    }
    for (kind, (label, ink)) in [("estimates", Ink::Step(0)), ("odd", Ink::Other)].into_iter().enumerate() {
        let gap = 0.02 * width;
        let cells = bins.iter().filter(|(_, counts)| counts[kind] > 0.0).map(|(number, counts)| {
            let (left, below) = (low + number * width, if kind == 1 { counts[0] } else { 0.0 });
            (left + gap, left + width - gap, below, below + counts[kind])
        });
        let cells: Vec<_> = cells.collect();
        if !cells.is_empty() {
            series.push(Series::new(label, ink, Shape::Cells(cells)));
        }
    }
    let belonging = near.iter().filter(|unit| !unit.is_odd).count() as f64;
    // A curve much narrower than a bin would be a needle above everything else.
    for (label, ink, deviation) in
        [("devices and the error of a log", Ink::Bound, seen), ("devices", Ink::Predicted, of.scatter)]
    {
        if let Ok(normal) = Normal::new(of.mean, deviation)
            && deviation > 0.3 * width
        {
            let at = |place: i32| of.mean + 3.3 * deviation * f64::from(place) / 100.0;
            let curve = (-100..=100).map(|place| (at(place), belonging * width * normal.pdf(at(place))));
            series.push(Series::new(label, ink, Shape::Line(curve.collect())));
        }
    }
    Panel::new(Axis::linear(&of.quantity), Axis::linear("Devices in a bin (1)"), series)
        .titled(format!("How {} devices lie{beyond}", of.units.len()))
}

/// Units around the means of their lots.
fn by_lot(of: &OfCoefficient, near: &[UnitDot]) -> Panel {
    let mut dots: Vec<(f64, UnitDot)> = Vec::new();
    for lot in 0..of.lots.len() {
        let units: Vec<&UnitDot> = near.iter().filter(|unit| unit.lot == Some(lot)).collect();
        // Side by side in the order of their names, within three fifths of the width of the lot.
        let across = |place: usize| 0.6 * ((place as f64 + 0.5) / units.len() as f64 - 0.5);
        dots.extend(units.iter().enumerate().map(|(place, unit)| (lot as f64 + across(place), **unit)));
    }
    let mut series = dots_of(&dots);
    // A series for each lot, without a line between them.
    series.extend(of.lots.iter().enumerate().map(|(place, lot)| {
        let bar = (place as f64, lot.mean, lot.interval[0], lot.interval[1]);
        Series::new("mean of the lot, 90 %", Ink::Floor, Shape::Bars(vec![bar]))
    }));
    series.push(mean_of(of));
    let names = of.lots.iter().map(|lot| lot.name.clone()).collect();
    let x = Axis { names, ..Axis::linear("Lots, in the order of their names") };
    Panel::new(x, Axis::linear(&of.quantity), series).titled("Lot by lot")
}

/// Units in sequence, if lots are unknown.
fn in_order(of: &OfCoefficient, near: &[UnitDot]) -> Panel {
    let dots: Vec<(f64, UnitDot)> =
        near.iter().enumerate().map(|(place, unit)| (place as f64 + 1.0, *unit)).collect();
    let mut series = dots_of(&dots);
    series.push(mean_of(of));
    let x = Axis::linear("Devices, in the order of their names (1)");
    Panel::new(x, Axis::linear(&of.quantity), series).titled("Device by device")
}

fn dots_of(dots: &[(f64, UnitDot)]) -> Vec<Series> {
    let every = dots.len().div_ceil(DOTS).max(1);
    let belong = dots.iter().filter(|(_, unit)| !unit.is_odd).step_by(every);
    let belong = belong.map(|(x, unit)| (*x, unit.value)).collect();
    let label = if every == 1 { "estimates".to_owned() } else { format!("estimates, one of {every}") };
    let mut series = vec![Series::new(label, Ink::Measured, Shape::Points(belong))];
    let odd: Vec<(f64, f64)> =
        dots.iter().filter(|(_, unit)| unit.is_odd).map(|(x, unit)| (*x, unit.value)).collect();
    if !odd.is_empty() {
        series.push(Series::new("odd", Ink::Other, Shape::Points(odd)));
    }
    series
}

fn mean_of(of: &OfCoefficient) -> Series {
    Series::new("mean of the part", Ink::Predicted, Shape::Level(of.mean))
}

/// Parts of the variance of the estimates, with a panel for each of `coefficients`.
pub fn of_variance(title: &str, coefficients: &[(String, Vec<OfVariance>)]) -> Figure {
    let panel = |(name, axes): &(String, Vec<OfVariance>)| {
        let kinds = [("lots", Ink::Predicted), ("devices", Ink::Measured), ("error of a log", Ink::Bound)];
        let series = kinds.iter().enumerate().map(|(kind, (label, ink))| {
            let cells = axes.iter().enumerate().map(|(place, axis)| {
                let below: f64 = axis.shares[..kind].iter().sum();
                let x = place as f64;
                (x - 0.35, x + 0.35, 100.0 * below, 100.0 * (below + axis.shares[kind]))
            });
            Series::new(*label, *ink, Shape::Cells(cells.collect()))
        });
        let names = axes.iter().map(|axis| axis.name.clone()).collect();
        let y = Axis::linear("Share of the variance of estimates (%)");
        Panel::new(Axis { names, ..Axis::linear("") }, y, series).titled(name)
    };
    Figure { title: title.into(), panels: coefficients.iter().map(panel).collect() }
}

#[cfg(test)]
mod tests {
    use super::super::svg;
    use super::*;

    fn drawn(values: &[f64], lots: usize) -> OfCoefficient {
        let dot = |(place, value): (usize, &f64)| UnitDot {
            value: *value,
            lot: (lots > 0).then(|| place % lots.max(1)),
            is_odd: false,
        };
        let lot = |place| LotMean { name: format!("2026-W{place}"), mean: 0.0, interval: [-0.1, 0.1] };
        OfCoefficient {
            title: "gyro x: bias".into(),
            quantity: "Bias (dps)".into(),
            units: values.iter().enumerate().map(dot).collect(),
            lots: (0..lots).map(lot).collect(),
            mean: 0.0,
            scatter: 1.0,
            error: 0.1,
        }
    }

    #[test]
    fn histogram_counts_every_unit_and_reports_far_ones() {
        let figure = of_coefficient(&drawn(&[-1.0, -0.5, 0.0, 0.1, 0.2, 1.5, 40.0], 2));
        let Shape::Cells(bins) = &figure.panels[0].series[0].shape else { panic!("bins") };
        assert_eq!(bins.iter().map(|(.., count)| *count as usize).sum::<usize>(), 6);
        assert_eq!(figure.panels[0].title, "How 7 devices lie; 1 device lies beyond");
        assert!(svg(&figure).expect("drawn").contains("2026-W1"));
    }

    #[test]
    fn draws_degenerate_populations() {
        for (values, scatter) in [(&[0.0; 3][..], 0.0), (&[f64::NAN, 1.0, f64::INFINITY], 1.0), (&[], 1.0)] {
            for lots in [0, 2] {
                let of = OfCoefficient { scatter, error: 0.0, ..drawn(values, lots) };
                let picture = svg(&of_coefficient(&of)).expect("drawn");
                assert!(!picture.contains("NaN") && !picture.contains("inf"));
            }
        }
    }

    #[test]
    fn labels_as_many_lots_as_fit() {
        for (lots, named) in [(4, 4..5), (90, 9..16)] {
            let picture = svg(&of_coefficient(&drawn(&[0.0; 90], lots))).expect("drawn");
            let found = (0..lots).filter(|lot| picture.contains(&format!("2026-W{lot}\n"))).count();
            assert!(named.contains(&found), "{lots}: {found}");
        }
    }
}
