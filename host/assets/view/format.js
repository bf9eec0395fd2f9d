// Formats numbers and words for display.

export const PHASES = {
  unknown: "not known yet",
  idle: "no contact",
  held: "touched",
  sliding: "sliding",
  held_after: "held after the slide",
};

export const words = (name) => name.replaceAll("_", " ");

// Adds the frequency and its uncertainty to an estimate, under the names that plots use.
export const charted = (estimate) => ({
  ...estimate,
  frequency: estimate.frequency_hz ?? null,
  sigma: estimate.sigma_hz ?? null,
});

// Formats the uncertainty with two digits, and the value with as many decimals.
export function withSigma(value, sigma, unit) {
  if (!(sigma > 0)) return `${Number(value.toPrecision(6))} ${unit}`;
  const decimals = Math.min(7, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
  return `${value.toFixed(decimals)} ± ${sigma.toFixed(decimals)} ${unit}`;
}

export const seconds = (t_s) => `${t_s.toFixed(2)} s`;

// Rounds `min` up to 1, 2 or 5 times a power of ten.
export function round125(min) {
  const power = 10 ** Math.floor(Math.log10(min));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= min * 0.999);
}

// Formats the frequency of a fit with its uncertainty, by time or by position.
export function tone(fit) {
  if (!fit) return "no fit";
  const [value, sigma, unit] = fit.domain === "position" ? [fit.frequency_per_mm, fit.sigma_per_mm, "/mm"] : [fit.frequency_hz, fit.sigma_hz, "Hz"];
  return (value ?? null) === null ? "no tone" : withSigma(value, sigma, unit);
}
