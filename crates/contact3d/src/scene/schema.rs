//! Ways through the JSON Schema of a type.

use schemars::{JsonSchema, schema_for};
use serde_json::Value as Schema;

/// The JSON Schema of a type.
pub(super) struct SchemaTree(Schema);

/// The kind of a schema that lists words and tables with one key.
pub(super) const CHOICE: &str = "choice";

impl SchemaTree {
    /// The schema of a type.
    pub(super) fn of<T: JsonSchema>() -> Self {
        Self(schema_for!(T).to_value())
    }

    /// The schema of the type itself.
    pub(super) fn root(&self) -> &Schema {
        &self.0
    }

    /// The schemas of which a value follows one.
    pub(super) fn alternatives<'a>(&'a self, schema: &'a Schema) -> Vec<&'a Schema> {
        if let Some(path) = schema["$ref"].as_str() {
            let definition = self.0.pointer(path.trim_start_matches('#'));
            return self.alternatives(definition.expect("the schema defines what it refers to"));
        }
        match schema["anyOf"].as_array() {
            Some(options) => options
                .iter()
                .flat_map(|option| self.alternatives(option))
                .filter(|option| kind(option) != "null")
                .collect(),
            None => vec![schema],
        }
    }
}

/// The type that a schema asks for; empty for any.
pub(super) fn kind(schema: &Schema) -> &str {
    match &schema["type"] {
        Schema::String(kind) => kind,
        // Beside null, for a key that may be left out.
        Schema::Array(kinds) => kinds[0].as_str().unwrap_or_default(),
        _ if schema["oneOf"].is_array() => CHOICE,
        _ => "",
    }
}

/// The items of a list, none of anything else.
pub(super) fn items(list: &Schema) -> impl Iterator<Item = &Schema> {
    list.as_array().into_iter().flatten()
}
