//! Starts a headless browser and controls it over the DevTools protocol
//! (<https://chromedevtools.github.io/devtools-protocol/>) on two pipes.

use rustix::fs::{CWD, Mode, mkfifoat};
use serde_json::{Value, json};
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command};
use std::sync::mpsc::{Receiver, channel};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// Maximum time for any action of the browser.
const PATIENCE: Duration = Duration::from_secs(120);

#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub width: u32,
    pub height: u32,
    pub dark: bool,
}

/// The browser found by `cargo xtask test`, or else Debian's in PATH.
fn browser() -> OsString {
    std::env::var_os("RIDGETONE_BROWSER").unwrap_or_else(|| "chromium".into())
}

/// Returns the command of a headless browser that cannot resolve any host but this computer.
fn command(profile: &Path, look: Look) -> Command {
    let mut command = Command::new(browser());
    command
        // The sandbox needs a user other than root; only our own page is opened.
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
        ])
        .args([
            "--enable-logging=stderr",
            "--log-level=0",
            "--force-device-scale-factor=1",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--window-size={},{}", look.width, look.height))
        .arg(format!(
            "--blink-settings=preferredColorScheme={}",
            u8::from(!look.dark)
        ));
    command
}

pub struct Browser {
    child: Child,
    commands: File,
    answers: Receiver<Value>,
    session: String,
    number: u64,
    events: Vec<Value>,
    /// Deleted when the browser is dropped.
    _folder: tempfile::TempDir,
}

impl Browser {
    pub fn start(look: Look) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = |name: &str| {
            let path = folder.path().join(name);
            mkfifoat(CWD, &path, Mode::RUSR | Mode::WUSR).expect("a pipe");
            path
        };
        let (commands, answers) = (pipe("commands"), pipe("answers"));
        let plain = command(&folder.path().join("profile"), look);
        let log = File::create(folder.path().join("log")).expect("a file");
        let child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<\"$COMMANDS\" 4>\"$ANSWERS\""])
            .arg(plain.get_program())
            .args(plain.get_args())
            .args(["--remote-debugging-pipe", "about:blank"])
            .env("COMMANDS", &commands)
            .env("ANSWERS", &answers)
            .stderr(log)
            .spawn()
            .expect("a shell");
        // Open them in the same order as the shell, or both would block.
        let commands = File::options()
            .write(true)
            .open(commands)
            .expect("the pipe");
        let answers = File::open(answers).expect("the pipe");
        let (to_us, heard) = channel();
        spawn(move || {
            for message in BufReader::new(answers).split(0).map_while(Result::ok) {
                if to_us
                    .send(serde_json::from_slice(&message).expect("JSON"))
                    .is_err()
                {
                    return;
                }
            }
        });
        let (session, events) = (String::new(), Vec::new());
        let mut browser = Self {
            child,
            commands,
            answers: heard,
            session,
            number: 0,
            events,
            _folder: folder,
        };
        let targets = browser.call("Target.getTargets", json!({}));
        let infos = targets["targetInfos"].as_array().expect("pages");
        let page = infos
            .iter()
            .find(|info| info["type"] == "page")
            .expect("a page")["targetId"]
            .clone();
        let attached = browser.call(
            "Target.attachToTarget",
            json!({"targetId": page, "flatten": true}),
        );
        browser.session = attached["sessionId"]
            .as_str()
            .expect("a session")
            .to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.look(look);
        browser
    }

    /// Calls a method without waiting for its result.
    pub fn tell(&mut self, method: &str, parameters: Value) {
        self.number += 1;
        let mut command = json!({"id": self.number, "method": method, "params": parameters});
        if !self.session.is_empty() && !method.starts_with("Browser.") {
            command["sessionId"] = self.session.clone().into();
        }
        self.commands
            .write_all(format!("{command}\0").as_bytes())
            .expect("a browser: cargo xtask setup installs one");
    }

    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.tell(method, parameters);
        loop {
            let message = self
                .answers
                .recv_timeout(PATIENCE)
                .expect("the browser answers");
            if message["id"] == self.number {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            self.events.push(message);
        }
    }

    pub fn look(&mut self, look: Look) {
        let Look {
            width,
            height,
            dark,
        } = look;
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500});
        self.call("Emulation.setDeviceMetricsOverride", size);
        let scheme = if dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.call("Emulation.setEmulatedMedia", json!({"features": features}));
    }

    pub fn open(&mut self, url: &str) {
        let loaded = self.call("Page.navigate", json!({"url": url}));
        assert!(loaded["errorText"].is_null(), "{url}: {loaded}");
    }

    /// Evaluates an expression in the page, and awaits its value.
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters =
            json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let found = self.call("Runtime.evaluate", parameters);
        assert!(found["exceptionDetails"].is_null(), "{expression}: {found}");
        found["result"]["value"].clone()
    }

    pub fn wait(&mut self, expression: &str) {
        let begun = Instant::now();
        while self.value(expression) != true {
            assert!(
                begun.elapsed() < PATIENCE,
                "never: {expression}; {:?}",
                self.errors()
            );
            sleep(Duration::from_millis(50));
        }
    }

    /// Returns console messages, and exceptions in scripts.
    pub fn errors(&self) -> Vec<String> {
        let bad = [
            "Log.entryAdded",
            "Runtime.consoleAPICalled",
            "Runtime.exceptionThrown",
        ];
        let is_error = |event: &&Value| bad.iter().any(|method| event["method"] == *method);
        self.events
            .iter()
            .filter(is_error)
            .map(Value::to_string)
            .collect()
    }

    pub fn requests(&self) -> Vec<String> {
        let sent = self
            .events
            .iter()
            .filter(|event| event["method"] == "Network.requestWillBeSent");
        sent.map(|event| {
            event["params"]["request"]["url"]
                .as_str()
                .unwrap_or_default()
                .to_owned()
        })
        .collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
