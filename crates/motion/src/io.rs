//! Inputs and outputs of one cycle: changes applied, run-state outputs, timed inputs and wires.
//!
//! Owns the image, the delay lines and the rules of outputs without a program and of inputs with an action. All memory
//! is there before the first cycle. Registers are shared with the script side: read once, when a cycle begins, so that
//! a recording can tell what the cycle saw, and written in place.

use std::sync::Arc;

use motion_api::{
    InputAction, IoChange, IoImage, IoPoint, PointLevels, PointSet, RegisterCache, RegisterImages,
    Registers, RunStateChoice, io::DIGITAL_POINTS,
};

/// An output connected to an input: a pure delay, a pulse keeps its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireSetup {
    /// An output.
    pub from: IoPoint,
    /// An input.
    pub to: IoPoint,
    /// s.
    pub delay: f64,
}

/// An input that changes by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedInput {
    /// Simulated time, s.
    pub at: f64,
    /// An input.
    pub to: IoPoint,
    /// Level (0 is low), A, V, or a register's value.
    pub value: f64,
}

/// What stands around the inputs and outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IoSetup {
    /// Wires, driven in this order.
    pub wires: Vec<WireSetup>,
    /// Timed inputs, in any order; of two at the same time the later in the list wins.
    pub inputs: Vec<TimedInput>,
}

/// The inputs and outputs of one controller.
pub(crate) struct IoSystem {
    pub(crate) image: IoImage,
    registers: Arc<Registers>,
    view: RegisterCache,
    /// What the registers held when this cycle began; older than the view's images where these changed since.
    sampled: RegisterImages,
    is_sample_outdated: bool,
    /// The frames show what the view's images hold.
    is_frame_current: bool,
    digital_out: [RunStateChoice; DIGITAL_POINTS as usize],
    analog_out: [RunStateChoice; 3],
    boolean_registers: [RunStateChoice; 128],
    /// Some output has been made to follow the run state.
    has_run_state_outputs: bool,
    freedrive_inputs: u32,
    freedrive_registers: [u64; 2],
    /// Freedrive is on because of such an input.
    pub(crate) is_freedrive_by_input: bool,
    program_running: bool,
    /// Inputs that keep their value, and those that are false or 0, whoever drives them.
    stuck: PointSet,
    open: PointSet,
    wires: Box<[DelayLine]>,
    timed: Box<[TimedInput]>,
    timed_done: usize,
}

struct DelayLine {
    from: IoPoint,
    to: IoPoint,
    /// What was sampled, oldest at `next`; empty without delay.
    line: Box<[f64]>,
    next: usize,
}

impl IoSystem {
    /// `step`: length of a cycle, s.
    pub(crate) fn new(setup: &IoSetup, step: f64, registers: Arc<Registers>) -> Self {
        let wire = |wire: &WireSetup| DelayLine {
            from: wire.from,
            to: wire.to,
            line: vec![0.0; (wire.delay / step).round().max(0.0) as usize].into(),
            next: 0,
        };
        let mut timed = setup.inputs.clone();
        // Stable: of equal times the later in the list wins.
        timed.sort_by(|a, b| a.at.total_cmp(&b.at));
        Self {
            image: IoImage::default(),
            registers,
            view: RegisterCache::default(),
            sampled: RegisterImages::default(),
            is_sample_outdated: false,
            is_frame_current: false,
            has_run_state_outputs: false,
            digital_out: [RunStateChoice::Keep; DIGITAL_POINTS as usize],
            analog_out: [RunStateChoice::Keep; 3],
            boolean_registers: [RunStateChoice::Keep; 128],
            freedrive_inputs: 0,
            freedrive_registers: [0; 2],
            is_freedrive_by_input: false,
            program_running: false,
            stuck: PointSet::default(),
            open: PointSet::default(),
            wires: setup.wires.iter().map(wire).collect(),
            timed: timed.into(),
            timed_done: 0,
        }
    }

    /// Reads the registers for this cycle.
    pub(crate) fn sample_registers(&mut self) -> &RegisterImages {
        self.refresh_registers();
        if self.is_sample_outdated {
            self.sampled = *self.view.images();
            self.is_sample_outdated = false;
        }
        &self.sampled
    }

    /// Puts the registers as they are now where those lie that it was shown last.
    pub(crate) fn copy_registers_into(&mut self, shown: &mut RegisterImages) {
        self.refresh_registers();
        if !self.is_frame_current {
            *shown = *self.view.images();
            self.is_frame_current = true;
        }
    }

    fn refresh_registers(&mut self) {
        if self.view.refresh(&self.registers) {
            self.is_sample_outdated = true;
            self.is_frame_current = false;
        }
    }

    /// Inputs with a fault, from now on.
    pub(crate) fn set_impaired_inputs(&mut self, stuck: &PointSet, open: &PointSet) {
        (self.stuck, self.open) = (*stuck, *open);
        if self.open.digital != 0 {
            let (mask, levels) = (self.open.digital, 0);
            self.image.apply(&IoChange::DigitalIn { mask, levels });
        }
        for port in 0..self.image.analog_in.len() as u8 {
            if self.open.contains(IoPoint::Analog(port)) {
                self.image.apply(&IoChange::AnalogIn { port, value: 0.0 });
            }
        }
        for index in 0..128 {
            if self.open.contains(IoPoint::BooleanRegister(index)) {
                self.registers.input.set_boolean(index, false);
            }
        }
    }

    /// Puts levels on the inputs that the world drives.
    pub(crate) fn set_driven_inputs(&mut self, levels: &PointLevels, driven: &PointSet) {
        let (mask, levels_digital) = (driven.digital, levels.digital);
        self.apply(&IoChange::DigitalIn {
            mask,
            levels: levels_digital,
        });
        for port in 0..self.image.analog_in.len() as u8 {
            let point = IoPoint::Analog(port);
            if driven.contains(point) {
                let largest = self.image.config.analog_in[usize::from(port)].measurable_max();
                self.set_input(point, levels.ratio(point) * largest);
            }
        }
        if driven.booleans == [0; 2] {
            return;
        }
        for index in 0..128 {
            let point = IoPoint::BooleanRegister(index);
            if driven.contains(point) {
                self.set_input(point, f64::from(u8::from(levels.level(point))));
            }
        }
    }

    /// All outputs, for the world.
    pub(crate) fn output_levels(&self) -> PointLevels {
        PointLevels {
            digital: self.image.digital_out,
            booleans: self.sampled.output.booleans(),
            analog: self.image.analog_out_ratio,
        }
    }

    /// Whether an input keeps what it has, or nothing, whatever drives it.
    fn is_impaired(&self, input: IoPoint) -> bool {
        self.stuck.contains(input) || self.open.contains(input)
    }

    /// Applies a change.
    pub(crate) fn apply(&mut self, change: &IoChange) {
        let mut change = *change;
        match &mut change {
            IoChange::DigitalIn { mask, .. } => *mask &= !(self.stuck.digital | self.open.digital),
            IoChange::AnalogIn { port, .. } if self.is_impaired(IoPoint::Analog(*port)) => return,
            _ => {}
        }
        let change = &change;
        self.image.apply(change);
        match *change {
            IoChange::DigitalOutRunState { bit, choice } => {
                self.has_run_state_outputs = true;
                if let Some(of_bit) = self.digital_out.get_mut(usize::from(bit)) {
                    *of_bit = choice;
                }
            }
            IoChange::AnalogOutRunState { port, choice } => {
                self.has_run_state_outputs = true;
                if let Some(of_port) = self.analog_out.get_mut(usize::from(port)) {
                    *of_port = choice;
                }
            }
            IoChange::BooleanRegisterRunState { index, choice } => {
                self.has_run_state_outputs = true;
                if let Some(of_index) = self.boolean_registers.get_mut(usize::from(index)) {
                    *of_index = choice;
                }
            }
            IoChange::DigitalInAction { bit, action } if bit < DIGITAL_POINTS => {
                let mask = 1 << bit;
                self.freedrive_inputs = match action {
                    InputAction::Default => self.freedrive_inputs & !mask,
                    InputAction::Freedrive => self.freedrive_inputs | mask,
                };
            }
            IoChange::BooleanRegisterAction { index, action } => {
                if let Some(word) = self.freedrive_registers.get_mut(usize::from(index / 64)) {
                    let mask = 1 << (index % 64);
                    *word = match action {
                        InputAction::Default => *word & !mask,
                        InputAction::Freedrive => *word | mask,
                    };
                }
            }
            IoChange::InputActionsToDefault => {
                self.freedrive_inputs = 0;
                self.freedrive_registers = [0; 2];
            }
            IoChange::ProgramRunning(running) => self.program_running = running,
            IoChange::BooleanRegister { .. }
            | IoChange::FloatRegister { .. }
            | IoChange::IntegerRegister { .. } => self.registers.change(change),
            _ => {}
        }
        self.image.config.freedrive_by_input =
            self.freedrive_inputs != 0 || self.freedrive_registers != [0; 2];
    }

    /// Everything that happens by itself at the simulated time `now`, s: run-state outputs, then timed inputs, then
    /// wires.
    pub(crate) fn advance(&mut self, now: f64) {
        self.force_run_state_outputs();
        // Half a microsecond of slack: times of the cell file are decimal, `now` is a product.
        while let Some(input) = self.timed.get(self.timed_done)
            && input.at <= now + 5e-7
        {
            let TimedInput { to, value, .. } = *input;
            self.set_input(to, value);
            self.timed_done += 1;
        }
        for k in 0..self.wires.len() {
            let sample = self.output_value(self.wires[k].from);
            let wire = &mut self.wires[k];
            let delayed = match wire.line.get_mut(wire.next) {
                None => sample,
                Some(oldest) => {
                    let delayed = *oldest;
                    *oldest = sample;
                    wire.next = (wire.next + 1) % wire.line.len();
                    delayed
                }
            };
            let to = wire.to;
            self.set_input(to, delayed);
        }
    }

    /// True while an input or boolean register with the action "freedrive" is high (manual 5.27).
    pub(crate) fn is_freedrive_requested(&self) -> bool {
        let [low, high] = self.sampled.input.booleans();
        self.image.digital_in & self.freedrive_inputs != 0
            || low & self.freedrive_registers[0] != 0
            || high & self.freedrive_registers[1] != 0
    }

    fn force_run_state_outputs(&mut self) {
        if !self.has_run_state_outputs {
            return;
        }
        let running = self.program_running;
        for bit in 0..DIGITAL_POINTS {
            if let Some(level) = self.digital_out[usize::from(bit)].level(running) {
                let mask = 1 << bit;
                self.image.apply(&IoChange::DigitalOut {
                    mask,
                    levels: if level { mask } else { 0 },
                });
            }
        }
        for port in 0..3_u8 {
            if let Some(level) = self.analog_out[usize::from(port)].level(running) {
                let ratio = f64::from(u8::from(level));
                self.image.apply(&IoChange::AnalogOut { port, ratio });
            }
        }
        for (index, choice) in (0_u8..).zip(&self.boolean_registers) {
            if let Some(level) = choice.level(running) {
                self.registers.output.set_boolean(index, level);
            }
        }
    }

    /// What an output carries.
    fn output_value(&self, output: IoPoint) -> f64 {
        match output {
            IoPoint::Digital(bit) => f64::from(self.image.digital_out >> (bit & 31) & 1),
            IoPoint::Analog(port) => {
                let values = self.image.analog_out();
                values.get(usize::from(port)).copied().unwrap_or(0.0)
            }
            IoPoint::BooleanRegister(n) => f64::from(u8::from(self.sampled.output.boolean(n))),
            IoPoint::IntegerRegister(n) => f64::from(self.sampled.output.integer(n)),
            IoPoint::FloatRegister(n) => self.sampled.output.float(n),
        }
    }

    /// Puts a value on an input.
    fn set_input(&mut self, input: IoPoint, value: f64) {
        if self.is_impaired(input) {
            return;
        }
        let level = value != 0.0;
        match input {
            IoPoint::Digital(bit) => {
                let mask = 1_u32 << (bit & 31);
                self.image.apply(&IoChange::DigitalIn {
                    mask,
                    levels: if level { mask } else { 0 },
                });
            }
            IoPoint::Analog(port) => self.image.apply(&IoChange::AnalogIn { port, value }),
            IoPoint::BooleanRegister(n) => self.registers.input.set_boolean(n, level),
            // Saturates; a wire from a float register may carry anything.
            IoPoint::IntegerRegister(n) => self.registers.input.set_integer(n, value as i32),
            IoPoint::FloatRegister(n) => self.registers.input.set_float(n, value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion_api::DigitalBank;
    use proptest::prelude::*;

    const STEP: f64 = 0.004;

    fn io(setup: &IoSetup) -> IoSystem {
        IoSystem::new(setup, STEP, Arc::default())
    }

    /// One cycle at `now`.
    fn advance(io: &mut IoSystem, now: f64) {
        io.sample_registers();
        io.advance(now);
    }

    fn wire(from: IoPoint, to: IoPoint, delay: f64) -> IoSetup {
        IoSetup {
            wires: vec![WireSetup { from, to, delay }],
            inputs: Vec::new(),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn a_wire_repeats_its_output_after_its_delay(levels in proptest::collection::vec(any::<bool>(), 1..80),
            cycles in 0_usize..30) {
            let mut io = io(&wire(IoPoint::Digital(3), IoPoint::Digital(18), cycles as f64 * STEP));
            let mut seen = Vec::new();
            for (k, level) in levels.iter().enumerate() {
                io.apply(&IoChange::digital_out(DigitalBank::Standard, 3, *level));
                advance(&mut io, k as f64 * STEP);
                seen.push(io.image.digital_in >> 18 & 1 == 1);
            }
            for (k, level) in seen.iter().enumerate() {
                prop_assert_eq!(*level, k >= cycles && levels[k - cycles]);
            }
        }
    }

    #[test]
    fn wires_carry_analog_values_and_registers() {
        let mut setup = wire(IoPoint::Analog(1), IoPoint::Analog(0), 0.0);
        setup.wires.extend([
            WireSetup {
                from: IoPoint::IntegerRegister(47),
                to: IoPoint::FloatRegister(0),
                delay: STEP,
            },
            WireSetup {
                from: IoPoint::BooleanRegister(127),
                to: IoPoint::Digital(0),
                delay: 0.0,
            },
        ]);
        let mut io = io(&setup);
        io.registers.output.set_integer(47, -12);
        io.registers.output.set_boolean(127, true);
        io.apply(&IoChange::AnalogOut {
            port: 1,
            ratio: 0.25,
        });
        advance(&mut io, 0.0);
        assert_eq!(io.image.analog_in[0], 2.5);
        assert_eq!(io.image.digital_in, 1);
        assert_eq!(io.registers.input.float(0), 0.0);
        advance(&mut io, STEP);
        assert_eq!(io.registers.input.float(0), -12.0);
    }

    #[test]
    fn timed_inputs_change_in_the_cycle_of_their_time() {
        let inputs = [(0.02, 1.0), (0.008, 1.0), (0.012, 0.0), (0.02, 0.0)];
        let mut io = io(&IoSetup {
            wires: Vec::new(),
            inputs: inputs
                .map(|(at, value)| TimedInput {
                    at,
                    to: IoPoint::Digital(5),
                    value,
                })
                .into(),
        });
        let levels: Vec<bool> = (1..=6)
            .map(|cycle| {
                advance(&mut io, f64::from(cycle) * STEP);
                io.image.digital_in == 1 << 5
            })
            .collect();
        assert_eq!(levels, [false, true, false, false, false, false]);
    }

    #[test]
    fn run_state_outputs_follow_their_choice() {
        use RunStateChoice::{FollowsRunning, HighWhenNotRunning, Keep, LowWhenNotRunning};
        let choices = [Keep, LowWhenNotRunning, HighWhenNotRunning, FollowsRunning];
        let mut io = io(&IoSetup::default());
        let set_all = |io: &mut IoSystem, level: bool| {
            for n in 0..4 {
                io.apply(&IoChange::digital_out(DigitalBank::Configurable, n, level));
                io.registers.output.set_boolean(n, level);
            }
        };
        for (n, choice) in (0..).zip(choices) {
            let bit = DigitalBank::Configurable.bit(n);
            io.apply(&IoChange::DigitalOutRunState { bit, choice });
            io.apply(&IoChange::BooleanRegisterRunState { index: n, choice });
        }
        let levels = |io: &mut IoSystem, running| {
            io.apply(&IoChange::ProgramRunning(running));
            advance(io, 0.0);
            let digital = io.image.digital_out >> 16 & 0xF;
            assert_eq!(io.registers.output.booleans()[0] as u32 & 0xF, digital);
            digital
        };
        set_all(&mut io, true);
        assert_eq!(levels(&mut io, false), 0b0101);
        set_all(&mut io, false);
        assert_eq!(levels(&mut io, true), 0b1000);
        set_all(&mut io, true);
        assert_eq!(levels(&mut io, true), 0b1111);
        assert_eq!(levels(&mut io, false), 0b0101);

        let choice = HighWhenNotRunning;
        io.apply(&IoChange::AnalogOutRunState { port: 2, choice });
        advance(&mut io, 0.0);
        assert_eq!(io.image.analog_out()[2], 10.0);
    }

    #[test]
    fn inputs_with_the_action_freedrive_ask_for_it_while_they_are_high() {
        let mut io = io(&IoSetup::default());
        let action = InputAction::Freedrive;
        io.apply(&IoChange::DigitalInAction { bit: 2, action });
        io.apply(&IoChange::BooleanRegisterAction { index: 100, action });
        assert!(!io.is_freedrive_requested() && io.image.config.freedrive_by_input);
        io.apply(&IoChange::digital_in(DigitalBank::Standard, 2, true));
        assert!(io.is_freedrive_requested());
        io.apply(&IoChange::digital_in(DigitalBank::Standard, 2, false));
        assert!(!io.is_freedrive_requested());
        io.registers.input.set_boolean(100, true);
        advance(&mut io, 0.0);
        assert!(io.is_freedrive_requested());
        io.apply(&IoChange::InputActionsToDefault);
        assert!(!io.is_freedrive_requested() && !io.image.config.freedrive_by_input);
    }
}
