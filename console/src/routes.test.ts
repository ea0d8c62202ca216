import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { ROUTES, match } from './routes';

const found = (path: string): [string, Record<string, string>] | null => {
  const matched = match(ROUTES, path);
  return matched === null ? null : [matched.route.path, matched.parameters];
};

describe('match', () => {
  it('finds pages and the parts that vary', () => {
    expect(found('/')).toEqual(['/', {}]);
    expect(found('')).toEqual(['/', {}]);
    expect(found('/twins/a%20b/play')).toEqual(['/twins/:id/play', { id: 'a%20b' }]);
    expect(found('/fits/new')).toEqual(['/fits/new', {}]);
    expect(found('/fits/0199/')).toEqual(['/fits/:id', { id: '0199' }]);
  });

  it('finds nothing at other addresses', () => {
    for (const path of ['/nothing', '/twins/1/2/3', '/constructor', '/Fits', 'fits1']) expect(found(path)).toBe(null);
  });
});

it('every page is documented', () => {
  const text = readFileSync(new URL('../../docs/use/console.md', import.meta.url), 'utf8');
  for (const { path } of ROUTES) {
    const address = `\`#${path.replace(':id', '{id}')}`;
    expect(text.includes(`${address}\``) || text.includes(`${address}?`), path).toBe(true);
  }
});
