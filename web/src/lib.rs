//! The engine of kinetostat as a WebAssembly module: questions and answers as JSON, see [`kinetostat::explore`].
//!
//! A page writes a question into memory that [`allocate`] gives it, calls [`call`], and reads the answer. The scene stays in the
//! module between calls. A fault of the program ends the module; [`fault`] then says in words what it was.

use std::{
    cell::RefCell,
    sync::{Mutex, PoisonError},
};

use kinetostat::explore::{self, Explorer};

thread_local! {
    static EXPLORER: RefCell<Option<Explorer>> = const { RefCell::new(None) };
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
}

static FAULT: Mutex<String> = Mutex::new(String::new());

/// Notes faults in words from here on.
#[unsafe(no_mangle)]
pub extern "C" fn start() {
    std::panic::set_hook(Box::new(|panic| *FAULT.lock().unwrap_or_else(PoisonError::into_inner) = panic.to_string()));
}

/// Memory for a question of `length` bytes, to be given to [`call`].
#[unsafe(no_mangle)]
pub extern "C" fn allocate(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; length].into_boxed_slice()).cast()
}

/// Answers the question of `length` bytes at `question`, whose memory is then free; the number of bytes of the answer, which
/// [`answer`] gives.
///
/// # Safety
/// `question` is what [`allocate`] gave for this length, and was not given here before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn call(question: *mut u8, length: usize) -> usize {
    // SAFETY: by the contract of this function it is the box that `allocate` made.
    let question = unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(question, length)) };
    let text = String::from_utf8_lossy(&question);
    let answer = EXPLORER.with_borrow_mut(|explorer| explore::call(explorer, &text));
    ANSWER.replace(answer);
    ANSWER.with_borrow(String::len)
}

/// The bytes of the last answer, until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// Makes what is known of a fault the last answer; the number of its bytes.
#[unsafe(no_mangle)]
pub extern "C" fn fault() -> usize {
    ANSWER.replace(FAULT.lock().unwrap_or_else(PoisonError::into_inner).clone());
    ANSWER.with_borrow(String::len)
}
