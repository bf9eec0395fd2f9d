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

    const MANIFEST: &str = "[package]\nname = \"a\"\ndescription = \"A crate\"\nreadme = \"README.md\"\n\
        license = \"MIT OR Apache-2.0\"\nrepository = \"https://example.org/project\"\n\n[lib]\nname = \"a\"\n";

    /// Looks at a package as cargo unpacks it, of which `spoil` changes something.
    fn package(spoil: impl Fn(&Path)) -> Result<Option<String>> {
        let folder = env::temp_dir().join(format!("xtask-package-{}", std::process::id()));
        remove(&folder)?;
        create(&folder)?;
        for file in FILES {
            write(&folder.join(file), b"text")?;
        }
        write(&folder.join("Cargo.toml"), MANIFEST.as_bytes())?;
        spoil(&folder);
        let found = check_contents(&folder);
        remove(&folder)?;
        found
    }

    #[test]
    fn a_package_lacks_no_file_and_its_manifest_no_field() {
        let whole = package(|_| ()).expect("whole");
        assert_eq!(whole.as_deref(), Some("https://example.org/project"));
        let without_field = |folder: &Path, name: &str| {
            let kept = MANIFEST.lines().filter(|line| !line.starts_with(name));
            let manifest = kept.collect::<Vec<_>>().join("\n");
            write(&folder.join("Cargo.toml"), manifest.as_bytes()).expect("written");
        };
        for file in FILES {
            let removed = package(|folder| fs::remove_file(folder.join(file)).expect("removed"));
            let emptied = package(|folder| fs::write(folder.join(file), "").expect("emptied"));
            for found in [removed, emptied] {
                let error = found.expect_err(file).to_string();
                assert!(error.contains(&format!("without {file},")), "{error}");
            }
        }
        for name in FIELDS {
            let error = package(|folder| without_field(folder, name)).expect_err(name);
            assert!(error.to_string().contains(&format!("`{name}`")), "{error}");
        }
        let found = package(|folder| without_field(folder, "repository"));
        assert_eq!(found.expect("still whole"), None);
        // A field of another section is none of the package.
        let manifest = "[package]\nname = \"a\"\nreadme = false\n\n[badges]\nlicense = \"MIT\"\n";
        let fields = ["name", "readme", "license"].map(|name| field(manifest, name));
        assert_eq!(fields, [Some("a".to_owned()), None, None]);
    }

    #[test]
    fn an_address_is_missing_until_all_have_it() {
        for (given, publish, expected) in [
            ("https://a.org https://a.org", true, Ok(None)),
            (
                "- -",
                false,
                Ok(Some("still missing before a release: 2 of 2")),
            ),
            ("- -", true, Err("2 of 2")),
            ("https://a.org -", false, Err("1 of 2")),
            ("https://a.org soon", false, Err("\"soon\"")),
        ] {
            let given: Vec<Option<String>> = given
                .split(' ')
                .map(|one| (one != "-").then(|| one.to_owned()))
                .collect();
            match (missing_repository(&given, publish), expected) {
                (Ok(None), Ok(None)) => {}
                (Ok(Some(line)), Ok(Some(begins))) => assert!(line.starts_with(begins), "{line}"),
                (Err(error), Err(words)) => assert!(error.to_string().contains(words), "{error}"),
                (found, _) => panic!("{given:?}: {found:?}"),
            }
        }
    }
}
