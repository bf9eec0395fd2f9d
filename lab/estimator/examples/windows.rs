//! Fits windows of a binary file, for comparisons: of each its frames and channels as u32, a 1
//! where times precede each frame's values, and the values as f32, little endian.

use ridgetone_estimator::{Fitter, FrameSpan, Frames, Scene, Speed};
use std::io::Write;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let bytes = std::fs::read(arguments.next().ok_or("a file of windows")?)?;
    let mut scene = Scene::DEFAULT;
    for argument in arguments {
        match argument.as_str() {
            "may-move" => scene.speed = Speed::MayMove,
            "lean" => scene = Scene::LEAN,
            other => scene.harmonics = other.parse()?,
        }
    }
    let words: Vec<[u8; 4]> = bytes
        .chunks_exact(4)
        .map(|word| [word[0], word[1], word[2], word[3]])
        .collect();
    let mut out = std::io::stdout().lock();
    let mut fitter = Box::new(Fitter::new());
    let mut at = 0;
    while at + 3 <= words.len() {
        let [frames, channels, timed] =
            [0, 1, 2].map(|i| u32::from_le_bytes(words[at + i]) as usize);
        at += 3;
        let row = channels + timed;
        let all: Vec<f32> = words[at..at + frames * row]
            .iter()
            .map(|word| f32::from_le_bytes(*word))
            .collect();
        at += frames * row;
        let times: Vec<f32> = all.chunks_exact(row).map(|frame| frame[0]).collect();
        let values: Vec<f32> = all
            .chunks_exact(row)
            .flat_map(|frame| &frame[timed..])
            .copied()
            .collect();
        let mut source = Frames::new(&values, channels).ok_or("1 to 16 channels")?;
        let place = |frame: u32| times[frame as usize];
        let span = FrameSpan::new(&mut source, 0, frames as u32);
        let mut span = if timed == 1 {
            span.along(&place).ok_or("times that go on")?
        } else {
            span
        };
        let fit = fitter.fit(&mut span, &scene)?;
        let t = fit.tests;
        writeln!(
            out,
            "{:?} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}",
            fit.status,
            fit.frequency,
            fit.sigma,
            fit.harmonics,
            fit.with_tone,
            t.line,
            t.fundamental,
            t.other,
            t.between,
            t.beside,
            t.beside_share,
            t.unfollowed,
            t.fading,
            t.cycles,
            t.one_shape,
            t.steady,
            t.degree,
            t.degrees,
            t.lines
        )?;
    }
    Ok(())
}
