//! Expressions: operators, poses, lists, items, fields; and values that are copied where they are stored.

use messages::text;

use super::analysis::rotation_of_one;
use super::kinds::Kinds;
use super::messages::MessageKind;
use super::scopes::ScopeId;
use super::{Translator, poses};
use crate::urscript::ast::{Argument, BinaryOperator, Expr, ExprKind, UnaryOperator};

/// What may become of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Stored or given on: it must know that it is a pose, in programs where this matters.
    Value,
    /// Read by a function of the robot at once: six numbers are enough.
    Argument,
}

/// How strongly the outermost operator binds; an atom most strongly.
const ATOM: u8 = 9;

impl Translator<'_> {
    /// An expression whose value is stored or given on.
    pub(super) fn value(&mut self, expr: &Expr, scope: ScopeId) -> String {
        self.emit(expr, scope, Form::Value).0
    }

    /// A value for a variable, an item, a parameter: lists of Universal Robots are copied when they are stored. No copy
    /// is made where nobody could tell the difference.
    pub(super) fn stored(&mut self, expr: &Expr, scope: ScopeId, is_changed: bool) -> String {
        let text = self.value(expr, scope);
        let (is_variable, is_call) = match &without_parens(expr).kind {
            ExprKind::Name(_) | ExprKind::Index { .. } | ExprKind::Field(..) => (true, false),
            ExprKind::Call { callee, .. } => (
                false,
                matches!(&callee.kind, ExprKind::Name(name) if self.analysis.scopes.named(name).is_some()),
            ),
            _ => (false, false),
        };
        let kind = self.analysis.infer(expr, scope);
        let source = without_parens(expr);
        let matters = is_changed || (is_variable && self.analysis.is_mutated(source, scope));
        let is_function = matches!(&source.kind, ExprKind::Name(name)
            if self.analysis.scopes.symbol(scope, name).is_none());
        if !(is_variable || is_call) || !kind.is_shared() || !matters || is_function {
            return text;
        }
        let is_flat = kind.is_list() && !kind.has_shared_items();
        match is_flat || (kind.is_pose() && !self.analysis.has_pose_objects) {
            true => format!("list({text})"),
            false => format!("elicopy.deepcopy({text})"),
        }
    }

    /// An expression, and how strongly its outermost operator binds.
    pub(super) fn emit(&mut self, expr: &Expr, scope: ScopeId, form: Form) -> (String, u8) {
        match &expr.kind {
            ExprKind::Number(text) => (number(text), ATOM),
            ExprKind::Text(text) => (quoted(text), ATOM),
            ExprKind::Bool(true) => ("True".to_owned(), ATOM),
            ExprKind::Bool(false) => ("False".to_owned(), ATOM),
            ExprKind::Name(name) => (self.variable(name, expr.line, scope), ATOM),
            ExprKind::Paren(inner) => (format!("({})", self.emit(inner, scope, form).0), ATOM),
            ExprKind::Pose(items) => self.pose(items, expr.line, scope, form),
            ExprKind::List(items) => {
                let items: Vec<String> = items.iter().map(|item| self.item(item, scope)).collect();
                (format!("[{}]", items.join(", ")), ATOM)
            }
            ExprKind::Index { base, indices } => {
                let mut text = self.operand(base, scope, Form::Value, ATOM);
                for index in indices {
                    let index = self.emit(index, scope, Form::Value).0;
                    text = format!("{text}[{index}]");
                }
                (text, ATOM)
            }
            ExprKind::Field(base, field) => {
                let base = self.operand(base, scope, Form::Value, ATOM);
                let field = self.name(field, expr.line);
                (format!("{base}.{field}"), ATOM)
            }
            ExprKind::Unary(UnaryOperator::Minus, inner)
                if self.analysis.infer(inner, scope).is_list() =>
            {
                let inner = self.value(inner, scope);
                (format!("elementwise(\"*\", {inner}, -1)"), ATOM)
            }
            ExprKind::Unary(operator, inner) => {
                let (word, strength) = match operator {
                    UnaryOperator::Not => ("not ", 3),
                    UnaryOperator::Minus => ("-", 7),
                    UnaryOperator::Plus => ("+", 7),
                };
                let inner = self.operand(inner, scope, Form::Value, strength);
                (format!("{word}{inner}"), strength)
            }
            ExprKind::Binary(operator, left, right) => self.binary(*operator, left, right, scope),
            ExprKind::Call { callee, args } => {
                (self.call(callee, args, expr.line, scope, form), ATOM)
            }
            ExprKind::Run { name, args } => (self.run(name, args, expr.line, scope), ATOM),
        }
    }

    /// An operand, in brackets where its operator binds less than `strength`.
    pub(super) fn operand(
        &mut self,
        expr: &Expr,
        scope: ScopeId,
        form: Form,
        strength: u8,
    ) -> String {
        let (text, own) = self.emit(expr, scope, form);
        match own < strength {
            true => format!("({text})"),
            false => text,
        }
    }

    /// An item of a list or a field of a structure, copied where a change of the original could be seen.
    pub(super) fn item(&mut self, expr: &Expr, scope: ScopeId) -> String {
        let is_changed = self.analysis.has_nested_changes;
        self.stored(expr, scope, is_changed)
    }

    fn variable(&mut self, name: &str, line: u32, scope: ScopeId) -> String {
        let is_known = self.analysis.scopes.symbol(scope, name).is_some()
            || self.analysis.scopes.named(name).is_some();
        if is_known {
            return self.name(name, line);
        }
        self.missing(
            line,
            name,
            text!(
                "nothing in this text gives it a value",
                "此文本中没有给它赋值"
            ),
        )
    }

    fn binary(
        &mut self,
        operator: BinaryOperator,
        left: &Expr,
        right: &Expr,
        scope: ScopeId,
    ) -> (String, u8) {
        let strength = match operator {
            BinaryOperator::Or => 1,
            BinaryOperator::And => 2,
            BinaryOperator::Xor | BinaryOperator::Compare(_) => 4,
            BinaryOperator::Add | BinaryOperator::Subtract => 5,
            _ => 6,
        };
        if strength >= 5 {
            let kinds = [left, right].map(|side| self.analysis.infer(side, scope));
            let has_pose = kinds.iter().any(|kind| kind.own.has(Kinds::POSE));
            if kinds.iter().any(|kind| kind.own.has(Kinds::LIST)) && !has_pose {
                let (left, right) = (self.value(left, scope), self.value(right, scope));
                let sign = operator.text();
                self.say(
                    self.line,
                    MessageKind::Helper,
                    sign,
                    text!("lists are combined number by number", "列表逐个数运算"),
                );
                return (format!("elementwise(\"{sign}\", {left}, {right})"), ATOM);
            }
        }
        // Comparisons in a row mean something else in Python.
        let is_comparison = strength == 4;
        let left = self.operand(left, scope, Form::Value, strength + u8::from(is_comparison));
        let right = self.operand(right, scope, Form::Value, strength + 1);
        let sign = match operator {
            BinaryOperator::Xor => "!=",
            other => other.text(),
        };
        (format!("{left} {sign} {right}"), strength)
    }

    /// `p[…]`: as roll, pitch and yaw, worked out here where its numbers are known.
    fn pose(&mut self, items: &[Expr], line: u32, scope: ScopeId, form: Form) -> (String, u8) {
        let mut texts: Vec<String> = Vec::new();
        for item in items {
            texts.push(self.emit(item, scope, Form::Value).0);
        }
        let position = texts[..3].join(", ");
        if self.analysis.has_pose_objects && form == Form::Value {
            self.say(
                line,
                MessageKind::Helper,
                "p[…]",
                text!(
                    "a pose that knows its rotation vector",
                    "带有旋转向量的位姿"
                ),
            );
            return (
                format!("Pose([{position}], [{}])", texts[3..].join(", ")),
                ATOM,
            );
        }
        if let Some(name) = rotation_of_one(items)
            && !self.analysis.has_pose_objects
            && self.analysis.scopes.symbol(scope, name).is_some()
        {
            let name = self.name(name, line);
            return (format!("[{position}] + {name}[3:6]"), 5);
        }
        let numbers: Vec<f64> = items[3..].iter().filter_map(poses::constant).collect();
        if let [rx, ry, rz] = numbers[..] {
            if poses::is_rpy_as_well([rx, ry, rz]) {
                return (format!("[{}]", texts.join(", ")), ATOM);
            }
            let rpy = poses::rpy([rx, ry, rz]).map(poses::number).join(", ");
            self.say(
                line,
                MessageKind::Helper,
                "p[…]",
                text!(
                    "the rotation vector {rx}, {ry}, {rz} is roll, pitch, yaw {rpy}",
                    "旋转向量 {rx}, {ry}, {rz} 即 roll、pitch、yaw {rpy}"
                ),
            );
            return (format!("[{position}, {rpy}]"), ATOM);
        }
        self.say(
            line,
            MessageKind::Helper,
            "p[…]",
            text!(
                "the rotation vector is converted while the program runs",
                "旋转向量在程序运行时换算"
            ),
        );
        (format!("pose_from_rotvec({})", texts.join(", ")), ATOM)
    }

    fn run(&mut self, name: &str, args: &[Argument], line: u32, scope: ScopeId) -> String {
        let Some(callee) = self.analysis.scopes.named(name) else {
            return self.missing(
                line,
                name,
                text!(
                    "no thread of this text is called so",
                    "此文本中没有这个名称的线程"
                ),
            );
        };
        let args: Vec<String> = args
            .iter()
            .enumerate()
            .map(|(index, arg)| {
                let is_changed = self.analysis.is_mutated_param(callee, index, None);
                self.stored(&arg.value, scope, is_changed)
            })
            .collect();
        let tuple = match &args[..] {
            [one] => format!("({one},)"),
            _ => format!("({})", args.join(", ")),
        };
        let name = self.name(name, line);
        format!("start_thread({name}, {tuple}, False)")
    }
}

/// An expression without the brackets around it.
pub(super) fn without_parens(mut expr: &Expr) -> &Expr {
    while let ExprKind::Paren(inner) = &expr.kind {
        expr = inner;
    }
    expr
}

/// A text between quotes; backslashes stand for themselves.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            c if c.is_control() => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// Python refuses zeros before a number.
fn number(text: &str) -> String {
    let digits = text.trim_start_matches('0');
    match digits.starts_with(|c: char| c.is_ascii_digit()) {
        true => digits.to_owned(),
        false if digits.len() < text.len() && !digits.starts_with(['x', 'X']) => {
            format!("0{digits}")
        }
        false => text.to_owned(),
    }
}
