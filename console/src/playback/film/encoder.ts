import { webm, type Packet, type Track } from './webm';

/** Codecs in the order of preference, as browsers and as files name them. */
const CODECS = [['vp8', 'V_VP8'], ['vp09.00.40.08', 'V_VP9']] as const;
const BITS_PER_SECOND = 8_000_000;
/** Time after which a picture comes that needs no other one, for players that seek [s]. */
const KEY_S = 1;
/** Pictures that may wait to be encoded: each takes memory. */
const MOST_WAITING = 3;

/** True if this browser encodes videos: pages that came without encryption from another machine cannot. */
export function canEncode(): boolean {
  return typeof VideoEncoder !== 'undefined';
}

/**
 * Pictures that become a video at given times, however long it takes to make them. A MediaRecorder
 * would take the clock's times, and leave out pictures where a machine is slow.
 */
export class Encoder {
  readonly #packets: Packet[] = [];
  readonly #encoder: VideoEncoder;
  readonly #size: { readonly width: number; readonly height: number };
  #count = 0;
  #fault: Error | null = null;

  private constructor(
    config: VideoEncoderConfig,
    private readonly codec: Track['codec'],
    /** Time for which each picture is shown [s]. */
    private readonly seconds: number,
  ) {
    this.#encoder = new VideoEncoder({
      output: (chunk) => {
        const data = new Uint8Array(chunk.byteLength);
        chunk.copyTo(data);
        this.#packets.push({ data, timeMs: chunk.timestamp / 1000, isKey: chunk.type === 'key' });
      },
      error: (error) => (this.#fault = error),
    });
    this.#encoder.configure(config);
    this.#size = { width: config.width, height: config.height };
  }

  /** Begins a video of pictures of a size [pixels]; throws if the browser has no codec for it. */
  static async begin(width: number, height: number, seconds: number): Promise<Encoder> {
    for (const [codec, name] of CODECS) {
      const config = { codec, width, height, bitrate: BITS_PER_SECOND, framerate: 1 / seconds };
      if ((await VideoEncoder.isConfigSupported(config)).supported === true) return new Encoder(config, name, seconds);
    }
    throw new Error('this browser has no codec for videos');
  }

  /** Adds what a canvas shows, as soon as there is room for it. */
  async add(canvas: HTMLCanvasElement): Promise<void> {
    const step = 1e6 * this.seconds;
    const frame = new VideoFrame(canvas, { timestamp: Math.round(this.#count * step), duration: Math.round(step) });
    const every = Math.max(Math.round(KEY_S / this.seconds), 1);
    try {
      if (this.#fault !== null) throw this.#fault;
      this.#encoder.encode(frame, { keyFrame: this.#count % every === 0 });
    } finally {
      frame.close();
    }
    this.#count += 1;
    while (this.#encoder.encodeQueueSize > MOST_WAITING && this.#fault === null) {
      await new Promise((resolve) => this.#encoder.addEventListener('dequeue', resolve, { once: true }));
    }
  }

  /** The video of all pictures. */
  async finish(): Promise<Blob> {
    await this.#encoder.flush();
    if (this.#fault !== null) throw this.#fault;
    return webm(this.#packets, { codec: this.codec, ...this.#size, durationMs: 1000 * this.seconds * this.#count });
  }

  /** Frees what the encoder holds. */
  close(): void {
    if (this.#encoder.state !== 'closed') this.#encoder.close();
  }
}
