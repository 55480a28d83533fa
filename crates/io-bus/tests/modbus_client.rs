//! The Modbus server as a PLC sees it: over real sockets, with an independent client.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::net::SocketAddr;
use std::sync::Arc;

use io_bus::modbus_server::{self, tables::Store};
use tokio::net::TcpListener;
use tokio_modbus::client::{Client, Context, Reader, Writer, tcp};
use tokio_modbus::{ExceptionCode, Request, Slave};

async fn server() -> (SocketAddr, Arc<Store>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let store = Arc::new(Store::default());
    let shared = Arc::clone(&store);
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            let store = Arc::clone(&shared);
            tokio::spawn(async move { modbus_server::serve(stream, &*store).await });
        }
    });
    (address, store)
}

async fn client(address: SocketAddr) -> Context {
    tcp::connect_slave(address, Slave(255)).await.unwrap()
}

#[tokio::test]
async fn a_client_reads_what_is_there_and_writes_it() {
    let (address, store) = server().await;
    let mut plc = client(address).await;

    store.values().coils[127] = true;
    store.values().registers[0] = 65534;
    assert_eq!(
        plc.read_coils(126, 2).await.unwrap().unwrap()[..2],
        [false, true]
    );
    assert_eq!(
        plc.read_holding_registers(0, 2).await.unwrap().unwrap(),
        [65534, 0]
    );

    plc.write_single_coil(3, true).await.unwrap().unwrap();
    plc.write_multiple_coils(10, &[true, false, true])
        .await
        .unwrap()
        .unwrap();
    plc.write_single_register(255, 500).await.unwrap().unwrap();
    plc.write_multiple_registers(20, &[1, 2, 3])
        .await
        .unwrap()
        .unwrap();
    plc.masked_write_register(22, 0, 0x00FF)
        .await
        .unwrap()
        .unwrap();
    let both = plc
        .read_write_multiple_registers(20, 3, 21, &[7])
        .await
        .unwrap()
        .unwrap();
    assert_eq!(both, [1, 7, 255]);
    assert_eq!(
        [3, 10, 11, 12].map(|n| store.values().coils[n]),
        [true, true, false, true]
    );
    assert_eq!(store.values().registers[255], 500);
}

#[tokio::test]
async fn values_outlive_a_client_and_are_shared_by_all() {
    let (address, _store) = server().await;
    let mut first = client(address).await;
    first.write_single_register(9, 9).await.unwrap().unwrap();
    first.disconnect().await.unwrap();
    for _ in 0..8 {
        let mut other = client(address).await;
        assert_eq!(
            other.read_holding_registers(9, 1).await.unwrap().unwrap(),
            [9]
        );
    }
}

#[tokio::test]
async fn what_is_wrong_has_its_exception_and_the_connection_lives_on() {
    let (address, _store) = server().await;
    let mut plc = client(address).await;
    let exception = |reply: tokio_modbus::Result<_>| reply.unwrap().err();
    let (outside, count) = (
        Some(ExceptionCode::IllegalDataAddress),
        Some(ExceptionCode::IllegalDataValue),
    );
    assert_eq!(
        exception(plc.read_coils(128, 1).await.map(|r| r.map(|_| ()))),
        outside
    );
    assert_eq!(
        exception(
            plc.read_holding_registers(250, 7)
                .await
                .map(|r| r.map(|_| ()))
        ),
        outside
    );
    assert_eq!(exception(plc.write_single_register(1000, 1).await), outside);
    assert_eq!(
        exception(plc.read_coils(0, 0).await.map(|r| r.map(|_| ()))),
        count
    );
    assert_eq!(
        exception(
            plc.read_holding_registers(0, 126)
                .await
                .map(|r| r.map(|_| ()))
        ),
        count
    );
    let unknown = plc.call(Request::Custom(0x41, (&[1, 2, 3]).into())).await;
    assert_eq!(
        exception(unknown.map(|r| r.map(|_| ()))),
        Some(ExceptionCode::IllegalFunction)
    );
    assert_eq!(plc.read_coils(0, 1).await.unwrap().unwrap()[..1], [false]);
}
