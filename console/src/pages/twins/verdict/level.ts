import { badge } from '../../../ui/badge';
import { h, type Child } from '../../../ui/dom';
import { millimetres } from '../../../ui/format';
import { prose } from '../../parts/text';
import { headlineOf, type Headline, type Quality } from '../quality';

const TONES: Record<string, Parameters<typeof badge>[1]> = {
  good: 'good',
  fair: 'warn',
  poor: 'bad',
  unknown: 'neutral',
};

/** Levels of trust, the best first. */
export const LEVELS = ['good', 'fair', 'poor', 'unknown'] as const;

/** A level of trust as a badge; a dash where a twin has none. */
export function levelBadge(level: string | null | undefined): HTMLElement | string {
  return level ? badge(level, TONES[level] ?? 'neutral') : '–';
}

/** The verdict in a sentence: its level, and the twin's error with its measure. Null without an assessment. */
export function verdictLine(quality: Quality): HTMLElement | null {
  const { assessment } = quality;
  if (assessment === undefined) return null;
  return h('p', { class: 'verdict' }, levelBadge(assessment.level), ' ', h('span', {}, verdictText(quality)));
}

function verdictText(quality: Quality): Child {
  const off = ({ error_m, word }: Headline): Child => [h('strong', {}, millimetres(error_m)), ` (${word})`];
  const headline = headlineOf(quality);
  if (headline !== null) return ['Off by ', off(headline), ' on frames that it never saw.'];
  const train = headlineOf(quality, 'train');
  if (train === null) return 'It was not measured yet.';
  return ['Off by ', off(train), ' on the frames that it was fitted to, which says little of others: none was left over.'];
}

/** Warnings about a fit or its data. */
export function warningList(warnings: readonly string[]): HTMLElement | null {
  return warnings.length === 0 ? null : h('ul', {}, ...warnings.map((warning) => h('li', {}, prose(warning))));
}
