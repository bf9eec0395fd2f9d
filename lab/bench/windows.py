"""Writes windows.bin, the windows that the bench image holds: 940 frames of a pure tone, then 940 of one with overtones.

A grating of 3.6 mm at 30 mm/s, 16 channels of different amplitude and phase, read one after the other; white noise 20 dB below the tone; whole codes. Shorter windows are the first frames of these."""

import pathlib

import numpy as np

RATE_HZ, FRAMES, CHANNELS = 241.14, 940, 16
FREQUENCY_HZ, SKEW_S, CODES, SNR_DB = 30 / 3.6, 197.5e-6, 100.0, 20.0


def window(rng, overtones):
    amplitude = CODES * np.tile([6.0, 2.4, -5.2, 1.9], 4) * rng.uniform(0.8, 1.2, CHANNELS)
    phase = rng.uniform(0, 2 * np.pi) + rng.uniform(-0.6, 0.6, CHANNELS)
    t = np.arange(FRAMES)[:, None] / RATE_HZ + np.arange(CHANNELS) * SKEW_S
    x = amplitude * np.cos(2 * np.pi * FREQUENCY_HZ * t + phase)
    for k, ratio in overtones:
        shift = k * phase + rng.uniform(0, 2 * np.pi, CHANNELS)
        x += ratio * amplitude * np.cos(2 * np.pi * k * FREQUENCY_HZ * t + shift)
    noise = np.sqrt(np.mean(amplitude**2) / 2) * 10 ** (-SNR_DB / 20)
    return x + noise * rng.standard_normal(x.shape) + rng.uniform(-2000, 2000, CHANNELS)


if __name__ == "__main__":
    rng = np.random.default_rng(1)
    windows = [window(rng, overtones) for overtones in ([], [(2, 0.4), (3, 0.2), (4, 0.1)])]
    path = pathlib.Path(__file__).with_name("windows.bin")
    path.write_bytes(np.round(windows).astype("<f4").tobytes())
