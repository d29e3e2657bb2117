// The values of the vertex or particle that was clicked, which is followed through time by its id.

import { short } from './plots.js';

const html = (name, text = '') => Object.assign(document.createElement(name), { textContent: text });

/** Tells `chosen(index, ray)` of clicks on the canvas that are no drags. */
export function clicks(canvas, stage, chosen) {
  let start;
  canvas.addEventListener('pointerdown', (event) => {
    start = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : undefined;
  });
  canvas.addEventListener('pointerup', (event) => {
    if (!start || Math.hypot(event.clientX - start[0], event.clientY - start[1]) > 4) return;
    const ray = stage.ray(event.clientX, event.clientY);
    if (ray) chosen(ray.index, ray.raycaster);
  });
}

/** The vertex of `frame` with this id; of several copies the one of that piece, then side, then the first. */
export function find(frame, { id, piece, inside, body }) {
  const { columns } = frame;
  let [best, score] = [-1, -1];
  for (let v = 0; v < columns.id.length; v++) {
    if (columns.id[v] !== id || columns.body?.[v] !== body) continue;
    const fits = 2 * (columns.piece[v] === piece) + ((columns.inside?.[v] ?? 0) === inside);
    if (fits > score) [best, score] = [v, fits];
  }
  return best;
}

/** What to remember of a vertex. */
export const chosen = ({ columns }, vertex) => ({
  id: columns.id[vertex],
  piece: columns.piece[vertex],
  inside: columns.inside?.[vertex] ?? 0,
  body: columns.body?.[vertex],
});

/** Shows the values of a vertex in `card`; `extra` are further rows of name and text. */
export function tell(card, frame, vertex, what, extra, close) {
  card.hidden = vertex < 0;
  if (vertex < 0) return;
  const { columns } = frame;
  const vector = (values) => [0, 1, 2].map((k) => short(values[3 * vertex + k]));
  const speed = Math.hypot(...[0, 1, 2].map((k) => columns.velocity[3 * vertex + k]));
  const rows = [
    ['position', `${vector(columns.position).join(', ')} m`],
    ['velocity', `${vector(columns.velocity).join(', ')} m/s`],
    ['speed', `${short(speed)} m/s`],
    ['damage', short(columns.damage[vertex])],
    ...(columns.stretch ? [['stretch', short(columns.stretch[vertex])]] : []),
    ['piece', String(columns.piece[vertex])],
  ];
  if (columns.inside) rows.push(['side', columns.inside[vertex] ? 'crack face' : 'outer surface']);
  if (columns.mass) rows.push(['mass', `${short(columns.mass[vertex])} kg`]);
  const list = html('dl');
  for (const [name, text] of [...rows, ...extra]) list.append(html('dt', name), html('dd', text));
  const button = Object.assign(html('button', '×'), { type: 'button', className: 'round', onclick: close });
  button.setAttribute('aria-label', 'Close the values');
  card.replaceChildren(html('h2', `${what} ${columns.id[vertex]}`), button, list);
}
