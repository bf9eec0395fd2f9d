//! Runs the examples.

#[path = "../examples/asynchronous.rs"]
mod asynchronous;
#[path = "../examples/blocking.rs"]
mod blocking;

#[test]
fn blocking_example() {
    blocking::main();
}

#[test]
fn async_example() {
    asynchronous::main();
}
