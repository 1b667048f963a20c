//! Text that is shown with its control characters visible.

use super::Scene;

/// Whether a character moves the cursor, gives the terminal a command or turns the direction of
/// text instead of being seen.
#[must_use]
pub fn is_hidden_control(c: char) -> bool {
    let turns_text =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns_text
}

/// Text for one line of a page or a terminal: control characters are shown by their escapes, such
/// as `\n` and `\u{1b}`.
#[must_use]
pub fn shown(text: &str) -> String {
    with_escapes(text, is_hidden_control)
}

/// Text of several lines, as [`shown`] but with its ends of lines and tabs.
#[must_use]
pub fn shown_lines(text: &str) -> String {
    with_escapes(text, |c| is_hidden_control(c) && c != '\n' && c != '\t')
}

fn with_escapes(text: &str, is_hidden: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_hidden(c) {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    shown
}

impl Scene {
    /// The title as pages, pictures and terminals show it; files and JSON hold it as it is.
    #[must_use]
    pub fn shown_title(&self) -> String {
        shown(&self.title)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_stays_on_its_line_and_commands_nothing() {
        let title = "a\nb\u{1b}]0;c\u{7}\t\u{202e}é λ";
        assert_eq!(shown_lines(title), "a\nb\\u{1b}]0;c\\u{7}\t\\u{202e}é λ");
        assert_eq!(shown(title), "a\\nb\\u{1b}]0;c\\u{7}\\t\\u{202e}é λ");
    }
}
