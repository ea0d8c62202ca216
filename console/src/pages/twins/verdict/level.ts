import { badge } from '../../../ui/badge';
import { h } from '../../../ui/dom';
import { millimetres } from '../../../ui/format';
import { prose } from '../../parts/text';
import { headlineOf, type Quality } from '../quality';
import { firstSentence } from './reasons';

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
  const headline = headlineOf(quality);
  const text =
    headline === null
      ? prose(firstSentence(assessment.why))
      : [
          'Off by ',
          h('strong', {}, millimetres(headline.error_m)),
          ` (${headline.word}) on frames that it never saw.`,
        ];
  return h('p', { class: 'verdict' }, levelBadge(assessment.level), ' ', h('span', {}, text));
}

/** Warnings about a fit or its data. */
export function warningList(warnings: readonly string[]): HTMLElement | null {
  return warnings.length === 0 ? null : h('ul', {}, ...warnings.map((warning) => h('li', {}, prose(warning))));
}
