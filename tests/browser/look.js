// Finds faults of the layout: overflowing words, small targets, words under the frame, covered or cut STOP.
() => {
  const wrong = [], visible = e => e.checkVisibility({ checkOpacity: false, checkVisibilityCSS: true }) && !e.closest('.unseen, noscript');
  const scrolled = e => { for (let at = e; at; at = at.parentElement) if (['auto', 'scroll'].includes(getComputedStyle(at).overflowY)) return at; return null; };
  const name = e => `${e.tagName.toLowerCase()}#${e.id}.${e.className} "${(e.textContent || '').slice(0, 30)}"`;
  const root = document.documentElement;
  if (root.scrollWidth > innerWidth || root.scrollHeight > innerHeight) wrong.push('the page itself scrolls');
  const pieces = [];
  // What is seen of a box: an element and its parents cut it where they scroll or hide.
  const seen = (from, box) => {
    let { left, right, top, bottom } = box;
    for (let at = from; at; at = at.parentElement) {
      if (getComputedStyle(at).overflowY === 'visible') continue;
      const cut = at.getBoundingClientRect();
      [left, right, top, bottom] = [Math.max(left, cut.left), Math.min(right, cut.right), Math.max(top, cut.top), Math.min(bottom, cut.bottom)];
    }
    return { left, right, top, bottom };
  };
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (words.nextNode()) {
    const text = words.currentNode, at = text.parentElement;
    if (!text.data.trim() || !visible(at) || ['OPTION', 'SCRIPT'].includes(at.tagName)) continue;
    if (parseFloat(getComputedStyle(at).fontSize) < 16) wrong.push(`under 16 px: ${name(at)}`);
    if (at.closest('.equal')) continue;
    const box = at.closest('button, li, td, th, select, #state, #alarm-line, section, form, header'), outer = box.getBoundingClientRect();
    const range = document.createRange();
    range.selectNodeContents(text);
    // A line of text is higher than its letters.
    for (const part of range.getClientRects()) {
      const { left, right, top, bottom } = part, edge = 0.2 * (bottom - top);
      pieces.push({ e: at, ...seen(at, { left, right, top: top + edge, bottom: bottom - edge }) });
    }
    for (const part of range.getClientRects()) {
      const scrolls = scrolled(at) !== null && box.contains(scrolled(at));
      const sideways = part.left < outer.left - 2 || part.right > outer.right + 2;
      const updown = part.top < outer.top - 3 || part.bottom > outer.bottom + 3;
      if (sideways || (updown && !scrolls)) { wrong.push(`text leaves its box: ${name(at)} in ${name(box)}`); break; }
    }
  }
  for (const e of document.querySelectorAll('button, select, input, textarea, a')) {
    if (!visible(e)) continue;
    const box = e.getBoundingClientRect(), { width, height } = box;
    pieces.push({ e, ...seen(e.parentElement, box) });
    if (width < 59.5 || height < 59.5) wrong.push(`target of ${width.toFixed(0)} x ${height.toFixed(0)}: ${name(e)}`);
  }
  const frame = parseFloat(getComputedStyle(document.body, '::after').borderTopWidth) || 0;
  for (const { e, left, right, top, bottom } of pieces)
    if (bottom > top && right > left && (left < frame || right > innerWidth - frame || top < frame)) wrong.push(`under the frame: ${name(e)}`);
  pieces.forEach((a, at) => pieces.slice(at + 1).forEach(b => {
    if (a.e.contains(b.e) || b.e.contains(a.e) || a.e.closest('section, form, header') !== b.e.closest('section, form, header')) return;
    const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left), high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (wide > 1 && high > 1) wrong.push(`${name(a.e)} over ${name(b.e)}`);
  }));
  const panels = [...document.querySelectorAll('#bar, #alarm, #answers, #hand, #map, #identification, #signals, #buttons, #stop-place')].filter(e => visible(e) && !e.closest('#details'));
  for (const a of panels) for (const b of panels) {
    if (a === b || scrolled(a.parentElement) || scrolled(b.parentElement)) continue;
    const p = a.getBoundingClientRect(), q = b.getBoundingClientRect();
    if (p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1) wrong.push(`${a.id} over ${b.id}`);
  }
  const stop = document.getElementById('stop');
  if (visible(stop)) {
    const box = stop.getBoundingClientRect();
    if (Math.max(box.width, box.height) < 188 || Math.min(box.width, box.height) < 112) wrong.push('STOP is small');
    if (box.right > innerWidth || box.bottom > innerHeight) wrong.push('STOP is cut');
    for (const [dx, dy] of [[0.5, 0.5], [0.1, 0.5], [0.9, 0.5], [0.5, 0.1], [0.5, 0.9]])
      if (!stop.contains(document.elementFromPoint(box.left + dx * box.width, box.top + dy * box.height))) wrong.push('STOP is covered');
  }
  return [...new Set(wrong)];
}
