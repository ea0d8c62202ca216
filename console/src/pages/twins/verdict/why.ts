import { idOf, type Twin } from '@bendtwin/client';
import { h, type Child } from '../../../ui/dom';
import { millimetres } from '../../../ui/format';
import { table } from '../../../ui/table';
import { below } from '../../parts/error';
import { prose } from '../../parts/text';
import type { Quality } from '../quality';
import { adviceOf, type Step } from './advice';
import { levelBadge, warningList } from './level';
import { decisive, reasonsOf, shareText, type Reason } from './reasons';
import type { Scale } from './scale';

/** A twin that a verdict is about, and how it is measured on another capture. */
export interface Judged {
  readonly twin: Pick<Twin, 'capture' | 'fit' | 'node_count'>;
  readonly evaluate: () => void;
}

/**
 * Why a twin is good, fair or poor: each number that its error is compared with, what it means, and what to do.
 * Without a verdict, warnings alone. `scale` is undefined while it is loaded, and null if it cannot be.
 */
export function whyView(quality: Quality, scale: Scale | null | undefined, judged: Judged): HTMLElement | null {
  const { assessment, warnings = [] } = quality;
  if (assessment === undefined) return warningList(warnings);
  const reasons = reasonsOf(quality, scale ?? null);
  return h(
    'section',
    { 'aria-label': 'Why this verdict' },
    h('h2', {}, 'Why this verdict'),
    // Which comparison decides is known once all are.
    scale !== undefined && adviceView(quality, reasons, judged),
    warningList(warnings),
    reasons.length > 0 && reasonTable(reasons),
  );
}

/** What makes a twin what it is, and what to do about it, with links that do it. */
export function adviceView({ assessment }: Quality, reasons: readonly Reason[], judged: Judged): HTMLElement | null {
  if (assessment === undefined) return null;
  const { level, next } = assessment;
  const advice = adviceOf(level, reasons);
  const due = decisive(reasons, level);
  const steps = advice?.steps ?? [];
  return h(
    'div',
    { class: 'advice' },
    // What the server says speaks of commands: it stands where the page does not know better.
    h('p', {}, due.length > 0 && `What makes it ${level}: ${listText(due)}. `, advice?.text ?? prose(next)),
    steps.length > 0 && h('div', { class: 'buttons' }, ...steps.map((step) => stepButton(step, judged))),
  );
}

/** A link or a button that takes a step. */
function stepButton(step: Step, { twin, evaluate }: Judged): Child {
  const { capture, fit, node_count } = twin;
  const again = (text: string, changes: Record<string, string>): HTMLElement => {
    const query = new URLSearchParams(changes);
    if (capture) query.set('capture', idOf(capture));
    if (fit) query.set('like', idOf(fit));
    return link(text, `#/fits/new?${query}`);
  };
  switch (step) {
    case 'starts':
      return again('Fit again with more starts', { starts: 'more' });
    case 'finer':
      return again('Fit again with more nodes and starts', { starts: 'more', nodes: String(2 * node_count) });
    case 'report':
      return capture ? link('What the recording lacks', `#/${capture}`) : null;
    case 'upload':
      return link('Add a recording', '#/upload');
    case 'evaluate':
      return h('button', { type: 'button', onclick: evaluate }, 'Measure it on a capture');
  }
}

function link(text: string, href: string): HTMLElement {
  return h('a', { class: 'button', href }, text);
}

/** Names within a sentence. */
function listText(reasons: readonly Reason[]): string {
  return new Intl.ListFormat('en-GB').format(reasons.map(({ name }) => name.charAt(0).toLowerCase() + name.slice(1)));
}

/** The comparisons of a twin's error; the worst of them decides. */
export function reasonTable(reasons: readonly Reason[]): HTMLElement {
  return table<Reason>({
    caption: 'Numbers behind the verdict: the worst comparison decides',
    rows: reasons,
    columns: [
      { header: 'Number', cell: ({ name }) => h('span', { class: 'reason' }, name) },
      { header: 'Value', isNumeric: true, cell: ({ value_m, measure }) => [millimetres(value_m), below(measure)] },
      {
        header: 'Error as a share of it',
        help: 'The error on later frames, in the first row, divided by the number of this row. Errors of all rows have the same measure.',
        isNumeric: true,
        cell: ({ share }) => (share === null ? '' : shareText(share)),
      },
      { header: 'Counts as', cell: ({ level }) => (level === null ? '' : levelBadge(level)) },
      { header: 'Meaning', cell: ({ meaning }) => h('span', { class: 'meaning' }, meaning) },
    ],
  });
}
