//! A report as one HTML page: its parts as plain data, and the page with everything inside it, so
//! that it opens from the file system without network, scripts or fonts of its own. Only a page with a body in
//! 3D has one script; a Content-Security-Policy keeps it from loading anything, and every other script from running.
//!
//! Values show when the reader points at them: they are the `title` elements of the drawings.

mod view3d;

pub use view3d::{BodyView, ViewArray, ViewPlace, ViewValues};

use std::borrow::Cow;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use base64::{Engine, engine::general_purpose::STANDARD};

use super::Chart;

/// The style of every page.
const STYLE: &str = include_str!("style.css");

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// The heading.
    pub title: String,
    /// A line below it; none when empty.
    pub subtitle: String,
    /// What the reader should know before believing anything; nothing when empty.
    pub warning: String,
    /// The line at the end.
    pub footer: String,
    /// Its sections.
    pub sections: Vec<Section>,
}

/// A section of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Name in links: ASCII letters and hyphens.
    pub name: &'static str,
    /// The heading.
    pub heading: String,
    /// Its parts.
    pub parts: Vec<PagePart>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum PagePart {
    /// A paragraph.
    Text(String),
    /// A paragraph that matters most.
    Advice(String),
    /// Something the reader should know before believing the rest.
    Warning(String),
    /// Text as it stands in a file, folded away below its name.
    Listing(String, String),
    /// A table.
    Table(PageTable),
    /// An SVG document.
    Figure(String),
    /// A PNG, folded away where a script draws more, with its name.
    Picture(String, Vec<u8>),
    /// A body in 3D; one in a page.
    Body(BodyView),
}

/// A table of texts; below the name of a column, cells that read as numbers are set to the right.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PageTable {
    /// What it shows; none when empty.
    pub caption: String,
    /// Names of the columns; none when empty.
    pub head: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

impl PageTable {
    /// A table of two columns: names and values.
    #[must_use]
    pub fn of_pairs(pairs: impl IntoIterator<Item = (String, String)>) -> Self {
        let rows = pairs.into_iter().map(|(name, value)| vec![name, value]);
        Self {
            rows: rows.collect(),
            ..Self::default()
        }
    }
}

impl Page {
    /// The page as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        let parts = self.sections.iter().flat_map(|section| &section.parts);
        let interactive = parts
            .into_iter()
            .any(|part| matches!(part, PagePart::Body(_)));
        let style: Cow<'_, str> = if interactive {
            [STYLE, view3d::STYLE].concat().into()
        } else {
            STYLE.into()
        };
        let sections = html! { @for section in &self.sections { (section.markup()) } };
        // Script and style are known by a word that nothing in the page can foresee.
        let nonce = &blake3::hash(sections.0.as_bytes()).to_hex()[..32];
        let policy = format!(
            "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data:; base-uri 'none'; form-action 'none'"
        );
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    @if interactive { meta http-equiv="Content-Security-Policy" content=(policy); }
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    // An icon in the page itself: a browser asks the network for none.
                    link rel="icon" href="data:,";
                    title { (self.title) }
                    style nonce=[interactive.then_some(nonce)] { (PreEscaped(&style)) }
                }
                body {
                    header {
                        h1 { (self.title) }
                        @if !self.subtitle.is_empty() { p { (self.subtitle) } }
                        @if !self.warning.is_empty() { p.warning { (self.warning) } }
                        nav {
                            @for section in &self.sections {
                                a href={ "#" (section.name) } { (section.heading) } " "
                            }
                        }
                    }
                    main {
                        (sections)
                        @if interactive { script nonce=(nonce) { (PreEscaped(view3d::SCRIPT)) } }
                    }
                    footer { p { (self.footer) } }
                }
            }
        };
        page.into_string() + "\n"
    }
}

impl Section {
    /// A section of some parts.
    #[must_use]
    pub fn new(name: &'static str, heading: &str, parts: Vec<PagePart>) -> Self {
        Self {
            name,
            heading: heading.to_owned(),
            parts,
        }
    }

    fn markup(&self) -> Markup {
        html! {
            section id=(self.name) {
                h2 { (self.heading) }
                @for part in &self.parts { (part.markup()) }
            }
        }
    }
}

impl PagePart {
    /// A chart.
    #[must_use]
    pub fn chart(chart: &Chart) -> Self {
        Self::Figure(chart.figure().svg())
    }

    fn markup(&self) -> Markup {
        match self {
            Self::Text(text) => html! { p { (text) } },
            Self::Advice(text) => html! { p.advice { (text) } },
            Self::Warning(text) => html! { p.warning { (text) } },
            Self::Listing(name, text) => {
                html! { details { summary { (name) } pre { (text) } } }
            }
            Self::Table(table) => table.markup(),
            Self::Picture(name, png) => html! {
                details.picture open {
                    summary { (name) }
                    img src={ "data:image/png;base64," (STANDARD.encode(png)) } alt=(name);
                }
            },
            Self::Body(body) => body.markup(),
            Self::Figure(svg) => html! { figure { (PreEscaped(without_prolog(svg))) } },
        }
    }
}

impl PageTable {
    fn markup(&self) -> Markup {
        let has_columns = !self.head.is_empty();
        let cell = |text: &String| {
            let right = has_columns && is_number(text);
            html! { td.number[right] { (text) } }
        };
        html! {
            div.table {
                table {
                    @if !self.caption.is_empty() { caption { (self.caption) } }
                    @if has_columns {
                        thead { tr { @for name in &self.head { th { (name) } } } }
                    }
                    tbody {
                        @for row in &self.rows { tr { @for text in row { (cell(text)) } } }
                    }
                }
            }
        }
    }
}

/// Whether a cell begins with a number.
fn is_number(text: &str) -> bool {
    let first = text.split_whitespace().next().unwrap_or("");
    text == "-" || first.trim_end_matches(',').parse::<f64>().is_ok()
}

/// An SVG document without the XML declaration, which HTML does not allow inside it.
fn without_prolog(svg: &str) -> &str {
    svg.find("<svg").map_or(svg, |start| &svg[start..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out_of_the_page() {
        let hostile = "<script>alert(\"1\")</script> & more";
        let page = Page {
            title: hostile.into(),
            subtitle: hostile.into(),
            warning: hostile.into(),
            footer: String::new(),
            sections: vec![Section {
                name: "one",
                heading: hostile.into(),
                parts: vec![
                    PagePart::Text(hostile.into()),
                    PagePart::Listing(hostile.into(), hostile.into()),
                    PagePart::Table(PageTable::of_pairs([(hostile.into(), hostile.into())])),
                ],
            }],
        };
        let html = page.html();
        assert!(!html.contains("<script"), "{html}");
        assert_eq!(html.matches("&lt;script&gt;").count(), 11, "{html}");
    }

    #[test]
    fn drawings_come_without_their_declaration() {
        let page = Page {
            title: "A".into(),
            subtitle: String::new(),
            warning: String::new(),
            footer: String::new(),
            sections: vec![Section {
                name: "one",
                heading: "One".into(),
                parts: vec![PagePart::Figure(
                    "<?xml version=\"1.0\"?>\n<svg></svg>".into(),
                )],
            }],
        };
        assert!(page.html().contains("<figure><svg></svg></figure>"));
    }
}
