import { readHeader, startOfData } from '../api/twin_file';
import { startsOf, type Skin } from '../view3d/skin';

/** A twin file in memory: its document, and its tensors by name, which are empty where the file has none. */
export class TwinFile {
  readonly document: unknown;
  readonly #tensors;
  readonly #data: Uint8Array;

  constructor(bytes: Uint8Array) {
    const { document, tensors } = readHeader(bytes);
    this.document = document;
    this.#tensors = tensors;
    this.#data = bytes.subarray(startOfData(bytes));
  }

  floats(name: string): Float32Array {
    return new Float32Array(this.#part(name, 'F32', 4));
  }

  indices(name: string): Uint32Array {
    return new Uint32Array(this.#part(name, 'U32', 4));
  }

  bytes(name: string): Uint8Array {
    return new Uint8Array(this.#part(name, 'U8', 1));
  }

  /** Points that nodes carry: the tensors that begin with `skin`, `surface` or the like. */
  carried(prefix: string): Skin {
    return {
      starts: startsOf(this.indices(`${prefix}.weight_count`)),
      nodes: this.indices(`${prefix}.weight_node`),
      weights: this.floats(`${prefix}.weight`),
      frames: this.indices(`${prefix}.frame`),
      offsets: this.floats(`${prefix}.offset`),
    };
  }

  #part(name: string, dtype: string, width: number): ArrayBuffer {
    const entry = this.#tensors.get(name);
    if (entry === undefined) return new ArrayBuffer(0);
    const [start, end] = entry.data_offsets;
    if (entry.dtype !== dtype || (end - start) % width !== 0) throw new Error(`${name} is no ${dtype}`);
    // A copy, as the place of a tensor need not be a multiple of its numbers' size.
    return this.#data.slice(start, end).buffer as ArrayBuffer;
  }
}
