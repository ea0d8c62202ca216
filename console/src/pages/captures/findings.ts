import { badge } from '../../ui/badge';
import { h, type Child } from '../../ui/dom';
import { counted } from '../../ui/format';
import { prose } from '../parts/text';
import type { Finding, Report } from './report';

const TONES = { error: 'bad', warning: 'warn', info: 'neutral' } as const;

const VERDICTS: Record<string, string> = {
  good: 'This recording is good: nothing limits a fit.',
  usable: 'This recording can be fitted; warnings name what makes the twin worse.',
  unusable: 'This recording cannot be fitted.',
};

/** What can be done about a finding here, such as a button. */
export type Remedy = (finding: Finding) => Child;

/** The verdict in words, and the findings in the order of repair. */
export function findingsView(report: Report, remedy: Remedy): HTMLElement {
  const { verdict, first_step, findings } = report;
  return h(
    'section',
    { 'aria-label': 'Findings' },
    h('h2', {}, 'Report'),
    h('p', {}, badge(verdict), ' ', VERDICTS[verdict] ?? ''),
    first_step !== null && findings.length > 0 && h('p', {}, h('strong', {}, 'First: '), prose(first_step)),
    findingList(report, remedy),
  );
}

/** The findings in the order of repair; null without any. */
export function findingList({ findings, cameras }: Report, remedy: Remedy): HTMLElement | null {
  if (findings.length === 0) return null;
  const names = cameras.map(({ name }) => name);
  return h('ol', { class: 'findings' }, ...findings.map((finding) => findingRow(finding, names, remedy(finding))));
}

function findingRow(finding: Finding, cameras: readonly string[], remedy: Child): HTMLElement {
  const where: Child[] = [];
  if (finding.cameras && finding.cameras.length > 0) {
    where.push(
      h('li', {}, `Cameras: ${finding.cameras.map((c) => (cameras[c] ? `${c} (${cameras[c]})` : c)).join(', ')}`),
    );
  }
  if (finding.frames && finding.frames.length > 0) {
    where.push(h('li', {}, `Frames: ${finding.frames.join(', ')}${finding.frames.length >= 20 ? ' and more' : ''}`));
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
      h('strong', {}, prose(finding.message)),
    ),
    h('p', {}, prose(finding.advice)),
    remedy,
    where.length > 0 && h('ul', { class: 'muted' }, ...where),
    h('p', { class: 'muted' }, h('code', {}, finding.code)),
  );
}
