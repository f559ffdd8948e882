// Asked of a page in every browser: check_pages.py and firefox.mjs read this file and call its functions in the page.
({
  // Texts and controls that must not lie over one another. Tables scroll in boxes of their own. Boxes may meet where what is in them
  // does not: `apart` may say so of two elements.
  overlaps: (apart = () => false) => {
    const seen = (element) => {
      const box = element.getBoundingClientRect();
      return element.checkVisibility({ visibilityProperty: true }) && box.width > 0 && box.height > 0;
    };
    const close = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1.5
      && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1.5;
    const groups = [[...document.querySelectorAll(
      'h1, h2, h3, h4, main p, dt, dd, figcaption, img, .panel svg, select, input, output, .controls span, button, .scroll, .plot, summary')]
      .filter((element) => !element.parentElement.closest('.scroll, .plot, .contents') && seen(element))];
    for (const plot of document.querySelectorAll('.plot')) {
      groups.push([...plot.querySelectorAll('.xtick text, .ytick text, .xtitle, .ytitle, .cbaxis text, .cbtitle text, .legendtext, .colorbar text')]
        .filter(seen));
    }
    const found = [];
    for (const group of groups) {
      const boxes = group.map((element) => element.getBoundingClientRect());
      for (let i = 0; i < group.length; i++) {
        for (let j = i + 1; j < group.length; j++) {
          const nested = group[i].contains(group[j]) || group[j].contains(group[i]);
          if (!nested && close(boxes[i], boxes[j]) && !apart(group[i], group[j])) {
            found.push([group[i], group[j]].map((e) => e.tagName + ' "' + (e.textContent || e.alt || '').replace(/\s+/g, ' ').trim().slice(0, 40) + '"').join(' over '));
          }
        }
      }
    }
    return found.slice(0, 10);
  },
  // Texts of too little contrast with what is behind them (WCAG 2.2, 1.4.3).
  contrasts: () => {
    const parse = (text) => (text.match(/[\d.]+/g) || []).map(Number);
    const light = (colour) => {
      const [r, g, b] = colour.slice(0, 3).map((c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; });
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const behind = (element) => {
      for (let e = element; e; e = e.parentElement) {
        const colour = parse(getComputedStyle(e).backgroundColor);
        if (colour.length === 3 || colour[3] === 1) return colour;
      }
      return [255, 255, 255];
    };
    const found = new Set();
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const element = walker.currentNode.parentElement;
      if (!walker.currentNode.textContent.trim() || ['SCRIPT', 'STYLE', 'NOSCRIPT', 'OPTION'].includes(element.tagName)) continue;
      const style = getComputedStyle(element);
      const inChart = element instanceof SVGElement;
      if (!element.checkVisibility({ visibilityProperty: true })) continue;
      if (inChart && style.textShadow !== 'none') continue;
      const ink = parse(inChart ? style.fill : style.color);
      const [a, b] = [light(ink), light(behind(element))].sort((x, y) => y - x);
      const ratio = (a + 0.05) / (b + 0.05);
      const size = parseFloat(style.fontSize);
      const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
      if (ratio < (large ? 3 : 4.5)) found.add(ratio.toFixed(2) + ' "' + walker.currentNode.textContent.trim().slice(0, 40) + '"');
    }
    return [...found].slice(0, 10);
  },
  unnamed: () => [...document.querySelectorAll('select, input, button, img, a, [role=img], [role=region]')].filter((e) => {
    const labelled = e.getAttribute('aria-labelledby');
    const name = e.getAttribute('aria-label') || e.alt || (labelled && document.getElementById(labelled)?.textContent)
      || e.closest('label')?.textContent || e.textContent;
    return !name || !name.trim();
  }).map((e) => e.outerHTML.slice(0, 80)),
  // Elements that are wider than the page, but for what scrolls or is clipped in a box of its own.
  wide: () => {
    const width = document.documentElement.clientWidth;
    const found = [];
    for (const e of document.querySelectorAll('body *')) {
      if (e.closest('#js-plotly-tester')) continue;
      if (e.closest('.scroll, .plot, svg, .skip') && !e.matches('.scroll, .plot, svg') || !e.checkVisibility()) continue;
      const box = e.getBoundingClientRect();
      if (box.right > width + 1 || box.left < -1 && !e.matches('.skip')) found.push(e.tagName + '.' + e.className + ' to ' + Math.round(box.right) + ' px');
    }
    return found.slice(0, 5);
  },
  // Texts of a figure that lie over one another: those of images, laid out once in the page, and those drawn in it.
  figureTexts: async () => {
    const found = [];
    const check = (svg, name) => {
      const texts = [...svg.querySelectorAll('text')].filter((t) => t.textContent.trim());
      const boxes = texts.map((t) => t.getBoundingClientRect());
      for (let i = 0; i < texts.length; i++) for (let j = i + 1; j < texts.length; j++) {
        const [a, b] = [boxes[i], boxes[j]];
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        const least = (k) => 0.35 * Math.min(a[k], b[k]);
        if (across > Math.max(1.5, 0.1 * Math.min(a.width, b.width)) && down > Math.max(1.5, least('height')))
          found.push(name + ': "' + texts[i].textContent.slice(0, 30) + '" over "' + texts[j].textContent.slice(0, 30) + '"');
      }
    };
    document.querySelectorAll('.panel svg').forEach((svg) => check(svg, 'picture'));
    for (const image of document.querySelectorAll('img[src^="data:image/svg+xml;base64,"]')) {
      const bytes = Uint8Array.from(atob(image.src.split(',')[1]), (c) => c.charCodeAt(0));
      const holder = document.createElement('div');
      holder.style.cssText = 'position: absolute; left: 0; top: 0; width: 900px; visibility: hidden';
      const parsed = new DOMParser().parseFromString(new TextDecoder().decode(bytes), 'image/svg+xml').documentElement;
      parsed.querySelectorAll('script').forEach((script) => script.remove());
      holder.append(document.importNode(parsed, true));
      document.body.append(holder);
      check(holder, 'figure ' + image.alt.slice(0, 40));
      holder.remove();
    }
    return found.slice(0, 10);
  },
  // The headline and its numbers; of a page without them, the first paragraph of the answer.
  answer: () => {
    const parts = [...document.querySelectorAll('.answer > h1, .first h1, .numbers > .number .value')].map((e) => e.textContent);
    const paragraph = document.querySelector('.answer p')?.textContent;
    return parts.length ? parts : paragraph ? [paragraph] : [];
  },
  overflow: () => [document.documentElement.scrollWidth, window.innerWidth],
  settled: () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 120)))),
})
