import { randomBytes } from 'node:crypto';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import Provider from 'oidc-provider';
import type { Page } from 'playwright-core';

/** An identity provider: a certified implementation of OpenID Connect, at which everybody has an account. */
export interface Identity {
  readonly issuer: string;
  /** Options of a server that trusts it. */
  readonly config: string;
  /** Port at which browsers of that server come back. */
  readonly port: number;
  close(): void;
}

/** Starts a provider, and reserves a port for a server at which people sign in with it. */
export async function startIdentity(): Promise<Identity> {
  const reserved = createServer();
  const port = await listen(reserved);
  await new Promise((resolve) => reserved.close(resolve));
  const http = createServer();
  const issuer = `http://127.0.0.1:${await listen(http)}`;
  const publicUrl = `http://127.0.0.1:${port}`;
  const provider = new Provider(issuer, {
    clients: [
      {
        client_id: 'bendtwin',
        token_endpoint_auth_method: 'none',
        application_type: 'native',
        redirect_uris: [`${publicUrl}/sign-in`],
        grant_types: ['authorization_code', 'urn:ietf:params:oauth:grant-type:device_code'],
        response_types: ['code'],
      },
    ],
    pkce: { required: () => true },
    features: { deviceFlow: { enabled: true }, devInteractions: { enabled: true } },
    claims: { openid: ['sub', 'groups'], email: ['email', 'email_verified'], profile: ['name'] },
    cookies: { keys: [randomBytes(16).toString('hex')] },
    findAccount: (_: unknown, id: string) => ({
      accountId: id,
      claims: () => ({ sub: id, email: `${id}@example.org`, email_verified: id !== 'mallory', groups: ['lab'] }),
    }),
  });
  http.on('request', provider.callback());
  const folder = mkdtempSync(join(tmpdir(), 'bendtwin-identity-'));
  const config = join(folder, 'config.toml');
  writeFileSync(
    config,
    `[sign_in]
issuer = "${issuer}"
client_id = "bendtwin"
public_url = "${publicUrl}"
display_name = "the lab"
groups_claim = "groups"
groups = { lab = ["captures:read", "fits:read", "twins:read"] }
`,
  );
  const close = (): void => {
    http.closeAllConnections();
    http.close();
    rmSync(folder, { recursive: true });
  };
  return { issuer, config, port, close };
}

/** Fills in the provider's pages: who one is, and that one agrees. */
export async function confirm(page: Page, account: string): Promise<void> {
  await page.locator('input[name=login]').fill(account);
  await page.locator('input[name=password]').fill('any');
  await page.getByRole('button', { name: 'Sign-in' }).click();
  await page.getByRole('button', { name: 'Continue' }).click();
}

function listen(server: ReturnType<typeof createServer>): Promise<number> {
  return new Promise((resolve) => {
    server.listen(0, '127.0.0.1', () => resolve((server.address() as AddressInfo).port));
  });
}
