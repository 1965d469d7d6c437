//! Any text as a column map, as effects, and as a case to simulate.
#![no_main]

use fos_diagnose::effects::{Effect, Library};
use fos_data::recording::ColumnMap;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    for map in [ColumnMap::from_toml(text), ColumnMap::from_specs(text.lines())] {
        match map {
            Ok(map) => {
                for target in ["t_s", "gx_rads", "temp_c"] {
                    let _ = (map.column_of(target), map.ignores(target));
                }
                // As stored in a study.
                assert_eq!(ColumnMap::from_specs(map.specs()).expect("an entry can be read"), map);
            }
            Err(error) => assert!(error.to_string().contains("\nhelp: "), "{error}"),
        }
    }
    let effect = Effect::parse("own.toml", text).map_err(|error| error.to_string());
    if let Err(error) = &effect {
        assert!(error.contains("own.toml") && error.contains("\nhelp: "), "{error}");
    }
    if let Ok(effect) = effect {
        let _ = effect.follows_clock_alone();
        for target in ["ax_mps2", "gz_rads", "pressure"] {
            for value in [None, Some(0.0), Some(1.0), Some(f64::MAX)] {
                let _ = effect.regressors(target, value);
            }
            let _ = effect.unit(0, target);
        }
        let mut library = Library::built_in();
        let id = effect.id.clone();
        library.add(effect);
        assert!(library.get(&id).is_ok());
    }
});
