// Colours of vertices, as the pictures of `fissure render` have them. All in linear light.

const STOPS = {
  damage: [[0.87, 0.88, 0.89], [0.96, 0.80, 0.53], [0.90, 0.42, 0.22], [0.58, 0.07, 0.13]],
  speed: [[0.27, 0.00, 0.33], [0.23, 0.32, 0.55], [0.13, 0.57, 0.55], [0.37, 0.79, 0.38], [0.99, 0.91, 0.14]],
  stretch: [[0.13, 0.40, 0.67], [0.57, 0.77, 0.87], [0.94, 0.94, 0.93], [0.96, 0.65, 0.51], [0.70, 0.09, 0.17]],
  difference: [[0.83, 0.85, 0.88], [0.42, 0.68, 0.86], [0.36, 0.30, 0.75], [0.92, 0.20, 0.45]],
};
const NEUTRAL = [0.36, 0.38, 0.41];

/** What can give the colour: its key in settings, its name, and what its numbers are in. */
export const COLOURS = [
  { key: 'material', name: 'Material' },
  { key: 'damage', name: 'Damage', unit: '' },
  { key: 'speed', name: 'Speed', unit: 'm/s' },
  { key: 'piece', name: 'Piece' },
  { key: 'inside', name: 'Inside' },
  { key: 'stretch', name: 'Stretch', unit: '', signed: true },
  { key: 'difference', name: 'Difference', unit: 'm', pair: true },
];

const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const toLinear = (srgb) => srgb.map(linear);

/** Stops of a scale as CSS colours, for legends. */
export const stops = (name) => STOPS[name].map((c) => `rgb(${c.map((x) => Math.round(255 * x)).join(' ')})`);

/** A scale as 256 colours. */
function table(name) {
  const ends = STOPS[name].map(toLinear);
  const colours = new Float32Array(256 * 3);
  for (let n = 0; n < 256; n++) {
    const t = (n / 255) * (ends.length - 1);
    const k = Math.min(Math.floor(t), ends.length - 2);
    for (let c = 0; c < 3; c++) colours[3 * n + c] = ends[k][c] + (t - k) * (ends[k + 1][c] - ends[k][c]);
  }
  return colours;
}
const TABLES = Object.fromEntries(Object.keys(STOPS).map((name) => [name, table(name)]));

function hash(x) {
  x = Math.imul(x ^ (x >>> 16), 0x7feb352d);
  x = Math.imul(x ^ (x >>> 15), 0x846ca68b);
  return (x ^ (x >>> 16)) >>> 0;
}

/** A colour of its own for a piece: hues by the golden ratio, lightness in three steps. */
export function pieceColour(number) {
  const turn = (Math.imul(number, 2654435769) >>> 0) / 4294967296;
  const light = 0.66 + 0.1 * (hash(number) % 3);
  const channel = (shift) => {
    const x = Math.abs(((turn + shift) % 1) * 6 - 3) - 1;
    return light * (1 - 0.42 * (1 - Math.min(Math.max(x, 0), 1)));
  };
  return toLinear([channel(0), channel(2 / 3), channel(1 / 3)]);
}

/** Red, green, blue for every vertex. `values` are those of a scale; `top` is what gets its last colour. */
export function paint(frame, mode, { look, values, top }) {
  const { position, inside, piece } = frame.columns;
  const count = position.length / 3;
  const out = new Float32Array(3 * count);
  const put = (v, colour, dim = 1) => {
    for (let c = 0; c < 3; c++) out[3 * v + c] = colour[c] * dim;
  };
  if (mode === 'piece') {
    const { ids, of } = frame.pieces;
    const colours = Array.from(ids, pieceColour);
    for (let v = 0; v < count; v++) put(v, colours[of[v]], inside?.[v] ? 0.7 : 1);
  } else if (mode in TABLES && values) {
    const colours = TABLES[mode];
    const { signed } = COLOURS.find(({ key }) => key === mode);
    for (let v = 0; v < count; v++) {
      const share = values[v] / top || 0;
      const n = 3 * Math.round(255 * Math.min(Math.max(signed ? 0.5 + 0.5 * share : share, 0), 1));
      for (let c = 0; c < 3; c++) out[3 * v + c] = colours[n + c];
    }
  } else {
    const outside = mode === 'inside' ? toLinear(NEUTRAL) : toLinear(look.outside);
    const crack = mode === 'inside' ? toLinear([0.95, 0.55, 0.36]) : toLinear(look.crack);
    for (let v = 0; v < count; v++) put(v, inside?.[v] ? crack : outside);
  }
  return out;
}

/** The numbers behind a scale, for every vertex; nothing for colours without a scale. */
export function valuesOf(frame, mode) {
  if (mode === 'damage' || mode === 'stretch') return frame.columns[mode];
  if (mode !== 'speed') return undefined;
  const { velocity } = frame.columns;
  const out = new Float32Array(velocity.length / 3);
  for (let v = 0; v < out.length; v++) out[v] = Math.hypot(velocity[3 * v], velocity[3 * v + 1], velocity[3 * v + 2]);
  return out;
}

/** The next of 1, 2, 5, 10, … from `x` on: the end of a scale that does not flicker from frame to frame. */
export function rounded(x) {
  if (!(x > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(x));
  return ten * ([1, 2, 5].find((n) => n * ten >= x * 0.999) ?? 10);
}
