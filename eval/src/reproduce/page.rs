//! `docs/reproduction.html`: the document as one page that needs nothing else, its pictures in it.

use super::plot::STYLE;
use anyhow::{Context, Result};
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};

/// Nothing is loaded from anywhere; whatever asks for it is an error in the browser's console.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";

const PAGE_STYLE: &str = ":root{color-scheme:light dark}\
body{margin:0 auto;max-width:980px;padding:24px 16px 64px;background:#fff;color:#222;\
font:16px/1.5 system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif}\
h1{font-size:1.7em;line-height:1.2}h2{margin-top:2em;font-size:1.3em}h3{font-size:1.05em}\
a{color:#0058a0}code{font-size:.9em}svg{display:block;max-width:100%;height:auto}\
.table{overflow-x:auto;margin:1em 0}table{border-collapse:collapse;font-size:.86em;font-variant-numeric:tabular-nums}\
th,td{padding:.3em .6em;border-bottom:1px solid #ddd;vertical-align:top}th{border-bottom:2px solid #999;vertical-align:bottom}\
@media(prefers-color-scheme:dark){body{background:#101317;color:#e4e6ea}a{color:#7cc0ff}th,td{border-color:#333}\
th{border-color:#777}}";

/// The page of a document in Markdown; `picture` gives the SVG, without a style, of a picture by its address.
///
/// # Errors
/// The document shows a picture that there is not.
pub fn page(markdown: &str, picture: impl Fn(&str) -> Option<String>) -> Result<String> {
    let title = markdown.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or_default();
    let mut body = String::new();
    html::push_html(&mut body, events(markdown, picture)?.into_iter());
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>{PAGE_STYLE}{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    ))
}

/// The document's parts: pictures replaced, tables in a box that scrolls, headings with the names that links go to.
fn events(markdown: &str, picture: impl Fn(&str) -> Option<String>) -> Result<Vec<Event<'_>>> {
    let mut events = Vec::new();
    let mut parser = Parser::new_ext(markdown, Options::ENABLE_TABLES);
    while let Some(event) = parser.next() {
        match event {
            Event::Start(Tag::Image { dest_url, .. }) => {
                // The text that stands for the picture is its title already.
                parser.by_ref().find(|event| matches!(event, Event::End(TagEnd::Image)));
                let svg = picture(&dest_url).with_context(|| format!("the document shows {dest_url}"))?;
                events.push(Event::InlineHtml(svg.into()));
            }
            Event::Start(Tag::Heading { level, id: None, classes, attrs }) => {
                let inner: Vec<Event<'_>> =
                    parser.by_ref().take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_)))).collect();
                let id = Some(anchor(&inner).into());
                events.push(Event::Start(Tag::Heading { level, id, classes, attrs }));
                events.extend(inner);
                events.push(Event::End(TagEnd::Heading(level)));
            }
            Event::Start(Tag::Table(_)) => events.extend([Event::Html("<div class=\"table\">".into()), event]),
            Event::End(TagEnd::Table) => events.extend([event, Event::Html("</div>\n".into())]),
            other => events.push(other),
        }
    }
    Ok(events)
}

/// A heading's name as usual on the web: small letters, hyphens for blanks.
fn anchor(inner: &[Event<'_>]) -> String {
    let text = inner.iter().filter_map(|event| match event {
        Event::Text(text) | Event::Code(text) => Some(text),
        _ => None,
    });
    let text: String = text.map(CowStr::as_ref).collect();
    let kept = text.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -".contains(*c)).collect::<String>();
    kept.replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_in_it_and_tables_scroll() {
        let text = "# A & B\n\n## What was run\n\n![alt](x.svg)\n\n| a |\n|---|\n| 1 |\n";
        let page = page(text, |name| (name == "x.svg").then(|| "<svg></svg>".into())).expect("a page");
        assert!(page.contains("<svg></svg>") && !page.contains("<img"), "{page}");
        assert!(page.contains("<div class=\"table\"><table>") && page.contains("<h2 id=\"what-was-run\">"), "{page}");
        assert!(super::page(text, |_| None).is_err());
    }
}
