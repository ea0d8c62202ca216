import { pauseMs, sleep } from '@bendtwin/client';
import { token } from '../../api/token';
import type { Message, ProblemText, Text } from './messages';
import { decodeState, type PlayState } from './state';

/** Events of a play's socket. */
export interface SocketListener {
  /** The first message of a play, made again for each connection; null to watch. */
  begin(): object | null;
  text(text: Exclude<Text, { type: 'ended' }>): void;
  state(state: PlayState): void;
  /** The connection is interrupted, and another one is sought. */
  lost(): void;
  /** There will be no more messages. */
  ended(problem: ProblemText | null): void;
}

/** Reachability of the server, from `Api.connection`. */
export interface ServerWatch {
  lost(): void;
  back(signal: AbortSignal): Promise<void>;
}

const PROTOCOL = 'bendtwin.play.v1';
/** Attempts in a row that open nothing although the server answers. */
const MOST_ATTEMPTS = 7;
/** Reasons that pass: the server stops and is started again, or its workers are not there yet. */
const PASSING = ['STOPPING', 'NO_WORKER', 'WORKER_LOST', 'WORKERS_BUSY'];

/** The WebSocket of a play. If the server is lost it opens another one as soon as there is a server. */
export class PlaySocket {
  #socket: WebSocket | null = null;
  #failures = 0;
  #isReady = false;

  /** Opens a path as `/v1/twins/{id}/play` until the signal is aborted. */
  constructor(
    private readonly path: string,
    private readonly listener: SocketListener,
    private readonly server: ServerWatch,
    private readonly signal: AbortSignal,
  ) {
    signal.addEventListener('abort', () => this.#socket?.close());
    this.#open();
  }

  /** True once the play has begun, until its connection is lost. */
  get isReady(): boolean {
    return this.#isReady;
  }

  /** Sends a message; false if there is no play to send it to. */
  send(message: Message): boolean {
    if (!this.#isReady) return false;
    this.#socket?.send(JSON.stringify(message));
    return true;
  }

  #open(): void {
    const socket = (this.#socket = openSocket(this.path));
    let farewell: { problem: ProblemText | null } | null = null;
    socket.addEventListener('open', () => {
      const begin = this.listener.begin();
      if (begin !== null) socket.send(JSON.stringify({ type: 'begin', ...begin }));
    });
    socket.addEventListener('message', ({ data }: MessageEvent<string | ArrayBuffer>) => {
      if (typeof data !== 'string') return this.listener.state(decodeState(data));
      const text = JSON.parse(data) as Text;
      if (text.type === 'ended') {
        farewell = text;
        return;
      }
      if (text.type === 'ready') {
        this.#isReady = true;
        this.#failures = 0;
      }
      this.listener.text(text);
    });
    socket.addEventListener('close', () => {
      this.#isReady = false;
      if (this.signal.aborted) return;
      if (farewell !== null && !PASSING.includes(farewell.problem?.reason ?? '')) {
        return this.listener.ended(farewell.problem);
      }
      void this.#reopen();
    });
  }

  async #reopen(): Promise<void> {
    this.#failures += 1;
    if (this.#failures > MOST_ATTEMPTS) {
      const detail = 'The connection to the play could not be opened: it has ended, or the server refuses it.';
      return this.listener.ended({ detail, reason: '' });
    }
    this.listener.lost();
    this.server.lost();
    await this.server.back(this.signal);
    if (this.#failures > 1) await sleep(pauseMs(this.#failures), this.signal);
    if (!this.signal.aborted) this.#open();
  }
}

/** A WebSocket of a path, which shows the token. */
export function openSocket(path: string): WebSocket {
  const url = new URL(path, location.href);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  const shown = token();
  const socket = new WebSocket(url, shown === null ? [PROTOCOL] : [PROTOCOL, 'bendtwin.token', shown]);
  socket.binaryType = 'arraybuffer';
  return socket;
}
