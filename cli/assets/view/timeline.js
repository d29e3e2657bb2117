// The bar below: play, step, scrub, how much is loaded, and what time it is.

const byId = (id) => document.getElementById(id);

/** Connects the bar; `run` tells how many frames there are and when they are. */
export function timeline(state, run, player) {
  const scrub = byId('scrub');
  byId('first').onclick = () => player.go(0);
  byId('back').onclick = () => player.step(-1);
  byId('next').onclick = () => player.step(1);
  byId('last').onclick = () => player.go(Infinity);
  byId('play').onclick = () => (state.playing = !state.playing);
  byId('loop').onclick = () => (state.loop = !state.loop);
  byId('speed').onchange = ({ target }) => (state.speed = Number(target.value));
  scrub.oninput = () => state.set({ playing: false, at: Number(scrub.value) });
  state.on(['playing'], () => {
    byId('play').classList.toggle('playing', state.playing);
    byId('play').setAttribute('aria-label', state.playing ? 'Pause' : 'Play');
  });
  state.on(['loop'], () => byId('loop').setAttribute('aria-pressed', state.loop));
  state.on(['at', 'length', 'speed'], () => {
    scrub.max = Math.max(state.length - 1, 0);
    scrub.value = state.at;
    scrub.style.setProperty('--done', state.length > 1 ? state.at / (state.length - 1) : 0);
    const time = seconds(run.times[state.at] ?? 0);
    scrub.setAttribute('aria-valuetext', `frame ${run.frames[state.at]}, ${time}`);
    byId('clock').innerHTML = '';
    byId('clock').append(part('b', time), part('span', `frame ${run.frames[state.at]} of ${run.frames.at(-1)}`));
    byId('speed').title = `Frames a second: ${pace(run, state.speed)}`;
  });
}

/** Marks which frames are here; `ready(k)` tells. */
export function loaded(length, ready) {
  const marks = [];
  for (let k = 0; k < length; k++) {
    if (!ready(k)) continue;
    const from = k;
    while (k + 1 < length && ready(k + 1)) k++;
    const share = (n) => `${((100 * n) / Math.max(length - 1, 1)).toFixed(2)}%`;
    marks.push(`transparent ${share(from - 0.5)}, var(--loaded) ${share(from - 0.5)} ${share(k + 0.5)}, transparent ${share(k + 0.5)}`);
  }
  byId('loaded').style.background = marks.length ? `linear-gradient(to right, ${marks.join(', ')})` : 'none';
}

/** A time in the unit that suits it. */
export function seconds(time) {
  const size = Math.abs(time);
  if (size >= 1 || size === 0) return `${time.toFixed(3)} s`;
  if (size >= 1e-3) return `${(1e3 * time).toFixed(2)} ms`;
  return `${(1e6 * time).toFixed(2)} µs`;
}

/** How play compares with life. */
function pace({ times }, speed) {
  const every = times.length > 1 ? (times.at(-1) - times[0]) / (times.length - 1) : 0;
  if (!(every > 0)) return 'as fast as given';
  const slower = 1 / (every * speed);
  const factor = (x) => (x >= 10 ? x.toFixed(0) : x.toPrecision(2));
  return slower >= 1 ? `${factor(slower)} times slower than life` : `${factor(1 / slower)} times faster than life`;
}

function part(name, text) {
  const element = document.createElement(name);
  element.textContent = text;
  return element;
}
