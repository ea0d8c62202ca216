import { expect, test } from 'vitest';

import { picturesOf } from './report';

const PNG = 'data:image/png;base64,iVBORw0KGgo=';

test('pictures are taken out of the page of a report, texts as texts', () => {
  const page = `<h2>Pictures</h2><div class="plates">
<figure><img alt="Depth &amp; &quot;masks&quot;" src="${PNG}"><figcaption>&lt;b&gt;x&lt;/b&gt;, it&#39;s &amp;lt;</figcaption></figure>
<figure><img alt="" src="data:image/jpeg;base64,AA=="><figcaption>second</figcaption></figure></div>`;
  expect(picturesOf(page)).toEqual([
    { source: PNG, title: 'Depth & "masks"', caption: "<b>x</b>, it's &lt;" },
    { source: 'data:image/jpeg;base64,AA==', title: '', caption: 'second' },
  ]);
});

test('other images than embedded ones are ignored', () => {
  const sources = [
    'https://evil.example/a.png',
    'data:image/svg+xml;base64,AA==',
    'javascript:alert(1)',
    'data:text/html;base64,AA==',
  ];
  const pages = sources.map((src) => `<figure><img alt="" src="${src}"><figcaption></figcaption></figure>`);
  expect(pages.flatMap(picturesOf)).toEqual([]);
  expect(picturesOf('')).toEqual([]);
});
