//! Going back: the run is given up, and the program run again, without a word, to a place before the one where it
//! stood.

use messages::{Text, text};
use serde_json::{Value as Json, json};

use super::run_channel::{Purpose, ResumeMode, RunCommand, RunEvent, SuspendReason};
use super::run_position::{Position, SeekTarget};
use super::session::{DapSession, ProgramPhase};

/// What the session waits for on its way back.
pub(crate) enum ReverseState {
    /// The held program says where to go back to, for this request.
    Asked(i64),
    /// A run is looked through for breakpoints.
    Scanning,
}

impl DapSession<'_> {
    /// `stepBack` and `restartFrame`: the held program knows the place.
    pub(super) fn begin_back(
        &mut self,
        request: &(i64, String),
        arguments: &Json,
    ) -> Option<Result<Json, Text>> {
        if let Err(error) = self.must_be_held() {
            return Some(Err(error));
        }
        let command = match request.1.as_str() {
            "stepBack" => "back",
            _ => "frameStart",
        };
        self.backwards = Some(ReverseState::Asked(request.0));
        self.order(request, command.to_owned(), arguments)
    }

    /// Whether an answer is to a question of the session itself.
    pub(super) fn is_own_question(&self, request: &(i64, String)) -> bool {
        let is_back = matches!(request.1.as_str(), "stepBack" | "restartFrame");
        is_back
            && matches!(self.backwards, Some(ReverseState::Asked(number)) if number == request.0)
    }

    /// The held program has said where to go back to.
    pub(super) fn go_back(&mut self, request: &(i64, String), result: Result<Json, Text>) {
        self.backwards = None;
        let place = match result {
            Ok(place) => place,
            Err(error) => return self.respond(request, Err(error)),
        };
        self.respond(request, Ok(json!({})));
        let tick = place.get("tick").and_then(Json::as_u64).unwrap_or(0);
        let reason = match request.1.as_str() {
            "stepBack" => "step",
            _ => "restart",
        };
        if tick == 0 {
            // Nothing lies before the first statement of a thread.
            let why = SuspendReason {
                description: Some(text!("the beginning", "程序开头")),
                ..SuspendReason::only("entry")
            };
            return self.handle_run_event(
                self.generation,
                RunEvent::Stopped {
                    thread: self.thread,
                    threads: self.threads.clone(),
                    why,
                    position: self.position,
                    last: None,
                },
            );
        }
        self.seek(SeekTarget::Tick(tick), SuspendReason::only(reason));
    }

    /// Runs the program again up to a place.
    pub(super) fn seek(&mut self, target: SeekTarget, why: SuspendReason) {
        self.start(Purpose::Seek(target, why));
        self.phase = ProgramPhase::Repeating;
    }

    /// `reverseContinue`: to the last place before this one at which a breakpoint holds, or to the beginning.
    pub(super) fn reverse_continue(&mut self, arguments: &Json) -> Result<Json, Text> {
        self.must_be_held()?;
        self.thread_of(arguments)?;
        if let Some(last) = self.last_met.take() {
            self.go_to_met(last);
            return Ok(json!({"allThreadsContinued": true}));
        }
        let before = self.position.moment;
        self.backwards = Some(ReverseState::Scanning);
        self.start(Purpose::Scan { before });
        self.phase = ProgramPhase::Repeating;
        Ok(json!({"allThreadsContinued": true}))
    }

    /// A run was looked through.
    pub(super) fn scanned(&mut self, found: Option<(Position, SuspendReason)>) {
        if !matches!(self.backwards.take(), Some(ReverseState::Scanning)) {
            return;
        }
        self.go_to_met(found);
    }

    fn go_to_met(&mut self, found: Option<(Position, SuspendReason)>) {
        match found {
            Some((position, why)) => self.seek(SeekTarget::Moment(position.moment), why),
            None => self.seek(
                SeekTarget::Tick(1),
                SuspendReason {
                    description: Some(text!("the beginning", "程序开头")),
                    ..SuspendReason::only("entry")
                },
            ),
        }
    }

    /// An exception has ended the program: it is shown where it was raised, with everything as it was then.
    pub(super) fn show_exception(&mut self, moment: u64, why: SuspendReason) {
        self.seek(SeekTarget::Moment(moment), why);
    }

    /// `gotoCycle`: forwards in this run, backwards in a repeated one.
    pub(super) fn go_to_cycle(&mut self, arguments: &Json) -> Result<Json, Text> {
        self.must_be_held()?;
        let cycle = arguments.get("cycle").and_then(Json::as_u64);
        let cycle = cycle.ok_or(text!(
            "gotoCycle needs cycle, a whole number from 0",
            "gotoCycle 需要 cycle，从 0 起的整数"
        ))?;
        match (cycle > self.position.cycle, &self.run) {
            (true, Some(run)) => {
                run.order(RunCommand::Go(ResumeMode::ToCycle(cycle)));
                self.phase = ProgramPhase::Running;
            }
            _ => self.seek(SeekTarget::Cycle(cycle), SuspendReason::only("goto")),
        }
        Ok(json!({}))
    }
}
