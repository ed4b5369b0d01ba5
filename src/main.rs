//! The program: hands the stages of a run to the command line and its exit code to the system.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

use floodsim::cli::{self, Stages};
use floodsim::pipeline::out_of_memory;

/// The allocator of the system, but for its end: where there is no more memory, the program says so and leaves with the exit code of a limit.
struct OrLeave;

#[global_allocator]
static ALLOCATOR: OrLeave = OrLeave;

#[expect(unsafe_code, reason = "the trait of allocators is unsafe; each function hands its arguments on as they are")]
// SAFETY: everything is done by the allocator of the system.
unsafe impl GlobalAlloc for OrLeave {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        given(unsafe { System.realloc(old, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Memory of so many bytes, if the system gave it.
fn given(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        out_of_memory(bytes)
    }
    memory
}

fn main() {
    let stages = Stages {
        prepare: floodsim::pipeline::check,
        plan: floodsim::pipeline::plan,
        run: |scenario, options| floodsim::pipeline::run(scenario, options).map(|summary| summary.to_string()),
        resume: |options| floodsim::pipeline::resume(options).map(|summary| summary.to_string()),
    };
    let code = cli::main(&stages);
    // All is written and closed. What the libraries do at an exit would meet the files that could not be closed, and crash.
    let _ = std::io::stdout().flush();
    signal_hook::low_level::exit(code as i32)
}
