//! Stress and strain in an elastic half space under a force at a point of its surface: pins in rows
//! and columns. Compression is positive.
//!
//! Boussinesq's solution: Johnson, *Contact Mechanics*, section 3.2, equation 3.18. Values are per
//! newton; strain is times Young's modulus, so both are per square millimetre. Depths are in
//! millimetres, and above 0.
//!
//! The paper's thin slices give way across, and a half space cannot. Under a wide even pressure rubber
//! (Poisson's ratio 0.5) in a half space is not strained at all, and a slice is strained as by half
//! of the pressure. [`strain`] is that of the half space, [`slice_strain`] that of the slices.

use std::f32::consts::PI;

/// Normal stress along z, `r_mm` beside a force of 1 N and `z_mm` deep.
pub fn stress(r_mm: f32, z_mm: f32) -> f32 {
    let r2 = r_mm * r_mm + z_mm * z_mm;
    1.5 / PI * z_mm * z_mm * z_mm / (r2 * r2 * r2.sqrt())
}

/// Normal strain along z times Young's modulus as the paper's slices (plane stress) have it: that of
/// a line load is [`half_plane::normal`]'s, and an even pressure strains by 1 - poisson of it.
///
/// Along a line load a half space is in plane strain, and plane strain with Poisson's ratio
/// v / (1 + v) is plane stress with v, if Young's modulus is (1 + 2 v) / (1 + v)^2 as large.
///
/// [`half_plane::normal`]: crate::display::half_plane::normal
pub fn slice_strain(r_mm: f32, z_mm: f32, poisson: f32) -> f32 {
    let one_more = 1.0 + poisson;
    let modulus = (one_more + poisson) / (one_more * one_more);
    strain(r_mm, z_mm, poisson / one_more) / modulus
}

/// Normal strain along z times Young's modulus. Its sum over the plane is 1 - poisson - 2 poisson^2
/// times the force, which for rubber (0.5) is none: a wide even pressure does not compress it.
pub fn strain(r_mm: f32, z_mm: f32, poisson: f32) -> f32 {
    let (square, depth) = (r_mm * r_mm, z_mm * z_mm);
    // The stress along z less Poisson's share of the two across, radial and around; with r^2 = R^2
    // - z^2 their sum has two terms.
    let root = (square + depth).sqrt().recip();
    let share = root * root;
    let scale = 0.5 / PI * (1.0 + poisson) * z_mm;
    scale * (share * root) * (3.0 * depth * share - 2.0 * poisson)
}
