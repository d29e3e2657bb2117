// How far two runs are apart, vertex by vertex, told by the ids that both have from the same mesh at rest.

/** For every vertex of `a` the distance to the nearest vertex of `b` with its id [m], NaN where `b` has none. */
export function difference(a, b) {
  const ids = b.columns.id;
  let most = 0;
  for (const id of ids) if (id > most) most = id;
  const first = new Int32Array(most + 1).fill(-1);
  const next = new Int32Array(ids.length);
  for (let v = 0; v < ids.length; v++) {
    next[v] = first[ids[v]];
    first[ids[v]] = v;
  }
  const [p, q] = [a.columns.position, b.columns.position];
  const out = new Float32Array(a.columns.id.length);
  for (let v = 0; v < out.length; v++) {
    const id = a.columns.id[v];
    let least = Infinity;
    for (let w = id <= most ? first[id] : -1; w >= 0; w = next[w]) {
      const square = (p[3 * v] - q[3 * w]) ** 2 + (p[3 * v + 1] - q[3 * w + 1]) ** 2 + (p[3 * v + 2] - q[3 * w + 2]) ** 2;
      if (square < least) least = square;
    }
    out[v] = least === Infinity ? NaN : Math.sqrt(least);
  }
  return out;
}

/** The largest of `values`, and what 99 of 100 are not above. */
export function spread(values) {
  const sorted = values.filter((x) => !Number.isNaN(x)).sort();
  return { most: sorted.at(-1) ?? 0, usual: sorted[Math.floor(0.99 * (sorted.length - 1))] ?? 0 };
}
