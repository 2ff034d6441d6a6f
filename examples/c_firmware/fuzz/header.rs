//! `stiction.h` beside what `cbindgen` makes of the Rust side: a C compiler takes both in one file only if they agree.
//!
//! The header itself is written by hand: its comments are for C, and `cbindgen` does not know how large a `stiction` is. Numbers
//! need no test (`header.rs` of the folder above), and `test.c` there reads every field of the structs.

use cbindgen::{Builder, Config, ItemType, Language};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// The functions as `cbindgen` declares them, in the names of `stiction.h`.
fn declarations(folder: &Path) -> String {
    let names = [
        ("N", "STICTION_N"),
        ("D", "STICTION_D"),
        ("C", "STICTION_C"),
        ("K", "STICTION_K"),
        ("Real", "stiction_real"),
        ("Solver", "stiction"),
        ("Solution", "stiction_solution"),
        ("Culprit", "stiction_culprit"),
        ("Status", "enum stiction_status"),
        ("LawNumber", "enum stiction_law"),
        ("ModelNumber", "enum stiction_model"),
        ("Surface", "stiction_surface"),
        ("JointRow", "stiction_joint_row"),
        ("ContactImpulse", "stiction_contact_impulse"),
        ("RowImpulse", "stiction_row_impulse"),
        ("ContactOutcome", "stiction_contact"),
        ("RowOutcome", "stiction_row"),
        ("Violation", "stiction_violation"),
    ];
    let mut config =
        Config { language: Language::C, no_includes: true, usize_is_size_t: true, ..Config::default() };
    config.export.item_types = vec![ItemType::Functions];
    let names = names.map(|(rust, c)| (rust.to_owned(), c.to_owned()));
    config.export.rename.extend(names);
    let rust = Builder::new().with_config(config).with_src(folder.join("calls.rs"));
    let mut text = Vec::new();
    rust.generate().expect("it is read").write(&mut text);
    String::from_utf8(text).expect("it is text")
}

#[test]
fn the_header_declares_what_rust_defines() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let declarations = declarations(folder);
    let mut cc = Command::new("cc")
        .args(["-std=c11", "-fsyntax-only", "-x", "c", "-"])
        .current_dir(folder)
        .stdin(Stdio::piped())
        .spawn()
        .expect("there is a C compiler");
    let both = format!("#include \"stiction.h\"\n{declarations}");
    let mut stdin = cc.stdin.take().expect("it is piped");
    stdin.write_all(both.as_bytes()).expect("it is read");
    drop(stdin);
    assert!(cc.wait().expect("it ends").success(), "{declarations}");
    // Each name in both, but for what the header defines itself.
    let header = include_str!("../stiction.h");
    let names = |text: &str| {
        let words = text.split(|c: char| !(c.is_alphanumeric() || "_(".contains(c)));
        let calls = words.filter_map(|word| word.strip_prefix("stiction_")?.split_once('('));
        let calls = calls.map(|(name, _)| name.to_owned());
        // A pointer to an array of the number type is no call.
        let mut names: Vec<String> = calls.filter(|name| name != "real").collect();
        names.sort();
        names.dedup();
        names
    };
    let mut declared = names(&declarations);
    declared.push("init".to_owned());
    declared.sort();
    assert_eq!(names(header), declared);
    assert!(names(header).len() > 10);
}
