import { Problem, ServerLost } from '@bendtwin/client';
import { h } from './dom';
import { withGuide } from './guide';

/** An error as people read it: what happened, what to do, and the words by which it is found again. */
export function problemBox(error: unknown, retry?: () => void): HTMLElement {
  const problem = error instanceof Problem ? error : null;
  return h(
    'div',
    { class: 'problem', role: 'alert' },
    h('p', {}, withGuide(textOf(error))),
    problem !== null &&
      problem.reason !== '' &&
      h(
        'p',
        { class: 'muted' },
        h('code', {}, problem.reason),
        problem.requestId !== null && [' Request ', h('code', {}, problem.requestId)],
      ),
    retry !== undefined && h('button', { type: 'button', onclick: retry }, 'Try again'),
  );
}

/** An error in a sentence. */
export function textOf(error: unknown): string {
  if (error instanceof ServerLost) return 'The server does not answer; the page keeps trying.';
  if (error instanceof Problem) return error.message || `The server refused with status ${error.status}.`;
  return error instanceof Error ? error.message : String(error);
}
