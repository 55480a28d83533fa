//! Variables of a held program that the client sets. Each change is a statement, so that it is done again when the run
//! is repeated.

use elite_lang::ThreadId;
use elite_lang::debug::{ChildFilter, PausedProgram};
use messages::{Text, text};
use serde_json::Value as Json;

use super::inspect::{GLOBALS, InspectArguments, ReferenceTarget, last_line};
use super::probe::Probe;
use super::run_channel::RequestId;
use super::run_position::Intervention;

impl Probe {
    pub(super) fn set_variable(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        request: &RequestId,
        asked: &InspectArguments,
    ) -> Result<Option<Json>, Text> {
        let not_set = |name: &str| text!("{name} cannot be set", "{name} 不能设置");
        let (path, thread, call) = match self.referred(asked.variables_reference)? {
            ReferenceTarget::Locals { thread, call } => (asked.name.clone(), thread, call),
            ReferenceTarget::Globals => (asked.name.clone(), self.held.get(), GLOBALS),
            ReferenceTarget::Arm | ReferenceTarget::Parts(_) => {
                return Err(text!(
                    "{} is the arm's: only motions and outputs change it",
                    "{} 属于机械臂：只有运动和输出能改变它",
                    asked.name
                ));
            }
            ReferenceTarget::Value {
                value,
                thread,
                call,
                path,
            } => {
                let path = path.ok_or_else(|| not_set(&asked.name))?;
                let children = halt.children(&value, ChildFilter::Both, 0, usize::MAX);
                let child = children.into_iter().find(|child| child.name == asked.name);
                let suffix = child.and_then(|child| child.suffix);
                let suffix = suffix.ok_or_else(|| not_set(&asked.name))?;
                (format!("{path}{suffix}"), thread, call)
            }
        };
        self.assign(halt, holder, request, (thread, call), &path, &asked.value)
    }

    pub(super) fn set_expression(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        request: &RequestId,
        asked: &InspectArguments,
    ) -> Result<Option<Json>, Text> {
        let place = self.call_of(halt, asked)?;
        self.assign(
            halt,
            holder,
            request,
            place,
            &asked.expression,
            &asked.value,
        )
    }

    fn assign(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        request: &RequestId,
        (number, call): (u32, usize),
        path: &str,
        value: &str,
    ) -> Result<Option<Json>, Text> {
        let what = Intervention {
            moment: self.position(halt).moment,
            thread: number,
            call,
            text: format!("{path} = ({value})"),
            may_move: false,
        };
        match self.execute(halt, holder, &what, request) {
            None => return Ok(None),
            Some(ended) => drop(ended.map_err(last_line)?),
        }
        let thread = self.thread(number).unwrap_or(ThreadId(0));
        let value = self.evaluate(halt, thread, call, path).map_err(last_line)?;
        let path = Some(path.to_owned());
        let shown = self.shown_value(halt, value.unwrap_or_default(), number, call, path);
        Ok(Some(shown.assigned()))
    }
}
