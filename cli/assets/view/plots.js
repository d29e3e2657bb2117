// Small plots over time, with the cursor of the time that is shown; a click goes to that time.

import { plotsOf } from './series.js';
import { seconds } from './timeline.js';

const INKS = ['#e8916b', '#6bb3e8', '#8fd18a', '#d9a7e8', '#e8d06b', '#7fd6cf', '#e87b9a', '#a8b0bd', '#b59a7a'];
const [WIDTH, HEIGHT] = [1000, 260];
const svg = (name, attributes) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};
const html = (name, className, text = '') => Object.assign(document.createElement(name), { className, textContent: text });

export class Plots {
  #place;
  #go;
  #plots = [];
  #time = 0;

  /** In the element `place`; `go(time)` goes to a time. */
  constructor(place, go) {
    this.#place = place;
    this.#go = go;
  }

  /** Draws the tables of one run or two, the second dashed. */
  draw(tables) {
    this.#place.replaceChildren();
    const first = tables.find(Boolean);
    if (!first) {
      this.#place.append(html('p', 'quiet', 'Plots appear here when the run writes its series.'));
      this.#plots = [];
      return;
    }
    this.#plots = plotsOf(first).map((plot) => this.#plot(plot, tables.filter(Boolean)));
    this.at(this.#time);
  }

  /** Moves the cursor. */
  at(time) {
    this.#time = time;
    for (const plot of this.#plots) plot.at(time);
  }

  #plot({ title, unit, lines, whole }, tables) {
    const ends = [0, Math.max(...tables.map((t) => t.time.at(-1)), 1e-12)];
    const all = tables.flatMap((t) => lines.flatMap((name) => t[name] ?? [])).filter(Number.isFinite);
    const [low, high] = [Math.min(0, ...all), Math.max(...all, 0) || 1];
    const x = (time) => ((time - ends[0]) / (ends[1] - ends[0])) * WIDTH;
    const y = (value) => HEIGHT - 8 - ((value - low) / (high - low)) * (HEIGHT - 16);
    const picture = svg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: 'none', role: 'img' });
    picture.append(svg('line', { class: 'zero', x1: 0, x2: WIDTH, y1: y(0), y2: y(0) }));
    tables.forEach((table, which) => lines.forEach((name, k) => {
      if (!table[name]) return;
      const points = table.time.map((time, n) => [time, table[name][n]]).filter(([, v]) => Number.isFinite(v));
      const d = points.map(([t, v], n) => `${n ? 'L' : 'M'}${x(t).toFixed(1)} ${y(v).toFixed(1)}`).join('');
      picture.append(svg('path', { class: which ? 'second' : 'first', d, stroke: INKS[k % INKS.length] }));
    }));
    const cursor = svg('line', { class: 'cursor', y1: 0, y2: HEIGHT });
    picture.append(cursor);
    picture.onclick = ({ clientX }) => {
      const box = picture.getBoundingClientRect();
      this.#go(ends[0] + ((clientX - box.left) / box.width) * (ends[1] - ends[0]));
    };
    const head = html('h2', '', title);
    const numbers = html('div', 'numbers');
    const figure = html('figure', 'plot');
    figure.append(head, html('span', 'top', `${short(high, whole)}${unit && ` ${unit}`}`), picture, numbers);
    this.#place.append(figure);
    const at = (time) => {
      cursor.setAttribute('x1', x(time));
      cursor.setAttribute('x2', x(time));
      const told = tables.map((table) => lines.map((name) => valueAt(table, name, time)));
      numbers.replaceChildren(...lines.map((name, k) => {
        const item = html('span', 'number', lines.length > 1 ? `${name.replace(/^s_/, '')} ` : '');
        item.style.setProperty('--ink', INKS[k % INKS.length]);
        item.append(html('b', '', told.map((row) => short(row[k], whole)).join(' | ')));
        return item;
      }));
      const words = lines.map((name, k) => `${name} ${told.map((row) => short(row[k], whole)).join(' and ')}`);
      picture.setAttribute('aria-label', `${title} at ${seconds(time)}: ${words.join(', ')}${unit && ` ${unit}`}`);
    };
    return { at };
  }
}

/** The number of the row that is nearest before `time`. */
function valueAt(table, name, time) {
  let row = table.time.findLastIndex((t) => t <= time * (1 + 1e-9) + 1e-15);
  row = Math.max(row, 0);
  return table[name]?.[row];
}

/** A number in few signs. */
export function short(value, whole = false) {
  if (value === undefined || Number.isNaN(value)) return '–';
  if (whole) return Math.round(value).toLocaleString('en');
  if (value === 0) return '0';
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2).replace('e+', 'e') : String(Number(value.toPrecision(4)));
}
