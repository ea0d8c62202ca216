import { badge } from '../../../ui/badge';
import { h } from '../../../ui/dom';
import { counted } from '../../../ui/format';
import { prose } from '../../parts/text';
import type { Report } from './report';

/** The verdict of a report in one sentence. */
export function verdictText({ verdict, kind, findings }: Report): string {
  const what = kind === 'recording' ? 'recording' : 'capture';
  const warnings = findings.filter(({ severity }) => severity === 'warning').length;
  const error = findings.find(({ severity }) => severity === 'error');
  if (verdict === 'unusable') return `This ${what} cannot be fitted${error === undefined ? '.' : `: ${ended(error.message)}`}`;
  if (verdict === 'good') return `This ${what} is good: nothing limits a fit.`;
  const say = warnings === 1 ? 'says' : 'say';
  return `This ${what} can be fitted; ${counted(warnings, 'warning')} ${say} what makes the twin worse.`;
}

/** The verdict, and what to do first if something is wrong. */
export function verdictView(report: Report): HTMLElement {
  const { verdict, first_step, findings } = report;
  const error = findings.find(({ severity }) => severity === 'error');
  // The verdict has said already what is wrong.
  const first = verdict === 'unusable' && error !== undefined ? error.advice : findings.length > 0 ? first_step : null;
  return h(
    'div',
    { class: 'capture-verdict' },
    h('p', {}, badge(verdict), ' ', h('strong', {}, prose(verdictText(report)))),
    first !== null && h('p', {}, 'First: ', prose(ended(first))),
  );
}

/** A message as the end of a sentence. */
function ended(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}
