//! How well 200 signals at 50 Hz are kept up with: `modbus_rate HOST PORT SECONDS SPACING`.
//!
//! Reads one holding register a signal, SPACING addresses apart (1: neighbours share requests), and prints how many
//! updates came more than a period late. The device has to have the addresses.
//!
//! Beside it a thread that does nothing but sleep to the same beat: when that is late, the machine was busy with
//! others, and all 200 signals are late at once.

#![allow(clippy::print_stdout, reason = "what it is for")]

use std::thread;
use std::time::{Duration, Instant};

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
    let idle = thread::spawn(move || late_beats(50 * seconds));
    thread::sleep(Duration::from_secs(seconds));
    let mut missed = 0;
    let mut invalid = 0;
    for name in &names {
        missed += client.missed_updates(name)?;
        invalid += u32::from(!client.time_since_invalid(name)?.is_zero());
    }
    let late = idle.join().map_err(|_| "the idle thread panicked")?;
    let updates = 200 * 50 * seconds;
    println!(
        "{spacing} apart, {seconds} s: {missed} of {updates} updates late ({:.2} %), \
         {invalid} signals invalid at the end; a thread \
         that only sleeps was late in {late} of {} beats ({:.2} %)",
        100.0 * missed as f64 / updates as f64,
        50 * seconds,
        100.0 * late as f64 / (50 * seconds) as f64,
    );
    Ok(())
}

/// How many of so many beats of 20 ms a thread that only sleeps misses by more than a beat.
#[allow(
    clippy::disallowed_methods,
    reason = "the machine's own time is what is measured"
)]
fn late_beats(beats: u64) -> u64 {
    let beat = Duration::from_millis(20);
    let mut deadline = Instant::now();
    let mut late = 0;
    for _ in 0..beats {
        deadline += beat;
        thread::sleep(deadline.saturating_duration_since(Instant::now()));
        if deadline.elapsed() > beat {
            late += 1;
            deadline = Instant::now();
        }
    }
    late
}
