//! What is written down of the options is what their structs declare: the extension's schema and the tables of the README.
//!
//! `WRITE_DOCS=1` writes them anew; the test fails all the same that once.

use serde_json::Value;
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::engine::shadow::{Accepts, Catalog, OptionSpec, OptionTable, extension_schema};
use shadowgraph::measure::ReferenceShadow;
use shadowgraph_testing::docs::{holds, text, with_block};

/// Every technique that scenes may name on the command line.
fn catalog() -> Catalog {
    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    catalog
}

#[test]
fn the_schema_is_what_the_options_declare() {
    holds("assets/SHADOWGRAPH_shadow_node.schema.json", &format!("{:#}\n", extension_schema(&catalog())));
}

/// The options in Markdown: name, values with the default first, and what each option is for.
fn markdown(table: &OptionTable) -> String {
    let row = |option: &OptionSpec| {
        let values = match &option.accepts {
            Accepts::Words(words) => {
                words.iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ")
            }
            Accepts::Flag => "`false`, `true`".into(),
            accepts if option.has_default() => format!("`{}` ({accepts})", option.default),
            accepts => format!("left out ({accepts})"),
        };
        format!("| `{}` | {values} | {} |\n", option.name, option.doc)
    };
    let rows: String = table.options.iter().map(row).collect();
    format!("| option | values, the default first | what it says |\n|---|---|---|\n{rows}")
}

#[test]
fn the_tables_of_the_readme_are_what_the_options_declare() {
    let mut wanted = text("README.md");
    for entry in shadowgraph::nodes::catalog().entries() {
        let name = format!("options of {}", entry.type_name);
        wanted = with_block(wanted, &name, &markdown(&(entry.options)()));
    }
    holds("README.md", &wanted);
}

/// Whether the schema lets a node pass: the part of JSON Schema that it is made of.
fn passes(schema: &Value, root: &Value, value: &Value) -> bool {
    if let Some(path) = schema["$ref"].as_str() {
        return passes(root.pointer(&path[1..]).unwrap(), root, value);
    }
    let object = schema.as_object().unwrap();
    object.iter().all(|(rule, says)| match rule.as_str() {
        "type" => match says.as_str().unwrap() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "number" => value.is_number(),
            "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
            other => panic!("type {other}"),
        },
        "minimum" => value.as_f64().is_none_or(|number| number >= says.as_f64().unwrap()),
        "maximum" => value.as_f64().is_none_or(|number| number <= says.as_f64().unwrap()),
        "minItems" => value.as_array().is_none_or(|items| items.len() as u64 >= says.as_u64().unwrap()),
        "maxItems" => value.as_array().is_none_or(|items| items.len() as u64 <= says.as_u64().unwrap()),
        "minLength" => value.as_str().is_none_or(|text| text.len() as u64 >= says.as_u64().unwrap()),
        "items" => value.as_array().is_none_or(|items| items.iter().all(|item| passes(says, root, item))),
        "const" => value == says,
        "enum" => says.as_array().unwrap().contains(value),
        "oneOf" => says.as_array().unwrap().iter().filter(|one| passes(one, root, value)).count() == 1,
        "allOf" => says.as_array().unwrap().iter().all(|one| passes(one, root, value)),
        "if" => !passes(says, root, value) || passes(&schema["then"], root, value),
        "required" => says.as_array().unwrap().iter().all(|name| value.get(name.as_str().unwrap()).is_some()),
        "properties" => {
            let says = says.as_object().unwrap();
            says.iter().all(|(name, one)| value.get(name).is_none_or(|value| passes(one, root, value)))
        }
        "additionalProperties" => value.as_object().is_none_or(|object| {
            let known = schema["properties"].as_object();
            let more = object.iter().filter(|(name, _)| known.is_none_or(|known| !known.contains_key(*name)));
            more.into_iter()
                .all(|(_, value)| if says.is_boolean() { *says == true } else { passes(says, root, value) })
        }),
        "then" | "default" | "description" | "title" | "$schema" | "$id" | "$defs" => true,
        other => panic!("this test does not know the rule '{other}'"),
    })
}

/// Every node of the catalog is constrained: what its reader refuses of single options, the schema refuses.
#[test]
fn the_schema_constrains_every_node() {
    let catalog = catalog();
    let schema = extension_schema(&catalog);
    let node = |technique: &str, option: &str, value: &ParamValue| serde_json::json!({ "type": technique, "params": { option: Value::from(value) } });
    let number = ParamValue::Number;
    let mut refused = 0;
    for entry in catalog.entries() {
        let reads = |option: &str, value: &ParamValue| {
            // Beside others an option may be accepted that is refused by itself.
            let params = Params::from([(option.to_owned(), value.clone())]);
            (entry.from_params)(&params).is_ok()
                || (entry.options)().find(option).is_some_and(|o| o.accepts.takes(value))
        };
        for option in (entry.options)().options {
            let mut tried = vec![
                ParamValue::Text("maybe".into()),
                number(-1.0),
                number(0.5),
                number(17.0),
                number(1e10),
                ParamValue::Flag(true),
                ParamValue::Numbers(vec![0.5; 3]),
                ParamValue::Numbers(vec![0.5; 2]),
                ParamValue::Numbers(vec![2.0; 3]),
                option.default.clone(),
            ];
            if let Accepts::Words(words) = &option.accepts {
                tried.extend(words.iter().map(|word| ParamValue::Text(word.name.clone())));
            }
            for value in tried {
                let (read, valid) = (
                    reads(&option.name, &value),
                    passes(&schema, &schema, &node(entry.type_name, &option.name, &value)),
                );
                assert_eq!(read, valid, "{} {}={value}", entry.type_name, option.name);
                refused += usize::from(!read);
            }
            assert!(!option.doc.is_empty(), "{} {}: say what it is for", entry.type_name, option.name);
        }
        assert!(
            !passes(&schema, &schema, &node(entry.type_name, "speed", &number(1.0))),
            "{}",
            entry.type_name
        );
    }
    assert!(refused > 100, "{refused}");
    // A technique from outside may have any options; nothing else may.
    assert!(passes(&schema, &schema, &node("Another", "speed", &number(1.0))));
    assert!(!passes(&schema, &schema, &serde_json::json!({ "type": "Another", "lights": [-1] })));
    assert!(!passes(&schema, &schema, &serde_json::json!({ "type": "Another", "speed": 1 })));
}
