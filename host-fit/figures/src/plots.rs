//! Figures of a comparison, one set for each axis, and their files. Their data are computed in [`curves`]; their appearance is defined in
//! [`figures`].
//!
//! [`curves`]: crate::curves
//! [`figures`]: crate

use std::path::{Path, PathBuf};

use crate::compare::View;
use crate::curves::AxisCurves;
use crate::staircase::staircase;
use crate::{Figure, FigureError, Shading, write_png, write_svg};
use fos_data::escaping::in_file_name;
use fos_data::file::{check_output, make_folder};
use fos_diagnose::compare::Comparison;
use fos_diagnose::study::Refinement;

/// Writes the six figures of every axis into `folder`, each as SVG and PNG. `curves` has an entry for every axis; `moved` shades the
/// detected motion.
pub fn write_all(
    folder: &Path,
    comparison: &Comparison,
    curves: &[AxisCurves],
    moved: &Shading,
) -> Result<(), FigureError> {
    for (axis, curves) in comparison.axes.iter().zip(curves) {
        write(folder, &axis.column, &figures(View { axis, curves, moved }))?;
    }
    Ok(())
}

/// Writes the figure of the added effects of an axis into `folder`, as SVG and PNG.
pub fn write_staircase(folder: &Path, refinement: &Refinement) -> Result<(), FigureError> {
    write(folder, &refinement.column, &[(STAIRCASE, staircase(refinement))])
}

/// Writes figures of a column into `folder`, each as SVG and PNG, named by column and name.
pub fn write(folder: &Path, column: &str, figures: &[(&str, Figure)]) -> Result<(), FigureError> {
    check(folder, column, figures.iter().map(|(name, _)| *name))?;
    make_folder(folder)?;
    for (name, figure) in figures {
        let [svg, png] = paths(folder, column, name);
        write_svg(figure, &svg)?;
        write_png(figure, &png)?;
    }
    Ok(())
}

/// Checks that figures of these names can be written, before any is.
///
/// # Errors
///
/// A figure would replace an input file, or a path that is not a file.
pub fn check<'a>(
    folder: &Path,
    column: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Result<(), FigureError> {
    let mut paths = names.into_iter().flat_map(|name| paths(folder, column, name));
    Ok(paths.try_for_each(|path| check_output(&path))?)
}

fn paths(folder: &Path, column: &str, name: &str) -> [PathBuf; 2] {
    ["svg", "png"].map(|ending| folder.join(format!("{}_{name}.{ending}", in_file_name(column))))
}

/// Name of the figure in file names.
const STAIRCASE: &str = "staircase";

/// Checks that [`write_staircase`] can write its files, before a study is changed.
pub fn check_staircase(folder: &Path, column: &str) -> Result<(), FigureError> {
    check(folder, column, [STAIRCASE])
}

/// Figures of one axis with their names, without those for which the log is too short.
pub fn figures(view: View<'_>) -> Vec<(&'static str, Figure)> {
    let mut figures = vec![("1_over_time", view.over_time()), ("2_residual", view.residual())];
    figures.extend(view.autocorrelation().map(|figure| ("3_autocorrelation", figure)));
    figures.extend(view.spectrum().map(|figure| ("4_spectrum", figure)));
    figures.push(("5_allan", view.allan()));
    figures.extend(view.dependence().map(|figure| ("6_dependence", figure)));
    figures
}
