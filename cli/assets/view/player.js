// Play: goes to the next frame when it is due and here, and asks for those after it.

/** Frames that are asked for ahead. */
const AHEAD = 6;

export class Player {
  #state;
  #length;
  #ask;
  #ready;
  #due = 0;

  /** `ask(k)` gets frame `k`; `ready(k)` says whether it is here. */
  constructor(state, length, ask, ready) {
    this.#state = state;
    this.#length = length;
    this.#ask = ask;
    this.#ready = ready;
    state.on(['playing'], () => {
      if (!state.playing) return;
      if (state.at >= length() - 1) state.at = 0;
      this.#due = performance.now();
      requestAnimationFrame(this.#turn);
    });
    state.on(['at', 'playing'], () => this.#ahead());
  }

  /** Goes by so many frames, and stops playing. */
  step(by) {
    this.go(this.#state.at + by);
  }

  go(to) {
    this.#state.set({ playing: false, at: Math.min(Math.max(to, 0), this.#length() - 1) });
  }

  #ahead() {
    const [count, length] = [this.#state.playing ? AHEAD : 2, this.#length()];
    for (let k = 1; k <= count; k++) {
      const next = this.#state.at + k;
      const place = next < length ? next : this.#state.playing && this.#state.loop ? next % length : -1;
      if (place >= 0) this.#ask(place);
    }
  }

  #turn = (now) => {
    const state = this.#state;
    if (!state.playing) return;
    requestAnimationFrame(this.#turn);
    if (now < this.#due) return;
    const last = this.#length() - 1;
    if (state.at >= last && !state.loop) {
      state.playing = false;
      return;
    }
    const next = state.at >= last ? 0 : state.at + 1;
    if (!this.#ready(next)) return;
    // a late frame is not made up for: time slows rather than jumps
    this.#due = Math.max(this.#due + 1000 / state.speed, now - 1000 / state.speed);
    state.at = next;
  };
}
