//! What is known of a whole text before it is written anew: kinds of its variables, what is changed in place, and
//! whether poses must carry their kind with them while the program runs.

use std::collections::{BTreeMap, BTreeSet};

use super::functions::function;
use super::kinds::{Kinds, Type};
use super::scopes::{ScopeId, Scopes, Symbol};
use crate::urscript::ast::{
    Argument, BinaryOperator, Expr, ExprKind, Stmt, StmtKind, UnaryOperator, walk_expr,
};

/// Rounds until kinds no longer change; every round carries them one assignment further.
const ROUNDS_MAX: usize = 40;

/// Methods of lists.
pub const LIST_METHODS: [&str; 10] = [
    "append",
    "capacity",
    "clear",
    "extend",
    "insert",
    "length",
    "pop",
    "remove",
    "slice",
    "to_string",
];

/// Methods that change a list.
const CHANGING_METHODS: [&str; 6] = ["append", "clear", "extend", "insert", "pop", "remove"];

/// What is known of a text.
pub struct Analysis {
    /// Where names live.
    pub scopes: Scopes,
    types: BTreeMap<Symbol, Type>,
    fields: BTreeMap<String, Type>,
    results: Vec<Type>,
    /// Variables whose items or fields are assigned.
    mutated: BTreeSet<Symbol>,
    /// Whether an item of an item is assigned anywhere.
    pub has_nested_changes: bool,
    /// Whether poses are objects that know their rotation vector.
    pub has_pose_objects: bool,
    /// Names of the functions that are called.
    pub called: BTreeSet<String>,
    changed: bool,
}

impl Analysis {
    /// Looks through the statements of a program.
    pub fn of(body: &[Stmt]) -> Self {
        let scopes = Scopes::of(body);
        let mut analysis = Self {
            results: vec![Type::default(); scopes.count()],
            scopes,
            types: BTreeMap::new(),
            fields: BTreeMap::new(),
            mutated: BTreeSet::new(),
            has_nested_changes: false,
            has_pose_objects: false,
            called: BTreeSet::new(),
            changed: false,
        };
        analysis.settle(body);
        // A parameter that no call tells about is what its function takes it for.
        analysis.guess_params(body, 0);
        analysis.settle(body);
        analysis.find_changes(body, 0);
        analysis.has_pose_objects = analysis.wants_pose_objects(body, 0);
        analysis
    }

    fn settle(&mut self, body: &[Stmt]) {
        for _ in 0..ROUNDS_MAX {
            self.changed = false;
            self.infer_body(body, 0);
            if !self.changed {
                return;
            }
        }
    }

    fn add_type(&mut self, symbol: Symbol, more: Type) {
        let known = self.types.entry(symbol).or_default();
        let sum = known.or(more);
        self.changed |= *known != sum;
        *known = sum;
    }

    fn add_param(&mut self, scope: ScopeId, index: usize, name: Option<&str>, more: Type) {
        let params = &self.scopes.scope(scope).params;
        let param = match name {
            Some(name) => params.iter().find(|param| *param == name),
            None => params.get(index),
        };
        if let Some(param) = param.cloned() {
            self.add_type((scope, param), more);
        }
    }

    fn infer_body(&mut self, body: &[Stmt], scope: ScopeId) {
        for stmt in body {
            for expr in stmt.expressions() {
                self.note_calls(expr, scope);
            }
            match &stmt.kind {
                StmtKind::Assign {
                    target,
                    value: Some(value),
                    ..
                } => {
                    let kind = self.infer(value, scope);
                    self.assign(target, kind, scope);
                }
                StmtKind::Return(Some(value)) => {
                    let sum = self.results[scope].or(self.infer(value, scope));
                    self.changed |= self.results[scope] != sum;
                    self.results[scope] = sum;
                }
                StmtKind::Function(function) => {
                    let inner = self.scopes.of_function(function);
                    for (name, default) in &function.params {
                        if let Some(default) = default {
                            let kind = self.infer(default, scope);
                            self.add_type((inner, name.clone()), kind);
                        }
                    }
                    self.infer_body(&function.body, inner);
                }
                _ => {}
            }
            stmt.blocks()
                .into_iter()
                .for_each(|block| self.infer_body(block, scope));
        }
    }

    fn assign(&mut self, target: &Expr, kind: Type, scope: ScopeId) {
        match &target.kind {
            ExprKind::Name(name) => {
                if let Some(symbol) = self.scopes.symbol(scope, name) {
                    self.add_type(symbol, kind);
                }
            }
            ExprKind::Index { base, indices } => {
                // An item of a pose is a number of that pose.
                if let ExprKind::Name(name) = &base.kind
                    && let Some(symbol) = self.scopes.symbol(scope, name)
                    && !self.infer(base, scope).is_pose()
                {
                    let row = match indices.len() {
                        2 => Type::list(kind),
                        _ => kind,
                    };
                    self.add_type(symbol, Type::list(row));
                }
            }
            ExprKind::Field(_, field) => self.add_field(field, kind),
            _ => {}
        }
    }

    fn add_field(&mut self, field: &str, more: Type) {
        let known = self.fields.entry(field.to_owned()).or_default();
        let sum = known.or(more);
        self.changed |= *known != sum;
        *known = sum;
    }

    /// Kinds of arguments go to the parameters, and those of fields to the fields.
    fn note_calls(&mut self, expr: &Expr, scope: ScopeId) {
        let mut calls: Vec<(&str, &[Argument])> = Vec::new();
        let mut appends: Vec<(&Expr, &Expr)> = Vec::new();
        walk_expr(expr, &mut |expr| match &expr.kind {
            ExprKind::Call { callee, args } => match &callee.kind {
                ExprKind::Name(name) => calls.push((name, args)),
                ExprKind::Field(base, method) => {
                    if let ("append" | "insert", Some(last)) = (method.as_str(), args.last()) {
                        appends.push((base, &last.value));
                    }
                }
                _ => {}
            },
            ExprKind::Run { name, args } => calls.push((name, args)),
            _ => {}
        });
        for (name, args) in calls {
            self.called.insert(name.to_owned());
            if name == "struct" {
                for arg in args {
                    let kind = self.infer(&arg.value, scope);
                    self.add_field(arg.name.as_deref().unwrap_or_default(), kind);
                }
            } else if let Some(callee) = self.scopes.named(name) {
                for (index, arg) in args.iter().enumerate() {
                    let kind = self.infer(&arg.value, scope);
                    self.add_param(callee, index, arg.name.as_deref(), kind);
                }
            }
        }
        for (base, item) in appends {
            let kind = Type::list(self.infer(item, scope));
            if self.infer(base, scope).own.has(Kinds::LIST) {
                self.assign(base, kind, scope);
            }
        }
    }

    /// The kinds that an expression can have.
    pub fn infer(&self, expr: &Expr, scope: ScopeId) -> Type {
        match &expr.kind {
            ExprKind::Number(_) => Type::of(Kinds::NUMBER),
            ExprKind::Text(_) => Type::of(Kinds::TEXT),
            ExprKind::Bool(_) => Type::of(Kinds::BOOL),
            ExprKind::Pose(_) => Type::of(Kinds::POSE),
            ExprKind::Run { .. } => Type::of(Kinds::NUMBER),
            ExprKind::Paren(inner) => self.infer(inner, scope),
            ExprKind::Name(name) => self
                .scopes
                .symbol(scope, name)
                .and_then(|symbol| self.types.get(&symbol).copied())
                .unwrap_or_default(),
            ExprKind::List(items) => Type::list(
                items
                    .iter()
                    .map(|item| self.infer(item, scope))
                    .fold(Type::default(), Type::or),
            ),
            ExprKind::Index { base, indices } => {
                let item = self.infer(base, scope).item();
                match indices.len() {
                    2 => item.item(),
                    _ => item,
                }
            }
            ExprKind::Field(_, field) => self.fields.get(field).copied().unwrap_or_default(),
            ExprKind::Unary(UnaryOperator::Not, _) => Type::of(Kinds::BOOL),
            ExprKind::Unary(_, inner) => self.infer(inner, scope),
            ExprKind::Binary(operator, left, right) => match operator {
                BinaryOperator::Or
                | BinaryOperator::And
                | BinaryOperator::Xor
                | BinaryOperator::Compare(_) => Type::of(Kinds::BOOL),
                _ => {
                    let (left, right) = (self.infer(left, scope), self.infer(right, scope));
                    match (left.is_list(), right.is_list()) {
                        (true, false) => left,
                        (false, true) => right,
                        _ => left.or(right),
                    }
                }
            },
            ExprKind::Call { callee, args } => self.infer_call(callee, args, scope),
        }
    }

    fn infer_call(&self, callee: &Expr, args: &[Argument], scope: ScopeId) -> Type {
        let argument = |index: usize| {
            args.get(index)
                .map(|arg| self.infer(&arg.value, scope))
                .unwrap_or_default()
        };
        match &callee.kind {
            ExprKind::Name(name) => {
                if let Some(callee) = self.scopes.named(name) {
                    return self.results[callee];
                }
                match name.as_str() {
                    "struct" => Type::of(Kinds::STRUCT),
                    "inv" => argument(0),
                    "make_list" => Type::list(argument(1)),
                    _ => function(name).map(|row| row.result()).unwrap_or_default(),
                }
            }
            ExprKind::Field(base, method) => match method.as_str() {
                "length" | "capacity" => Type::of(Kinds::NUMBER),
                "to_string" => Type::of(Kinds::TEXT),
                "pop" => self.infer(base, scope).item(),
                "slice" => self.infer(base, scope),
                _ => Type::default(),
            },
            _ => Type::default(),
        }
    }

    fn guess_params(&mut self, body: &[Stmt], scope: ScopeId) {
        for stmt in body {
            for expr in stmt.expressions() {
                let mut guesses = Vec::new();
                walk_expr(expr, &mut |expr| {
                    if let ExprKind::Call { callee, args } = &expr.kind
                        && let ExprKind::Name(name) = &callee.kind
                        && self.scopes.named(name).is_none()
                        && let Some(row) = function(name)
                    {
                        let params = row.parameters();
                        for (index, arg) in args.iter().enumerate() {
                            let param = match &arg.name {
                                Some(name) => params.iter().find(|param| param.name == name),
                                None => params.get(index),
                            };
                            if let (Some(param), ExprKind::Name(given)) = (param, &arg.value.kind) {
                                guesses.push((given.clone(), param.kind));
                            }
                        }
                    }
                });
                for (name, kind) in guesses {
                    let Some(symbol) = self.scopes.symbol(scope, &name) else {
                        continue;
                    };
                    let known = self.types.get(&symbol).copied().unwrap_or_default();
                    let is_param = self.scopes.scope(symbol.0).params.contains(&name);
                    if known.own.is_unknown() && is_param {
                        match kind {
                            "p" => self.add_type(symbol, Type::of(Kinds::POSE)),
                            "j" => self.add_type(symbol, Type::list(Type::of(Kinds::NUMBER))),
                            _ => {}
                        }
                    }
                }
            }
            if let StmtKind::Function(function) = &stmt.kind {
                let inner = self.scopes.of_function(function);
                self.guess_params(&function.body, inner);
            }
            stmt.blocks()
                .into_iter()
                .for_each(|block| self.guess_params(block, scope));
        }
    }

    fn find_changes(&mut self, body: &[Stmt], scope: ScopeId) {
        for stmt in body {
            match &stmt.kind {
                StmtKind::Assign { target, .. } => {
                    self.note_change(target, scope);
                }
                StmtKind::Function(function) => {
                    let inner = self.scopes.of_function(function);
                    self.find_changes(&function.body, inner);
                }
                _ => {}
            }
            for expr in stmt.expressions() {
                let mut bases = Vec::new();
                walk_expr(expr, &mut |expr| {
                    if let ExprKind::Call { callee, .. } = &expr.kind
                        && let ExprKind::Field(base, method) = &callee.kind
                        && CHANGING_METHODS.contains(&method.as_str())
                    {
                        bases.push(&**base);
                    }
                });
                for base in bases {
                    self.has_nested_changes |= !matches!(base.kind, ExprKind::Name(_));
                    if let Some(symbol) = self.root(base, scope) {
                        self.mutated.insert(symbol);
                    }
                }
            }
            stmt.blocks()
                .into_iter()
                .for_each(|block| self.find_changes(block, scope));
        }
    }

    fn note_change(&mut self, target: &Expr, scope: ScopeId) {
        let (ExprKind::Index { base, .. } | ExprKind::Field(base, _)) = &target.kind else {
            return;
        };
        let is_matrix =
            matches!(&target.kind, ExprKind::Index { indices, .. } if indices.len() == 2);
        self.has_nested_changes |= is_matrix || !matches!(base.kind, ExprKind::Name(_));
        if let Some(symbol) = self.root(base, scope) {
            self.mutated.insert(symbol);
        }
    }

    /// The variable that an item, a field or a variable belongs to.
    fn root(&self, expr: &Expr, scope: ScopeId) -> Option<Symbol> {
        match &expr.kind {
            ExprKind::Name(name) => self.scopes.symbol(scope, name),
            ExprKind::Index { base, .. } | ExprKind::Field(base, _) | ExprKind::Paren(base) => {
                self.root(base, scope)
            }
            _ => None,
        }
    }

    /// Whether the items of the variable behind an expression are changed anywhere.
    pub fn is_mutated(&self, expr: &Expr, scope: ScopeId) -> bool {
        self.root(expr, scope)
            .is_some_and(|symbol| self.mutated.contains(&symbol))
    }

    /// Whether the items of a parameter are changed anywhere.
    pub fn is_mutated_param(&self, function: ScopeId, index: usize, name: Option<&str>) -> bool {
        let params = &self.scopes.scope(function).params;
        let param = match name {
            Some(name) => params.iter().find(|param| *param == name),
            None => params.get(index),
        };
        param.is_some_and(|param| self.mutated.contains(&(function, param.clone())))
    }

    /// Whether rotations are read or written number by number, or a value may be a pose or joint positions where it
    /// matters.
    fn wants_pose_objects(&self, body: &[Stmt], scope: ScopeId) -> bool {
        body.iter().any(|stmt| {
            let mut found = false;
            for expr in stmt.expressions() {
                // The rotation of one pose in another one needs no rotation vector.
                let mut harmless: Vec<*const Expr> = Vec::new();
                walk_expr(expr, &mut |expr| match &expr.kind {
                    ExprKind::Pose(items) if rotation_of_one(items).is_some() => {
                        harmless.extend(items[3..].iter().map(std::ptr::from_ref));
                    }
                    ExprKind::Index { base, indices }
                        if !harmless.contains(&std::ptr::from_ref(expr)) =>
                    {
                        let base = self.infer(base, scope);
                        let is_position = matches!(
                            &indices[0].kind,
                            ExprKind::Number(text) if matches!(text.as_str(), "0" | "1" | "2")
                        );
                        found |= base.own.has(Kinds::POSE) && !is_position;
                    }
                    ExprKind::Call { callee, args } => {
                        if let ExprKind::Name(name) = &callee.kind
                            && is_motion(name)
                        {
                            found |= args
                                .iter()
                                .any(|arg| self.infer(&arg.value, scope).is_mixed());
                        }
                    }
                    _ => {}
                });
            }
            if let StmtKind::Function(function) = &stmt.kind {
                found |= self.wants_pose_objects(&function.body, self.scopes.of_function(function));
            }
            found
                || stmt
                    .blocks()
                    .into_iter()
                    .any(|block| self.wants_pose_objects(block, scope))
        })
    }
}

/// Motions, which take poses and joint positions alike.
pub fn is_motion(name: &str) -> bool {
    matches!(
        name,
        "movej" | "movel" | "movep" | "movec" | "servoc" | "servoj" | "optimovej" | "optimovel"
    )
}

/// The pose whose rotation vector the last three of these numbers are, item by item.
pub fn rotation_of_one(items: &[Expr]) -> Option<&str> {
    let mut found: Option<&str> = None;
    for (item, wanted) in items.get(3..6)?.iter().zip(["3", "4", "5"]) {
        let ExprKind::Index { base, indices } = &item.kind else {
            return None;
        };
        let (ExprKind::Name(name), [index]) = (&base.kind, &indices[..]) else {
            return None;
        };
        let is_wanted = matches!(&index.kind, ExprKind::Number(text) if text == wanted);
        if !is_wanted || found.is_some_and(|found| found != name) {
            return None;
        }
        found = Some(name);
    }
    found
}
