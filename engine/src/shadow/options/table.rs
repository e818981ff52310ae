//! What the options of a technique accept, read off the schema that is derived from its struct.

use std::fmt;

use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::Options;
use crate::scene::ParamValue;

/// A word that an option accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// The word.
    pub name: String,
    /// What it asks for.
    pub doc: String,
}

/// What an option accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum Accepts {
    /// One of these words; the first is the default.
    Words(Vec<Word>),
    /// A number.
    Number {
        /// The least.
        min: f64,
        /// The greatest.
        max: f64,
        /// Whether it has to be without a fraction.
        whole: bool,
    },
    /// So many numbers.
    Numbers {
        /// How many.
        count: usize,
        /// The least of each.
        min: f64,
        /// The greatest of each.
        max: f64,
    },
    /// True or false.
    Flag,
}

impl Accepts {
    /// Whether `value` is among what is accepted.
    pub fn takes(&self, value: &ParamValue) -> bool {
        match (self, value) {
            (Self::Words(words), ParamValue::Text(text)) => words.iter().any(|word| word.name == *text),
            (Self::Number { min, max, whole }, ParamValue::Number(number)) => {
                (*min..=*max).contains(number) && (!whole || number.fract() == 0.0)
            }
            (Self::Numbers { count, min, max }, ParamValue::Numbers(numbers)) => {
                numbers.len() == *count && numbers.iter().all(|number| (*min..=*max).contains(number))
            }
            (Self::Flag, ParamValue::Flag(_)) => true,
            _ => false,
        }
    }
}

impl fmt::Display for Accepts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(words) => {
                let names: Vec<&str> = words.iter().map(|word| word.name.as_str()).collect();
                f.write_str(&names.join(", "))
            }
            Self::Number { min, max, whole: true } => write!(f, "a whole number from {min} to {max}"),
            Self::Number { min, max, whole: false } if *max >= LONG => {
                write!(f, "a number from {min} to {max:e}")
            }
            Self::Number { min, max, whole: false } => write!(f, "a number from {min} to {max}"),
            Self::Numbers { count, min, max } => {
                let letters = ["a", "b", "c", "d"].into_iter().take(*count).collect::<Vec<_>>();
                let (json, line) = (letters.join(", "), letters.join("/"));
                write!(f, "{count} numbers from {min} to {max}: [{json}], or {line} on the command line")
            }
            Self::Flag => f.write_str("true, false"),
        }
    }
}

/// From here numbers are written by their power of ten.
const LONG: f64 = 1e6;

/// One option.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionSpec {
    /// Its camelCase name.
    pub name: String,
    /// What it is for, in one line.
    pub doc: String,
    /// What it accepts.
    pub accepts: Accepts,
    /// What it is when it is left out; NaN for a number that has none, so that leaving it out says something by itself.
    pub default: ParamValue,
}

/// All options of a technique, in the order in which its struct declares them.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionTable {
    /// One for each option.
    pub options: Vec<OptionSpec>,
    /// Their JSON schema.
    pub schema: Value,
}

impl OptionTable {
    /// The table of a technique without options.
    pub fn none() -> Self {
        let schema = serde_json::json!({ "type": "object", "properties": {}, "additionalProperties": false });
        Self { options: Vec::new(), schema }
    }

    /// What `T` declares.
    pub fn of<T: Options>() -> Self {
        let settings = SchemaSettings::draft2020_12().with(|settings| {
            settings.inline_subschemas = true;
            settings.meta_schema = None;
        });
        let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
        tidy(&mut schema);
        let empty = serde_json::Map::new();
        let properties = schema["properties"].as_object().unwrap_or(&empty);
        let mut options: Vec<OptionSpec> =
            properties.iter().filter_map(|(name, property)| OptionSpec::new(name, property)).collect();
        // A schema's properties are sorted by name; what serde writes is in the order of declaration.
        let written = serde_json::to_string(&T::default()).unwrap_or_default();
        // What has no default is not written, and comes last.
        options.sort_by_key(|option| written.find(&format!("\"{}\":", option.name)).unwrap_or(usize::MAX));
        Self { options, schema }
    }

    /// The option called `name`.
    pub fn find(&self, name: &str) -> Option<&OptionSpec> {
        self.options.iter().find(|option| option.name == name)
    }

    /// The names of all options in one line; "none" where there are none.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.options.iter().map(|option| option.name.as_str()).collect();
        if names.is_empty() { "none".into() } else { names.join(", ") }
    }
}

impl OptionSpec {
    /// Whether leaving it out is the same as giving it some value.
    pub fn has_default(&self) -> bool {
        !matches!(self.default, ParamValue::Number(number) if number.is_nan())
    }

    /// Reads one property of a schema; none for what options cannot be.
    fn new(name: &str, property: &Value) -> Option<Self> {
        let range = |schema: &Value| {
            let bound = |key: &str, unbounded: f64| schema[key].as_f64().unwrap_or(unbounded);
            (bound("minimum", f64::NEG_INFINITY), bound("maximum", f64::INFINITY))
        };
        let accepts = match property["type"].as_str() {
            _ if words(property).is_some() => Accepts::Words(words(property)?),
            Some(kind @ ("number" | "integer")) => {
                let (min, max) = range(property);
                Accepts::Number { min, max, whole: kind == "integer" }
            }
            Some("array") => {
                let (min, max) = range(&property["items"]);
                Accepts::Numbers { count: property["maxItems"].as_u64()? as usize, min, max }
            }
            Some("boolean") => Accepts::Flag,
            _ => return None,
        };
        let doc = one_line(&property["description"]);
        Some(Self { name: name.into(), doc, accepts, default: ParamValue::from(&property["default"]) })
    }
}

/// The words that a schema of an enum lists.
fn words(schema: &Value) -> Option<Vec<Word>> {
    let word = |schema: &Value| {
        let name = schema["const"].as_str()?.to_owned();
        Some(Word { name, doc: one_line(&schema["description"]) })
    };
    let bare = |name: &Value| Some(Word { name: name.as_str()?.to_owned(), doc: String::new() });
    match (&schema["oneOf"], &schema["enum"]) {
        (Value::Array(variants), _) => variants.iter().map(word).collect(),
        (_, Value::Array(names)) => names.iter().map(bare).collect(),
        _ => None,
    }
}

/// A description without line breaks.
fn one_line(description: &Value) -> String {
    description.as_str().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Takes out Rust's number types and the line breaks of doc comments, which say nothing to a reader of JSON; and null, which
/// is how an optional number is left out in Rust and not in JSON.
fn tidy(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.remove("format");
            if object.get("type") == Some(&serde_json::json!(["number", "null"])) {
                object.insert("type".into(), "number".into());
                object.remove("default");
            }
            if let Some(description) = object.get_mut("description") {
                *description = one_line(description).into();
            }
            object.values_mut().for_each(tidy);
        }
        Value::Array(items) => items.iter_mut().for_each(tidy),
        _ => {}
    }
}
