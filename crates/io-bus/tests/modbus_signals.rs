//! The Modbus client against devices that take several requests at once, and such that do not.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
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

/// Answers while `answers` says so; otherwise takes what comes and is silent.
async fn moody(mut stream: TcpStream, answers: Arc<AtomicBool>) {
    let mut request = [0; 12];
    while stream.read_exact(&mut request).await.is_ok() {
        if answers.load(Ordering::Relaxed) {
            stream.write_all(&answer(&request)).await.unwrap();
        }
    }
}

/// Manual 6.1.10, 6.1.15, 6.1.16.
#[tokio::test]
async fn a_device_that_takes_connections_and_answers_nothing_is_invalid_until_a_good_answer() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let answers = Arc::new(AtomicBool::new(true));
    let connections = Arc::new(AtomicUsize::new(0));
    let device = {
        let (answers, connections) = (answers.clone(), connections.clone());
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                connections.fetch_add(1, Ordering::Relaxed);
                tokio::spawn(moody(stream, answers.clone()));
            }
        })
    };
    let client = ModbusClient::default();
    let spec = |slave| SignalSpec {
        device: DeviceAddress {
            host: "127.0.0.1".to_owned(),
            port,
        },
        slave,
        address: 7,
        count: 1,
        kind: SignalKind::RegisterInput,
        is_sequential: false,
    };
    client.add("a", spec(1)).unwrap();
    client
        .set_watchdog("a", Duration::from_millis(1500))
        .unwrap();
    assert_eq!(client.status("a").await.unwrap().0, [7]);
    assert_eq!(client.time_since_invalid("a").unwrap(), Duration::ZERO);
    assert_eq!(client.error_codes("a").unwrap(), [0, 0]);

    answers.store(false, Ordering::Relaxed);
    let age = || client.time_since_invalid("a").unwrap();
    until("the signal is invalid", async || !age().is_zero()).await;
    // From here on it grows, over several connections, and reading raises once the watchdog has run out.
    let (begun, before) = (connections.load(Ordering::Relaxed), age());
    assert!(
        before >= Duration::from_millis(900),
        "since the last good answer: {before:?}"
    );
    let mut last = before;
    while connections.load(Ordering::Relaxed) < begun + 3 {
        let now = age();
        assert!(now >= last, "{now:?} after {last:?}");
        assert_ne!(client.error_codes("a").unwrap(), [0, 0]);
        last = now;
        sleep(Duration::from_millis(5)).await;
    }
    let raised = client.status("a").await.unwrap_err();
    assert!(
        raised.to_string().contains("no good answer for"),
        "{raised}"
    );

    answers.store(true, Ordering::Relaxed);
    until("a good answer", async || age().is_zero()).await;
    assert_eq!(client.error_codes("a").unwrap(), [0, 0]);
    assert_eq!(client.status("a").await.unwrap().0, [7]);
    device.abort();
}
