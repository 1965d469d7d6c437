//! Figures of a comparison, one set for each axis, and their files. Their data are computed in [`curves`]; their appearance is defined in
//! [`figures`].
//!
//! [`curves`]: crate::curves
//! [`figures`]: crate

use std::path::{Path, PathBuf};

use crate::compare::{
    SetApart, Subject, against, allan, measured_and_predicted, residual, residual_autocorrelation, spectra,
};
use crate::curves::{AgainstChannel, AxisCurves, Deviations, MEAN_S, Spectra};
use crate::dependence::dependence;
use crate::staircase::{Predicted, Tread, staircase};
use crate::{Figure, FigureError, Shading, write_png, write_svg};
use fos_data::column::Column;
use fos_data::escaping::in_file_name;
use fos_data::file::{FileError, check_output, make_folder};
use fos_diagnose::compare::{AxisComparison, Comparison};
use fos_diagnose::effects::Band;
use fos_diagnose::study::Refinement;

/// Label of the shaded stretches.
const WORST: &str = "worst stretches";

/// The figures could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The folder cannot be created.
    #[error(transparent)]
    Folder(#[from] FileError),
    /// A figure cannot be drawn or written.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// Writes the six figures of every axis into `folder`, each as SVG and PNG. `curves` has an entry for every axis; `moved` shades the
/// detected motion.
///
/// # Errors
///
/// The folder cannot be created, or a file in it cannot be written.
pub fn write_all(
    folder: &Path,
    comparison: &Comparison,
    curves: &[AxisCurves],
    moved: &Shading,
) -> Result<(), PlotError> {
    for (axis, curves) in comparison.axes.iter().zip(curves) {
        write(folder, &axis.column, &figures(View { axis, curves, moved }))?;
    }
    Ok(())
}

/// Writes the figure of the added effects of an axis into `folder`, as SVG and PNG.
///
/// # Errors
///
/// The folder cannot be created, or a file in it cannot be written.
pub fn write_staircase(folder: &Path, refinement: &Refinement) -> Result<(), PlotError> {
    write(folder, &refinement.column, &[(STAIRCASE, staircase_of(refinement))])
}

/// Figure of the remaining error after each added effect.
pub fn staircase_of(refinement: &Refinement) -> Figure {
    let mut steps: Vec<Tread> = Vec::new();
    for step in &refinement.steps {
        let before = steps.last().map(|step| (step.slow, step.wide));
        let predicted = step.added.as_ref().zip(before).and_then(|(added, (slow, wide))| {
            let finding = &added.finding;
            let is_wide = finding.band == Band::Wide;
            let left = |drop: f64| if is_wide { wide } else { slow } * (1.0 - drop).max(0.0).sqrt();
            let [low, high] = finding.predicted_reduction_interval;
            (finding.predicted_reduction > 0.0).then(|| Predicted {
                wide: is_wide,
                left: left(finding.predicted_reduction),
                interval: [left(high), left(low)],
            })
        });
        steps.push(Tread {
            name: step.errors.model.clone(),
            slow: step.left.slow.sqrt(),
            wide: step.left.wide.sqrt(),
            predicted,
            coast: step.errors.coast.iter().map(|coast| (coast.horizon_s, coast.mse.sqrt())).collect(),
        });
    }
    staircase(
        Column::named(&refinement.column).label(),
        Column::named(&refinement.column).unit().label(),
        &steps,
    )
}

/// Writes figures of a column into `folder`, each as SVG and PNG, named by column and name.
///
/// # Errors
///
/// The folder cannot be created, or a file in it cannot be written.
pub fn write(folder: &Path, column: &str, figures: &[(&str, Figure)]) -> Result<(), PlotError> {
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
) -> Result<(), PlotError> {
    let mut paths = names.into_iter().flat_map(|name| paths(folder, column, name));
    Ok(paths.try_for_each(|path| check_output(&path))?)
}

fn paths(folder: &Path, column: &str, name: &str) -> [PathBuf; 2] {
    ["svg", "png"].map(|ending| folder.join(format!("{}_{name}.{ending}", in_file_name(column))))
}

/// Name of the figure in file names.
const STAIRCASE: &str = "staircase";

/// Checks that [`write_staircase`] can write its files, before a study is changed.
///
/// # Errors
///
/// Errors of [`check`].
pub fn check_staircase(folder: &Path, column: &str) -> Result<(), PlotError> {
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

/// One axis of a comparison with its curves.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Errors, worst stretches, dependences.
    pub axis: &'a AxisComparison,
    /// Curves over all evaluated rows, or over a part of them.
    pub curves: &'a AxisCurves,
    /// Detected motion.
    pub moved: &'a Shading,
}

impl View<'_> {
    fn subject(&self) -> Subject<'_> {
        Subject { channel: Column::named(&self.axis.column).label(), unit: &self.axis.unit }
    }

    /// The worst stretches, the worst first, s.
    fn worst_s(&self) -> Vec<(f64, f64)> {
        self.axis.worst.iter().map(|stretch| (stretch.begin_s, stretch.end_s)).collect()
    }

    fn apart<'s>(&'s self, worst_s: &'s [(f64, f64)]) -> SetApart<'s> {
        SetApart { label: WORST, worst_s, moved: self.moved }
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

    /// Measurement and prediction over time.
    pub fn over_time(&self) -> Figure {
        let AxisCurves { measured, predicted, .. } = self.curves;
        let worst_s = self.worst_s();
        measured_and_predicted(self.subject(), measured, predicted, &mean_label(), self.apart(&worst_s))
    }

    /// Residual over time.
    pub fn residual(&self) -> Figure {
        let worst_s = self.worst_s();
        residual(self.subject(), &self.curves.left, &mean_label(), self.apart(&worst_s))
    }

    /// Autocorrelation of the innovations; none if there are too few.
    pub fn autocorrelation(&self) -> Option<Figure> {
        let correlation = self.curves.autocorrelation.as_ref()?;
        Some(residual_autocorrelation(self.subject(), correlation, self.curves.period_s))
    }

    /// Spectra of measurement, prediction and residual; none if the log is too short.
    pub fn spectrum(&self) -> Option<Figure> {
        let Spectra { measured, predicted, left, floor } = self.curves.spectra.as_ref()?;
        Some(spectra(self.subject(), measured, predicted, left, *floor))
    }

    /// Allan deviations of measurement, prediction and residual.
    pub fn allan(&self) -> Figure {
        let Deviations { measured, predicted, left } = &self.curves.deviations;
        allan(self.subject(), measured, predicted, left)
    }

    /// Dependence of the residual on every logged column, with the level explained by chance; none if it is unknown.
    pub fn dependence(&self) -> Option<Figure> {
        self.axis.dependence.as_ref().map(|found| dependence(self.subject(), found))
    }

    /// Residual against one channel.
    pub fn against(&self, found: AgainstChannel) -> Figure {
        let AgainstChannel { channel, block_s, usual, apart } = found;
        against(self.subject(), &channel, block_s, usual, apart)
    }
}

fn mean_label() -> String {
    format!("{MEAN_S} s mean")
}
