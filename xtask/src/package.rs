//! `package`: checks that the published crates build from their packages alone, and contain what a
//! registry shows.

use crate::tools::{clean, create, remove, run, target_dir};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Published crates, in order of dependency.
const PACKAGES: [&str; 5] = [
    "ads1258",
    "ridgetone-proto",
    "ridgetone-tone",
    "ridgetone-feel",
    "ridgetone-finger",
];

/// Packs each crate, builds it from its package without network, and checks its files and manifest.
///
/// A missing `repository` is only reported unless `publish` is set: while the project has no public
/// address there is no true value, and a check that always fails would hide other findings.
///
/// Uses a separate target folder and cargo home, because cargo never re-reads a package of the same
/// version.
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
    let folder = target.join("package");
    let mut repositories = Vec::new();
    for name in PACKAGES {
        let package = unpacked(&folder, name)?;
        let size = |file: &Path| fs::metadata(file).map_or(0, |data| data.len());
        let manifest = fs::read_to_string(package.join("Cargo.toml")).context("no manifest")?;
        let found = check_contents(&manifest, |file| size(&package.join(file)));
        repositories.push(found.context(name)?);
        let packed = format!("{}.crate", package.display());
        println!("{name:<20} {} bytes packed", size(Path::new(&packed)));
    }
    if let Some(missing) = missing_repository(&repositories, publish)? {
        println!("{missing}");
    }
    remove(&folder)
}

/// Folder of an unpacked package, whose version may differ from the workspace's.
fn unpacked(folder: &Path, name: &str) -> Result<PathBuf> {
    let start = format!("{name}-");
    let is_its = |path: &PathBuf| {
        let file = path.file_name().and_then(|file| file.to_str());
        let version = file.and_then(|file| file.strip_prefix(&start));
        path.is_dir()
            && version.is_some_and(|version| version.starts_with(|c: char| c.is_ascii_digit()))
    };
    let entries = fs::read_dir(folder).context("no packages")?;
    let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths
        .find(is_its)
        .with_context(|| format!("no package {name}"))
}

/// Files required in a package besides code.
const FILES: [&str; 3] = ["LICENSE-APACHE", "LICENSE-MIT", "README.md"];

/// Fields required in the manifest besides `repository`.
const FIELDS: [&str; 3] = ["description", "license", "readme"];

/// Fails if an unpacked package lacks one of [`FILES`] or [`FIELDS`]; returns its `repository`.
fn check_contents(manifest: &str, size: impl Fn(&str) -> u64) -> Result<Option<String>> {
    for file in FILES {
        ensure!(
            size(file) > 0,
            "packed without {file}, or with an empty one: put it into the crate's folder"
        );
    }
    for name in FIELDS {
        ensure!(
            field(manifest, name).is_some(),
            "packed without `{name}`: set it under [package] in the crate's Cargo.toml"
        );
    }
    Ok(field(manifest, "repository"))
}

/// Reads a text field under `[package]` in a manifest as packed by cargo: one field per line.
fn field(manifest: &str, name: &str) -> Option<String> {
    let (_, package) = manifest.split_once("[package]\n")?;
    let fields = package.lines().take_while(|line| !line.starts_with('['));
    let mut values = fields.filter_map(|line| line.strip_prefix(name)?.strip_prefix(" = \""));
    let value = values.next()?.trim_end_matches('"');
    (!value.is_empty()).then(|| value.to_owned())
}

/// Returns a remark if no package has a `repository`. Fails if it is required now, if only some
/// packages have one, or if it is not a web address.
fn missing_repository(given: &[Option<String>], publish: bool) -> Result<Option<String>> {
    const SET: &str = "set `repository` under [workspace.package] in Cargo.toml, and \
        `repository.workspace = true` in each published crate";
    let mut addresses = given.iter().flatten();
    if let Some(other) = addresses.find(|it| !it.starts_with("https://")) {
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

    #[test]
    fn a_package_lacks_no_file_and_its_manifest_no_field() {
        let address = "https://example.org/project";
        for lacks in FILES
            .into_iter()
            .chain(FIELDS)
            .chain(["repository", "nothing"])
        {
            let fields = FIELDS
                .iter()
                .chain(&["repository"])
                .filter(|name| **name != lacks);
            let fields: String = fields
                .map(|name| format!("{name} = \"{address}\"\n"))
                .collect();
            // Fields of a different section do not count, and fields need not be texts.
            let others = "[lib]\nlicense = \"MIT\"\nrepository = \"\"\n";
            let manifest = format!("[package]\nname = \"a\"\npublish = false\n{fields}\n{others}");
            let found = check_contents(&manifest, |file| u64::from(file != lacks));
            match lacks {
                "nothing" => assert_eq!(found.expect("whole").as_deref(), Some(address)),
                "repository" => assert_eq!(found.expect("whole"), None),
                _ => {
                    let error = found.expect_err(lacks).to_string();
                    assert!(
                        error.contains(&format!("without {lacks}"))
                            || error.contains(&format!("without `{lacks}`")),
                        "{error}"
                    );
                }
            }
            assert_eq!(field(&manifest, "publish"), None);
        }
    }

    #[test]
    fn an_address_is_missing_until_all_have_it() {
        for (given, publish, is_fine, words) in [
            ("https://a.org https://a.org", true, true, ""),
            ("- -", false, true, "2 of 2"),
            ("- -", true, false, "2 of 2"),
            ("https://a.org -", false, false, "1 of 2"),
            ("https://a.org soon", false, false, "\"soon\""),
        ] {
            let addresses = given
                .split(' ')
                .map(|one| (one != "-").then(|| one.to_owned()));
            let found = missing_repository(&addresses.collect::<Vec<_>>(), publish);
            assert_eq!(found.is_ok(), is_fine, "{given}: {found:?}");
            let line = found.map_or_else(|error| error.to_string(), Option::unwrap_or_default);
            assert!(
                line.contains(words) && line.is_empty() == words.is_empty(),
                "{line}"
            );
        }
    }
}
