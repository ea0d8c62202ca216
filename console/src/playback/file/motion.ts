import { Blocks } from './blocks';
import type { MotionHead, Range } from './head';

/** Stands for the coordinates of a point that is not known. */
const UNKNOWN = -32768;
/** Bytes of points that one request is for, about. */
const BLOCK_BYTES = 256 << 10;

/** Reads bytes of a playback's data. */
export type Read = (range: Range) => Promise<Uint8Array<ArrayBuffer>>;

/** Points and control points of a frame; the arrays belong to the caller. */
export interface Frame {
  /** Tracked points [m], shape [P, 3]; not a number where they are not known. */
  readonly points: Float32Array;
  /** 1 where a camera saw the point in this frame, shape [P]. */
  readonly visible: Uint8Array;
  /** Control points [m], shape [C, 3]. */
  readonly controls: Float32Array;
}

interface Block {
  readonly points: Uint8Array;
  readonly visible: Uint8Array;
  readonly controls: Uint8Array;
}

/** Motion of a sequence, loaded while it is played. */
export class Motion {
  readonly #blocks: Blocks<Block>;
  readonly #rows: { points: number; visible: number; controls: number };

  constructor(
    readonly head: MotionHead,
    readonly frameCount: number,
    read: Read,
  ) {
    const { point_count: points, control_count: controls } = head;
    const rows = (this.#rows = { points: 6 * points, visible: Math.ceil(points / 8), controls: 6 * controls });
    const row = Math.max(rows.points + rows.visible + rows.controls, 1);
    const size = Math.min(Math.max(Math.floor(BLOCK_BYTES / row), 1), frameCount);
    // A playback's motion has 14 MiB in all, so all of it stays.
    this.#blocks = new Blocks<Block>(size, Infinity, async (block) => {
      const part = ([first]: Range, bytes: number): Promise<Uint8Array> => {
        const from = block * size;
        return read([first + from * bytes, (Math.min(from + size, frameCount) - from) * bytes]);
      };
      const [p, v, c] = await Promise.all([
        part(head.points, rows.points), part(head.visible, rows.visible), part(head.controls, rows.controls),
      ]);
      return { points: p, visible: v, controls: c };
    });
  }

  /** Loads a frame, and begins to load those after it. */
  async load(frame: number): Promise<void> {
    await this.#blocks.get(frame);
    const next = (Math.floor(frame / this.#blocks.size) + 1) * this.#blocks.size;
    // What fails here is asked for again when it is needed.
    if (next < this.frameCount) void this.#blocks.get(next).catch(() => undefined);
  }

  /** A frame, or null while it is not here. */
  frame(frame: number): Frame | null {
    const block = this.#blocks.peek(frame);
    if (block === undefined) return null;
    const row = frame % this.#blocks.size;
    const { point_count: count } = this.head;
    const of = (bytes: Uint8Array, length: number): Uint8Array => bytes.subarray(row * length, (row + 1) * length);
    const bits = of(block.visible, this.#rows.visible);
    const visible = Uint8Array.from({ length: count }, (_, i) => (bits[i >> 3]! >> (i & 7)) & 1);
    return {
      points: metres(of(block.points, this.#rows.points), this.head),
      visible,
      controls: metres(of(block.controls, this.#rows.controls), this.head),
    };
  }
}

/** Control points of all frames [m], shape [T, C, 3]; not a number where they are not known. */
export async function controlsOf(head: MotionHead, read: Read): Promise<Float32Array> {
  return metres(await read(head.controls), head);
}

function metres(bytes: Uint8Array, { origin, scale_m: scale }: MotionHead): Float32Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return Float32Array.from({ length: bytes.length / 2 }, (_, i) => {
    const number = view.getInt16(2 * i, true);
    return number === UNKNOWN ? NaN : origin[i % 3]! + scale * number;
  });
}
