//! How well 200 signals at 50 Hz are kept up with: `modbus_rate HOST PORT SECONDS SPACING`.
//!
//! Reads one holding register a signal, SPACING addresses apart (1: neighbours share requests), and prints how many
//! updates came more than a period late. The device has to have the addresses.

#![allow(clippy::print_stdout, reason = "what it is for")]

use std::time::Duration;

use io_bus::modbus::{DeviceAddress, ModbusClient, SignalKind, SignalSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [host, port, seconds, spacing] = arguments.as_slice() else {
        return Err("usage: modbus_rate HOST PORT SECONDS SPACING".into());
    };
    let (seconds, spacing): (u64, u16) = (seconds.parse()?, spacing.parse()?);
    let device = DeviceAddress {
        host: host.clone(),
        port: port.parse()?,
    };
    let client = ModbusClient::default();
    let names: Vec<String> = (0..200).map(|n| format!("s{n}")).collect();
    for (n, name) in (0..).zip(&names) {
        let spec = SignalSpec {
            device: device.clone(),
            slave: 255,
            address: n * spacing,
            count: 1,
            kind: SignalKind::RegisterInput,
            is_sequential: false,
        };
        client.add(name, spec)?;
        client.set_frequency(name, 50)?;
    }
    std::thread::sleep(Duration::from_secs(seconds));
    let mut missed = 0;
    let mut invalid = 0;
    for name in &names {
        missed += client.missed_updates(name)?;
        invalid += u32::from(!client.time_since_invalid(name)?.is_zero());
    }
    println!(
        "200 signals at 50 Hz, {spacing} apart, {seconds} s: {missed} updates late, {invalid} signals invalid at the end"
    );
    Ok(())
}
