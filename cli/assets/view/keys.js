// Keys, and the list of them.

import { SHAPES, colours } from './panel.js';

const byId = (id) => document.getElementById(id);

/** Listens to keys; `frame()` brings the bodies into view. */
export function keys(state, player, runs, { frame, particles }) {
  const shapes = SHAPES.filter(({ key }) => particles || key !== 'particles');
  const help = byId('help');
  const list = [
    [['space'], 'play or pause', [' '], () => (state.playing = !state.playing)],
    [['←', '→'], 'a frame back, on; with shift ten', [], () => {}],
    [['Home', 'End'], 'first, last frame', [], () => {}],
    [[`1 – ${colours(runs).length}`], `colour: ${colours(runs).map((c) => c.name.toLowerCase()).join(', ')}`, [], () => {}],
    [['D'], `draw: ${shapes.map((s) => s.name.toLowerCase()).join(', ')}`, ['d'], () => {
      const at = shapes.findIndex(({ key }) => key === state.shape);
      state.shape = shapes[(at + 1) % shapes.length].key;
    }],
    [['C'], 'crack faces on or off', ['c'], () => (state.cracks = !state.cracks)],
    [['K'], 'colliders on or off', ['k'], () => (state.colliders = !state.colliders)],
    [['G'], 'ground on or off', ['g'], () => (state.ground = !state.ground)],
    [['E'], 'explode, back together', ['e'], () => (state.explode = state.explode > 0 ? 0 : 0.5)],
    [['L'], 'begin again at the end', ['l'], () => (state.loop = !state.loop)],
    [['F'], 'bring all into view', ['f'], frame],
    [['Esc'], 'close the values', ['escape'], () => (state.picked = null)],
    [['?'], 'this list', ['?'], () => help.showModal()],
  ];
  for (const [names, text] of list) {
    const term = document.createElement('dt');
    term.append(...names.map((name) => Object.assign(document.createElement('kbd'), { textContent: name })));
    byId('keys').append(term, Object.assign(document.createElement('dd'), { textContent: text }));
  }
  byId('help-button').onclick = () => help.showModal();
  const moves = new Map([
    ['arrowleft', (far) => player.step(far ? -10 : -1)],
    ['arrowright', (far) => player.step(far ? 10 : 1)],
    ['home', () => player.go(0)],
    ['end', () => player.go(Infinity)],
  ]);
  const known = new Map(list.flatMap(([, , pressed, act]) => pressed.map((key) => [key, act])));
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    const key = event.key.toLowerCase();
    const { target } = event;
    // what has the focus keeps the keys that it understands
    const own = target.matches('input[type=range], input[type=radio], select') && (moves.has(key) || target.matches('select'));
    const pressed = key === ' ' && target.matches('button, input[type=checkbox], input[type=radio], select');
    if (own || pressed) return;
    const number = Number(key);
    const colour = number >= 1 ? colours(runs)[number - 1] : undefined;
    const act = moves.get(key) ?? known.get(key) ?? (colour && (() => (state.colour = colour.key)));
    if (!act) return;
    event.preventDefault();
    act(event.shiftKey);
  });
}
