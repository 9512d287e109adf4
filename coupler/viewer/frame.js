// Decodes frames packed by coupler/sunder_tools/pictures/playback.py, and keeps the last ones.

const KINDS = { f4: Float32Array, i4: Int32Array, u4: Uint32Array };
const STORED_BYTES = 300e6;

/** Decodes a buffer to {time_s, origin, thickness_m, arrays: {name: typed array}}. Throws where it is too short. */
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, [kind, offset, count]] of Object.entries(header.arrays))
    arrays[name] = new KINDS[kind](buffer, 4 + length + offset, count);
  const { time_s, origin, thickness_m } = header;
  return { time_s, origin, thickness_m, arrays, bytes: buffer.byteLength };
}

export class FrameStore {
  #kept = new Map(); // promises of frames by key, the least recently used one first
  #bytes = 0;

  /** Promise of frame k of this version. The frame is fetched once only. */
  get(k, version) {
    const key = `${k} ${version}`;
    let promise = this.#kept.get(key);
    if (promise) this.#kept.delete(key);
    else {
      promise = this.#fetch(k, version);
      promise.catch(() => this.#kept.delete(key)); // a later request may succeed
    }
    this.#kept.set(key, promise);
    return promise;
  }

  async #fetch(k, version) {
    const answer = await fetch(`frame/${k}?${encodeURIComponent(version)}`);
    if (!answer.ok) throw new Error(`frame ${k}: ${await answer.text()}`);
    const frame = decode(await answer.arrayBuffer());
    this.#bytes += frame.bytes;
    for (const [key, promise] of this.#kept) {
      if (this.#bytes <= STORED_BYTES || this.#kept.size <= 4) break;
      this.#kept.delete(key);
      promise.then((old) => { this.#bytes -= old.bytes; }, () => {});
    }
    return frame;
  }
}
