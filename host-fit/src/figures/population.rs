//! The figures of a population: how units lie about it, their lots in order, and of what their differences are made.

use statrs::distribution::{Continuous, Normal};

use super::{Axis, Figure, Ink, Panel, Series, Shape};

/// A unit's estimate of a coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitDot {
    /// In the unit of the coefficient.
    pub value: f64,
    /// The place of its lot among the lots.
    pub lot: Option<usize>,
    /// It does not belong.
    pub is_odd: bool,
}

/// What is known of a lot's mean.
#[derive(Debug, Clone, PartialEq)]
pub struct LotMean {
    /// Its name.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Its 90 % interval.
    pub interval: [f64; 2],
}

/// A coefficient of an axis, over the units of a part; all in one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct OfCoefficient {
    /// As in `gyro x: bias`.
    pub title: String,
    /// Quantity and unit, as under an axis.
    pub quantity: String,
    /// In the order of their lots and names.
    pub units: Vec<UnitDot>,
    /// In their order; empty where no lot is named.
    pub lots: Vec<LotMean>,
    /// Mean of the part.
    pub mean: f64,
    /// Standard deviation of units about it, lots included.
    pub scatter: f64,
    /// Standard deviation of an estimate about its unit.
    pub error: f64,
}

/// Shares of the variance of estimates.
#[derive(Debug, Clone, PartialEq)]
pub struct OfVariance {
    /// As under an axis.
    pub name: String,
    /// Lots, units, error of a log; they add up to 1.
    pub shares: [f64; 3],
}

/// What is further off, in standard deviations of the estimates, is left out: nothing else could be told apart.
const FURTHEST: f64 = 12.0;

/// Units that are drawn at most; of more, every so-manieth.
const DOTS: usize = 500;

/// Bins of a histogram at most.
const MOST_BINS: f64 = 200.0;

/// Estimates as a histogram beside the population, and lot by lot.
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
    // half as wide as is best for a normal distribution (Scott 1979): the curve beside it is smooth enough
    let width = (1.75 * seen * n.powf(-1.0 / 3.0)).max((high - low) / MOST_BINS);
    let width = if width.is_normal() { width } else { 1.0 };
    let mut series = Vec::new();
    // bins as (number of the bin, units that belong, odd ones); the odd ones stand on the others
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
            series.push(Series { label: label.into(), ink, shape: Shape::Cells(cells) });
        }
    }
    let belonging = near.iter().filter(|unit| !unit.is_odd).count() as f64;
    // a curve much narrower than a bin is a needle above all else
    for (label, ink, deviation) in
        [("devices and the error of a log", Ink::Bound, seen), ("devices", Ink::Predicted, of.scatter)]
    {
        if let Ok(normal) = Normal::new(of.mean, deviation)
            && deviation > 0.3 * width
        {
            let at = |place: i32| of.mean + 3.3 * deviation * f64::from(place) / 100.0;
            let curve = (-100..=100).map(|place| (at(place), belonging * width * normal.pdf(at(place))));
            series.push(Series { label: label.into(), ink, shape: Shape::Line(curve.collect()) });
        }
    }
    Panel {
        title: format!("How {} devices lie{beyond}", of.units.len()),
        x: Axis::linear(of.quantity.clone()),
        y: Axis::linear("Devices in a bin (1)"),
        series,
        ..Panel::default()
    }
}

/// Units about the means of their lots.
fn by_lot(of: &OfCoefficient, near: &[UnitDot]) -> Panel {
    let mut dots: Vec<(f64, UnitDot)> = Vec::new();
    for lot in 0..of.lots.len() {
        let units: Vec<&UnitDot> = near.iter().filter(|unit| unit.lot == Some(lot)).collect();
        // side by side in the order of their names, within three fifths of the lot's room
        let across = |place: usize| 0.6 * ((place as f64 + 0.5) / units.len() as f64 - 0.5);
        dots.extend(units.iter().enumerate().map(|(place, unit)| (lot as f64 + across(place), **unit)));
    }
    let mut series = dots_of(&dots);
    // each lot of its own: nothing lies between them
    series.extend(of.lots.iter().enumerate().map(|(place, lot)| Series {
        label: "mean of the lot, 90 %".into(),
        ink: Ink::Floor,
        shape: Shape::Bars(vec![(place as f64, lot.mean, lot.interval[0], lot.interval[1])]),
    }));
    series.push(mean_of(of));
    let names = of.lots.iter().map(|lot| lot.name.clone()).collect();
    Panel {
        title: "Lot by lot".into(),
        x: Axis { names, ..Axis::linear("Lots, in the order of their names") },
        y: Axis::linear(of.quantity.clone()),
        series,
        ..Panel::default()
    }
}

/// Units one after the other, where no lots are known.
fn in_order(of: &OfCoefficient, near: &[UnitDot]) -> Panel {
    let dots: Vec<(f64, UnitDot)> =
        near.iter().enumerate().map(|(place, unit)| (place as f64 + 1.0, *unit)).collect();
    let mut series = dots_of(&dots);
    series.push(mean_of(of));
    Panel {
        title: "Device by device".into(),
        x: Axis::linear("Devices, in the order of their names (1)"),
        y: Axis::linear(of.quantity.clone()),
        series,
        ..Panel::default()
    }
}

fn dots_of(dots: &[(f64, UnitDot)]) -> Vec<Series> {
    let every = dots.len().div_ceil(DOTS).max(1);
    let belong = dots.iter().filter(|(_, unit)| !unit.is_odd).step_by(every);
    let belong = belong.map(|(x, unit)| (*x, unit.value)).collect();
    let label = if every == 1 { "estimates".to_owned() } else { format!("estimates, one of {every}") };
    let mut series = vec![Series { label, ink: Ink::Measured, shape: Shape::Points(belong) }];
    let odd: Vec<(f64, f64)> =
        dots.iter().filter(|(_, unit)| unit.is_odd).map(|(x, unit)| (*x, unit.value)).collect();
    if !odd.is_empty() {
        series.push(Series { label: "odd".into(), ink: Ink::Other, shape: Shape::Points(odd) });
    }
    series
}

fn mean_of(of: &OfCoefficient) -> Series {
    Series { label: "mean of the part".into(), ink: Ink::Predicted, shape: Shape::Level(of.mean) }
}

/// Of what the differences of estimates are made, a panel for each of `coefficients`.
pub fn of_variance(title: &str, coefficients: &[(String, Vec<OfVariance>)]) -> Figure {
    let panel = |(name, axes): &(String, Vec<OfVariance>)| {
        let kinds = [("lots", Ink::Predicted), ("devices", Ink::Measured), ("error of a log", Ink::Bound)];
        let series = kinds.iter().enumerate().map(|(kind, (label, ink))| {
            let cells = axes.iter().enumerate().map(|(place, axis)| {
                let below: f64 = axis.shares[..kind].iter().sum();
                let x = place as f64;
                (x - 0.35, x + 0.35, 100.0 * below, 100.0 * (below + axis.shares[kind]))
            });
            Series { label: (*label).into(), ink: *ink, shape: Shape::Cells(cells.collect()) }
        });
        let names = axes.iter().map(|axis| axis.name.clone()).collect();
        Panel {
            title: name.clone(),
            x: Axis { names, ..Axis::linear("") },
            y: Axis::linear("Share of the variance of estimates (%)"),
            series: series.collect(),
            ..Panel::default()
        }
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
    fn every_unit_is_in_the_histogram_and_one_far_beyond_is_told() {
        let figure = of_coefficient(&drawn(&[-1.0, -0.5, 0.0, 0.1, 0.2, 1.5, 40.0], 2));
        let Shape::Cells(bins) = &figure.panels[0].series[0].shape else { panic!("bins") };
        assert_eq!(bins.iter().map(|(.., count)| *count as usize).sum::<usize>(), 6);
        assert_eq!(figure.panels[0].title, "How 7 devices lie; 1 device lies beyond");
        assert!(svg(&figure).expect("drawn").contains("2026-W1"));
    }

    #[test]
    fn what_has_no_width_no_number_or_no_unit_is_drawn_all_the_same() {
        for (values, scatter) in [(&[0.0; 3][..], 0.0), (&[f64::NAN, 1.0, f64::INFINITY], 1.0), (&[], 1.0)] {
            for lots in [0, 2] {
                let of = OfCoefficient { scatter, error: 0.0, ..drawn(values, lots) };
                let picture = svg(&of_coefficient(&of)).expect("drawn");
                assert!(!picture.contains("NaN") && !picture.contains("inf"));
            }
        }
    }

    #[test]
    fn of_many_lots_as_many_are_named_as_have_room() {
        for (lots, named) in [(4, 4..5), (90, 9..16)] {
            let picture = svg(&of_coefficient(&drawn(&[0.0; 90], lots))).expect("drawn");
            let found = (0..lots).filter(|lot| picture.contains(&format!("2026-W{lot}\n"))).count();
            assert!(named.contains(&found), "{lots}: {found}");
        }
    }
}
