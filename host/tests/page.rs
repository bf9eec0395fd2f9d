//! The page of the reproduction in a real browser without a network. `cargo xtask test` installs one and runs this.

#[path = "common/browser.rs"]
mod browser;

use browser::{Look, PATIENCE};
use serde_json::Value;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

const SCRIPT: &str = include_str!("page.js");

fn shipped() -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/reproduction.html");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What a browser makes of a page from disk, every name of a host unknown to it: the document at the end, and what was
/// said in its console.
fn opened(html: &str, look: Look) -> (String, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    fs::write(file("page.html"), html).expect("the page is written");
    let mut command = browser::command(&file("profile"), look);
    command.arg("--dump-dom").arg(format!("file://{}", file("page.html").display()));
    let create = |name: &str| Stdio::from(File::create(file(name)).expect("a file"));
    let mut child =
        command.stdout(create("dom")).stderr(create("log")).spawn().expect("a browser: cargo xtask setup installs one");
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().expect("the browser runs") {
            Some(status) => break status,
            None if begun.elapsed() > PATIENCE => {
                child.kill().expect("the browser can be stopped");
                panic!("the browser has not come to an end");
            }
            None => sleep(Duration::from_millis(50)),
        }
    };
    let read = |path: &Path| String::from_utf8_lossy(&fs::read(path).expect("a file")).into_owned();
    let log = read(&file("log"));
    assert!(status.success(), "{log}");
    let console = log.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
    (read(&file("dom")), console)
}

/// What the script found in a page, which it may run in a copy of.
fn report(html: &str, look: Look) -> Value {
    let copy = html.replace("default-src 'none'", "default-src 'none'; script-src 'unsafe-inline'");
    let copy = copy.replace("</body>", &format!("<script>{SCRIPT}</script></body>"));
    let (dom, _) = opened(&copy, look);
    let (_, rest) = dom.split_once("<pre id=\"report\">").unwrap_or_else(|| panic!("no report in {dom}"));
    let json = rest.split("</pre>").next().unwrap_or_default();
    let json = json.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&json).expect("JSON")
}

const LOOKS: [Look; 4] = [
    Look { width: 1200, height: 900, dark: false },
    Look { width: 1200, height: 900, dark: true },
    Look { width: 700, height: 900, dark: false },
    Look { width: 700, height: 900, dark: true },
];

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn the_page_is_whole_without_a_network_in_light_and_dark() {
    let page = shipped();
    for look in LOOKS {
        let (_, console) = opened(&page, look);
        assert!(console.is_empty(), "{look:?}: {console:?}");
        let found = report(&page, look);
        assert_eq!(found["wrong"], Value::Array(Vec::new()), "{look:?}");
        assert_eq!((&found["svgs"], &found["tables"]), (&8.into(), &8.into()), "{look:?}");
        assert_eq!(found["dark"], look.dark);
        assert!(found["texts"].as_u64() > Some(400), "{found}");
    }
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn what_would_be_wrong_is_noticed() {
    let look = Look { width: 1200, height: 900, dark: true };
    let page = shipped();
    // A picture from elsewhere is not loaded, and the console says so.
    let outside = page.replace("</h1>", "</h1><img src=\"https://example.org/picture.png\">");
    let (_, console) = opened(&outside, look);
    assert!(console.iter().any(|line| line.contains("Content Security Policy")), "{console:?}");
    // Texts on each other and outside, unreadable, a picture without a size, a page too wide.
    let bad = "<svg width=\"2000\" height=\"200\"><title>bad</title><rect class=\"card\" width=\"400\" height=\"200\"/>\
               <text x=\"10\" y=\"50\">one text</text><text x=\"30\" y=\"52\">another</text>\
               <text x=\"1990\" y=\"90\">outside</text><text x=\"10\" y=\"120\" style=\"fill:#222\">dim</text></svg>\
               <svg width=\"0\" height=\"0\"><title>none</title><rect class=\"card\"/></svg>\
               <div style=\"width:3000px\">wide</div>";
    let found = report(&page.replace("</h1>", &format!("</h1>{bad}")), look);
    let wrong = found["wrong"].as_array().expect("a list");
    for what in ["overlap: bad, one text / another", "sticks out: bad, outside", "contrast 1", "no size: none", "wider"]
    {
        assert!(wrong.iter().any(|line| line.as_str().is_some_and(|line| line.starts_with(what))), "{what}: {found}");
    }
}
