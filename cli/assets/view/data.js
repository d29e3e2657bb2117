// Where frames come from: the server that gave the page, or the page itself when it is a file.

/** Bytes of unpacked frames that a run keeps. */
const ROOM = 768 << 20;

const inside = (id) => document.getElementById(id)?.textContent;
const embedded = inside('runs') !== undefined;

/** What runs there are; throws a sentence. */
export async function listing() {
  if (embedded) return JSON.parse(inside('runs'));
  const answer = await fetch('runs');
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.json();
}

/** Whether there may be more later. */
export const live = !embedded;

/** A run: what is known of it, and its frames. */
export class Run {
  #worker;
  #open = new Map();
  #kept = new Map();
  #size = 0;
  #tickets = 0;

  constructor(index, about) {
    this.index = index;
    this.about = about;
    const code = inside('worker');
    this.#worker = new Worker(code ? URL.createObjectURL(new Blob([code], { type: 'text/javascript' })) : 'worker.js');
    this.#worker.onmessage = ({ data }) => this.#arrived(data);
  }

  get frames() {
    return this.about.frames;
  }

  get times() {
    return this.about.times;
  }

  /** The place among the frames of the one nearest to `time`. */
  nearest(time) {
    const { times } = this.about;
    let low = 0;
    let high = times.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low > 0 && time - times[low - 1] < times[low] - time ? low - 1 : Math.max(low, 0);
  }

  /** Frame number `number`, as `frame` or `particles`; a promise that throws a sentence. */
  get(kind, number) {
    const key = `${kind}/${number}`;
    const known = this.#kept.get(key);
    if (known) {
      this.#kept.delete(key);
      this.#kept.set(key, known);
      return known.promise;
    }
    const entry = { bytes: 0 };
    entry.promise = new Promise((resolve, reject) => {
      const ticket = ++this.#tickets;
      this.#open.set(ticket, { key, entry, resolve, reject });
      if (embedded) this.#worker.postMessage({ ticket, text: inside(`${kind}-${this.index}-${number}`) });
      else this.#worker.postMessage({ ticket, url: new URL(`${kind}/${this.index}/${number}`, location.href).href });
    });
    this.#kept.set(key, entry);
    return entry.promise;
  }

  /** The frame if it is here already. */
  ready(kind, number) {
    return this.#kept.get(`${kind}/${number}`)?.frame;
  }

  /** The series as text. */
  async series() {
    if (embedded) return inside(`series-${this.index}`) ?? '';
    const answer = await fetch(`series/${this.index}`);
    return answer.ok ? answer.text() : '';
  }

  #arrived({ ticket, frame, error }) {
    const { key, entry, resolve, reject } = this.#open.get(ticket);
    this.#open.delete(ticket);
    if (error) {
      this.#kept.delete(key);
      reject(new Error(error));
      return;
    }
    entry.frame = frame;
    entry.bytes = frame.bytes;
    this.#size += frame.bytes;
    for (const [old, { bytes }] of this.#kept) {
      if (this.#size <= ROOM) break;
      if (old === key || bytes === 0) continue;
      this.#kept.delete(old);
      this.#size -= bytes;
    }
    resolve(frame);
  }
}
