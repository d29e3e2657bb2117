#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fissure_fuzz::mesh("msh", data));
