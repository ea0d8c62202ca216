import { expect, it } from 'vitest';
import { fileName } from './download';

it('makes names of files from any text', () => {
  expect(fileName('blue rope (wet)', 'png')).toBe('blue-rope-wet.png');
  expect(fileName('../../etc/passwd', 'json')).toBe('etc-passwd.json');
  expect(fileName('<img onerror=x>'.repeat(20), 'csv').length).toBeLessThan(70);
  expect(fileName('‮///', 'webm')).toBe('twin.webm');
});
