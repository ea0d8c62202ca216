import { expect, it } from 'vitest';
import { addressOf, idOf } from './routes.js';

it('fills in ids and queries with any content', () => {
  expect(addressOf('/v1/fits/{id}', 'a/b?c')).toBe('/v1/fits/a%2Fb%3Fc');
  expect(addressOf('/v1/fits', undefined, { page_size: 5, search: 'a&b', tag: '', state: undefined })).toBe(
    '/v1/fits?page_size=5&search=a%26b',
  );
  expect(idOf('fits/0199')).toBe('0199');
});
