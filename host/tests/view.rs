//! `view`: the server on its own, and the page in a browser, which `cargo xtask test` installs.
#![cfg(target_os = "linux")]

#[path = "common/browser.rs"]
mod browser;
mod common;

use browser::{Browser, Look};
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

/// `ridgetone view` at a free port.
struct View {
    child: Child,
    url: String,
}

impl View {
    fn start(arguments: &[&str]) -> Self {
        let mut child = common::ridgetone()
            .args(["view", "--listen", "127.0.0.1:0"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let mut url = String::new();
        BufReader::new(child.stdout.as_mut().expect("a pipe")).read_line(&mut url).expect("a line");
        Self { child, url: url.trim().to_owned() }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn pictures() {
    let view = View::start(&["--emulated"]);
    let look = Look { width: 1280, height: 800, dark: false };
    let mut browser = Browser::start(look);
    browser.open(&view.url);
    browser.wait("document.getElementById('phase').textContent === 'sliding' && document.getElementById('frequency').textContent.includes('Hz')");
    std::thread::sleep(std::time::Duration::from_secs(1));
    let save = |name: &str, data: String| std::fs::write(format!("/tmp/view-pictures/{name}.b64"), data).unwrap();
    save("light", browser.picture(false));
    browser.look(Look { dark: true, ..look });
    std::thread::sleep(std::time::Duration::from_secs(1));
    save("dark", browser.picture(true));
    browser.look(Look { width: 390, height: 844, dark: false });
    std::thread::sleep(std::time::Duration::from_secs(3));
    save("phone", browser.picture(true));
    println!("{:#?}", browser.errors());
    println!("{:#?}", browser.requests());
}
