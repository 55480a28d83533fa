//! The target that `FUZZ_TARGET` names; `cargo dev targets` lists them.
#![no_main]

use std::sync::LazyLock;

use dev::targets::{Target, target};
use libfuzzer_sys::fuzz_target;

static TARGET: LazyLock<&'static Target> = LazyLock::new(|| {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    target(&name).unwrap_or_else(|| panic!("FUZZ_TARGET is {name:?}, which is no target; `cargo dev targets` \
        lists them"))
});

// What libFuzzer changes is the material of a generator, or the input itself; `shown` makes the input.
fuzz_target!(|data: &[u8]| (TARGET.check)(&(TARGET.render_input)(data)));
