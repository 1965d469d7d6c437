//! Panels of the dependence of the residual on the logged columns.

use super::{Axis, Ink, Panel, Series, Shape, with_unit};
use fos_diagnose::dependence::{Bin, Cell, ChannelDependence, Dependence, PowerMap};

/// Maximum number of channels: those with a dependence and all temperatures, at least the most probable one.
const DRAWN: usize = 4;

/// Position of a delay of 0, which a logarithmic axis lacks, s.
const NO_DELAY_AT: f64 = 0.3;

/// 95 % point of χ²₁: gain of one coefficient by chance.
const CHANCE: f64 = 3.84;

/// Upper ends of the steps of the map, relative to the usual power.
const STEPS: [(f64, &str); 6] = [
    (0.5, "below ½"),
    (1.5, "usual"),
    (2.0, "1.5–2 times"),
    (4.0, "2–4 times"),
    (8.0, "4–8 times"),
    (f64::INFINITY, "above 8 times"),
];

/// Residual, in `unit`, against channels, their delays, time and frequency.
pub fn panels(unit: &str, found: &Dependence) -> Vec<Panel> {
    let drawn: Vec<&ChannelDependence> = found
        .channels
        .iter()
        .enumerate()
        .filter(|(place, channel)| *place == 0 || channel.is_clear() || !channel.bins.rising.is_empty())
        .map(|(_, channel)| channel)
        .take(DRAWN)
        .collect();
    let mut panels: Vec<Panel> = drawn.iter().map(|channel| against(unit, channel)).collect();
    panels.push(delays(&drawn));
    panels.push(map(&found.power));
    panels
}

fn against(unit: &str, channel: &ChannelDependence) -> Panel {
    let bars = |label: &str, ink, bins: &[Bin]| {
        let bar =
            |bin: &Bin| (bin.channel, bin.level, bin.level - bin.half_width, bin.level + bin.half_width);
        Series::new(label, ink, Shape::Bars(bins.iter().map(bar).collect()))
    };
    let bins = &channel.bins;
    let series = match bins.rising.is_empty() && bins.falling.is_empty() {
        true => vec![bars("residual, 95 %", Ink::Residual, &bins.all)],
        false => vec![
            bars("all, 95 %", Ink::Residual, &bins.all),
            bars("rising", Ink::Predicted, &bins.rising),
            bars("falling", Ink::Measured, &bins.falling),
        ],
    };
    let verdict = if channel.is_clear() { "depends" } else { "no more than chance" };
    let (name, p, score) = (&channel.channel, probability(channel.p_of_all), channel.curve.score);
    let y = Axis::linear(format!("Slow residual less its mean ({unit})"));
    Panel::new(Axis::linear(with_unit(name, &channel.unit)), y, series)
        .titled(format!("{name}: {verdict}, {p}, score {score:.1}"))
}

fn delays(channels: &[&ChannelDependence]) -> Panel {
    let profile = |(number, channel): (usize, &&ChannelDependence)| {
        let points = channel.lag.delays.iter().map(|delay| (delay.delay_s.max(NO_DELAY_AT), delay.gain));
        let points: Vec<(f64, f64)> = points.collect();
        let ink = Ink::Method(number);
        [
            Series::new(&channel.channel, ink, Shape::Line(points.clone())),
            Series::new(&channel.channel, ink, Shape::Points(points)),
        ]
    };
    let chance = Series::new("chance, 95 %", Ink::Bound, Shape::Level(CHANCE));
    let series = [chance].into_iter().chain(channels.iter().enumerate().flat_map(profile));
    let y = Axis::linear("Gain of a linear term, 2 Δln L (1)");
    Panel::new(Axis::log("Delay of the channel (s)"), y, series)
        .titled("Which delay explains most; leftmost: none")
}

fn map(power: &PowerMap) -> Panel {
    let corners = |cell: &Cell| (cell.begin_s, cell.end_s, cell.low_hz, cell.high_hz);
    let step = |cell: &Cell| STEPS.iter().position(|(end, _)| cell.times < *end).unwrap_or(STEPS.len() - 1);
    let mut series: Vec<Series> = STEPS
        .iter()
        .enumerate()
        .map(|(number, (_, label))| {
            let cells = power.cells.iter().filter(|cell| step(cell) == number).map(corners).collect();
            Series::new(*label, Ink::Step(number), Shape::Cells(cells))
        })
        .collect();
    let worst: Vec<_> = power.worst().into_iter().map(corners).collect();
    if !worst.is_empty() {
        series.push(Series::new("beyond chance", Ink::Floor, Shape::Frames(worst)));
    }
    Panel::new(Axis::linear("Time (s)"), Axis::log("Frequency (Hz)"), series)
        .titled("Power over that of the median stretch")
}

fn probability(p: f64) -> String {
    match p {
        p if p < 1e-10 => "p < 1e−10".to_owned(),
        p if p < 0.01 => format!("p = {p:.0e}").replace('-', "−"),
        p => format!("p = {p:.2}"),
    }
}
