// The controls beside the scene.

import { COLOURS } from './colour.js';

const byId = (id) => document.getElementById(id);

export const SHAPES = [
  { key: 'surface', name: 'Surface' },
  { key: 'edges', name: 'Wireframe' },
  { key: 'particles', name: 'Particles' },
];

/** Makes a row of radio buttons for the setting `key`. */
function choice(state, key, place, options) {
  for (const option of options) {
    const label = document.createElement('label');
    const input = Object.assign(document.createElement('input'), { type: 'radio', name: key, value: option.key });
    input.onchange = () => (state[key] = option.key);
    label.append(input, Object.assign(document.createElement('span'), { textContent: option.name }));
    place.append(label);
  }
  const mark = () => {
    for (const input of place.querySelectorAll('input')) input.checked = input.value === state[key];
  };
  state.on([key], mark);
}

/** Colours there are for so many runs. */
export const colours = (runs) => COLOURS.filter((colour) => !colour.pair || runs > 1);

/** Connects the controls. */
export function panel(state, { runs, particles, colliders, ground }) {
  choice(state, 'colour', byId('colours'), colours(runs));
  choice(state, 'shape', byId('shapes'), particles ? SHAPES : SHAPES.slice(0, 2));
  for (const key of ['cracks', 'colliders', 'ground']) {
    byId(key).onchange = ({ target }) => (state[key] = target.checked);
    state.on([key], () => (byId(key).checked = state[key]));
  }
  byId('ground').parentElement.hidden = !ground;
  byId('colliders').parentElement.hidden = !colliders;
  const explode = byId('explode');
  explode.oninput = () => (state.explode = Number(explode.value) / 100);
  state.on(['explode'], () => {
    explode.value = Math.round(100 * state.explode);
    explode.style.setProperty('--done', state.explode / 2);
    byId('exploded').textContent = `${Math.round(100 * state.explode)} %`;
  });
}
