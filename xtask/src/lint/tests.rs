//! What is refused, and what is not. Texts are put together here, so that the lint finds nothing
//! in this file.

use super::{comments, crates, is_exempt, look_at, parameters};

/// The lines that are refused in a text with these comments, one a line.
fn refused(marker: &str, comments: &[&str]) -> Vec<usize> {
    let text: String = comments
        .iter()
        .map(|comment| format!("{marker} {comment}\n"))
        .collect();
    let findings = comments::openings(&text, &marker[..marker.len().min(2)]);
    findings.into_iter().map(|finding| finding.line).collect()
}

#[test]
fn each_refused_opening_is_found_in_every_kind_of_comment() {
    let openings = [
        "Of nothing.",
        "Nor are others.",
        "And with a line.",
        "The same, in mm.",
        "So too do waves.",
        "Unless it moves.",
        "Behind the others.",
    ];
    for marker in ["//", "///", "//!", "#"] {
        assert_eq!(
            refused(marker, &openings),
            [1, 2, 3, 4, 5, 6, 7],
            "{marker}"
        );
    }
}

#[test]
fn words_that_only_begin_alike_and_sentences_that_go_on_are_no_openings() {
    let fine = [
        "Offset of the slide.",
        "Normal equations.",
        "Android, once.",
        "The samples",
        "of a window, and",
        "and of the next one,",
        "unless they are lost.",
        "So is this.",
    ];
    for marker in ["//", "///", "#"] {
        assert!(refused(marker, &fine).is_empty(), "{marker}");
    }
}

#[test]
fn a_comment_after_code_and_one_that_is_indented_are_looked_at() {
    let text = format!("let a = 1; {} Of one.\n    {} And this.\n", "//", "///");
    assert_eq!(look_at("a.rs", &text).len(), 2);
    let text = format!("a = 1  {} Unless it is two.\nb = '#Of'\n", "#");
    assert_eq!(look_at("a.py", &text).len(), 1);
}

#[test]
fn a_finding_names_the_line_the_word_and_what_to_do() {
    let text = format!("\n{} Nor this.\n", "//");
    let findings = look_at("a.js", &text);
    assert_eq!(findings[0].line, 2);
    assert!(findings[0].what.contains("\"Nor\""), "{findings:?}");
    assert!(findings[0].what.contains("noun phrase"), "{findings:?}");
}

/// Whether a function with this list of parameters is refused.
fn is_refused(generics: &str, list: &str) -> bool {
    let text = format!(
        "/// Text.\npub {} name{generics}({list}) -> u32 {{\n    0\n}}\n",
        "fn"
    );
    let findings = parameters::tuples(&text);
    if let Some(finding) = findings.first() {
        assert_eq!(finding.line, 2);
        assert!(finding.what.contains("`name`"), "{finding:?}");
    }
    !findings.is_empty()
}

#[test]
fn tuples_and_references_to_tuples_are_refused() {
    for list in [
        "pair: (f32, f32)",
        "&self, (from, to): (usize, usize)",
        "first: u8,\n    second: &(A, B),\n",
        "pair: &'a mut (A, B)",
        "pair: (A<B>, [u8; 2])",
    ] {
        assert!(is_refused("", list), "{list}");
    }
    assert!(is_refused("<F: Fn(u8) -> u8>", "f: F, pair: (u8, u8)"));
}

#[test]
fn closures_lists_of_pairs_and_types_in_parentheses_are_free() {
    for list in [
        "",
        "()",
        "a: u8, b: u8",
        "f: impl Fn((u8, u8), u8)",
        "f: &mut dyn FnMut(A, B) -> (A, B)",
        "pairs: &[(f32, f32)]",
        "pairs: Vec<(A, B)>",
        "one: &(dyn Fn(u8, u8) + Send)",
        "none: ()",
    ] {
        assert!(!is_refused("", list), "{list}");
    }
    assert!(!is_refused("<F: FnOnce((u8, u8))>", "f: F"));
}

#[test]
fn comments_and_answers_are_no_parameters() {
    let text = format!(
        "// {0} a(pair: (A, B)) {{}}\n{0} b(x: u8) -> (A, B) {{}}\n",
        "fn"
    );
    assert!(parameters::tuples(&text).is_empty());
}

#[test]
fn the_reader_of_recordings_is_exempt_and_nothing_else() {
    for path in ["hal-mock/src/trace/rows.rs", "host/src/grid.rs"] {
        assert!(is_exempt(path), "{path}");
    }
    for path in [
        "crates/feel/src/firing.rs",
        "crates/tone/src/fit.rs",
        "hal-mock/src/chip.rs",
        "host/src/replay.rs",
    ] {
        assert!(!is_exempt(path), "{path}");
    }
}

#[test]
fn licences_that_ask_for_more_and_crates_in_two_versions_are_refused() {
    let own = "ridgetone v0.1.0 (/somewhere/crates/finger)|";
    let fine =
        "a v1.0.0|MIT/Apache-2.0\nb v1.0.0 (proc-macro)|(MIT OR GPL-3.0-only) AND Unicode-3.0";
    let files = "c v2.0.0|MPL-2.0";
    let notice = "- c: https://example.org/c";
    let all = [own, fine, files, files].join("\n");
    assert_eq!(crates::complaints(&all, notice, &[]), [""; 0]);
    let twice = "e v1.0.0|MIT\ne v2.0.0|MIT";
    assert_eq!(crates::complaints(twice, notice, &["e"]), [""; 0]);
    for (tree, notice, part) in [
        (files, "", "c v2.0.0: the licence is \"MPL-2.0\""),
        (files, "- cc: https://example.org/cc", "c v2.0.0"),
        ("d v1.0.0|GPL-3.0-only", notice, "d v1.0.0"),
        ("d v1.0.0|MIT AND GPL-3.0-only", notice, "d v1.0.0"),
        ("d v1.0.0|", notice, "d v1.0.0"),
        (twice, notice, "e is there in 2 versions"),
    ] {
        let found = crates::complaints(tree, notice, &[]);
        assert_eq!(found.len(), 1, "{tree}: {found:?}");
        assert!(found[0].contains(part), "{found:?}");
    }
}
