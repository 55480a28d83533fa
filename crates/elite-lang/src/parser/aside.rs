//! Parts of the tree that were complete when what they stood in turned out to be none. There may be hundreds of thousands of
//! them, so they are not dropped where the parser gives the construct up: they wait until it is done, and go with pauses.

use super::{Failed, Parse, Parser};
use crate::ast::{Arg, DictItem, Expr, FStringPart, release};
use crate::limits::memory::Budget;

/// Such parts.
pub(super) enum Aside {
    Expressions(Vec<Expr>),
    Arguments(Vec<Arg>),
    Items(Vec<DictItem>),
    Parts(Vec<FStringPart>),
}

impl Aside {
    /// Drops them, with pauses.
    pub(super) fn release(self, budget: &Budget<'_>) {
        match self {
            Aside::Expressions(expressions) => release::expressions(expressions, budget),
            Aside::Arguments(arguments) => release::arguments(arguments, budget),
            Aside::Items(items) => release::dict_items(items, budget),
            Aside::Parts(parts) => release::format_parts(parts, budget),
        }
    }
}

impl From<Expr> for Aside {
    fn from(expr: Expr) -> Self {
        Aside::Expressions(vec![expr])
    }
}

impl From<Vec<Expr>> for Aside {
    fn from(expressions: Vec<Expr>) -> Self {
        Aside::Expressions(expressions)
    }
}

impl From<Vec<Arg>> for Aside {
    fn from(arguments: Vec<Arg>) -> Self {
        Aside::Arguments(arguments)
    }
}

impl From<Vec<DictItem>> for Aside {
    fn from(items: Vec<DictItem>) -> Self {
        Aside::Items(items)
    }
}

impl From<Vec<FStringPart>> for Aside {
    fn from(parts: Vec<FStringPart>) -> Self {
        Aside::Parts(parts)
    }
}

impl Parser<'_> {
    /// What was parsed behind something that is complete already, with that; if it failed, what is complete is put aside.
    pub(super) fn behind<H: Into<Aside>, T>(
        &mut self,
        complete: H,
        parsed: Parse<T>,
    ) -> Parse<(H, T)> {
        match parsed {
            Ok(parsed) => Ok((complete, parsed)),
            Err(Failed) => {
                self.aside.push(complete.into());
                Err(Failed)
            }
        }
    }

    /// The same in a list, of which what was parsed becomes the last one.
    pub(super) fn listed<T>(&mut self, mut list: Vec<T>, parsed: Parse<T>) -> Parse<Vec<T>>
    where
        Vec<T>: Into<Aside>,
    {
        match parsed {
            Ok(parsed) => {
                list.push(parsed);
                Ok(list)
            }
            Err(Failed) => {
                self.aside.push(list.into());
                Err(Failed)
            }
        }
    }
}
