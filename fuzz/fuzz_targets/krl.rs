#![no_main]

mod reader;

use detune::program::Dialect;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    reader::run(Dialect::Krl, data);
});
