//! Model in an image in the form of the host: the basis of a check of a log's columns.

use fos_core::{Axis, Image, Quantity};

use crate::model::{FittedAxis, FittedTerm, LoggedQuantity, NamedInput, UnitModel};

#[derive(Debug, thiserror::Error)]
#[error("{what} {index} of the image has no column of its own\nhelp: name the columns of the axes (`axes`)")]
pub struct NoColumn {
    /// `axis` or `quantity`.
    pub what: &'static str,
    /// Index in the model, from 0.
    pub index: usize,
}

/// Returns the column of an axis.
pub(super) fn column_of(axis: Axis) -> Option<&'static str> {
    match axis {
        Axis::Ax => Some("ax_mps2"),
        Axis::Ay => Some("ay_mps2"),
        Axis::Az => Some("az_mps2"),
        Axis::Gx => Some("gx_rads"),
        Axis::Gy => Some("gy_rads"),
        Axis::Gz => Some("gz_rads"),
        Axis::Other => None,
    }
}

/// Returns the model of an image, with the names of its columns; `axes`, unless empty, names its axes instead.
pub fn model_of(image: &Image<'_>, axes: &[String]) -> Result<UnitModel, NoColumn> {
    let terms = |terms: fos_core::image::Terms<'_>| -> Vec<FittedTerm> {
        terms
            .map(|term| FittedTerm {
                coefficient: f64::from(term.coefficient),
                standard_error: None,
                factors: term.factors().to_vec(),
            })
            .collect()
    };
    let named = image.axes().enumerate().map(|(index, axis)| {
        let column = match axes.get(index) {
            Some(column) => column.clone(),
            None => column_of(axis.parameters.axis).ok_or(NoColumn { what: "axis", index })?.to_owned(),
        };
        Ok(FittedAxis {
            column,
            parameters: axis.parameters.convert(),
            physical: terms(axis.physical),
            stochastic: terms(axis.stochastic),
            plain: None,
        })
    });
    let axes = named.collect::<Result<Vec<_>, NoColumn>>()?;
    let names: Vec<&str> = image.info().quantities.lines().collect();
    let quantities = image.quantities().enumerate().map(|(index, quantity): (usize, Quantity)| {
        let name = names.get(index).and_then(|line| line.split(' ').next()).filter(|name| !name.is_empty());
        let column = name.ok_or(NoColumn { what: "quantity", index })?.to_owned();
        Ok(LoggedQuantity { column, quantity })
    });
    Ok(UnitModel {
        period_s: image.period_s(),
        fitted_on: image.fitted_on(),
        stillness: image.stillness().map(|limits| limits.convert()),
        // that of a device: `Calibrated` applies it
        calibration: None,
        quantities: quantities.collect::<Result<Vec<_>, NoColumn>>()?,
        inputs: image
            .inputs()
            .enumerate()
            .map(|(index, input)| NamedInput { name: format!("u{index}"), input: input.convert() })
            .collect(),
        axes,
    })
}
