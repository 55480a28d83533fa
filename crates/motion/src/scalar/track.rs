//! How fast one may be at each place of a way: cells with limits of their own, and what their neighbours leave of them.
//!
//! The way is known to its present end and may be lengthened while somebody is on it; until then it ends at rest. A
//! cell's speed is lowered to what can still be braked from (backward pass over the squares of the speeds, which change
//! evenly with the place at constant acceleration; Bobrow, Dubowsky and Gibson 1985). The motion along the way is
//! smoothed in time afterwards ([`PathProgress`](super::PathProgress)): for half of that time before and behind a cell
//! nobody may be faster than the cell allows, so that the mean keeps its limits too.

use super::{IntervalLimits, Pace};
use crate::constants::{HARD_STOP_SHARE, PAUSE_SHARE};

/// A cell that is passed within so many windows counts as short.
const SHORT_CELL: f64 = 2.0;
/// Range of gentle steps: the squared speed limit of the next cell over that of this one. Above it a step is not felt.
const GENTLE_STEP: (f64, f64) = (0.6, 0.98);

/// A piece of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitInterval {
    /// Where the piece ends.
    pub until: f64,
    /// What is asked for and possible on the piece.
    pub limits: IntervalLimits,
    /// How much slower the piece is gone along than it could be, when a longer duration is wanted.
    pub speed_scale: Pace,
    /// The largest speed on the piece, whatever was planned.
    pub cap: f64,
    /// What the neighbours leave of the limits, and of the caps.
    windowed_limits: IntervalLimits,
    windowed_cap: f64,
    squared_limit: SquaredSpeedLimit,
    /// What the squares would be without caps: whoever is still too fast for those keeps to these.
    uncapped_squared_limit: SquaredSpeedLimit,
}

/// How fast one may be in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct SquaredSpeedLimit {
    /// Square of the speed at the end of the cell, how fast it may fall towards there along the way, and the most it
    /// may be.
    end_squared: f64,
    slope: f64,
    max_squared: f64,
}

/// The cells in order, and where they begin.
#[derive(Clone, Debug)]
pub struct VelocityLimitCurve {
    begin: f64,
    cells: Vec<LimitInterval>,
    /// Time over which the motion is smoothed, s.
    window: f64,
    /// What is so while it is not known what comes behind the end.
    blend_entry_limit: Zone,
    /// What stood from a place on, for [`undo_truncate`](Self::undo_truncate), and the zone.
    undo_state: (usize, Vec<LimitInterval>),
    saved_zone: Zone,
}

/// Least cap of a cell.
const SLOWEST_CAP: f64 = 1e-6;

/// The end of a way while it is not known what comes behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Where the motion may begin to slow down `times` as hard as asked.
    pub hard_from: f64,
    /// How many times as hard as asked the motion may slow down from `hard_from` on.
    pub times: f64,
    /// Where `speed` begins to be the most.
    pub slow_from: f64,
    /// The largest speed from `slow_from` on.
    pub speed: f64,
}

impl Zone {
    /// Nothing is so.
    pub const NONE: Self = Self {
        hard_from: f64::INFINITY,
        times: 1.0,
        slow_from: f64::INFINITY,
        speed: f64::INFINITY,
    };
}

impl VelocityLimitCurve {
    /// A way of no length; room for `room` cells, more are never taken.
    pub fn new(room: usize) -> Self {
        Self {
            begin: 0.0,
            cells: Vec::with_capacity(room),
            window: 0.0,
            blend_entry_limit: Zone::NONE,
            undo_state: (0, Vec::with_capacity(room)),
            saved_zone: Zone::NONE,
        }
    }

    /// Begins anew at 0 for motions smoothed over `window` seconds.
    pub fn restart(&mut self, window: f64) {
        self.begin = 0.0;
        self.cells.clear();
        self.window = window;
        self.blend_entry_limit = Zone::NONE;
    }

    /// Places for further cells.
    pub fn room(&self) -> usize {
        self.cells.capacity() - self.cells.len()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// Time over which the motion is smoothed, s.
    pub fn window(&self) -> f64 {
        self.window
    }

    /// Where the way ends.
    pub fn end(&self) -> f64 {
        self.cells.last().map_or(self.begin, |cell| cell.until)
    }

    /// Adds a cell; `None` when there is no room or it cannot be used. One of no length is left out.
    pub fn push(&mut self, until: f64, limits: IntervalLimits) -> Option<()> {
        if until <= self.end() + 1e-12 * (1.0 + until.abs()) {
            return Some(());
        }
        if self.room() == 0 || !limits.are_usable() || !until.is_finite() {
            return None;
        }
        self.cells.push(LimitInterval {
            until,
            limits,
            speed_scale: Pace::FULL,
            cap: f64::INFINITY,
            windowed_limits: limits,
            windowed_cap: f64::INFINITY,
            squared_limit: SquaredSpeedLimit::default(),
            uncapped_squared_limit: SquaredSpeedLimit::default(),
        });
        Some(())
    }

    /// Ends the way at `place`. What stands behind `from`, which is before that, can be [restored](Self::undo_truncate)
    /// until the next cut.
    pub fn truncate(&mut self, from: f64, place: f64) {
        self.saved_zone = self.blend_entry_limit;
        self.blend_entry_limit = Zone::NONE;
        let kept = self
            .cells
            .partition_point(|cell| cell.until < from.min(place));
        self.undo_state.0 = kept;
        self.undo_state.1.clear();
        self.undo_state
            .1
            .extend_from_slice(self.cells.get(kept..).unwrap_or_default());
        let kept = self.cells.partition_point(|cell| cell.until < place);
        self.cells.truncate(kept + 1);
        if let Some(last) = self.cells.last_mut() {
            last.until = last.until.min(place);
        }
    }

    /// Lets the motion slow down so many times harder in the cells between two places, as far as that is possible.
    pub fn scale_braking(&mut self, from: f64, to: f64, times: f64) {
        let mut begin = from;
        for cell in self.cells.iter_mut().filter(|cell| cell.until > from) {
            if begin >= to {
                break;
            }
            begin = cell.until;
            cell.limits.brake_harder(times);
            cell.speed_scale.acceleration *= times;
        }
    }

    /// Takes the last cut back, and what was added since.
    pub fn undo_truncate(&mut self) {
        self.cells.truncate(self.undo_state.0);
        self.cells.extend_from_slice(&self.undo_state.1);
        self.blend_entry_limit = self.saved_zone;
    }

    /// Cells that end before `place` are forgotten.
    pub fn forget_before(&mut self, place: f64) {
        let gone = self.cells.iter().take_while(|cell| cell.until < place);
        let gone = gone.count().min(self.cells.len().saturating_sub(1));
        if gone > 0 {
            self.begin = self
                .cells
                .get(gone - 1)
                .map_or(self.begin, |cell| cell.until);
            self.cells.drain(..gone);
        }
    }

    /// What is so until the way is cut.
    pub fn set_zone(&mut self, zone: Zone) {
        self.blend_entry_limit = zone;
    }

    /// Sets the pace of the cells from `place` on.
    pub fn set_pace(&mut self, place: f64, pace: Pace) {
        let from = self.cells.partition_point(|cell| cell.until <= place);
        self.cells
            .iter_mut()
            .skip(from)
            .for_each(|cell| cell.speed_scale = pace);
    }

    /// What the way bears behind a place at its pace, whatever neighbours leave of that.
    pub fn bears(&self, place: f64) -> IntervalLimits {
        let cell = self.cells.get(self.index(place));
        cell.map_or(IntervalLimits::NONE, |cell| {
            cell.limits.scaled(&cell.speed_scale, self.window)
        })
    }

    /// Where the cell at a place begins.
    pub fn begin_of(&self, place: f64) -> f64 {
        let k = self.index(place);
        self.cells
            .get(k)
            .map_or(place, |cell| cell.until - self.length(k))
    }

    /// The largest speed of any cell behind `place`.
    pub fn fastest(&self, place: f64) -> f64 {
        let first = self.cells.partition_point(|cell| cell.until <= place);
        let ahead = self.cells.iter().skip(first);
        ahead.fold(0.0, |most, cell| most.max(cell.limits.speed))
    }

    /// The least time that the way from `place` to the end takes, s.
    pub fn least_time(&self, place: f64) -> f64 {
        let mut begin = place;
        let first = self.cells.partition_point(|cell| cell.until <= place);
        let ahead = self.cells.iter().skip(first);
        ahead.fold(0.0, |time, cell| {
            let way = cell.until - begin;
            begin = cell.until;
            time + way / cell.limits.speed
        })
    }

    /// From where on the speed only falls, because the way ends, or to what is allowed while it is not known what comes
    /// behind.
    pub fn falls_from(&self) -> f64 {
        let mut place = self.end();
        let slow = if self.blend_entry_limit.slow_from < place {
            self.blend_entry_limit.speed * self.blend_entry_limit.speed * (1.0 + 1e-9)
        } else {
            0.0
        };
        for k in (0..self.cells.len()).rev() {
            let (length, cell) = (self.length(k), self.cells.get(k));
            let Some(LimitInterval {
                until,
                squared_limit: speeds,
                ..
            }) = cell
            else {
                break;
            };
            if speeds.max_squared > slow
                && speeds.end_squared + speeds.slope * length > speeds.max_squared
            {
                // Even before that.
                return place.min(
                    until - (speeds.max_squared - speeds.end_squared).max(0.0) / speeds.slope,
                );
            }
            place = until - length;
        }
        place
    }

    /// The first cell that ends behind `place`, and where it ends.
    pub fn cell_after(&self, place: f64) -> Option<(usize, f64)> {
        let cell = self.cells.partition_point(|cell| cell.until <= place);
        self.cells.get(cell).map(|found| (cell, found.until))
    }

    /// What is asked for and possible in that cell.
    pub fn limits(&self, cell: usize) -> IntervalLimits {
        self.cells
            .get(cell)
            .map_or(IntervalLimits::NONE, |cell| cell.limits)
    }

    /// Nobody may be faster than `cap` in that cell, until the caps are forgotten.
    pub fn set_cap(&mut self, cell: usize, cap: f64) {
        if let Some(cell) = self.cells.get_mut(cell) {
            cell.cap = cap.max(SLOWEST_CAP);
        }
    }

    /// Cells bear again what they were planned with.
    pub fn clear_caps(&mut self) {
        for cell in &mut self.cells {
            cell.cap = f64::INFINITY;
        }
    }

    /// Works out the speeds after cells were added, cut or paced.
    pub fn recompute(&mut self) {
        for k in 0..self.cells.len() {
            let own = self.interval_limits(k);
            if let Some(cell) = self.cells.get_mut(k) {
                cell.windowed_limits = own;
                cell.windowed_cap = cell.cap;
            }
        }
        self.apply_window_minimum();
        let window = self.window;
        let (mut behind, mut behind_planned) = (BackwardPass::default(), BackwardPass::default());
        for k in (0..self.cells.len()).rev() {
            let length = self.length(k);
            let Some(cell) = self.cells.get_mut(k) else {
                return;
            };
            let most = cell.windowed_limits.speed * cell.windowed_limits.speed;
            let capped = most.min(cell.windowed_cap * cell.windowed_cap);
            cell.uncapped_squared_limit =
                behind_planned.step_back(&cell.windowed_limits, most, length, window);
            cell.squared_limit = behind.step_back(&cell.windowed_limits, capped, length, window);
        }
    }

    /// What a cell bears by itself, without its cap: that is no reason to accelerate less in it.
    fn interval_limits(&self, k: usize) -> IntervalLimits {
        let Some(cell) = self.cells.get(k) else {
            return IntervalLimits::NONE;
        };
        let mut own = cell.limits.scaled(&cell.speed_scale, self.window);
        let is_behind = |place: f64| cell.until > place + 1e-12 * (1.0 + cell.until.abs());
        if is_behind(self.blend_entry_limit.hard_from) {
            own.brake_harder(self.blend_entry_limit.times);
        }
        if cell.until - self.length(k) >= self.blend_entry_limit.slow_from {
            own = own.up_to(self.blend_entry_limit.speed);
        }
        own
    }

    fn length(&self, k: usize) -> f64 {
        let begin = match k.checked_sub(1) {
            Some(before) => self.cells.get(before).map_or(self.begin, |cell| cell.until),
            None => self.begin,
        };
        self.cells.get(k).map_or(0.0, |cell| cell.until - begin)
    }

    /// Lowers every cell to what others allow for half of the window before and behind them.
    fn apply_window_minimum(&mut self) {
        for k in 0..self.cells.len() {
            let own = self.interval_limits(k);
            let cap = self.cells.get(k).map_or(f64::INFINITY, |cell| cell.cap);
            // Whoever still slows down for a cap passes as fast as was planned.
            let reach = 0.5 * own.speed * self.window;
            let begin = self.cells.get(k).map_or(0.0, |cell| cell.until) - self.length(k);
            let end = begin + self.length(k);
            for cell in self.cells.get_mut(..k).unwrap_or_default().iter_mut().rev() {
                if cell.until <= begin - reach {
                    break;
                }
                cell.restrict_to(&own, cap);
            }
            let mut from = end;
            for cell in self.cells.get_mut(k + 1..).unwrap_or_default() {
                if from >= end + reach {
                    break;
                }
                cell.restrict_to(&own, cap);
                from = cell.until;
            }
        }
    }

    /// The cell at a place; the last one behind the end.
    pub fn index(&self, place: f64) -> usize {
        let k = self.cells.partition_point(|cell| cell.until <= place);
        k.min(self.cells.len().saturating_sub(1))
    }

    /// The index of the cell at a place that is not before the cell `from`; quick when the place is near behind it.
    pub fn index_from(&self, from: usize, place: f64) -> usize {
        let ahead = self.cells.get(from..).unwrap_or_default();
        let passed = ahead.iter().take_while(|cell| cell.until <= place).count();
        (from + passed).min(self.cells.len().saturating_sub(1))
    }

    /// Square of the speed allowed at a place.
    pub fn squared_limit(&self, place: f64) -> f64 {
        self.squared_limit_in(self.index(place), place)
    }

    /// Square of the speed allowed at a place in a cell that is known.
    pub fn squared_limit_in(&self, cell: usize, place: f64) -> f64 {
        let cell = self.cells.get(cell);
        cell.map_or(0.0, |cell| cell.square(place))
    }

    /// Square of the speed that would be allowed at a place without caps.
    pub fn uncapped_squared_limit_at(&self, place: f64) -> f64 {
        let cell = self.cells.get(self.index(place));
        cell.map_or(0.0, |cell| {
            cell.uncapped_squared_limit.square(cell.until - place)
        })
    }

    /// The least square of the speed allowed from a place, whose cell is known, to another place.
    pub fn min_squared_limit(&self, (first, from): (usize, f64), to: f64) -> f64 {
        if to >= self.end() {
            return 0.0;
        }
        let last = self.index_from(first, to);
        let mut least = self
            .squared_limit_in(first, from)
            .min(self.squared_limit_in(last, to));
        for cell in self.cells.get(first..last).unwrap_or_default() {
            least = least.min(cell.squared_limit.end_squared);
        }
        least
    }

    /// Acceleration asked for when speeding up, in a cell and at a speed.
    pub fn acceleration_at(&self, cell: usize, speed: f64) -> f64 {
        self.cells.get(cell).map_or(1.0, |cell| {
            cell.windowed_limits
                .acceleration_at(cell.windowed_limits.asked, speed * speed)
        })
    }

    /// Acceleration with which a pause and the slider slow down, the hardest one, and the jerk, at a place and a speed.
    /// The first is what is asked for when slowing down, and no less than [`PAUSE_SHARE`] of what the joints can do.
    pub fn braking_at(&self, place: f64, speed: f64) -> (f64, f64, f64) {
        let Some(cell) = self.cells.get(self.index(place)) else {
            return (1.0, 1.0, 1.0);
        };
        let limits = &cell.windowed_limits;
        let square = speed * speed;
        let asked = limits.acceleration_at(limits.braking, square);
        let hardest = limits
            .acceleration_at(limits.max_braking, square)
            .max(asked);
        let [without_bends, _] = limits.max_braking;
        let least = (PAUSE_SHARE / HARD_STOP_SHARE * without_bends).min(hardest);
        (asked.max(least), hardest, limits.jerk)
    }

    /// The speed after `time` when one goes at `speed` at `place` and follows the squares of the speeds down; the
    /// place.
    pub fn follow_limit(&self, place: f64, speed: f64, time: f64) -> (f64, f64) {
        self.follow(place, speed, time, |cell| &cell.squared_limit)
    }

    /// Follows the squares of the speeds without caps for `time`, s: place and speed then.
    pub fn follow_uncapped_limit(&self, place: f64, speed: f64, time: f64) -> (f64, f64) {
        self.follow(place, speed, time, |cell| &cell.uncapped_squared_limit)
    }

    fn follow(
        &self,
        place: f64,
        speed: f64,
        time: f64,
        speeds: impl Fn(&LimitInterval) -> &SquaredSpeedLimit,
    ) -> (f64, f64) {
        let mut k = self.index(place);
        loop {
            let Some(cell) = self.cells.get(k) else {
                return (self.end(), 0.0);
            };
            let speeds = speeds(cell);
            // w² = square here - fall (next place - place), next place - place = (speed + w) time / 2.
            let here = speeds.end_squared + speeds.slope * (cell.until - place);
            let quarter = speeds.slope * time / 4.0;
            let under = quarter * quarter + here - 2.0 * quarter * speed;
            let next = if under >= 0.0 {
                (under.sqrt() - quarter).min(speeds.max_squared.sqrt())
            } else {
                -1.0
            };
            let reached = place + 0.5 * (speed + next.max(0.0)) * time;
            let is_last = k + 1 >= self.cells.len();
            if is_last && (next <= 0.0 || reached >= cell.until) {
                return (cell.until, 0.0);
            }
            if reached <= cell.until && next >= 0.0 || is_last {
                return (reached, next.max(0.0));
            }
            k += 1;
        }
    }

    /// How far the allowed speed stays what it is at a place.
    pub fn constant_until(&self, place: f64, speed: f64) -> f64 {
        let square = speed * speed * (1.0 - 1e-12);
        let mut until = place;
        for cell in self.cells.get(self.index(place)..).unwrap_or_default() {
            // Where more is allowed one speeds up.
            if cell.squared_limit.max_squared < square
                || cell.squared_limit.max_squared > square * (1.0 + 1e-9)
            {
                break;
            }
            if cell.squared_limit.end_squared < square {
                return until.max(
                    cell.until
                        - (square - cell.squared_limit.end_squared) / cell.squared_limit.slope,
                );
            }
            until = cell.until;
        }
        until
    }
}

/// What a cell has to be left with: the squares of the speed at which the next one may be entered, and the most in it.
#[derive(Clone, Copy, Debug, Default)]
struct BackwardPass {
    entry_squared: f64,
    max_squared: f64,
}

impl BackwardPass {
    /// The speeds in the cell before, where the square is `max_squared` at most; that cell is what is behind
    /// afterwards.
    fn step_back(
        &mut self,
        limits: &IntervalLimits,
        most: f64,
        length: f64,
        window: f64,
    ) -> SquaredSpeedLimit {
        let end = self.entry_squared.min(self.max_squared).min(most);
        // With x the square of the speed: x = end + 2 (rest + change x) length, change being 0 or less.
        let [rest, fast] = limits.braking;
        let change = (fast - rest).min(0.0) / (limits.speed * limits.speed);
        let entry = (end + 2.0 * rest * length) / (1.0 - 2.0 * change * length);
        let mut fall = 2.0 * (rest + change * entry.min(most));
        let is_short = length > 0.0 && length < SHORT_CELL * most.sqrt() * window;
        let gentle = GENTLE_STEP.0..GENTLE_STEP.1;
        if is_short
            && self.max_squared <= self.entry_squared
            && gentle.contains(&(self.max_squared / most))
        {
            // Where the next cell bears a little less, evenly down to that: full braking at every step would shake the
            // arm.
            fall = fall.min((most - end) / length);
        }
        self.entry_squared = (end + fall * length).min(most);
        self.max_squared = most;
        SquaredSpeedLimit {
            end_squared: end,
            slope: fall,
            max_squared: most,
        }
    }
}

impl SquaredSpeedLimit {
    /// Square of the speed so far before the end of the cell.
    fn square(&self, before: f64) -> f64 {
        (self.end_squared + self.slope * before.max(0.0)).min(self.max_squared)
    }
}

impl LimitInterval {
    fn restrict_to(&mut self, neighbour: &IntervalLimits, cap: f64) {
        self.windowed_limits.restrict_to(neighbour);
        self.windowed_cap = self.windowed_cap.min(cap);
    }

    fn square(&self, place: f64) -> f64 {
        self.squared_limit.square(self.until - place)
    }
}
