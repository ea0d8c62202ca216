import { expect, test } from 'vitest';

import { documentedSettings } from '../../../scripts/settings.mjs';
import { KNOWN_SETTINGS } from './known';

test('the settings are those of the documentation', () => {
  const documented = documentedSettings();
  expect(documented.length).toBeGreaterThan(30);
  expect(KNOWN_SETTINGS, 'run `npm run settings` in console, then console/rebuild').toEqual(documented);
  expect(documented).toContainEqual(['within_s', 'null', '1 to 1e6', 'Time that the fit may take [s].']);
});
