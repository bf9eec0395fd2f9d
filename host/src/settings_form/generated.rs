//! Checked-in files generated from the table of settings: the list in `host/reference.md` and the
//! Python class. A test fails if one is out of date; `cargo xtask settings` regenerates them.

use super::{range, rows, shown, split, tables, words};
use ridgetone_proto::settings::{Kind, Setting, TABLE};
use std::fmt::Write;
use std::path::Path;

/// Set by `cargo xtask settings`: write the files instead of comparing them.
const WRITE: &str = "RIDGETONE_WRITE";

/// A page or Python module, with the lines around the generated text.
struct Place {
    file: &'static str,
    begin: &'static str,
    end: &'static str,
}

const LIST: Place = Place {
    file: "reference.md",
    begin: "<!-- `cargo xtask settings` writes what follows. -->\n",
    end: "<!-- End of what `cargo xtask settings` writes. -->\n",
};
const PYTHON: Place = Place {
    file: "python/package/ridgetone/_objects.py",
    begin: "# `cargo xtask settings` writes what follows.\n",
    end: "# End of what `cargo xtask settings` writes.\n",
};

impl Place {
    /// Compares the text between the lines, or replaces it.
    fn check(&self, text: &str) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(self.file);
        let all = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = all.split_once(self.begin).unwrap();
        let (found, after) = rest.split_once(self.end).unwrap();
        if std::env::var_os(WRITE).is_some() {
            let all = [before, self.begin, text, self.end, after].concat();
            std::fs::write(&path, all).unwrap();
            return;
        }
        assert_eq!(
            found, text,
            "{} is not what the table of settings gives: run `cargo xtask settings`",
            self.file
        );
    }
}

fn list() -> String {
    let mut text =
        String::from("\n| setting | range | default | what it is |\n|---|---|---|---|\n");
    for setting in TABLE {
        let cells = [
            format!("`{}`", setting.name),
            range(setting),
            format!("`{}`", shown(&setting.default())),
            setting.sentence().to_owned(),
        ];
        writeln!(text, "| {} |", cells.join(" | ")).unwrap();
    }
    text.push('\n');
    text
}

fn python() -> String {
    let mut text = String::new();
    for table in tables() {
        let name = class(table);
        write!(
            text,
            "class {name}(Object):\n    \"\"\"Settings `{table}`.\"\"\"\n\n"
        )
        .unwrap();
        rows(Some(table)).for_each(|setting| field(setting, &mut text));
        text.push_str("\n\n");
    }
    text.push_str(
        "class Settings(Object):\n    \"\"\"Settings, by the names of the settings file.\"\"\"\n\n",
    );
    rows(None).for_each(|setting| field(setting, &mut text));
    for table in tables() {
        writeln!(text, "    {table}: {}", class(table)).unwrap();
    }
    text
}

fn class(table: &str) -> String {
    let (first, rest) = table.split_at(1);
    format!("{}{rest}Settings", first.to_uppercase())
}

fn field(setting: &Setting, text: &mut String) {
    let kind = match setting.kind {
        Kind::Number => "float".to_owned(),
        Kind::Whole | Kind::Mask => "int".into(),
        Kind::Switch => "bool".into(),
        Kind::Masks => "list[int]".into(),
        Kind::Word(words) => format!("Literal[\"{}\"]", words.join("\", \"")),
        Kind::Plan => "str | dict[str, Any]".into(),
    };
    let name = split(setting.name).1;
    let comment = words::comment(setting);
    write!(text, "    {name}: {kind}\n    \"\"\"{comment}\"\"\"\n").unwrap();
}

#[test]
fn the_list_and_python_have_what_the_table_has() {
    LIST.check(&list());
    PYTHON.check(&python());
}
