// Fetches and unpacks frames away from the page's thread. The bytes are documented in cli/src/view/pack.rs.

const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array };

self.onmessage = async ({ data: { ticket, url, text } }) => {
  try {
    const buffer = url ? await fetched(url) : await inflated(text);
    const start = performance.now();
    const frame = unpacked(buffer);
    frame.took = performance.now() - start;
    frame.bytes = buffer.byteLength;
    const arrays = [...Object.values(frame.columns), frame.pieces.of, frame.pieces.ids, frame.pieces.centres];
    self.postMessage({ ticket, frame }, [...new Set(arrays.map((array) => array.buffer))]);
  } catch (error) {
    self.postMessage({ ticket, error: error.message });
  }
};

async function fetched(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.arrayBuffer();
}

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))).arrayBuffer();
}

function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const columns = {};
  for (const [name, about] of Object.entries(head.columns)) {
    const raw = new TYPES[about.type](buffer, 4 + length + about.at, about.count * about.per);
    if (about.step) columns[name] = scaled(raw, about);
    else if (name.endsWith('normal')) columns[name] = normals(raw);
    else columns[name] = raw;
  }
  const { number, time, outer } = head;
  return { number, time, outer, columns, ...extent(columns), pieces: pieces(columns) };
}

function scaled(raw, { per, step, from }) {
  const values = new Float32Array(raw.length);
  for (let k = 0; k < raw.length; k++) values[k] = from[k % per] + step[k % per] * raw[k];
  return values;
}

/** Unit vectors from an unfolded octahedron. */
function normals(raw) {
  const half = raw.BYTES_PER_ELEMENT === 1 ? 127 : 32767;
  const values = new Float32Array((raw.length / 2) * 3);
  for (let k = 0, n = 0; k < raw.length; k += 2, n += 3) {
    let x = raw[k] / half - 1;
    let y = raw[k + 1] / half - 1;
    const z = 1 - Math.abs(x) - Math.abs(y);
    const under = Math.max(-z, 0);
    x -= Math.sign(x) * under;
    y -= Math.sign(y) * under;
    const scale = 1 / Math.sqrt(x * x + y * y + z * z);
    values[n] = x * scale;
    values[n + 1] = y * scale;
    values[n + 2] = z * scale;
  }
  return values;
}

/** Where nearly everything is, and how fast: a splinter that flies off counts for nothing. */
function extent({ position, velocity, stretch }) {
  const stride = 3 * Math.max(1, Math.floor(position.length / 3 / 4000));
  const sample = (value) => {
    const values = [];
    for (let k = 0; k < position.length; k += stride) values.push(value(k));
    return values.sort((a, b) => a - b);
  };
  const axes = [0, 1, 2].map((axis) => sample((k) => position[k + axis]));
  const lost = Math.floor(axes[0].length * 0.005);
  const speeds = sample((k) => Math.hypot(velocity[k], velocity[k + 1], velocity[k + 2]));
  const usual = (values) => values[values.length - 1 - 2 * lost] ?? 0;
  return {
    low: axes.map((values) => values[lost] ?? 0),
    high: axes.map((values) => values[values.length - 1 - lost] ?? 0),
    speed: usual(speeds),
    stretch: stretch ? usual(sample((k) => Math.abs(stretch[k / 3]))) : 0,
  };
}

/** Which pieces there are, in the middle of what each lies, and the place of every vertex's piece among them. */
function pieces({ position, piece }) {
  const count = position.length / 3;
  const places = new Map();
  const of = new Uint32Array(count);
  const sums = [];
  for (let v = 0; v < count; v++) {
    const id = piece?.[v] ?? 0;
    let place = places.get(id);
    if (place === undefined) {
      place = places.size;
      places.set(id, place);
      sums.push(0, 0, 0, 0);
    }
    of[v] = place;
    for (let k = 0; k < 3; k++) sums[4 * place + k] += position[3 * v + k];
    sums[4 * place + 3] += 1;
  }
  const centres = new Float32Array(3 * places.size);
  for (let p = 0; p < places.size; p++) {
    for (let k = 0; k < 3; k++) centres[3 * p + k] = sums[4 * p + k] / sums[4 * p + 3];
  }
  return { of, ids: Uint32Array.from(places.keys()), centres };
}
