/** An answer that refuses: RFC 9457's fields and the reason that programs know it by. */
export class Problem extends Error {
  override readonly name = 'Problem';

  constructor(
    readonly status: number,
    /** A stable word, listed in docs/use/errors.md; empty if the answer is not the server's. */
    readonly reason: string,
    detail: string,
    readonly requestId: string | null,
  ) {
    super(detail);
  }

  /** The problem in a document; text of something else, as of a proxy, has no reason. */
  static read(text: string, status = 0): Problem {
    try {
      const body = JSON.parse(text) as { status?: number; detail?: string; reason?: string; request_id?: string };
      return new Problem(status || (body.status ?? 0), body.reason ?? '', body.detail ?? text, body.request_id ?? null);
    } catch {
      return new Problem(status, '', text, null);
    }
  }
}

/** The problem that an answer has as its body. */
export async function problemOf(answer: Response): Promise<Problem> {
  const text = await answer.text();
  return Problem.read(text || answer.statusText, answer.status);
}
