import type { Api } from '../../api/client';
import { PREFIX, headLength, readHead, type Head, type Range } from './head';

/** Bytes of the first request, which most heads fit in. */
const FIRST = 64 << 10;

/** The playback of a capture, read by ranges. */
export class PlaybackFile {
  private constructor(
    private readonly api: Api,
    private readonly path: string,
    private readonly signal: AbortSignal,
    /** The version that the head is of. */
    readonly tag: string,
    private readonly dataAt: number,
    readonly head: Head,
  ) {}

  /** Reads the head of a capture's playback. Requests end with `signal`. */
  static async open(api: Api, capture: string, signal: AbortSignal): Promise<PlaybackFile> {
    const path = `/v1/captures/${encodeURIComponent(capture)}/playback`;
    const answer = await api.fetch(path, { signal, headers: { range: `bytes=0-${FIRST - 1}` } });
    const tag = answer.headers.get('etag') ?? '';
    let bytes = new Uint8Array(await answer.arrayBuffer());
    const end = PREFIX + headLength(bytes);
    if (bytes.length < end) {
      const rest = await api.fetch(path, { signal, headers: { range: `bytes=0-${end - 1}` } });
      bytes = new Uint8Array(await rest.arrayBuffer());
    }
    return new PlaybackFile(api, path, signal, tag, end, readHead(bytes.subarray(PREFIX, end)));
  }

  /** Bytes of the data; throws if the capture was read again since the head was. */
  async read([first, length]: Range): Promise<Uint8Array<ArrayBuffer>> {
    if (length === 0) return new Uint8Array(0);
    const from = this.dataAt + first;
    const headers = { range: `bytes=${from}-${from + length - 1}` };
    const answer = await this.api.fetch(this.path, { signal: this.signal, headers });
    if (this.tag !== '' && answer.headers.get('etag') !== this.tag) {
      await answer.body?.cancel();
      throw new Error('the capture was read again meanwhile: load this page again');
    }
    const bytes = new Uint8Array(await answer.arrayBuffer());
    if (bytes.length !== length) throw new Error(`the playback has ${bytes.length} bytes in place of ${length}`);
    return bytes;
  }
}
