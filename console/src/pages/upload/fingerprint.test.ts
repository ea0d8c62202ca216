import { expect, test } from 'vitest';

import { fingerprint, fingerprintOf } from './fingerprint';

test('fingerprints are the same again and differ with every fact', () => {
  const facts = { path: 'rope.zip', size: 10, lastModified: 5 };
  const own = fingerprintOf([facts]);
  expect(own).toMatch(/^[0-9a-f]{32}$/);
  expect(fingerprintOf([{ ...facts }])).toBe(own);
  const others = [
    [{ ...facts, path: 'ropf.zip' }],
    [{ ...facts, size: 11 }],
    [{ ...facts, lastModified: 6 }],
    [facts, facts],
    [],
  ];
  const all = [own, ...others.map(fingerprintOf)];
  expect(new Set(all).size).toBe(all.length);
});

test('a hundred thousand short texts have different fingerprints in every half', () => {
  const words = Array.from({ length: 100_000 }, (_, index) => fingerprint(String(index)));
  expect(new Set(words.map((word) => word.slice(0, 16))).size).toBe(words.length);
  expect(new Set(words.map((word) => word.slice(16))).size).toBe(words.length);
});
