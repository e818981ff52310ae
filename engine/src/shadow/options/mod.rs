//! The options of techniques, declared once.
//!
//! A technique's options are the fields of its struct, under serde's camelCase names. What each accepts (words, ranges) and
//! what it is for stands in the struct's types, attributes and doc comments; [`OptionTable`] reads it off the JSON schema that
//! is derived from them. Reader, writer, command line, the extension's schema and the tables of the documentation all come
//! from there. What an option is worth beside the others is said in one place, [`Options::check`].

mod error;
mod extension;
mod table;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

pub use error::OptionError;
pub use extension::extension_schema;
pub use table::{Accepts, OptionSpec, OptionTable, Word};

use super::{Setting, ShadowTechnique, TechniqueEntry};
use crate::scene::{ParamValue, Params, ShadowNode};

/// A technique's options, as a struct that serde reads and writes: camelCase, defaults for what is left out
/// (`#[serde(rename_all = "camelCase", deny_unknown_fields, default)]`), ranges by schemars' attributes.
pub trait Options: Serialize + DeserializeOwned + JsonSchema + Default + 'static {
    /// The type name that scenes use.
    const TYPE_NAME: &'static str;

    /// The options that cannot be given beside the others: they would do nothing, or contradict them. A number at its limit
    /// (a weight of 0, a light of size 0) leaves the others standing, so that numbers can be animated.
    fn check(&self) -> Vec<Clash> {
        Vec::new()
    }

    /// Reads the options; what is left out has its default.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    fn from_params(params: &Params) -> Result<Self, OptionError> {
        let technique = Self::TYPE_NAME;
        let table = OptionTable::of::<Self>();
        for (option, value) in params {
            let spec = table.find(option).ok_or_else(|| OptionError::Unknown {
                technique,
                option: option.clone(),
                known: table.names(),
            })?;
            if !spec.accepts.takes(value) {
                return Err(OptionError::bad_value(technique, option, value, spec.accepts.to_string()));
            }
        }
        let object: Map<String, Value> =
            params.iter().map(|(option, value)| (option.clone(), Value::from(value))).collect();
        let options: Self = serde_json::from_value(object.into())
            .map_err(|error| OptionError::Unreadable { technique, problem: error.to_string() })?;
        for clash in options.check() {
            if let Some(value) = params.get(clash.option()) {
                return Err(OptionError::clash(technique, clash, value));
            }
        }
        Ok(options)
    }

    /// All options in force with their values. Those that do nothing beside the others are left out, unless they were set to
    /// something: then the refusal is the reader's.
    fn to_params(&self) -> Params {
        let mut params = all_params(self);
        let clashes = self.check();
        if !clashes.is_empty() {
            let default = all_params(&Self::default());
            for option in clashes.iter().map(Clash::option) {
                if params.get(option) == default.get(option) {
                    params.remove(option);
                }
            }
        }
        params
    }
}

/// An option that cannot be given beside the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clash {
    /// The option would have no effect.
    Idle {
        /// The option.
        option: &'static str,
        /// Beside what it does something.
        accepted: &'static str,
    },
    /// The option contradicts the others.
    Contradiction {
        /// The option.
        option: &'static str,
        /// What would be accepted.
        accepted: &'static str,
    },
}

impl Clash {
    /// The name of the option that cannot be given.
    pub fn option(&self) -> &'static str {
        match self {
            Self::Idle { option, .. } | Self::Contradiction { option, .. } => option,
        }
    }
}

/// Every option with its value, whether it does anything or not.
fn all_params<T: Options>(options: &T) -> Params {
    let Ok(Value::Object(object)) = serde_json::to_value(options) else { return Params::new() };
    object.into_iter().map(|(option, value)| (option, ParamValue::from(&value))).collect()
}

impl<T: Options> From<T> for ShadowNode {
    fn from(options: T) -> Self {
        Self { technique: T::TYPE_NAME.into(), params: options.to_params(), ..Self::default() }
    }
}

impl TechniqueEntry {
    /// The entry of a technique that is the struct of its options.
    pub const fn of<T: Options + ShadowTechnique>(
        short_name: &'static str,
        summary: &'static str,
        settings: &'static [Setting],
    ) -> Self {
        Self {
            type_name: T::TYPE_NAME,
            short_name,
            summary,
            from_params: |params| Ok(Arc::new(T::from_params(params)?)),
            options: OptionTable::of::<T>,
            settings,
        }
    }
}

impl From<&ParamValue> for Value {
    /// JSON for the value; a number that is not finite becomes null, since JSON has no other word for it.
    fn from(value: &ParamValue) -> Self {
        // Whole numbers are integers, so that they can be read as such.
        let number = |number: f64| {
            let is_whole = number.fract() == 0.0 && number.abs() <= MAX_WHOLE;
            if is_whole { Self::from(number as i64) } else { Self::from(number) }
        };
        match value {
            ParamValue::Text(text) => Self::from(text.as_str()),
            ParamValue::Flag(flag) => Self::from(*flag),
            ParamValue::Number(value) => number(*value),
            ParamValue::Numbers(numbers) => numbers.iter().copied().map(number).collect(),
        }
    }
}

/// Up to here every f64 without a fraction is the integer it looks like.
const MAX_WHOLE: f64 = 9_007_199_254_740_992.0;

impl From<&Value> for ParamValue {
    /// The value of JSON that options are made of; null, which is what serde writes for numbers that are not finite, is NaN.
    fn from(value: &Value) -> Self {
        match value {
            Value::String(text) => Self::Text(text.clone()),
            Value::Bool(flag) => Self::Flag(*flag),
            Value::Array(items) => {
                Self::Numbers(items.iter().map(|item| item.as_f64().unwrap_or(f64::NAN)).collect())
            }
            other => Self::Number(other.as_f64().unwrap_or(f64::NAN)),
        }
    }
}
