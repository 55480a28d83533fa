//! The queue of interpreter mode: numbers, order, what is skipped, thrown away and cleared (manual chapter 2).
//!
//! Pure: knows no socket, no compiler and no thread. The caller decides when interpreter mode is entered and left, what
//! a statement is, and who is told about it.

use std::collections::VecDeque;

use messages::Localized;
use thiserror::Error;

/// Most statements that can wait (manual 2.2).
pub const STATEMENTS_MAX: usize = 8500;

/// Number of a statement, from 1 in the order of acceptance, for as long as the controller runs. 0 means "none".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StatementId(pub u64);

impl StatementId {
    /// No statement.
    pub const NONE: Self = Self(0);
}

/// What a statement does to the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueueEffect {
    /// Nothing.
    None,
    /// The statement is `clear_interpreter()`: once accepted, nothing newer is accepted until it has been executed.
    Clears,
}

/// The reason for which a statement was not accepted; the statement comes back in the variant.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum PushError<S> {
    /// [`STATEMENTS_MAX`] wait.
    #[error("{STATEMENTS_MAX} statements wait to be executed, which is the limit")]
    #[zh("已有 {STATEMENTS_MAX} 条语句等待执行，达到上限")]
    Full(S),
    /// An accepted `clear_interpreter()` has not been executed yet; try again when [`StatementQueue::is_held`] is
    /// false.
    #[error("a clear_interpreter() has to be executed first")]
    #[zh("必须先执行 clear_interpreter()")]
    Held(S),
}

/// Statements that wait, and the numbers that the state commands report.
#[derive(Debug)]
pub struct StatementQueue<S> {
    waiting: VecDeque<(StatementId, S)>,
    last_accepted: StatementId,
    running: Option<StatementId>,
    last_executed: StatementId,
    last_cleared: StatementId,
    /// Waiting statements up to this one are dropped when the running one ends.
    skip_to: StatementId,
    /// The accepted `clear_interpreter()` that has not been executed.
    clearing: Option<StatementId>,
}

impl<S> Default for StatementQueue<S> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            last_accepted: StatementId::NONE,
            running: None,
            last_executed: StatementId::NONE,
            last_cleared: StatementId::NONE,
            skip_to: StatementId::NONE,
            clearing: None,
        }
    }
}

impl<S> StatementQueue<S> {
    /// Accepts a statement at the end of the queue.
    ///
    /// # Errors
    /// [`PushError`] with the statement: the queue is full, or held by a `clear_interpreter()`.
    pub fn push(&mut self, statement: S, effect: QueueEffect) -> Result<StatementId, PushError<S>> {
        if self.is_held() {
            return Err(PushError::Held(statement));
        }
        if self.waiting.len() >= STATEMENTS_MAX {
            return Err(PushError::Full(statement));
        }
        self.last_accepted.0 += 1;
        let id = self.last_accepted;
        if effect == QueueEffect::Clears {
            self.clearing = Some(id);
        }
        self.waiting.push_back((id, statement));
        Ok(id)
    }

    /// True while nothing is accepted because of a `clear_interpreter()`.
    pub const fn is_held(&self) -> bool {
        self.clearing.is_some()
    }

    /// Takes the next statement to execute and counts it as running; one that still runs counts as finished.
    pub fn begin(&mut self) -> Option<(StatementId, S)> {
        self.finish();
        let (id, statement) = self.waiting.pop_front()?;
        self.running = Some(id);
        self.last_executed = id;
        Some((id, statement))
    }

    /// The running statement has ended, whichever way. What was skipped meanwhile is dropped.
    pub fn finish(&mut self) {
        if let Some(id) = self.running.take()
            && self.clearing == Some(id)
        {
            self.clearing = None;
        }
        self.drop_skipped();
    }

    /// `skipbuffer`: nothing that waits now is executed; the running statement goes on to its end.
    pub fn skip(&mut self) {
        self.skip_to = self.last_accepted;
        if self.running.is_none() {
            self.drop_skipped();
        }
    }

    /// Throws away everything that waits (on entry, or when the task ends) and gives it back, oldest first.
    pub fn throw_away(&mut self) -> Vec<(StatementId, S)> {
        if self.clearing != self.running {
            self.clearing = None; // the one that was waited for will not be executed
        }
        self.waiting.drain(..).collect()
    }

    /// The injected functions were removed: by `clear_interpreter()` or by leaving the mode.
    pub const fn finish_clear(&mut self) {
        self.last_cleared = self.last_executed;
    }

    /// The statement that runs now.
    pub const fn running(&self) -> Option<StatementId> {
        self.running
    }

    /// The statement executed last or being executed (`statelastexecuted`).
    pub const fn last_executed(&self) -> StatementId {
        self.last_executed
    }

    /// The statement accepted last (`statelastinterpreted`).
    pub const fn last_accepted(&self) -> StatementId {
        self.last_accepted
    }

    /// The statement cleared last (`statelastcleared`).
    pub const fn last_cleared(&self) -> StatementId {
        self.last_cleared
    }

    /// How many wait, those that will be skipped included, the running one not (`stateunexecuted`).
    pub fn unexecuted(&self) -> usize {
        self.waiting.len()
    }

    fn drop_skipped(&mut self) {
        let keep = self.waiting.partition_point(|(id, _)| *id <= self.skip_to);
        self.waiting.drain(..keep);
        if self
            .clearing
            .is_some_and(|id| id <= self.skip_to && self.running != Some(id))
        {
            self.clearing = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn queue(statements: usize) -> StatementQueue<usize> {
        let mut queue = StatementQueue::default();
        for number in 1..=statements {
            queue.push(number, QueueEffect::None).unwrap();
        }
        queue
    }

    #[test]
    fn statements_are_numbered_from_one_and_executed_in_order() {
        let mut queue = queue(2);
        assert_eq!(queue.last_accepted(), StatementId(2));
        assert_eq!(queue.last_executed(), StatementId::NONE);
        assert_eq!(queue.unexecuted(), 2);
        assert_eq!(queue.begin(), Some((StatementId(1), 1)));
        assert_eq!(queue.last_executed(), StatementId(1));
        assert_eq!(queue.unexecuted(), 1, "the running one does not count");
        assert_eq!(queue.begin(), Some((StatementId(2), 2)));
        assert_eq!(queue.begin(), None);
        assert_eq!(queue.last_executed(), StatementId(2));
        assert_eq!(queue.running(), None);
    }

    #[test]
    fn one_statement_more_than_the_limit_is_refused_without_a_number() {
        let mut queue = queue(STATEMENTS_MAX);
        assert_eq!(queue.push(0, QueueEffect::None), Err(PushError::Full(0)));
        assert_eq!(queue.last_accepted(), StatementId(8500));
        queue.begin();
        assert_eq!(queue.push(0, QueueEffect::None), Ok(StatementId(8501)));
    }

    #[test]
    fn skipped_statements_wait_until_the_running_one_ends() {
        let mut queue = queue(3);
        queue.begin();
        queue.skip();
        assert_eq!(queue.unexecuted(), 2);
        assert_eq!(queue.push(4, QueueEffect::None), Ok(StatementId(4)));
        queue.finish();
        assert_eq!(queue.unexecuted(), 1);
        assert_eq!(queue.last_executed(), StatementId(1));
        assert_eq!(queue.begin(), Some((StatementId(4), 4)));
    }

    #[test]
    fn with_nothing_running_a_skip_takes_effect_at_once() {
        let mut queue = queue(3);
        queue.skip();
        assert_eq!(queue.unexecuted(), 0);
        assert_eq!(queue.last_accepted(), StatementId(3));
    }

    #[test]
    fn nothing_is_accepted_between_a_clear_and_its_execution() {
        let mut queue = queue(1);
        assert_eq!(queue.push(2, QueueEffect::Clears), Ok(StatementId(2)));
        assert_eq!(queue.push(3, QueueEffect::None), Err(PushError::Held(3)));
        queue.begin();
        assert!(queue.is_held());
        assert_eq!(queue.begin(), Some((StatementId(2), 2)));
        assert!(queue.is_held(), "it is being executed");
        queue.finish_clear();
        queue.finish();
        assert!(!queue.is_held());
        assert_eq!(queue.last_cleared(), StatementId(2));
        assert_eq!(queue.push(3, QueueEffect::None), Ok(StatementId(3)));
    }

    #[test]
    fn a_clear_that_is_skipped_or_thrown_away_holds_nothing() {
        let mut skipped = queue(0);
        skipped.push(1, QueueEffect::Clears).unwrap();
        skipped.skip();
        assert!(!skipped.is_held());

        let mut waiting = queue(1);
        waiting.begin();
        waiting.push(2, QueueEffect::Clears).unwrap();
        waiting.skip();
        assert!(waiting.is_held(), "it is dropped when the running one ends");
        waiting.finish();
        assert!(!waiting.is_held());

        let mut thrown = queue(1);
        thrown.push(2, QueueEffect::Clears).unwrap();
        assert_eq!(
            thrown.throw_away(),
            [(StatementId(1), 1), (StatementId(2), 2)]
        );
        assert!(!thrown.is_held());

        let mut running = queue(0);
        running.push(1, QueueEffect::Clears).unwrap();
        running.begin();
        running.throw_away();
        assert!(running.is_held(), "the running one is still being executed");
    }

    #[test]
    fn numbers_go_on_after_everything_was_thrown_away() {
        let mut queue = queue(2);
        queue.throw_away();
        assert_eq!(queue.unexecuted(), 0);
        assert_eq!(queue.push(3, QueueEffect::None), Ok(StatementId(3)));
    }

    #[derive(Clone, Debug)]
    enum Step {
        Push(bool),
        Begin,
        Finish,
        Skip,
        ThrowAway,
        Cleared,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            4 => proptest::bool::weighted(0.2).prop_map(Step::Push),
            3 => Just(Step::Begin),
            2 => Just(Step::Finish),
            1 => Just(Step::Skip),
            1 => Just(Step::ThrowAway),
            1 => Just(Step::Cleared),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]
        #[test]
        fn every_number_is_executed_once_in_order_or_never_and_no_hold_lasts(
            steps in proptest::collection::vec(step(), 0..60),
        ) {
            let mut queue = StatementQueue::default();
            let mut executed = Vec::new();
            for step in steps {
                match step {
                    Step::Push(clears) => {
                        let effect = if clears { QueueEffect::Clears } else { QueueEffect::None };
                        let held = queue.is_held();
                        prop_assert_eq!(queue.push((), effect).is_err(), held);
                    }
                    Step::Begin => executed.extend(queue.begin().map(|(id, ())| id)),
                    Step::Finish => queue.finish(),
                    Step::Skip => queue.skip(),
                    Step::ThrowAway => drop(queue.throw_away()),
                    Step::Cleared => queue.finish_clear(),
                }
                prop_assert!(queue.last_cleared() <= queue.last_executed());
                prop_assert!(queue.last_executed() <= queue.last_accepted());
            }
            while let Some((id, ())) = queue.begin() {
                executed.push(id);
            }
            prop_assert!(executed.is_sorted_by(|a, b| a < b));
            prop_assert!(!queue.is_held(), "with an empty queue nothing can be waited for");
        }
    }
}
