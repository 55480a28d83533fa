//! What an XML-RPC server answers.
#![no_main]

use io_bus::xmlrpc::codec::{decode_response, encode_call};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    if let Ok(Ok(value)) = decode_response(&text) {
        // What came in can go out again.
        let _ = encode_call("f", &[value]);
    }
});
