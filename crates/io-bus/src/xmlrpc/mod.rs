//! Remote calls over XML-RPC (manual 7.2): values as XML and back (`codec`), one server over HTTP (`client`).

mod client;
pub mod codec;

pub use client::{CALL_TIME, RpcClient, RpcError, RpcUrl};
pub use codec::{RpcFault, RpcValue};
