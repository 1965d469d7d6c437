//! JSON that says which schema it follows.

use serde::Deserialize;
use serde::de::DeserializeOwned;

#[derive(Debug)]
pub enum Refused {
    /// No JSON, or without a field that it must have.
    NotJson {
        /// Where, from 1.
        line: usize,
        /// Where in it, from 1.
        column: usize,
        /// What the reader says of it.
        reason: String,
    },
    /// Another schema; which.
    Schema(String),
}

impl From<serde_json::Error> for Refused {
    fn from(error: serde_json::Error) -> Self {
        Self::NotJson { line: error.line(), column: error.column(), reason: error.to_string() }
    }
}

/// Reads what follows `schema`, or names none and is complete without.
pub fn from_json<T: DeserializeOwned>(bytes: &[u8], schema: &str) -> Result<T, Refused> {
    #[derive(Deserialize)]
    struct Named {
        schema: Option<String>,
    }
    // the schema first: what follows another need not have the fields of this one
    match serde_json::from_slice(bytes)? {
        Named { schema: Some(found) } if found != schema => Err(Refused::Schema(found)),
        _ => Ok(serde_json::from_slice(bytes)?),
    }
}
