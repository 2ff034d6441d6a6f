//! Scene files that are cut, and of wrong sizes and types: read or refused, and solved without a panic.

use super::cases::cases;
use proptest::prelude::*;
use std::sync::LazyLock;
use stiction::Settings;
use testbed::kernel::{self, Shape, smallest};
use testbed::method::Method;
use testbed::scene_file::SceneFile;
use testbed::{format, mixed, scene_file};

/// The texts of small bundled files.
static TEXTS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let mixed = scene_file::json_files(&scene_file::repository().join("tests/mixed"));
    let paths = scene_file::bundled().into_iter().chain(mixed);
    let texts = paths.filter_map(|path| std::fs::read_to_string(path).ok());
    texts.filter(|text| text.len() < 4_000).collect()
});

/// What a file has in place of something else.
const WORDS: [&str; 16] = [
    "",
    "0",
    "-1",
    "1",
    "4",
    "1e308",
    "1e999",
    "NaN",
    "null",
    "[]",
    "{}",
    "\"x\"",
    "[[1.0]]",
    "18446744073709551615",
    "9223372036854775807",
    "-0.5",
];

/// Numbers, words and brackets, each with what is between them.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = vec![String::new()];
    let mut inside = false;
    for c in text.chars() {
        let part = c.is_alphanumeric() || "+-._".contains(c);
        if !(part && inside) {
            tokens.push(String::new());
        }
        inside = part;
        tokens.last_mut().expect("there is one").push(c);
    }
    tokens
}

fn read_and_solve(text: &str) {
    let settings = Settings::new(1e-6);
    for file in format::read_text(text, "fuzz").unwrap_or_default() {
        if !file.has_contacts_alone() {
            let _ = mixed::solve::<f64>(&file, &settings, 1);
        } else if let Ok(file) = SceneFile::of_file(&file)
            && smallest::<f64>(Shape::of(&file)).is_ok()
            && let Ok(mut kernel) = kernel::prepared(smallest::<f64>, &file, Method::Default)
        {
            let _ = kernel.solve(Method::Default, &settings);
        }
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_file_that_is_damaged_is_read_or_refused(
        which in any::<prop::sample::Index>(),
        places in prop::collection::vec((any::<prop::sample::Index>(), 0..WORDS.len()), 0..4),
        first in prop::option::weighted(0.4, (0..60_usize, 0..WORDS.len())),
        end in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut tokens = tokens(&TEXTS[which.index(TEXTS.len())]);
        // The sizes stand in front.
        if let Some((place, word)) = first && let Some(token) = tokens.get_mut(place) {
            *token = WORDS[word].to_owned();
        }
        for (place, word) in places {
            *place.get_mut(&mut tokens) = WORDS[word].to_owned();
        }
        if let Some(end) = end {
            tokens.truncate(end.index(tokens.len()));
        }
        read_and_solve(&tokens.concat());
    }
}
