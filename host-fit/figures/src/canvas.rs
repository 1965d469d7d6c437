//! Strokes and text of figures, on any plotters backend.

use std::sync::Once;

use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use fos_data::visible::visible;

/// Device pixels per unit of length. plotters places everything on whole pixels, which is coarse for thin lines, so figures are drawn
/// larger by this factor; the SVG states it in its viewBox, the PNG is averaged down.
pub(super) const PIXELS_PER_UNIT: u32 = 4;

/// Offset of plotters' texts above the vertical centre of their digits, in font sizes.
const CENTRING: f64 = 0.2;

/// Font family. The PNG has only Ubuntu Light, registered by this name; a browser takes the first available.
const FONT: &str = "Ubuntu, Helvetica Neue, Helvetica, Arial, sans-serif";

/// Result of a stroke, with the error of the backend.
pub(super) type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// A point on the canvas: units right and down from the upper left corner.
pub(super) type Point = (f64, f64);

/// Colour and opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Colour(pub(super) u32, pub(super) f64);

impl Colour {
    fn rgba(self) -> RGBAColor {
        let [_, red, green, blue] = self.0.to_be_bytes();
        RGBAColor(red, green, blue, self.1)
    }
}

/// Position of a text relative to its point; its digits are centred vertically.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

/// A drawing area in units of length, 1/96 inch on a screen.
pub(super) struct Canvas<'a, DB: DrawingBackend> {
    area: &'a DrawingArea<DB, Shift>,
}

impl<'a, DB: DrawingBackend> Canvas<'a, DB> {
    pub(super) fn new(area: &'a DrawingArea<DB, Shift>) -> Self {
        static FONT_REGISTERED: Once = Once::new();
        FONT_REGISTERED.call_once(|| {
            let is_font =
                plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
            assert!(is_font.is_ok(), "the built-in font is a font");
        });
        Canvas { area }
    }

    pub(super) fn clear(&self, colour: Colour) -> Drawn<DB> {
        self.area.fill(&colour.rgba())
    }

    pub(super) fn line(&self, points: &[Point], width: f64, colour: Colour) -> Drawn<DB> {
        if points.len() < 2 {
            return Ok(());
        }
        self.area.draw(&PathElement::new(pixels(points), colour.rgba().stroke_width(whole_pixels(width))))
    }

    /// A straight dashed line.
    pub(super) fn dashes(&self, from: Point, to: Point, width: f64, colour: Colour) -> Drawn<DB> {
        let (dash, gap) = (7.0, 4.0);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let along = |distance: f64| {
            let fraction = (distance / length).min(1.0);
            (from.0 + fraction * (to.0 - from.0), from.1 + fraction * (to.1 - from.1))
        };
        for piece in 0..(length / (dash + gap)).ceil() as usize {
            let start = piece as f64 * (dash + gap);
            self.line(&[along(start), along(start + dash)], width, colour)?;
        }
        Ok(())
    }

    pub(super) fn polygon(&self, points: &[Point], colour: Colour) -> Drawn<DB> {
        self.area.draw(&Polygon::new(pixels(points), colour.rgba()))
    }

    pub(super) fn rectangle(&self, upper_left: Point, lower_right: Point, colour: Colour) -> Drawn<DB> {
        let corners = [pixel(upper_left), pixel(lower_right)];
        self.area.draw(&Rectangle::new(corners, colour.rgba().filled()))
    }

    pub(super) fn dot(&self, centre: Point, radius: f64, colour: Colour) -> Drawn<DB> {
        self.area.draw(&Circle::new(pixel(centre), whole_pixels(radius), colour.rgba().filled()))
    }

    pub(super) fn text(&self, text: &str, at: Point, align: Align, size: f64, colour: Colour) -> Drawn<DB> {
        if text.is_empty() {
            return Ok(());
        }
        let horizontal = match align {
            Align::Left => HPos::Left,
            Align::Centre => HPos::Center,
            Align::Right => HPos::Right,
        };
        let text = &visible(text);
        let style = font(size).color(&colour.rgba()).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw_text(text, &style, pixel((at.0, at.1 + CENTRING * size)))
    }

    /// Width of a text, units of length.
    pub(super) fn text_width(&self, text: &str, size: f64) -> f64 {
        let width = font(size).layout_box(&visible(text)).map_or(0, |(low, high)| high.0 - low.0);
        f64::from(width) / f64::from(PIXELS_PER_UNIT)
    }
}

fn font(size: f64) -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FONT), size * f64::from(PIXELS_PER_UNIT), FontStyle::Normal)
}

fn pixel(point: Point) -> (i32, i32) {
    let whole = |units: f64| (units * f64::from(PIXELS_PER_UNIT)).round() as i32;
    (whole(point.0), whole(point.1))
}

fn pixels(points: &[Point]) -> Vec<(i32, i32)> {
    points.iter().copied().map(pixel).collect()
}

fn whole_pixels(length: f64) -> u32 {
    (length * f64::from(PIXELS_PER_UNIT)).round().max(1.0) as u32
}
