//! TOML against the schema of what it should hold: its keys, types, words and kinds.
//!
//! Serde alone also takes the values of a table as a list without keys, and leaves what is beyond the end of a list of a given
//! length unread.

use std::ops::Range;

use schemars::{JsonSchema, schema_for};
use serde::Deserialize;
use serde_json::Value as Schema;
use toml::{
    Spanned,
    de::{DeInteger, DeTable, DeValue, Deserializer},
};

use super::{
    SceneError,
    error::{SchemaViolation, whole_limit},
};

/// Tables that hold exactly one kind of several, by their first kind, and words that need a table beside them: how to write them.
const EXAMPLES: [(&str, &str); 7] = [
    (
        "isotropic",
        "material.isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 }",
    ),
    ("group", "part.box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]"),
    ("constant", "friction.coefficient.constant = 0.3"),
    (
        "half_space",
        "contact.obstacle.sphere = { centre = [0.0, 0.0, -1.0], radius = 1.0 }",
    ),
    ("brick", "body.gmsh = { file = \"foot.msh\" }"),
    (
        "mean_pressure",
        "of = { mean_pressure = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]] } }",
    ),
    (
        "mean_displacement",
        "of = { mean_displacement = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], component = \"z\" } }",
    ),
];

/// How to write what was meant, where a text stands for a number or a number for a vector; nothing elsewhere.
fn remedy(options: &[&Schema], found: &DeValue<'_>) -> String {
    let takes = |wanted: &str| options.iter().any(|option| kind(option) == wanted);
    let is_vector = |option: &&Schema| option["minItems"] == 3 && option["maxItems"] == 3;
    match found {
        DeValue::String(_) if takes("number") => {
            "write the number alone, in the units of the scene; ".into()
        }
        DeValue::Integer(_) | DeValue::Float(_) if options.iter().any(is_vector) => {
            "write a vector: [1.0, 0.0, 0.0]; ".into()
        }
        _ => String::new(),
    }
}

/// Least similarity (Jaro and Winkler's, 1 for equal words) of a word that may have been meant.
const SIMILAR: f64 = 0.8;

/// Reads TOML; `name` is the file's name and `page` the page about its keys, for messages.
///
/// # Errors
/// [`SceneError::Syntax`] for text that is not TOML or has an unknown, missing or mistyped key, a list in the place of a
/// table, a list of another length.
pub fn parse_toml<'de, T: Deserialize<'de> + JsonSchema>(
    name: &str,
    text: &'de str,
    page: &str,
) -> Result<T, SceneError> {
    let keys = format!("{page} lists the keys with their types and defaults");
    let unreadable = |error| SceneError::unreadable(name, text, &error, &keys);
    let table = DeTable::parse(text).map_err(unreadable)?;
    let root = schema_for!(T).to_value();
    let checker = Checker {
        root: &root,
        keys: &keys,
        text,
    };
    checker
        .table(&root, "", table.get_ref(), 0..0)
        .map_err(|violation| SceneError::syntax(name, text, violation))?;
    T::deserialize(Deserializer::from(table)).map_err(unreadable)
}

struct Checker<'a> {
    root: &'a Schema,
    /// Where the keys are listed.
    keys: &'a str,
    text: &'a str,
}

impl<'a> Checker<'a> {
    fn value(
        &self,
        schema: &'a Schema,
        key: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), SchemaViolation> {
        let found = value.get_ref();
        let options = self.alternatives(schema);
        let Some(schema) = options.iter().find(|option| fits(kind(option), found)) else {
            let expected: Vec<_> = options
                .iter()
                .map(|option| self.type_words(option, key, options.len() > 1))
                .collect();
            let message = format!(
                "expected {}, found {}",
                expected.join(", or "),
                self.found(value)
            );
            return Err(SchemaViolation {
                key: key.to_owned(),
                message,
                help: remedy(&options, found) + self.keys,
                span: value.span(),
            });
        };
        match (kind(schema), found) {
            (CHOICE, _) => self.choice(schema, key, value),
            (_, DeValue::Integer(whole)) => self.whole(key, whole, value.span()),
            ("object", DeValue::Table(table)) => self.table(schema, key, table, value.span()),
            ("array", DeValue::Array(items)) => {
                let length = schema["minItems"].as_u64();
                if let Some(length) = length.filter(|length| *length != items.len() as u64) {
                    let message = format!("expected {length} values, found {}", items.len());
                    return self.refuse(key, value.span(), message);
                }
                items.iter().enumerate().try_for_each(|(i, item)| {
                    let own = item.get_ref().is_table().then(|| format!("{key}.{i}"));
                    self.value(&schema["items"], own.as_deref().unwrap_or(key), item)
                })
            }
            _ => Ok(()),
        }
    }

    /// Refuses a whole number that TOML cannot hold.
    fn whole(
        &self,
        key: &str,
        whole: &DeInteger<'_>,
        span: Range<usize>,
    ) -> Result<(), SchemaViolation> {
        let digits = whole.as_str().replace('_', "");
        if i64::from_str_radix(&digits, whole.radix()).is_ok() {
            return Ok(());
        }
        let found = &self.text[span.clone()];
        Err(SchemaViolation {
            key: key.to_owned(),
            message: format!("expected {}, found {found}", whole_limit()),
            help: match digits.parse::<f64>() {
                Ok(number) => format!("write {number:e} where a number serves"),
                Err(_) => self.keys.to_owned(),
            },
            span,
        })
    }

    fn table(
        &self,
        schema: &'a Schema,
        key: &str,
        table: &DeTable<'_>,
        span: Range<usize>,
    ) -> Result<(), SchemaViolation> {
        let properties = schema["properties"].as_object();
        for (name, value) in table {
            let own = format!("{key}.{}", name.get_ref());
            let own = own.trim_start_matches('.');
            match properties.and_then(|known| known.get(name.get_ref().as_ref())) {
                Some(schema) => self.value(schema, own, value)?,
                None if schema["additionalProperties"] == false => {
                    let known = properties.into_iter().flat_map(|known| known.keys());
                    let known: Vec<&str> = known.map(String::as_str).collect();
                    return self.unknown("key", own, name.get_ref(), name.span(), &known);
                }
                None => self.value(&schema["additionalProperties"], own, value)?,
            }
        }
        if key.is_empty() && table.is_empty() {
            return Err(SchemaViolation {
                key: String::new(),
                message: "line 1: expected keys, found none".to_owned(),
                help: format!(
                    "`contact3d-pipe init` writes a file to start from; {}",
                    self.keys
                ),
                span,
            });
        }
        let mut required = items(&schema["required"]).filter_map(Schema::as_str);
        if let Some(name) = required.find(|name| !table.contains_key(*name)) {
            return self.refuse(key, span, format!("missing key `{name}`"));
        }
        let kinds = items(&schema["oneOf"]).filter_map(|option| option["required"][0].as_str());
        match kinds.collect::<Vec<_>>().as_slice() {
            [] => Ok(()),
            kinds => self.one_of(kinds, key, table, span),
        }
    }

    /// One word of several, or a table with one key of several.
    fn choice(
        &self,
        schema: &'a Schema,
        key: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), SchemaViolation> {
        let options = || items(&schema["oneOf"]);
        let words: Vec<&str> = options()
            .filter_map(|option| option["const"].as_str())
            .collect();
        let tables = options().filter_map(|option| option["properties"].as_object());
        let tables: Vec<_> = tables.flatten().collect();
        let kinds: Vec<&str> = tables.iter().map(|(name, _)| name.as_str()).collect();
        let mut aliases = options().flat_map(|option| items(&option["aliases"]));
        match value.get_ref() {
            DeValue::String(word) if kinds.contains(&word.as_ref()) && !words.is_empty() => {
                Err(SchemaViolation {
                    key: key.to_owned(),
                    message: format!("expected a table with the box of the mean, found {word:?}"),
                    help: format!(
                        "write {}; --of takes what is right of the sign =",
                        example(word)
                    ),
                    span: value.span(),
                })
            }
            DeValue::String(word) if words.contains(&word.as_ref()) => Ok(()),
            DeValue::String(word) if aliases.any(|alias| alias == word.as_ref()) => Ok(()),
            DeValue::String(word) if !words.is_empty() => {
                let aliases = options().flat_map(|option| items(&option["aliases"]));
                let known = words.iter().copied();
                let known: Vec<&str> = known.chain(aliases.filter_map(Schema::as_str)).collect();
                self.unknown("word", key, word, value.span(), &known)
            }
            DeValue::Table(table)
                if !tables.is_empty() && !words.iter().any(|w| table.contains_key(*w)) =>
            {
                let mut names = table.keys();
                if let Some(name) = names.find(|name| !kinds.contains(&name.get_ref().as_ref())) {
                    let own = format!("{key}.{}", name.get_ref());
                    return self.unknown("key", &own, name.get_ref(), name.span(), &kinds);
                }
                self.one_of(&kinds, key, table, value.span())?;
                tables.iter().try_for_each(|(name, schema)| {
                    let own = format!("{key}.{name}");
                    let value = table.get(name.as_str());
                    value.map_or(Ok(()), |value| self.value(schema, &own, value))
                })
            }
            _ if words.is_empty() => Err(SchemaViolation {
                key: key.to_owned(),
                message: format!("{}; found {}", exactly_one(&kinds), self.found(value)),
                help: format!("name the kind, such as {}", example(kinds[0])),
                span: value.span(),
            }),
            found => {
                let inside =
                    |word: &&&str| found.as_table().is_some_and(|t| t.contains_key(**word));
                let meant = words.iter().find(inside).map(|word| {
                    let name = key.rsplit('.').next().unwrap_or(key);
                    format!("write {name} = {word:?}; ")
                });
                Err(SchemaViolation {
                    key: key.to_owned(),
                    message: format!("expected a word, found {}", self.found(value)),
                    help: meant.unwrap_or_default() + self.keys,
                    span: value.span(),
                })
            }
        }
    }

    /// Refuses a table with none of some kinds, or with several.
    fn one_of(
        &self,
        kinds: &[&str],
        key: &str,
        table: &DeTable<'_>,
        span: Range<usize>,
    ) -> Result<(), SchemaViolation> {
        let names = table.keys().map(|name| name.get_ref().as_ref());
        let found: Vec<&str> = names.filter(|name| kinds.contains(name)).collect();
        let (found, help) = match found.as_slice() {
            [_] => return Ok(()),
            [] => (
                "none".to_owned(),
                format!("give one of them, such as {}", example(kinds[0])),
            ),
            several => (
                several.join(" and "),
                format!("leave one of them; --set '{key}={{ ... }}' replaces the whole table"),
            ),
        };
        Err(SchemaViolation {
            key: key.to_owned(),
            message: format!("{}; found {found}", exactly_one(kinds)),
            help,
            span,
        })
    }

    fn unknown(
        &self,
        what: &str,
        key: &str,
        name: &str,
        span: Range<usize>,
        known: &[&str],
    ) -> Result<(), SchemaViolation> {
        let similarity = |known: &str| strsim::jaro_winkler(name, known);
        let nearest = known
            .iter()
            .max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
        let meant = nearest.filter(|nearest| similarity(nearest) >= SIMILAR);
        let is_of_sweep = known.contains(&"body") && ["scene", "axis"].contains(&key);
        let meant = if is_of_sweep {
            Some("`contact3d-pipe sweep` runs the file of a sweep; ".to_owned())
        } else {
            meant.map(|meant| format!("did you mean `{meant}`? "))
        };
        let expected = match known {
            [] | [_] | [_, _] => format!("`{}`", known.join("` or `")),
            several => format!("one of `{}`", several.join("`, `")),
        };
        Err(SchemaViolation {
            key: key.to_owned(),
            message: format!("unknown {what} `{name}`, expected {expected}"),
            help: meant.unwrap_or_default() + self.keys,
            span,
        })
    }

    fn refuse(
        &self,
        key: &str,
        span: Range<usize>,
        message: String,
    ) -> Result<(), SchemaViolation> {
        Err(SchemaViolation {
            key: key.to_owned(),
            message,
            help: self.keys.to_owned(),
            span,
        })
    }

    /// The schemas of which a value follows one.
    fn alternatives(&self, schema: &'a Schema) -> Vec<&'a Schema> {
        if let Some(path) = schema["$ref"].as_str() {
            let definition = self.root.pointer(path.trim_start_matches('#'));
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

    /// What a schema asks for at a key; texts beside something else are formulas.
    fn type_words(&self, schema: &'a Schema, key: &str, is_one_of_several: bool) -> String {
        let of_tables = || {
            let items = self.alternatives(&schema["items"]);
            items.iter().any(|item| kind(item) == "object")
        };
        let words = match kind(schema) {
            "object" => "a table",
            "array" => match &schema["minItems"] {
                Schema::Number(length) => return format!("a list of {length} values"),
                _ if of_tables() => return format!("several tables [[{key}]]"),
                _ => "a list",
            },
            "string" if is_one_of_several => "an expression in x, y, z as a string",
            "string" => "a string",
            "boolean" => "true or false",
            "integer" => "a whole number from 0 on",
            _ => "a number",
        };
        words.to_owned()
    }

    fn found(&self, value: &Spanned<DeValue<'_>>) -> String {
        let kind = match value.get_ref() {
            DeValue::Table(_) => return "a table".to_owned(),
            DeValue::Array(_) => return "a list".to_owned(),
            DeValue::String(text) => return format!("string {text:?}"),
            DeValue::Integer(_) => "integer",
            DeValue::Float(_) => "number",
            DeValue::Boolean(_) => "boolean",
            DeValue::Datetime(_) => "date",
        };
        format!("{kind} `{}`", &self.text[value.span()])
    }
}

/// The kind of a schema that lists words and tables with one key.
const CHOICE: &str = "choice";

/// The type that a schema asks for; empty for any.
fn kind(schema: &Schema) -> &str {
    match &schema["type"] {
        Schema::String(kind) => kind,
        // Beside null, for a key that may be left out.
        Schema::Array(kinds) => kinds[0].as_str().unwrap_or_default(),
        _ if schema["oneOf"].is_array() => CHOICE,
        _ => "",
    }
}

fn fits(kind: &str, value: &DeValue<'_>) -> bool {
    match (kind, value) {
        ("" | CHOICE, _)
        | ("object", DeValue::Table(_))
        | ("array", DeValue::Array(_))
        | ("string", DeValue::String(_))
        | ("boolean", DeValue::Boolean(_))
        | ("number", DeValue::Integer(_) | DeValue::Float(_)) => true,
        ("integer", DeValue::Integer(value)) => !value.as_str().starts_with('-'),
        _ => false,
    }
}

fn items(list: &Schema) -> impl Iterator<Item = &Schema> {
    list.as_array().into_iter().flatten()
}

fn exactly_one(kinds: &[&str]) -> String {
    format!("expected exactly one of {}", kinds.join(", "))
}

fn example(kind: &str) -> &'static str {
    let known = EXAMPLES.iter().find(|(known, _)| *known == kind);
    known.map_or("KIND = VALUE", |(_, example)| example)
}
