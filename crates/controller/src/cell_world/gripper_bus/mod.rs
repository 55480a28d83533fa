//! Grippers of the cell as Modbus slaves, on the controller's serial lines and on Modbus TCP.
//!
//! Owns the words that were written to each. What they ask for reaches the world as an order between two cycles, and so
//! gets into the recording. Answers take no time: runs on the thread of whoever asks.

mod registers;
mod tcp;

use std::collections::BTreeMap;
use std::sync::Arc;

use io_bus::modbus_server::tables::{ModbusException, Slaves, Space, Tables};
use parking_lot::Mutex;
use world::description::{Fingers, GripperKind};
use world::{FingerOrder, FingerState};

use super::{CellWorld, WorldOrder};
use crate::cell::Cell;
use crate::cell::world_schema::{GripperBus, GripperTable};
use registers::{FingerLimits, FingerRequest, FingerView, GripperRegisters};

pub(crate) use tcp::{GripperPeers, GripperTimeline};

/// The grippers on Modbus TCP, by port.
pub(crate) fn tcp_slaves(cell: &Cell, world: &CellWorld) -> BTreeMap<u16, Slaves> {
    let buses = cell
        .tables()
        .gripper
        .iter()
        .filter_map(GripperTable::modbus_bus);
    let ports = buses.filter_map(|bus| match bus {
        GripperBus::Tcp(port) => Some((port, slaves(cell, world, bus))),
        GripperBus::Serial(_) => None,
    });
    ports.collect()
}

/// The grippers on a bus, by the number of the slave.
pub(crate) fn slaves(cell: &Cell, world: &CellWorld, bus: GripperBus) -> Slaves {
    let grippers = cell.tables().gripper.iter().enumerate();
    let slaves = grippers.filter_map(|(number, table)| {
        if table.modbus_bus() != Some(bus) {
            return None;
        }
        let slave = BusGripper::new(number, table, world.clone())?;
        Some((table.slave_number(), Arc::new(slave) as Arc<_>))
    });
    slaves.collect::<BTreeMap<_, _>>()
}

/// A gripper on a bus.
struct BusGripper {
    world: CellWorld,
    /// Number of the gripper in the world.
    number: usize,
    limits: FingerLimits,
    words: Mutex<WrittenWords>,
}

struct WrittenWords {
    registers: GripperRegisters,
    /// The order that the fingers have.
    order: Option<FingerOrder>,
}

impl BusGripper {
    fn new(number: usize, table: &GripperTable, world: CellWorld) -> Option<Self> {
        let GripperKind::Fingers(Fingers {
            stroke,
            speed,
            force,
            ..
        }) = world.description().grippers.get(number)?.kind
        else {
            return None;
        };
        Some(Self {
            number,
            limits: FingerLimits {
                stroke,
                speed,
                force,
            },
            words: Mutex::new(WrittenWords {
                registers: GripperRegisters::new(table.protocol?),
                order: None,
            }),
            world,
        })
    }

    fn view(&self) -> FingerView {
        let world = self.world.lock();
        let state = world.state().grippers.get(self.number);
        FingerView {
            width: state.map_or(0.0, |gripper| gripper.width),
            state: state.map_or(FingerState::Moving, |gripper| gripper.fingers),
        }
    }

    /// Gives the fingers an order, if it is another one than they have.
    fn send(&self, words: &mut WrittenWords, order: FingerOrder) -> Result<(), ModbusException> {
        if words.order == Some(order) {
            return Ok(());
        }
        let sent = self.world.order(WorldOrder::Fingers {
            gripper: self.number,
            width: order.width,
            speed: order.speed,
            force: order.force,
        });
        sent.map_err(|_| ModbusException::IllegalValue)?;
        words.order = Some(order);
        Ok(())
    }
}

impl Tables for BusGripper {
    fn has_function(&self, function: u8) -> bool {
        self.words.lock().registers.has_function(function)
    }

    fn read_bits(&self, _: Space, _: u16, _: u16) -> Result<Vec<bool>, ModbusException> {
        Err(ModbusException::IllegalFunction)
    }

    fn write_bits(&self, _: u16, _: &[bool]) -> Result<(), ModbusException> {
        Err(ModbusException::IllegalFunction)
    }

    /// Both spaces show the same words.
    fn read_words(&self, _: Space, address: u16, count: u16) -> Result<Vec<u16>, ModbusException> {
        let view = self.view();
        let registers = self.words.lock().registers;
        let word = |k: u16| {
            let address = address
                .checked_add(k)
                .ok_or(ModbusException::IllegalAddress)?;
            registers.read(address, &self.limits, &view)
        };
        (0..count).map(word).collect()
    }

    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException> {
        let view = self.view();
        let mut words = self.words.lock();
        let mut registers = words.registers;
        for (address, value) in (u32::from(address)..).zip(values) {
            let address = u16::try_from(address).map_err(|_| ModbusException::IllegalAddress)?;
            registers.write(address, *value)?;
        }
        match registers.request(&self.limits) {
            FingerRequest::Go(order) => self.send(&mut words, order)?,
            FingerRequest::Stop if view.state == FingerState::Moving => {
                if let Some(order) = words.order {
                    let width = (view.width * 1e9).round() / 1e9;
                    let width = width.clamp(0.0, self.limits.stroke);
                    self.send(&mut words, FingerOrder { width, ..order })?;
                }
            }
            FingerRequest::Stop | FingerRequest::Nothing => {}
        }
        words.registers = registers;
        Ok(())
    }

    fn change_word(&self, _: u16, _: &dyn Fn(u16) -> u16) -> Result<(), ModbusException> {
        Err(ModbusException::IllegalFunction)
    }
}
