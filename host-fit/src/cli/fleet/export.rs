//! `fleet export`: an image for a part and a record for each device.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use fos_core::FittedOn;
use fos_fleet::{PartSummary, Shipment, ShippedUnit, UnitRow};
use serde::Serialize;

use crate::cli::arguments::OutputFolder;
use crate::cli::output::{Failure, Written, print_line, print_warning, print_written};
use fos_data::file::{check_output, write_atomically};
use fos_data::text::counted;

/// Write the image of a part, and a record of some 100 bytes for each device
///
/// The image has the means of the population. The record of a device combines its own log with the population, and the device makes its
/// image of both (fos_core::image::for_unit, in C fos_image_for_unit). A device without a record runs on the image of its part. The record of
/// an odd device comes from its own log alone.
#[derive(Debug, Args)]
#[command(after_help = "Example: fos fleet export population.json -o shipment --sensor bmi270")]
pub(super) struct Export {
    /// The population, as `fos fleet` wrote it, with its rows next to it
    population: PathBuf,
    /// The folder to write: part.fosm, units.csv, and a file for each device in units/
    #[arg(short, long, default_value = "shipment")]
    output: OutputFolder,
    /// The part, if the population has several
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// Name of the sensor, stored in the image; by default the name of the part
    #[arg(long, value_name = "NAME")]
    sensor: Option<String>,
    /// The logs, and the values on the device, are after a factory's or driver's correction
    #[arg(long)]
    factory_corrected: bool,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

const IMAGE: &str = "part.fosm";

const UNITS: &str = "units.csv";

/// A line of [`UNITS`].
#[derive(Debug, Serialize)]
struct Line<'a> {
    unit: &'a str,
    lot: &'a str,
    file: String,
    bytes: usize,
    odd: bool,
}

impl Export {
    /// Corrected values if the logs of the part's devices or the user say so; raw otherwise.
    fn values(&self, part: &PartSummary, rows: &[UnitRow]) -> Result<FittedOn, Failure> {
        let of_part = rows.iter().filter(|row| row.part == part.part);
        let stated =
            of_part.filter_map(|row| Some((row.unit.as_str(), row.log.as_ref()?.corrected_by.as_deref())));
        let (corrected, others): (Vec<_>, Vec<_>) = stated.partition(|(_, by)| by.is_some());
        match (corrected.first(), others.first()) {
            (Some((unit, Some(by))), Some((other, _))) if !self.factory_corrected => Err(format!(
                "the log of {unit} holds values that were corrected by {by}, that of {other} does not say so: one image cannot be for both\nhelp: log all devices alike; if all logs are corrected, --factory-corrected"
            )
            .into()),
            (Some(_), _) => Ok(FittedOn::FactoryCorrected),
            (None, _) if self.factory_corrected => Ok(FittedOn::FactoryCorrected),
            (None, _) => Ok(FittedOn::Raw),
        }
    }

    pub(super) fn run(&self) -> Result<(), Failure> {
        // before any error about missing rows
        [IMAGE, UNITS].iter().try_for_each(|name| check_output(&self.output.join(name)))?;
        let (fleet, rows) = fos_fleet::Fleet::read(&self.population)?;
        let part = self.part_of(&fleet.parts)?;
        let values = self.values(part, &rows)?;
        let sensor = self.sensor.as_deref().unwrap_or(&part.part);
        let digest = fleet.rows_sha256.get(..16).unwrap_or_default();
        let provenance = format!("means of {} devices, rows {digest}; {}", fleet.units, fleet.program);
        let shipment = Shipment::of(part, &rows, values, sensor, &provenance)?;

        let folder: &Path = &self.output;
        let records = folder.join("units");
        std::fs::create_dir_all(&records).map_err(|error| format!("{}: {error}", records.display()))?;
        let mut written = Vec::new();
        let mut write = |path: PathBuf, bytes: &[u8], what: String| -> Result<(), Failure> {
            write_atomically(&path, bytes)?;
            written.push(Written { path: path.display().to_string(), what });
            Ok(())
        };
        let terms = shipment.model.n_terms();
        let about = format!("{} bytes, {}", shipment.image.len(), counted(terms, "term"));
        write(folder.join(IMAGE), &shipment.image, about)?;
        let names = file_names(&shipment.units);
        let mut table = csv::Writer::from_writer(Vec::new());
        for (unit, name) in shipment.units.iter().zip(&names) {
            write_atomically(&records.join(name), &unit.record)?;
            table.serialize(Line {
                unit: &unit.unit,
                lot: unit.lot.as_deref().unwrap_or_default(),
                file: format!("units/{name}"),
                bytes: unit.record.len(),
                odd: unit.odd,
            })?;
        }
        let table = table.into_inner().map_err(|error| error.to_string())?;
        write(folder.join(UNITS), &table, format!("{} and their records", counted(names.len(), "device")))?;
        print_written(&written, self.json)?;
        if !shipment.without.is_empty() {
            print_warning(&format!(
                "{} without data, which will run the image of the part: {}",
                counted(shipment.without.len(), "device"),
                some(&shipment.without)
            ));
        }
        let odd: Vec<String> =
            shipment.units.iter().filter(|unit| unit.odd).map(|unit| unit.unit.clone()).collect();
        if !odd.is_empty() {
            print_warning(&format!("{}: {}", counted(odd.len(), "odd device"), some(&odd)));
        }
        if !self.json {
            let longest = shipment.units.iter().map(|unit| unit.record.len()).max().unwrap_or(0);
            print_line!(
                "{} in {}, at most {longest} bytes each",
                counted(names.len(), "record"),
                records.display()
            );
        }
        Ok(())
    }

    fn part_of<'a>(&self, parts: &'a [PartSummary]) -> Result<&'a PartSummary, Failure> {
        let names = || parts.iter().map(|part| part.part.as_str()).collect::<Vec<_>>().join(", ");
        match (&self.part, parts) {
            (Some(name), _) => parts.iter().find(|part| part.part == *name).ok_or_else(|| {
                format!("the population has no part {name:?}\nhelp: it has {}", names()).into()
            }),
            (None, [part]) => Ok(part),
            (None, _) => {
                Err(format!("the population has several parts\nhelp: --part, one of {}", names()).into())
            }
        }
    }
}

/// The first names of many.
fn some(names: &[String]) -> String {
    const FEW: usize = 5;
    let more = if names.len() > FEW { ", …" } else { "" };
    format!("{}{more}", names[..names.len().min(FEW)].join(", "))
}

/// File names of the devices, after their names: characters that separate folders or act in a shell become `_`.
fn file_names(units: &[ShippedUnit]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut name = |unit: &ShippedUnit| {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_' | '.');
        let safe: String = unit.unit.chars().map(|letter| if plain(letter) { letter } else { '_' }).collect();
        let stem = if safe.is_empty() || safe.starts_with('.') { format!("_{safe}") } else { safe };
        let mut file = format!("{stem}.fosu");
        // Some file systems treat certain letters as equal.
        for next in 2.. {
            if taken.insert(file.to_ascii_lowercase()) {
                break;
            }
            file = format!("{stem}-{next}.fosu");
        }
        file
    };
    units.iter().map(&mut name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_its_own_file() {
        let units = ["w7/01", "w7_01", "W7_01", "../../etc", ".", "", "ü"].map(|unit| ShippedUnit {
            unit: unit.to_owned(),
            lot: None,
            odd: false,
            record: Vec::new(),
        });
        let expected = [
            "w7_01.fosu",
            "w7_01-2.fosu",
            "W7_01-3.fosu",
            "_.._.._etc.fosu",
            "_..fosu",
            "_.fosu",
            "_-2.fosu",
        ];
        assert_eq!(file_names(&units), expected);
    }
}
