//! Memory to allocate from, for the one baseline that allocates.

// The allocator is given its memory by address.
#![allow(unsafe_code)]

use core::ptr::addr_of_mut;
use embedded_alloc::LlffHeap;

/// Bytes: a matrix of 2 x 241 rows and 7 columns, six vectors of as many rows, and small ones.
const BYTES: usize = 40 * 1024;

#[global_allocator]
static HEAP: LlffHeap = LlffHeap::empty();

/// Gives the allocator its memory. Once, before anything allocates.
pub fn start() {
    static mut MEMORY: [u8; BYTES] = [0; BYTES];
    // SAFETY: the memory is this function's alone, and it is called once.
    unsafe { HEAP.init(addr_of_mut!(MEMORY) as usize, BYTES) }
}
