//! JSON that names its schema.

use serde::Deserialize;
use serde::de::DeserializeOwned;

#[derive(Debug)]
pub enum Refused {
    /// No JSON, or JSON without a required field.
    NotJson {
        /// Line of the error, from 1.
        line: usize,
        /// Column of the error, from 1.
        column: usize,
        reason: String,
    },
    /// Another schema, with its name.
    Schema(String),
}

impl From<serde_json::Error> for Refused {
    fn from(error: serde_json::Error) -> Self {
        Self::NotJson { line: error.line(), column: error.column(), reason: error.to_string() }
    }
}

/// Parses JSON that names `schema`, or that names none and has all fields.
pub fn from_json<T: DeserializeOwned>(bytes: &[u8], schema: &str) -> Result<T, Refused> {
    #[derive(Deserialize)]
    struct Named {
        schema: Option<String>,
    }
    // the schema first: JSON of another schema need not have the fields of this one
    match serde_json::from_slice(bytes)? {
        Named { schema: Some(found) } if found != schema => Err(Refused::Schema(found)),
        _ => Ok(serde_json::from_slice(bytes)?),
    }
}
