import type { Api } from '../../api/client';
import type { PageContext } from '../../page';
import { counted } from '../../ui/format';
import { totalOf } from '../../ui/list';

/** Entries that are counted where the server does not say how many there are. */
const MOST = 100;

/** Numbers of twins and fits of captures; `isLeast` if there are more. */
interface Dependents {
  readonly twins: number;
  readonly fits: number;
  readonly isLeast: boolean;
}

/** What depends on captures, in a sentence; empty if nothing does. */
export async function dependentsText({ api, signal }: PageContext, captures: readonly string[]): Promise<string> {
  const all = await Promise.all(captures.map((capture) => dependentsOf(api, capture, signal)));
  const sum = all.reduce<Dependents>(
    (a, b) => ({ twins: a.twins + b.twins, fits: a.fits + b.fits, isLeast: a.isLeast || b.isLeast }),
    { twins: 0, fits: 0, isLeast: false },
  );
  return textOf(sum, captures.length > 1);
}

/** The sentence about what depends on one capture or several. */
export function textOf({ twins, fits, isLeast }: Dependents, areSeveral: boolean): string {
  if (twins + fits === 0) return '';
  const parts = [twins > 0 ? counted(twins, 'twin') : '', fits > 0 ? counted(fits, 'fit') : ''].filter((part) => part !== '');
  const least = isLeast ? 'At least ' : '';
  const depend = twins + fits === 1 ? 'depends' : 'depend';
  const kept = 'Twins and fits are kept, but can no longer be shown beside the recording or be refined.';
  return `${least}${parts.join(' and ')} ${depend} on ${areSeveral ? 'them' : 'it'}. ${kept}`;
}

async function dependentsOf(api: Api, capture: string, signal: AbortSignal): Promise<Dependents> {
  const query = { capture, page_size: MOST };
  const [twins, fits] = await Promise.all([
    api.get('/v1/twins', { query, signal }),
    api.get('/v1/fits', { query, signal }),
  ]);
  const isCut = (page: { next_page_token: string }): boolean => totalOf(page) === undefined && page.next_page_token !== '';
  return {
    twins: totalOf(twins) ?? twins.twins.length,
    fits: totalOf(fits) ?? fits.fits.length,
    isLeast: isCut(twins) || isCut(fits),
  };
}

/** The question before captures are deleted. */
export async function deleteQuestion(context: PageContext, captures: readonly string[]): Promise<{ title: string; text: string }> {
  const depend = await dependentsText(context, captures);
  const areSeveral = captures.length > 1;
  const subject = areSeveral ? 'They go' : 'It goes';
  const trash = `${subject} to the trash, if this server has one, with ${areSeveral ? 'their' : 'its'} points and report.`;
  return {
    title: areSeveral ? `Delete ${captures.length} captures?` : 'Delete this capture?',
    text: [depend, trash].filter((part) => part !== '').join(' '),
  };
}
