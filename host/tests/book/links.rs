//! Every link leads to a file and a heading, those that the command prints included, and the guide is
//! short.

use super::{documents, pages, read, root};
use pulldown_cmark::{Event as Mark, Parser, Tag, TagEnd};
use std::path::Path;

/// The anchors of a page's headings, as GitHub and others make them.
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

/// Fails if a link from a page leads to no file, or to no heading of a page.
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
    assert!(links > 100, "{links} links");
}

/// The command prints the file and the heading for each of its checks.
#[test]
fn every_check_leads_to_a_heading() {
    for row in &ridgetone_host::check::table::TABLE {
        assert_leads(&root().join("README.md"), row.page);
    }
}

/// A chapter begins with what its reader can do at its end, and all of them are short.
#[test]
fn the_guide_is_six_short_chapters() {
    let mut words = 0;
    let chapters = &pages()[1..];
    for (number, path) in chapters.iter().enumerate() {
        let page = read(path);
        words += page.split_whitespace().count();
        let mut lines = page.lines().filter(|line| !line.is_empty());
        let title = lines.next().expect("a title");
        assert!(title.starts_with(&format!("# {}. ", number + 1)), "{title}");
        let first = lines.next().expect("a first paragraph");
        assert!(
            first.starts_with("At the end of this chapter you "),
            "{first}"
        );
    }
    assert_eq!(chapters.len(), 6, "{chapters:?}");
    assert!(words <= 15_000, "{words} words");
    let readme = read(&root().join("README.md"));
    assert!(readme.lines().count() <= 120);
}
