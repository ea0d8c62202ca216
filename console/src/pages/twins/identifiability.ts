import { h } from '../../ui/dom';
import { millimetres, percent } from '../../ui/format';
import { table } from '../../ui/table';
import { prose } from '../parts/text';
import type { Identifiability, OpenGroup, Quality } from './quality';

const QUANTITIES: Record<string, string> = {
  stiffness: 'Stiffness',
  rest_length: 'Rest length',
  bend_stiffness: 'Bending stiffness',
  grip: 'Grip',
  twist_stiffness: 'Twist stiffness',
  dashpot: 'Damping of springs',
  bend_damping: 'Damping of bending',
  drag: 'Drag',
  ground_friction: 'Friction on the ground',
  ground_restitution: 'Restitution on the ground',
};

const CERTAINTIES: Record<string, string> = {
  determined: 'determined',
  partly: 'determined in part',
  undetermined: 'left open',
};

/** A group of parameters in words: what it is, and where. */
export function groupText({ regions }: Pick<Identifiability, 'regions'>, { quantity, region, hand }: OpenGroup): string {
  const what = QUANTITIES[quantity] ?? quantity;
  const place = region === undefined ? undefined : regions[region]?.name;
  if (place !== undefined) return `${what}, ${place}`;
  return hand === undefined ? what : `${what} of hand ${hand + 1}`;
}

/** Groups with their largest part in a motion, those that matter most first. */
export function groupsByShare({ groups, motions }: Identifiability): { group: OpenGroup; share: number }[] {
  const share = (index: number): number => Math.max(0, ...motions.map(({ shares }) => shares[index] ?? 0));
  return groups.map((group, index) => ({ group, share: share(index) })).sort((a, b) => b.share - a.share);
}

/** What the recordings leave open, and what to record next; `view` shows the object coloured by it. */
export function identifiabilityView({ identifiability: report }: Quality, view: string): HTMLElement | null {
  if (report === undefined) return null;
  return h(
    'section',
    { 'aria-label': 'What the recordings leave open' },
    h('h2', {}, 'What the recordings leave open'),
    ...report.summary.map((sentence) => h('p', {}, prose(sentence))),
    h('p', {}, h('a', { href: view }, 'See it as colours on the object')),
    h(
      'details',
      { class: 'card' },
      h('summary', {}, 'Groups of parameters, and recordings that would help'),
      groupTable(report),
      nextTable(report),
    ),
  );
}

function groupTable(report: Identifiability): HTMLElement {
  return table({
    caption: 'Groups of parameters, the most important first',
    rows: groupsByShare(report),
    columns: [
      { header: 'Group', cell: ({ group }) => groupText(report, group) },
      { header: 'Remaining range', isNumeric: true, cell: ({ group }) => percent(group.relative_sd) },
      { header: 'So it is', cell: ({ group }) => CERTAINTIES[group.certainty] ?? group.certainty },
      { header: 'Share of the uncertainty', isNumeric: true, cell: ({ share }) => percent(share) },
    ],
  });
}

function nextTable({ next }: Identifiability): HTMLElement {
  return table({
    caption: 'Suggested next recordings',
    rows: next,
    columns: [
      { header: 'What to do', cell: ({ action }) => prose(action) },
      { header: 'Would leave', isNumeric: true, cell: ({ sd_m }) => millimetres(sd_m) },
    ],
  });
}
