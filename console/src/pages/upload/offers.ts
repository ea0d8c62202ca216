import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { counted, name, size } from '../../ui/format';
import { guideLink } from '../../ui/guide';
import { isolated } from '../parts/text';
import type { Intake, Offer, Refusal } from './intake';
import type { Package } from './select';
import type { Survey } from './survey/survey';
import { accept } from './take';
import { sizeOf } from './transfers';

/** What waits for a decision: files that were looked into, and what was refused. It follows the intake until the page is left. */
export function offerList(intake: Intake, { api, signal }: PageContext): HTMLElement {
  const element = h('div');
  const offers = h('ul', { class: 'transfers', 'aria-label': 'Ready to upload' });
  const all = h('button', { type: 'button', class: 'primary', onclick: () => intake.offers.forEach((offer) => accept(api, offer)) });
  const refusals = h('div', { role: 'alert' });
  const rows = new Map<number, HTMLElement>();
  const update = (): void => {
    for (const offer of intake.offers) keep(rows, offer.id, () => offerRow(offer, intake, api), offers);
    for (const refusal of intake.refusals) keep(rows, refusal.id, () => refusalRow(refusal, intake), refusals);
    const here = new Set([...intake.offers, ...intake.refusals].map(({ id }) => id));
    for (const [id, row] of rows) {
      if (here.has(id)) continue;
      row.remove();
      rows.delete(id);
    }
    const { length } = intake.offers;
    offers.hidden = length === 0;
    all.hidden = length < 2;
    all.textContent = `Upload all ${length}`;
  };
  intake.addEventListener('change', update, { signal });
  update();
  element.append(refusals, offers, all);
  return element;
}

/** Rows stay while others come and go, so that the focus does. */
function keep(rows: Map<number, HTMLElement>, id: number, make: () => HTMLElement, place: HTMLElement): void {
  if (rows.has(id)) return;
  const row = make();
  rows.set(id, row);
  place.append(row);
}

function offerRow(offer: Offer, intake: Intake, api: PageContext['api']): HTMLElement {
  const { source, survey, id } = offer;
  return h(
    'li',
    { class: 'card' },
    h(
      'div',
      { class: 'transfer-head' },
      h('strong', {}, name(source.name)),
      h('button', { type: 'button', class: 'primary small', onclick: () => accept(api, offer), 'aria-label': `Upload ${source.name}` }, 'Upload'),
      h('button', { type: 'button', class: 'small', onclick: () => intake.dismiss(id), 'aria-label': `Leave out ${source.name}` }, 'Leave out'),
    ),
    h('p', { class: 'muted' }, sourceText(source, sizeOf(source))),
    surveyView(survey),
  );
}

function refusalRow({ id, text }: Refusal, intake: Intake): HTMLElement {
  const dismiss = h('button', { type: 'button', class: 'small', onclick: () => intake.dismiss(id), 'aria-label': `Dismiss: ${text}` }, 'Dismiss');
  return h('div', { class: 'problem refusal' }, h('p', {}, h('bdi', {}, text)), dismiss);
}

/** What was found in files: their form, their parts, and what is missing. */
export function surveyView({ format, facts, parts, notes }: Survey): HTMLElement {
  return h(
    'div',
    { class: 'survey' },
    h(
      'p',
      {},
      h('span', {}, [format, ...facts].join(', ')),
      ...parts.map(([part, isThere]) =>
        h('span', { class: isThere ? 'badge badge-good' : 'badge badge-warn' }, isThere ? part : `no ${part}`),
      ),
    ),
    ...notes.map(({ text, section }) => h('p', {}, h('bdi', {}, text), section !== undefined && [' See ', guideLink(section), '.'])),
  );
}

/** Where an upload comes from, and what of it stays here. */
export function sourceText(source: Package, sizeBytes: number): string {
  if (source.kind === 'file') return `${isolated(source.file.name)}, ${size(sizeBytes)}`;
  const note = source.note === null ? '' : `. ${source.note}`;
  const left = source.left > 0 ? `, ${counted(source.left, 'other file')} not needed and left out` : '';
  return `Folder of ${counted(source.files.length, 'file')}, ${size(sizeBytes)}${left}${note}`;
}
