//! Two mirrors, of the rows and of the columns: values in four places that are mirror images of each other, as their four sums and
//! differences.
//!
//! Number m of four images mirrors the columns if its bit 0 is set, and the rows if its bit 1 is. Sum s changes its sign with the columns'
//! mirror if its bit 0 is set, and with the rows' if its bit 1 is. So an image of a pin has the pin's own sums, up to their signs. In the
//! products of a pin with itself, added over images, the sums s and t of the sensors meet with the weight s ^ t of those images: all
//! four images together have only the four blocks on the diagonal.

/// Images, and sums.
pub(crate) const FOUR: usize = 4;

/// One value for each sensor of 4 x 4, by sum and by place in the first quarter of the array.
pub(crate) type Sums = [[f32; FOUR]; FOUR];

/// A symmetric matrix of the sums: its blocks on and below the diagonal, row by row.
pub(crate) type Blocks = [Sums; FOUR * (FOUR + 1) / 2];

/// Sums and differences of four images. Twice gives four times the images.
pub(crate) fn sums<T>([a, b, c, d]: [T; FOUR]) -> [T; FOUR]
where
    T: Copy + core::ops::Add<Output = T> + core::ops::Sub<Output = T>,
{
    let (ab, cd, a_b, c_d) = (a + b, c + d, a - b, c - d);
    [ab + cd, a_b + c_d, ab - cd, a_b - c_d]
}

/// Values of 4 x 4 sensors, row by row, by their sums.
pub(crate) fn by_sums(sensors: &Sums) -> Sums {
    let mut by_sums = Sums::default();
    for place in 0..FOUR {
        let (row, column) = (place / 2, place % 2);
        let images = [[row, column], [row, 3 - column], [3 - row, column], [3 - row, 3 - column]];
        let sums = sums(images.map(|[row, column]| sensors[row][column]));
        by_sums.iter_mut().zip(sums).for_each(|(by_sum, sum)| by_sum[place] = sum);
    }
    by_sums
}

/// The same with rows and columns of the array exchanged.
pub(crate) fn transposed(of: &Sums) -> Sums {
    const OTHER: [usize; FOUR] = [0, 2, 1, 3];
    OTHER.map(|sum| OTHER.map(|place| of[sum][place]))
}

/// Adds the products of some images of a pin with themselves; `weights` are the sums of how often each counts. Gives the number of
/// multiplications.
pub(crate) fn add(matrix: &mut Blocks, pin: &Sums, weights: &[f32; FOUR]) -> u32 {
    let (mut blocks, mut multiply_adds) = (matrix.iter_mut(), 0);
    for (s, left) in pin.iter().enumerate() {
        for ((t, right), block) in pin.iter().enumerate().take(s + 1).zip(&mut blocks) {
            let weight = weights[(s ^ t) % FOUR];
            if weight == 0.0 {
                continue;
            }
            for (line, value) in block.iter_mut().zip(left) {
                let value = weight * value;
                line.iter_mut().zip(right).for_each(|(element, other)| *element += value * other);
            }
            multiply_adds += (FOUR * FOUR) as u32;
        }
    }
    multiply_adds
}

/// The matrix as [`packed`](crate::packed) has it.
pub(crate) fn pack(matrix: &Blocks, packed: &mut [f32]) {
    let (mut blocks, mut rest) = (&matrix[..], packed);
    for s in 0..FOUR {
        let Some((row, below)) = blocks.split_at_checked(s + 1) else { return };
        blocks = below;
        for place in 0..FOUR {
            let Some((line, below)) = rest.split_at_mut_checked(FOUR * s + place + 1) else { return };
            rest = below;
            for (values, block) in line.chunks_mut(FOUR).zip(row) {
                values.iter_mut().zip(&block[place]).for_each(|(value, element)| *value = *element);
            }
        }
    }
}
