//! Pages read with a CommonMark parser: blocks of code, anchors of headings, links.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

/// The top of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// The program that pages talk about: the one that was built beside this test, or what `ELITESERVER` names.
pub fn eliteserver() -> PathBuf {
    let path = std::env::var_os("ELITESERVER").map_or_else(
        || {
            let test = std::env::current_exe().unwrap();
            test.parent().unwrap().with_file_name("eliteserver")
        },
        PathBuf::from,
    );
    assert!(path.exists(), "{path:?} is not there: cargo build");
    path
}

/// A block of code.
pub struct Block {
    /// The first word behind the fence; empty for indented blocks.
    pub language: String,
    /// What follows it, `name` or `name=value`.
    pub attributes: BTreeMap<String, String>,
    pub text: String,
    /// Line of the page on which it begins.
    pub line: usize,
}

impl Block {
    pub fn has(&self, attribute: &str) -> bool {
        self.attributes.contains_key(attribute)
    }
}

/// A page, as far as tests look at it.
#[derive(Default)]
pub struct Page {
    pub blocks: Vec<Block>,
    pub anchors: BTreeSet<String>,
    /// Target and line of every link and picture.
    pub links: Vec<(String, usize)>,
}

/// Every page that is ours: those of folders that others fill, and of results of builds, are left out.
pub fn pages() -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                let is_ours = !name.starts_with('.')
                    && !["target", "node_modules", "recordings", "dist", "book"].contains(&name);
                if is_ours {
                    walk(&path, found);
                }
            } else if name.ends_with(".md") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    walk(&root(), &mut found);
    found.sort();
    assert!(found.len() > 15, "{found:?}");
    found
}

/// The page's name from the top of the repository.
pub fn name(path: &Path) -> String {
    path.strip_prefix(root())
        .unwrap()
        .to_str()
        .unwrap()
        .to_owned()
}

/// Reads a page.
pub fn read(path: &Path) -> Page {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
    parse(&text)
}

fn parse(text: &str) -> Page {
    let line_of = |offset: usize| text[..offset].matches('\n').count() + 1;
    let mut page = Page::default();
    let mut heading: Option<String> = None;
    let mut block: Option<Block> = None;
    let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
    for (event, range) in Parser::new_ext(text, options).into_offset_iter() {
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                let info = match kind {
                    CodeBlockKind::Fenced(info) => info.to_string(),
                    CodeBlockKind::Indented => String::new(),
                };
                let mut words = info.split_whitespace();
                block = Some(Block {
                    language: words.next().unwrap_or("").to_owned(),
                    attributes: words
                        .map(|word| word.split_once('=').unwrap_or((word, "")))
                        .map(|(name, value)| (name.to_owned(), value.to_owned()))
                        .collect(),
                    text: String::new(),
                    line: line_of(range.start),
                });
            }
            Event::End(TagEnd::CodeBlock) => page.blocks.extend(block.take()),
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => {
                let anchor = anchor(&heading.take().unwrap_or_default());
                let mut numbered = anchor.clone();
                let mut number = 0;
                while !page.anchors.insert(numbered.clone()) {
                    number += 1;
                    numbered = format!("{anchor}-{number}");
                }
            }
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                page.links
                    .push((dest_url.to_string(), line_of(range.start)));
            }
            Event::Text(said) | Event::Code(said) => {
                if let Some(block) = &mut block {
                    block.text.push_str(&said);
                } else if let Some(heading) = &mut heading {
                    heading.push_str(&said);
                }
            }
            _ => {}
        }
    }
    page
}

/// What a heading is called in links, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    heading
        .trim()
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

#[test]
fn a_page_is_read() {
    let page = parse(
        "# One `two`, three\n\n# One two three\n\n```console background x=1\n$ a\n```\n\n[l](b.md#c) ![p](d.png)\n",
    );
    let anchors: Vec<&str> = page.anchors.iter().map(String::as_str).collect();
    assert_eq!(anchors, ["one-two-three", "one-two-three-1"]);
    let [block] = &page.blocks[..] else { panic!() };
    assert_eq!((&*block.language, &*block.text), ("console", "$ a\n"));
    assert!(block.has("background") && block.attributes["x"] == "1");
    assert_eq!((block.line, page.links.len()), (5, 2));
}
