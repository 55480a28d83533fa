//! `mdbook build` makes a book of `docs/`: its table of contents has every page once, and no page that is not there.

use std::collections::BTreeSet;

use crate::markdown::{name, pages, read, root};

#[test]
fn the_book_has_every_page_once() {
    let docs = root().join("docs");
    let summary = docs.join("SUMMARY.md");
    let mut listed = BTreeSet::new();
    for (link, line) in read(&summary).links {
        let page = docs.join(&link).canonicalize();
        let page = page.unwrap_or_else(|_| panic!("SUMMARY.md:{line}: there is no page {link}"));
        assert!(
            listed.insert(name(&page)),
            "SUMMARY.md:{line}: {link} stands twice"
        );
    }
    let there: BTreeSet<String> = pages()
        .iter()
        .filter(|page| page.starts_with(&docs) && **page != summary)
        .map(|page| name(page))
        .collect();
    let missing: Vec<&String> = there.difference(&listed).collect();
    assert!(missing.is_empty(), "not in docs/SUMMARY.md: {missing:?}");
    let book = std::fs::read_to_string(root().join("book.toml")).unwrap();
    let book: toml::Table = toml::from_str(&book).unwrap();
    assert_eq!(book["book"]["src"].as_str(), Some("docs"));
}
