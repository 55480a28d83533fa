//! The Modbus client against devices that take several requests at once, and such that do not.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use io_bus::modbus::{DeviceAddress, ModbusClient, SignalKind, SignalSpec};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, sleep, timeout};

const SIGNALS: u16 = 40;

/// Adds signals that share no request, at a rate that one request after the other cannot keep.
fn scattered(client: &ModbusClient, port: u16) {
    for n in 0..SIGNALS {
        let spec = SignalSpec {
            device: DeviceAddress {
                host: "127.0.0.1".to_owned(),
                port,
            },
            slave: 1,
            address: 10 * n,
            count: 1,
            kind: SignalKind::RegisterInput,
            is_sequential: false,
        };
        client.add(&format!("s{n}"), spec).unwrap();
        client.set_frequency(&format!("s{n}"), 100).unwrap();
    }
}

/// The answer to a read of one register: its address.
fn answer(request: &[u8]) -> [u8; 11] {
    let [t1, t0, _, _, _, _, unit, function, a1, a0, ..] = *request else {
        panic!("no request: {request:?}")
    };
    [t1, t0, 0, 0, 0, 5, unit, function, 2, a1, a0]
}

async fn until(what: &str, mut holds: impl AsyncFnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(20);
    while !holds().await {
        assert!(Instant::now() < deadline, "never came: {what}");
        sleep(Duration::from_millis(10)).await;
    }
}

async fn all_values_are_right(client: &ModbusClient) {
    for n in 0..SIGNALS {
        let (values, _) = client.status(&format!("s{n}")).await.unwrap();
        assert_eq!(values, [10 * n]);
    }
}

/// Answers 3 ms after each request, however many are under way; notes how many came at once.
async fn patient(mut stream: TcpStream, most: Arc<AtomicUsize>) {
    let mut chunk = [0; 1200];
    while let Ok(count @ 1..) = stream.read(&mut chunk).await {
        assert_eq!(count % 12, 0, "whole requests");
        most.fetch_max(count / 12, Ordering::Relaxed);
        sleep(Duration::from_millis(3)).await;
        // In another order than they came.
        for request in chunk[..count].chunks(12).rev() {
            stream.write_all(&answer(request)).await.unwrap();
        }
    }
}

#[tokio::test]
async fn several_requests_are_under_way_where_one_does_not_keep_the_rate() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let most = Arc::new(AtomicUsize::new(0));
    let seen = most.clone();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(patient(stream, seen.clone()));
        }
    });
    let client = ModbusClient::default();
    scattered(&client, port);
    all_values_are_right(&client).await;
    until("several at once", async || most.load(Ordering::Relaxed) > 1).await;
    all_values_are_right(&client).await;
    assert!(most.load(Ordering::Relaxed) <= 8);
    assert_eq!(client.error_codes("s0").unwrap(), [0, 0]);
}

/// Answers the first of the requests that it finds and forgets the others, as the simplest devices do.
async fn simple(mut stream: TcpStream, connections: Arc<AtomicUsize>, most: Arc<AtomicUsize>) {
    connections.fetch_add(1, Ordering::Relaxed);
    most.store(0, Ordering::Relaxed);
    let mut chunk = [0; 1200];
    while let Ok(count @ 1..) = stream.read(&mut chunk).await {
        most.fetch_max(count / 12, Ordering::Relaxed);
        sleep(Duration::from_millis(1)).await;
        if stream.write_all(&answer(&chunk[..12])).await.is_err() {
            return;
        }
    }
}

#[tokio::test]
async fn a_device_that_answers_one_request_at_a_time_gets_one_at_a_time() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let (connections, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let (count, seen) = (connections.clone(), most.clone());
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(simple(stream, count.clone(), seen.clone()));
        }
    });
    let client = ModbusClient::default();
    scattered(&client, port);
    until("a second connection", async || {
        connections.load(Ordering::Relaxed) > 1
    })
    .await;
    timeout(Duration::from_secs(10), all_values_are_right(&client))
        .await
        .unwrap();
    sleep(Duration::from_millis(300)).await;
    assert_eq!(connections.load(Ordering::Relaxed), 2);
    assert_eq!(most.load(Ordering::Relaxed), 1);
    assert_eq!(client.error_codes("s0").unwrap(), [0, 0]);
}
