import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { defineConfig, type Plugin } from 'vite';

/** Sources that the page may load from: none, but the script and the style that are in it. */
const policy = (code: string, style: string): string =>
  [
    "default-src 'none'", `script-src '${digest(code)}'`, `style-src '${digest(style)}'`, "base-uri 'none'",
    "form-action 'none'", "require-trusted-types-for 'script'", "trusted-types 'none'",
  ].join('; ');

function digest(text: string): string {
  return `sha256-${createHash('sha256').update(text).digest('base64')}`;
}

/** Puts script and style into one file, in which `{{name}}` and `{{twin}}` remain to be filled in. */
const onePage: Plugin = {
  name: 'one-page',
  enforce: 'post',
  generateBundle(_, bundle) {
    let [code, style] = ['', ''];
    for (const [file, part] of Object.entries(bundle)) {
      if (part.type === 'chunk') code += part.code;
      else if (file.endsWith('.css')) style += String(part.source);
      else throw new Error(`${file} is no script and no style`);
      delete bundle[file];
    }
    if (/<\/(script|style)|<!--/i.test(code + style)) throw new Error('the page would end within its script or style');
    const parts: Record<string, string> = { policy: policy(code, style), style, code };
    const template = readFileSync(new URL('src/embed/page.html', import.meta.url), 'utf8');
    const source = template.replace(/\{\{(policy|style|code)\}\}/g, (_whole, name: string) => parts[name]!);
    this.emitFile({ type: 'asset', fileName: 'embed.html', source });
  },
};

/** The page of one twin, which `bendtwin twin export` writes: a separate file beside those of the console. */
export default defineConfig({
  plugins: [onePage],
  resolve: { tsconfigPaths: true },
  publicDir: false,
  build: {
    target: 'es2023',
    emptyOutDir: false,
    // One file of styles, in place of code that adds them, which the policy would refuse.
    cssCodeSplit: false,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1000,
    rolldownOptions: {
      input: 'src/embed/main.ts',
      checks: { pluginTimings: false },
      output: { format: 'iife', codeSplitting: false },
    },
  },
});
