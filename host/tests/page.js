// Put into a copy of the page by page.rs: looks at what the browser made of it and writes that down as JSON.
(() => {
  const wrong = [];
  const say = (what, where) => wrong.push(`${what}: ${where.slice(0, 120)}`);
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const light = (colour) => {
    const part = (v) => ((v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    const [r, g, b] = numbers(colour).map(part);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  // WCAG 2: contrast of two colours.
  const contrast = (a, b) => {
    const [low, high] = [light(a), light(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const svgs = [...document.querySelectorAll("svg")];
  let texts = 0;
  for (const svg of svgs) {
    const name = svg.querySelector("title").textContent;
    const frame = svg.getBoundingClientRect();
    if (frame.width < 300 || frame.height < 100) say("no size", name);
    const card = getComputedStyle(svg.querySelector(".card")).fill;
    const boxes = [...svg.querySelectorAll("text")].map((text) => {
      const fill = getComputedStyle(text).fill;
      if (contrast(fill, card) < 4.5) say(`contrast ${contrast(fill, card).toFixed(1)} of ${fill}`, text.textContent);
      return { text: text.textContent, box: text.getBoundingClientRect() };
    });
    texts += boxes.length;
    boxes.forEach((a, n) => {
      const b = a.box;
      if (b.width === 0) say("no width", `${name}, ${a.text}`);
      if (b.left < frame.left || b.right > frame.right || b.top < frame.top || b.bottom > frame.bottom) {
        say("sticks out", `${name}, ${a.text}`);
      }
      for (const other of boxes.slice(n + 1)) {
        const c = other.box;
        // Boxes are as high as the font's highest letters: a pixel of them is air.
        const across = Math.min(b.right, c.right) - Math.max(b.left, c.left);
        const down = Math.min(b.bottom, c.bottom) - Math.max(b.top, c.top);
        if (across > 0.5 && down > 1.5) say("overlap", `${name}, ${a.text} / ${other.text}`);
      }
    });
  }
  const page = getComputedStyle(document.body);
  if (contrast(page.color, page.backgroundColor) < 7) say("contrast", "the page's text");
  const wide = document.documentElement.scrollWidth;
  if (wide > window.innerWidth) say("wider than the window", `${wide} of ${window.innerWidth} pixels`);
  const loaded = performance.getEntriesByType("resource").map((entry) => entry.name);
  loaded.forEach((name) => say("loaded", name));
  const report = document.createElement("pre");
  report.id = "report";
  report.textContent = JSON.stringify({
    svgs: svgs.length,
    texts,
    tables: document.querySelectorAll("table").length,
    dark: matchMedia("(prefers-color-scheme: dark)").matches,
    width: window.innerWidth,
    wrong,
  });
  document.body.append(report);
})();
