//! What a serial line carries while a reply is waited for: found or not, never a wrong length, the same in pieces.

use io_bus::modbus::pdu::{Reply, Request, Table};
use io_bus::modbus::rtu;

fn request(kind: u8, count: u8) -> Request {
    let table = match kind & 3 {
        0 => Table::Coils,
        1 => Table::DiscreteInputs,
        2 => Table::HoldingRegisters,
        _ => Table::InputRegisters,
    };
    match kind >> 2 & 3 {
        0 | 1 => Request::Read {
            table,
            address: 0,
            count: u16::from(count).clamp(1, 125),
        },
        2 => Request::WriteCoil(7, true),
        _ => Request::WriteRegisters(7, vec![1; usize::from(count).clamp(1, 123)]),
    }
}

pub(super) fn judge(data: &[u8]) {
    let Some((&[slave, kind, count, damage], noise)) = data.split_first_chunk::<4>() else {
        return;
    };
    let request = request(kind, count);
    // Half of the inputs get good checksums, or nothing behind them would ever be reached.
    let mut line = noise.to_vec();
    if damage & 1 == 0 {
        line.extend(rtu::crc(noise).to_le_bytes());
    }
    let found = rtu::find_reply(&line, slave, &request);
    if let Some(reply) = found
        && let Ok(Reply::Values(values)) = request.decode(reply)
    {
        assert!(values.len() <= 2000);
    }
    // A longer line keeps what a shorter one had, unless it found nothing.
    let half = &line[..line.len() / 2];
    if let Some(early) = rtu::find_reply(half, slave, &request) {
        assert_eq!(found, Some(early));
    }
    let _ = request.decode(noise);
}
