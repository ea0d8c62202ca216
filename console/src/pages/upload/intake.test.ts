import { expect, test } from 'vitest';

import { Intake } from './intake';
import { closed } from './survey/survey';

const SOURCE = { kind: 'file', name: 'a', file: new File([], 'a.zip') } as const;

test('offers and refusals stay until they are dismissed, each once', () => {
  const intake = new Intake();
  let changes = 0;
  intake.addEventListener('change', () => (changes += 1));
  const offer = { source: SOURCE, survey: closed('ZIP archive', ''), isOnly: true };
  intake.offer({ ...offer, files: '1' });
  intake.offer({ ...offer, files: '2' });
  intake.offer({ ...offer, files: '1' });
  intake.refuse('a is a video');
  intake.refuse('b is a video');
  intake.refuse('a is a video');
  expect(intake.offers.map(({ files }) => files)).toEqual(['2', '1']);
  expect(intake.refusals.map(({ text }) => text)).toEqual(['b is a video', 'a is a video']);
  for (const { id } of [...intake.offers, ...intake.refusals].slice(1, 3)) intake.dismiss(id);
  expect([intake.offers.length, intake.refusals.length]).toEqual([1, 1]);
  expect(changes).toBe(8);
});
