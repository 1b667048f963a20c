//! Formulas in other coordinates.

/// A formula with other text, in parentheses, in place of some of its names.
pub(super) fn substitute(text: &str, replacements: &[(&str, String)]) -> String {
    let bytes = text.as_bytes();
    let mut result = String::with_capacity(2 * text.len());
    let mut at = 0;
    while at < bytes.len() {
        let length = token_length(&bytes[at..]);
        let token = &text[at..at + length];
        match replacements.iter().find(|(name, _)| *name == token) {
            Some((_, replacement)) => result.extend(["(", replacement, ")"]),
            None => result.push_str(token),
        }
        at += length;
    }
    result
}

/// Bytes of the number, the name or the sign that a text begins with.
fn token_length(text: &[u8]) -> usize {
    let run = |from: usize, belongs: &dyn Fn(u8) -> bool| {
        let rest = text[from..].iter();
        from + rest.take_while(|c| belongs(**c)).count()
    };
    let is_number = |c: u8| c.is_ascii_digit() || c == b'.';
    match text[0] {
        c if is_number(c) => {
            let end = run(0, &is_number);
            let exponent = matches!(text.get(end), Some(b'e' | b'E'));
            let sign = usize::from(matches!(text.get(end + 1), Some(b'+' | b'-')));
            let digits = run((end + 1 + sign).min(text.len()), &|c| c.is_ascii_digit());
            if exponent && digits > end + 1 + sign {
                digits
            } else {
                end
            }
        }
        c if c.is_ascii_alphabetic() || c == b'_' => {
            run(0, &|c| c.is_ascii_alphanumeric() || c == b'_')
        }
        // Text that is not ASCII goes by whole characters.
        _ => run(1, &|c| c & 0xC0 == 0x80),
    }
}

#[cfg(test)]
mod tests {
    use super::substitute;

    #[test]
    fn names_are_replaced_and_numbers_and_functions_are_not() {
        let to = [("x", "y".to_owned()), ("s", "s/2".to_owned())];
        assert_eq!(substitute("exp(-x/1e-5)", &to), "exp(-(y)/1e-5)");
        assert_eq!(substitute("2e3*s1 + s*E", &to), "2e3*s1 + (s/2)*E");
        assert_eq!(substitute("1.5e-1x", &to), "1.5e-1(y)");
        assert_eq!(substitute("sinh(s)", &to), "sinh((s/2))");
    }
}
