//! Two mirrors, of the rows and of the columns: values in four places that are mirror images of
//! each other, as their four sums and differences.
//!
//! Image m mirrors the columns if its bit 0 is set, and the rows if its bit 1 is. Sum s changes its
//! sign with the mirror of the columns if its bit 0 is set, and with that of the rows if its bit 1
//! is. So an image of a pin has the sums of the pin itself, up to their signs; and of the products
//! of some images with themselves, block s, t of their total is that of the pin times sum s ^ t of
//! how often each image counts. Of all four images only the blocks on the diagonal are left.

use crate::blocks::{Block, FOUR};
use core::ops::{Add, Sub};

/// Sums and differences of four images. Twice gives four times the images.
pub(crate) fn sums<T: Copy + Add<Output = T> + Sub<Output = T>>(
    [a, b, c, d]: [T; FOUR],
) -> [T; FOUR] {
    [
        (a + b) + (c + d),
        (a - b) + (c - d),
        (a + b) - (c + d),
        (a - b) - (c - d),
    ]
}

/// Values of 4 x 4 sensors, row by row, as sums: a row for each sum, with the four places of the
/// first quarter of the array.
pub(crate) fn by_sums([first, second, third, fourth]: &Block) -> Block {
    let halves = |[a, b, c, d]: &[f32; FOUR], [e, f, g, h]: &[f32; FOUR]| {
        [sums([*a, *d, *e, *h]), sums([*b, *c, *f, *g])]
    };
    let ([a, b], [c, d]) = (halves(first, fourth), halves(second, third));
    let mut by_sums = Block::default();
    for (by_sum, (((a, b), c), d)) in by_sums.iter_mut().zip(a.into_iter().zip(b).zip(c).zip(d)) {
        *by_sum = [a, b, c, d];
    }
    by_sums
}

/// The sums if rows and columns of the array are exchanged.
pub(crate) fn transposed([a, b, c, d]: &Block) -> Block {
    [a, c, b, d].map(|[e, f, g, h]| [*e, *g, *f, *h])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_has_the_same_sums_up_to_signs() {
        let sensors: Block = core::array::from_fn(|row| {
            core::array::from_fn(|column| ((7 * row + column * column) % 11) as f32)
        });
        let own = by_sums(&sensors);
        for image in 0..FOUR {
            let (rows, columns) = (3 * (image >> 1), 3 * (image & 1));
            let mirrored: Block = core::array::from_fn(|row| {
                core::array::from_fn(|column| sensors[row ^ rows][column ^ columns])
            });
            for (s, (row, own)) in by_sums(&mirrored).iter().zip(own).enumerate() {
                let sign = if (s & image).count_ones() % 2 == 0 {
                    1.0
                } else {
                    -1.0
                };
                assert_eq!(*row, own.map(|value| sign * value), "{image} {s}");
            }
        }
        let exchanged: Block =
            core::array::from_fn(|row| core::array::from_fn(|column| sensors[column][row]));
        assert_eq!(by_sums(&exchanged), transposed(&own));
        assert_eq!(sums(sums([1, 2, 3, 5])), [4, 8, 12, 20]);
    }
}
