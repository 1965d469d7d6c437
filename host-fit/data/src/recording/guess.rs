//! Guesses the channel and unit of a column: by its name, and where that is ambiguous, by its values.

use super::column_map::quoted;
use super::column_words::{self, Named, Quantity, unit_in};
use crate::column::{AXES, Column, MAGNETOMETERS};
use crate::statistics::median_of;
use crate::unit::{STANDARD_GRAVITY_MPS2, parse_unit};

/// Probable channel of a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guess {
    /// Channel in the log format, such as `gx_rads`.
    pub(super) target: String,
    /// Unit, in a spelling accepted by a column map; `None` for a channel without one.
    pub(super) unit: Option<&'static str>,
    pub(super) why: String,
    /// True if the name alone determines it.
    pub(super) sure: bool,
    /// Column map entries of worse candidates for the same channel, best first.
    pub(super) others: Vec<String>,
}

/// Probable channels of the columns of a table.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Guesses {
    /// One per column, `None` if it seems to be no channel; no channel is guessed twice.
    pub(super) columns: Vec<Option<Guess>>,
    /// Channels without a guess, since several candidates are equally good.
    pub(super) undecided: Vec<Undecided>,
}

/// Channels with several equally good candidates that differ, or that only a mix of sensors would fill.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Undecided {
    /// Channels in the log format, such as `gx_rads`.
    pub(super) targets: Vec<String>,
    /// Column map entries, grouped by sensor.
    pub(super) choices: Vec<Vec<String>>,
}

/// A column that may be a channel.
struct Candidate {
    /// Index in the table.
    at: usize,
    named: Named,
    target: &'static str,
    unit: Option<&'static str>,
    sure: bool,
}

/// Guesses for all columns, independent of their order: by the rank of their names, and within a rank by the names
/// themselves if they hold the same data.
pub(super) fn guesses(columns: &[(&str, &[f64])]) -> Guesses {
    let mut guesses = Guesses { columns: vec![None; columns.len()], ..Guesses::default() };
    // names of the log format first: their meaning is fixed whatever other columns exist
    let mut taken: Vec<&str> = Vec::new();
    for (guess, (name, _)) in
        guesses.columns.iter_mut().zip(columns).filter(|(_, (name, _))| is_standard(name))
    {
        let (target, why) = ((*name).to_owned(), "a name of the log format".to_owned());
        *guess = Some(Guess { target, unit: None, why, sure: true, others: Vec::new() });
        taken.push(name);
    }
    let mut named: Vec<(usize, Named)> = columns
        .iter()
        .enumerate()
        .filter(|(_, (name, _))| !is_standard(name))
        .filter_map(|(at, (name, _))| Some((at, column_words::named(name)?)))
        .filter(|(_, named)| !taken.contains(&target_of(named.quantity)))
        .collect();
    // then stated units, then by name, so that the order of the file has no influence
    named.sort_by_key(|(at, named)| {
        let name = columns[*at].0;
        (named.rank, unit_in(name, target_of(named.quantity)).is_none(), name)
    });
    let mut numbers = Vec::new();
    for kind in [is_force, is_rate, is_field] {
        numbers.push(guesses.choose_sensor(columns, named.iter().filter(|(_, named)| kind(named.quantity))));
    }
    if let [Some(forces), Some(rates), _] = &numbers[..]
        && !forces.is_empty()
        && !rates.is_empty()
        && forces != rates
    {
        guesses.withdraw_axes(columns);
    }
    for quantity in [Quantity::Time, Quantity::Temperature, Quantity::Voltage, Quantity::Load] {
        guesses.choose_column(columns, named.iter().filter(|(_, named)| named.quantity == quantity));
    }
    guesses
}

fn is_standard(name: &str) -> bool {
    let column = Column::named(name);
    column.measured().unwrap_or(column).place().is_some()
        || ["t_s", "still", "segment", "temp_c", "supply_v", "load_pct"].contains(&name)
        || MAGNETOMETERS.contains(&name)
}

fn is_force(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::Force(_))
}

fn is_rate(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::Rate(_))
}

fn is_field(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::Field(_))
}

fn target_of(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "t_s",
        Quantity::Force(axis) => AXES[axis],
        Quantity::Rate(axis) => AXES[3 + axis],
        Quantity::Field(axis) => MAGNETOMETERS[axis],
        Quantity::Temperature => "temp_c",
        Quantity::Voltage => "supply_v",
        Quantity::Load => "load_pct",
    }
}

impl Guesses {
    /// Chooses the sensor whose columns form a triad: all axes of one, never some of each. Returns the numbers in the
    /// name of the chosen one.
    fn choose_sensor<'a>(
        &mut self,
        columns: &[(&str, &[f64])],
        named: impl Iterator<Item = &'a (usize, Named)>,
    ) -> Option<Vec<u32>> {
        let mut sensors: Vec<Vec<&(usize, Named)>> = Vec::new();
        for column in named {
            match sensors.iter_mut().find(|sensor| sensor[0].1.sensor == column.1.sensor) {
                Some(sensor) => sensor.push(column),
                None => sensors.push(vec![column]),
            }
        }
        let sensors: Vec<Vec<Candidate>> =
            sensors.into_iter().map(|sensor| candidates(columns, &sensor)).collect();
        let (best, others) = sensors.split_first()?;
        let has = |sensor: &[Candidate], target: &str| sensor.iter().any(|column| column.target == target);
        let first =
            |sensor: &'_ [Candidate], target: &str| sensor.iter().position(|column| column.target == target);
        // one axis in two units, or twice: the same sensor, if the data agree
        let is_one = |sensor: &[Candidate]| {
            sensor.iter().all(|column| {
                let first = first(sensor, column.target).map(|at| &sensor[at]);
                first.is_none_or(|first| same(columns, first, column))
            })
        };
        let same_as_best = |other: &[Candidate]| {
            let covers =
                |one: &[Candidate], all: &[Candidate]| all.iter().all(|column| has(one, column.target));
            covers(best, other)
                && covers(other, best)
                && other.iter().all(|column| {
                    first(best, column.target).is_some_and(|at| same(columns, &best[at], column))
                })
        };
        let rank = best[0].named.rank;
        let has_rival = others.iter().any(|other| other[0].named.rank == rank && !same_as_best(other));
        let is_mixed = others.iter().flatten().any(|column| !has(best, column.target));
        if has_rival || is_mixed || !is_one(best) {
            let choices = sensors.iter().filter(|sensor| is_mixed || sensor[0].named.rank == rank);
            let mut targets: Vec<String> =
                sensors.iter().flatten().map(|column| column.target.to_owned()).collect();
            targets.sort_unstable();
            targets.dedup();
            let choices = match is_one(best) {
                true => choices.map(|sensor| entries(columns, sensor)).collect(),
                false => best.iter().map(|column| vec![entry(columns, column)]).collect(),
            };
            self.undecided.push(Undecided { targets, choices });
            return None;
        }
        for (at, column) in best.iter().enumerate() {
            if first(best, column.target) != Some(at) {
                continue;
            }
            let rest = best[at + 1..].iter().chain(others.iter().flatten());
            let others = rest.filter(|other| other.target == column.target);
            self.take(columns, column, others.map(|other| entry(columns, other)).collect());
        }
        Some(best[0].named.numbers.clone())
    }

    /// Chooses one column for a channel that is no axis.
    fn choose_column<'a>(
        &mut self,
        columns: &[(&str, &[f64])],
        named: impl Iterator<Item = &'a (usize, Named)>,
    ) {
        let named: Vec<&(usize, Named)> = named.collect();
        let mut found = candidates(columns, &named);
        let Some(rank) = found.first().map(|best| best.named.rank) else { return };
        let equals = found.iter().take_while(|candidate| candidate.named.rank == rank).count();
        // the finest of clocks that run alike
        if found[0].target == "t_s" {
            found[..equals]
                .sort_by_key(|column| (!column.sure, std::cmp::Reverse(distinct(columns[column.at].1))));
        }
        let best = &found[0];
        if !found[1..equals].iter().all(|other| same(columns, best, other)) {
            let choices = found[..equals].iter().map(|column| vec![entry(columns, column)]).collect();
            self.undecided.push(Undecided { targets: vec![best.target.to_owned()], choices });
            return;
        }
        let others = found[1..].iter().map(|other| entry(columns, other)).collect();
        self.take(columns, best, others);
    }

    /// Withdraws the axes: the accelerometers would be those of one device, the gyros those of another.
    fn withdraw_axes(&mut self, columns: &[(&str, &[f64])]) {
        let mut choices = Vec::new();
        for triad in [&AXES[..3], &AXES[3..]] {
            let mut entries = Vec::new();
            for (guess, (name, _)) in self.columns.iter_mut().zip(columns) {
                if let Some(Guess { target, unit, .. }) =
                    guess.take_if(|guess| triad.contains(&&*guess.target))
                {
                    entries.push(spec(&target, name, unit));
                }
            }
            entries.sort();
            choices.push(entries);
        }
        let targets = AXES.map(str::to_owned).to_vec();
        self.undecided.push(Undecided { targets, choices });
    }

    fn take(&mut self, columns: &[(&str, &[f64])], column: &Candidate, others: Vec<String>) {
        let why = match (column.unit, column.sure) {
            (Some(_), true) => "by its name",
            (Some(_), false) => "the channel by its name, the unit by its values",
            (None, _) => "by its name; its values fit no unit: raw counts need a scale",
        };
        debug_assert!(column.at < columns.len());
        self.columns[column.at] = Some(Guess {
            target: column.target.to_owned(),
            unit: column.unit,
            why: why.to_owned(),
            sure: column.sure,
            others,
        });
    }
}

/// Columns of one sensor, or candidates for one channel, with their units.
fn candidates(columns: &[(&str, &[f64])], named: &[&(usize, Named)]) -> Vec<Candidate> {
    let values: Vec<&[f64]> = named.iter().map(|(at, _)| columns[*at].1).collect();
    let candidate = |(at, named): &&(usize, Named)| {
        let (name, own) = columns[*at];
        let target = target_of(named.quantity);
        let stated = unit_in(name, target);
        let unit = stated.or_else(|| match named.quantity {
            Quantity::Time => time_unit(own),
            // a single axis sees only a component of gravity, so the unit is determined from three
            Quantity::Force(_) => values[..].try_into().ok().and_then(force_unit),
            Quantity::Rate(_) => rate_unit(&values),
            Quantity::Temperature => temperature_unit(own),
            Quantity::Voltage => Some(if typical(own) > 100.0 { "mV" } else { "V" }),
            Quantity::Field(_) => Some("uT"),
            Quantity::Load => Some("%"),
        });
        Candidate { at: *at, named: named.clone(), target, unit, sure: stated.is_some() }
    };
    named.iter().map(candidate).collect()
}

fn entries(columns: &[(&str, &[f64])], sensor: &[Candidate]) -> Vec<String> {
    let mut entries: Vec<String> = Vec::new();
    for (at, column) in sensor.iter().enumerate() {
        if !sensor[..at].iter().any(|before| before.target == column.target) {
            entries.push(entry(columns, column));
        }
    }
    entries.sort();
    entries
}

fn entry(columns: &[(&str, &[f64])], column: &Candidate) -> String {
    spec(column.target, columns[column.at].0, column.unit)
}

fn spec(target: &str, column: &str, unit: Option<&str>) -> String {
    let unit = unit.map_or_else(String::new, |unit| format!(":{unit}"));
    format!("{target}={}{unit}", quoted(column))
}

/// Largest relative difference attributed to rounding of a conversion.
const ROUNDING: f64 = 1e-6;

/// Returns true if two candidates of one channel hold the same data, in the unit of the channel; clocks may differ in
/// their epoch.
fn same(columns: &[(&str, &[f64])], one: &Candidate, other: &Candidate) -> bool {
    let converted = |column: &Candidate| -> Vec<f64> {
        let mut values = columns[column.at].1.to_vec();
        if let Some((_, to_si)) = column.unit.and_then(parse_unit) {
            to_si.apply(&mut values);
        }
        values
    };
    let (one_values, other_values) = (converted(one), converted(other));
    let mut pairs = one_values.iter().zip(&other_values);
    if one.target != "t_s" {
        return pairs.all(|(a, b)| {
            a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
        });
    }
    // timestamps belong to the same sample if they differ by less than half a period
    let apart: Vec<f64> = pairs.map(|(a, b)| a - b).filter(|apart| apart.is_finite()).collect();
    let (low, high) =
        apart.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    let period = median(steps(&one_values).into_iter().filter(|step| *step > 0.0).collect());
    apart.is_empty() || one.unit.is_some() == other.unit.is_some() && high - low <= 0.5 * period
}

fn distinct(values: &[f64]) -> usize {
    let mut bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
    bits.sort_unstable();
    bits.dedup();
    bits.len()
}

/// Median of the finite magnitudes.
fn typical(values: &[f64]) -> f64 {
    let magnitudes = values.iter().filter(|value| value.is_finite()).map(|value| value.abs());
    median(magnitudes.collect())
}

/// Median; NaN if empty, which lies in no range.
fn median(values: Vec<f64>) -> f64 {
    median_of(values).unwrap_or(f64::NAN)
}

fn steps(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| step.is_finite()).collect()
}

/// Unit in which the timestamps give 10 to 2000 samples per second.
pub(super) fn time_unit(stamps: &[f64]) -> Option<&'static str> {
    let step = median(steps(stamps).into_iter().filter(|step| *step > 0.0).collect());
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]
        .into_iter()
        .find(|(_, seconds)| (5e-4..=0.1).contains(&(step * seconds)))
        .map(|(unit, _)| unit)
}

/// Gravity as measured by a triad of accelerometers, in their unit: the median magnitude; `None` without rows.
pub(super) fn gravity(triad: [&[f64]; 3]) -> Option<f64> {
    let rows = triad.iter().map(|values| values.len()).min()?;
    let norm = |row: usize| triad.iter().map(|values| values[row] * values[row]).sum::<f64>().sqrt();
    median_of((0..rows).map(norm).filter(|norm| norm.is_finite()))
}

/// Unit in which the median magnitude of a triad is about gravity.
pub(super) fn force_unit(triad: [&[f64]; 3]) -> Option<&'static str> {
    let gravity = gravity(triad)?;
    let about = |one: f64| (0.7..1.4).contains(&(gravity / one));
    [("m/s2", STANDARD_GRAVITY_MPS2), ("g", 1.0), ("mg", 1000.0)]
        .into_iter()
        .find(|(_, one)| about(*one))
        .map(|(unit, _)| unit)
}

/// Largest bias of such gyros, dps. Where all axes turn faster than this most of the time, the values are rather counts
/// with an offset.
const LARGEST_BIAS_DPS: f64 = 20.0;

/// Unit by the sample-to-sample noise: that of such gyros is 0.02 to 0.5 dps at 200 Hz.
pub(super) fn rate_unit(triad: &[&[f64]]) -> Option<&'static str> {
    // in slow or coarse data most samples repeat the one before
    let changes = |values: &&[f64]| steps(values).into_iter().filter(|step| *step > 0.0).collect();
    let noise = median(triad.iter().map(|values| median(changes(values))).collect());
    let (unit, dps) = match noise {
        noise if (2e-4..0.009).contains(&noise) => ("rad/s", 1_f64.to_degrees()),
        noise if (0.009..2.0).contains(&noise) => ("dps", 1.0),
        noise if (9.0..2000.0).contains(&noise) => ("mdps", 1e-3),
        _ => return None,
    };
    let is_bias = |values: &&[f64]| dps * typical(values) < LARGEST_BIAS_DPS;
    triad.iter().any(is_bias).then_some(unit)
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
    use fos_testkit::noise::Noise;

    fn guessed(columns: &[(&str, Vec<f64>)]) -> Vec<Option<(String, Option<&'static str>, bool)>> {
        let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, v)| (*name, v.as_slice())).collect();
        let found = guesses(&columns).columns.into_iter();
        found.map(|guess| guess.map(|g| (g.target, g.unit, g.sure))).collect()
    }

    fn noise(size: f64, about: f64) -> Vec<f64> {
        (0..500).map(|n| about + size * f64::from((n * 7919) % 101 - 50) / 30.0).collect()
    }

    #[test]
    fn names_with_units_are_certain() {
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
    fn names_of_the_log_format_take_precedence() {
        for name in ["t_s", "gx_rads", "ref_az_mps2", "still", "temp_c"] {
            assert_eq!(guessed(&[(name, noise(1.0, 0.0))])[0], Some((name.to_owned(), None, true)));
        }
        // and nothing else becomes the same channel
        let both = guessed(&[("gyro_x_dps", noise(1.0, 0.0)), ("gx_rads", noise(1.0, 0.0))]);
        assert_eq!(both[0], None);
    }

    #[test]
    fn guesses_units_from_values_as_uncertain() {
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
        let raw = guessed(&["gx", "gy", "gz"].map(|name| (name, noise(30.0, 32768.0))));
        assert_eq!(raw[2], Some(("gz_rads".to_owned(), None, false)), "raw counts with an offset");
    }

    #[test]
    fn ignores_columns_that_are_no_channel() {
        for name in ["", "counter", "x", "label", "motor_current", "gps_lat"] {
            assert_eq!(guessed(&[(name, noise(1.0, 0.0))])[0], None, "{name}");
        }
    }

    /// Column of each channel, by a rule.
    type Mapping = std::collections::BTreeMap<String, String>;
    type Rule = fn(&[(&str, &[f64])]) -> Mapping;

    fn mapping(columns: &[(&str, &[f64])]) -> Mapping {
        let guesses = guesses(columns).columns.into_iter().zip(columns);
        guesses.filter_map(|(guess, (name, _))| Some((guess?.target, (*name).to_owned()))).collect()
    }

    /// The previous rule: the first column of the file that matches a channel.
    fn first_in_the_file(columns: &[(&str, &[f64])]) -> Mapping {
        let mut mapping = Mapping::new();
        for (name, _) in columns {
            let named = column_words::named(name);
            if let Some(named) = named {
                mapping.entry(target_of(named.quantity).to_owned()).or_insert_with(|| (*name).to_owned());
            }
        }
        mapping
    }

    /// Columns with different noise in an order that `seed` determines.
    fn shuffled(names: &[String], seed: u64) -> Vec<(String, Vec<f64>)> {
        let mut columns: Vec<(String, Vec<f64>)> = names
            .iter()
            .zip(1..)
            .map(|(name, size)| (name.clone(), noise(1e-3 * f64::from(size), 0.0)))
            .collect();
        let mut random = Noise::new(seed);
        for last in (1..columns.len()).rev() {
            columns.swap(last, random.bits() as usize % (last + 1));
        }
        columns
    }

    /// Returns true if the mapping does not depend on the order of the columns.
    fn is_free_of_order(names: &[String], rule: Rule) -> bool {
        let of = |seed: u64| {
            let columns = shuffled(names, seed);
            let columns: Vec<(&str, &[f64])> =
                columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
            rule(&columns)
        };
        (1..40).all(|seed| of(seed) == of(0))
    }

    fn triads(patterns: &[&str]) -> Vec<String> {
        let of = |pattern: &&str| ["x", "y", "z"].map(|axis| pattern.replace('*', axis)).to_vec();
        patterns.iter().flat_map(of).collect()
    }

    fn rich_table() -> Vec<String> {
        let mut names = triads(&[
            "gyro_bias_*_dps",
            "gyro_*_dps",
            "gyro_raw_*_dps",
            "gravity_acc_*_g",
            "acc_*_g",
            "acc_*_filt_g",
            "linear_acceleration_* (m/s2)",
            "accuracy_*_m_s2",
            "acc_std_*_g",
            "mag_*_ut2",
            "mag_*_gauss",
        ]);
        let others = [
            "cpu_temp_c",
            "imu_temp_c",
            "temperature_c",
            "time_us",
            "gps_time_us",
            "timeout_ms",
            "vdd_mv",
            "vbat_mv",
            "cpu_load_pct",
            "gpu_load_pct",
            "battery_pct",
        ];
        names.extend(others.map(str::to_owned));
        names
    }

    #[test]
    fn maps_columns_the_same_in_any_order() {
        assert!(is_free_of_order(&rich_table(), mapping));
        // of two equally good ones none is taken, in any order
        assert!(is_free_of_order(&triads(&["imu0_gyro_*_dps", "imu1_gyro_*_dps", "acc_*_g"]), mapping));
        // negative control: the previous rule depends on the order
        assert!(!is_free_of_order(&rich_table(), first_in_the_file));
        let decoys: Vec<&str> = column_words::DECOYS.split_ascii_whitespace().collect();
        println!(
            "attack: choice among columns | {} columns in 40 orders give the same mapping; a gyro column qualified by any of {} words is not taken for the measurement | negative control: a rule that takes the first candidate depends on the order, and accepts {} columns qualified as linear, filtered or raw",
            rich_table().len(),
            decoys.len() - deceived_by(&decoys, mapping).len(),
            deceived_by(&["linear", "filtered", "raw"], first_in_the_file).len(),
        );
    }

    #[test]
    fn prefers_the_bare_measurement_and_the_imu_own_temperature() {
        let columns = shuffled(&rich_table(), 7);
        let columns: Vec<(&str, &[f64])> =
            columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        let found = mapping(&columns);
        for (target, column) in [
            ("gx_rads", "gyro_x_dps"),
            ("gz_rads", "gyro_z_dps"),
            ("ay_mps2", "acc_y_g"),
            ("mag_x_ut", "mag_x_gauss"),
            ("temp_c", "imu_temp_c"),
            ("t_s", "time_us"),
            ("supply_v", "vdd_mv"),
            ("load_pct", "cpu_load_pct"),
        ] {
            assert_eq!(found.get(target).map(String::as_str), Some(column), "{target}");
        }
        let others = |target: &str| {
            let guess = guesses(&columns).columns.into_iter().flatten().find(|guess| guess.target == target);
            guess.unwrap().others
        };
        assert_eq!(others("gx_rads"), ["gx_rads=gyro_raw_x_dps:dps"]);
        let processed = ["ax_mps2=acc_x_filt_g:g", "ax_mps2=linear_acceleration_x (m/s2):m/s2"];
        assert_eq!(others("ax_mps2"), processed);
    }

    /// Decoys that are taken for the measurement, whether they stand before it or after it.
    fn deceived_by(words: &[&str], rule: Rule) -> Vec<String> {
        let mut deceived = Vec::new();
        for word in words {
            for pattern in ["gyro_#_*_dps", "#_gyro_*_dps", "gyro_*_#_dps"] {
                let decoys = triads(&[&pattern.replace('#', word)]);
                let measured = triads(&["gyro_*_dps"]);
                for names in [[decoys.clone(), measured.clone()], [measured.clone(), decoys.clone()]] {
                    let names = names.concat();
                    let columns: Vec<(String, Vec<f64>)> = names
                        .iter()
                        .zip(1..)
                        .map(|(name, size)| (name.clone(), noise(f64::from(size), 0.0)))
                        .collect();
                    let columns: Vec<(&str, &[f64])> =
                        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
                    let found = rule(&columns);
                    let is_right = ["gx_rads", "gy_rads", "gz_rads"]
                        .iter()
                        .zip(&measured)
                        .all(|(target, column)| found.get(*target) == Some(column));
                    if !is_right {
                        deceived.push(decoys[0].clone());
                    }
                }
            }
        }
        deceived
    }

    #[test]
    fn ignores_decoy_words_in_column_names() {
        let words: Vec<&str> = column_words::DECOYS
            .split_ascii_whitespace()
            .chain(["linear", "filtered", "raw", "lpf", "debug", "left"])
            .collect();
        assert_eq!(deceived_by(&words, mapping), [""; 0]);
        // negative control: the previous rule takes a worse candidate that comes first
        assert!(deceived_by(&["linear", "filtered", "raw"], first_in_the_file).len() >= 9);
        // nor by a prefix
        for name in [
            "accuracy_x_m_s2",
            "magnitude_x_gauss",
            "template_c",
            "timeout_ms",
            "angular_acceleration_x (rad/s)",
        ] {
            assert_eq!(guessed(&[(name, noise(1.0, 5.0))])[0], None, "{name}");
        }
    }

    #[test]
    fn takes_no_triad_from_two_sensors() {
        for names in [
            vec!["imu0_acc_x_g", "imu1_acc_y_g", "imu0_acc_z_g"],
            vec!["acc_x_g", "acc_y_g", "acc_z_filt_g"],
            vec!["acc0_x_g", "acc0_y_g", "acc0_z_g", "gyro1_x_dps", "gyro1_y_dps", "gyro1_z_dps"],
        ] {
            let columns: Vec<(&str, Vec<f64>)> =
                names.iter().zip(1..).map(|(name, size)| (*name, noise(f64::from(size), 0.0))).collect();
            let columns: Vec<(&str, &[f64])> =
                columns.iter().map(|(name, v)| (*name, v.as_slice())).collect();
            let found = guesses(&columns);
            assert_eq!((found.columns.iter().flatten().count(), found.undecided.len()), (0, 1), "{names:?}");
        }
        // one sensor in two units is one
        let (dps, rads) =
            (noise(1.0, 0.0), noise(1.0, 0.0).iter().map(|v| v.to_radians()).collect::<Vec<_>>());
        let both = guesses(&[("gyro_x_dps", &dps), ("gyro_x_rads", &rads)]);
        assert_eq!((both.columns.iter().flatten().count(), both.undecided.len()), (1, 0));
    }
}
