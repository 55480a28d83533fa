//! Modbus requests and replies without their framing (MODBUS Application Protocol Specification V1.1b3). Pure.

use messages::Localized;
use thiserror::Error;

/// What is asked of a device. Counts are within the protocol's limits by construction of their callers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Functions 1 to 4.
    Read {
        /// Table that is read.
        table: Table,
        /// Address of the first value.
        address: u16,
        /// Number of values.
        count: u16,
    },
    /// Function 5.
    WriteCoil(u16, bool),
    /// Function 6.
    WriteRegister(u16, u16),
    /// Function 15.
    WriteCoils(u16, Vec<bool>),
    /// Function 16.
    WriteRegisters(u16, Vec<u16>),
    /// Function 23; the device writes first.
    ReadWrite {
        /// First register to read.
        read: u16,
        /// Number of registers to read.
        count: u16,
        /// First register to write.
        write: u16,
        /// The values.
        values: Vec<u16>,
    },
    /// Any function with its bytes; the reply is not looked at.
    Custom(u8, Vec<u8>),
}

/// The four tables of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Table {
    /// Function 1.
    Coils = 1,
    /// Function 2.
    DiscreteInputs = 2,
    /// Function 3.
    HoldingRegisters = 3,
    /// Function 4.
    InputRegisters = 4,
}

impl Table {
    /// True for tables of single bits.
    pub const fn is_bits(self) -> bool {
        matches!(self, Self::Coils | Self::DiscreteInputs)
    }
}

/// Set in the function code of a reply that is an exception.
pub const EXCEPTION_FLAG: u8 = 0x80;

/// What a device answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The values read; bits as 0 and 1.
    Values(Vec<u16>),
    /// Written, or a custom function answered.
    Done,
}

/// A reason why an answer is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
pub enum PduError {
    /// The device refused.
    #[error("the device answered with exception {0}")]
    #[zh("设备以异常 {0} 应答")]
    Exception(u8),
    /// The bytes do not answer the request.
    #[error("the device's answer does not fit the request")]
    #[zh("设备的应答与请求不符")]
    Malformed,
}

impl Request {
    /// The function code.
    pub fn function(&self) -> u8 {
        match self {
            Self::Read { table, .. } => *table as u8,
            Self::WriteCoil(..) => 5,
            Self::WriteRegister(..) => 6,
            Self::WriteCoils(..) => 15,
            Self::WriteRegisters(..) => 16,
            Self::ReadWrite { .. } => 23,
            Self::Custom(function, _) => *function,
        }
    }

    /// The bytes of the request proper.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = vec![self.function()];
        let mut words = |words: &[u16]| out.extend(words.iter().flat_map(|w| w.to_be_bytes()));
        match self {
            Self::Read { address, count, .. } => words(&[*address, *count]),
            Self::WriteCoil(address, level) => words(&[*address, if *level { 0xFF00 } else { 0 }]),
            Self::WriteRegister(address, value) => words(&[*address, *value]),
            Self::WriteCoils(address, levels) => {
                words(&[*address, levels.len() as u16]);
                let bytes = levels.chunks(8).map(|chunk| {
                    let bits = chunk.iter().enumerate();
                    bits.fold(0, |byte, (k, level)| byte | u8::from(*level) << k)
                });
                out.push(levels.len().div_ceil(8) as u8);
                out.extend(bytes);
            }
            Self::WriteRegisters(address, values) => {
                words(&[*address, values.len() as u16]);
                out.push((2 * values.len()) as u8);
                out.extend(values.iter().flat_map(|w| w.to_be_bytes()));
            }
            Self::ReadWrite {
                read,
                count,
                write,
                values,
            } => {
                words(&[*read, *count, *write, values.len() as u16]);
                out.push((2 * values.len()) as u8);
                out.extend(values.iter().flat_map(|w| w.to_be_bytes()));
            }
            Self::Custom(_, data) => out.extend(data),
        }
        out
    }

    /// Length of the reply proper when it is no exception; `None` when it cannot be known.
    pub fn reply_bytes(&self) -> Option<usize> {
        match self {
            Self::Read { table, count, .. } if table.is_bits() => {
                Some(2 + usize::from(*count).div_ceil(8))
            }
            Self::Read { count, .. } | Self::ReadWrite { count, .. } => {
                Some(2 + 2 * usize::from(*count))
            }
            Self::Custom(..) => None,
            _ => Some(5),
        }
    }

    /// Understands a reply proper.
    ///
    /// # Errors
    /// [`PduError`]: an exception of the device, or bytes that are no answer.
    pub fn decode(&self, reply: &[u8]) -> Result<Reply, PduError> {
        match reply {
            [function, code, ..] if *function == self.function() | EXCEPTION_FLAG => {
                return Err(PduError::Exception(*code));
            }
            [function, ..] if *function == self.function() => {}
            _ => return Err(PduError::Malformed),
        }
        if self
            .reply_bytes()
            .is_some_and(|length| length != reply.len())
        {
            return Err(PduError::Malformed);
        }
        match self {
            Self::Read { count, .. } | Self::ReadWrite { count, .. } => {
                let data = &reply[2..];
                if usize::from(reply[1]) != data.len() {
                    return Err(PduError::Malformed);
                }
                let bits = matches!(self, Self::Read { table, .. } if table.is_bits());
                let value = |k: usize| match bits {
                    true => u16::from(data[k / 8] >> (k % 8) & 1),
                    false => u16::from_be_bytes([data[2 * k], data[2 * k + 1]]),
                };
                Ok(Reply::Values((0..usize::from(*count)).map(value).collect()))
            }
            // The address and value, or count, come back.
            Self::WriteCoil(..) | Self::WriteRegister(..) if reply != self.encode() => {
                Err(PduError::Malformed)
            }
            Self::WriteCoils(..) | Self::WriteRegisters(..)
                if reply[1..] != self.encode()[1..5] =>
            {
                Err(PduError::Malformed)
            }
            _ => Ok(Reply::Done),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modbus_server::codec::build_reply;
    use crate::modbus_server::tables::Store;
    use proptest::prelude::*;

    /// What our own server, which is tested against tokio-modbus, answers.
    fn ask(store: &Store, request: &Request) -> Result<Reply, PduError> {
        let pdu = request.encode();
        let length = (pdu.len() + 1) as u16;
        let mut message = vec![0, 1, 0, 0];
        message.extend(length.to_be_bytes());
        message.push(255);
        message.extend(pdu);
        request.decode(&build_reply(&message, store)[7..])
    }

    #[test]
    fn every_function_gives_what_was_written() {
        let store = Store::default();
        let levels = vec![true, false, true, true, false, false, true, true, true];
        let bits = levels.iter().map(|l| u16::from(*l)).collect();
        let read = |table, address, count| Request::Read {
            table,
            address,
            count,
        };
        assert_eq!(
            ask(&store, &Request::WriteCoils(3, levels)),
            Ok(Reply::Done)
        );
        assert_eq!(
            ask(&store, &read(Table::Coils, 3, 9)),
            Ok(Reply::Values(bits))
        );
        assert_eq!(ask(&store, &Request::WriteCoil(4, true)), Ok(Reply::Done));
        assert_eq!(
            ask(&store, &read(Table::Coils, 4, 1)),
            Ok(Reply::Values(vec![1]))
        );
        let values = vec![1, 65535, 256];
        assert_eq!(
            ask(&store, &Request::WriteRegisters(7, values.clone())),
            Ok(Reply::Done)
        );
        assert_eq!(ask(&store, &Request::WriteRegister(8, 77)), Ok(Reply::Done));
        let request = Request::ReadWrite {
            read: 7,
            count: 3,
            write: 9,
            values: vec![9],
        };
        assert_eq!(ask(&store, &request), Ok(Reply::Values(vec![1, 77, 9])));
        assert_eq!(
            ask(&store, &read(Table::HoldingRegisters, 256, 1)),
            Err(PduError::Exception(2))
        );
        assert_eq!(
            ask(&store, &Request::Custom(99, vec![])),
            Err(PduError::Exception(1))
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_bytes_are_a_reply_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..20), count in 1..20_u16,
            which in 0..4_u8) {
            let tables = [Table::Coils, Table::DiscreteInputs, Table::HoldingRegisters, Table::InputRegisters];
            let request = Request::Read { table: tables[usize::from(which)], address: 0, count };
            if let Ok(Reply::Values(values)) = request.decode(&bytes) {
                prop_assert_eq!(values.len(), usize::from(count));
            }
            let _ = Request::WriteCoils(1, vec![true; 9]).decode(&bytes);
            let _ = Request::Custom(5, vec![]).decode(&bytes);
        }
    }
}
