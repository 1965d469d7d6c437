//! The tables of docs/calibration.md and the sentence of README, between their markers.

use std::error::Error;
use std::ops::Range;

use serde_json::Value;

use super::interval;

pub(crate) const CALIBRATION: &str = "docs/calibration.md";
pub(crate) const README: &str = "README.md";
/// Number of cases for each seed.
pub(crate) const CASES: usize = 450;
/// Fixed in advance, and never used in development; README and the summary have the figures of the first.
pub(crate) const SEEDS: [u32; 2] = [20261121, 20261122];

/// Rows of the summary: their names there, and in the table of a seed.
pub(crate) const ROWS: [(&str, &str); 6] = [
    ("a single hidden effect is ranked first", "single effect named first, all"),
    ("another effect is reported instead", "wrong name claimed with verdict missing"),
    ("false alarm, no effect missing", "false alarm with nothing missing"),
    ("an effect outside the library is reported as unexplained", "outside the library: unexplained"),
    ("an effect outside the library is mistaken for another", "outside the library: wrong name claimed"),
    ("the 90 % interval of the predicted reduction holds", "predicted reduction's 90 % interval holds"),
];

/// A statistic in a table of the page.
pub(crate) struct Figure {
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) interval: (f64, f64),
    pub(crate) cases: usize,
    /// Required range: `≥ 0.9`, `≤ 0.02`, or `0.8 … 1`.
    pub(crate) must: String,
}

impl Figure {
    /// Number of cases behind a share.
    pub(crate) fn hits(&self) -> usize {
        (self.value * self.cases as f64).round() as usize
    }
}

/// Position of the text between the markers of this name.
pub(crate) fn section(text: &str, name: &str, path: &str) -> Result<Range<usize>, Box<dyn Error>> {
    let (begin, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->"));
    let found = text
        .find(&begin)
        .map(|at| at + begin.len())
        .and_then(|start| Some(start..start + text[start..].find(&end)?));
    found.ok_or_else(|| format!("{path}: there are no markers {} and {end}", begin.trim()).into())
}

/// Lines of the tables within a part of the text.
pub(crate) fn rows(text: &str, part: Range<usize>) -> Vec<Range<usize>> {
    let mut start = part.start;
    let mut found = Vec::new();
    for line in text[part].split_inclusive('\n') {
        if line.starts_with('|') {
            found.push(start..start + line.trim_end().len());
        }
        start += line.len();
    }
    found
}

fn ends(text: &str) -> Result<(f64, f64), Box<dyn Error>> {
    let (low, high) =
        text.split_once('…').ok_or_else(|| format!("{CALIBRATION}: {text:?} is no interval"))?;
    Ok((low.trim().parse()?, high.trim().parse()?))
}

/// All statistics of a seed.
pub(crate) fn figures(page: &str, seed: u32) -> Result<Vec<Figure>, Box<dyn Error>> {
    let mut found = Vec::new();
    for row in rows(page, section(page, &format!("calibration {seed}"), CALIBRATION)?) {
        let cells: Vec<&str> = page[row].trim_matches('|').split('|').map(str::trim).collect();
        if let [name, value, interval, cases, must, _] = cells[..]
            && interval.contains('…')
        {
            let (value, interval, cases) = (value.parse()?, ends(interval)?, cases.parse()?);
            found.push(Figure { name: name.to_owned(), value, interval, cases, must: must.to_owned() });
        }
    }
    Ok(found)
}

/// A value meets its requirement.
pub(crate) fn holds(value: f64, must: &str) -> Result<bool, Box<dyn Error>> {
    let bound = |text: &str| text.trim().parse::<f64>();
    Ok(match (must.strip_prefix('≥'), must.strip_prefix('≤')) {
        (Some(least), _) => value >= bound(least)?,
        (_, Some(most)) => value <= bound(most)?,
        _ => ends(must).map(|(low, high)| low <= value && value <= high)?,
    })
}

/// A statistic of the first seed, checked against its count and its requirement.
fn checked(page: &str, name: &str) -> Result<Figure, Box<dyn Error>> {
    let figure = figures(page, SEEDS[0])?
        .into_iter()
        .find(|figure| figure.name == name)
        .ok_or_else(|| format!("{CALIBRATION}: there is no figure {name:?}"))?;
    interval::check(figure.value, figure.interval, figure.cases)
        .map_err(|error| format!("{CALIBRATION}: {name}: {error}"))?;
    if !holds(figure.value, &figure.must)? {
        return Err(format!("{CALIBRATION}: {name}: {}, must be {}", figure.value, figure.must).into());
    }
    Ok(figure)
}

fn percent(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

/// Summary at the head of the page, computed from the table of the first seed.
pub(crate) fn summary(page: &str) -> Result<String, Box<dyn Error>> {
    let mut text = format!(
        "| of {} simulated cases, seed {} | share, % | 95 % interval | cases |\n|---|---|---|---|\n",
        CASES, SEEDS[0]
    );
    for (called, name) in ROWS {
        let figure = checked(page, name)?;
        let (low, high) = figure.interval;
        text += &format!(
            "| {called} | {} | {} … {} | {} |\n",
            percent(figure.value),
            percent(low),
            percent(high),
            figure.cases
        );
    }
    Ok(text)
}

/// Sentence of README, computed from the table of the first seed.
pub(crate) fn headline(page: &str) -> Result<String, Box<dyn Error>> {
    let share = |name| -> Result<String, Box<dyn Error>> {
        let figure = checked(page, name)?;
        let (low, high) = figure.interval;
        Ok(format!("{} % (95 % interval {} … {})", percent(figure.value), percent(low), percent(high)))
    };
    Ok(format!(
        "On {CASES} simulated cases the diagnosis ranked a single hidden effect first in {},\nand raised a false alarm in {} of the cases without one.\n",
        share("single effect named first, all")?,
        share("false alarm with nothing missing")?
    ))
}

/// Four significant digits, without trailing zeros.
fn short(number: f64) -> String {
    let exponent = if number == 0.0 { 0 } else { number.abs().log10().floor() as i32 };
    if !(-4..4).contains(&exponent) {
        return format!("{number:.3e}");
    }
    let text = format!("{number:.*}", (3 - exponent) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Table of the page, from the output of `fos calibrate --json`.
pub(crate) fn table(calibrated: &[Value]) -> Result<String, Box<dyn Error>> {
    let mut text =
        String::from("| figure | value | 95 % interval | cases | must | aim |\n|---|---|---|---|---|---|\n");
    let number = |value: &Value| value.as_f64().map(short).ok_or("calibrate gives no number");
    let span =
        |pair: &Value| Ok::<_, Box<dyn Error>>(format!("{} … {}", number(&pair[0])?, number(&pair[1])?));
    for figure in calibrated {
        let name = figure["name"].as_str().ok_or("calibrate gives a figure without a name")?;
        if figure["value"].is_null() || figure["interval"].is_null() {
            return Err(format!("{name}: no case counts; more cases are needed").into());
        }
        let goal = figure["goal"]
            .as_object()
            .and_then(|goal| goal.iter().next())
            .ok_or_else(|| format!("{name}: no goal"))?;
        let asked = |at: usize| match (goal.0.as_str(), &goal.1[at]) {
            ("within", pair) => span(pair),
            ("at_least", least) => Ok(format!("≥ {}", number(least)?)),
            (_, most) => Ok(format!("≤ {}", number(most)?)),
        };
        let name = name.strip_prefix("  ").map_or(name.to_owned(), |name| format!("· {name}"));
        text += &format!(
            "| {name} | {} | {} | {} | {} | {} |\n",
            number(&figure["value"])?,
            span(&figure["interval"])?,
            figure["cases"],
            asked(0)?,
            asked(1)?
        );
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let numbers = [0.0, 1.0, 0.96, 0.98876, 0.0040625, 93.26, 1234.5, 0.00003];
        assert_eq!(numbers.map(short), ["0", "1", "0.96", "0.9888", "0.004063", "93.26", "1234", "3.000e-5"]);
    }

    #[test]
    fn table_contains_output_of_calibrate() {
        let of = |goal: &str| {
            format!(
                r#"{{"name": "  all", "value": 0.98765, "interval": [0.96, 1], "cases": 178, "goal": {goal}}}"#
            )
        };
        let rows = [
            r#"{"at_least": [0.9, 0.95]}"#,
            r#"{"at_most": [0.02, 0]}"#,
            r#"{"within": [[0.8, 1], [0.85, 0.95]]}"#,
        ];
        let calibrated: Vec<Value> =
            rows.iter().map(|goal| serde_json::from_str(&of(goal)).unwrap()).collect();
        let lines = table(&calibrated).unwrap();
        let lines: Vec<&str> = lines.lines().skip(2).collect();
        let same = "| · all | 0.9877 | 0.96 … 1 | 178 ";
        assert_eq!(
            lines,
            [
                format!("{same}| ≥ 0.9 | ≥ 0.95 |"),
                format!("{same}| ≤ 0.02 | ≤ 0 |"),
                format!("{same}| 0.8 … 1 | 0.85 … 0.95 |")
            ]
        );
    }

    #[test]
    fn parses_requirements() {
        for (value, must, wanted) in [
            (0.9, "≥ 0.9", true),
            (0.89, "≥ 0.9", false),
            (0.03, "≤ 0.02", false),
            (0.9, "0.8 … 1", true),
            (1.1, "0.8 … 1", false),
        ] {
            assert_eq!(holds(value, must).unwrap(), wanted, "{value} {must}");
        }
        assert!(holds(1.0, "so").is_err());
    }
}
