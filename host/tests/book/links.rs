//! Tests that every link, including those that the command prints, leads to an existing file and
//! heading.

use super::{documents, read, root};
use pulldown_cmark::{Event as Mark, Parser, Tag, TagEnd};
use std::path::Path;

/// Returns the anchors of a page's headings, as GitHub generates them.
fn anchors(page: &str) -> Vec<String> {
    let (mut anchors, mut heading): (Vec<String>, Option<String>) = (Vec::new(), None);
    for mark in Parser::new(page) {
        match mark {
            Mark::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Mark::End(TagEnd::Heading(_)) => {
                let text = heading.take().expect("begun").to_lowercase();
                let kept = text
                    .chars()
                    .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
                anchors.push(kept.map(|c| if c == ' ' { '-' } else { c }).collect());
            }
            Mark::Text(text) | Mark::Code(text) => {
                if let Some(heading) = &mut heading {
                    heading.push_str(&text);
                }
            }
            _ => {}
        }
    }
    anchors
}

/// Asserts that a link leads to a file and, if it has an anchor, to a heading.
fn assert_leads(page: &Path, to: &str) {
    let (file, anchor) = to.split_once('#').unwrap_or((to, ""));
    let target = if file.is_empty() {
        page.to_owned()
    } else {
        page.with_file_name("").join(file)
    };
    assert!(target.exists(), "{}: {to}", page.display());
    assert!(
        anchor.is_empty() || anchors(&read(&target)).iter().any(|name| name == anchor),
        "{}: no heading {to}",
        page.display()
    );
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut links = 0;
    for page in documents()
        .into_iter()
        .chain([root().join("docs/CHANGELOG.md")])
    {
        for mark in Parser::new(&read(&page)) {
            let (Mark::Start(Tag::Link { dest_url: to, .. })
            | Mark::Start(Tag::Image { dest_url: to, .. })) = mark
            else {
                continue;
            };
            if !to.contains("://") {
                links += 1;
                assert_leads(&page, &to);
            }
        }
    }
    assert!(links > 0, "no page has a link");
}

/// The command prints a file and a heading for each of its checks.
#[test]
fn every_check_leads_to_a_heading() {
    for row in &ridgetone_host::check::table::TABLE {
        assert_leads(&root().join("README.md"), row.page);
    }
}
