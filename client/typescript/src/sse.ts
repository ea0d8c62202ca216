/** A message of a stream of server-sent events. */
export interface Message {
  readonly event: string;
  /** The last id up to this message. */
  readonly id: string;
  readonly data: string;
}

/** The messages of an answer, as they come. Comments, which keep the connection alive, are left out. */
export async function* messages(answer: Response): AsyncGenerator<Message> {
  if (answer.body === null) return;
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  const parser = new Parser();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield* parser.push(value);
    }
  } finally {
    // The connection is closed even if the reader does not want all of it.
    await reader.cancel().catch(() => undefined);
  }
}

/** Reads the format of server-sent events, in pieces that may end anywhere. */
export class Parser {
  #rest = '';
  #event = '';
  #id = '';
  #data: string[] = [];

  *push(piece: string): Generator<Message> {
    // A carriage return at the very end may be half of a line's end.
    const lines = (this.#rest + piece).split(/\r\n|\n|\r(?!$)/);
    this.#rest = lines.pop() ?? '';
    for (const line of lines) {
      if (line !== '') this.field(line);
      else if (this.#data.length > 0) yield this.take();
      else this.#event = '';
    }
  }

  private field(line: string): void {
    const colon = line.indexOf(':');
    if (colon === 0) return;
    const name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (name === 'event') this.#event = value;
    else if (name === 'id') this.#id = value;
    else if (name === 'data') this.#data.push(value);
  }

  private take(): Message {
    const message = { event: this.#event || 'message', id: this.#id, data: this.#data.join('\n') };
    this.#event = '';
    this.#data = [];
    return message;
  }
}
