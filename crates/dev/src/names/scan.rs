//! One crate as the figures need it: its types, functions, comments and lines, each with its place.
//!
//! The syntax tree comes from `syn`. Comments are read line by line, because a parser drops those that are no
//! documentation. Test code counts for the length of lines only: its names are read by whoever reads the test.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};

use super::NamesError;

/// A named thing and where it stands.
#[derive(Clone, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub struct Mention {
    /// The file, as it was given.
    pub path: PathBuf,
    /// The line, from 1.
    pub line: usize,
    /// The name, or the first line of a comment.
    pub text: String,
}

/// A function and its length in lines, from its signature to its closing brace.
#[derive(Clone, Debug)]
pub struct Function {
    /// Name and place.
    pub mention: Mention,
    /// Lines.
    pub lines: usize,
}

/// What a set of files contains.
#[derive(Debug, Default)]
pub struct Inventory {
    /// Structs, enums, unions, traits and type aliases.
    pub types: Vec<Mention>,
    /// Functions and methods.
    pub functions: Vec<Function>,
    /// Comments of documentation, by their first line.
    pub docs: Vec<Mention>,
    /// Other comments that have lines of their own, by the first line.
    pub remarks: Vec<Mention>,
    /// All lines, those of tests included.
    pub lines: usize,
    /// Lines of more than [`LINE_MAX`](super::LINE_MAX) columns.
    pub long_lines: Vec<Mention>,
}

/// Reads the Rust files of a crate.
///
/// Files below `src` give names, functions and comments; those of tests, benchmarks and examples only lines.
///
/// # Errors
/// A folder or file that cannot be read, and source text that does not parse.
pub fn scan_crate(folder: &Path) -> Result<Inventory, NamesError> {
    let mut inventory = Inventory::default();
    let mut sources = Vec::new();
    for path in rust_files(folder)? {
        let text = std::fs::read_to_string(&path).map_err(|source| NamesError::File {
            path: path.clone(),
            source,
        })?;
        inventory.add_lines(&path, &text);
        if path
            .strip_prefix(folder)
            .is_ok_and(|below| below.starts_with("src"))
        {
            sources.push(parsed_source(path, text)?);
        }
    }
    let test_modules: Vec<PathBuf> = sources
        .iter()
        .flat_map(|source| source.test_modules.clone())
        .collect();
    for source in &sources {
        let is_test = test_modules.iter().any(|module| {
            source.path.starts_with(module) || source.path == module.with_extension("rs")
        });
        if !is_test {
            inventory.add_source(source);
        }
    }
    Ok(inventory)
}

impl Inventory {
    /// Appends what another set of files contains.
    pub fn append(&mut self, other: &mut Self) {
        self.types.append(&mut other.types);
        self.functions.append(&mut other.functions);
        self.docs.append(&mut other.docs);
        self.remarks.append(&mut other.remarks);
        self.lines += other.lines;
        self.long_lines.append(&mut other.long_lines);
    }

    fn add_lines(&mut self, path: &Path, text: &str) {
        for (number, line) in (1..).zip(text.lines()) {
            self.lines += 1;
            let columns = line.chars().count();
            if columns > super::LINE_MAX {
                self.long_lines
                    .push(mention(path, number, &format!("{columns} columns")));
            }
        }
    }

    fn add_source(&mut self, source: &Source) {
        let mut collector = DefinitionCollector {
            source,
            inventory: self,
        };
        collector.visit_file(&source.tree);
        self.add_comments(source);
    }

    fn add_comments(&mut self, source: &Source) {
        let mut marker_before = "";
        for (number, line) in (1..).zip(source.text.lines()) {
            let line = line.trim_start();
            let marker = if source.literal_lines.contains(&number) || source.is_test_line(number) {
                ""
            } else {
                comment_marker(line)
            };
            if !marker.is_empty() && marker != marker_before {
                let text = line[marker.len()..].trim();
                let comments = if marker == "//" {
                    &mut self.remarks
                } else {
                    &mut self.docs
                };
                comments.push(mention(&source.path, number, text));
            }
            marker_before = marker;
        }
    }
}

/// A file with its syntax tree and what a line-by-line reading must leave out.
struct Source {
    path: PathBuf,
    text: String,
    tree: syn::File,
    /// Lines that begin inside of a literal.
    literal_lines: BTreeSet<usize>,
    /// Lines of items that only tests compile.
    test_lines: Vec<RangeInclusive<usize>>,
    /// Files of modules that only tests compile, without extension.
    test_modules: Vec<PathBuf>,
}

impl Source {
    fn is_test_line(&self, number: usize) -> bool {
        self.test_lines.iter().any(|lines| lines.contains(&number))
    }
}

fn parsed_source(path: PathBuf, text: String) -> Result<Source, NamesError> {
    let wrong = |error: &dyn std::fmt::Display| NamesError::Syntax {
        path: path.clone(),
        message: error.to_string(),
    };
    let tokens: TokenStream = text
        .parse()
        .map_err(|error: proc_macro2::LexError| wrong(&error))?;
    let mut literal_lines = BTreeSet::new();
    add_literal_lines(tokens.clone(), &mut literal_lines);
    let tree: syn::File = syn::parse2(tokens).map_err(|error| wrong(&error))?;
    let mut tests = TestCollector {
        folder: module_folder(&path),
        lines: Vec::new(),
        modules: Vec::new(),
    };
    tests.visit_file(&tree);
    Ok(Source {
        literal_lines,
        test_lines: tests.lines,
        test_modules: tests.modules,
        path,
        text,
        tree,
    })
}

fn add_literal_lines(tokens: TokenStream, lines: &mut BTreeSet<usize>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => add_literal_lines(group.stream(), lines),
            TokenTree::Literal(literal) => {
                let span = literal.span();
                lines.extend(span.start().line + 1..=span.end().line);
            }
            TokenTree::Ident(_) | TokenTree::Punct(_) => {}
        }
    }
}

/// The folder in which the modules lie that a file declares.
fn module_folder(path: &Path) -> PathBuf {
    let is_root = ["lib.rs", "main.rs", "mod.rs"]
        .iter()
        .any(|name| path.ends_with(name));
    if is_root {
        path.parent().map(Path::to_path_buf).unwrap_or_default()
    } else {
        path.with_extension("")
    }
}

/// Finds items under `#[cfg(test)]`.
struct TestCollector {
    folder: PathBuf,
    lines: Vec<RangeInclusive<usize>>,
    modules: Vec<PathBuf>,
}

impl<'ast> Visit<'ast> for TestCollector {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let attributes: &[syn::Attribute] = match item {
            syn::Item::Fn(item) => &item.attrs,
            syn::Item::Impl(item) => &item.attrs,
            syn::Item::Mod(item) => &item.attrs,
            syn::Item::Struct(item) => &item.attrs,
            syn::Item::Enum(item) => &item.attrs,
            syn::Item::Macro(item) => &item.attrs,
            _ => &[],
        };
        if !attributes.iter().any(is_test_attribute) {
            return visit::visit_item(self, item);
        }
        let span = item.span();
        self.lines.push(span.start().line..=span.end().line);
        if let syn::Item::Mod(module) = item
            && module.content.is_none()
        {
            self.modules
                .push(self.folder.join(module.ident.to_string()));
        }
    }
}

/// Whether an attribute is `#[test]`, or a condition that holds only where tests are compiled.
fn is_test_attribute(attribute: &syn::Attribute) -> bool {
    if attribute.path().is_ident("test") {
        return true;
    }
    let syn::Meta::List(list) = &attribute.meta else {
        return false;
    };
    let mut words = list.tokens.clone().into_iter();
    attribute.path().is_ident("cfg")
        && match words.next() {
            Some(TokenTree::Ident(word)) if word == "test" => true,
            Some(TokenTree::Ident(word)) if word == "all" => {
                list.tokens
                    .to_string()
                    .split(|c: char| !c.is_alphanumeric())
                    .any(|word| word == "test")
                    && !list.tokens.to_string().contains("not")
            }
            _ => false,
        }
}

/// Notes the definitions of a file that are no tests.
struct DefinitionCollector<'a> {
    source: &'a Source,
    inventory: &'a mut Inventory,
}

impl DefinitionCollector<'_> {
    fn add_type(&mut self, name: &syn::Ident) {
        let line = name.span().start().line;
        if !self.source.is_test_line(line) {
            self.inventory
                .types
                .push(mention(&self.source.path, line, &name.to_string()));
        }
    }

    fn add_function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let line = signature.span().start().line;
        if !self.source.is_test_line(line) {
            self.inventory.functions.push(Function {
                mention: mention(&self.source.path, line, &signature.ident.to_string()),
                lines: block.span().end().line + 1 - line,
            });
        }
    }
}

impl<'ast> Visit<'ast> for DefinitionCollector<'_> {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.add_type(&item.ident);
        visit::visit_item_struct(self, item);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.add_type(&item.ident);
        visit::visit_item_enum(self, item);
    }

    fn visit_item_union(&mut self, item: &'ast syn::ItemUnion) {
        self.add_type(&item.ident);
        visit::visit_item_union(self, item);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.add_type(&item.ident);
        visit::visit_item_trait(self, item);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.add_type(&item.ident);
        visit::visit_item_type(self, item);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.add_function(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.add_function(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.add_function(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }
}

/// The marker with which a line begins that is nothing but a comment.
fn comment_marker(line: &str) -> &'static str {
    ["///", "//!", "//"]
        .into_iter()
        .find(|&marker| line.starts_with(marker))
        .unwrap_or_default()
}

fn mention(path: &Path, line: usize, text: &str) -> Mention {
    Mention {
        path: path.to_path_buf(),
        line,
        text: text.to_owned(),
    }
}

/// The Rust files below a folder, in the order of their paths; `target` and hidden folders are left out.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, NamesError> {
    let unreadable = |source| NamesError::File {
        path: folder.to_path_buf(),
        source,
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let (path, name) = (entry.path(), entry.file_name());
        let kind = entry.file_type().map_err(unreadable)?;
        if kind.is_dir() && name != "target" && !name.to_string_lossy().starts_with('.') {
            files.extend(rust_files(&path)?);
        } else if kind.is_file() && path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
