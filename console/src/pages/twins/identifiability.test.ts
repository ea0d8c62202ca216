import { expect, test } from 'vitest';
import { groupText, groupsByShare } from './identifiability';
import type { Identifiability, OpenGroup } from './quality';

function group(quantity: string, rest: Partial<OpenGroup> = {}): OpenGroup {
  return { quantity, relative_sd: 0.5, certainty: 'partly', ...rest };
}

const report: Identifiability = {
  summary: [],
  regions: [{ name: 'near the hand' }, { name: 'free end' }],
  groups: [group('drag'), group('stiffness', { region: 1 }), group('grip', { hand: 0 })],
  motions: [
    { motion: 'future', sd_m: 0.002, shares: [0.1, 0.5, 0.3] },
    { motion: 'shake', sd_m: 0.004, shares: [0.2, 0.1, 0.4] },
  ],
  next: [],
};

test('groups are named by kind and place', () => {
  expect(report.groups.map((of) => groupText(report, of))).toEqual(['Drag', 'Stiffness, free end', 'Grip of hand 1']);
  expect(groupText(report, group('of_a_newer_server', { region: 7 }))).toBe('of_a_newer_server');
});

test('those that matter most come first', () => {
  expect(groupsByShare(report).map(({ group: of, share }) => [of.quantity, share])).toEqual([
    ['stiffness', 0.5],
    ['grip', 0.4],
    ['drag', 0.2],
  ]);
});
