//! What the controller's own Modbus map shows beside the robot's state: the general purpose words that scripts
//! (`read_port_register` …, manual 6.1.11 to 6.1.14) and Modbus clients share, what the program does, and who has
//! control.
//!
//! Values outlive programs and clients. Shared by reference between threads; a lock is held for a few instructions.

use std::sync::atomic::{AtomicU8, Ordering};

use parking_lot::Mutex;

/// Number of general purpose words.
pub const WORDS: usize = 128;

/// What the main program does. The numbers are those of word 500.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ProgramState {
    /// A program runs.
    Running = 1,
    /// A program is paused.
    Paused = 2,
    /// No program runs.
    Stopped = 3,
}

/// Who controls the robot. The numbers are those of word 71.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum ControlMode {
    /// Remote control is switched off in the settings, as it leaves the factory: the pendant controls, programs are
    /// taken from port 30001 all the same.
    Mixed = 0,
    /// The pendant alone.
    Local = 1,
    /// The network.
    #[default]
    Remote = 2,
}

impl ControlMode {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mixed => "mixed",
            Self::Local => "local",
            Self::Remote => "remote",
        }
    }

    const fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Mixed,
            1 => Self::Local,
            _ => Self::Remote,
        }
    }
}

/// The words, all zero at first; no program runs, and the network controls.
#[derive(Debug)]
pub struct PortImage {
    words: Mutex<[u16; WORDS]>,
    program: AtomicU8,
    control: AtomicU8,
}

impl Default for PortImage {
    fn default() -> Self {
        Self {
            words: Mutex::new([0; WORDS]),
            program: AtomicU8::new(ProgramState::Stopped as u8),
            control: AtomicU8::new(ControlMode::default() as u8),
        }
    }
}

impl PortImage {
    /// All words at one moment.
    pub fn words(&self) -> [u16; WORDS] {
        *self.words.lock()
    }

    /// Changes words in one step; nobody sees half of it.
    pub fn with_words<T>(&self, change: impl FnOnce(&mut [u16; WORDS]) -> T) -> T {
        change(&mut self.words.lock())
    }

    /// What the main program does.
    pub fn program(&self) -> ProgramState {
        match self.program.load(Ordering::Relaxed) {
            1 => ProgramState::Running,
            2 => ProgramState::Paused,
            _ => ProgramState::Stopped,
        }
    }

    /// The main program does something else from now on.
    pub fn set_program(&self, state: ProgramState) {
        self.program.store(state as u8, Ordering::Relaxed);
    }

    /// Who has control.
    pub fn control(&self) -> ControlMode {
        ControlMode::from_number(self.control.load(Ordering::Relaxed))
    }

    /// Gives control to somebody.
    pub fn set_control(&self, mode: ControlMode) {
        self.control.store(mode as u8, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_shown() {
        let image = PortImage::default();
        image.with_words(|words| words[127] = 7);
        assert_eq!((image.words()[127], image.words()[0]), (7, 0));
        for state in [
            ProgramState::Running,
            ProgramState::Paused,
            ProgramState::Stopped,
        ] {
            image.set_program(state);
            assert_eq!(image.program(), state);
        }
        for mode in [ControlMode::Mixed, ControlMode::Local, ControlMode::Remote] {
            image.set_control(mode);
            assert_eq!(image.control(), mode);
        }
    }
}
