use ridgetone_tone::*;
fn fit(values: &[f32], scene: &Scene) -> Fit {
    let mut frames = Frames::new(values, 16).unwrap();
    let n = frames.count();
    Fitter::new()
        .fit(
            &mut FrameSpan::new(&mut frames, 0, n).with_quantization(1.0),
            scene,
        )
        .unwrap()
}
#[test]
fn nan() {
    let mut bad = 0;
    for cycles in [2.2, 2.6, 3.0, 3.4, 4.2, 5.2] {
        for time in [0.05f64, 0.2, 0.5, 1.0, 3.0, 1000.0] {
            for swing in [1000.0] {
                for seed in 0..20 {
                    let seed = seed as f64;
                    let mut st = seed as u64 + 1;
                    let mut noise = move || {
                        let mut s = -6.0;
                        for _ in 0..12 {
                            st = st
                                .wrapping_mul(6364136223846793005)
                                .wrapping_add(1442695040888963407);
                            s += (st >> 40) as f64 / 16777216.0;
                        }
                        s
                    };
                    let v: Vec<f32> = (0..241 * 16)
                        .map(|i| {
                            let (n, c) = ((i / 16) as f64, (i % 16) as f64);
                            let t = n / 241.0;
                            (1000.0
                                * ((6.283185307 * cycles * t + 2.4 * c + 0.77 * seed).cos()
                                    + swing
                                        * (0.7 * c + seed).sin()
                                        * (((-t / time).exp() - (-1.0 / time).exp())
                                            / (1.0 - (-1.0 / time).exp()))
                                    + 0.07 * noise()))
                            .round() as f32
                        })
                        .collect();
                    let f = fit(&v, &Scene::DEFAULT);
                    if !f.frequency.is_finite() || !f.movement.wander.is_finite() {
                        bad += 1;
                        println!(
                            "{cycles} {time} {swing} {seed} {:?} {} {} {:?}",
                            f.status, f.frequency, f.sigma, f.tests
                        );
                    }
                }
            }
        }
    }
    assert_eq!(bad, 0);
}
