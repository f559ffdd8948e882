//! Memory that cannot be had ends the program in words. Without this the standard library aborts it, which looks like a
//! fault of the program.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    io::Write,
};

/// The system's allocator, but that it never fails.
pub struct EndingInWords;

// SAFETY: everything is passed to the system's allocator and back as it is.
unsafe impl GlobalAlloc for EndingInWords {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the rules of `alloc`, as in all that follow.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

fn given(pointer: *mut u8, size: usize) -> *mut u8 {
    if pointer.is_null() { end(size) } else { pointer }
}

/// Says it on standard error, which takes no memory, and ends the program: there is none to go on with.
#[cold]
fn end(size: usize) -> ! {
    let _ = writeln!(
        std::io::stderr(),
        "error: out of memory: {size} bytes more could not be had; a smaller grid, fewer points or fewer --threads need less. \
         What a run has kept is not lost: --resume goes on with it."
    );
    std::process::exit(crate::BAD_INPUT.into())
}
