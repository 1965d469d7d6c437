//! Units of the numbers of an axis for people, in both systems.

use std::collections::BTreeMap;

use serde::Serialize;

use super::AxisSection;
use fos_diagnose::study::Refinement;
use fos_figures::units::{ErrorUnit, ShownUnit, Units};

/// Units of an axis for people; the page chooses between field units and SI.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AxisUnits {
    /// Measured values.
    pub measured: UnitChoice,
    /// Errors and residuals.
    pub errors: UnitChoice,
    /// Heading or position without aiding.
    pub unaided: UnitChoice,
    /// N, B and K.
    pub noise: [UnitChoice; 3],
    /// Coefficients of findings, by the unit they are stored in.
    pub sizes: BTreeMap<String, UnitChoice>,
}

/// A unit in both systems.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct UnitChoice {
    pub field: ShownUnit,
    pub si: ShownUnit,
}

impl UnitChoice {
    fn of<U: Into<ShownUnit>>(unit: impl Fn(Units) -> U) -> Self {
        Self { field: unit(Units::Field).into(), si: unit(Units::Si).into() }
    }
}

impl AxisUnits {
    pub fn of(section: &AxisSection) -> Self {
        let column = section.column.as_str();
        let errors = section.comparison.iter().flat_map(|comparison| &comparison.errors);
        let [field, si] = [Units::Field, Units::Si].map(|units| ShownUnit::of_noise(column, units));
        let found = section.diagnosis.iter().flat_map(|diagnosis| &diagnosis.findings);
        let added = section.refinement.iter().flat_map(Refinement::added).map(|added| &added.finding);
        let sizes = found
            .chain(added)
            .flat_map(|finding| &finding.sizes)
            .map(|size| (size.unit.clone(), UnitChoice::of(|units| ShownUnit::of_size(&size.unit, units))));
        let mut noise = field.into_iter().zip(si).map(|(field, si)| UnitChoice { field, si });
        Self {
            // the values of a turning gyro are large
            measured: UnitChoice::of(|units| ErrorUnit::of(column, f64::INFINITY, units)),
            errors: UnitChoice::of(|units| ErrorUnit::of_models(column, errors.clone(), units)),
            unaided: UnitChoice::of(|units| ShownUnit::of_unaided(column, units)),
            noise: std::array::from_fn(|_| noise.next().expect("three of each")),
            sizes: sizes.collect(),
        }
    }
}
