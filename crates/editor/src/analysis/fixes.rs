//! Changes that do away with findings.

use elite_syntax::ast::visit::{blocks, own_expressions, parts};
use elite_syntax::ast::{Constant, Expr, ExprKind, Stmt, StmtKind, UnaryOp};
use elite_syntax::{Diagnostic, Span};

use super::Analysis;
use super::words::Language;

/// A change of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// What is replaced.
    pub span: Span,
    /// Text that takes its place.
    pub text: String,
}

/// A change that does away with a finding.
pub struct Fix {
    /// What it does.
    pub title: String,
    /// The changes, in the order of the text.
    pub edits: Vec<Edit>,
    /// The likely one.
    pub is_preferred: bool,
}

/// What can be done about a finding.
pub fn fixes(analysis: &Analysis, finding: &Diagnostic, language: Language) -> Vec<Fix> {
    let written = analysis.file.slice(finding.span);
    let mut found = Vec::new();
    let mut put = |title: String, edits: Vec<Edit>| {
        if !edits.is_empty() {
            let is_preferred = found.is_empty();
            found.push(Fix {
                title,
                edits,
                is_preferred,
            });
        }
    };
    if let Some(fix) = &finding.fix {
        let title = language
            .pick("Write '{}'", "改为 '{}'")
            .replace("{}", &fix.text);
        put(
            title,
            vec![Edit {
                span: fix.span,
                text: fix.text.clone(),
            }],
        );
    }
    match finding.code {
        "unused-import" => {
            let title = language.pick("Remove the import", "删除该导入");
            put(title.to_owned(), without_import(analysis, finding.span));
        }
        "unused-variable" => {
            let title = language
                .pick("Call it '_{}'", "改名为 '_{}'")
                .replace("{}", written);
            let places = super::navigate::references(analysis, finding.span.start);
            let edits = places.iter().map(|place| Edit {
                span: place.span,
                text: format!("_{written}"),
            });
            put(title, edits.collect());
        }
        "degrees" => {
            let title = language.pick(
                "Turn degrees into radians with d2r()",
                "用 d2r() 把度换算为弧度",
            );
            let from = if is_pose(analysis, finding) { 3 } else { 0 };
            put(
                title.to_owned(),
                around_numbers(analysis, finding.span, from, usize::MAX, "d2r(", ")"),
            );
        }
        "millimetres" => {
            let title = language.pick("Divide millimetres by 1000", "把毫米除以 1000");
            put(
                title.to_owned(),
                around_numbers(analysis, finding.span, 0, 3, "", " / 1000"),
            );
        }
        "busy-loop" => {
            let title = language.pick("Call sync() in the loop", "在循环中调用 sync()");
            put(title.to_owned(), sync_in_loop(analysis, finding.span));
        }
        "pose-for-joints" => {
            let title = language.pick(
                "Turn the pose into joint positions with get_inverse_kin()",
                "用 get_inverse_kin() 把位姿换算为关节位置",
            );
            put(
                title.to_owned(),
                around(finding.span, "get_inverse_kin(", ")"),
            );
        }
        "joints-for-pose" => {
            let title = language.pick(
                "Turn joint positions into a pose with get_forward_kin()",
                "用 get_forward_kin() 把关节位置换算为位姿",
            );
            put(
                title.to_owned(),
                around(finding.span, "get_forward_kin(", ")"),
            );
        }
        _ => {}
    }
    found
}

fn around(span: Span, before: &str, after: &str) -> Vec<Edit> {
    let at = |offset: u32, text: &str| Edit {
        span: Span {
            start: offset,
            end: offset,
        },
        text: text.to_owned(),
    };
    vec![at(span.start, before), at(span.end, after)]
}

/// Whether the finding is about a pose, of which only the last three numbers are angles.
fn is_pose(analysis: &Analysis, finding: &Diagnostic) -> bool {
    let mut kind = None;
    each_expr(&analysis.module().body, &mut |expr| {
        let ExprKind::Call { function, args } = &expr.kind else {
            return;
        };
        let ExprKind::Name(name) = &function.kind else {
            return;
        };
        let Some(builtin) = super::library::robot(name) else {
            return;
        };
        for (index, arg) in args.iter().enumerate() {
            use elite_syntax::ast::Arg;
            let (value, parameter) = match arg {
                Arg::Positional(value) => (value, builtin.params.get(index)),
                Arg::Keyword(name, value) => {
                    (value, builtin.params.iter().find(|p| *p.name == *name.name))
                }
                _ => continue,
            };
            if value.span == finding.span {
                kind = parameter.map(|parameter| parameter.kind);
            }
        }
    });
    kind == Some(elite_runtime::builtins::declare::ParameterType::Pose)
}

/// Wraps the numbers of a list that are not zero, from item `from` on, before item `to`.
fn around_numbers(
    analysis: &Analysis,
    list: Span,
    from: usize,
    to: usize,
    before: &str,
    after: &str,
) -> Vec<Edit> {
    let mut edits = Vec::new();
    each_expr(&analysis.module().body, &mut |expr| {
        let (ExprKind::List(items) | ExprKind::Tuple(items)) = &expr.kind else {
            return;
        };
        if expr.span != list || !edits.is_empty() {
            return;
        }
        for item in items.iter().take(to).skip(from) {
            if is_number(item) {
                edits.push(Edit {
                    span: item.span,
                    text: format!("{before}{}{after}", analysis.file.slice(item.span)),
                });
            }
        }
    });
    edits
}

fn is_number(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Constant(Constant::Int(value)) => *value != 0,
        ExprKind::Constant(Constant::Float(value)) => *value != 0.0,
        ExprKind::Unary {
            op: UnaryOp::Neg,
            operand,
        } => is_number(operand),
        _ => false,
    }
}

fn each_statement<'t>(body: &'t [Stmt], visit: &mut dyn FnMut(&'t Stmt)) {
    for statement in body {
        visit(statement);
        for inner in blocks(statement) {
            each_statement(inner, visit);
        }
    }
}

fn each_expr<'t>(body: &'t [Stmt], visit: &mut dyn FnMut(&'t Expr)) {
    fn deep<'t>(expr: &'t Expr, visit: &mut dyn FnMut(&'t Expr)) {
        visit(expr);
        parts(expr, &mut |part| deep(part, visit));
    }
    each_statement(body, &mut |statement| {
        own_expressions(statement, &mut |expr| deep(expr, visit));
    });
}

/// Removes the import of the name at `place`, and the statement with the last one.
fn without_import(analysis: &Analysis, place: Span) -> Vec<Edit> {
    let mut edits = Vec::new();
    let file = &analysis.file;
    each_statement(&analysis.module().body, &mut |statement| {
        let (StmtKind::Import(names) | StmtKind::ImportFrom { names, .. }) = &statement.kind else {
            return;
        };
        let whole = |alias: &elite_syntax::ast::ImportAlias| match &alias.alias {
            Some(bound) => alias.name.span.to(bound.span),
            None => alias.name.span,
        };
        let Some(index) = names.iter().position(|alias| {
            let span = whole(alias);
            span.start <= place.start && place.end <= span.end
        }) else {
            return;
        };
        if names.len() > 1 {
            // With the comma before it, or behind it if it is the first.
            let own = whole(&names[index]);
            let span = match index.checked_sub(1) {
                Some(before) => Span {
                    start: whole(&names[before]).end,
                    end: own.end,
                },
                None => Span {
                    start: own.start,
                    end: whole(&names[1]).start,
                },
            };
            edits.push(Edit {
                span,
                text: String::new(),
            });
            return;
        }
        let line = file.line_of(statement.span.start);
        let alone = file.line_text(line).trim() == file.slice(statement.span);
        let (span, text) = match alone && statement_is_removable(analysis, statement) {
            true => {
                let text = analysis.text();
                let start = text[..statement.span.start as usize]
                    .rfind('\n')
                    .map_or(0, |at| at + 1);
                let rest = &text[statement.span.end as usize..];
                let end = rest
                    .find('\n')
                    .map_or(text.len(), |at| statement.span.end as usize + at + 1);
                (Span::new(start, end), String::new())
            }
            false => (statement.span, "pass".to_owned()),
        };
        edits.push(Edit { span, text });
    });
    edits
}

/// A statement that is alone in its block cannot go.
fn statement_is_removable(analysis: &Analysis, statement: &Stmt) -> bool {
    if analysis
        .module()
        .body
        .iter()
        .any(|own| own.span == statement.span)
    {
        return true;
    }
    let mut removable = false;
    each_statement(&analysis.module().body, &mut |outer| {
        for block in blocks(outer) {
            removable |= block.len() > 1 && block.iter().any(|own| own.span == statement.span);
        }
    });
    removable
}

/// `sync()` as the first statement of the loop whose condition is at `test`.
fn sync_in_loop(analysis: &Analysis, test: Span) -> Vec<Edit> {
    let mut edits = Vec::new();
    each_statement(&analysis.module().body, &mut |statement| {
        if let StmtKind::While {
            test: own, body, ..
        } = &statement.kind
            && own.span == test
            && let Some(first) = body.first()
        {
            let start = first.span.start as usize;
            let text = analysis.text();
            let line = text[..start].rfind('\n').map_or(0, |at| at + 1);
            let before = &text[line..start];
            // `while True: …` on one line goes on with a semicolon.
            let sync = match before.trim().is_empty() {
                true => format!("sync()\n{before}"),
                false => "sync(); ".to_owned(),
            };
            edits.push(Edit {
                span: Span::new(start, start),
                text: sync,
            });
        }
    });
    edits
}
