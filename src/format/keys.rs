//! Values at dotted key paths of a scene, such as `friction.coefficient_1.constant` or
//! `traction.0.value`.

use toml::Value;

/// Puts a value at a key path; tables that are not there are made, items of lists must be there.
///
/// # Errors
/// The part of the path that leads nowhere.
pub fn set(table: &mut toml::Table, key: &str, value: Value) -> Result<(), String> {
    let (first, rest) = split(key);
    match rest {
        None => {
            table.insert(first.to_owned(), value);
            Ok(())
        }
        Some(rest) => {
            let below = table
                .entry(first)
                .or_insert_with(|| Value::Table(toml::Table::new()));
            set_below(below, first, rest, value)
        }
    }
}

fn set_below(place: &mut Value, name: &str, key: &str, value: Value) -> Result<(), String> {
    match place {
        Value::Table(table) => set(table, key, value),
        Value::Array(items) => {
            let (first, rest) = split(key);
            let item = first.parse::<usize>().ok().and_then(|i| items.get_mut(i));
            let item = item.ok_or_else(|| format!("no item {first} in the list {name}"))?;
            match rest {
                None => *item = value,
                Some(rest) => set_below(item, first, rest, value)?,
            }
            Ok(())
        }
        _ => Err(format!("{name} is neither a table nor a list")),
    }
}

/// The value at a key path; `None` where it leads nowhere.
pub fn get<'a>(table: &'a toml::Table, key: &str) -> Option<&'a Value> {
    let mut parts = key.split('.');
    let mut found = table.get(parts.next()?)?;
    for part in parts {
        found = match found {
            Value::Table(table) => table.get(part)?,
            Value::Array(items) => items.get(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(found)
}

fn split(key: &str) -> (&str, Option<&str>) {
    match key.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (key, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_set_in_tables_and_lists() {
        let mut table: toml::Table = "a = 1\n[[t]]\nv = [1, 2]\n".parse().unwrap();
        set(&mut table, "t.0.v.1", Value::Integer(5)).unwrap();
        set(&mut table, "b.c.d", Value::Boolean(true)).unwrap();
        assert_eq!(get(&table, "t.0.v.1"), Some(&Value::Integer(5)));
        assert_eq!(get(&table, "b.c.d"), Some(&Value::Boolean(true)));
        assert_eq!(get(&table, "t.1.v"), None);
        for key in ["t.1.v", "t.x", "a.b"] {
            assert!(set(&mut table, key, Value::Integer(0)).is_err(), "{key}");
        }
    }
}
