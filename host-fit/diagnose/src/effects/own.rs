//! Effects of a user's own: read from files, and what is wrong with one by file, line and column.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::place::place;
use super::{Effect, EffectError, Library};
use fos_data::closest::closest;
use fos_data::file;

/// What of an effect's file is held against the library.
#[derive(Deserialize)]
struct Names {
    id: Spanned<String>,
    #[serde(default)]
    confused_with: Vec<Rival>,
}

#[derive(Deserialize)]
struct Rival {
    effect: Spanned<String>,
}

impl Library {
    /// The built-in effects and the user's, one file each.
    ///
    /// # Errors
    ///
    /// A file cannot be read or is no effect, an identifier is taken, or a rival in `confused_with` is in none of them.
    pub fn with_files<P: AsRef<Path>>(paths: &[P]) -> Result<Self, EffectError> {
        let mut library = Self::built_in();
        let mut from: HashMap<String, String> = HashMap::new();
        let mut rivals = Vec::new();
        for path in paths {
            let text = String::from_utf8_lossy(&file::read(path.as_ref())?).into_owned();
            let path = path.as_ref().display().to_string();
            let effect = Effect::parse(&path, &text)?;
            let names: Names =
                toml::from_str(&text).map_err(|error| EffectError::toml(&path, &text, &error))?;
            let here = place(&path, &text, Some(names.id.span()));
            if library.get(&effect.id).is_ok() {
                let other =
                    from.remove(&effect.id).unwrap_or_else(|| "the library of built-in effects".to_owned());
                return Err(EffectError::Taken { place: here, id: effect.id, other });
            }
            from.insert(effect.id.clone(), here);
            let located =
                |rival: Rival| (place(&path, &text, Some(rival.effect.span())), rival.effect.into_inner());
            rivals.extend(names.confused_with.into_iter().map(located));
            library.add(effect);
        }
        // a rival may be in a file that comes later
        for (place, id) in rivals {
            if library.get(&id).is_err() {
                let known: Vec<String> = library.effects().iter().map(|effect| effect.id.clone()).collect();
                let closest = closest(&id, known.iter().map(String::as_str)).map(str::to_owned);
                return Err(EffectError::NoRival { place, id, closest, known });
            }
        }
        Ok(library)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINE: &str = "# mine\nid = \"mine\"\nname = \"m\"\nband = \"slow\"\nmechanism = \"m\"\nequation = \"e\"\nexperiment = \"x\"\n\
         [[terms]]\nregressor = \"temp_c\"\n[[confused_with]]\neffect = \"temp_linear\"\nseparate = \"s\"\n";

    /// What is said of these files, by their names.
    fn said(files: &[(&str, &str)]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let write = |(name, text): &(&str, &str)| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let paths: Vec<_> = files.iter().map(write).collect();
        let inside = format!("{}/", folder.path().display());
        match Library::with_files(&paths) {
            Ok(_) => "ok".to_owned(),
            Err(error) => error.to_string().replace(&inside, ""),
        }
    }

    #[test]
    fn an_identifier_that_is_taken_is_refused_with_both_places() {
        assert_eq!(said(&[("mine.toml", MINE)]), "ok");
        let again = MINE.replace("\"mine\"", "\"thermal_lag\"");
        let built_in = said(&[("again.toml", &again)]);
        assert!(built_in.starts_with("again.toml:2:6: the id \"thermal_lag\""), "{built_in}");
        assert!(built_in.contains("built-in") && built_in.contains("\nhelp: "), "{built_in}");
        let twice = said(&[("mine.toml", MINE), ("other.toml", &format!("\n{MINE}"))]);
        assert!(twice.starts_with("other.toml:3:6: ") && twice.contains("mine.toml:2:6"), "{twice}");
    }

    #[test]
    fn a_rival_that_is_no_effect_is_refused_with_those_that_are() {
        let wrong = said(&[("mine.toml", &MINE.replace("temp_linear", "temp_linaer"))]);
        assert!(wrong.starts_with("mine.toml:11:10: "), "{wrong}");
        for part in ["\"temp_linaer\"", "did you mean \"temp_linear\"?", "\nhelp: ", "thermal_lag"] {
            assert!(wrong.contains(part), "{part}: {wrong}");
        }
        // a user's own, whichever comes first
        let of_other = MINE.replace("temp_linear", "other");
        let other = MINE.replace("\"mine\"", "\"other\"");
        assert_eq!(said(&[("mine.toml", &of_other), ("other.toml", &other)]), "ok");
    }

    #[test]
    fn a_band_that_is_none_is_refused_at_its_place_with_those_that_are() {
        let wrong = said(&[("mine.toml", &MINE.replace("\"slow\"", "\"slwo\""))]);
        assert!(wrong.starts_with("mine.toml:4:8: not an effect: "), "{wrong}");
        for part in ["slwo", "slow", "wide", "data", "stochastic", "\nhelp: "] {
            assert!(wrong.contains(part), "{part}: {wrong}");
        }
        // columns count characters
        let wrong = said(&[("mine.toml", &MINE.replace("# mine\n", "name = \"µ\"; 1\n"))]);
        assert!(wrong.starts_with("mine.toml:1:11: "), "{wrong}");
    }
}
