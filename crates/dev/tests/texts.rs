//! Every text for people in the source is Chinese in its Chinese form. That both forms are there, with the same
//! arguments, the compiler sees to.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};

/// Forms that have no Chinese words: names and units, which are written alike.
const SAME_IN_BOTH: &[&str] = &[
    "ROS 2",
    "TCP",
    "bag {}：{source}",
    "{}：model = {given:?}：{source}",
];

/// Names of types and units, which are written alike in both languages.
const TYPES_AND_UNITS: &[&str] = &["bool", "float", "int", "str", "rad"];

/// A text as it is declared.
struct DeclaredText {
    place: String,
    /// Not known where the comment of an option is the English form.
    english: Option<String>,
    chinese: String,
}

fn source_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            source_files(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}

/// The string literals of a list, up to the first other thing.
fn literals(list: TokenStream) -> Vec<String> {
    let mut literals = Vec::new();
    for token in list {
        match token {
            TokenTree::Literal(literal) => {
                let literal: syn::LitStr = syn::parse_str(&literal.to_string()).unwrap();
                literals.push(literal.value());
            }
            TokenTree::Punct(comma) if comma.as_char() == ',' && literals.len() < 2 => {}
            _ => break,
        }
    }
    literals
}

/// The texts among these tokens: `text!("…", "…")`, `phrase("…", "…")`, and `#[zh("…")]`.
fn add_texts(tokens: TokenStream, path: &Path, texts: &mut Vec<DeclaredText>) {
    let tokens: Vec<_> = tokens.into_iter().collect();
    for (number, token) in tokens.iter().enumerate() {
        let TokenTree::Group(group) = token else {
            continue;
        };
        let before = |back: usize| {
            let token = number.checked_sub(back).and_then(|at| tokens.get(at));
            token.map(ToString::to_string).unwrap_or_default()
        };
        let place = format!("{}:{}", path.display(), group.span_open().start().line);
        let is_text = before(1) == "!" && matches!(&*before(2), "text" | "phrase");
        if is_text || before(1) == "phrase" {
            // The function `phrase` has parameters where calls have literals, and its macro takes one form alone for
            // names.
            if let Ok([english, chinese]) = <[_; 2]>::try_from(literals(group.stream())) {
                texts.push(DeclaredText {
                    place,
                    english: Some(english),
                    chinese,
                });
            }
        } else if before(1) == "zh" {
            texts.extend(
                literals(group.stream())
                    .into_iter()
                    .map(|chinese| DeclaredText {
                        place: place.clone(),
                        english: None,
                        chinese,
                    }),
            );
        }
        add_texts(group.stream(), path, texts);
    }
}

fn declared_texts() -> Vec<DeclaredText> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&crates).unwrap() {
        let folder = entry.unwrap().path();
        // The examples of the crate that defines texts are about texts.
        if folder.file_name().is_some_and(|name| name != "messages") && folder.join("src").is_dir()
        {
            source_files(&folder.join("src"), &mut files);
        }
    }
    files.sort();
    let mut texts = Vec::new();
    for path in files {
        let source = std::fs::read_to_string(&path).unwrap();
        let tokens = source.parse().unwrap();
        let name = path.strip_prefix(&crates).unwrap();
        add_texts(tokens, name, &mut texts);
    }
    texts
}

fn is_chinese(letter: char) -> bool {
    matches!(letter, '\u{4e00}'..='\u{9fff}')
}

/// Whether a form has words: lower-case letters outside of the places of arguments.
fn has_words(form: &str) -> bool {
    let words = form
        .split('{')
        .map(|piece| piece.split_once('}').map_or(piece, |(_, words)| words));
    words
        .flat_map(str::split_whitespace)
        .filter(|word| word.len() > 2 && !TYPES_AND_UNITS.contains(word))
        .any(|word| word.bytes().all(|letter| letter.is_ascii_lowercase()))
}

#[test]
fn every_chinese_form_is_chinese() {
    let texts = declared_texts();
    assert!(texts.len() > 3000, "{}", texts.len());
    let english_only: Vec<_> = texts
        .iter()
        .filter(|text| !text.chinese.contains(is_chinese))
        .filter(|text| has_words(text.english.as_deref().unwrap_or(&text.chinese)))
        .filter(|text| !SAME_IN_BOTH.contains(&&*text.chinese))
        .map(|text| format!("{}: {}", text.place, text.chinese))
        .collect();
    assert_eq!(english_only, [""; 0]);
}

#[test]
fn no_english_form_is_chinese() {
    let swapped: Vec<_> = declared_texts()
        .into_iter()
        .filter(|text| {
            text.english
                .as_ref()
                .is_some_and(|form| form.contains(is_chinese))
        })
        .map(|text| text.place)
        .collect();
    assert_eq!(swapped, [""; 0]);
}
