//! The body of a request that sets inputs.

use motion_api::IoConfig;
use server::ports::http::io::read;

pub(super) fn judge(data: &[u8]) {
    match read(data, &IoConfig::default()) {
        Ok(changes) => assert!(changes.points.len() <= 4 && changes.registers.len() <= 224),
        Err(error) => assert!(error.to_string().len() < data.len() + 600),
    }
}
