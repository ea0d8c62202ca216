/** An answer that refuses: RFC 9457's fields and the reason that programs know it by. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    readonly reason: string,
    detail: string,
    readonly requestId: string | null,
  ) {
    super(detail);
  }
}

/** The problem that an answer has as its body; text of something else, as of a proxy, has no reason. */
export async function problemOf(answer: Response): Promise<Problem> {
  const text = await answer.text();
  try {
    const body = JSON.parse(text) as { detail?: string; reason?: string; request_id?: string };
    return new Problem(answer.status, body.reason ?? '', body.detail ?? text, body.request_id ?? null);
  } catch {
    return new Problem(answer.status, '', text || answer.statusText, null);
  }
}
