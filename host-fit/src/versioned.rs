//! JSON that says which schema it follows.

use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Why it is not read.
#[derive(Debug)]
pub(crate) enum Refused {
    /// No JSON, or without a field that it must have.
    NotJson(serde_json::Error),
    /// Another schema; which.
    Schema(String),
}

/// Reads what follows `schema`, or names none and is complete without.
pub(crate) fn from_json<T: DeserializeOwned>(bytes: &[u8], schema: &str) -> Result<T, Refused> {
    #[derive(Deserialize)]
    struct Named {
        schema: Option<String>,
    }
    // the schema first: what follows another need not have the fields of this one
    match serde_json::from_slice(bytes).map_err(Refused::NotJson)? {
        Named { schema: Some(found) } if found != schema => Err(Refused::Schema(found)),
        _ => serde_json::from_slice(bytes).map_err(Refused::NotJson),
    }
}
