//! A hand goes to and fro over a texture that changes in the middle. Prints the voltage as a strip.
//!
//! `cargo run -p ridgetone-stimulus --example to_and_fro`

use ridgetone_stimulus::{Actuator, AmplitudeLaw, Encoder, Error, Stimulus, Texture};

fn main() -> Result<(), Error> {
    let mut stimulus = Stimulus::new(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)?;
    stimulus.set_texture(&Texture::new(2.0))?;
    stimulus.down();
    for n in 0..5000 {
        if n == 2500 {
            stimulus.set_texture(&Texture::new(1.4))?;
        }
        let t_s = f64::from(n) / 5000.0;
        let place_mm = 10.0 * libm::sin(core::f64::consts::TAU * t_s);
        let volts = stimulus.next((place_mm / 0.005) as i32);
        if n % 50 == 0 {
            println!(
                "{t_s:5.3} s {place_mm:+6.2} mm {volts:6.1} V {}*",
                " ".repeat((volts / 3.0) as usize)
            );
        }
    }
    Ok(())
}
