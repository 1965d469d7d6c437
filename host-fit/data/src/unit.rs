//! Units: the SI units a recording holds, and the units logs come in.

/// Unit of a channel once loaded. A recording holds nothing but these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Seconds.
    Second,
    /// Specific force, m/s².
    MetrePerSecondSquared,
    /// Angular rate, rad/s.
    RadianPerSecond,
    /// Temperature, °C.
    Celsius,
    /// Voltage, V.
    Volt,
    /// Magnetic flux density, µT.
    Microtesla,
    /// Pressure, Pa.
    Pascal,
    /// Percentage.
    Percent,
    /// Not stated by the column's name: the numbers are kept unchanged.
    Unstated,
}

impl Unit {
    /// The unit a column's name states by its last part: `gx_rads` is in rad/s, `temp_c` in °C.
    pub fn of_column(name: &str) -> Unit {
        match name.rsplit_once('_').map(|(_, suffix)| suffix) {
            Some("s") => Unit::Second,
            Some("mps2") => Unit::MetrePerSecondSquared,
            Some("rads") => Unit::RadianPerSecond,
            Some("c") => Unit::Celsius,
            Some("v") => Unit::Volt,
            Some("ut") => Unit::Microtesla,
            Some("pa") => Unit::Pascal,
            Some("pct") => Unit::Percent,
            _ => Unit::Unstated,
        }
    }

    /// Symbol for people; empty if the unit is not stated.
    pub fn label(self) -> &'static str {
        match self {
            Unit::MetrePerSecondSquared => "m/s²",
            Unit::Celsius => "°C",
            Unit::Microtesla => "µT",
            other => other.symbol(),
        }
    }

    /// Symbol in ASCII, for files; empty if the unit is not stated.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Second => "s",
            Unit::MetrePerSecondSquared => "m/s2",
            Unit::RadianPerSecond => "rad/s",
            Unit::Celsius => "degC",
            Unit::Volt => "V",
            Unit::Microtesla => "uT",
            Unit::Pascal => "Pa",
            Unit::Percent => "%",
            Unit::Unstated => "",
        }
    }
}

/// A straight line, `scale · x + offset`: how a cell becomes a value in the channel's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    pub(crate) scale: f64,
    /// Value of a cell that reads zero, in the unit of the result.
    pub(crate) offset: f64,
}

impl Affine {
    /// Keeps every number unchanged, to the last bit.
    pub(crate) const IDENTITY: Affine = Affine { scale: 1.0, offset: 0.0 };

    /// This line, and `next` applied to its result.
    pub(crate) fn then(self, next: Affine) -> Affine {
        Affine { scale: self.scale * next.scale, offset: self.offset * next.scale + next.offset }
    }

    /// Converts all `values` in place. A scale that is one over a whole number divides by it, which rounds once: a
    /// timestamp in µs, in ns and as a decimal of seconds becomes the same number.
    pub(crate) fn apply(self, values: &mut [f64]) {
        let divisor = (1.0 / self.scale).round();
        match self {
            Affine::IDENTITY => {}
            Affine { scale, offset } if 1.0 / divisor == scale => {
                values.iter_mut().for_each(|value| *value = *value / divisor + offset);
            }
            Affine { scale, offset } => {
                values.iter_mut().for_each(|value| *value = scale * *value + offset);
            }
        }
    }
}

/// Standard gravity, m/s² (BIPM, SI Brochure, 9th edition; exact by definition).
pub const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;

/// One mg, m/s².
pub const MG_MPS2: f64 = STANDARD_GRAVITY_MPS2 / 1000.0;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Spellings of a unit met in logs, the SI unit it converts to, and `scale`, `offset` of the conversion.
const KNOWN: &[(&[&str], Unit, f64, f64)] = &[
    (&["s"], Unit::Second, 1.0, 0.0),
    (&["ms"], Unit::Second, 1e-3, 0.0),
    (&["us", "µs"], Unit::Second, 1e-6, 0.0),
    (&["ns"], Unit::Second, 1e-9, 0.0),
    (&["m/s2", "m/s^2", "m/s²", "mps2"], Unit::MetrePerSecondSquared, 1.0, 0.0),
    (&["g"], Unit::MetrePerSecondSquared, STANDARD_GRAVITY_MPS2, 0.0),
    (&["mg"], Unit::MetrePerSecondSquared, MG_MPS2, 0.0),
    (&["rad/s", "rads"], Unit::RadianPerSecond, 1.0, 0.0),
    (&["mrad/s"], Unit::RadianPerSecond, 1e-3, 0.0),
    (&["deg/s", "dps", "°/s"], Unit::RadianPerSecond, DEGREE, 0.0),
    (&["mdps"], Unit::RadianPerSecond, DEGREE * 1e-3, 0.0),
    (&["deg/h", "dph", "°/h"], Unit::RadianPerSecond, DEGREE / 3600.0, 0.0),
    (&["degC", "°C", "C"], Unit::Celsius, 1.0, 0.0),
    (&["degF", "°F", "F"], Unit::Celsius, 5.0 / 9.0, -160.0 / 9.0),
    (&["K"], Unit::Celsius, 1.0, -273.15),
    (&["V"], Unit::Volt, 1.0, 0.0),
    (&["mV"], Unit::Volt, 1e-3, 0.0),
    (&["uT", "µT"], Unit::Microtesla, 1.0, 0.0),
    (&["mT"], Unit::Microtesla, 1e3, 0.0),
    (&["gauss", "Gauss"], Unit::Microtesla, 100.0, 0.0),
    (&["mgauss"], Unit::Microtesla, 0.1, 0.0),
    (&["Pa"], Unit::Pascal, 1.0, 0.0),
    (&["%"], Unit::Percent, 1.0, 0.0),
];

/// The SI unit that `spelling` converts to, and the conversion; `None` if it is not a unit known here.
pub(crate) fn parse_unit(spelling: &str) -> Option<(Unit, Affine)> {
    let (_, unit, scale, offset) = KNOWN.iter().find(|(names, ..)| names.contains(&spelling))?;
    Some((*unit, Affine { scale: *scale, offset: *offset }))
}

/// First spelling of every unit that converts to `unit`, `unit` itself first.
pub(crate) fn spellings_of(unit: Unit) -> Vec<&'static str> {
    KNOWN.iter().filter(|(_, other, ..)| *other == unit).map(|(names, ..)| names[0]).collect()
}

/// First spelling of every known unit, for messages and help.
pub(crate) fn known_units() -> String {
    KNOWN.iter().map(|(names, ..)| names[0]).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn convert(x: f64, spelling: &str) -> f64 {
        let mut values = [x];
        parse_unit(spelling).expect(spelling).1.apply(&mut values);
        values[0]
    }

    #[test]
    fn units_convert_to_known_values() {
        for (x, unit, expected) in [
            (1.0, "g", 9.80665),
            (1000.0, "mg", 9.80665),
            (180.0, "dps", std::f64::consts::PI),
            (180e3, "mdps", std::f64::consts::PI),
            (180.0 * 3600.0, "deg/h", std::f64::consts::PI),
            (212.0, "degF", 100.0),
            (-40.0, "degF", -40.0),
            (273.15, "K", 0.0),
            (2500.0, "ms", 2.5),
            (2500.0, "us", 2.5e-3),
            (2500.0, "ns", 2.5e-6),
            (3300.0, "mV", 3.3),
            (0.5, "gauss", 50.0),
            (0.05, "mT", 50.0),
        ] {
            // a few roundings of a 53-bit number
            assert!((convert(x, unit) - expected).abs() <= 1e-12 * expected.abs().max(10.0), "{x} {unit}");
        }
    }

    /// Shows that docs/columns-and-units.md lists every spelling in the row of its unit, and no other.
    #[test]
    fn the_page_of_units_has_every_spelling() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/columns-and-units.md");
        let Ok(page) = std::fs::read_to_string(page) else { return }; // the crate alone, as packaged
        let table = page.split("| to | spellings |").nth(1).unwrap().split("\n\n").next().unwrap();
        let rows = table.lines().filter_map(|line| line.strip_prefix("| ")?.split_once(" | "));
        let listed: Vec<(String, String)> = rows
            .flat_map(|(unit, cells)| {
                let cells = cells.split('`').skip(1).step_by(2);
                cells.map(|spelling| (unit.to_owned(), spelling.to_owned())).collect::<Vec<_>>()
            })
            .collect();
        let known = KNOWN.iter().flat_map(|(names, unit, ..)| names.iter().map(|name| (unit.label(), *name)));
        let known: Vec<(String, String)> =
            known.map(|(unit, name)| (unit.to_owned(), name.to_owned())).collect();
        for one in &known {
            assert!(listed.contains(one), "{one:?}");
        }
        assert_eq!(listed.len(), known.len());
    }

    #[test]
    fn timestamp_is_the_same_number_in_every_unit() {
        for (text, us) in
            [("0.3", 300_000.0), ("12.345678", 12_345_678.0), ("86399.999999", 86_399_999_999.0)]
        {
            let seconds: f64 = text.parse().unwrap();
            assert_eq!([convert(us, "us"), convert(us * 1000.0, "ns")], [seconds, seconds], "{text}");
        }
    }

    #[test]
    fn no_spelling_names_two_units() {
        let mut all: Vec<_> = KNOWN.iter().flat_map(|(names, ..)| names.iter()).collect();
        let n = all.len();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), n);
    }

    #[test]
    fn the_unit_of_a_column_is_read_from_its_suffix() {
        assert_eq!(Unit::of_column("ref_gx_rads"), Unit::RadianPerSecond);
        assert_eq!(Unit::of_column("temp_c"), Unit::Celsius);
        assert_eq!(Unit::of_column("press_pa"), Unit::Pascal);
        assert_eq!(Unit::of_column("gx_dps"), Unit::Unstated);
        assert_eq!(Unit::of_column("still"), Unit::Unstated);
    }
}
