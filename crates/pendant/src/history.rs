//! What the time line of the page shows: frames, what was in the panel, registers, parts and events over the whole
//! time, within a bound.
//!
//! Owns the bound and the search. The same for a controller that runs and for a recording: who fills it makes the
//! difference.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::bounded_series::{BoundedSeries, HeapSize};
use crate::frame::{FRAME_BYTES, shows_the_same};

/// Frames: a quarter of an hour at 60 a second before they are thinned out. Evenly, those of an hour are 62.5 ms apart.
const FRAMES_MAX: usize = 60_000;
/// Bytes of all panels, and of all registers.
const TEXT_BYTES_MAX: usize = 16 << 20;
/// Bytes of all moments of the world: 200 parts have 20 kB.
const WORLD_BYTES_MAX: usize = 32 << 20;
/// Panels, and registers.
const TEXTS_MAX: usize = 20_000;
/// Events.
const EVENTS_MAX: usize = 20_000;
/// Most frames in an answer.
pub const POINTS_MAX: usize = 4000;
/// Most events in an answer.
pub const EVENTS_GIVEN_MAX: usize = 2000;
/// From this level on an event is no mere line of the log (those of debug and information are 1 and 2).
pub const LEVEL_OF_MARKS: u8 = 3;
/// A frame that shows nothing new is kept after so long, s.
const STILL_PERIOD: f64 = 1.0;

/// Something that has happened.
#[derive(Clone, Debug)]
struct TimedEvent {
    /// Level of a log line: 1 debug to 5 fatal.
    level: u8,
    json: Arc<str>,
}

impl HeapSize for TimedEvent {
    fn weight(&self) -> usize {
        self.json.len()
    }
}

/// Selection of events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventQuery {
    /// Beginning of the span, s.
    pub from: f64,
    /// End of the span, s.
    pub to: f64,
    /// Lowest level, 1 debug to 5 fatal.
    pub level: u8,
    /// Most events of an answer, never more than [`EVENTS_GIVEN_MAX`].
    pub most: usize,
    /// The first events of the span are given, not the latest.
    pub first: bool,
}

/// The history.
#[derive(Clone, Debug)]
pub struct History {
    frames: BoundedSeries<Box<[u8]>>,
    panels: BoundedSeries<Arc<str>>,
    registers: BoundedSeries<Arc<str>>,
    /// Parts and what handles them.
    world: BoundedSeries<Arc<str>>,
    /// Warnings, errors, alarms, changes of mode, commands: what is jumped to.
    marks: BoundedSeries<TimedEvent>,
    /// Other lines of the log.
    lines: BoundedSeries<TimedEvent>,
    /// The latest frame, which is kept only when the next one shows something else.
    still: Option<(f64, [u8; FRAME_BYTES])>,
    /// Nothing is added any more.
    whole: bool,
}

impl Default for History {
    fn default() -> Self {
        Self {
            frames: BoundedSeries::new(FRAMES_MAX, FRAMES_MAX * FRAME_BYTES),
            panels: BoundedSeries::new(TEXTS_MAX, TEXT_BYTES_MAX),
            registers: BoundedSeries::new(TEXTS_MAX, TEXT_BYTES_MAX),
            world: BoundedSeries::new(TEXTS_MAX, WORLD_BYTES_MAX),
            marks: BoundedSeries::new(EVENTS_MAX, TEXT_BYTES_MAX),
            lines: BoundedSeries::new(EVENTS_MAX, TEXT_BYTES_MAX),
            still: None,
            whole: false,
        }
    }
}

impl History {
    /// Of something whole, such as a recording: every part of it is kept alike.
    pub fn of_recording() -> Self {
        Self {
            frames: BoundedSeries::even(FRAMES_MAX, FRAMES_MAX * FRAME_BYTES),
            panels: BoundedSeries::even(TEXTS_MAX, TEXT_BYTES_MAX),
            registers: BoundedSeries::even(TEXTS_MAX, TEXT_BYTES_MAX),
            world: BoundedSeries::even(TEXTS_MAX, WORLD_BYTES_MAX),
            ..Self::default()
        }
    }

    /// One frame more.
    pub fn frame(&mut self, time: f64, frame: &[u8; FRAME_BYTES]) {
        let last = self.frames.span().map(|(_, last)| last);
        let latest = last.and_then(|last| self.frames.at(last));
        let has_changed = latest.is_none_or(|(_, latest)| !shows_the_same(latest, frame));
        let is_new =
            has_changed || latest.is_some_and(|(at, _)| time - at >= STILL_PERIOD || time < *at);
        if !is_new {
            self.still = Some((time, *frame));
            return;
        }
        // What stood still until now must not look as if it had moved slowly.
        if let Some((at, still)) = self.still.take()
            && has_changed
            && latest.is_some_and(|(latest, _)| at > *latest)
            && at < time
        {
            self.frames.push(at, Box::from(still.as_slice()));
        }
        self.frames.push(time, Box::from(frame.as_slice()));
    }

    /// The panel is this from `time` on: program, popups, variables, as JSON.
    pub fn panel(&mut self, time: f64, panel: Arc<str>) {
        self.panels.push(time, panel);
    }

    /// The registers are these from `time` on, as JSON.
    pub fn registers(&mut self, time: f64, registers: Arc<str>) {
        self.registers.push(time, registers);
    }

    /// Parts and what handles them are so from `time` on, as JSON.
    pub fn world(&mut self, time: f64, world: Arc<str>) {
        self.world.push(time, world);
    }

    /// Something has happened, as JSON; its level is that of a line of the log, 1 debug to 5 fatal.
    pub fn event(&mut self, time: f64, level: u8, json: Arc<str>) {
        let track = match level >= LEVEL_OF_MARKS {
            true => &mut self.marks,
            false => &mut self.lines,
        };
        track.insert(time, TimedEvent { level, json });
    }

    /// Nothing comes any more.
    pub fn complete(&mut self) {
        self.whole = true;
    }

    /// True once nothing comes any more.
    pub const fn is_whole(&self) -> bool {
        self.whole
    }

    /// First and last time, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        let (first, last) = self.frames.span()?;
        let still = self.still.as_ref().map_or(last, |(at, _)| *at);
        Some((first, last.max(still)))
    }

    /// Frames from `from` to `to`, one behind the other, at most `most` and never more than [`POINTS_MAX`].
    pub fn frames(&self, from: f64, to: f64, most: usize) -> Vec<u8> {
        let most = most.clamp(1, POINTS_MAX);
        let mut bytes = Vec::new();
        for (_, frame) in self.frames.between(from, to, most) {
            bytes.extend_from_slice(frame);
        }
        bytes
    }

    /// The frame of a moment: the latest at or before it.
    pub fn frame_at(&self, time: f64) -> Option<&[u8]> {
        match &self.still {
            Some((at, still)) if *at <= time => Some(still),
            _ => self.frames.at(time).map(|(_, frame)| &**frame),
        }
    }

    /// What was there at a moment, beside the frame.
    pub fn beside(&self, time: f64) -> Value {
        let text = |track: &BoundedSeries<Arc<str>>| {
            let text = track.by(time).map(|text| serde_json::from_str(text));
            text.and_then(Result::ok).unwrap_or(Value::Null)
        };
        json!({
            "time": time,
            "panel": text(&self.panels),
            "registers": text(&self.registers),
            "world": text(&self.world),
        })
    }

    /// Events, oldest first, as a JSON array.
    pub fn events(&self, wanted: EventQuery) -> String {
        let most = wanted.most.min(EVENTS_GIVEN_MAX);
        let of = |track: &BoundedSeries<TimedEvent>| -> Vec<(f64, Arc<str>)> {
            let all = track.between(wanted.from, wanted.to, usize::MAX);
            let all = all.filter(|(_, event)| event.level >= wanted.level);
            let all = all.map(|(time, event)| (*time, event.json.clone()));
            all.collect()
        };
        let mut all = of(&self.marks);
        if wanted.level < LEVEL_OF_MARKS {
            all.extend(of(&self.lines));
        }
        // Stable: events of one moment stay in their order.
        all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let given = match wanted.first {
            true => &all[..most.min(all.len())],
            false => &all[all.len().saturating_sub(most)..],
        };
        // Each is JSON already.
        let texts: Vec<&str> = given.iter().map(|(_, json)| &**json).collect();
        format!("[{}]", texts.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{FrameContext, encode, time_of};
    use kinematics::JointPositions;
    use motion_api::RobotState;

    fn frame(time: f64, q: f64) -> [u8; FRAME_BYTES] {
        let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
        state.time = time;
        state.actual_q[0] = q;
        encode(&state, &FrameContext::default())
    }

    #[test]
    fn an_arm_that_stands_costs_little_and_begins_to_move_when_it_did() {
        let mut history = History::default();
        let mut put = |n: u32, q: f64| {
            let time = f64::from(n) / 10.0;
            history.frame(time, &frame(time, q));
        };
        (0..=55).for_each(|n| put(n, 0.0));
        put(56, 0.1);
        assert_eq!(history.span(), Some((0.0, 5.6)));
        let frames = history.frames(0.0, 100.0, 1000);
        let times: Vec<f64> = frames.chunks(FRAME_BYTES).map(time_of).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.5, 5.6]);
        assert_eq!(time_of(history.frame_at(4.9).unwrap()), 4.0);
    }

    #[test]
    fn an_event_that_comes_late_takes_nothing_away() {
        let mut history = History::default();
        for (time, name) in [
            (2.0, "run"),
            (4.136, "alarm"),
            (4.14, "stop"),
            (4.132, "log"),
        ] {
            history.event(time, 4, format!(r#"{{"event":"{name}"}}"#).into());
        }
        let events = |history: &History| {
            let wanted = EventQuery {
                from: 0.0,
                to: 9.0,
                level: 0,
                most: 9,
                first: false,
            };
            history.events(wanted)
        };
        let all = ["run", "log", "alarm", "stop"].map(|name| format!(r#"{{"event":"{name}"}}"#));
        assert_eq!(events(&history), format!("[{}]", all.join(",")));
        // A controller that was started again.
        history.event(0.5, 4, r#"{"event":"run"}"#.into());
        assert_eq!(events(&history), r#"[{"event":"run"}]"#);
    }

    #[test]
    fn the_latest_is_seen_though_it_is_not_kept() {
        let mut history = History::default();
        history.frame(0.0, &frame(0.0, 0.0));
        history.frame(0.5, &frame(0.5, 0.0));
        assert_eq!(history.span(), Some((0.0, 0.5)));
        assert_eq!(time_of(history.frame_at(0.7).unwrap()), 0.5);
        assert_eq!(time_of(history.frame_at(0.3).unwrap()), 0.0);
    }

    #[test]
    fn panel_registers_and_events_are_those_of_the_moment() {
        let mut history = History::default();
        assert_eq!(
            history.beside(1.0),
            json!({"time": 1.0, "panel": null, "registers": null, "world": null})
        );
        history.panel(1.0, r#"{"line":4}"#.into());
        history.panel(2.0, r#"{"line":5}"#.into());
        history.registers(0.5, r#"{"in":[1]}"#.into());
        history.world(1.0, r#"{"counts":[1]}"#.into());
        history.world(3.0, r#"{"counts":[2]}"#.into());
        history.event(1.5, 2, r#"{"event":"log"}"#.into());
        history.event(2.5, 5, r#"{"event":"alarm"}"#.into());
        assert_eq!(history.beside(1.9)["panel"]["line"], 4);
        assert_eq!(history.beside(1.9)["registers"]["in"][0], 1);
        assert_eq!(history.beside(1.9)["world"]["counts"][0], 1);
        assert_eq!(history.beside(9.0)["world"]["counts"][0], 2);
        let events = |from, to, level, most, first| {
            history.events(EventQuery {
                from,
                to,
                level,
                most,
                first,
            })
        };
        let (log, alarm) = (r#"{"event":"log"}"#, r#"{"event":"alarm"}"#);
        assert_eq!(events(0.0, 9.0, 0, 9, false), format!("[{log},{alarm}]"));
        assert_eq!(events(0.0, 9.0, 0, 1, true), format!("[{log}]"));
        assert_eq!(events(0.0, 9.0, 0, 1, false), format!("[{alarm}]"));
        assert_eq!(events(0.0, 9.0, 3, 9, true), format!("[{alarm}]"));
        assert_eq!(events(2.0, 9.0, 0, 9, false), format!("[{alarm}]"));
        assert_eq!(events(5.0, 1.0, 0, 9, false), "[]");
    }

    #[test]
    fn an_alarm_is_not_lost_among_lines() {
        let mut history = History::default();
        history.event(1.0, 5, "1".into());
        for n in 0..3 * EVENTS_MAX {
            history.event(2.0 + n as f64, 2, "2".into());
        }
        let marks = EventQuery {
            from: 0.0,
            to: 1e9,
            level: LEVEL_OF_MARKS,
            most: 10,
            first: true,
        };
        assert_eq!(history.events(marks), "[1]");
    }
}
