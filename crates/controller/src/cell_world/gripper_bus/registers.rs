//! The public Modbus maps of gripper makers: words written become an order to the fingers, and what the fingers do
//! becomes words to read.
//!
//! Pure: knows no bus and no world. Motors are not simulated, so the words for their current read 0, and activation
//! takes no way and no time.

use io_bus::modbus_server::tables::ModbusException;
use world::{FingerOrder, FingerState};

use crate::cell::world_schema::GripperProtocol;

/// What the fingers can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FingerLimits {
    /// Opening between open fingers, m.
    pub(super) stroke: f64,
    /// Speed of each finger, m/s.
    pub(super) speed: f64,
    /// Force of each finger, N.
    pub(super) force: f64,
}

/// What the fingers do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FingerView {
    /// Opening between the fingers, m.
    pub(super) width: f64,
    /// Whether they move, press or have arrived.
    pub(super) state: FingerState,
}

/// What written words ask of the fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FingerRequest {
    /// Nothing has been asked yet.
    Nothing,
    /// Stop where they are; what they hold stays held.
    Stop,
    /// Go somewhere.
    Go(FingerOrder),
}

/// The words of one gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GripperRegisters {
    Robotiq(RobotiqRegisters),
    Dh(DhRegisters),
}

/// Written words of the Robotiq 2F-85 and 2F-140 (instruction manual, "Control": action request to force).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RobotiqRegisters {
    words: [u16; 3],
}

/// Written words of the DH AG grippers (AG-95 manual, "Modbus RTU").
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DhRegisters {
    is_initialised: bool,
    /// Force, %.
    force: u16,
    /// Opening, thousandths of the stroke, once it has been asked for.
    position: Option<u16>,
    /// Speed, %.
    speed: u16,
}

/// The function that writes words and reads others.
const READ_WRITE: u8 = 23;
/// First word that is written to a Robotiq gripper, and first one to read.
const ROBOTIQ_OUTPUTS: u16 = 0x03E8;
const ROBOTIQ_INPUTS: u16 = 0x07D0;
/// Bits of the high byte of the first word.
const ACTIVATE: u16 = 0x0100;
const GO: u16 = 0x0800;
/// The 2F-85 presses with 20 to 235 N and moves at 20 to 150 mm/s: byte 0 is the least, which is not 0.
const LEAST_FORCE: f64 = 20.0 / 235.0;
const LEAST_SPEED: f64 = 20.0 / 150.0;

impl GripperRegisters {
    pub(super) const fn new(protocol: GripperProtocol) -> Self {
        match protocol {
            GripperProtocol::Robotiq2F => Self::Robotiq(RobotiqRegisters { words: [0; 3] }),
            GripperProtocol::DhAg => Self::Dh(DhRegisters {
                is_initialised: false,
                force: 100,
                position: None,
                speed: 100,
            }),
        }
    }

    /// Whether a gripper has a function: reading and writing at once is in the manual of the 2F-85 and 2F-140 ("Master
    /// read & write multiple registers FC23"), and in none of DH.
    pub(super) const fn has_function(&self, function: u8) -> bool {
        match self {
            Self::Robotiq(_) => true,
            Self::Dh(_) => function != READ_WRITE,
        }
    }

    /// Takes one word.
    pub(super) fn write(&mut self, address: u16, word: u16) -> Result<(), ModbusException> {
        match self {
            Self::Robotiq(registers) => registers.write(address, word),
            Self::Dh(registers) => registers.write(address, word),
        }
    }

    /// The word at an address.
    pub(super) fn read(
        &self,
        address: u16,
        limits: &FingerLimits,
        view: &FingerView,
    ) -> Result<u16, ModbusException> {
        match self {
            Self::Robotiq(registers) => registers.read(address, limits, view),
            Self::Dh(registers) => registers.read(address, limits, view),
        }
    }

    /// What the words written so far ask for.
    pub(super) fn request(&self, limits: &FingerLimits) -> FingerRequest {
        match self {
            Self::Robotiq(registers) => registers.request(limits),
            Self::Dh(registers) => registers.request(limits),
        }
    }
}

/// A share of the largest value as an order: kept to nanometres and the like, so that a recording gives the same bits
/// back.
fn share_of(largest: f64, share: f64) -> f64 {
    ((largest * share * 1e9).round() / 1e9).min(largest)
}

/// How far the fingers are open, in steps of the stroke.
fn steps(view: &FingerView, limits: &FingerLimits, count: f64) -> u16 {
    // Within 0 and `count`, which is at most 1000.
    (view.width / limits.stroke * count)
        .round()
        .clamp(0.0, count) as u16
}

impl RobotiqRegisters {
    fn write(&mut self, address: u16, word: u16) -> Result<(), ModbusException> {
        let index = usize::from(address.wrapping_sub(ROBOTIQ_OUTPUTS));
        let slot = self
            .words
            .get_mut(index)
            .ok_or(ModbusException::IllegalAddress)?;
        // Other bits of the action request (automatic release) would ask for what these fingers do not do.
        if index == 0 && word & 0xFF00 & !(ACTIVATE | GO) != 0 {
            return Err(ModbusException::IllegalValue);
        }
        *slot = word;
        Ok(())
    }

    const fn is_active(&self) -> bool {
        self.words[0] & ACTIVATE != 0
    }

    const fn goes(&self) -> bool {
        self.is_active() && self.words[0] & GO != 0
    }

    fn position(&self) -> f64 {
        f64::from(self.words[1] & 0xFF) / 255.0
    }

    fn read(
        &self,
        address: u16,
        limits: &FingerLimits,
        view: &FingerView,
    ) -> Result<u16, ModbusException> {
        let asked = self.words[1] & 0xFF;
        let position = 255 - steps(view, limits, 255.0);
        match address.wrapping_sub(ROBOTIQ_INPUTS) {
            0 => {
                let ready = if self.is_active() { 3 << 12 } else { 0 };
                let go_and_object = match self.goes() {
                    true => GO | self.object(limits, view) << 14,
                    false => 0,
                };
                Ok(self.words[0] & ACTIVATE | ready | go_and_object)
            }
            1 => Ok(asked),
            2 => Ok(position << 8),
            _ => Err(ModbusException::IllegalAddress),
        }
    }

    /// The two bits that tell of an object.
    fn object(&self, limits: &FingerLimits, view: &FingerView) -> u16 {
        match view.state {
            FingerState::Moving => 0,
            FingerState::BlockedOpening => 1,
            FingerState::GrippingInside => 2,
            FingerState::Arrived => 3,
            // What was lost shows as arrival without an object, once the fingers are there.
            FingerState::Lost => {
                let target = share_of(limits.stroke, 1.0 - self.position());
                if (view.width - target).abs() < 1e-4 {
                    3
                } else {
                    0
                }
            }
        }
    }

    fn request(&self, limits: &FingerLimits) -> FingerRequest {
        if !self.goes() {
            return FingerRequest::Stop;
        }
        let [speed, force] =
            [self.words[2] >> 8, self.words[2] & 0xFF].map(|b| f64::from(b) / 255.0);
        FingerRequest::Go(FingerOrder {
            width: share_of(limits.stroke, 1.0 - self.position()),
            speed: share_of(limits.speed, LEAST_SPEED + (1.0 - LEAST_SPEED) * speed),
            force: share_of(limits.force, LEAST_FORCE + (1.0 - LEAST_FORCE) * force),
        })
    }
}

impl DhRegisters {
    fn write(&mut self, address: u16, word: u16) -> Result<(), ModbusException> {
        let allowed = match address {
            // 0xA5 finds both ends before it is ready, 1 one of them.
            0x0100 if word == 0xA5 => 0xA5..=0xA5,
            0x0100 => 1..=1,
            0x0101 => 20..=100,
            0x0103 => 0..=1000,
            0x0104 => 1..=100,
            _ => return Err(ModbusException::IllegalAddress),
        };
        if !allowed.contains(&word) {
            return Err(ModbusException::IllegalValue);
        }
        match address {
            0x0100 => self.is_initialised = true,
            0x0101 => self.force = word,
            // Before it is initialised, the gripper does not move, then or later.
            0x0103 if !self.is_initialised => {}
            0x0103 => self.position = Some(word),
            _ => self.speed = word,
        }
        Ok(())
    }

    fn read(
        &self,
        address: u16,
        limits: &FingerLimits,
        view: &FingerView,
    ) -> Result<u16, ModbusException> {
        let opening = steps(view, limits, 1000.0);
        match address {
            0x0100 | 0x0200 => Ok(self.is_initialised.into()),
            0x0101 => Ok(self.force),
            0x0103 => Ok(self.position.unwrap_or(opening)),
            0x0104 => Ok(self.speed),
            0x0201 => Ok(match view.state {
                FingerState::Moving => 0,
                FingerState::Arrived => 1,
                FingerState::GrippingInside | FingerState::BlockedOpening => 2,
                FingerState::Lost => 3,
            }),
            0x0202 => Ok(opening),
            _ => Err(ModbusException::IllegalAddress),
        }
    }

    fn request(&self, limits: &FingerLimits) -> FingerRequest {
        let Some(position) = self.position else {
            return FingerRequest::Nothing;
        };
        FingerRequest::Go(FingerOrder {
            width: share_of(limits.stroke, f64::from(position) / 1000.0),
            speed: share_of(limits.speed, f64::from(self.speed) / 100.0),
            force: share_of(limits.force, f64::from(self.force) / 100.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: FingerLimits = FingerLimits {
        stroke: 0.085,
        speed: 0.075,
        force: 235.0,
    };

    fn view(width: f64, state: FingerState) -> FingerView {
        FingerView { width, state }
    }

    #[test]
    fn robotiq_answers_as_the_examples_of_its_manual() {
        // Instruction manual of the 2F-85, "Modbus RTU example": first input word when activated 0x3100, while it
        // closes 0x3900, with an object 0xB900, open again 0xF900.
        let mut map = GripperRegisters::new(GripperProtocol::Robotiq2F);
        let open = view(0.085, FingerState::Arrived);
        let status = |map: &GripperRegisters, view| map.read(0x07D0, &LIMITS, &view);
        assert_eq!(status(&map, open), Ok(0));
        map.write(0x03E8, 0x0100).unwrap();
        assert_eq!(status(&map, open), Ok(0x3100));
        assert_eq!(map.request(&LIMITS), FingerRequest::Stop);
        for (address, word) in [(0x03E8, 0x0900), (0x03E9, 0x00FF), (0x03EA, 0xFFFF)] {
            map.write(address, word).unwrap();
        }
        let order = FingerOrder {
            width: 0.0,
            speed: 0.075,
            force: 235.0,
        };
        assert_eq!(map.request(&LIMITS), FingerRequest::Go(order));
        assert_eq!(status(&map, view(0.06, FingerState::Moving)), Ok(0x3900));
        let held = view(0.0425, FingerState::GrippingInside);
        assert_eq!(status(&map, held), Ok(0xB900));
        assert_eq!(map.read(0x07D1, &LIMITS, &held), Ok(0x00FF));
        assert_eq!(map.read(0x07D2, &LIMITS, &held), Ok(127 << 8));
        let blocked = view(0.0425, FingerState::BlockedOpening);
        assert_eq!(status(&map, blocked), Ok(0x7900));
        assert_eq!(status(&map, view(0.02, FingerState::Lost)), Ok(0x3900));
        assert_eq!(status(&map, view(0.0, FingerState::Lost)), Ok(0xF900));
        assert_eq!(status(&map, open), Ok(0xF900));
        map.write(0x03E8, 0).unwrap();
        assert_eq!(map.request(&LIMITS), FingerRequest::Stop);
    }

    #[test]
    fn robotiq_moves_slowly_and_gently_at_byte_zero() {
        let mut map = GripperRegisters::new(GripperProtocol::Robotiq2F);
        map.write(0x03E8, 0x0900).unwrap();
        let order = FingerOrder {
            width: 0.085,
            speed: 0.01,
            force: 20.0,
        };
        assert_eq!(map.request(&LIMITS), FingerRequest::Go(order));
    }

    #[test]
    fn dh_moves_once_it_is_initialised() {
        let mut map = GripperRegisters::new(GripperProtocol::DhAg);
        map.write(0x0103, 500).unwrap();
        map.write(0x0100, 1).unwrap();
        assert_eq!(map.request(&LIMITS), FingerRequest::Nothing);
        for (address, word) in [(0x0101, 20), (0x0103, 500), (0x0104, 40)] {
            map.write(address, word).unwrap();
        }
        let order = FingerOrder {
            width: 0.0425,
            speed: 0.03,
            force: 47.0,
        };
        assert_eq!(map.request(&LIMITS), FingerRequest::Go(order));
        let states = [
            (FingerState::Moving, 0),
            (FingerState::Arrived, 1),
            (FingerState::GrippingInside, 2),
            (FingerState::Lost, 3),
        ];
        for (state, word) in states {
            assert_eq!(map.read(0x0201, &LIMITS, &view(0.017, state)), Ok(word));
        }
        let there = view(0.017, FingerState::Arrived);
        assert_eq!(map.read(0x0200, &LIMITS, &there), Ok(1));
        assert_eq!(map.read(0x0202, &LIMITS, &there), Ok(200));
    }

    #[test]
    fn what_the_maps_do_not_have_is_refused() {
        let there = view(0.0, FingerState::Arrived);
        let (address, value) = (
            ModbusException::IllegalAddress,
            ModbusException::IllegalValue,
        );
        let mut map = GripperRegisters::new(GripperProtocol::Robotiq2F);
        assert_eq!(map.write(0x03EB, 0), Err(address));
        assert_eq!(map.write(0x03E7, 0), Err(address));
        assert_eq!(map.write(0x03E8, 0x1100), Err(value));
        assert_eq!(map.read(0x07D3, &LIMITS, &there), Err(address));
        let mut map = GripperRegisters::new(GripperProtocol::DhAg);
        for (at, word) in [(0x0100, 0), (0x0101, 19), (0x0103, 1001), (0x0104, 0)] {
            assert_eq!(map.write(at, word), Err(value), "{at:#x}");
        }
        assert_eq!(map.write(0x0102, 1), Err(address));
        assert_eq!(map.read(0x0203, &LIMITS, &there), Err(address));
    }
}
