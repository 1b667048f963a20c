//! The JSON Schema of a type, and TOML against it: its keys, types, words and kinds.
//!
//! Serde alone also takes the values of a table as a list without keys, and leaves what is beyond the end of a list of a given
//! length unread.

use std::ops::Range;

use schemars::{JsonSchema, schema_for};
use serde_json::Value as Schema;
use toml::{
    Spanned,
    de::{DeInteger, DeTable, DeValue},
};

use super::{Expression, SyntaxProblem, source::whole_limit};

/// The JSON Schema of a type.
pub(super) struct SchemaTree(pub(super) Schema);

/// The kind of a schema that lists words and tables with one key.
pub(super) const CHOICE: &str = "choice";

/// The format of strings that are formulas.
pub(super) const FORMULA: &str = "formula";

impl SchemaTree {
    /// The schema of a type.
    pub(super) fn of<T: JsonSchema>() -> Self {
        Self(schema_for!(T).to_value())
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

/// What may limit the numbers of a key.
const LIMITS: [&str; 4] = ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"];

/// Puts limits of the numbers of a list, or of a kind with one key, where JSON Schema looks for them: beside the type of the numbers.
pub(super) fn limit_numbers(schema: &mut Schema) {
    let kind = kind(schema).to_owned();
    if let Schema::Object(words) = schema {
        let inner = match kind.as_str() {
            "array" => words.get("items").map(|_| "items"),
            "object" => words.get("properties").map(|_| "properties"),
            _ => None,
        };
        if let Some(inner) = inner {
            let limits = LIMITS.map(|limit| Some((limit, words.get(limit)?.clone())));
            words.retain(|word, _| !LIMITS.contains(&word.as_str()));
            let of_numbers = match &mut words[inner] {
                Schema::Object(properties) if inner == "properties" => {
                    properties.values_mut().collect()
                }
                items => vec![items],
            };
            for numbers in of_numbers {
                for (limit, value) in limits.iter().flatten() {
                    numbers[*limit] = value.clone();
                }
            }
        }
        words.values_mut().for_each(limit_numbers);
    } else if let Schema::Array(options) = schema {
        options.iter_mut().for_each(limit_numbers);
    }
}

/// The items of a list, none of anything else.
pub(super) fn items(list: &Schema) -> impl Iterator<Item = &Schema> {
    list.as_array().into_iter().flatten()
}

/// A key that a text gives.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) key: String,
    pub(super) name: Range<usize>,
    pub(super) value: Range<usize>,
}

/// Compares a text with the schema of what it should hold.
pub(super) struct Checker<'a> {
    pub(super) schema: &'a SchemaTree,
    /// Where the keys are listed, in words.
    pub(super) keys: &'a str,
    pub(super) text: &'a str,
    /// The keys that were found, tables before what is in them.
    pub(super) places: Vec<Place>,
}

impl<'a> Checker<'a> {
    fn value(
        &mut self,
        schema: &'a Schema,
        key: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), SyntaxProblem> {
        let found = value.get_ref();
        let options = self.schema.alternatives(schema);
        let Some(schema) = options.iter().find(|option| fits(kind(option), found)) else {
            let expected: Vec<_> = options
                .iter()
                .map(|option| self.type_words(option, key, options.len() > 1))
                .collect();
            let expected = expected.join(", or ");
            let message = format!("expected {expected}, found {}", self.describe(value));
            let bodies = found.is_array().then(|| beyond_model(key)).flatten();
            let help = bodies.unwrap_or_default() + &remedy(&options, found) + self.keys;
            return refuse(key, value.span(), message, help);
        };
        match (kind(schema), found) {
            (CHOICE, _) => self.choice(schema, key, value),
            (_, DeValue::String(text)) if schema["format"] == FORMULA => {
                match Expression::unbound(text, &[]) {
                    Ok(_) => Ok(()),
                    Err(error) => refuse(key, value.span(), error.to_string(), self.keys),
                }
            }
            (_, DeValue::Integer(whole)) => self.whole(key, whole, value.span()),
            ("object", DeValue::Table(table)) => self.table(schema, key, table, value.span()),
            ("array", DeValue::Array(items)) => {
                let length = schema["minItems"].as_u64();
                if let Some(length) = length.filter(|length| *length != items.len() as u64) {
                    let message = format!("expected {length} values, found {}", items.len());
                    return refuse(key, value.span(), message, self.keys);
                }
                items.iter().enumerate().try_for_each(|(i, item)| {
                    let own = item.get_ref().is_table().then(|| format!("{key}.{i}"));
                    if let Some(own) = &own {
                        self.add_place(own, item.span(), item.span());
                    }
                    self.value(&schema["items"], own.as_deref().unwrap_or(key), item)
                })
            }
            _ => Ok(()),
        }
    }

    fn add_place(&mut self, key: &str, name: Range<usize>, value: Range<usize>) {
        let key = key.to_owned();
        self.places.push(Place { key, name, value });
    }

    /// Refuses a whole number that TOML cannot hold.
    fn whole(
        &self,
        key: &str,
        whole: &DeInteger<'_>,
        span: Range<usize>,
    ) -> Result<(), SyntaxProblem> {
        let digits = whole.as_str().replace('_', "");
        if i64::from_str_radix(&digits, whole.radix()).is_ok() {
            return Ok(());
        }
        let found = &self.text[span.clone()];
        let help = match digits.parse::<f64>() {
            Ok(number) => format!("write {number:e} where a number serves"),
            Err(_) => self.keys.to_owned(),
        };
        let message = format!("expected {}, found {found}", whole_limit());
        refuse(key, span, message, help)
    }

    /// Checks a table; the whole text has no key.
    pub(super) fn table(
        &mut self,
        schema: &'a Schema,
        key: &str,
        table: &DeTable<'_>,
        span: Range<usize>,
    ) -> Result<(), SyntaxProblem> {
        let properties = schema["properties"].as_object();
        for (name, value) in table {
            let own = format!("{key}.{}", name.get_ref());
            let own = own.trim_start_matches('.');
            self.add_place(own, name.span(), value.span());
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
            let message = "line 1: expected keys, found none".to_owned();
            let help = "`contact3d-pipe init` writes a file to start from; ".to_owned() + self.keys;
            return refuse(key, span, message, help);
        }
        let mut required = items(&schema["required"]).filter_map(Schema::as_str);
        if let Some(name) = required.find(|name| !table.contains_key(*name)) {
            return refuse(key, span, format!("missing key `{name}`"), self.keys);
        }
        let kinds = items(&schema["oneOf"]).filter_map(|option| option["required"][0].as_str());
        match kinds.collect::<Vec<_>>().as_slice() {
            [] => Ok(()),
            kinds => one_of(schema, kinds, key, table, span),
        }
    }

    /// One word of several, or a table with one key of several.
    fn choice(
        &mut self,
        schema: &'a Schema,
        key: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), SyntaxProblem> {
        let options = || items(&schema["oneOf"]);
        let words: Vec<&str> = options()
            .filter_map(|option| option["const"].as_str())
            .collect();
        let kind_of = |option: &'a Schema| option["required"][0].as_str();
        let kinds: Vec<&str> = options().filter_map(kind_of).collect();
        match value.get_ref() {
            DeValue::String(word) if words.contains(&word.as_ref()) => Ok(()),
            DeValue::String(word) if !words.is_empty() => {
                match options().find(|option| kind_of(option) == Some(word.as_ref())) {
                    Some(option) => {
                        let message =
                            format!("expected a table with the box of the mean, found {word:?}");
                        let example = example(option);
                        let help =
                            format!("write {example}; --of takes what is right of the sign =");
                        refuse(key, value.span(), message, help)
                    }
                    None => self.unknown("word", key, word, value.span(), &words),
                }
            }
            DeValue::Table(table)
                if !kinds.is_empty() && !words.iter().any(|w| table.contains_key(*w)) =>
            {
                let mut names = table.keys();
                if let Some(name) = names.find(|name| !kinds.contains(&name.get_ref().as_ref())) {
                    let own = format!("{key}.{}", name.get_ref());
                    return self.unknown("key", &own, name.get_ref(), name.span(), &kinds);
                }
                one_of(schema, &kinds, key, table, value.span())?;
                options().try_for_each(|option| match kind_of(option) {
                    Some(kind) if table.contains_key(kind) => {
                        self.table(option, key, table, value.span())
                    }
                    _ => Ok(()),
                })
            }
            _ if words.is_empty() => {
                let found = self.describe(value);
                let message = format!("{}; found {found}", exactly_one(&kinds));
                let help = format!("name the kind, such as {}", example(schema));
                refuse(key, value.span(), message, help)
            }
            found => {
                let inside =
                    |word: &&&str| found.as_table().is_some_and(|t| t.contains_key(**word));
                let meant = words.iter().find(inside).map(|word| {
                    let name = key.rsplit('.').next().unwrap_or(key);
                    format!("write {name} = {word:?}; ")
                });
                let message = format!("expected a word, found {}", self.describe(value));
                let help = meant.unwrap_or_default() + self.keys;
                refuse(key, value.span(), message, help)
            }
        }
    }

    fn unknown(
        &self,
        what: &str,
        key: &str,
        name: &str,
        span: Range<usize>,
        known: &[&str],
    ) -> Result<(), SyntaxProblem> {
        let is_of_sweep = known.contains(&"body") && ["scene", "axis"].contains(&key);
        let meant = match name {
            _ if is_of_sweep => {
                Some("`contact3d-pipe sweep` runs the file of a sweep; ".to_owned())
            }
            "slip_interpolation" => {
                Some("slips are those at the nodes: leave the key out; ".to_owned())
            }
            _ => beyond_model(name).or_else(|| nearest(name, known)),
        };
        let expected = match known {
            [] | [_] | [_, _] => format!("`{}`", known.join("` or `")),
            several => format!("one of `{}`", several.join("`, `")),
        };
        let message = format!("unknown {what} `{name}`, expected {expected}");
        refuse(key, span, message, meant.unwrap_or_default() + self.keys)
    }

    /// What a schema asks for at a key; texts beside something else are formulas.
    fn type_words(&self, schema: &'a Schema, key: &str, is_one_of_several: bool) -> String {
        let of_tables = || {
            let items = self.schema.alternatives(&schema["items"]);
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

    fn describe(&self, value: &Spanned<DeValue<'_>>) -> String {
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

/// The question whether one of some words was meant, before other help; `None` where none is like it.
pub(crate) fn nearest(name: &str, known: &[impl AsRef<str>]) -> Option<String> {
    let similarity = |known: &str| strsim::jaro_winkler(name, known);
    let known = known.iter().map(AsRef::as_ref);
    let nearest = known.max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    // Jaro and Winkler's similarity is 1 for equal words.
    (similarity(nearest) >= 0.8).then(|| format!("did you mean `{nearest}`? "))
}

/// What to do where a name stands a second time.
pub(super) fn help_for_second(name: &str, help: &str) -> String {
    let beyond = beyond_model(name).unwrap_or_default();
    format!("{beyond}a table stands once; of a list, every entry begins with [[{name}]]; {help}")
}

/// What is said of a key for what this program does not model, with the nearest that it does; `None` for other keys.
fn beyond_model(name: &str) -> Option<String> {
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let words = if has(&["plastic", "yield", "hardening"]) {
        "materials are elastic, without plasticity: compare the largest von Mises stress with the yield stress"
    } else if has(&[
        "density",
        "gravity",
        "time_step",
        "mass",
        "damping",
        "velocity",
        "frequency",
        "dynamic",
    ]) {
        "there is no dynamics and no mass: weight is body_force = { value = [0.0, 0.0, -76500.0] }, slow motion a history of [[step]]"
    } else if has(&["temperature", "thermal", "heat", "conductivity"]) {
        "there is no heat: a change of size that another program computed may be a `value` of clamps, or a contact.gap"
    } else if has(&[
        "large_",
        "nlgeom",
        "nonlinear",
        "hyperelastic",
        "neo_hook",
        "mooney",
    ]) {
        "deformations are small and materials linear: rubber takes a Poisson's ratio near 0.5"
    } else if has(&["symmetry"]) {
        "a plane of symmetry is a [[clamp]] of its face with components = [\"x\"], \"y\" or \"z\""
    } else if has(&["point_load", "line_load", "node"]) || name == "nodal_force" {
        "stress under a load at a point has no bound: [[force]] takes a face, or disc = { centre, radius } on it"
    } else if has(&["self_contact"]) {
        "a body does not touch itself: cut it into two [[body]] with a [[contact]] between them"
    } else if ["tie", "tied", "bonded", "bolt", "preload"].contains(&name) {
        "bodies that share nodes are one; a face keeps plane, and is pulled, as the `face` of a [[tool]]"
    } else if ["bodies", "body2", "body_2", "contact_pair"].contains(&name) {
        "several bodies are tables [[body]] with a name each, and [[contact]] has between = [\"a.face\", \"b.face\"]"
    } else {
        return None;
    };
    Some(format!("{words}; "))
}

fn refuse(
    key: &str,
    span: Range<usize>,
    message: String,
    help: impl Into<String>,
) -> Result<(), SyntaxProblem> {
    Err(SyntaxProblem::new(key, span, message, help))
}

/// Refuses a table with none of some kinds, or with several.
fn one_of(
    schema: &Schema,
    kinds: &[&str],
    key: &str,
    table: &DeTable<'_>,
    span: Range<usize>,
) -> Result<(), SyntaxProblem> {
    let names = table.keys().map(|name| name.get_ref().as_ref());
    let found: Vec<&str> = names.filter(|name| kinds.contains(name)).collect();
    let (found, help) = match found.as_slice() {
        [_] => return Ok(()),
        [] => {
            let example = example(schema);
            let help = format!("give one of them, such as {example}");
            ("none".to_owned(), help)
        }
        several => (
            several.join(" and "),
            format!("leave one of them; --set '{key}={{ ... }}' replaces the whole table"),
        ),
    };
    let message = format!("{}; found {found}", exactly_one(kinds));
    refuse(key, span, message, help)
}

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

fn exactly_one(kinds: &[&str]) -> String {
    format!("expected exactly one of {}", kinds.join(", "))
}

/// How to write a table that is one kind of several, which stands beside its type.
fn example(schema: &Schema) -> &str {
    schema["examples"][0].as_str().unwrap_or("KIND = VALUE")
}
