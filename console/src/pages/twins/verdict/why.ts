import { h } from '../../../ui/dom';
import { millimetres } from '../../../ui/format';
import { table } from '../../../ui/table';
import { prose } from '../../parts/text';
import { levelBadge, warningList } from './level';
import type { Quality } from '../quality';
import type { Scale } from './scale';
import { decisive, reasonsOf, type Reason } from './reasons';

/** Why a twin is good, fair or poor: each number that its error is compared with, what it means, and what to do. Without a verdict, warnings alone. */
export function whyView(quality: Quality, scale: Scale | null): HTMLElement | null {
  const { assessment, warnings = [] } = quality;
  if (assessment === undefined) return warningList(warnings);
  const reasons = reasonsOf(quality, scale);
  const due = decisive(reasons, assessment.level);
  return h(
    'section',
    { 'aria-label': 'Why this verdict' },
    h('h2', {}, 'Why this verdict'),
    h('p', {}, due.length > 0 && `What makes it ${assessment.level}: ${listText(due)}. `, prose(assessment.next)),
    warningList(warnings),
    reasons.length > 0 && reasonTable(reasons),
  );
}

/** Names within a sentence. */
function listText(names: readonly string[]): string {
  return new Intl.ListFormat('en-GB').format(names.map((name) => name.charAt(0).toLowerCase() + name.slice(1)));
}

/** The comparisons of a twin's error; the worst of them decides. */
export function reasonTable(reasons: readonly Reason[]): HTMLElement {
  return table<Reason>({
    caption: 'Numbers behind the verdict: the worst comparison decides',
    rows: reasons,
    columns: [
      { header: 'Number', cell: ({ name }) => h('span', { class: 'reason' }, name) },
      { header: 'Value', isNumeric: true, cell: ({ value_m }) => millimetres(value_m) },
      { header: 'The error is', isNumeric: true, cell: ({ relation }) => relation },
      { header: 'Counts as', cell: ({ level }) => (level === null ? '' : levelBadge(level)) },
      { header: 'Meaning', cell: ({ meaning }) => h('span', { class: 'meaning' }, meaning) },
    ],
  });
}
