//! Statements, with the comments around them.

use super::Translator;
use super::expressions::without_parens;
use super::messages::MessageKind;
use super::scopes::ScopeId;
use crate::urscript::ast::{Expr, ExprKind, Function, FunctionKind, Stmt, StmtKind};

/// Lines of the original that a comment repeats at most.
const QUOTED_LINES_MAX: usize = 5;

impl Translator<'_> {
    /// Writes the statements of a block; an empty one gets a `pass`.
    pub(super) fn write_body(&mut self, body: &[Stmt], scope: ScopeId) {
        let mut is_empty = self.level > 0;
        for stmt in body {
            is_empty &= !self.write(stmt, scope);
        }
        if is_empty {
            self.put("pass");
        }
    }

    fn write_block(&mut self, body: &[Stmt], scope: ScopeId, end_line: u32) {
        self.level += 1;
        self.has_break = true;
        self.write_body(body, scope);
        self.flush_comments(end_line);
        self.level -= 1;
    }

    /// Writes one statement; false where only a comment is left of it.
    fn write(&mut self, stmt: &Stmt, scope: ScopeId) -> bool {
        self.flush_comments(stmt.line);
        self.keep_break(stmt.line);
        self.line = stmt.line;
        let missing_before = self.missing_count();
        let at = self.out.len();
        let is_written = match &stmt.kind {
            StmtKind::Function(function) => {
                self.write_function(function, stmt);
                true
            }
            StmtKind::If { .. } | StmtKind::While(..) => {
                self.write_branches(stmt, scope, missing_before, at);
                self.last_line = stmt.end_line;
                return true;
            }
            StmtKind::Label(text) => {
                self.put(&format!("# {text}"));
                false
            }
            _ => {
                let text = self.simple(stmt, scope);
                match text.is_empty() {
                    true => {
                        if !matches!(&stmt.kind, StmtKind::Assign { value: None, .. }) {
                            self.quote(stmt.line, stmt.end_line);
                        }
                        false
                    }
                    false => {
                        self.put(&text);
                        true
                    }
                }
            }
        };
        if !matches!(stmt.kind, StmtKind::Function(_)) {
            self.quote_missing(missing_before, at, stmt.line, stmt.end_line);
            self.trail(stmt.line, stmt.end_line);
        }
        self.last_line = stmt.end_line;
        is_written
    }

    fn missing_count(&self) -> usize {
        let messages = self.messages.iter();
        messages
            .filter(|message| message.kind == MessageKind::Missing)
            .count()
    }

    /// What has no counterpart stays above its line as a comment.
    fn quote_missing(&mut self, missing_before: usize, at: usize, line: u32, end_line: u32) {
        if self.missing_count() > missing_before {
            let after = self.out.split_off(at);
            self.quote(line, end_line);
            self.out.push_str(&after);
        }
    }

    fn quote(&mut self, line: u32, end_line: u32) {
        let count = end_line.saturating_sub(line) as usize + 1;
        for index in 0..count.min(QUOTED_LINES_MAX) {
            let text = self
                .lines
                .get(line as usize - 1 + index)
                .copied()
                .unwrap_or_default();
            let text = text.split('#').next().unwrap_or_default().trim();
            let text: String = text.chars().filter(|c| !c.is_control()).collect();
            self.put(&format!("# {text}"));
        }
    }

    fn simple(&mut self, stmt: &Stmt, scope: ScopeId) -> String {
        match &stmt.kind {
            StmtKind::Assign { target, value, .. } => match value {
                Some(value) => self.assignment(target, value, scope),
                None => String::new(),
            },
            StmtKind::Expr(expr) => self.statement_of(expr, scope),
            StmtKind::Return(value) => {
                let value = value.as_ref().map(|value| self.stored(value, scope, false));
                match (scope, value) {
                    // The program itself is no function here.
                    (0, _) => "halt()".to_owned(),
                    (_, Some(value)) => format!("return {value}"),
                    (_, None) => "return".to_owned(),
                }
            }
            StmtKind::Break => "break".to_owned(),
            StmtKind::Continue => "continue".to_owned(),
            StmtKind::Pass => "pass".to_owned(),
            StmtKind::Halt => "halt()".to_owned(),
            StmtKind::Pause => "pause()".to_owned(),
            StmtKind::Kill(handle) => {
                format!("stop_thread({})", self.value(without_parens(handle), scope))
            }
            StmtKind::Join(handle) => {
                format!("join_thread({})", self.value(without_parens(handle), scope))
            }
            StmtKind::EnterCritical => "critical_section.acquire()".to_owned(),
            StmtKind::ExitCritical => "critical_section.release()".to_owned(),
            StmtKind::If { .. }
            | StmtKind::While(..)
            | StmtKind::Function(_)
            | StmtKind::Label(_) => String::new(),
        }
    }

    /// A call whose value nobody uses.
    fn statement_of(&mut self, expr: &Expr, scope: ScopeId) -> String {
        let text = self.emit(expr, scope, super::expressions::Form::Argument).0;
        let inner = |head: &str| {
            text.strip_prefix(head)
                .and_then(|rest| rest.strip_suffix(')'))
        };
        // What a remote call gives back is looked at by nobody.
        if let Some(call) = inner("rpc_result(").or_else(|| inner("rpc_object(")) {
            return call.to_owned();
        }
        text
    }

    fn assignment(&mut self, target: &Expr, value: &Expr, scope: ScopeId) -> String {
        let is_item = !matches!(target.kind, ExprKind::Name(_));
        let is_changed = match is_item {
            true => self.analysis.has_nested_changes,
            false => self.analysis.is_mutated(target, scope),
        };
        let value_text = self.stored(value, scope, is_changed);
        let value_text = match value_text.is_empty() {
            true => "None".to_owned(),
            false => value_text,
        };
        let target_text = match &target.kind {
            ExprKind::Name(name) => {
                let new = self.name(name, target.line);
                match self.analysis.scopes.is_unused_local(scope, name) && !name.starts_with('_') {
                    true => format!("_{new}"),
                    false => new,
                }
            }
            _ => self.value(target, scope),
        };
        format!("{target_text} = {value_text}")
    }

    fn write_branches(&mut self, stmt: &Stmt, scope: ScopeId, missing_before: usize, at: usize) {
        let header = |this: &mut Self, word: &str, test: &Expr, missing: usize, at: usize| {
            let test_text = this.value(without_parens(test), scope);
            this.put(&format!("{word} {test_text}:"));
            this.quote_missing(missing, at, test.line, test.line);
            this.trail(test.line, test.line);
            this.last_line = test.line;
        };
        match &stmt.kind {
            StmtKind::While(test, body) => {
                header(self, "while", test, missing_before, at);
                self.write_block(body, scope, stmt.end_line);
            }
            StmtKind::If {
                branches,
                otherwise,
            } => {
                for (index, (test, body)) in branches.iter().enumerate() {
                    let next = branches.get(index + 1).map(|(test, _)| test.line);
                    let next = next.or(otherwise.as_ref().map(|block| block.line));
                    let word = if index == 0 { "if" } else { "elif" };
                    let (missing, at) = (self.missing_count(), self.out.len());
                    let (missing, at) = match index {
                        0 => (missing_before, at),
                        _ => (missing, at),
                    };
                    header(self, word, test, missing, at);
                    self.write_block(body, scope, next.unwrap_or(stmt.end_line));
                }
                if let Some(block) = otherwise {
                    self.put("else:");
                    self.trail(block.line, block.line);
                    self.last_line = block.line;
                    self.write_block(&block.body, scope, stmt.end_line);
                }
            }
            _ => {}
        }
        self.put("end");
        self.trail(stmt.end_line, stmt.end_line);
    }

    fn write_function(&mut self, function: &Function, stmt: &Stmt) {
        let inner = self.analysis.scopes.of_function(function);
        let word = match function.kind {
            FunctionKind::Def | FunctionKind::Thread => "def",
            FunctionKind::Secondary => "sec",
        };
        let mut params = Vec::new();
        for (param, default) in &function.params {
            let name = self.name(param, stmt.line);
            params.push(match default {
                Some(default) => format!("{name}={}", self.value(default, 0)),
                None => name,
            });
        }
        let name = self.name(&function.name, stmt.line);
        self.put(&format!("{word} {name}({}):", params.join(", ")));
        self.trail(stmt.line, stmt.line);
        self.last_line = stmt.line;
        let outer = self.analysis.scopes.scope(inner).outer.clone();
        self.level += 1;
        for (word, is_global) in [("global", true), ("nonlocal", false)] {
            let names: Vec<String> = outer
                .iter()
                .filter(|(_, owner)| (**owner == 0) == is_global)
                .map(|(name, _)| self.name(name, stmt.line))
                .collect();
            if !names.is_empty() {
                self.put(&format!("{word} {}", names.join(", ")));
            }
        }
        self.level -= 1;
        self.write_block(&function.body, inner, stmt.end_line);
        self.put("end");
        self.trail(stmt.end_line, stmt.end_line);
    }

    /// Writes a line.
    fn put(&mut self, text: &str) {
        for _ in 0..self.level {
            self.out.push_str("    ");
        }
        self.out.push_str(text);
        self.out.push('\n');
        self.has_break = false;
    }

    /// An empty line where the original has some.
    fn keep_break(&mut self, line: u32) {
        if line > self.last_line.saturating_add(1) && !self.has_break {
            self.out.push('\n');
            self.has_break = true;
        }
    }

    /// Writes the comments that stand before a line.
    pub(super) fn flush_comments(&mut self, line: u32) {
        while let Some(comment) = self.comments.next_if(|comment| comment.line < line) {
            self.keep_break(comment.line);
            self.put(&format!("#{}", comment.text));
            self.last_line = comment.line;
        }
    }

    /// Writes the comment at the end of a line.
    fn trail(&mut self, line: u32, end_line: u32) {
        while let Some(comment) = self
            .comments
            .next_if(|comment| comment.is_trailing && (line..=end_line).contains(&comment.line))
        {
            if self.out.ends_with('\n') {
                self.out.pop();
                self.out.push_str("  #");
                self.out.push_str(&comment.text);
                self.out.push('\n');
            }
        }
    }
}
