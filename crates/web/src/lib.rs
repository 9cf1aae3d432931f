//! The answers of the page as WebAssembly: three functions that `worker.js` of `slipmap-explore` calls, and no other
//! interface. A request is written where [`room`] says, [`ask`] returns its status, and [`answer`] says where its answer is.
//! A panic ends the instance.

#![allow(unsafe_code)] // names of functions, which no other code that is linked may have

use std::cell::RefCell;
use std::sync::atomic::AtomicBool;

thread_local! {
    /// The request, and then its answer: a worker has one at a time.
    static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Where a request of `length` bytes is to be written: its path, a line feed, its body.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    TEXT.with_borrow_mut(|text| {
        *text = vec![0; length];
        text.as_mut_ptr()
    })
}

/// Answers the request, and returns the status of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> u32 {
    // The browser ends the worker of an answer that nobody waits for.
    static NEVER: AtomicBool = AtomicBool::new(false);
    TEXT.with_borrow_mut(|text| {
        let (path, body) = match text.iter().position(|&byte| byte == b'\n') {
            Some(end) => (&text[..end], &text[end + 1..]),
            None => (&text[..], &[][..]),
        };
        let (status, answer) = slipmap_explore::ask(&String::from_utf8_lossy(path), body, &NEVER);
        *text = answer;
        u32::from(status)
    })
}

/// Where the answer is, in the lower half, and its length in bytes, in the upper.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> u64 {
    TEXT.with_borrow(|text| (text.len() as u64) << 32 | text.as_ptr() as u64)
}
