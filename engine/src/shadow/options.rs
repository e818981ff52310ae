//! Reading the options of a shadow node: every mistake is named together with what is accepted.

use thiserror::Error;

use crate::scene::{ParamValue, Params};

/// Why an option was refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum OptionError {
    #[error("{technique} has no option '{option}' (it has: {known})")]
    Unknown { technique: &'static str, option: String, known: String },
    #[error("{technique}: option '{option}' is {value}, accepted: {accepted}")]
    BadValue { technique: &'static str, option: String, value: String, accepted: String },
}

/// Reads a technique's options one by one, then checks that none was left over.
#[derive(Debug)]
pub struct OptionReader<'a> {
    technique: &'static str,
    params: &'a Params,
    known: Vec<&'static str>,
}

impl<'a> OptionReader<'a> {
    /// A reader of `params` for `technique`.
    pub fn new(technique: &'static str, params: &'a Params) -> Self {
        Self { technique, params, known: Vec::new() }
    }

    /// One of several named values; the first is the default.
    ///
    /// # Errors
    /// [`OptionError::BadValue`] lists the names.
    pub fn choice<T: Copy>(
        &mut self,
        option: &'static str,
        values: &[(&'static str, T)],
    ) -> Result<T, OptionError> {
        self.known.push(option);
        let chosen = match self.params.get(option) {
            None => Some(values[0].1),
            Some(ParamValue::Text(text)) => {
                values.iter().find(|(name, _)| name == text).map(|(_, value)| *value)
            }
            Some(_) => None,
        };
        chosen.ok_or_else(|| {
            let names: Vec<&str> = values.iter().map(|(name, _)| *name).collect();
            self.bad_value(option, names.join(", "))
        })
    }

    /// A number from `min` to `max`.
    ///
    /// # Errors
    /// [`OptionError::BadValue`] names the range.
    pub fn number(
        &mut self,
        option: &'static str,
        default: f64,
        min: f64,
        max: f64,
    ) -> Result<f64, OptionError> {
        self.known.push(option);
        match self.params.get(option) {
            None => Ok(default),
            Some(ParamValue::Number(number)) if *number >= min && *number <= max => Ok(*number),
            Some(_) => Err(self.bad_value(option, format!("a number from {min} to {max}"))),
        }
    }

    /// Makes `option` known, for a value that the caller reads by itself.
    pub fn known(&mut self, option: &'static str) {
        self.known.push(option);
    }

    /// The refusal of a value that is fine by itself but not beside the other options.
    #[must_use]
    pub fn conflict(&self, option: &str, accepted: &str) -> OptionError {
        self.bad_value(option, accepted.into())
    }

    /// Checks that every given option was asked for.
    ///
    /// # Errors
    /// [`OptionError::Unknown`] names the first that was not, and those there are.
    pub fn finish(self) -> Result<(), OptionError> {
        match self.params.keys().find(|name| !self.known.contains(&name.as_str())) {
            None => Ok(()),
            Some(option) => Err(OptionError::Unknown {
                technique: self.technique,
                option: option.clone(),
                known: if self.known.is_empty() { "none".into() } else { self.known.join(", ") },
            }),
        }
    }

    fn bad_value(&self, option: &str, accepted: String) -> OptionError {
        let value = match self.params.get(option) {
            Some(ParamValue::Text(text)) => format!("'{text}'"),
            Some(ParamValue::Number(number)) => number.to_string(),
            Some(ParamValue::Flag(flag)) => flag.to_string(),
            Some(ParamValue::Numbers(numbers)) => format!("{numbers:?}"),
            None => "missing".into(),
        };
        OptionError::BadValue { technique: self.technique, option: option.into(), value, accepted }
    }
}
