//! Lines over a pty and over TCP, good answers and bad ones.

use super::*;
use crate::modbus::pdu::Table;
use serialport::{SerialPort, TTYPort};
use std::io::{Read, Write};
use tokio::net::TcpListener;

const PATIENCE: Option<Duration> = Some(Duration::from_millis(300));

fn settings(modbus_rtu: bool) -> SerialSettings {
    SerialSettings {
        baud_rate: 115_200,
        parity: 0,
        stop_bits: 1,
        data_bits: 8,
        modbus_rtu,
        is_daemon_owned: false,
    }
}

#[tokio::test]
async fn bytes_go_through_a_pty_both_ways() {
    let (mut master, slave) = TTYPort::pair().unwrap();
    let line = SerialLine::new(Some(Endpoint::parse(&slave.name().unwrap())));
    line.configure(Some(settings(false))).await.unwrap();
    assert_eq!(line.mode(), SerialMode::Raw);
    assert_eq!(line.write(b"hello".to_vec()).await.unwrap(), 5);
    let mut received = [0; 5];
    master.read_exact(&mut received).unwrap();
    assert_eq!(&received, b"hello");
    master.write_all(&[1, 2, 3, 255]).unwrap();
    assert_eq!(line.read(3, PATIENCE).await.unwrap(), [1, 2, 3]);
    assert_eq!(line.read(3, PATIENCE).await.unwrap(), [255]);
    assert_eq!(
        line.read(1, Some(Duration::from_millis(20))).await.unwrap(),
        [0; 0]
    );
    line.configure(None).await.unwrap();
    assert!(matches!(
        line.read(1, PATIENCE).await,
        Err(SerialError::Mode { .. })
    ));
}

/// A device that answers each request with the next of `answers`.
async fn device(answers: Vec<Vec<u8>>) -> SerialLine {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = format!("tcp:{}", listener.local_addr().unwrap());
    tokio::spawn(async move {
        let (mut stream, _) = listener.accept().await.unwrap();
        for answer in answers {
            let mut request = [0; 8];
            stream.read_exact(&mut request).await.unwrap();
            stream.write_all(&answer).await.unwrap();
        }
        stream.read_exact(&mut [0; 999]).await.unwrap_or_default();
    });
    let line = SerialLine::new(Some(Endpoint::parse(&address)));
    line.configure(Some(settings(true))).await.unwrap();
    line
}

fn frame(body: &[u8]) -> Vec<u8> {
    [body, &rtu::crc(body).to_le_bytes()].concat()
}

#[tokio::test]
async fn answers_damaged_answers_refusals_and_silence_are_told_apart() {
    let good = frame(&[7, 3, 2, 0x12, 0x34]);
    let mut damaged = good.clone();
    damaged[3] ^= 1;
    let noisy = [vec![0, 255, 7, 3], good.clone()].concat();
    let line = device(vec![good, damaged, frame(&[7, 0x83, 2]), noisy, vec![]]).await;
    let mut answers = Vec::new();
    for _ in 0..5 {
        let request = Request::Read {
            table: Table::HoldingRegisters,
            address: 0,
            count: 1,
        };
        answers.push(match line.request(7, request, PATIENCE).await {
            Ok(Reply::Values(values)) => format!("{values:?}"),
            Ok(Reply::Done) => "done".to_owned(),
            Err(error) => error.to_string(),
        });
    }
    assert_eq!(
        answers,
        [
            "[4660]",
            "the answer is damaged (7 bytes without a frame whose checksum fits)",
            "the device answered with exception 2",
            "[4660]",
            "no answer within the timeout",
        ]
    );
}

#[tokio::test]
async fn a_port_without_a_device_says_so() {
    let line = SerialLine::default();
    let error = line.configure(Some(settings(false))).await.unwrap_err();
    assert!(matches!(error, SerialError::NoDevice), "{error}");
    assert_eq!(line.mode(), SerialMode::Closed);
    let line = SerialLine::new(Some(Endpoint::parse("/dev/no-such-line")));
    let error = line.configure(Some(settings(false))).await.unwrap_err();
    assert!(matches!(error, SerialError::Line(_)), "{error}");
}

#[tokio::test]
async fn a_forwarded_line_carries_bytes_both_ways_and_gives_programs_their_turns() {
    let (mut master, slave) = TTYPort::pair().unwrap();
    let line = SerialLine::new(Some(Endpoint::parse(&slave.name().unwrap())));
    let (mut client, there) = tokio::io::duplex(4096);
    // Nobody has set it yet.
    let refused = line.forward(there).await.unwrap_err();
    assert!(matches!(refused, SerialError::Mode { .. }), "{refused}");
    drop(client);

    line.configure(Some(settings(false))).await.unwrap();
    let (here, there) = tokio::io::duplex(4096);
    client = here;
    let talk = async {
        client.write_all(b"ask").await.unwrap();
        let mut asked = [0; 3];
        let asked = tokio::task::spawn_blocking(move || {
            master.read_exact(&mut asked).unwrap();
            master.write_all(&[0, 255, 10, 13]).unwrap();
            (asked, master)
        });
        let (asked, mut master) = asked.await.unwrap();
        assert_eq!(&asked, b"ask");
        let mut answer = [0; 4];
        client.read_exact(&mut answer).await.unwrap();
        assert_eq!(answer, [0, 255, 10, 13]);
        // A program writes meanwhile.
        assert_eq!(line.write(b"hi".to_vec()).await.unwrap(), 2);
        let mut both = [0; 2];
        master.read_exact(&mut both).unwrap();
        assert_eq!(&both, b"hi");
        client.shutdown().await.unwrap();
        // The other end of the line is there until the client has gone.
        master
    };
    let (forwarded, _master) = tokio::join!(line.forward(there), talk);
    forwarded.unwrap();
}
