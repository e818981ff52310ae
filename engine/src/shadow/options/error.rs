//! Why an option was refused: every mistake is named together with what is accepted.

use thiserror::Error;

use super::Clash;
use crate::scene::ParamValue;

/// Why an option was refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum OptionError {
    #[error("{technique} has no option '{option}' (it has: {known})")]
    Unknown { technique: &'static str, option: String, known: String },
    #[error("{technique}: option '{option}' is {value}, accepted: {accepted}")]
    BadValue { technique: &'static str, option: String, value: String, accepted: String },
    /// The option would have no effect beside the others.
    #[error("{technique}: option '{option}' is {value}, accepted: {accepted}")]
    Idle { technique: &'static str, option: String, value: String, accepted: String },
    #[error("{technique}: {problem}")]
    Unreadable { technique: &'static str, problem: String },
}

impl OptionError {
    /// The refusal of `value`.
    pub(super) fn bad_value(
        technique: &'static str,
        option: &str,
        value: &ParamValue,
        accepted: String,
    ) -> Self {
        Self::BadValue { technique, option: option.into(), value: quoted(value), accepted }
    }

    /// The refusal of `value` beside the other options.
    pub(super) fn clash(technique: &'static str, clash: Clash, value: &ParamValue) -> Self {
        match clash {
            Clash::Contradiction { option, accepted } => {
                Self::bad_value(technique, option, value, accepted.into())
            }
            Clash::Idle { option, accepted } => Self::Idle {
                technique,
                option: option.into(),
                value: quoted(value),
                accepted: accepted.into(),
            },
        }
    }
}

/// A value as it is shown: words in quotes.
fn quoted(value: &ParamValue) -> String {
    match value {
        ParamValue::Text(text) => format!("'{text}'"),
        other => other.to_string(),
    }
}
