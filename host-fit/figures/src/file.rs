//! Figures as SVG and PNG, in memory and in files.

use std::path::Path;

use plotters::prelude::*;

use super::canvas::{Canvas, PIXELS_PER_UNIT};
use super::round_joins::RoundJoins;
use super::{Figure, draw};
use fos_data::file::{FileError, write_atomically};

/// A figure could not be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Error of the drawing or encoding library.
    #[error("could not draw the figure: {0}")]
    Draw(String),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] FileError),
}

/// A figure as an SVG document.
pub fn svg(figure: &Figure) -> Result<String, FigureError> {
    let (width, height) = size(figure);
    let mut document = String::new();
    paint(
        SVGBackend::with_string(&mut document, (width * PIXELS_PER_UNIT, height * PIXELS_PER_UNIT)),
        figure,
    )?;
    // The viewBox has the fine grid of the drawing, the size is that of the figure. Text is centred vertically as in the PNG,
    // independent of the letter height of the browser's font.
    let fine = |name: &str, length: u32| format!("{name}=\"{}\"", length * PIXELS_PER_UNIT);
    let plain = |name: &str, length: u32| format!("{name}=\"{length}\"");
    Ok(document
        .replacen(&fine("width", width), &plain("width", width), 1)
        .replacen(&fine("height", height), &plain("height", height), 1)
        .replace("dy=\"0.5ex\"", "dy=\"0.12em\""))
}

/// A figure as the bytes of a PNG file.
pub fn png(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    let (width, height) = size(figure);
    let fine = (width * PIXELS_PER_UNIT, height * PIXELS_PER_UNIT);
    let mut pixels = vec![0; 3 * fine.0 as usize * fine.1 as usize];
    paint(RoundJoins(BitMapBackend::with_buffer(&mut pixels, fine)), figure)?;

    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let refused = |error: png::EncodingError| FigureError::Draw(error.to_string());
    let mut writer = encoder.write_header().map_err(refused)?;
    writer.write_image_data(&averaged(&pixels, width as usize)).map_err(refused)?;
    writer.finish().map_err(refused)?;
    Ok(file)
}

/// Writes a figure as SVG atomically.
pub fn write_svg(figure: &Figure, path: &Path) -> Result<(), FigureError> {
    Ok(write_atomically(path, svg(figure)?.as_bytes())?)
}

/// Writes a figure as PNG atomically.
pub fn write_png(figure: &Figure, path: &Path) -> Result<(), FigureError> {
    Ok(write_atomically(path, &png(figure)?)?)
}

/// Width and height in units of length, which are the pixels of the PNG.
fn size(figure: &Figure) -> (u32, u32) {
    (draw::WIDTH as u32, draw::height(figure) as u32)
}

fn paint<DB: DrawingBackend>(backend: DB, figure: &Figure) -> Result<(), FigureError> {
    let area = backend.into_drawing_area();
    let drawn = draw::figure(&Canvas::new(&area), figure).and_then(|()| area.present());
    drawn.map_err(|error| FigureError::Draw(error.to_string()))
}

/// Averages squares of `PIXELS_PER_UNIT` pixels into one; rows of RGB, `width` pixels wide when done.
fn averaged(fine: &[u8], width: usize) -> Vec<u8> {
    let side = PIXELS_PER_UNIT as usize;
    let mut coarse = Vec::with_capacity(fine.len() / (side * side));
    let mut sums = vec![0u16; 3 * width];
    for rows in fine.chunks_exact(3 * width * side * side) {
        sums.fill(0);
        for row in rows.chunks_exact(3 * width * side) {
            for (sums, pixels) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * side)) {
                for (place, value) in pixels.iter().enumerate() {
                    sums[place % 3] += u16::from(*value);
                }
            }
        }
        coarse.extend(sums.iter().map(|sum| (sum / (side * side) as u16) as u8));
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Ink, Panel, Scale, Series, ShadedRange, Shading, Shape, Tone};
    use super::*;

    /// One series of every kind on the given axes.
    fn everything(values: &[(f64, f64)], scale: Scale) -> Figure {
        let axis = |label: &str| Axis { label: label.into(), scale, ..Axis::default() };
        let shapes = [
            ("band", Shape::Band(values.iter().map(|(x, y)| (*x, *y, 2.0 * y)).collect())),
            ("line", Shape::Line(values.to_vec())),
            ("points", Shape::Points(values.to_vec())),
            ("bars", Shape::Bars(values.iter().map(|(x, y)| (*x, *y, 0.5 * y, 2.0 * y)).collect())),
            ("stems", Shape::Stems(values.to_vec())),
            ("cells", Shape::Cells(values.iter().map(|(x, y)| (*x, 2.0 * x, *y, 2.0 * y)).collect())),
            ("frames", Shape::Frames(values.iter().map(|(x, y)| (*x, 2.0 * x, *y, 2.0 * y)).collect())),
            ("level", Shape::Level(values.first().map_or(0.0, |(_, y)| *y))),
        ];
        let series = shapes.map(|(label, shape)| Series::new(label, Ink::Measured, shape));
        let range = ShadedRange { from: 2.0, to: 3.0, mark: "17".into(), says: String::new() };
        let shading = vec![Shading { label: "shaded <&>".into(), tone: Tone::Apart, ranges: vec![range] }];
        let panel =
            Panel::new(axis("Time (s)"), axis("Rate (rad/s)"), series).titled("a panel").shaded(shading);
        Figure { title: "a figure".into(), panels: vec![panel.clone(), panel] }
    }

    fn decoded(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
        let mut reader = png::Decoder::new(bytes).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        (frame.width, frame.height, pixels)
    }

    #[test]
    fn svg_contains_every_label_and_no_nan() {
        let picture = svg(&everything(&[(1.0, 1.0), (2.0, f64::NAN), (4.0, 3.0)], Scale::Linear)).unwrap();
        for text in
            ["a figure", "a panel", "Time (s)", "Rate (rad/s)", "band", "line", "points", "bars", "stems"]
        {
            assert!(picture.contains(text), "{text}");
        }
        assert!(picture.contains("shaded &lt;&amp;&gt;") && picture.contains("17"));
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        assert!(picture.contains("width=\"1200\"") && picture.contains("viewBox=\"0 0 4800 "));
    }

    #[test]
    fn figure_from_json_is_drawn_alike() {
        for scale in [Scale::Linear, Scale::Log] {
            let figure = everything(&[(1.0, 1.0), (2.0, f64::NAN), (4.0, f64::INFINITY)], scale);
            let json = serde_json::to_string(&figure).unwrap();
            assert!(json.contains("null"), "not finite");
            assert_eq!(svg(&serde_json::from_str(&json).unwrap()).unwrap(), svg(&figure).unwrap());
        }
    }

    #[test]
    fn png_has_size_and_colours_of_the_figure() {
        let (width, height, pixels) =
            decoded(&png(&everything(&[(1.0, 1.0), (4.0, 3.0)], Scale::Log)).unwrap());
        assert_eq!((width, height), (1200, 748));
        // #0072B2, the colour of measurements, occurs at full strength.
        assert!(pixels.chunks_exact(3).any(|pixel| pixel == [0x00, 0x72, 0xB2]));
        assert_eq!(pixels[..3], [255; 3]);
    }

    #[test]
    fn draws_empty_constant_and_extreme_series() {
        let cases: [&[(f64, f64)]; 7] = [
            &[],
            &[(1.0, 1.0)],
            &[(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)],
            &[(0.0, 9.81); 5],
            &[(f64::NAN, f64::INFINITY), (f64::NEG_INFINITY, 1.0)],
            &[(-1.0, -1.0), (-2.0, -3.0)],
            &[(1e-300, 1e300), (1e300, -1e-300), (5e-324, 1.0)],
        ];
        for values in cases {
            for scale in [Scale::Linear, Scale::Log] {
                let figure = everything(values, scale);
                let picture = svg(&figure).unwrap();
                assert!(!picture.contains("NaN") && !picture.contains("inf"), "{values:?}");
                assert_eq!(decoded(&png(&figure).unwrap()).0, 1200);
            }
        }
        let no_panels = Figure { title: "nothing".into(), panels: vec![] };
        assert!(svg(&no_panels).is_ok() && png(&no_panels).is_ok());
    }

    #[test]
    fn file_is_replaced_atomically() {
        let folder = tempfile::tempdir().unwrap();
        let figure = everything(&[(1.0, 1.0), (4.0, 3.0)], Scale::Linear);
        for _ in 0..2 {
            write_svg(&figure, &folder.path().join("a.svg")).unwrap();
            write_png(&figure, &folder.path().join("a.png")).unwrap();
        }
        assert_eq!(std::fs::read_to_string(folder.path().join("a.svg")).unwrap(), svg(&figure).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn error_names_missing_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("a.svg");
        let error = write_svg(&Figure::default(), &path).unwrap_err();
        assert!(error.to_string().contains("missing"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
