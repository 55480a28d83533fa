//! Where script threads stand in the task that the pendant made the program from: the nodes their `$ LINE` directives
//! name.
//!
//! A node is a number in a table of the interpreter, so that passing a directive is a comparison and a store. Every
//! script thread has a place of its own; what it passes while it is resumed waits in a bounded list for the driver.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::Arc;

use elite_syntax::TaskNode;

use super::{BoxExpr, Evaluator, ExprNode, Flow, Frame, StmtNode};
use crate::value::R;

/// Most changes of node that are kept of one resumption; of more, the last one is.
const PASSAGES_MAX: usize = 64;

/// A thread came to a node: which one, and the line of the text it was in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeChange {
    /// The node that is shown from now on.
    pub node: TaskNode,
    /// The line of the statement that follows, from 1.
    pub line: u32,
}

/// Index of a node in the table, from 1; 0 is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeId(u32);

/// The place of one script thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeCursor {
    /// The node of the last directive it passed.
    last_entered: NodeId,
    /// The node that is shown.
    shown: NodeId,
    /// The node that is shown when the motion that follows has ended.
    after_motion: NodeId,
}

impl NodeCursor {
    /// The place of a thread that is started here.
    pub fn for_new_thread(self) -> Self {
        NodeCursor {
            shown: self.last_entered,
            after_motion: NodeId::default(),
            ..self
        }
    }
}

/// The nodes of one interpreter, and the place of the running thread.
#[derive(Default)]
pub struct TaskNodes {
    table: RefCell<Vec<TaskNode>>,
    known: RefCell<HashMap<(u32, Arc<str>), NodeId>>,
    state: Cell<NodeCursor>,
    passages: RefCell<Vec<(NodeId, u32)>>,
}

impl TaskNodes {
    /// The number of a node, which is the same for all directives that name it.
    pub fn intern(&self, number: u32, label: &str) -> NodeId {
        let key = (number, Arc::from(label));
        let mut known = self.known.borrow_mut();
        if let Some(id) = known.get(&key) {
            return *id;
        }
        let mut table = self.table.borrow_mut();
        table.push(TaskNode {
            number,
            label: key.1.clone(),
        });
        let id = NodeId(table.len() as u32);
        known.insert(key, id);
        id
    }

    fn node(&self, id: NodeId) -> Option<TaskNode> {
        let index = (id.0 as usize).checked_sub(1)?;
        self.table.borrow().get(index).cloned()
    }

    /// The node that is shown for a thread.
    pub fn shown_node(&self, state: NodeCursor) -> Option<TaskNode> {
        self.node(state.shown)
    }

    /// The node that the running thread passed last, also one that is only shown later.
    pub fn passed(&self) -> Option<TaskNode> {
        self.node(self.state.get().last_entered)
    }

    /// The place of the running thread.
    pub fn state(&self) -> NodeCursor {
        self.state.get()
    }

    /// Makes `state` that of the running thread; returns the one before.
    pub fn switch_to(&self, state: NodeCursor) -> NodeCursor {
        self.state.replace(state)
    }

    /// The running thread passes a directive, in this line.
    #[inline]
    fn enter(&self, id: NodeId, after: bool, line: u32) {
        let mut state = self.state.get();
        state.last_entered = id;
        if after {
            state.after_motion = id;
        } else if state.shown != id {
            state.shown = id;
            self.note(id, line);
        }
        self.state.set(state);
    }

    /// The motion that followed the latest directive with "after" has ended, or has failed: then it shows nothing.
    pub fn on_motion_end(&self, failed: bool, line: u32) {
        let mut state = self.state.get();
        let due = std::mem::take(&mut state.after_motion);
        if due != NodeId::default() && due != state.shown && !failed {
            state.shown = due;
            self.note(due, line);
        }
        self.state.set(state);
    }

    #[cold]
    fn note(&self, id: NodeId, line: u32) {
        let mut passages = self.passages.borrow_mut();
        if passages.len() == PASSAGES_MAX {
            passages.pop();
        }
        passages.push((id, line));
    }

    /// What the thread that was resumed last has passed since, in order.
    pub fn take_node_changes(&self) -> Vec<NodeChange> {
        let mut passages = self.passages.borrow_mut();
        let passed = passages.drain(..);
        passed
            .filter_map(|(id, line)| {
                let node = self.node(id)?;
                Some(NodeChange { node, line })
            })
            .collect()
    }
}

/// A directive as the thread passes it.
#[derive(Clone, Copy)]
pub struct EnterTaskNode {
    /// The node.
    pub node: NodeId,
    /// The node is shown when the motion that follows has ended.
    pub after: bool,
}

impl EnterTaskNode {
    #[inline]
    fn run(self, ev: &Evaluator<'_>) {
        let core = &ev.core;
        core.nodes.enter(self.node, self.after, core.line.get());
    }
}

impl StmtNode for EnterTaskNode {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        self.run(ev);
        Flow::Next
    }
}

/// The condition of an `elif` behind directives.
pub struct EnterTaskNodeThen {
    /// The directives.
    pub passes: Box<[EnterTaskNode]>,
    /// The condition.
    pub then: BoxExpr,
}

impl ExprNode for EnterTaskNodeThen {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.passes.iter().for_each(|pass| pass.run(ev));
        self.then.eval(ev, f)
    }
}
