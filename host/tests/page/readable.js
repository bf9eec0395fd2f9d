// Lists unreadable text on the page: too little contrast, or sticking out of its card.
(() => {
  const light = (colour) => {
    const part = (v) => ((v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    const [r, g, b] = colour.match(/[\d.]+/g).map(Number).map(part);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const under = (element) => {
    const own = getComputedStyle(element).backgroundColor;
    return own === "rgba(0, 0, 0, 0)" && element.parentElement ? under(element.parentElement) : own;
  };
  const wrong = [];
  for (const element of document.querySelectorAll("body *")) {
    const says = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim() !== "");
    const box = element.getBoundingClientRect();
    if (!says || box.width === 0 || element.tagName === "OPTION") continue;
    // Contrast of two colours as defined in WCAG 2.
    const [low, high] = [light(getComputedStyle(element).color), light(under(element))].sort((a, b) => a - b);
    const contrast = (high + 0.05) / (low + 0.05);
    const name = `${element.tagName} ${element.id} ${element.textContent.slice(0, 40)}`;
    if (contrast < 4.5) wrong.push(`contrast ${contrast.toFixed(1)}: ${name}`);
    const card = element.closest(".card, .tile");
    if (card && (box.right > card.getBoundingClientRect().right + 1 || element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 0)) {
      wrong.push(`sticks out: ${name}`);
    }
  }
  return wrong;
})()
