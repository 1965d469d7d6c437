//! Which channel a column seems to be, and in what unit: by its name, and where that leaves a choice, by its values.

use crate::column::{AXES, Column, MAGNETOMETERS};
use crate::statistics::median_of;
use crate::unit::{STANDARD_GRAVITY, parse_unit};

/// What a column seems to be.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guess {
    /// As in the log format, as `gx_rads`.
    pub(super) target: String,
    /// The unit, in a spelling that a column map takes; none for a channel without one.
    pub(super) unit: Option<&'static str>,
    /// What that rests on.
    pub(super) why: String,
    /// The name alone says so.
    pub(super) sure: bool,
}

/// What kind of quantity a name speaks of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Quantity {
    Time,
    Force(usize),
    Rate(usize),
    Field(usize),
    Temperature,
    Voltage,
    Load,
}

/// A guess for every column, none where it seems to be no channel; no channel is guessed twice.
pub(super) fn guesses(columns: &[(&str, &[f64])]) -> Vec<Option<Guess>> {
    let named: Vec<Option<Quantity>> = columns.iter().map(|(name, _)| quantity(name)).collect();
    let of_kind = |is: fn(&Quantity) -> bool| -> Vec<&[f64]> {
        let found = columns.iter().zip(&named).filter(|(_, quantity)| quantity.as_ref().is_some_and(is));
        found.map(|((_, values), _)| *values).collect()
    };
    let forces = of_kind(|quantity| matches!(quantity, Quantity::Force(_)));
    let rates = of_kind(|quantity| matches!(quantity, Quantity::Rate(_)));
    let mut taken: Vec<String> = Vec::new();
    let mut guesses: Vec<Option<Guess>> = vec![None; columns.len()];
    // names of the log format first: whatever else is there, they mean what they say
    for standard_only in [true, false] {
        for (place, (name, values)) in columns.iter().enumerate() {
            if guesses[place].is_some() || is_standard(name) != standard_only {
                continue;
            }
            let guess = match (is_standard(name), named[place]) {
                (true, _) => Some(Guess {
                    target: (*name).to_owned(),
                    unit: None,
                    why: "a name of the log format".to_owned(),
                    sure: true,
                }),
                (false, Some(quantity)) => Some(guess(name, quantity, values, &forces, &rates)),
                (false, None) => None,
            };
            guesses[place] = guess.filter(|guess| !taken.contains(&guess.target));
            taken.extend(guesses[place].iter().map(|guess| guess.target.clone()));
        }
    }
    guesses
}

fn is_standard(name: &str) -> bool {
    let column = Column::named(name);
    column.measured().unwrap_or(column).place().is_some()
        || ["t_s", "still", "segment", "temp_c", "supply_v", "load_pct"].contains(&name)
        || MAGNETOMETERS.contains(&name)
}

fn guess(name: &str, quantity: Quantity, values: &[f64], forces: &[&[f64]], rates: &[&[f64]]) -> Guess {
    let target = match quantity {
        Quantity::Time => "t_s".to_owned(),
        Quantity::Force(axis) => AXES[axis].to_owned(),
        Quantity::Rate(axis) => AXES[3 + axis].to_owned(),
        Quantity::Field(axis) => MAGNETOMETERS[axis].to_owned(),
        Quantity::Temperature => "temp_c".to_owned(),
        Quantity::Voltage => "supply_v".to_owned(),
        Quantity::Load => "load_pct".to_owned(),
    };
    if let Some(unit) = unit_in(name, &target) {
        return Guess { target, unit: Some(unit), why: "by its name".to_owned(), sure: true };
    }
    let by_values = match quantity {
        Quantity::Time => time_unit(values),
        // of one axis only a part of gravity is seen, so that nothing is said of fewer than three
        Quantity::Force(_) => forces.try_into().ok().and_then(force_unit),
        Quantity::Rate(_) => rate_unit(rates),
        Quantity::Temperature => temperature_unit(values),
        Quantity::Voltage => Some(if typical(values) > 100.0 { "mV" } else { "V" }),
        Quantity::Field(_) => Some("uT"),
        Quantity::Load => Some("%"),
    };
    match by_values {
        Some(unit) => Guess {
            target,
            unit: Some(unit),
            why: "the channel by its name, the unit by its values".to_owned(),
            sure: false,
        },
        None => Guess {
            target,
            unit: None,
            why: "by its name; its values fit no unit: raw counts need a scale".to_owned(),
            sure: false,
        },
    }
}

/// Words of a name: split at everything that is no letter or digit, and where a capital follows a small letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        let is_new = before.is_lowercase() && letter.is_uppercase();
        if !letter.is_alphanumeric() || is_new {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphanumeric()) {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

fn quantity(name: &str) -> Option<Quantity> {
    let words = words(name);
    let any = |starts: &[&str]| words.iter().any(|word| starts.iter().any(|start| word.starts_with(start)));
    let is = |names: &[&str]| words.iter().any(|word| names.contains(&word.as_str()));
    // the last letter that names an axis, alone or at the end of a word that names the sensor: gyroX, accx, gx, ax
    let letter_axis = |letter: Option<char>| ['x', 'y', 'z'].iter().position(|axis| Some(*axis) == letter);
    let alone =
        words.iter().find_map(|word| if word.len() == 1 { letter_axis(word.chars().next()) } else { None });
    let joined = |sensors: &[&str]| {
        words.iter().find_map(|word| {
            let axis = letter_axis(word.chars().last())?;
            sensors.contains(&&word[..word.len() - 1]).then_some(axis)
        })
    };
    const FORCES: [&str; 7] = ["a", "acc", "accel", "acceleration", "accelerometer", "la", "xl"];
    const RATES: [&str; 7] = ["g", "gyr", "gyro", "gyroscope", "w", "omega", "rate"];
    const FIELDS: [&str; 4] = ["m", "mag", "magnetometer", "b"];
    if let Some(axis) = joined(&FORCES).or(alone.filter(|_| any(&["acc", "accel", "linear"]))) {
        return Some(Quantity::Force(axis));
    }
    if let Some(axis) = joined(&RATES).or(alone.filter(|_| any(&["gyr", "omega", "angular"]))) {
        return Some(Quantity::Rate(axis));
    }
    if let Some(axis) = joined(&FIELDS).or(alone.filter(|_| any(&["mag"]))) {
        return Some(Quantity::Field(axis));
    }
    if any(&["temp", "thermo"]) {
        return Some(Quantity::Temperature);
    }
    if any(&["time", "stamp", "elapsed"]) || is(&["t", "ts", "sec", "secs", "seconds", "ms", "us", "ns"]) {
        return Some(Quantity::Time);
    }
    if any(&["supply", "volt", "vdd", "vbat", "vcc", "batt"]) {
        return Some(Quantity::Voltage);
    }
    if is(&["load", "cpu"]) {
        return Some(Quantity::Load);
    }
    None
}

/// A unit that stands in the name, in brackets or as its last words, if it is one of the target.
pub(super) fn unit_in(name: &str, target: &str) -> Option<&'static str> {
    let bracketed = name.split_once(['(', '[']).map(|(_, rest)| rest.trim_end_matches([')', ']']).trim());
    let lower = name.to_lowercase();
    let words = words(name);
    let last = words.last().map(String::as_str);
    let last_two = words.len().checked_sub(2).map(|from| words[from..].join("/"));
    let found = [bracketed.map(str::to_owned), last_two, last.map(str::to_owned)];
    found.into_iter().flatten().find_map(|text| {
        let spelling = match text.to_lowercase().as_str() {
            "sec" | "secs" | "seconds" | "s" => "s",
            "msec" | "millis" | "ms" => "ms",
            "usec" | "micros" | "us" | "µs" => "us",
            "nsec" | "nanos" | "ns" => "ns",
            "m/s2" | "m/s^2" | "m/s²" | "m/s/s" | "mps2" | "ms2" => "m/s2",
            // an axis letter g is no unit: gyro names hold it
            "g" if lower.contains("acc") => "g",
            "mgauss" | "mg" if target.starts_with("mag") => "mgauss",
            "mg" | "milli/g" => "mg",
            "rad/s" | "rads" | "rps" | "radps" => "rad/s",
            "deg/s" | "dps" | "°/s" | "degs" | "degps" => "dps",
            "mdps" => "mdps",
            "deg/h" | "dph" | "°/h" => "deg/h",
            "degc" | "°c" | "c" | "celsius" => "degC",
            "degf" | "°f" | "f" | "fahrenheit" => "degF",
            "k" | "kelvin" => "K",
            "mv" => "mV",
            "v" | "volt" | "volts" => "V",
            "ut" | "µt" => "uT",
            "mt" => "mT",
            "gauss" => "gauss",
            "pct" | "%" | "percent" => "%",
            _ => return None,
        };
        let (unit, _) = parse_unit(spelling)?;
        (unit == crate::unit::Unit::of_column(target)).then_some(spelling)
    })
}

/// Median of the magnitudes that are finite.
fn typical(values: &[f64]) -> f64 {
    let magnitudes = values.iter().filter(|value| value.is_finite()).map(|value| value.abs());
    median(magnitudes.collect())
}

/// Not a number of none: it lies in no range.
fn median(values: Vec<f64>) -> f64 {
    median_of(values).unwrap_or(f64::NAN)
}

fn steps(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| step.is_finite()).collect()
}

/// The unit in which the stamps come at 10 to 2000 a second.
fn time_unit(stamps: &[f64]) -> Option<&'static str> {
    let step = median(steps(stamps).into_iter().filter(|step| *step > 0.0).collect());
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]
        .into_iter()
        .find(|(_, seconds)| (5e-4..=0.1).contains(&(step * seconds)))
        .map(|(unit, _)| unit)
}

/// Gravity as a triad of accelerometers shows it, in their unit: what it measures most of the time; none of no rows.
pub(super) fn gravity(triad: [&[f64]; 3]) -> Option<f64> {
    let rows = triad.iter().map(|values| values.len()).min()?;
    let norm = |row: usize| triad.iter().map(|values| values[row] * values[row]).sum::<f64>().sqrt();
    median_of((0..rows).map(norm).filter(|norm| norm.is_finite()))
}

/// The unit in which what a triad measures is about gravity.
pub(super) fn force_unit(triad: [&[f64]; 3]) -> Option<&'static str> {
    let gravity = gravity(triad)?;
    let about = |one: f64| (0.7..1.4).contains(&(gravity / one));
    [("m/s2", STANDARD_GRAVITY), ("g", 1.0), ("mg", 1000.0)]
        .into_iter()
        .find(|(_, one)| about(*one))
        .map(|(unit, _)| unit)
}

/// The unit by the noise from one sample to the next: that of such gyros is 0.02 to 0.5 dps at 200 Hz.
fn rate_unit(triad: &[&[f64]]) -> Option<&'static str> {
    // of slow or coarse data most samples repeat the one before
    let changes = |values: &&[f64]| steps(values).into_iter().filter(|step| *step > 0.0).collect();
    let noise = median(triad.iter().map(|values| median(changes(values))).collect());
    match noise {
        noise if (2e-4..0.009).contains(&noise) => Some("rad/s"),
        noise if (0.009..2.0).contains(&noise) => Some("dps"),
        noise if (9.0..2000.0).contains(&noise) => Some("mdps"),
        _ => None,
    }
}

fn temperature_unit(values: &[f64]) -> Option<&'static str> {
    match typical(values) {
        middle if (0.0..95.0).contains(&middle) => Some("degC"),
        middle if (230.0..370.0).contains(&middle) => Some("K"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guessed(columns: &[(&str, Vec<f64>)]) -> Vec<Option<(String, Option<&'static str>, bool)>> {
        let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, v)| (*name, v.as_slice())).collect();
        guesses(&columns).into_iter().map(|guess| guess.map(|g| (g.target, g.unit, g.sure))).collect()
    }

    fn noise(size: f64, about: f64) -> Vec<f64> {
        (0..500).map(|n| about + size * f64::from((n * 7919) % 101 - 50) / 30.0).collect()
    }

    #[test]
    fn names_that_state_a_unit_are_taken_at_their_word() {
        for (name, target, unit) in [
            ("gyro_x [mdps]", "gx_rads", "mdps"),
            ("GyroY(dps)", "gy_rads", "dps"),
            ("gyr_z_dps", "gz_rads", "dps"),
            ("gx_dps", "gx_rads", "dps"),
            ("Gyroscope x (rad/s)", "gx_rads", "rad/s"),
            ("angular_velocity_z deg/s", "gz_rads", "dps"),
            ("acc_x_mg", "ax_mps2", "mg"),
            ("Acc_Y [g]", "ay_mps2", "g"),
            ("accelZ (m/s²)", "az_mps2", "m/s2"),
            ("time_us", "t_s", "us"),
            ("timestamp [ns]", "t_s", "ns"),
            ("Temperature (°F)", "temp_c", "degF"),
            ("mag_x_gauss", "mag_x_ut", "gauss"),
            ("vbat_mv", "supply_v", "mV"),
        ] {
            let found = guessed(&[(name, noise(1.0, 5.0))]);
            assert_eq!(found[0], Some((target.to_owned(), Some(unit), true)), "{name}");
        }
    }

    #[test]
    fn names_of_the_log_format_mean_what_they_say() {
        for name in ["t_s", "gx_rads", "ref_az_mps2", "still", "temp_c"] {
            assert_eq!(guessed(&[(name, noise(1.0, 0.0))])[0], Some((name.to_owned(), None, true)));
        }
        // and nothing else becomes the same channel
        let both = guessed(&[("gyro_x_dps", noise(1.0, 0.0)), ("gx_rads", noise(1.0, 0.0))]);
        assert_eq!(both[0], None);
    }

    #[test]
    fn values_tell_the_unit_where_the_name_does_not_and_that_is_not_sure() {
        let stamps = |step: f64| (0..500).map(|n| 1e6 + f64::from(n) * step).collect::<Vec<_>>();
        for (step, unit) in [(0.005, "s"), (5.0, "ms"), (5000.0, "us"), (5e6, "ns")] {
            let found = guessed(&[("time", stamps(step))]);
            assert_eq!(found[0], Some(("t_s".to_owned(), Some(unit), false)));
        }
        for (gravity, unit) in [(9.8, "m/s2"), (1.0, "g"), (1000.0, "mg")] {
            let still = |share: f64| noise(1e-3 * gravity, share * gravity);
            let found = guessed(&[("ax", still(0.6)), ("ay", still(0.0)), ("az", still(-0.8))]);
            assert!(
                found.iter().flatten().all(|(_, found, sure)| *found == Some(unit) && !sure),
                "{found:?}"
            );
        }
        for (size, unit) in [(0.002, "rad/s"), (0.1, "dps"), (100.0, "mdps")] {
            let found = guessed(&[("gyro_x", noise(size, 0.0))]);
            assert_eq!(found[0], Some(("gx_rads".to_owned(), Some(unit), false)));
        }
        let raw =
            guessed(&[("ax", noise(30.0, 4000.0)), ("ay", noise(30.0, 0.0)), ("az", noise(30.0, 8000.0))]);
        assert_eq!(raw[2], Some(("az_mps2".to_owned(), None, false)), "raw counts");
    }

    #[test]
    fn what_is_no_channel_is_left_alone() {
        for name in ["", "counter", "x", "label", "motor_current", "gps_lat"] {
            assert_eq!(guessed(&[(name, noise(1.0, 0.0))])[0], None, "{name}");
        }
    }
}
