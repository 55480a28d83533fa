//! Rows of the pendant's task tree, which `$ LINE` directives name.

use std::fmt;
use std::sync::Arc;

use messages::{Language, Localized};

use crate::diagnostic_list::quoted;

/// A node of the task tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskNode {
    /// The row of the node in the task tree, from 1.
    pub number: u32,
    /// The label of the node, as the pendant shows it; long ones are cut.
    pub label: Arc<str>,
}

impl fmt::Display for TaskNode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for TaskNode {
    /// `node 7 Approach`, on one line whatever the label holds.
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", language.pick("node", "节点"), self.number)?;
        if self.label.is_empty() {
            return Ok(());
        }
        f.write_str(" ")?;
        for c in quoted(&self.label).chars() {
            if c.is_control() {
                write!(f, "{}", c.escape_default())?;
            } else {
                fmt::Write::write_char(f, c)?;
            }
        }
        Ok(())
    }
}
