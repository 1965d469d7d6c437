//! Meaning of a column, by its name: axis, unit, quantity, reference, label. Defined only here.
//!
//! | name | meaning |
//! |---|---|
//! | `t_s` | time, s |
//! | `ax_mps2` … `az_mps2`, `gx_rads` … `gz_rads` | measurement of an axis ([`AXES`]) |
//! | `ref_gx_rads`, … | its true value, where it is known ([`Column::reference`]) |
//! | `temp_c`, `supply_v`, `load_pct`, `mag_x_ut` … `mag_z_ut` | quantities that an error may depend on |
//! | `still`, `segment` | flags of a row ([`crate::recording`]) |
//! | `innovation_gx_rads`, `validity_gx_rads`, … | output of a model on a device ([`Column::is_of_model`]) |
//!
//! Any other column is a quantity of its own; the last part of its name states its unit ([`Unit::of_column`]).

use fos_core::{Axis, Quantity};

use crate::unit::Unit;

/// The accelerometers, x, y, z.
pub const ACCELEROMETERS: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];

pub const GYROS: [&str; 3] = ["gx_rads", "gy_rads", "gz_rads"];

/// The magnetometers, x, y, z.
pub const MAGNETOMETERS: [&str; 3] = ["mag_x_ut", "mag_y_ut", "mag_z_ut"];

/// The inertial channels, in the order used everywhere.
pub const AXES: [&str; 6] = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];

/// Prefix of the true value of an axis.
const REFERENCE: &str = "ref_";

/// Prefix of the innovation of an axis, from the telemetry of a device.
const INNOVATION: &str = "innovation_";

/// Prefix of the validity of an axis (flags on its corrected value), from the telemetry of a device.
const VALIDITY: &str = "validity_";

/// Three axes of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Triad {
    Accelerometers,
    Gyros,
}

impl Triad {
    /// Column names, x, y, z.
    pub fn columns(self) -> [&'static str; 3] {
        match self {
            Self::Accelerometers => ACCELEROMETERS,
            Self::Gyros => GYROS,
        }
    }
}

/// A column of a log, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column<'a>(&'a str);

impl<'a> Column<'a> {
    pub fn named(name: &'a str) -> Self {
        Self(name)
    }

    /// Triad of the axis, and its index: 0, 1, 2 for x, y, z. `None` for other columns.
    pub fn place(self) -> Option<(Triad, usize)> {
        [Triad::Accelerometers, Triad::Gyros].into_iter().find_map(|triad| {
            let index = triad.columns().iter().position(|column| *column == self.0)?;
            Some((triad, index))
        })
    }

    /// Axis in fos-core.
    pub fn axis(self) -> Axis {
        match self.place() {
            Some((Triad::Accelerometers, index)) => [Axis::Ax, Axis::Ay, Axis::Az][index],
            Some((Triad::Gyros, index)) => [Axis::Gx, Axis::Gy, Axis::Gz][index],
            None => Axis::Other,
        }
    }

    /// Quantity in fos-core from which an input is computed.
    pub fn quantity(self) -> Quantity {
        match self.0 {
            "temp_c" => Quantity::Temperature,
            "supply_v" => Quantity::Supply,
            "load_pct" => Quantity::Load,
            "mag_x_ut" => Quantity::MagneticX,
            "mag_y_ut" => Quantity::MagneticY,
            "mag_z_ut" => Quantity::MagneticZ,
            _ => match (self.axis(), self.measured().map(Self::axis)) {
                (Axis::Other, None | Some(Axis::Other)) => Quantity::Other,
                (Axis::Other, Some(axis)) => Quantity::Reference(axis),
                (axis, _) => Quantity::Measured(axis),
            },
        }
    }

    /// Unit stated by the name.
    pub fn unit(self) -> Unit {
        Unit::of_column(self.0)
    }

    /// Returns true for m/s²: an accelerometer, its reference, or one under another name.
    pub fn is_specific_force(self) -> bool {
        self.unit() == Unit::MetrePerSecondSquared
    }

    /// Returns true for rad/s.
    pub fn is_angular_rate(self) -> bool {
        self.unit() == Unit::RadianPerSecond
    }

    /// Name of the column with its true value.
    pub fn reference(self) -> String {
        format!("{REFERENCE}{}", self.0)
    }

    /// Column whose true value this one holds.
    pub fn measured(self) -> Option<Self> {
        self.0.strip_prefix(REFERENCE).map(Self)
    }

    /// Returns true for the output of a model in the telemetry of a device: neither measured nor a possible cause.
    pub fn is_of_model(self) -> bool {
        self.0.starts_with(INNOVATION) || self.0.starts_with(VALIDITY)
    }

    /// Name of the column with its innovation, from the telemetry of a device.
    pub fn innovation(self) -> String {
        format!("{INNOVATION}{}", self.0)
    }

    /// Name of the column with its validity, from the telemetry of a device.
    pub fn validity(self) -> String {
        format!("{VALIDITY}{}", self.0)
    }

    /// Everyday name, such as `gyro x`; the column name of other columns.
    pub fn label(self) -> &'a str {
        match self.place() {
            Some((Triad::Accelerometers, index)) => {
                ["accelerometer x", "accelerometer y", "accelerometer z"][index]
            }
            Some((Triad::Gyros, index)) => ["gyro x", "gyro y", "gyro z"][index],
            None => self.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classifies_columns_by_name() {
        let gyro = Column::named("gy_rads");
        assert_eq!(gyro.place(), Some((Triad::Gyros, 1)));
        assert_eq!((gyro.axis(), gyro.quantity()), (Axis::Gy, Quantity::Measured(Axis::Gy)));
        assert_eq!((gyro.unit(), gyro.label()), (Unit::RadianPerSecond, "gyro y"));
        let reference = gyro.reference();
        let reference = Column::named(&reference);
        assert_eq!((reference.axis(), reference.quantity()), (Axis::Other, Quantity::Reference(Axis::Gy)));
        assert_eq!(reference.measured(), Some(gyro));
        assert!(Column::named(&gyro.innovation()).is_of_model() && !reference.is_of_model());
        let other = Column::named("ref_wind_mps2");
        assert_eq!((other.axis(), other.quantity(), other.place()), (Axis::Other, Quantity::Other, None));
        assert!(other.is_specific_force() && !other.is_angular_rate());
        assert_eq!(other.label(), "ref_wind_mps2");
    }

    #[test]
    fn the_axes_are_the_two_triads() {
        assert_eq!(AXES[..3], ACCELEROMETERS);
        assert_eq!(AXES[3..], GYROS);
    }
}
