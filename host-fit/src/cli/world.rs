//! Disturbances of simulated logs, as arguments.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use fos_simulate::Disturbance;

/// A disturbance.
#[derive(Debug, Clone, Copy)]
pub(super) struct World(pub(super) Disturbance);

/// A disturbance, or all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worlds(pub(super) Option<Disturbance>);

const COUNT: usize = Disturbance::ALL.len();

impl ValueEnum for World {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [World; COUNT] = {
            let mut all = [World(Disturbance::Clean); COUNT];
            let mut i = 0;
            while i < COUNT {
                all[i] = World(Disturbance::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.words()))
    }
}

impl ValueEnum for Worlds {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [Worlds; COUNT + 1] = {
            let mut all = [Worlds(None); COUNT + 1];
            let mut i = 0;
            while i < COUNT {
                all[i] = Worlds(Some(Disturbance::ALL[i]));
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self.0 {
            Some(world) => World(world).to_possible_value(),
            None => Some(PossibleValue::new("all").help("each of them, the same cases in all")),
        }
    }
}
