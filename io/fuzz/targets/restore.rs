#![no_main]

use fissure_fuzz::restore::Base;

thread_local!(static BASE: Base = Base::new());

libfuzzer_sys::fuzz_target!(init: BASE.with(|_| ()), |data: &[u8]| BASE.with(|base| base.lie(data)));
