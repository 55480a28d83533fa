//! f-strings.

use elite_syntax::Span;
use elite_syntax::ast::Conversion;

use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::chunked::BULK_CHUNK;
use crate::limits::deferred_drop::NodeList;
use crate::value::{R, Value};

/// A part of an f-string.
pub enum FStringSegment {
    /// Text between the fields.
    Text(Box<str>),
    /// A replacement field.
    Field {
        /// What is shown.
        value: BoxExpr,
        /// `!s`, `!r` or `!a`.
        conversion: Conversion,
        /// The format specification, if it is plain text.
        spec: Box<str>,
        /// The format specification, if it has fields of its own.
        nested: Option<NodeList<FStringSegment>>,
        /// Where the value is written.
        span: Span,
    },
}

/// An f-string.
pub struct FString(pub NodeList<FStringSegment>);

impl ExprNode for FString {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let [FStringSegment::Field { .. }] = &*self.0 {
            return single(&self.0[0], ev, f);
        }
        let mut out = String::with_capacity(16 * self.0.len());
        join(&self.0, ev, f, &mut out)?;
        if out.len() <= BULK_CHUNK {
            return Ok(Value::str(out));
        }
        // The characters of a long text are counted with pauses.
        ev.new_str(out)
    }
}

/// An f-string of nothing but a field: what formats an object may give an object, too.
#[inline(never)]
fn single(part: &FStringSegment, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
    if let FStringSegment::Field {
        value,
        conversion,
        spec,
        nested,
        span,
    } = part
    {
        let value = value.eval(ev, f)?;
        let value = match conversion {
            Conversion::None => value,
            conversion => ev.convert(value, *conversion).trace_at(ev, f, *span)?,
        };
        let Some(parts) = nested else {
            return ev.format_value(&value, spec).trace_at(ev, f, *span);
        };
        let mut spec = String::new();
        join(parts, ev, f, &mut spec)?;
        return ev.format_value(&value, &spec).trace_at(ev, f, *span);
    }
    Ok(Value::str(""))
}

fn join(
    parts: &[FStringSegment],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    out: &mut String,
) -> R<()> {
    for part in parts {
        match part {
            FStringSegment::Text(text) => out.push_str(text),
            FStringSegment::Field {
                value,
                conversion,
                spec,
                nested,
                span,
            } => {
                let value = value.eval(ev, f)?;
                let value = match conversion {
                    Conversion::None => value,
                    conversion => ev.convert(value, *conversion).trace_at(ev, f, *span)?,
                };
                match nested {
                    None => ev.format_into(&value, spec, out).trace_at(ev, f, *span)?,
                    Some(parts) => {
                        let mut spec = String::new();
                        join(parts, ev, f, &mut spec)?;
                        ev.format_into(&value, &spec, out).trace_at(ev, f, *span)?;
                    }
                }
            }
        }
    }
    Ok(())
}
