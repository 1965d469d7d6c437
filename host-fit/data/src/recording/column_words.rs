//! Words of a column's name: quantity, axis, sensor, and closeness to the bare measurement.
//!
//! Words are compared whole, since a prefix is misleading: `accuracy_x` begins like `acc_x`, `template` like `temp`.

use crate::unit::parse_unit;

/// Quantity stated by a name; axes are 0, 1, 2 for x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Force(usize),
    Rate(usize),
    Field(usize),
    Temperature,
    Voltage,
    Load,
}

/// A column that may be a channel, by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) quantity: Quantity,
    /// Distance from the bare measurement: 0 for the sensor's word with its axis and nothing else; larger with other
    /// words. See [`BARE`], [`PLAIN`], [`UNKNOWN`], [`PROCESSED`].
    pub(super) rank: u8,
    /// Name without axis and unit, common to the columns of one sensor.
    pub(super) sensor: String,
    /// Numbers of a device or sensor in the name, such as 0 in `imu0_acc_x`.
    pub(super) numbers: Vec<u32>,
}

/// Rank of the sensor's word with its axis; for temperatures, of that of the IMU itself.
pub(super) const BARE: u8 = 0;
/// Rank with words that change nothing, such as `raw` or `imu`.
pub(super) const PLAIN: u8 = 1;
/// Rank with unknown words.
pub(super) const UNKNOWN: u8 = 2;
/// Rank with words for a result computed from the measurement, or measured elsewhere.
pub(super) const PROCESSED: u8 = 3;

/// Accelerometers, gyros and magnetometers: words that stand next to an axis, and words that an axis may be joined to
/// (`ax`, `gyrox`).
const FORCE: &str = "acc accel accels acceleration accelerations accelerometer accelerometers xl";
const RATE: &str = "gyr gyro gyros gyroscope gyroscopes omega angvel angularvelocity";
const FIELD: &str = "mag mags magnetometer magnetic";
const JOINED_FORCE: &str = "a la";
const JOINED_RATE: &str = "g w rate";
const JOINED_FIELD: &str = "m b";

/// Two words that together mean a gyro.
const TURNS: &str = "angular ang rotation rotational";
const SPEED: &str = "velocity vel rate speed";

const TEMPERATURE: &str = "temp temps temperature temperatures tmp thermometer thermistor";
const TIME: &str = "time timestamp timestamps stamp elapsed t ts";
const VOLTAGE: &str = "supply vdd vcc vin vbat vbatt voltage volt";
const BATTERY: &str = "battery batt bat";
const LOAD: &str = "load cpu cpuload";

/// Words of the IMU itself, next to a temperature.
const OWN: &str = "imu gyro gyr gyros gyroscope acc accel accelerometer xl inertial mems die chip mpu";

/// Words that change nothing about a measurement.
const NEUTRAL: &str = "\
    raw imu sensor sensors data value val field msg measured meas measurement uncalibrated uncalib uncal \
    unfiltered unfilt inertial device header sample axis";

/// Words for results computed from a measurement that still contain part of its error.
const PROCESSED_WORDS: &str = "\
    linear lin filtered filt filter lpf lp lowpass notch smooth smoothed avg average mean median calibrated \
    calib cal corrected corr compensated comp scaled processed proc decimated resampled interp interpolated \
    rotated world earth enu ned nav global integrated integral delta est estimated fused";

/// Words that exclude a measurement of the quantity, whatever else is in the name.
pub(super) const DECOYS: &str = "\
    bias biases offset offsets gravity grav user std stddev sd sigma var variance cov covariance accuracy \
    uncertainty precision ref reference truth true gt groundtruth cmd command setpoint sp target desired des \
    goal error err residual innovation innov noise rms min max peak range scale gain sensitivity drift limit \
    threshold thresh clip clipping clipped status flag flags valid validity id count counter index quality \
    age gps gnss jerk angle position pos hp hpf highpass diff derivative gradient pred predicted model sim \
    simulated coeff trim dt";

/// Further words that assign a temperature to something else.
const ELSEWHERE: &str = "\
    cpu gpu soc battery batt bat ambient air room outside outdoor indoor motor esc engine water oil fan ssd \
    disk radio modem charger external ext environment weather dew rate slope";
/// Words of a temperature near the IMU.
const NEARBY: &str = "board pcb mcu baro barometer bmp case mag magnetometer housing body";

/// Words next to a time: of a duration, and of a clock other than the sampling one.
const NO_CLOCK: &str = "\
    delta delay latency lag left exposure duration interval period step cpu run remaining out";
const OTHER_CLOCK: &str = "\
    gps gnss utc unix epoch system host received recv arrival log local date day publish published wall \
    server";

/// Words next to a voltage or a load that assign it to something else.
const OTHER_SUPPLY: &str = "\
    motor esc cell adc current temp temperature pct level charger solar heater gpu memory mem freq";

/// Words that spell a unit at the end of a name or in its brackets.
const UNITS: &str = "\
    s ms us µs ns sec secs seconds msec msecs millis usec usecs micros nsec nsecs nanos m s2 s² mps2 ms2 g \
    mg milli ug rad rads radps rps mrad deg dps degs degps mdps dph h degc c celsius degf f fahrenheit k \
    kelvin mv v volts ut µt mt gauss mgauss pct";

/// Units of time, which name a clock if a name has no other words.
const TIME_UNITS: &str = "\
    s ms us µs ns sec secs seconds msec msecs millis usec usecs micros nsec nsecs nanos";

/// Words of a name: split at everything that is no letter or digit, and where a capital follows a small letter.
pub(super) fn words(name: &str) -> Vec<String> {
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

/// Returns true if `word` is one of a list of words separated by spaces.
fn is_in(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|listed| listed == word)
}

/// Returns true if a name has a word that excludes a measurement, such as `bias` or `accuracy`.
pub(super) fn is_decoy(name: &str) -> bool {
    words(name).iter().any(|word| is_in(DECOYS, word))
}

/// Channel stated by a name; `None` if there is none, or something other than a measurement.
pub(super) fn named(name: &str) -> Option<Named> {
    let mut words = words(name);
    let all_time = words.iter().all(|word| is_in(TIME_UNITS, word));
    if !all_time {
        drop_unit(&mut words);
    }
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let has = |list: &str| words.iter().any(|word| is_in(list, bare(word)));
    if words.is_empty() {
        return None;
    }
    if words.iter().any(|word| is_temperature(word)) {
        return temperature(&words);
    }
    if let Some(named) = inertial(&words) {
        return named;
    }
    if all_time || has(TIME) {
        if words == ["t"] && unit_in(name, "temp_c").is_some() {
            return of(Quantity::Temperature, PLAIN, &words, &words);
        }
        let context: Vec<&str> = words
            .iter()
            .copied()
            .filter(|word| !is_in(TIME, bare(word)) && !is_in(TIME_UNITS, word))
            .collect();
        let rank = rank(&context, |word| match word {
            word if is_in(NO_CLOCK, word) => None,
            word if is_in(OTHER_CLOCK, word) => Some(PROCESSED),
            word if word != "age" && is_in(DECOYS, word) => None,
            word if is_in(NEUTRAL, word) => Some(PLAIN),
            _ => Some(UNKNOWN),
        })?;
        return of(Quantity::Time, rank, &words, &context);
    }
    let other = |list: &str, quantity: Quantity, of_supply: bool| {
        let context: Vec<&str> = words.iter().copied().filter(|word| !is_in(list, bare(word))).collect();
        let is_battery = of_supply && (has("vbat vbatt") || has(BATTERY));
        let rank = rank(&context, |word| match word {
            word if is_in(OTHER_SUPPLY, word) || is_in(DECOYS, word) => None,
            word if is_in(BATTERY, word) => Some(PROCESSED),
            word if is_in(NEUTRAL, word) => Some(PLAIN),
            _ => Some(UNKNOWN),
        })?;
        of(quantity, if is_battery { PROCESSED } else { rank }, &words, &context)
    };
    let in_volts = || unit_in(name, "supply_v").is_some();
    if has(VOLTAGE) || has(BATTERY) && in_volts() {
        return other(VOLTAGE, Quantity::Voltage, true);
    }
    if has(LOAD) {
        return other(LOAD, Quantity::Load, false);
    }
    None
}

/// Removes the words of a unit from the end of a name, unless the name consists only of them.
fn drop_unit(words: &mut Vec<String>) {
    loop {
        let n = words.len();
        let is = |at: usize, list: &str| words.get(at).is_some_and(|word| is_in(list, word));
        // s^2 and s^-1
        let power = n > 2 && is(n - 1, "1 2") && is(n - 2, "s sec");
        match power {
            true => words.truncate(n - 2),
            false if n > 1 && is(n - 1, UNITS) => words.truncate(n - 1),
            false => return,
        }
    }
}

/// Word without the number at its end.
fn bare(word: &str) -> &str {
    word.trim_end_matches(|letter: char| letter.is_ascii_digit())
}

fn axis_of(letter: Option<char>) -> Option<usize> {
    ['x', 'y', 'z'].iter().position(|axis| Some(*axis) == letter)
}

/// Axis of a word that joins it to a word of one of these lists.
fn joined(word: &str, lists: [&str; 2]) -> Option<usize> {
    let axis = axis_of(word.chars().last())?;
    let sensor = bare(&word[..word.len() - 1]);
    lists.iter().any(|list| is_in(list, sensor)).then_some(axis)
}

/// `None` if the words state no axis of a sensor; `Some(None)` if they state an axis but no measurement of it.
fn inertial(words: &[&str]) -> Option<Option<Named>> {
    type Kind = fn(usize) -> Quantity;
    const KINDS: [(Kind, [&str; 2]); 3] = [
        (Quantity::Force, [FORCE, JOINED_FORCE]),
        (Quantity::Rate, [RATE, JOINED_RATE]),
        (Quantity::Field, [FIELD, JOINED_FIELD]),
    ];
    let turns = words.iter().any(|word| is_in(TURNS, word)) && words.iter().any(|word| is_in(SPEED, word));
    let of_kind = |word: &str, (_, [alone, joins]): &(Kind, [&str; 2])| {
        is_in(alone, bare(word)) || joined(word, [alone, joins]).is_some()
    };
    let is_turn = |word: &str| turns && (is_in(TURNS, word) || is_in(SPEED, word));
    let kinds: Vec<&(Kind, [&str; 2])> = KINDS
        .iter()
        .enumerate()
        .filter(|(at, kind)| words.iter().any(|word| of_kind(word, kind)) || *at == 1 && turns)
        .map(|(_, kind)| kind)
        .collect();
    let has_axis = words.iter().any(|word| {
        word.len() == 1 && axis_of(word.chars().next()).is_some()
            || kinds.iter().any(|kind| joined(word, kind.1).is_some())
    });
    // an angular acceleration is neither of the two
    let [kind] = kinds[..] else { return (has_axis && !kinds.is_empty()).then_some(None) };
    let alone =
        words.iter().filter_map(|word| if word.len() == 1 { axis_of(word.chars().next()) } else { None });
    let joins = words.iter().filter_map(|word| joined(word, kind.1));
    let axes: Vec<usize> = alone.chain(joins).collect();
    let [axis] = axes[..] else { return None };
    let (make, _) = kind;
    let without_axis = |word: &str| -> String {
        match joined(word, kind.1) {
            Some(_) => word[..word.len() - 1].to_owned(),
            None => word.to_owned(),
        }
    };
    let is_axis = |word: &str| word.len() == 1 && axis_of(word.chars().next()).is_some();
    let context: Vec<&str> = words
        .iter()
        .copied()
        .filter(|word| !is_axis(word) && !of_kind(word, kind) && !is_turn(word))
        .collect();
    let rank = rank(&context, |word| match word {
        "angular" => None,
        word if is_in(DECOYS, word) => None,
        word if is_in(PROCESSED_WORDS, word) => Some(PROCESSED),
        word if is_in(NEUTRAL, word) => Some(PLAIN),
        _ => Some(UNKNOWN),
    });
    let Some(rank) = rank else { return Some(None) };
    let sensor: Vec<String> =
        words.iter().filter(|word| !is_axis(word)).map(|word| without_axis(word)).collect();
    let sensor: Vec<&str> = sensor.iter().map(String::as_str).collect();
    Some(of(make(axis), rank, &sensor, &sensor))
}

fn is_temperature(word: &str) -> bool {
    let word = bare(word);
    is_in(TEMPERATURE, word) || word.ends_with("temperature") || (word.ends_with("temp") && word.len() > 4)
}

fn temperature(words: &[&str]) -> Option<Named> {
    let context: Vec<&str> = words
        .iter()
        .map(|word| {
            let word = bare(word);
            match is_in(TEMPERATURE, word) {
                true => "",
                false => word.strip_suffix("temperature").or(word.strip_suffix("temp")).unwrap_or(word),
            }
        })
        .filter(|word| !word.is_empty())
        .collect();
    let rank = match context.is_empty() {
        true => PLAIN,
        false => rank(&context, |word| match word {
            word if is_in(DECOYS, word) || is_in(ELSEWHERE, word) => None,
            word if is_in(PROCESSED_WORDS, word) || is_in(NEARBY, word) => Some(PROCESSED),
            word if is_in(OWN, word) => Some(BARE),
            word if is_in(NEUTRAL, word) => Some(PLAIN),
            _ => Some(UNKNOWN),
        })?,
    };
    of(Quantity::Temperature, rank, words, &context)
}

/// Rank of the worst of these words, each without its number; `None` if one of them means something else.
fn rank(context: &[&str], of: impl Fn(&str) -> Option<u8>) -> Option<u8> {
    context.iter().try_fold(BARE, |rank, word| {
        // a number alone only distinguishes devices
        let of_word = if bare(word).is_empty() { Some(PLAIN) } else { of(bare(word)) };
        of_word.map(|of_word| rank.max(of_word))
    })
}

fn of(quantity: Quantity, rank: u8, sensor: &[&str], context: &[&str]) -> Option<Named> {
    const NUMBERED: &str = "imu sensor device dev unit";
    let is_numbered = |word: &str| {
        let word = bare(word);
        word.is_empty() || is_in(NUMBERED, word) || is_in(FORCE, word) || is_in(RATE, word)
    };
    let numbers = context.iter().filter(|word| is_numbered(word));
    let numbers = numbers.filter_map(|word| word[bare(word).len()..].parse().ok()).collect();
    Some(Named { quantity, rank, sensor: sensor.join("_"), numbers })
}

/// Unit in the name, in brackets or as its last words, if it is one of the target.
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
            // an axis letter g is no unit: gyro names contain it
            "g" if lower.contains("acc") || bracketed.is_some_and(|unit| unit.eq_ignore_ascii_case("g")) => {
                "g"
            }
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
