import { badge } from '../../../ui/badge';
import { h, type Child } from '../../../ui/dom';
import { counted } from '../../../ui/format';
import { prose, sentence } from '../../parts/text';
import type { Finding, Report } from './report';

/** Frames that a report names of a finding, the first ones. */
const MOST_FRAMES = 20;

const TONES = { error: 'bad', warning: 'warn', info: 'neutral' } as const;

/** What can be done about a finding here, such as a button. */
export type Remedy = (finding: Finding) => Child;

/** The findings under a heading; null without any. `playback`: the address of the playback, to which frames lead, or null. */
export function findingsView(report: Report, remedy: Remedy, playback: string | null): HTMLElement | null {
  const rows = findingList(report, remedy, playback);
  return rows === null ? null : h('section', { 'aria-label': 'Findings' }, h('h2', {}, 'Findings'), rows);
}

/** The findings in the order of repair; null without any. */
export function findingList({ findings, cameras }: Report, remedy: Remedy, playback: string | null = null): HTMLElement | null {
  if (findings.length === 0) return null;
  const names = cameras.map(({ name }) => name);
  return h('ol', { class: 'findings' }, ...findings.map((finding) => findingRow(finding, names, remedy(finding), playback)));
}

function findingRow(finding: Finding, cameras: readonly string[], remedy: Child, playback: string | null): HTMLElement {
  const where: Child[] = [];
  if (finding.cameras && finding.cameras.length > 0) {
    where.push(
      h('li', {}, `Cameras: ${finding.cameras.map((c) => (cameras[c] ? `${c} (${cameras[c]})` : c)).join(', ')}`),
    );
  }
  if (finding.frames && finding.frames.length > 0) {
    where.push(h('li', {}, 'Frames: ', framesText(finding.frames, playback)));
  }
  if (finding.consequences && finding.consequences.length > 0) {
    where.push(
      h(
        'li',
        {},
        `${counted(finding.consequences.length, 'finding')} that follow from it: ${finding.consequences.join(', ')}`,
      ),
    );
  }
  return h(
    'li',
    { class: `card finding-${finding.severity}` },
    h(
      'p',
      {},
      badge(finding.severity, TONES[finding.severity] ?? 'neutral'),
      ' ',
      h('strong', {}, prose(sentence(finding.message))),
    ),
    h('p', {}, prose(sentence(finding.advice))),
    remedy,
    where.length > 0 && h('ul', { class: 'muted' }, ...where),
    h('p', { class: 'muted' }, h('code', {}, finding.code)),
  );
}

/** Numbers of frames; each leads to the playback there, if there is one. */
function framesText(frames: readonly number[], playback: string | null): Child[] {
  const words = frames.map((frame) => (playback === null ? String(frame) : h('a', { href: `${playback}?frame=${frame}` }, frame)));
  const more = frames.length >= MOST_FRAMES ? ' and more' : '';
  return [...words.flatMap((word, index) => (index === 0 ? [word] : [', ', word])), more];
}
