import { describe, expect, it } from 'vitest';
import { barriers } from './kit/barriers';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Faults that no page may have, what makes them, and how they are told. */
const FAULTS: readonly (readonly [string, string, RegExp])[] = [
  ['an error of a script', 'setTimeout(() => { throw new Error("amiss"); })', /^error: amiss/],
  ['a message of an error', 'console.error("amiss")', /^console: amiss/],
  ['an inline style', 'document.body.setAttribute("style", "color: red")', /policy: style-src/],
  ['text that becomes markup', 'document.body.innerHTML = "<b>bold</b>"', /policy: require-trusted-types-for/],
  ['text that becomes a program', 'setTimeout("1")', /policy: (script-src|require-trusted-types-for)/],
  ['a script from elsewhere', add('script', 'src', 'http://127.0.0.1:9/a.js'), /policy: (script-src|require-)/],
  ['a picture from elsewhere', add('img', 'src', 'http://127.0.0.1:9/a.png'), /policy: img-src/],
  ['a request elsewhere', 'void fetch("http://127.0.0.1:9/").catch(() => undefined)', /policy: connect-src/],
  ['a frame', add('iframe', 'src', '/docs'), /policy: frame-src/],
  ['another base', add('base', 'href', '/elsewhere/'), /policy: base-uri/],
  ['a form that is sent', `${add('form', 'action', '/v1/fits')}; element.submit()`, /policy: form-action/],
];

/** A script that puts an element with one attribute into the page. */
function add(tag: string, name: string, value: string): string {
  const made = `const element = document.createElement('${tag}'); element.setAttribute('${name}', '${value}')`;
  return `${made}; document.body.append(element)`;
}

describe('a story', () => {
  withServer(['--client-token', 'none', '--workers', '0']);

  for (const [what, script, told] of FAULTS) {
    it(`finds ${what}`, async () => {
      const visit = await Visit.open(browser, server, { at: '/login' });
      await visit.heading('Log in');
      expect(visit.faults).toEqual([]);
      // Some of these throw where they stand.
      await visit.page.evaluate(`(() => { ${script}; })()`).catch(() => undefined);
      await expect.poll(() => visit.faults.join('\n')).toMatch(told);
      await expect(visit.close()).rejects.toThrow('errors of the page');
    });
  }

  it('finds barriers', async () => {
    const visit = await Visit.open(browser, server, { at: '/login' });
    await visit.heading('Log in');
    expect(await barriers(visit.page)).toEqual([]);
    await visit.page.evaluate(() => {
      document.querySelector('main')?.append(document.createElement('input'), document.createElement('button'));
    });
    expect((await barriers(visit.page)).map((barrier) => barrier.split(':')[0])).toEqual(['button-name', 'label']);
    await visit.close();
  });
});
