//! Tests the decoder on a line that damages bytes. The fuzzer in `fuzz/` tests the same property;
//! here the seed is fixed.

#[path = "support/damage.rs"]
mod damage;

use damage::{Tried, try_line};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

#[test]
fn what_comes_through_is_read_and_nothing_else_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut all = Tried::default();
    for _ in 0..10_000 {
        let mut bytes = [0; 96];
        rng.fill_bytes(&mut bytes);
        let tried = try_line(&bytes);
        all.whole += tried.whole;
        all.damaged += tried.damaged;
        all.forged += tried.forged;
    }
    // Both outcomes must be frequent.
    assert!(all.whole > 80_000 && all.damaged > 80_000, "{all:?}");
    assert_eq!(all.forged, 0, "{all:?}");
}
