import { describe, expect, test } from 'vitest';

import { faultsByName, flat, readSettings } from './settings';
import { readTags } from './tags';

describe('settings as lines', () => {
  test('become one object', () => {
    const text =
      'seed=7\n\n graph.max_nodes = 400 \nrefine.window = {"frames": 3}\neffort = best\ncontrol_velocity = "true"';
    const { value, isEmpty, faults } = readSettings(text);
    expect(faults).toEqual([]);
    expect(isEmpty).toBe(false);
    expect(value).toEqual({
      seed: 7,
      graph: { max_nodes: 400 },
      refine: { window: { frames: 3 } },
      effort: 'best',
      control_velocity: 'true',
    });
    expect(readSettings(' \n').isEmpty).toBe(true);
  });

  test('that are wrong are named by their lines', () => {
    const { faults } = readSettings('seed\nseed=\na.b=1\na=2\nx=1\nx=2\n=3\na.b.c=1');
    expect(faults.map(({ line }) => line)).toEqual([0, 1, 3, 5, 6, 7]);
  });

  test('do not reach the prototypes of objects', () => {
    const { value } = readSettings('__proto__.polluted = 1\nconstructor.prototype.polluted = 1');
    expect(({} as { polluted?: number }).polluted).toBeUndefined();
    expect(JSON.parse(JSON.stringify(value))).toEqual(
      JSON.parse('{"__proto__": {"polluted": 1}, "constructor": {"prototype": {"polluted": 1}}}'),
    );
  });

  test('lie flat by their names', () => {
    expect(flat({ a: 1, b: { c: null, d: { e: [1] } }, f: {} })).toEqual([
      ['a', 1],
      ['b.c', null],
      ['b.d.e', [1]],
      ['f', {}],
    ]);
    expect(flat({})).toEqual([]);
  });
});

test('messages of the server are assigned to their settings', () => {
  const detail =
    'the settings are not accepted: effort: unknown variant `fast`, expected one of `draft`; ' +
    'substeps.auto.safety is 0: it must lie in 1..=100; sed: unknown field `sed`, expected one of `seed`';
  expect([...faultsByName(detail)]).toEqual([
    ['effort', 'unknown variant `fast`, expected one of `draft`'],
    ['substeps.auto.safety', 'substeps.auto.safety is 0: it must lie in 1..=100'],
    ['sed', 'unknown field `sed`, expected one of `seed`'],
  ]);
  expect([...faultsByName('`captures/0` is not a name')]).toEqual([['', '`captures/0` is not a name']]);
});

test('tags are words of letters, digits and a few marks', () => {
  expect(readTags(' wet,blue  wet\tgröße ')).toEqual({ tags: ['blue', 'größe', 'wet'], faults: [] });
  const { tags, faults } = readTags('good <b> -x ' + 'x'.repeat(51));
  expect(tags).toEqual(['good']);
  expect(faults).toHaveLength(3);
  expect(readTags(Array.from({ length: 33 }, (_, i) => `t${i}`).join(' ')).faults).toHaveLength(1);
});
