//! Parameter lists of `def` and `lambda`.

use std::collections::BTreeSet;

use messages::text;

use super::{ParseResult, Parser};
use crate::ast::{Parameter, Parameters};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::quoted;
use crate::lexer::TokenKind as T;

/// Work to look for another parameter of the same name.
const PARAMETER: usize = 200;

impl Parser<'_> {
    /// Parameters up to `closer` (`)` of a `def`, `:` of a `lambda`), which is not taken.
    pub(super) fn parameters(&mut self, closer: T) -> ParseResult<Parameters> {
        let mut parameters = Parameters::default();
        let mut after_star = false;
        // Whether a parameter that can be given by position has a default.
        let mut any_default = false;
        while self.kind() != closer {
            let start = self.token().span;
            match self.kind() {
                T::Slash => {
                    self.bump();
                    if after_star
                        || !parameters.positional_only.is_empty()
                        || parameters.positional.is_empty()
                    {
                        return self.fail(
                            start,
                            text!(
                                "'/' must follow positional parameters, once and before '*'",
                                "'/' 必须在位置参数之后、'*' 之前，且只出现一次"
                            ),
                        );
                    }
                    parameters.positional_only = std::mem::take(&mut parameters.positional);
                }
                T::Star => {
                    self.bump();
                    if after_star {
                        return self
                            .fail(start, text!("'*' may appear only once", "'*' 只能出现一次"));
                    }
                    after_star = true;
                    if self.kind() == T::Comma {
                        let names_follow = self.kind_ahead(1) == T::Name;
                        if !names_follow {
                            return self.fail(
                                start,
                                text!(
                                    "named parameters must follow a bare '*'",
                                    "单独的 '*' 之后必须有命名参数"
                                ),
                            );
                        }
                    } else {
                        parameters.star = Some(self.collecting_parameter(closer)?);
                    }
                }
                T::DoubleStar => {
                    self.bump();
                    parameters.double_star = Some(self.collecting_parameter(closer)?);
                    self.eat(T::Comma);
                    if self.kind() != closer {
                        let text = text!(
                            "{} after the '**' parameter",
                            "{}在 '**' 参数之后",
                            closer.describe()
                        );
                        return self.unexpected(text);
                    }
                    break;
                }
                _ => {
                    let parameter = self.parameter(closer)?;
                    if after_star {
                        parameters.keyword_only.push(parameter);
                    } else {
                        self.check_default(&parameter, any_default);
                        any_default |= parameter.default.is_some();
                        parameters.positional.push(parameter);
                    }
                }
            }
            if self.kind() != closer && self.eat(T::Comma).is_none() {
                return self.unexpected(text!("',' or {}", "',' 或{}", closer.describe()));
            }
        }
        self.check_duplicates(&parameters);
        Ok(parameters)
    }

    fn check_default(&mut self, parameter: &Parameter, earlier_default: bool) {
        if parameter.default.is_none() && earlier_default {
            let message = text!(
                "parameter '{}' without a default follows one with a default",
                "没有默认值的参数 '{}' 在有默认值的参数之后",
                quoted(&parameter.name.name)
            );
            self.report(Diagnostic::error("syntax", parameter.name.span, message));
        }
    }

    fn parameter(&mut self, closer: T) -> ParseResult<Parameter> {
        let name = self.ident()?;
        let annotated = closer == T::RightParen && self.eat(T::Colon).is_some();
        let annotation = if annotated {
            Some(self.expression()?)
        } else {
            None
        };
        let default = if self.eat(T::Equal).is_some() {
            Some(self.expression()?)
        } else {
            None
        };
        Ok(Parameter {
            name,
            annotation,
            default,
        })
    }

    /// The parameter after `*` or `**`.
    fn collecting_parameter(&mut self, closer: T) -> ParseResult<Parameter> {
        let parameter = self.parameter(closer)?;
        if let Some(default) = &parameter.default {
            let message = text!(
                "a parameter that collects arguments cannot have a default",
                "收集参数的形参不能有默认值"
            );
            self.report(Diagnostic::error("syntax", default.span, message));
        }
        Ok(parameter)
    }

    fn check_duplicates(&mut self, parameters: &Parameters) {
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        for parameter in parameters.iter() {
            self.budget.charge(PARAMETER);
            if !seen.insert(&parameter.name.name) {
                let name = quoted(&parameter.name.name);
                let message = text!(
                    "duplicate argument '{name}' in function definition",
                    "函数定义中参数 '{name}' 重复"
                );
                self.report(Diagnostic::error("syntax", parameter.name.span, message));
            }
        }
    }
}
