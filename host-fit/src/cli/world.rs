//! Disturbances and set-ups of simulated logs, as arguments.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use fos_simulate::{Disturbance, Setup};

pub(super) fn possible_worlds() -> impl Iterator<Item = PossibleValue> {
    Disturbance::ALL.into_iter().map(|world| PossibleValue::new(world.name()).help(world.words()))
}

pub(super) fn world() -> impl TypedValueParser<Value = Disturbance> {
    let world = |name: String| Disturbance::named(&name).expect("one of the possible values");
    PossibleValuesParser::new(possible_worlds()).map(world)
}

pub(super) fn setup() -> impl TypedValueParser<Value = Setup> {
    let possible = Setup::ALL.map(|setup| PossibleValue::new(setup.name()).help(setup.words()));
    let setup = |name: String| Setup::named(&name).expect("one of the possible values");
    PossibleValuesParser::new(possible).map(setup)
}
