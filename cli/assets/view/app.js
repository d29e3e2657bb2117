// The page: brings the frames that the settings ask for onto the stage.

import { Run, listing, live } from './data.js';
import { State } from './state.js';
import { Stage } from './stage.js';
import { Player } from './player.js';
import { paint, rounded, valuesOf } from './colour.js';
import { difference, spread } from './difference.js';
import { legend } from './legend.js';
import { loaded, timeline } from './timeline.js';
import { Plots } from './plots.js';
import { parse } from './series.js';
import { panel } from './panel.js';
import { keys } from './keys.js';
import { chosen, clicks, find, tell } from './pick.js';

/** Milliseconds between questions for new frames. */
const PATIENCE = 2000;

const byId = (id) => document.getElementById(id);

function say(sentence) {
  byId('message').textContent = sentence;
  byId('message').hidden = sentence === '';
}

class Page {
  #runs;
  #state;
  #stage;
  #plots;
  /** What is on the stage: for each run its surface and, if asked for, its particles. */
  #shown = [];
  /** Ends of the scales: the largest number met so far, but for a few splinters. */
  #most = { speed: 0, stretch: 0, difference: 0 };
  #wanted = 0;
  #grid = 0;
  #note = '';

  constructor(abouts) {
    this.#runs = abouts.map((about, k) => new Run(k, about));
    const [first] = this.#runs;
    const particles = abouts.every(({ particles }) => particles.length > 0);
    this.#state = new State({
      at: 0, length: first.frames.length, playing: false, loop: true, speed: 24, colour: first.about.colouring,
      shape: 'surface', cracks: true, colliders: true, ground: true, explode: 0, picked: null,
    });
    const state = this.#state;
    this.#stage = new Stage(byId('canvas'), abouts);
    this.#plots = new Plots(byId('plots'), (time) => state.set({ playing: false, at: first.nearest(time) }));
    const player = new Player(state, () => first.frames.length, (k) => this.#ask(k), (k) => this.#ready(k));
    timeline(state, first, player);
    panel(state, { runs: abouts.length, particles, colliders: true, ground: first.about.ground !== null });
    const frame = () => this.#stage.frame(...this.#extent());
    keys(state, player, abouts.length, { frame, particles });
    clicks(byId('canvas'), this.#stage, (index, ray) => this.#pick(index, ray));
    this.#introduce();
    state.on(['ground'], () => (this.#stage.ground = state.ground));
    state.on(['at', 'length', 'shape'], () => this.#show());
    state.on(['colour', 'cracks', 'colliders', 'explode'], () => this.#draw());
    state.on(['picked'], () => this.#tell());
    this.#series();
  }

  #introduce() {
    const { title, name } = this.#runs[0].about;
    byId('title').textContent = title || name;
    document.title = `${title || name} · Fissure`;
    byId('names').textContent = this.#runs.map(({ about }) => about.name).join(' and ');
    if (this.#runs.length < 2) return;
    for (const { about } of this.#runs) {
      byId('labels').append(Object.assign(document.createElement('span'), { textContent: about.name }));
    }
    byId('stage').classList.add('two');
  }

  /** The frame of run `r` that goes with frame `k` of the first. */
  #number(r, k) {
    const run = this.#runs[r];
    return run.frames[r === 0 ? k : run.nearest(this.#runs[0].times[k])];
  }

  #kinds() {
    return this.#state.shape === 'particles' ? ['frame', 'particles'] : ['frame'];
  }

  #ask(k) {
    return Promise.all(this.#runs.map((run, r) =>
      Promise.all(this.#kinds().map((kind) => run.get(kind, this.#number(r, k)))))).then((got) => {
      this.#marks();
      return got;
    }, (error) => say(error.message));
  }

  #ready(k) {
    return this.#runs.every((run, r) => this.#kinds().every((kind) => run.ready(kind, this.#number(r, k))));
  }

  #marks() {
    loaded(this.#state.length, (k) => this.#ready(k));
  }

  /** Brings the frame of this time onto the stage; of many asked for at once only the last. */
  async #show() {
    const wanted = ++this.#wanted;
    if (this.#state.length === 0) return;
    const got = await this.#ask(this.#state.at);
    if (!got || wanted !== this.#wanted) return;
    say('');
    const first = this.#shown.length === 0;
    this.#shown = got.map(([surface, particles]) => ({ surface, particles }));
    if (first) {
      this.#grid = this.#stage.look(...this.#extent(), this.#runs[0].about.camera);
      byId('waiting').hidden = true;
    }
    const rigid = got.some(([surface]) => surface.columns['collider.position']);
    byId('colliders').parentElement.hidden = !rigid;
    this.#draw();
    this.#plots.at(got[0][0].time);
    this.#tell();
    document.body.dataset.frame = got[0][0].number;
  }

  #extent() {
    const ends = this.#shown.map(({ surface }) => surface);
    const all = (key, pick) => [0, 1, 2].map((k) => pick(...ends.map((frame) => frame[key][k])));
    return [all('low', Math.min), all('high', Math.max)];
  }

  #draw() {
    if (this.#shown.length === 0) return;
    const { colour, cracks, colliders, explode, shape } = this.#state;
    const [low, high] = this.#extent();
    const middle = low.map((x, k) => (x + high[k]) / 2);
    const thing = shape === 'particles' ? 'particles' : 'surface';
    const frames = this.#shown.map((shown) => shown[thing]);
    this.#note = '';
    const values = frames.map((frame, r) => this.#values(frame, frames[1 - r]));
    const top = colour === 'damage' ? 1 : rounded(this.#most[colour] ?? 1);
    frames.forEach((frame, r) => {
      const { about } = this.#runs[r];
      const body = this.#stage.bodies[r];
      const colours = paint(frame, colour, { look: about, values: values[r], top });
      body[thing](frame, colours, { explode, cracks, middle });
      body.choose(shape, colliders);
    });
    const pieces = frames[0].pieces.ids.length;
    legend(byId('legend'), colour, {
      look: this.#runs[0].about, top, note: this.#note, pieces, grid: this.#state.ground && this.#grid,
    });
    this.#mark();
    this.#stage.redraw(true);
  }

  #values(frame, other) {
    const { colour } = this.#state;
    if (colour !== 'difference') {
      if (colour in this.#most) this.#most[colour] = Math.max(this.#most[colour], frame[colour]);
      return valuesOf(frame, colour);
    }
    const values = difference(frame, other);
    const { most, usual } = spread(values);
    this.#most.difference = Math.max(this.#most.difference, usual);
    this.#note = most === 0 ? 'the same in both, here' : `up to ${most.toPrecision(3)} m now`;
    if (values.every(Number.isNaN)) this.#note = 'the two have no ids in common';
    return values;
  }

  #pick(index, ray) {
    const vertex = this.#stage.bodies[index].hit(ray, 3 * this.#stage.pixel);
    const frame = this.#frameOf(index);
    this.#state.picked = vertex < 0 ? null : { index, ...chosen(frame, vertex) };
  }

  #frameOf(index) {
    const { surface, particles } = this.#shown[index];
    return this.#state.shape === 'particles' ? particles : surface;
  }

  #mark() {
    const { picked } = this.#state;
    this.#stage.bodies.forEach((body, index) => {
      body.mark(picked ? find(this.#frameOf(index), picked) : -1, 4 * this.#stage.pixel);
    });
  }

  #tell() {
    const { picked, shape } = this.#state;
    if (this.#shown.length === 0) return;
    this.#mark();
    this.#stage.redraw();
    if (!picked) {
      byId('card').hidden = true;
      return;
    }
    const frame = this.#frameOf(picked.index);
    const extra = this.#runs.length > 1 ? [['run', this.#runs[picked.index].about.name]] : [];
    const what = shape === 'particles' ? 'Particle' : 'Vertex';
    tell(byId('card'), frame, find(frame, picked), what, extra, () => (this.#state.picked = null));
  }

  async #series() {
    const texts = await Promise.all(this.#runs.map((run) => run.series()));
    this.#plots.draw(texts.map(parse));
  }

  /** Takes in what a run that goes on has written; who looks at the last frame goes on to the new last. */
  grow(abouts) {
    const before = this.#runs.map(({ frames }) => frames.length);
    this.#runs.forEach((run, k) => (run.about = abouts[k]));
    this.#progress();
    if (this.#runs.every(({ frames }, k) => frames.length === before[k])) return;
    const { at, length, playing } = this.#state;
    const now = this.#runs[0].frames.length;
    const follows = !playing && (at === length - 1 || length === 0);
    this.#state.set({ length: now, at: follows ? now - 1 : Math.min(at, now - 1) });
    this.#marks();
    this.#series();
  }

  #progress() {
    const { frames, about } = this.#runs[0];
    const all = Math.round(about.duration / about.every);
    const last = frames.at(-1) ?? -1;
    byId('live').textContent = last < all ? `frame ${Math.max(last, 0)} of ${all} so far` : '';
    if (frames.length === 0) byId('waiting').textContent = 'the run has no frames yet; they appear as it goes on';
  }

  start() {
    if (!live) return;
    this.#progress();
    setInterval(() => listing().then(({ runs }) => this.grow(runs), () => say('fissure view has ended')), PATIENCE);
  }
}

listing().then(({ runs }) => new Page(runs).start(), (error) => say(error.message));
