//! Disturbances and set-ups of simulated logs, as arguments.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use fos_simulate::{Disturbance, Setup};

/// A disturbance, or all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worlds(pub(super) Option<Disturbance>);

fn possible_worlds() -> impl Iterator<Item = PossibleValue> {
    Disturbance::ALL.into_iter().map(|world| PossibleValue::new(world.name()).help(world.words()))
}

pub(super) fn world() -> impl TypedValueParser<Value = Disturbance> {
    let world = |name: String| Disturbance::named(&name).expect("one of the possible values");
    PossibleValuesParser::new(possible_worlds()).map(world)
}

pub(super) fn worlds() -> impl TypedValueParser<Value = Worlds> {
    let all = PossibleValue::new("all").help("each of them, the same cases in all");
    PossibleValuesParser::new(possible_worlds().chain([all])).map(|name| Worlds(Disturbance::named(&name)))
}

pub(super) fn setup() -> impl TypedValueParser<Value = Setup> {
    let possible = Setup::ALL.map(|setup| PossibleValue::new(setup.name()).help(setup.words()));
    let setup = |name: String| Setup::named(&name).expect("one of the possible values");
    PossibleValuesParser::new(possible).map(setup)
}
