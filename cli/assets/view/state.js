// What the page is set to. Whoever depends on a part of it is told when that part changes.

export class State {
  #values;
  #listeners = [];

  constructor(values) {
    this.#values = { ...values };
    for (const key of Object.keys(values)) {
      Object.defineProperty(this, key, { get: () => this.#values[key], set: (value) => this.set({ [key]: value }) });
    }
  }

  /** Sets several at once; listeners hear of those that changed, once. */
  set(values) {
    const changed = Object.keys(values).filter((key) => this.#values[key] !== values[key]);
    for (const key of changed) {
      if (!(key in this.#values)) throw new Error(`there is no setting ${key}`);
      this.#values[key] = values[key];
    }
    if (changed.length === 0) return;
    for (const { keys, listener } of this.#listeners) {
      if (changed.some((key) => keys.includes(key))) listener();
    }
  }

  /** Calls `listener` whenever one of `keys` changes, and now. */
  on(keys, listener) {
    this.#listeners.push({ keys, listener });
    listener();
  }
}
