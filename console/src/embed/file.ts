import { readHeader, startOfData } from '@bendtwin/client';
import { NO_FRAME, startsOf, type Skin } from '../view3d/skin';
import { ofLength, within } from '../view3d/tensor';

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

  /** Points that N nodes carry: the tensors that begin with `skin` or `surface`. */
  carried(prefix: 'skin' | 'surface', nodes: number): Skin {
    const starts = startsOf(this.indices(`${prefix}.weight_count`));
    const points = starts.length - 1;
    const carriers = ofLength(this.indices(`${prefix}.weight_node`), starts[points]!, `${prefix}.weight_node`);
    within(carriers, nodes, `${prefix}.weight_node`);
    const frames = ofLength(this.indices(`${prefix}.frame`), 3 * points, `${prefix}.frame`);
    within(frames.filter((node) => node !== NO_FRAME), nodes, `${prefix}.frame`);
    return {
      starts,
      nodes: carriers,
      weights: ofLength(this.floats(`${prefix}.weight`), carriers.length, `${prefix}.weight`),
      frames,
      offsets: ofLength(this.floats(`${prefix}.offset`), 3 * points, `${prefix}.offset`),
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
