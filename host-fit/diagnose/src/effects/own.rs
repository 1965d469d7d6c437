//! A user's own effects, read from files; errors state file, line and column.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::place::place;
use super::{Effect, EffectError, Library};
use fos_data::closest::closest;
use fos_data::file;

/// Fields of an effect's file that are checked against the library, with their positions.
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
    /// Returns the built-in effects and the user's, one file each.
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
        // the other effect may be in a later file
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

    /// Error message for these files, with paths relative to their folder.
    fn message_for(files: &[(&str, &str)]) -> String {
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
    fn rejects_duplicate_identifier_with_both_positions() {
        assert_eq!(message_for(&[("mine.toml", MINE)]), "ok");
        let again = MINE.replace("\"mine\"", "\"thermal_lag\"");
        let built_in = message_for(&[("again.toml", &again)]);
        assert!(built_in.starts_with("again.toml:2:6: the id \"thermal_lag\""), "{built_in}");
        assert!(built_in.contains("built-in") && built_in.contains("\nhelp: "), "{built_in}");
        let twice = message_for(&[("mine.toml", MINE), ("other.toml", &format!("\n{MINE}"))]);
        assert!(twice.starts_with("other.toml:3:6: ") && twice.contains("mine.toml:2:6"), "{twice}");
    }

    #[test]
    fn rejects_unknown_rival_with_known_effects() {
        let wrong = message_for(&[("mine.toml", &MINE.replace("temp_linear", "temp_linaer"))]);
        assert!(wrong.starts_with("mine.toml:11:10: "), "{wrong}");
        for part in ["\"temp_linaer\"", "did you mean \"temp_linear\"?", "\nhelp: ", "thermal_lag"] {
            assert!(wrong.contains(part), "{part}: {wrong}");
        }
        // the other effect may be a user's own, in either order
        let with_other_rival = MINE.replace("temp_linear", "other");
        let other = MINE.replace("\"mine\"", "\"other\"");
        assert_eq!(message_for(&[("mine.toml", &with_other_rival), ("other.toml", &other)]), "ok");
    }

    #[test]
    fn rejects_unknown_band_with_position_and_valid_bands() {
        let wrong = message_for(&[("mine.toml", &MINE.replace("\"slow\"", "\"slwo\""))]);
        assert!(wrong.starts_with("mine.toml:4:8: not an effect: "), "{wrong}");
        for part in ["slwo", "slow", "wide", "data", "stochastic", "\nhelp: "] {
            assert!(wrong.contains(part), "{part}: {wrong}");
        }
        // the column is counted in characters
        let wrong = message_for(&[("mine.toml", &MINE.replace("# mine\n", "name = \"µ\"; 1\n"))]);
        assert!(wrong.starts_with("mine.toml:1:11: "), "{wrong}");
    }
}
