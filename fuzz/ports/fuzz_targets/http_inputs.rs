//! The body of a request that sets inputs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motion_api::IoConfig;
use server::ports::http::io::read;

fuzz_target!(|data: &[u8]| {
    match read(data, &IoConfig::default()) {
        Ok(changes) => assert!(changes.points.len() <= 4 && changes.registers.len() <= 224),
        Err(error) => assert!(error.to_string().len() < data.len() + 600),
    }
});
