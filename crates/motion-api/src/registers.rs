//! General purpose registers (manual 5.37 to 5.45): memory shared by scripts, ports, field buses and the motion thread.
//!
//! A write is seen by the next read, whoever reads; nobody waits for a cycle and nobody locks. Values outlive programs.
//! Each register is one atomic, so two writers of different registers never undo each other.

use crate::IoChange;
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering};

/// Boolean registers in each direction.
pub const BOOLEAN_REGISTERS: u8 = 128;
/// Integer registers in each direction.
pub const INTEGER_REGISTERS: u8 = 48;
/// Float registers in each direction.
pub const FLOAT_REGISTERS: u8 = 48;

/// All registers of one controller.
#[derive(Debug, Default)]
pub struct Registers {
    /// Written from outside, read by scripts.
    pub input: RegisterBank,
    /// Written by scripts, read from outside.
    pub output: RegisterBank,
}

impl Registers {
    /// Writes an output register; other changes are none of registers.
    pub fn change(&self, change: &IoChange) {
        match *change {
            IoChange::BooleanRegister { index, level } => self.output.set_boolean(index, level),
            IoChange::FloatRegister { index, value } => self.output.set_float(index, value),
            IoChange::IntegerRegister { index, value } => self.output.set_integer(index, value),
            _ => {}
        }
    }
}

/// The registers of one direction. All low and zero at first. Numbers beyond the last are read as zero and not written.
#[derive(Debug)]
pub struct RegisterBank {
    booleans: [AtomicU64; 2],
    integers: [AtomicI32; INTEGER_REGISTERS as usize],
    floats: [AtomicU64; FLOAT_REGISTERS as usize],
    /// Counts the writes, each after it was done: who finds the same count has seen them all.
    writes: AtomicU64,
}

impl Default for RegisterBank {
    fn default() -> Self {
        Self {
            booleans: Default::default(),
            integers: std::array::from_fn(|_| AtomicI32::new(0)),
            floats: std::array::from_fn(|_| AtomicU64::new(0)),
            writes: AtomicU64::new(0),
        }
    }
}

impl RegisterBank {
    /// Boolean register `n`.
    pub fn boolean(&self, n: u8) -> bool {
        let word = self.booleans.get(usize::from(n / 64));
        word.is_some_and(|word| word.load(Ordering::Relaxed) >> (n % 64) & 1 == 1)
    }

    /// Sets boolean register `n`.
    pub fn set_boolean(&self, n: u8, level: bool) {
        let Some(word) = self.booleans.get(usize::from(n / 64)) else {
            return;
        };
        if level {
            word.fetch_or(1 << (n % 64), Ordering::Relaxed);
        } else {
            word.fetch_and(!(1 << (n % 64)), Ordering::Relaxed);
        }
        self.count_write();
    }

    /// Boolean registers 0-63 and 64-127 as bits.
    pub fn booleans(&self) -> [u64; 2] {
        [0, 1].map(|k: usize| self.booleans[k].load(Ordering::Relaxed))
    }

    /// Integer register `n`.
    pub fn integer(&self, n: u8) -> i32 {
        let cell = self.integers.get(usize::from(n));
        cell.map_or(0, |cell| cell.load(Ordering::Relaxed))
    }

    /// Sets integer register `n`.
    pub fn set_integer(&self, n: u8, value: i32) {
        if let Some(cell) = self.integers.get(usize::from(n)) {
            cell.store(value, Ordering::Relaxed);
            self.count_write();
        }
    }

    /// Float register `n`.
    pub fn float(&self, n: u8) -> f64 {
        let cell = self.floats.get(usize::from(n));
        cell.map_or(0.0, |cell| f64::from_bits(cell.load(Ordering::Relaxed)))
    }

    /// Sets float register `n`.
    pub fn set_float(&self, n: u8, value: f64) {
        if let Some(cell) = self.floats.get(usize::from(n)) {
            cell.store(value.to_bits(), Ordering::Relaxed);
            self.count_write();
        }
    }

    fn count_write(&self) {
        self.writes.fetch_add(1, Ordering::Release);
    }
}

/// The registers as somebody saw them last, so that they are read again only where they were written since.
#[derive(Clone, Debug, Default)]
pub struct RegisterCache {
    images: RegisterImages,
    /// The writes that the images hold; none were seen yet before the first look.
    writes: Option<[u64; 2]>,
}

impl RegisterCache {
    /// Looks at the registers as they are now; true when one was written since the last look. One that is written
    /// meanwhile has its old or its new value, and its new one at the next look.
    pub fn refresh(&mut self, registers: &Registers) -> bool {
        // Before the values: a write that comes in between is read again.
        let banks = [&registers.input, &registers.output];
        let writes = banks.map(|bank| bank.writes.load(Ordering::Acquire));
        let [input, output] = self.writes.map_or([true; 2], |seen| {
            [0, 1].map(|k: usize| seen[k] != writes[k])
        });
        if input {
            self.images.input = registers.input.image();
        }
        if output {
            self.images.output = registers.output.image();
        }
        self.writes = Some(writes);
        input || output
    }

    /// What was seen.
    pub const fn images(&self) -> &RegisterImages {
        &self.images
    }
}

/// Both banks at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RegisterImages {
    /// The image of [`Registers::input`].
    pub input: RegisterImage,
    /// The image of [`Registers::output`].
    pub output: RegisterImage,
}

/// One bank at one moment. Equal images are equal bit for bit, also where a float is no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegisterImage {
    booleans: [u64; 2],
    integers: [i32; INTEGER_REGISTERS as usize],
    float_bits: [u64; FLOAT_REGISTERS as usize],
}

impl Default for RegisterImage {
    fn default() -> Self {
        Self {
            booleans: [0; 2],
            integers: [0; INTEGER_REGISTERS as usize],
            float_bits: [0; FLOAT_REGISTERS as usize],
        }
    }
}

impl Registers {
    /// All registers as they are now. One that is written meanwhile has its old or its new value.
    pub fn images(&self) -> RegisterImages {
        RegisterImages {
            input: self.input.image(),
            output: self.output.image(),
        }
    }
}

impl RegisterBank {
    /// All registers of the bank as they are now.
    pub fn image(&self) -> RegisterImage {
        RegisterImage {
            booleans: self.booleans(),
            integers: std::array::from_fn(|n| self.integers[n].load(Ordering::Relaxed)),
            float_bits: std::array::from_fn(|n| self.floats[n].load(Ordering::Relaxed)),
        }
    }
}

impl RegisterImage {
    /// Boolean register `n`; low beyond the last.
    pub fn boolean(&self, n: u8) -> bool {
        let word = self.booleans.get(usize::from(n / 64));
        word.is_some_and(|word| word >> (n % 64) & 1 == 1)
    }

    /// Boolean registers 0-63 and 64-127 as bits.
    pub const fn booleans(&self) -> [u64; 2] {
        self.booleans
    }

    /// Integer register `n`; 0 beyond the last.
    pub fn integer(&self, n: u8) -> i32 {
        self.integers.get(usize::from(n)).copied().unwrap_or(0)
    }

    /// Float register `n`; 0 beyond the last.
    pub fn float(&self, n: u8) -> f64 {
        let bits = self.float_bits.get(usize::from(n)).copied();
        f64::from_bits(bits.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_has_the_values_of_its_moment() {
        let registers = Registers::default();
        registers.output.set_boolean(100, true);
        registers.input.set_integer(47, -7);
        registers.input.set_float(3, f64::NAN);
        let image = registers.images();
        registers.input.set_integer(47, 8);
        assert!(image.output.boolean(100) && !image.input.boolean(100));
        assert_eq!((image.input.integer(47), image.input.integer(48)), (-7, 0));
        assert!(image.input.float(3).is_nan());
        assert_ne!(image, registers.images());
        registers.input.set_integer(47, -7);
        assert_eq!(image, registers.images());
    }

    #[test]
    fn a_view_shows_every_write_at_the_next_look() {
        let registers = Registers::default();
        let mut view = RegisterCache::default();
        registers.input.set_float(2, 1.5);
        for n in 0..48 {
            assert!(view.refresh(&registers) && !view.refresh(&registers));
            assert_eq!(*view.images(), registers.images());
            match n % 4 {
                0 => registers.input.set_integer(n, 7),
                1 => registers.output.set_float(n, -1.0),
                2 => registers.input.set_boolean(n, true),
                _ => registers.output.set_boolean(n - 1, false),
            }
        }
        assert!(view.refresh(&registers));
        assert_eq!(*view.images(), registers.images());
    }

    #[test]
    fn every_register_holds_its_own_value() {
        let bank = RegisterBank::default();
        for n in 0..BOOLEAN_REGISTERS {
            bank.set_boolean(n, n % 3 == 0);
        }
        for n in 0..INTEGER_REGISTERS {
            bank.set_integer(n, -i32::from(n));
            bank.set_float(n, f64::from(n) / 8.0);
        }
        assert!((0..BOOLEAN_REGISTERS).all(|n| bank.boolean(n) == (n % 3 == 0)));
        assert!((0..INTEGER_REGISTERS).all(|n| bank.integer(n) == -i32::from(n)));
        assert!((0..FLOAT_REGISTERS).all(|n| bank.float(n) == f64::from(n) / 8.0));
        assert_eq!(bank.booleans()[0] & 0b1111, 0b1001);
    }

    #[test]
    fn registers_beyond_the_last_do_not_exist() {
        let bank = RegisterBank::default();
        bank.set_boolean(128, true);
        bank.set_integer(48, 1);
        bank.set_float(255, 1.0);
        assert_eq!(
            (bank.boolean(128), bank.integer(48), bank.float(255)),
            (false, 0, 0.0)
        );
        assert_eq!(bank.booleans(), [0, 0]);
    }
}
