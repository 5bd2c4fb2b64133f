#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| stairscan_fuzz::targets::files::run(data));
