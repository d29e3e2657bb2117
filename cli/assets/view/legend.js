// What the colours mean.

import { COLOURS, stops } from './colour.js';
import { short } from './plots.js';

const html = (name, className, text = '') => Object.assign(document.createElement(name), { className, textContent: text });
const css = (srgb) => `rgb(${srgb.map((c) => Math.round(255 * c)).join(' ')})`;

/** Draws the legend of `mode`, whose scale ends at `top`; `note` is what else must be known. */
export function legend(place, mode, { look, top, note, pieces, grid }) {
  const { name, unit, signed } = COLOURS.find(({ key }) => key === mode);
  const parts = [html('h2', '', name)];
  if (unit !== undefined) {
    const bar = html('div', 'scale');
    bar.style.background = `linear-gradient(to right, ${stops(mode).join(', ')})`;
    const ends = html('div', 'ends');
    const inUnit = (x) => `${short(x)}${unit && ` ${unit}`}`;
    const [low, middle] = signed ? [`≤ −${short(top)}`, '0'] : ['0', short(top / 2)];
    const high = `${mode === 'damage' ? '' : '≥ '}${inUnit(top)}`;
    ends.append(...[low, middle, high].map((text) => html('span', '', text)));
    parts.push(bar, ends);
  } else if (mode === 'piece') {
    parts.push(html('p', '', `${pieces.toLocaleString('en')} ${pieces === 1 ? 'piece' : 'pieces'}, each its own colour`));
  } else {
    const [outside, crack] = mode === 'inside' ? ['rgb(92 97 105)', 'rgb(242 140 92)'] : [css(look.outside), css(look.crack)];
    parts.push(swatch(outside, 'outer surface'), swatch(crack, 'crack faces'));
  }
  if (note) parts.push(html('p', 'note', note));
  if (grid) parts.push(html('p', 'quiet', `lines on the ground: ${length(grid)} apart`));
  place.replaceChildren(...parts);
}

function swatch(colour, text) {
  const row = html('div', 'swatch', text);
  row.style.setProperty('--ink', colour);
  return row;
}

function length(metres) {
  if (metres >= 1) return `${short(metres)} m`;
  return metres >= 0.01 ? `${short(100 * metres)} cm` : `${short(1000 * metres)} mm`;
}
