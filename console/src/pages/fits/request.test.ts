import { expect, test } from 'vitest';

import { formOf, settingsOf, type FitForm, withMoreStarts, withNodes } from './request';

const PLAIN: FitForm = {
  effort: 'standard',
  within_s: '',
  seed: '',
  starts: '',
  bending: true,
  compareAxial: false,
  others: [],
};

test('a form that was not changed asks for no settings', () => {
  expect(settingsOf(PLAIN)).toEqual({ settings: {}, faults: new Map() });
  expect(formOf({})).toEqual(PLAIN);
});

test('filled-in fields become settings by their names', () => {
  const others = [
    ['graph.max_nodes', '400'],
    ['refine.window', '{"frames": 3}'],
    ['loss.sequences', 'geometric'],
    ['', ''],
  ] as const;
  const form = {
    ...PLAIN,
    effort: 'draft',
    within_s: '60',
    seed: '7',
    starts: '3',
    bending: false,
    compareAxial: true,
    others,
  };
  const { settings, faults } = settingsOf(form);
  expect(faults.size).toBe(0);
  expect(settings).toEqual({
    effort: 'draft',
    within_s: 60,
    seed: 7,
    search: { starts: 3 },
    bending: false,
    compare_axial: true,
    graph: { max_nodes: 400 },
    refine: { window: { frames: 3 } },
    loss: { sequences: 'geometric' },
  });
  const again = [
    ['graph.max_nodes', '400'],
    ['refine.window.frames', '3'],
    ['loss.sequences', '"geometric"'],
  ];
  expect(formOf(settings)).toEqual({ ...form, others: again });
  expect(settingsOf(formOf(settings)).settings).toEqual(settings);
});

test('invalid values are reported by their names', () => {
  const others = [
    ['a', ''],
    ['', '3'],
    ['graph.max_nodes', '1'],
    ['graph.max_nodes', '2'],
    ['seed', '3'],
  ] as const;
  const { faults } = settingsOf({ ...PLAIN, within_s: 'soon', seed: '18446744073709551615', starts: '1', others });
  expect([...faults.keys()].sort()).toEqual(['', 'a', 'graph.max_nodes', 'seed', 'within_s']);
});

test('more starts are twice as many, three at least, and a bound on nodes takes the place of another', () => {
  const starts = (settings: object): string => withMoreStarts(formOf(settings)).starts;
  expect([{ effort: 'draft' }, {}, { effort: 'best' }, { search: { starts: 7 } }, { search: { starts: 50 } }].map(starts)).toEqual(
    ['3', '4', '8', '14', '64'],
  );
  const form = withNodes(formOf({ graph: { max_nodes: 100 }, refine: { passes: 9 } }), 800);
  expect(form.others).toEqual([['refine.passes', '9'], ['graph.max_nodes', '800']]);
});
