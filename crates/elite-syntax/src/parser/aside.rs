//! Parts of the tree that were complete when what they stood in turned out to be none. There may be hundreds of
//! thousands of them, so they are not dropped where the parser gives the construct up: they wait until it is done, and
//! go with pauses.

use super::{ErrorReported, ParseResult, Parser};
use crate::ast::{Arg, DictItem, Expr, FStringPart, chunked_drop};
use crate::work_budget::WorkBudget;

/// Parts of the tree that are put aside until the parser is done.
pub(super) enum AbandonedNodes {
    Expressions(Vec<Expr>),
    Arguments(Vec<Arg>),
    Items(Vec<DictItem>),
    Parts(Vec<FStringPart>),
}

impl AbandonedNodes {
    /// Drops the parts, with pauses.
    pub(super) fn release(self, budget: &WorkBudget<'_>) {
        match self {
            AbandonedNodes::Expressions(expressions) => {
                chunked_drop::expressions(expressions, budget)
            }
            AbandonedNodes::Arguments(arguments) => chunked_drop::arguments(arguments, budget),
            AbandonedNodes::Items(items) => chunked_drop::dict_items(items, budget),
            AbandonedNodes::Parts(parts) => chunked_drop::format_parts(parts, budget),
        }
    }
}

impl From<Expr> for AbandonedNodes {
    fn from(expr: Expr) -> Self {
        AbandonedNodes::Expressions(vec![expr])
    }
}

impl From<Vec<Expr>> for AbandonedNodes {
    fn from(expressions: Vec<Expr>) -> Self {
        AbandonedNodes::Expressions(expressions)
    }
}

impl From<Vec<Arg>> for AbandonedNodes {
    fn from(arguments: Vec<Arg>) -> Self {
        AbandonedNodes::Arguments(arguments)
    }
}

impl From<Vec<DictItem>> for AbandonedNodes {
    fn from(items: Vec<DictItem>) -> Self {
        AbandonedNodes::Items(items)
    }
}

impl From<Vec<FStringPart>> for AbandonedNodes {
    fn from(parts: Vec<FStringPart>) -> Self {
        AbandonedNodes::Parts(parts)
    }
}

impl Parser<'_> {
    /// What was parsed behind something that is complete already, with that; if it failed, what is complete is put
    /// aside.
    pub(super) fn keep_or_abandon<H: Into<AbandonedNodes>, T>(
        &mut self,
        complete: H,
        parsed: ParseResult<T>,
    ) -> ParseResult<(H, T)> {
        match parsed {
            Ok(parsed) => Ok((complete, parsed)),
            Err(ErrorReported) => {
                self.aside.push(complete.into());
                Err(ErrorReported)
            }
        }
    }

    /// Adds what was parsed to a list; if parsing failed, the list is put aside.
    pub(super) fn push_or_abandon<T>(
        &mut self,
        mut list: Vec<T>,
        parsed: ParseResult<T>,
    ) -> ParseResult<Vec<T>>
    where
        Vec<T>: Into<AbandonedNodes>,
    {
        match parsed {
            Ok(parsed) => {
                list.push(parsed);
                Ok(list)
            }
            Err(ErrorReported) => {
                self.aside.push(list.into());
                Err(ErrorReported)
            }
        }
    }
}
