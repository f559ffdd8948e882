//! Cutting and engaging allocate nothing once room is made.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use kinetostat_removal::{Cutter, Engagement, Field, Slicing, Stock};
use nalgebra::Vector3;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: passes all calls on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn moves_allocate_nothing() {
    let stock = Stock::cuboid(Vector3::new(-20.0, -20.0, -10.0), Vector3::new(20.0, 20.0, 0.0)).unwrap();
    let cutter = Cutter::bull(10.0, 2.0).unwrap();
    let at = |number: u32| {
        let angle = 0.03 * f64::from(number);
        Vector3::new(8.0 * angle.cos(), 8.0 * angle.sin(), -0.01 * f64::from(number))
    };
    let mut engagement = Engagement::default();
    let mut run = || {
        let mut field = Field::new(stock.clone(), 0.25).unwrap();
        field.reserve(400);
        field.cut(&cutter, &at(1), &at(1), 0).unwrap();
        let before = ALLOCATIONS.with(Cell::get);
        for number in 0..300 {
            let (from, to) = (at(number), at(number + 1));
            field.engage(&cutter, &(0.5 * (from + to)), &(to - from), &Slicing::default(), &mut engagement).unwrap();
            field.cut(&cutter, &from, &to, number).unwrap();
        }
        ALLOCATIONS.with(Cell::get) - before
    };
    // The first run makes the buffers of the engagement as large as they need to be.
    assert!(run() > 0);
    assert_eq!(run(), 0);
}
