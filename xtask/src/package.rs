//! `package`: checks that the published crates build from their packages alone, and that these hold
//! what a registry shows.

use crate::tools::{clean, create, remove, run, target_dir};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Those that are published, each after those that it needs.
const PACKAGES: [&str; 5] = [
    "ads1258",
    "ridgetone-proto",
    "ridgetone-tone",
    "ridgetone-feel",
    "ridgetone-finger",
];

/// Packs each, builds it from its package, without network, and checks its files and its manifest.
///
/// A missing `repository` is only named unless `publish` is set: while the project has no public
/// address there is nothing true to fill in, and a check that cannot pass hides what else it finds.
///
/// In a target folder and a home of cargo of their own: cargo never reads a package of the same
/// version again.
pub fn check(publish: bool) -> Result<()> {
    let folder = target_dir().join("package-check");
    remove(&folder)?;
    let home = folder.join("home");
    create(&home.join("registry"))?;
    let usual = env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(env::home_dir()?.join(".cargo")));
    let usual = usual.context("neither CARGO_HOME nor a home directory")?;
    for part in ["registry/index", "registry/cache", "config.toml"] {
        if usual.join(part).exists() {
            link(&usual.join(part), &home.join(part))?;
        }
    }
    let target = folder.join("target");
    let mut cargo = clean("cargo");
    cargo.args(["package", "--quiet", "--offline", "--allow-dirty"]);
    cargo.args(PACKAGES.iter().flat_map(|name| ["--package", name]));
    run(cargo
        .env("CARGO_HOME", &home)
        .env("CARGO_TARGET_DIR", &target))
    .context("a package does not build")?;
    let mut repositories = Vec::new();
    for name in PACKAGES {
        let package = format!("{name}-{}", env!("CARGO_PKG_VERSION"));
        let folder = target.join("package");
        repositories.push(check_contents(&folder.join(&package)).context(name)?);
        let file = folder.join(package + ".crate");
        let bytes = fs::metadata(&file)
            .with_context(|| format!("no {}", file.display()))?
            .len();
        println!("{name:<20} {bytes} bytes packed");
    }
    if let Some(missing) = missing_repository(&repositories, publish)? {
        println!("{missing}");
    }
    remove(&folder)
}

/// What a package must hold besides its code.
const FILES: [&str; 3] = ["LICENSE-APACHE", "LICENSE-MIT", "README.md"];

/// What its manifest must give besides the `repository`.
const FIELDS: [&str; 3] = ["description", "license", "readme"];

/// Fails if an unpacked package lacks one of [`FILES`] or [`FIELDS`]; returns its `repository`.
fn check_contents(package: &Path) -> Result<Option<String>> {
    for file in FILES {
        ensure!(
            fs::metadata(package.join(file)).is_ok_and(|file| file.len() > 0),
            "packed without {file}, or with an empty one: put it into the crate's folder"
        );
    }
    let manifest = fs::read_to_string(package.join("Cargo.toml")).context("no manifest")?;
    for name in FIELDS {
        ensure!(
            field(&manifest, name).is_some(),
            "packed without `{name}`: set it under [package] in the crate's Cargo.toml"
        );
    }
    Ok(field(&manifest, "repository"))
}

/// A text under `[package]` of a manifest as cargo writes it into a package: one line a field.
fn field(manifest: &str, name: &str) -> Option<String> {
    let (_, package) = manifest.split_once("[package]\n")?;
    let fields = package.lines().take_while(|line| !line.starts_with('['));
    let mut values = fields.filter_map(|line| line.strip_prefix(name)?.strip_prefix(" = \""));
    let value = values.next()?.trim_end_matches('"');
    (!value.is_empty()).then(|| value.to_owned())
}

/// The line that says that no package has a `repository`; an error if it is needed now, if only some
/// have one, or if it is no address of the web.
fn missing_repository(given: &[Option<String>], publish: bool) -> Result<Option<String>> {
    const SET: &str = "set `repository` under [workspace.package] in Cargo.toml, and \
        `repository.workspace = true` in each published crate";
    if let Some(other) = given
        .iter()
        .flatten()
        .find(|it| !it.starts_with("https://"))
    {
        bail!("`repository` is {other:?}, no address that begins with https://: {SET}");
    }
    let missing = given.iter().filter(|it| it.is_none()).count();
    if missing == 0 {
        return Ok(None);
    }
    let line = format!(
        "still missing before a release: {missing} of {} packages have no `repository`; once the \
        project has a public address {SET}",
        given.len()
    );
    ensure!(missing == given.len() && !publish, "{line}");
    Ok(Some(line))
}

#[cfg(unix)]
fn link(from: &Path, to: &Path) -> Result<()> {
    std::os::unix::fs::symlink(from, to).with_context(|| format!("cannot link {}", to.display()))
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> Result<()> {
    anyhow::bail!("only where there are symbolic links")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::write;

    const ADDRESS: &str = "https://example.org/project";

    /// A package as cargo unpacks it, of which `spoil` takes something away.
    fn package(name: &str, spoil: impl Fn(&Path)) -> Result<Option<String>> {
        let folder = env::temp_dir().join(format!("{name}-{}", std::process::id()));
        remove(&folder)?;
        create(&folder)?;
        for file in FILES {
            write(&folder.join(file), b"text")?;
        }
        let manifest = format!(
            "[package]\nname = \"a\"\ndescription = \"A crate\"\nreadme = \"README.md\"\n\
            license = \"MIT OR Apache-2.0\"\nrepository = \"{ADDRESS}\"\n\n[lib]\nname = \"a\"\n"
        );
        write(&folder.join("Cargo.toml"), manifest.as_bytes())?;
        spoil(&folder);
        let found = check_contents(&folder);
        remove(&folder)?;
        found
    }

    fn without_field(folder: &Path, name: &str) {
        let path = folder.join("Cargo.toml");
        let kept: Vec<_> = fs::read_to_string(&path)
            .expect("a manifest")
            .lines()
            .filter(|line| !line.starts_with(name))
            .map(str::to_owned)
            .collect();
        fs::write(path, kept.join("\n")).expect("written");
    }

    #[test]
    fn a_package_lacks_no_file() {
        assert_eq!(
            package("package-whole", |_| ()).expect("whole"),
            Some(ADDRESS.to_owned())
        );
        for file in FILES {
            let removed = package("package-removed", |folder| {
                fs::remove_file(folder.join(file)).expect("removed");
            });
            let emptied = package("package-emptied", |folder| {
                fs::write(folder.join(file), "").expect("emptied");
            });
            for found in [removed, emptied] {
                let error = found.expect_err(file).to_string();
                assert!(error.contains(&format!("without {file},")), "{error}");
            }
        }
    }

    #[test]
    fn a_manifest_lacks_no_field() {
        for name in FIELDS {
            let found = package("package-field", |folder| without_field(folder, name));
            let error = found.expect_err(name).to_string();
            assert!(error.contains(&format!("`{name}`")), "{error}");
        }
        let found = package("package-address", |folder| {
            without_field(folder, "repository");
        });
        assert_eq!(found.expect("still whole"), None);
    }

    #[test]
    fn a_field_of_another_section_is_none_of_the_package() {
        let manifest = "[package]\nname = \"a\"\nreadme = false\n\n[badges]\nlicense = \"MIT\"\n";
        assert_eq!(field(manifest, "name").as_deref(), Some("a"));
        assert_eq!(field(manifest, "license"), None);
        assert_eq!(field(manifest, "readme"), None);
    }

    #[test]
    fn an_address_is_missing_until_all_have_it() {
        let address = || Some(ADDRESS.to_owned());
        let all = [address(), address()];
        assert_eq!(missing_repository(&all, true).expect("all"), None);
        let line = missing_repository(&[None, None], false)
            .expect("not needed yet")
            .expect("named");
        assert!(line.starts_with("still missing before a release: 2 of 2"));
        assert_eq!(line.lines().count(), 1);
        for (given, publish, words) in [
            ([None, None], true, "2 of 2"),
            ([address(), None], false, "1 of 2"),
            ([address(), Some("soon".to_owned())], false, "\"soon\""),
        ] {
            let error = missing_repository(&given, publish).expect_err(words);
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
