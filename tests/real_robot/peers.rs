//! A proxy between a command and its robot that delays, cuts, garbles, duplicates and re-orders what the robot says,
//! and peers that say what a test made by hand.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::time::Duration;

/// How messages of a port are told apart.
#[derive(Clone, Copy, Debug)]
pub enum Framing {
    /// Port 30001: four bytes of length, itself included.
    Primary,
    /// Port 30004: two bytes of length, itself included.
    Rtsi,
    /// Port 30020: lines.
    Lines,
}

impl Framing {
    /// Length of the first message, if it is whole.
    fn whole(self, bytes: &[u8]) -> Option<usize> {
        let length = match self {
            Self::Primary => u32::from_be_bytes(*bytes.first_chunk()?) as usize,
            Self::Rtsi => usize::from(u16::from_be_bytes(*bytes.first_chunk()?)),
            Self::Lines => bytes.iter().position(|byte| *byte == b'\n')? + 1,
        };
        (bytes.len() >= length).then_some(length)
    }
}

/// What becomes of the messages of the robot. Numbers count messages of one connection, from 0.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// Every byte by itself, after a pause now and then.
    Slow,
    /// Each message comes twice.
    Twice,
    /// From this one on, each second message changes places with the next.
    Swapped(usize),
    /// In the middle of this one the connection ends.
    Cut(usize),
    /// This one begins with other bytes.
    Garbled(usize),
    /// From this one on nothing comes any more.
    Silent(usize),
}

/// A port that leads to `to`, with a fault in the first connection, or in every one.
pub fn proxy(to: u16, framing: Framing, fault: Fault, once: bool) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for (number, client) in listener.incoming().flatten().enumerate() {
            let Ok(robot) = TcpStream::connect(("127.0.0.1", to)) else {
                continue;
            };
            let _ = (client.set_nodelay(true), robot.set_nodelay(true));
            let fault = (number == 0 || !once).then_some(fault);
            let (from_client, to_robot) = (client.try_clone().unwrap(), robot.try_clone().unwrap());
            std::thread::spawn(move || forward(from_client, to_robot));
            std::thread::spawn(move || {
                carry(&robot, &client, framing, fault);
                let _ = client.shutdown(Shutdown::Both);
                let _ = robot.shutdown(Shutdown::Both);
            });
        }
    });
    port
}

fn forward(mut from: TcpStream, mut to: TcpStream) {
    let mut piece = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut piece) {
        if to.write_all(&piece[..count]).is_err() {
            break;
        }
    }
    let _ = to.shutdown(Shutdown::Write);
}

/// Carries messages until one side has gone or the fault ends it.
fn carry(mut from: &TcpStream, mut to: &TcpStream, framing: Framing, fault: Option<Fault>) {
    let mut received = Vec::new();
    let mut piece = [0; 4096];
    let mut held: Option<Vec<u8>> = None;
    let mut number = 0;
    while let Ok(count @ 1..) = from.read(&mut piece) {
        received.extend_from_slice(&piece[..count]);
        while let Some(length) = framing.whole(&received) {
            let mut message: Vec<u8> = received.drain(..length).collect();
            let mut out = Vec::new();
            match fault {
                None => out = message,
                Some(Fault::Twice) => out = [message.clone(), message].concat(),
                Some(Fault::Slow) => {
                    for byte in message {
                        if to.write_all(&[byte]).is_err() {
                            return;
                        }
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
                Some(Fault::Swapped(first)) if number >= first => match held.take() {
                    Some(before) => out = [message, before].concat(),
                    None => held = Some(message),
                },
                Some(Fault::Cut(at)) if number == at => {
                    let _ = to.write_all(&message[..message.len() / 2]);
                    return;
                }
                Some(Fault::Garbled(at)) if number == at => {
                    let end = message.len().min(5);
                    message[..end].fill(b'?');
                    out = message;
                }
                Some(Fault::Silent(first)) if number >= first => {}
                Some(_) => out = message,
            }
            if to.write_all(&out).is_err() {
                return;
            }
            number += 1;
        }
    }
}

/// A peer that says `greeting`, answers every request of `framing` with what `answer` makes of it, and goes on saying
/// `stream` every 4 ms. It hangs up when the other side does.
pub fn peer(
    framing: Framing,
    greeting: Vec<u8>,
    answer: fn(&[u8]) -> Vec<u8>,
    stream: fn(u32) -> Vec<u8>,
) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for mut client in listener.incoming().flatten() {
            let (greeting, _) = (greeting.clone(), client.set_nodelay(true));
            std::thread::spawn(move || {
                let wait = Some(Duration::from_millis(4));
                let _ = client.set_read_timeout(wait);
                let mut received = Vec::new();
                let mut piece = [0; 4096];
                let mut out = greeting;
                for number in 0_u32.. {
                    if client.write_all(&out).is_err() {
                        return;
                    }
                    out = stream(number);
                    match client.read(&mut piece) {
                        Ok(0) => return,
                        Ok(count) => received.extend_from_slice(&piece[..count]),
                        Err(_) => {}
                    }
                    while let Some(length) = framing.whole(&received) {
                        let request: Vec<u8> = received.drain(..length).collect();
                        out.extend(answer(&request));
                    }
                }
            });
        }
    });
    port
}
