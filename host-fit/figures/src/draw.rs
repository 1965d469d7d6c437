//! Draws a figure; defines its appearance.

use plotters::prelude::DrawingBackend;

use super::canvas::{Align, Canvas, Colour, Drawn, Point};
use super::scale::{Extent, Tick};
use super::{Figure, Ink, Panel, Series, ShadedRange, Shading, Shape, Tone};

/// Width of every figure, units of length.
pub(super) const WIDTH: f64 = 1200.0;
/// Height of one of several panels, with its title, legend and axis labels.
const PANEL_HEIGHT: f64 = 340.0;
/// Height of a single panel.
const LONE_PANEL_HEIGHT: f64 = 420.0;
/// Room for the headline.
const HEADLINE: f64 = 56.0;
/// Room below the last panel.
const FOOT: f64 = 12.0;

/// Space around the axes of a panel: left beyond the tick labels, right, above, below.
const MARGIN: [f64; 4] = [34.0, 36.0, 58.0, 54.0];

const PAPER: Colour = Colour(0xFF_FF_FF, 1.0);
const TITLE: Colour = Colour(0x1B_1F_24, 1.0);
const TEXT: Colour = Colour(0x2F_35_3C, 1.0);
const AXIS: Colour = Colour(0x8B_93_9C, 1.0);
const GRID: Colour = Colour(0xE3_E6_EA, 1.0);
const SUBGRID: Colour = Colour(0xF1_F3_F5, 1.0);
const SHADE_MARK: Colour = Colour(0x8A_5F_00, 1.0);

const HEADLINE_SIZE: f64 = 22.0;
const TITLE_SIZE: f64 = 16.0;
const TEXT_SIZE: f64 = 14.0;

/// Width of the symbol before a text in the legend, with a gap on its left.
const KEY_WIDTH: f64 = 56.0;

/// Smallest gap between names below an axis.
const GAP_OF_NAMES: f64 = 12.0;

const LINE_WIDTH: f64 = 1.5;
const HAIRLINE: f64 = 0.75;

/// The other palette of Okabe and Ito, for comparing methods.
const METHODS: [u32; 7] =
    [0x00_72_B2, 0x56_B4_E9, 0x00_9E_73, 0xCC_79_A7, 0xE6_9F_00, 0xD5_5E_00, 0x22_22_22];

/// From Okabe and Ito's blue to vermilion, pale in the middle, and darker beyond.
const STEPS: [u32; 6] = [0x9C_C9_E6, 0xF1_F3_F5, 0xFC_E3_B8, 0xF2_AE_4E, 0xD5_5E_00, 0x7A_2E_00];

fn colour(ink: Ink) -> Colour {
    Colour(
        match ink {
            Ink::Measured => 0x00_72_B2,
            Ink::Predicted => 0xD5_5E_00,
            Ink::Residual => 0x00_9E_73,
            Ink::Floor => 0x22_22_22,
            Ink::Bound => 0x6B_72_7B,
            Ink::Other => 0xCC_79_A7,
            Ink::Step(number) => STEPS[number.min(STEPS.len() - 1)],
            Ink::Method(number) => METHODS[number % METHODS.len()],
        },
        1.0,
    )
}

fn background(tone: Tone) -> Colour {
    match tone {
        // Okabe–Ito orange, made transparent.
        Tone::Apart => Colour(0xE6_9F_00, 0.20),
        Tone::LeftOut => Colour(0x6B_72_7B, 0.30),
    }
}

/// Height of a figure, units of length.
pub(super) fn height(figure: &Figure) -> f64 {
    HEADLINE + panel_height(figure) * figure.panels.len() as f64 + FOOT
}

fn panel_height(figure: &Figure) -> f64 {
    if figure.panels.len() == 1 { LONE_PANEL_HEIGHT } else { PANEL_HEIGHT }
}

/// Draws a figure on a canvas of `WIDTH` × `height`.
pub(super) fn figure<DB: DrawingBackend>(canvas: &Canvas<DB>, figure: &Figure) -> Drawn<DB> {
    canvas.clear(PAPER)?;
    let plots: Vec<Plot> = figure
        .panels
        .iter()
        .enumerate()
        .map(|(place, panel)| {
            Plot::new(panel, HEADLINE + panel_height(figure) * place as f64, panel_height(figure))
        })
        .collect();
    // The widest tick label of all panels decides, so that their axes are aligned.
    let widest = plots
        .iter()
        .flat_map(|plot| plot.y.ticks(plot.y_ticks()))
        .filter_map(|tick| tick.label)
        .map(|label| canvas.text_width(&label, TEXT_SIZE))
        .fold(20.0, f64::max);
    canvas.text(&figure.title, (MARGIN[0] + widest, 32.0), Align::Left, HEADLINE_SIZE, TITLE)?;
    for mut plot in plots {
        plot.left = MARGIN[0] + widest;
        plot.draw(canvas)?;
    }
    Ok(())
}

/// A panel with its axes and position on the canvas.
struct Plot<'a> {
    panel: &'a Panel,
    x: Extent,
    y: Extent,
    is_empty: bool,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl<'a> Plot<'a> {
    fn new(panel: &'a Panel, upper_edge: f64, height: f64) -> Self {
        let points = || panel.series.iter().flat_map(|series| corners(&series.shape));
        let x = Extent::of(points().filter_map(|(x, _)| x), panel.x.scale, 0.01);
        let y = Extent::of(points().map(|(_, y)| y), panel.y.scale, 0.06);
        let nothing = |scale| Extent { low: 0.1, high: 1.0, scale };
        Plot {
            panel,
            is_empty: x.is_none() || y.is_none(),
            x: x.unwrap_or(nothing(panel.x.scale)),
            y: y.unwrap_or(nothing(panel.y.scale)),
            left: MARGIN[0],
            right: WIDTH - MARGIN[1],
            top: upper_edge + MARGIN[2],
            bottom: upper_edge + height - MARGIN[3],
        }
    }

    fn y_ticks(&self) -> usize {
        ((self.bottom - self.top) / 45.0) as usize
    }

    /// Position of a value on the canvas.
    fn place(&self, x: f64, y: f64) -> Option<Point> {
        Some((self.across(x)?, self.up(y)?))
    }

    fn across(&self, x: f64) -> Option<f64> {
        Some(self.left + self.x.position(x)? * (self.right - self.left))
    }

    fn up(&self, y: f64) -> Option<f64> {
        Some(self.bottom - self.y.position(y)? * (self.bottom - self.top))
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        canvas.text(&self.panel.title, (self.left, self.top - 42.0), Align::Left, TITLE_SIZE, TITLE)?;
        self.legend(canvas)?;
        self.labels(canvas)?;
        if !self.is_empty {
            self.grid(canvas)?;
        }
        self.shading(canvas)?;
        for series in &self.panel.series {
            self.shape(canvas, &series.shape, colour(series.ink))?;
        }
        canvas.line(&[(self.left, self.bottom), (self.right, self.bottom)], 1.0, AXIS)?;
        if self.is_empty {
            let middle = (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom));
            canvas.text("no data", middle, Align::Centre, TITLE_SIZE, TEXT)?;
        }
        Ok(())
    }

    fn labels<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        let below = (0.5 * (self.left + self.right), self.bottom + 37.0);
        canvas.text(&self.panel.x.label, below, Align::Centre, TEXT_SIZE, TEXT)?;
        canvas.text(&self.panel.y.label, (self.left, self.top - 17.0), Align::Left, TEXT_SIZE, TEXT)
    }

    /// Named values of the x axis, thinned out evenly if they do not all fit.
    fn named<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Vec<Tick> {
        let names = &self.panel.x.names;
        let widest = names.iter().map(|name| canvas.text_width(name, TEXT_SIZE)).fold(0.0, f64::max);
        let apart = match (self.across(0.0), self.across(1.0)) {
            (Some(first), Some(second)) if second > first => second - first,
            _ => f64::INFINITY,
        };
        let every = ((widest + GAP_OF_NAMES) / apart).ceil().max(1.0) as usize;
        let label = |place: usize, name: &String| place.is_multiple_of(every).then(|| name.clone());
        let tick = |(place, name)| Tick { value: place as f64, label: label(place, name) };
        let mut ticks: Vec<Tick> = names.iter().enumerate().map(tick).collect();
        ticks.sort_by_key(|tick| tick.label.is_some());
        ticks
    }

    fn grid<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        let shade = |tick: &Tick| if tick.label.is_some() { GRID } else { SUBGRID };
        // Subdivisions are drawn first, so that a fainter line never crosses a grid line.
        let named = self.named(canvas);
        let numbered = || self.x.ticks(((self.right - self.left) / 100.0) as usize);
        for tick in if named.is_empty() { numbered() } else { named } {
            let Some(x) = self.across(tick.value) else { continue };
            canvas.line(&[(x, self.top), (x, self.bottom)], HAIRLINE, shade(&tick))?;
            if let Some(label) = tick.label {
                canvas.line(&[(x, self.bottom), (x, self.bottom + 5.0)], 1.0, AXIS)?;
                canvas.text(&label, (x, self.bottom + 16.0), Align::Centre, TEXT_SIZE, TEXT)?;
            }
        }
        for tick in self.y.ticks(self.y_ticks()) {
            let Some(y) = self.up(tick.value) else { continue };
            canvas.line(&[(self.left, y), (self.right, y)], HAIRLINE, shade(&tick))?;
            if let Some(label) = tick.label {
                canvas.text(&label, (self.left - 9.0, y), Align::Right, TEXT_SIZE, TEXT)?;
            }
        }
        match self.up(0.0) {
            Some(zero) if self.y.low < 0.0 && self.y.high > 0.0 => {
                canvas.line(&[(self.left, zero), (self.right, zero)], HAIRLINE, AXIS)
            }
            _ => Ok(()),
        }
    }

    /// Shaded ranges that overlap the panel.
    fn shaded<'s>(&self, shading: &'s Shading) -> impl Iterator<Item = &'s ShadedRange> {
        let (low, high) = (self.x.low, self.x.high);
        shading.ranges.iter().filter(move |range| range.to >= low && range.from <= high)
    }

    fn shading<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        for shading in &self.panel.shading {
            for range in self.shaded(shading) {
                let (from, to) = (range.from.max(self.x.low), range.to.min(self.x.high));
                let (Some(from), Some(to)) = (self.across(from), self.across(to)) else { continue };
                // A range too short to be visible is widened about its middle.
                let (middle, half) = (0.5 * (from + to), (0.5 * (to - from)).max(1.5));
                let corners = ((middle - half, self.top), (middle + half, self.bottom));
                canvas.rectangle(corners.0, corners.1, background(shading.tone))?;
                canvas.text(&range.mark, (middle, self.top + 11.0), Align::Centre, TEXT_SIZE, SHADE_MARK)?;
            }
        }
        Ok(())
    }

    fn shape<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, shape: &Shape, ink: Colour) -> Drawn<DB> {
        match shape {
            Shape::Line(points) => self.polyline(canvas, points, ink),
            Shape::Band(edges) => {
                let places: Vec<Option<(Point, Point)>> = edges
                    .iter()
                    .map(|(x, low, high)| Some((self.place(*x, *low)?, self.place(*x, *high)?)))
                    .collect();
                for piece in unbroken(&places) {
                    let outline: Vec<Point> = piece
                        .iter()
                        .map(|edge| edge.1)
                        .chain(piece.iter().rev().map(|edge| edge.0))
                        .collect();
                    canvas.polygon(&outline, Colour(ink.0, 0.25))?;
                    canvas.line(&outline, HAIRLINE, Colour(ink.0, 0.4))?;
                }
                Ok(())
            }
            Shape::Points(points) => points
                .iter()
                .filter_map(|(x, y)| self.place(*x, *y))
                .try_for_each(|at| canvas.dot(at, 2.5, ink)),
            Shape::Stems(points) => {
                for (x, y) in points {
                    let (Some(foot), Some(tip)) = (self.place(*x, 0.0), self.place(*x, *y)) else { continue };
                    canvas.line(&[foot, tip], 1.0, ink)?;
                    canvas.dot(tip, 2.0, ink)?;
                }
                Ok(())
            }
            Shape::Bars(bars) => {
                let points: Vec<(f64, f64)> = bars.iter().map(|(x, y, ..)| (*x, *y)).collect();
                self.polyline(canvas, &points, ink)?;
                for (x, y, low, high) in bars {
                    let Some(at) = self.place(*x, *y) else { continue };
                    if let (Some(low), Some(high)) = (self.place(*x, *low), self.place(*x, *high)) {
                        canvas.line(&[low, high], 1.0, ink)?;
                        for end in [low, high] {
                            canvas.line(&[(end.0 - 3.5, end.1), (end.0 + 3.5, end.1)], 1.0, ink)?;
                        }
                    }
                    canvas.dot(at, 3.0, ink)?;
                }
                Ok(())
            }
            Shape::Cells(cells) => cells
                .iter()
                .filter_map(|cell| self.rectangle(cell))
                .try_for_each(|(upper_left, lower_right)| canvas.rectangle(upper_left, lower_right, ink)),
            Shape::Frames(frames) => {
                frames.iter().filter_map(|frame| self.rectangle(frame)).try_for_each(|(from, to)| {
                    let corners = [from, (to.0, from.1), to, (from.0, to.1), from];
                    canvas.line(&corners, LINE_WIDTH, ink)
                })
            }
            Shape::Level(y) => match (self.place(self.x.low, *y), self.place(self.x.high, *y)) {
                (Some(left), Some(right)) => canvas.dashes(left, right, 1.25, ink),
                _ => Ok(()),
            },
        }
    }

    /// Upper left and lower right corner of (left, right, low, high).
    fn rectangle(&self, (left, right, low, high): &(f64, f64, f64, f64)) -> Option<(Point, Point)> {
        Some((self.place(*left, *high)?, self.place(*right, *low)?))
    }

    fn polyline<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        points: &[(f64, f64)],
        ink: Colour,
    ) -> Drawn<DB> {
        let places: Vec<Option<Point>> = points.iter().map(|(x, y)| self.place(*x, *y)).collect();
        unbroken(&places).iter().try_for_each(|piece| canvas.line(piece, LINE_WIDTH, ink))
    }

    /// Draws the legend above the axes, beside the panel's title; continues beside the label of the y axis if one line is too short.
    fn legend<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        let mut entries: Vec<(&str, Key)> = Vec::new();
        for series in &self.panel.series {
            if !series.label.is_empty() && entries.iter().all(|(label, _)| *label != series.label) {
                entries.push((&series.label, Key::Series(series)));
            }
        }
        for shading in &self.panel.shading {
            if self.shaded(shading).next().is_some() {
                entries.push((&shading.label, Key::Shading(shading.tone)));
            }
        }
        let width = |label: &str| KEY_WIDTH + canvas.text_width(label, TEXT_SIZE);
        let room = self.right - self.left - canvas.text_width(&self.panel.title, TITLE_SIZE);
        let mut used = 0.0;
        let on_first_line = entries
            .iter()
            .take_while(|(label, _)| {
                used += width(label);
                used <= room
            })
            .count();
        let (first, second) = entries.split_at(on_first_line);
        for (line, y) in [(first, self.top - 42.0), (second, self.top - 22.0)] {
            let mut left = self.right - line.iter().map(|(label, _)| width(label)).sum::<f64>();
            for (label, key) in line {
                left += width(label);
                let text_left = left - canvas.text_width(label, TEXT_SIZE);
                key.draw(canvas, (text_left - 32.0, y), (text_left - 8.0, y))?;
                canvas.text(label, (text_left, y), Align::Left, TEXT_SIZE, TEXT)?;
            }
        }
        Ok(())
    }
}

/// Symbol before a text in the legend.
enum Key<'a> {
    Series(&'a Series),
    Shading(Tone),
}

impl Key<'_> {
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, from: Point, to: Point) -> Drawn<DB> {
        let patch = |colour| canvas.rectangle((from.0, from.1 - 6.0), (to.0, to.1 + 6.0), colour);
        let series = match self {
            Key::Series(series) => series,
            Key::Shading(tone) => return patch(background(*tone)),
        };
        let ink = colour(series.ink);
        let middle = (0.5 * (from.0 + to.0), from.1);
        match &series.shape {
            Shape::Band(_) => patch(Colour(ink.0, 0.35)),
            Shape::Cells(_) => patch(ink),
            Shape::Frames(_) => {
                let (low, high) = (from.1 - 6.0, from.1 + 6.0);
                let corners = [(from.0, low), (to.0, low), (to.0, high), (from.0, high), (from.0, low)];
                canvas.line(&corners, LINE_WIDTH, ink)
            }
            Shape::Level(_) => canvas.dashes(from, to, 1.25, ink),
            Shape::Line(_) => canvas.line(&[from, to], 2.0, ink),
            Shape::Points(_) | Shape::Stems(_) => canvas.dot(middle, 3.0, ink),
            Shape::Bars(_) => {
                canvas.line(&[from, to], 2.0, ink)?;
                canvas.dot(middle, 3.5, ink)
            }
        }
    }
}

/// All (x, y) that must be within the range of an axis; a level has no x.
fn corners(shape: &Shape) -> Vec<(Option<f64>, f64)> {
    match shape {
        Shape::Line(points) | Shape::Points(points) => points.iter().map(|(x, y)| (Some(*x), *y)).collect(),
        Shape::Stems(points) => points.iter().flat_map(|(x, y)| [(Some(*x), *y), (Some(*x), 0.0)]).collect(),
        Shape::Band(edges) => {
            edges.iter().flat_map(|(x, low, high)| [(Some(*x), *low), (Some(*x), *high)]).collect()
        }
        Shape::Bars(bars) => {
            bars.iter().flat_map(|(x, y, low, high)| [*y, *low, *high].map(|y| (Some(*x), y))).collect()
        }
        Shape::Level(y) => vec![(None, *y)],
        Shape::Cells(cells) | Shape::Frames(cells) => cells
            .iter()
            .flat_map(|(left, right, low, high)| [(Some(*left), *low), (Some(*right), *high)])
            .collect(),
    }
}

/// Runs of consecutive positions without a missing one.
fn unbroken<T: Copy>(places: &[Option<T>]) -> Vec<Vec<T>> {
    places
        .split(Option::is_none)
        .map(|run| run.iter().copied().flatten().collect())
        .filter(|run: &Vec<T>| !run.is_empty())
        .collect()
}
